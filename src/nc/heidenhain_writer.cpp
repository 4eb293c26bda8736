#include <algorithm>
#include <cctype>
#include <cmath>
#include <optional>
#include <string>

#include <fmt/format.h>

#include "trunnion/base/quantity.hpp"

#include "detail/arcs.hpp"
#include "detail/program_writer.hpp"

namespace trunnion::nc {

using Eigen::Vector3d;
using program::Move;
using program::MoveKind;
using program::OrientationLaw;
using program::Space;

namespace {

/// HEIDENHAIN Klartext: LN with TX TY TZ and L with rotary words under M128, M129 with TCP off, M91 for machine axes.
/// F of blocks that only turn is deg/min, as without M116.
class HeidenhainWriter final : public ProgramWriter {
  public:
    HeidenhainWriter(const program::Program& program, const machine::Machine* machine, const WriteOptions& options,
                     const TextSink& sink)
        : ProgramWriter(program, machine, options, sink), name_(plain_name(program.name)) {}

  private:
    static std::string plain_name(std::string_view name) {
        std::string out;
        for (const char c : name)
            out += std::isalnum(static_cast<unsigned char>(c)) != 0 ? static_cast<char>(std::toupper(c)) : '_';
        return out.empty() ? "PROGRAM" : out;
    }
    std::string_view unit() const { return options_.units == Units::inch ? "INCH" : "MM"; }

    void head() override {
        line(fmt::format("BEGIN PGM {} {}", name_, unit()));
        for (const std::string& text : options_.head) comment(text);
    }

    void tail() override {
        if (!ends_itself()) line("M30");
        line(fmt::format("END PGM {} {}", name_, unit()));
    }

    bool enter(const Move& to) override {
        if (to.space != Space::machine && !count_offset(to)) return false;
        if (to.exact_stop) tell("NC0914", "exact stop", "Klartext has no word for an exact stop: left out");
        if (!count_tool(to)) return false;
        if (to.space != space_) {
            forget_linear();
            forget_axis();
        }
        space_ = to.space;
        transform(to.space == Space::workpiece);  // M91 is not for M128
        return true;
    }

    /// Datum 1 … 6 are G54 … G59.
    bool count_offset(const Move& to) {
        const std::string& name = offset_name(to);
        if (name == offset_) return true;
        std::string number;
        if (name.size() == 3 && name >= "G54" && name <= "G59")
            number = fmt::format("{}", name[2] - '3');
        else if (name.starts_with("DATUM "))
            number = name.substr(6);
        else
            return refuse("NC0905", "no such work offset in this dialect", name, "datums are G54 … G59 or DATUM n");
        line("CYCL DEF 247 DATUM SETTING ~");
        begin_block();
        put("Q339=+" + number);
        out_.end_line();
        offset_ = name;
        forget_linear();
        forget_axis();
        return true;
    }

    bool count_tool(const Move& to) {
        const std::string& name = tool_name(to);
        if (name == tool_ || to.space == Space::machine) return true;
        if (name.empty() || name.ends_with(" D0"))
            return refuse("NC0906", "a tool whose length does not count cannot be said here", name,
                          "call it with its length");
        call_tool(name);
        return true;
    }

    void call_tool(std::string_view name) {
        const bool number = name.find_first_not_of("0123456789") == name.npos;
        line(number ? fmt::format("TOOL CALL {} Z", name) : fmt::format("TOOL CALL \"{}\" Z", name));
        tool_ = name;
        forget_linear();
        forget_axis();
    }

    void transform(bool on) {
        if (tcp_ == on) return;
        if (on || tcp_) line(on ? "M128" : "M129");
        tcp_ = on;
        forget_linear();
        forget_axis();
    }

    void begin_block() { out_.integer(number_++); }
    void word(std::string_view letters, const DecimalGrid& grid, std::int64_t steps) {
        out_.gap();
        out_.put(letters);
        out_.number(grid, steps, {.plus_sign = true});
    }
    void put(std::string_view text) {
        out_.gap();
        out_.put(text);
    }
    void line(std::string_view text) {
        begin_block();
        put(text);
        out_.end_line();
    }

    void linear_words() {
        constexpr std::string_view letters[] = {"X", "Y", "Z"};
        for (std::size_t i = 0; i < 3; ++i)
            if (says_linear(i)) word(letters[i], linear_grid_, goal_.linear[i]);
    }
    void rotary_words() {
        for (std::size_t i = 0; i < program_.rotary_letters.size(); ++i)
            if (says_rotary(i)) word({&program_.rotary_letters[i], 1}, rotary_grid_, goal_.rotary[i]);
    }

    /// LN says its vector in every block.
    bool straight(const Move& to) override {
        begin_block();
        const bool by_vector = to.law == OrientationLaw::vector;
        put(by_vector ? "LN" : "L");
        if (by_vector) {
            all_linear_words();
            constexpr std::string_view letters[] = {"TX", "TY", "TZ"};
            for (std::size_t i = 0; i < 3; ++i) word(letters[i], vector_grid_, goal_.axis[i]);
        } else {
            linear_words();
            rotary_words();
        }
        put("R0");
        feed_words(to, false);
        if (to.space == Space::machine) put("M91");
        out_.end_line();
        arrive(to);
        return true;
    }

