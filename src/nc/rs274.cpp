#include "detail/rs274_reader.hpp"

namespace trunnion::nc {

using program::EventKind;

namespace {

bool same_control(const program::PathControl& a, const program::PathControl& b) {
    return a.kind == b.kind && a.tolerance_mm == b.tolerance_mm && a.merge_tolerance_mm == b.merge_tolerance_mm;
}

}  // namespace

BlockReader::Step Rs274Reader::read_block() {
    if (finished_) return Step::end;
    switch (flow_.next(block_)) {
        case Rs274Flow::Step::end:
            return Step::end;
        case Rs274Flow::Step::refused:
            return Step::refused;
        case Rs274Flow::Step::block:
            break;
    }
    return block() ? Step::block : Step::refused;
}

/// In the order in which LinuxCNC carries out the words of a block.
bool Rs274Reader::block() {
    if (block_.deleted)
        findings_.count("NC0016", Severity::warning, block_.at(1), "/", "block skipped, as block delete asks for",
                        "take the slash away if it shall be read");
    if (!kept_states_.empty()) states_at_return();
    if (block_.deleted || block_.empty) return true;
    if (surface_words_.is_open()) return surface_datum();
    if (!sort_codes()) return false;
    if (request_.of(Group::surface) != Meaning::unknown) return surface_word();
    if (!check_letters()) return false;
    feed_mode();
    if (!feed() || !spindle_and_tool() || !dwell()) return false;
    units();
    if (!modes() || !shift() || !motion()) return false;
    stops();
    return subprogram();
}

bool Rs274Reader::sort_codes() {
    request_.meaning.fill(Meaning::unknown);
    request_.tcp.reset();
    request_.own_word = false;
    request_.takes_axes = false;
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
    const Spot spot = block_.at(code.column);
    const WordRule rule = rule_for(code);
    switch (rule.meaning) {
        case Meaning::unknown:
            return refuse("NC0204", spot, "unknown word: it might change motion", name_of(code),
                          "a word of this control that does not can be declared in the machine file: [words] ignore");
        case Meaning::changes_motion:
            return refuse("NC0302", spot, "changes motion and is not supported", name_of(code),
                          "post the path without it");
        case Meaning::printing:
            if (!printing_word(code)) return false;
            break;
        case Meaning::user_word:
            request_.own_word = true;
            break;
        case Meaning::shift_to_here:
        case Meaning::local_shift:
        case Meaning::set_data:
        case Meaning::go_home:
            request_.takes_axes = true;
            break;
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

/// Whatever letters stand beside it are its own.
bool Rs274Reader::printing_word(const Code& code) {
    findings_.ignored(block_.at(code.column), name_of(code));
    event(EventKind::other, false, with_letters(code, block_.present));
    if (block_.code_count > 1)
        return refuse("NC0304", block_.at(code.column), "this word needs a block of its own", name_of(code));
    block_.present = 0;
    return true;
}

void Rs274Reader::feed_mode() {
    const Meaning asked = request_.of(Group::feed_mode);
    if (asked == Meaning::unknown) return;
    const FeedMode mode = asked == Meaning::inverse_time ? FeedMode::inverse_time
                          : asked == Meaning::per_turn   ? FeedMode::per_turn
                                                         : FeedMode::per_minute;
    if (mode != modal_.feed_mode) modal_.feed_per_s = modal_.feed_per_turn = 0;
    modal_.feed_mode = mode;
}

/// F counts in the unit that is in force before the block: LinuxCNC takes it before G20 and G21.
bool Rs274Reader::feed() {
    if (modal_.feed_mode == FeedMode::inverse_time) modal_.feed_per_s = 0;
    if (!block_.has('F')) return true;
    modal_.feed_unit_mm = modal_.unit_mm;
    if (modal_.feed_mode != FeedMode::per_turn) return set_feed(block_['F'] / 60);
    modal_.feed_per_turn = block_['F'];
    return set_feed(block_['F']);
}

bool Rs274Reader::set_feed(double per_s) {
    if (!(per_s > 0) || !std::isfinite(1 / per_s))
        return refuse("NC0206", block_.spot('F'), "a feed must be positive", fmt::format("F{}", block_['F']));
    modal_.feed_per_s = per_s;
    return true;
}

bool Rs274Reader::spindle_and_tool() {
    if (block_.has('S') && !spindle_speed()) return false;
    if (modal_.feed_mode == FeedMode::per_turn)
        modal_.feed_per_s = modal_.feed_per_turn * modal_.spindle_per_s.value_or(0);
    if (block_.has('T') && !prepare_tool()) return false;
    if (request_.of(Group::pins) != Meaning::unknown && !pins()) return false;
    if (request_.of(Group::tool_change) != Meaning::unknown && !change_tool()) return false;
    if (request_.asks(Group::spindle, Meaning::spindle)) {
        code_event(EventKind::spindle, true, Group::spindle);
        const Code& code = request_.code_of(Group::spindle);
        modal_.spindle_word = code.tenths == 30 || code.tenths == 40 ? name_of(code) : std::string{};
    }
    if (request_.of(Group::state) != Meaning::unknown && !state()) return false;
    if (request_.asks(Group::mist, Meaning::coolant)) code_event(EventKind::coolant, false, Group::mist);
    if (request_.asks(Group::flood, Meaning::coolant)) code_event(EventKind::coolant, false, Group::flood);
    if (request_.asks(Group::user, Meaning::user_word)) user_word();
    return true;
}

bool Rs274Reader::spindle_speed() {
    if (block_['S'] < 0)
        return refuse("NC0314", block_.spot('S'), "a speed is not negative", fmt::format("S{}", block_['S']));
    modal_.spindle_per_s = block_['S'] / 60;
    event(EventKind::spindle, false, fmt::format("S{}", block_['S']));
    return true;
}

bool Rs274Reader::prepare_tool() {
    const double number = block_['T'];
    if (number < 0 || number != std::floor(number))
        return refuse("NC0314", block_.spot('T'), "a tool is a whole number", fmt::format("T{}", number));
    modal_.prepared_tool = number;
    event(EventKind::tool, false, fmt::format("T{}", number));
    return true;
}

/// M6 puts in the tool that T chose; M61 Q says which one is in the spindle.
bool Rs274Reader::change_tool() {
    if (request_.asks(Group::tool_change, Meaning::tool_in_spindle)) {
        if (!block_.has('Q') || block_['Q'] < 0 || block_['Q'] != std::floor(block_['Q']))
            return refuse("NC0314", spot_of(Group::tool_change), "M61 needs the number of the tool", {}, "M61 Q3");
        event(EventKind::tool, false, fmt::format("M61 Q{}", block_['Q']));
        return put_in(block_['Q']);
    }
    code_event(EventKind::tool, true, Group::tool_change);
    return !modal_.prepared_tool || put_in(*modal_.prepared_tool);
}

bool Rs274Reader::put_in(double number) {
    const auto index = index_in(program_.tools, fmt::format("{}", number));
    if (!index) return refuse("NC0008", block_.at(1), "more tools than are read");
    modal_.tool = *index;
    return true;
}

/// Outputs, and waiting for inputs.
bool Rs274Reader::pins() {
    std::string word = name_of(request_.code_of(Group::pins));
    for (const char letter : {'P', 'E', 'L', 'Q'})
        if (block_.has(letter)) word += fmt::format(" {}{}", letter, block_[letter]);
    event(EventKind::other, request_.asks(Group::pins, Meaning::wait_for_pin), std::move(word));
    return true;
}

/// M70 … M73: the modal words but for motion and tool.
bool Rs274Reader::state() {
    const Meaning asked = request_.of(Group::state);
    const bool kept = !kept_states_.empty() && kept_states_.back().depth == flow_.depth();
    if (asked == Meaning::restore_state) {
        if (!kept) return refuse("NC0349", spot_of(Group::state), "M72 without M70 or M73 in this program", "M72");
        restore(kept_states_.back().modal);
        return true;
    }
    if (kept) kept_states_.pop_back();
    if (asked != Meaning::forget_state)
        kept_states_.push_back({flow_.depth(), modal_, asked == Meaning::keep_state_till_return});
    return true;
}

void Rs274Reader::restore(const Modal& kept) {
    Modal now = kept;
    now.motion = modal_.motion;
    now.motion_code = modal_.motion_code;
    now.tcp = modal_.tcp;
    now.tool = modal_.tool;
    now.prepared_tool = modal_.prepared_tool;
    if (!same_control(now.path_control, modal_.path_control)) {
        now.path_control.before_move = program_.moves.size();
        program_.path_controls.push_back(now.path_control);
    }
    modal_ = std::move(now);
    use_shift();
}

/// What subprograms that have ended kept.
void Rs274Reader::states_at_return() {
    while (!kept_states_.empty() && kept_states_.back().depth > flow_.depth()) {
        const KeptState state = std::move(kept_states_.back());
        kept_states_.pop_back();
        if (state.till_return) restore(state.modal);
    }
}

bool Rs274Reader::dwell() {
    if (!request_.asks(Group::once, Meaning::dwell)) return true;
    if (!block_.has('P') || block_['P'] < 0)
        return refuse("NC0312", spot_of(Group::once), "a dwell needs its time", {}, "G4 P2 is two seconds");
    event(EventKind::dwell, true, fmt::format("G4 P{}", block_['P']), block_['P']);
    return true;
}

void Rs274Reader::units() {
    const Meaning unit = request_.of(Group::units);
    if (unit == Meaning::unknown) return;
    (unit == Meaning::mm ? stated_.mm : stated_.inch) = true;
    if (options_.units != Units::none) return;
    const double unit_mm = unit == Meaning::mm ? 1 : inch_mm;
    if (block_.has('F') && unit_mm != modal_.unit_mm && modal_.feed_mode != FeedMode::inverse_time)
        findings_.count("NC0017", Severity::warning, block_.spot('F'), "F",
                        "F in the block that changes the unit counts in the old one, as on LinuxCNC",
                        "give F in a block behind it");
    modal_.unit_mm = unit_mm;
}

bool Rs274Reader::modes() {
    if (request_.tcp) modal_.tcp = *request_.tcp;
    if (request_.asks(Group::offset, Meaning::offset) && !offset()) return false;
    if (!tool_length()) return false;
    if (request_.asks(Group::plane, Meaning::plane)) {
        modal_.plane_normal = 2 - (request_.code_of(Group::plane).tenths - 170) / 10;
        cycle_level_mm_.reset();
    }
    if (const Meaning centre = request_.of(Group::arc_distance); centre != Meaning::unknown)
        modal_.centre_absolute = centre == Meaning::absolute_centre;
    if (!path_control()) return false;
    if (const Meaning distance = request_.of(Group::distance); distance != Meaning::unknown)
        modal_.absolute = distance == Meaning::absolute;
    if (request_.of(Group::following_distance) != Meaning::unknown) following_distance();
    if (const Meaning retract = request_.of(Group::return_mode); retract != Meaning::unknown) modal_.retract = retract;
    return motion_word();
}

bool Rs274Reader::motion_word() {
    const Meaning motion = request_.of(Group::motion);
    if (motion == Meaning::unknown) return true;
    const bool wants_axes = axes_ != 0 || motion == Meaning::surface_machining;
    if (request_.takes_axes && motion != Meaning::no_motion && wants_axes)
        return refuse("NC0343", spot_of(Group::motion), "two words want the axis words of this block",
                      name_of(request_.code_of(Group::motion)),
                      fmt::format("give {} a block of its own", name_of(request_.code_of(Group::shift))));
    if (nurbs_ && motion != Meaning::nurbs && motion != Meaning::nurbs_end)
        return refuse("NC0351", spot_of(Group::motion), "a NURBS that G5.3 does not end",
                      name_of(request_.code_of(Group::motion)), "G5.3 behind its last point");
    if (motion == Meaning::cycle && modal_.motion != Meaning::cycle) {
        cycle_ = {};
        cycle_level_mm_.reset();
    }
    modal_.motion = motion == Meaning::surface_machining ? Meaning::no_motion : motion;
    modal_.motion_code = request_.code_of(Group::motion);
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
    modal_.path_control = control;
    program_.path_controls.push_back(control);
    return true;
}

bool Rs274Reader::offset() {
    const auto index = index_in(program_.offsets, name_of(request_.code_of(Group::offset)));
    if (!index) return refuse("NC0008", block_.at(1), "more offsets than are read");
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
    if (!index) return refuse("NC0008", block_.at(1), "more tools than are read");
    modal_.length_tool = index;
    return true;
}

void Rs274Reader::stops() {
    const Meaning stop = request_.of(Group::stop);
    if (stop == Meaning::unknown) return;
    code_event(EventKind::stop, true, Group::stop);
    finished_ = stop == Meaning::end;
}

/// M98 and M99, behind everything else in their block.
bool Rs274Reader::subprogram() {
    const Meaning asked = request_.of(Group::subprogram);
    if (asked == Meaning::unknown) return true;
    const int column = request_.code_of(Group::subprogram).column;
    if (asked == Meaning::return_from_program) return flow_.return_from_program(block_, column);
    if (!block_.has('P'))
        return refuse("NC0339", block_.at(column), "M98 needs the number of a program", {}, "M98 P1000");
    return flow_.call_program(block_, column, block_['P'], block_.has('L') ? block_['L'] : 1);
}

bool Rs274Reader::finish() {
    if (nurbs_) return refuse("NC0351", block_.at(nurbs_->column), "a NURBS that G5.3 does not end");
    if (!surface_words_.finish()) return false;
    const std::string_view rest = trimmed(flow_.rest());
    if (rest.find_first_not_of("% \t\r\n") != rest.npos && !flow_.has_subprograms())
        findings_.count("NC0014", Severity::note, block_.at(1), "end",
                        "the text behind the end of the program is not read");
    if (left_out_home_)
        findings_.count("NC0347", Severity::warning, *left_out_home_, "G28",
                        "the way home at the end is left out: where it leads is not known");
    drop_undetermined();
    if (program_.moves.size() < 2 && program_.surface_jobs.empty()) return never_started();
    report_units(stated_, options_.units, findings_);
    return true;
}

Result<std::unique_ptr<BlockReader>> open_rs274(const ProgramText& text, std::string_view file_name,
                                                const ReadOptions& options) {
    auto control = Control::make(options.machine);
    if (!control) return fail(std::move(control.error()));
    return std::make_unique<Rs274Reader>(text, file_name, options, std::move(*control));
}

}  // namespace trunnion::nc
