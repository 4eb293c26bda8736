#include "detail/rs274_reader.hpp"

namespace trunnion::nc {

using program::EventKind;

namespace {

constexpr std::uint32_t always_used = Block::bit('F') | Block::bit('S') | Block::bit('T');
constexpr std::uint32_t parameter_letters = Block::bit('D') | Block::bit('E') | Block::bit('H') | Block::bit('I') |
                                            Block::bit('J') | Block::bit('K') | Block::bit('L') | Block::bit('P') |
                                            Block::bit('Q') | Block::bit('R');

}  // namespace

Result<program::Program> Rs274Reader::read() {
    for (;;) {
        const BlockScanner::Step step = scanner_.next(block_);
        if (step == BlockScanner::Step::end) return done();
        if (step == BlockScanner::Step::refused || !block()) return fail(findings_.take_error());
        if (finished_) return done();
    }
}

/// In the order in which LinuxCNC carries out the words of a block.
bool Rs274Reader::block() {
    if (block_.deleted)
        findings_.count("NC0016", Severity::warning, {block_.line, 1}, "/", "block skipped, as block delete asks for",
                        "take the slash away if it shall be read");
    if (block_.deleted || block_.empty) return true;
    if (!sort_codes() || !check_letters()) return false;
    feed_mode();
    if (!feed() || !spindle_and_tool() || !dwell()) return false;
    units();
    if (!modes() || !motion()) return false;
    stops();
    return true;
}

bool Rs274Reader::sort_codes() {
    request_.meaning.fill(Meaning::unknown);
    request_.tcp.reset();
    request_.own_word = false;
    for (std::size_t i = 0; i < block_.code_count; ++i)
        if (!own_code(block_.codes[i]) && !sort_code(block_.codes[i])) return false;
    return true;
}

/// Whether the machine file declares this word.
bool Rs274Reader::own_code(const Code& code) {
    const Control::Role role = control_.role(code);
    if (role == Control::Role::none) return false;
    if (role == Control::Role::ignore)
        request_.own_word = true;
    else
        request_.tcp = role == Control::Role::tcp_on;
    return true;
}

bool Rs274Reader::sort_code(const Code& code) {
    const Spot spot{block_.line, code.column};
    const WordRule rule = rule_for(code);
    switch (rule.meaning) {
        case Meaning::unknown:
            return refuse("NC0204", spot, "unknown word: it might change motion", name_of(code),
                          "a word of this control that does not can be declared in the machine file: [words] ignore");
        case Meaning::spline:
            return refuse("NC0301", spot, "splines are not supported", name_of(code), "post linear moves or arcs");
        case Meaning::changes_motion:
            return refuse("NC0302", spot, "changes motion and is not supported", name_of(code),
                          "post the path without it");
        default:
            break;
    }
    const auto group = static_cast<std::size_t>(rule.group);
    if (request_.meaning[group] != Meaning::unknown)
        return refuse("NC0304", spot, "two words of one modal group in a block", name_of(code),
                      fmt::format("it contradicts {}", name_of(request_.code[group])));
    request_.meaning[group] = rule.meaning;
    request_.code[group] = code;
    return true;
}

bool Rs274Reader::check_letters() {
    axes_ = block_.present & control_.axis_letters();
    axes_ever_ |= axes_;
    for (std::uint32_t others = block_.present & ~(axes_ | always_used); others != 0; others &= others - 1)
        if (!check_letter(static_cast<char>('A' + std::countr_zero(others)))) return false;
    return true;
}

bool Rs274Reader::check_letter(char letter) {
    const Control::Letter kind = control_.kind(Block::index(letter));
    if (kind == Control::Letter::silent) return true;
    if (kind == Control::Letter::following) {
        findings_.ignored(block_.spot(letter), {&letter, 1});
        return true;
    }
    if ((parameter_letters & Block::bit(letter)) == 0 && letter != 'N') return absent_axis(letter);
    const bool dwells = request_.asks(Group::once, Meaning::dwell);
    if (moves_on_arc() && letter == 'P' && dwells)
        return refuse("NC0313", block_.spot(letter), "the letter has two uses in this block", {&letter, 1},
                      "give the dwell a block of its own");
    if (moves_on_arc() && std::string_view("IJKPR").contains(letter)) return true;
    if (letter == 'H' && request_.asks(Group::tool_length, Meaning::tool_length)) return true;
    const bool blends = request_.asks(Group::path_control, Meaning::continuous);
    if (request_.own_word || (letter == 'P' && dwells)) return true;
    if (blends && (letter == 'P' || letter == 'Q')) {
        findings_.ignored(block_.spot(letter), letter == 'P' ? "G64 P" : "G64 Q");
        return true;
    }
    return refuse("NC0313", block_.spot(letter), "the letter has no use in this block", {&letter, 1});
}

bool Rs274Reader::absent_axis(char letter) {
    if (!control_.has_machine())
        return refuse("NC0307", block_.spot(letter), "this axis needs a machine that has it", {&letter, 1},
                      "-m says which");
    return refuse("NC0306", block_.spot(letter), "the machine has no such axis", {&letter, 1},
                  "another machine (-m), or [words] following = [...] in its file for a letter that is no axis");
}

void Rs274Reader::feed_mode() {
    const Meaning mode = request_.of(Group::feed_mode);
    if (mode == Meaning::unknown) return;
    const bool inverse = mode == Meaning::inverse_time;
    if (inverse != modal_.inverse_time) modal_.feed_per_s = 0;
    modal_.inverse_time = inverse;
}

/// F counts in the unit that is in force before the block: LinuxCNC takes it before G20 and G21.
bool Rs274Reader::feed() {
    if (modal_.inverse_time) modal_.feed_per_s = 0;
    if (!block_.has('F')) return true;
    const double per_s = block_['F'] / 60;
    if (!(per_s > 0) || !std::isfinite(1 / per_s))
        return refuse("NC0206", block_.spot('F'), "a feed must be positive", fmt::format("F{}", block_['F']));
    modal_.feed_per_s = per_s;
    modal_.feed_unit_mm = modal_.unit_mm;
    return true;
}

bool Rs274Reader::spindle_and_tool() {
    if (block_.has('S')) {
        if (block_['S'] < 0)
            return refuse("NC0314", block_.spot('S'), "a speed is not negative", fmt::format("S{}", block_['S']));
        event(EventKind::spindle, false, fmt::format("S{}", block_['S']));
    }
    if (block_.has('T')) {
        const double number = block_['T'];
        if (number < 0 || number != std::floor(number))
            return refuse("NC0314", block_.spot('T'), "a tool is a whole number", fmt::format("T{}", number));
        modal_.prepared_tool = number;
        event(EventKind::tool, false, fmt::format("T{}", number));
    }
    if (request_.of(Group::tool_change) != Meaning::unknown && !change_tool()) return false;
    if (request_.asks(Group::spindle, Meaning::spindle)) code_event(EventKind::spindle, true, Group::spindle);
    if (request_.asks(Group::mist, Meaning::coolant)) code_event(EventKind::coolant, false, Group::mist);
    if (request_.asks(Group::flood, Meaning::coolant)) code_event(EventKind::coolant, false, Group::flood);
    return true;
}

bool Rs274Reader::change_tool() {
    code_event(EventKind::tool, true, Group::tool_change);
    if (!modal_.prepared_tool) return true;
    const auto index = index_in(program_.tools, fmt::format("{}", *modal_.prepared_tool));
    if (!index) return refuse("NC0008", {block_.line, 1}, "more tools than are read");
    modal_.tool = *index;
    return true;
}

bool Rs274Reader::dwell() {
    if (!request_.asks(Group::once, Meaning::dwell)) return true;
    if (!block_.has('P') || block_['P'] < 0)
        return refuse("NC0312", {block_.line, request_.code_of(Group::once).column}, "a dwell needs its time", {},
                      "G4 P2 is two seconds");
    event(EventKind::dwell, true, fmt::format("G4 P{}", block_['P']), block_['P']);
    return true;
}

void Rs274Reader::units() {
    const Meaning unit = request_.of(Group::units);
    if (unit == Meaning::unknown) return;
    (unit == Meaning::mm ? stated_.mm : stated_.inch) = true;
    if (options_.units != Units::none) return;
    const double unit_mm = unit == Meaning::mm ? 1 : inch_mm;
    if (block_.has('F') && unit_mm != modal_.unit_mm && !modal_.inverse_time)
        findings_.count("NC0017", Severity::warning, block_.spot('F'), "F",
                        "F in the block that changes the unit counts in the old one, as on LinuxCNC",
                        "give F in a block behind it");
    modal_.unit_mm = unit_mm;
}

bool Rs274Reader::modes() {
    if (request_.tcp) modal_.tcp = *request_.tcp;
    if (request_.asks(Group::offset, Meaning::offset) && !offset()) return false;
    if (!tool_length()) return false;
    if (request_.asks(Group::plane, Meaning::plane))
        modal_.plane_normal = 2 - (request_.code_of(Group::plane).tenths - 170) / 10;
    if (const Meaning centre = request_.of(Group::arc_distance); centre != Meaning::unknown)
        modal_.centre_absolute = centre == Meaning::absolute_centre;
    if (!path_control()) return false;
    if (const Meaning distance = request_.of(Group::distance); distance != Meaning::unknown)
        modal_.absolute = distance == Meaning::absolute;
    if (const Meaning motion = request_.of(Group::motion); motion != Meaning::unknown) modal_.motion = motion;
    return true;
}

/// G64 alone: no tolerance, and blocks stay; with P: blocks may be merged within it too, unless Q says another length.
bool Rs274Reader::path_control() {
    const Meaning asked = request_.of(Group::path_control);
    if (asked == Meaning::unknown) return true;
    for (const char letter : {'P', 'Q'})
        if (asked == Meaning::continuous && block_.has(letter) && block_[letter] < 0)
            return refuse("NC0314", block_.spot(letter), "a tolerance is not negative",
                          fmt::format("{}{}", letter, block_[letter]));
    modal_.exact_stop = asked == Meaning::exact_stop;
    program::PathControl control{.before_move = program_.moves.size()};
    if (modal_.exact_stop) {
        const bool always = request_.code_of(Group::path_control).tenths == 611;
        control.kind = always ? program::PathControlKind::stop : program::PathControlKind::exact;
    } else if (block_.has('P')) {
        control.tolerance_mm = block_['P'] * modal_.unit_mm;
        control.merge_tolerance_mm = block_.has('Q') ? block_['Q'] * modal_.unit_mm : control.tolerance_mm;
    }
    program_.path_controls.push_back(control);
    return true;
}

bool Rs274Reader::offset() {
    const auto index = index_in(program_.offsets, name_of(request_.code_of(Group::offset)));
    if (!index) return refuse("NC0008", {block_.line, 1}, "more offsets than are read");
    modal_.offset = *index;
    return true;
}

/// G43 Hn: the length of tool n counts, whatever tool is in the spindle; G43 and G49: that of the tool in the spindle.
bool Rs274Reader::tool_length() {
    if (request_.of(Group::tool_length) == Meaning::unknown) return true;
    modal_.length_tool.reset();
    if (!block_.has('H') || !request_.asks(Group::tool_length, Meaning::tool_length)) return true;
    const double number = block_['H'];
    if (number < 0 || number != std::floor(number))
        return refuse("NC0314", block_.spot('H'), "a tool is a whole number", fmt::format("H{}", number));
    const auto index =
        index_in(program_.tools, number == 0 ? program_.tools[modal_.tool] + " D0" : fmt::format("{}", number));
    if (!index) return refuse("NC0008", {block_.line, 1}, "more tools than are read");
    modal_.length_tool = index;
    return true;
}

void Rs274Reader::stops() {
    const Meaning stop = request_.of(Group::stop);
    if (stop == Meaning::unknown) return;
    code_event(EventKind::stop, true, Group::stop);
    finished_ = stop == Meaning::end;
}

Result<program::Program> Rs274Reader::done() {
    const std::string_view rest = trimmed(scanner_.rest());
    if (rest.find_first_not_of("% \t\r\n") != rest.npos)
        findings_.count("NC0014", Severity::note, {block_.line, 1}, "end",
                        "the text behind the end of the program is not read");
    drop_undetermined();
    if (program_.moves.size() < 2) {
        never_started();
        return fail(findings_.take_error());
    }
    keep_used_letters();
    report_units(stated_, options_.units, findings_);
    program_.diagnostics = findings_.take_notices();
    return std::move(program_);
}

Result<program::Program> read_rs274(std::string_view text, std::string_view file_name, const ReadOptions& options) {
    auto control = Control::make(options.machine);
    if (!control) return fail(std::move(control.error()));
    return Rs274Reader(text, file_name, options, std::move(*control)).read();
}

}  // namespace trunnion::nc