    void all_linear_words() {
        constexpr std::string_view letters[] = {"X", "Y", "Z"};
        for (std::size_t i = 0; i < 3; ++i)
            if (goal_.linear[i] != unsaid) word(letters[i], linear_grid_, goal_.linear[i]);
    }

    /// F MAX holds for its block alone.
    void feed_words(const Move& to, bool on_arc) {
        if (to.kind == MoveKind::rapid) return put("FMAX");
        FeedWord feed = feed_word(to, on_arc, false, 0);
        constexpr double tenths = 10;  // F of a program in inches
        if (options_.units == Units::inch && (on_arc || goes())) feed.number *= tenths;
        if (feed.kind == FeedWord::Kind::none || feed.number == feed_) return;
        feed_ = feed.number;
        put("F");
        out_.number_within(feed.number, options_.feed_precision);
    }

    /// Circles of less than a whole turn in the plane XY by centre and end; helices and other planes are divided.
    bool arc(const Move& to) override {
        const program::Arc& arc = program_.arcs[static_cast<std::size_t>(to.arc)];
        constexpr double upright = 1e-9;
        if (to.law == OrientationLaw::vector || to.kind == MoveKind::rapid || to.space == Space::machine) return false;
        if (std::abs(std::abs(arc.normal.z()) - 1) > upright || says_linear(2) || turns_words()) return false;
        Vector3d start = said_mm(), end = goal_mm();
        start.z() = end.z() = 0;
        if ((start + end).hasNaN()) return false;
        const DecimalGrid finer = DecimalGrid::within(0.01 * options_.precision_mm / unit_mm());
        Vector3d centre = Vector3d::Zero();
        for (int i = 0; i < 2; ++i) centre[i] = finer.value(finer.steps(arc.centre_mm[i] / unit_mm())) * unit_mm();
        const double angle = arc.angle_rad * (arc.normal.z() < 0 ? -1 : 1);
        const auto read = arc_by_centre(start, end, centre, Vector3d::UnitZ(), angle < 0, 0, linuxcnc_arcs);
        const double radius = (start - centre).norm();
        if (!read || !(std::abs(read->angle_rad - angle) * radius <= 4 * options_.precision_mm)) return false;
        begin_block();
        put("CC");
        word("X", finer, finer.steps(centre.x() / unit_mm()));
        word("Y", finer, finer.steps(centre.y() / unit_mm()));
        out_.end_line();
        begin_block();
        put("C");
        word("X", linear_grid_, goal_.linear[0]);
        word("Y", linear_grid_, goal_.linear[1]);
        put(angle < 0 ? "DR-" : "DR+");
        put("R0");
        feed_words(to, true);
        out_.end_line();
        arrive(to);
        return true;
    }

    bool action(const Action& action, const program::Event& event) override {
        using Kind = Action::Kind;
        switch (action.kind) {
            case Kind::dwell:
                line("CYCL DEF 9.0 DWELL TIME");
                begin_block();
                put("CYCL DEF 9.1 DWELL ");
                out_.number_within(action.number, options_.feed_precision);
                out_.end_line();
                return true;
            case Kind::spindle_speed:
                line(fmt::format("TOOL CALL S{}", action.number));
                return true;
            case Kind::prepare_tool:
                prepared_ = action.name;
                return true;
            case Kind::change_tool:
                return change_tool(action);
            case Kind::end:
                line(event.word == "M2" ? "M2" : "M30");
                return true;
            case Kind::mist:
                return false;
            default:
                line(word_of(action.kind));
                return true;
        }
    }

    static std::string_view word_of(Action::Kind kind) {
        using Kind = Action::Kind;
        switch (kind) {
            case Kind::spindle_clockwise:
                return "M3";
            case Kind::spindle_counter_clockwise:
                return "M4";
            case Kind::spindle_off:
                return "M5";
            case Kind::flood:
                return "M8";
            case Kind::coolant_off:
                return "M9";
            case Kind::optional_pause:
                return "M1";
            default:
                return "M0";
        }
    }

    bool change_tool(const Action& action) {
        const std::string name(action.name.empty() ? prepared_.value_or("") : std::string(action.name));
        if (name.empty() || name.contains('"')) return false;
        call_tool(name);
        return true;
    }

    bool own_word(const program::Event& event) override {
        if (!event.word.starts_with('M')) return false;
        line(event.word);
        return true;
    }

    void comment(std::string_view text) override {
        begin_block();
        put("; ");
        for (const char c : text) out_.put(c >= ' ' && c <= '~' ? c : '?');
        out_.end_line();
    }

    std::string name_, tool_, offset_;
    std::optional<std::string> prepared_;
    Space space_ = Space::untransformed;
    bool tcp_ = false;
    double feed_ = 0;
    std::int64_t number_ = 0;
};

}  // namespace

std::unique_ptr<ProgramWriter> make_heidenhain_writer(const program::Program& program, const machine::Machine* machine,
                                                      const WriteOptions& options, const TextSink& sink) {
    return std::make_unique<HeidenhainWriter>(program, machine, options, sink);
}

}  // namespace trunnion::nc
