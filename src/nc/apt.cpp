#include <fmt/format.h>

#include "detail/apt_reader.hpp"

namespace trunnion::nc {

using program::EventKind;

namespace {

struct Rule {
    std::string_view major;
    bool (AptReader::*read)();
};

constexpr Rule rules[] = {
    {"GOTO", &AptReader::go_to},
    {"RAPID", &AptReader::rapid},
    {"FEDRAT", &AptReader::feed_rate},
    {"FROM", &AptReader::from},
    {"UNITS", &AptReader::units},
    {"MULTAX", &AptReader::multax},
    {"TLAXIS", &AptReader::tool_axis},
    {"MSYS", &AptReader::machine_system},
    {"LOADTL", &AptReader::load_tool},
    {"TURRET", &AptReader::load_tool},
    {"SPINDL", &AptReader::spindle},
    {"COOLNT", &AptReader::coolant},
    {"STOP", &AptReader::stop},
    {"OPSTOP", &AptReader::stop},
    {"END", &AptReader::stop},
    {"DELAY", &AptReader::delay},
    {"FINI", &AptReader::end},
    {"PARTNO", &AptReader::part_name},
    {"REMARK", &AptReader::remark},
    {"PPRINT", &AptReader::remark},
    // Vocabulary, listings, what the tool looks like, what a display shows.
    {"PPWORD", &AptReader::ignore},
    {"PPFUN", &AptReader::ignore},
    {"SYN", &AptReader::ignore},
    {"PRINT", &AptReader::ignore},
    {"CLPRNT", &AptReader::ignore},
    {"DISPLY", &AptReader::ignore},
    {"CAMERA", &AptReader::ignore},
    {"PAINT", &AptReader::ignore},
    {"MACHIN", &AptReader::ignore},
    {"CUTTER", &AptReader::ignore},
    {"TLDATA", &AptReader::ignore},
    {"TOOLNO", &AptReader::ignore},
    {"TPRINT", &AptReader::ignore},
    {"SELECT", &AptReader::ignore},
    {"SELCTL", &AptReader::ignore},
    {"INTOL", &AptReader::ignore},
    {"OUTTOL", &AptReader::ignore},
    {"TOLER", &AptReader::ignore},
    {"OPNAME", &AptReader::ignore},
    {"SEQNO", &AptReader::ignore},
    {"LEADER", &AptReader::ignore},
    {"CLAMP", &AptReader::ignore},
    {"TOOL PATH", &AptReader::ignore},
    {"END-OF-PATH", &AptReader::ignore},
    // Off is the state in which everything here is read; on would change the motion.
    {"CYCLE", &AptReader::only_off},
    {"CUTCOM", &AptReader::only_off},
    {"CIRCLE", &AptReader::circle},
    {"MOVARC", &AptReader::arc_ahead},
    {"AUTOPS", &AptReader::remark},  // arcs lie in a plane through the tool anyway
    {"INDIRV", &AptReader::initial_direction},
    {"TLON,GOFWD", &AptReader::go_forward},
    {"GOFWD", &AptReader::refuse_curve},
    {"NURBS", &AptReader::nurbs},
    {"KNOT", &AptReader::knots},
    {"CNTRL", &AptReader::control_point},
    {"SPLINE", &AptReader::refuse_curve},
    {"GODLTA", &AptReader::go_by},
    {"GOHOME", &AptReader::refuse_motion},
    {"RETRCT", &AptReader::refuse_motion},
    {"RETURN", &AptReader::refuse_motion},
    {"TRANS", &AptReader::refuse_motion},
    {"ORIGIN", &AptReader::refuse_motion},
    {"ROTABL", &AptReader::rotary_table},
    {"ROTHED", &AptReader::refuse_motion},
    {"ROTATE", &AptReader::refuse_motion},
    {"HEAD", &AptReader::refuse_motion},
    {"PREFUN", &AptReader::refuse_motion},
    {"INSERT", &AptReader::refuse_motion},
    {"COPY", &AptReader::refuse_motion},
    {"INDEX", &AptReader::refuse_motion},
    {"TRACUT", &AptReader::refuse_motion},
    {"THREAD", &AptReader::refuse_motion},
};

/// BEGIN NURBS_SIEMENS(…); as CATIA writes.
bool starts_catia_curve(std::string_view major) noexcept {
    constexpr std::string_view start = "BEGIN NURBS";
    return reads(major.substr(0, start.size()), start);
}

const Rule* rule_for(std::string_view major) noexcept {
    for (const Rule& rule : rules)
        if (reads(major, rule.major)) return &rule;
    return nullptr;
}

}  // namespace

BlockReader::Step AptReader::read_block() {
    if (finished_) return Step::end;
    switch (scanner_.next()) {
        case StatementScanner::Step::end:
            return Step::end;
        case StatementScanner::Step::truncated:
            refuse("NC0411", "the text ends within a statement", "the last line ends in $: is the file complete?");
            return Step::refused;
        case StatementScanner::Step::statement:
            break;
    }
    return statement() ? Step::block : Step::refused;
}

bool AptReader::statement() {
    if (scanner_.major().empty()) return bare_pose();
    words_seen_ = true;
    if (curve_ && curve_->is_catia) return catia_line();
    if (starts_catia_curve(scanner_.major())) return begin_catia_curve();
    const Rule* const rule = rule_for(scanner_.major());
    const bool goes_on = rule && (rule->read == &AptReader::knots || rule->read == &AptReader::control_point);
    if (curve_ && !goes_on && !end_curve()) return false;
    if (circle_ && circle_->points > 0 && rule != rule_for("GOTO")) circle_.reset();
    if (!rule) return refuse("NC0204", "unknown statement: it might change motion", "CL data is read, not APT source");
    return (this->*rule->read)();
}

bool AptReader::finish() {
    if (!end_curve()) return false;
    if (circle_ && circle_->points == 0)
        return refuse("NC0415", "the program ends where a circle waits for the GOTO that ends it");
    if (finished_ && !trimmed(scanner_.rest()).empty())
        findings_.count("NC0014", Severity::note, scanner_.spot(), "FINI",
                        "the text behind the end of the program is not read");
    if (program_.moves.size() < 2)
        return findings_.refuse("NC0005", {}, "the program makes no move",
                                fmt::format("{} poses", program_.moves.size()));
    report_units(stated_, options_.units, findings_);
    return true;
}

bool AptReader::units() {
    const std::string_view unit = scanner_.arguments();
    const bool mm = is_word(unit, {"MM", "MILLIMETER", "MILLIMETERS", "MILLIMETRE", "MILLIMETRES"});
    if (!mm && !is_word(unit, {"IN", "INCH", "INCHES"}))
        return findings_.refuse("NC0407", scanner_.spot(), "not a unit of length", unit, "UNITS/MM or UNITS/INCHES");
    (mm ? stated_.mm : stated_.inch) = true;
    if (options_.units == Units::none) unit_mm_ = mm ? 1 : inch_mm;
    return true;
}

bool AptReader::part_name() {
    if (!scanner_.arguments().empty()) program_.name = scanner_.arguments();
    return true;
}

bool AptReader::load_tool() {
    std::string_view list = scanner_.arguments();
    const std::string_view name = take_item(list);
    if (name.empty()) return refuse("NC0412", "which tool?");
    const auto index = index_in(program_.tools, name);
    if (!index) return refuse("NC0008", "more tools than are read");
    tool_ = *index;
    return event(EventKind::tool, true);
}

/// SPINDL/500,RPM and SPINDL/RPM,500; a speed in other units, or SPINDL/ON, leaves open how fast it turns.
bool AptReader::spindle() {
    turns_per_s_.reset();
    std::optional<double> number;
    bool per_minute = true;
    for (std::string_view list = scanner_.arguments(); !list.empty();) {
        const std::string_view item = take_item(list);
        if (const auto value = number_of(item); value && !number) number = value;
        per_minute = per_minute && !is_word(item, {"SFM", "SMM", "SURF", "OFF"});
    }
    if (number && *number > 0 && per_minute) turns_per_s_ = *number / 60;
    return event(EventKind::spindle, true);
}

/// ROTABL/0: a table that stays where it is, as every other one is refused.
bool AptReader::rotary_table() {
    std::optional<double> angle;
    for (std::string_view list = scanner_.arguments(); !list.empty();) {
        const std::string_view item = take_item(list);
        const auto value = number_of(item);
        const bool known = item.empty() || is_word(item, {"TABLE", "ATABLE", "BTABLE", "CTABLE", "ATANGL", "ABS",
                                                          "INCR", "ROTREF", "CLW", "CCLW", "NEXT", "PREV"});
        if (value && !angle)
            angle = value;
        else if (!known)
            return refuse_motion();
    }
    if (angle != 0.0)
        return refuse("NC0404", "a rotary table that turns is not supported", "post tool vectors, with MULTAX/ON");
    findings_.ignored(scanner_.spot(), "ROTABL");
    return true;
}

bool AptReader::delay() {
    std::string_view list = scanner_.arguments();
    const std::string_view item = take_item(list);
    const auto seconds = number_of(item);
    if (!seconds || !list.empty() || *seconds < 0)
        return findings_.refuse("NC0412", scanner_.spot(), "DELAY is a time in seconds", scanner_.arguments());
    return event(EventKind::dwell, true, *seconds);
}

bool AptReader::end() {
    finished_ = true;
    return true;
}

bool AptReader::event(EventKind kind, bool stops, double dwell_s) {
    std::string word(scanner_.major());
    if (!scanner_.arguments().empty()) (word += '/') += scanner_.arguments();
    program_.events.push_back({kind, stops, dwell_s, std::move(word), program_.moves.size(), scanner_.spot().line});
    return true;
}

bool AptReader::ignore() {
    findings_.ignored(scanner_.spot(), scanner_.major());
    return true;
}

bool AptReader::only_off() {
    if (is_word(scanner_.arguments(), {"OFF"})) return true;
    return refuse_motion();
}

bool AptReader::refuse_curve() {
    return refuse("NC0405", "this curve is not supported", "let the CAM system put out points and circles");
}

bool AptReader::refuse_motion() {
    return refuse("NC0404", "changes motion and is not supported", "post the path without it");
}

bool is_apt_word(std::string_view major) noexcept {
    return rule_for(major) != nullptr;
}

Result<std::unique_ptr<BlockReader>> open_apt(const ProgramText& text, std::string_view file_name,
                                              const ReadOptions& options) {
    return std::make_unique<AptReader>(text, file_name, options);
}

}  // namespace trunnion::nc
