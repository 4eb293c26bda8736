#include "detail/sinumerik_reader.hpp"

#include <algorithm>

namespace trunnion::nc::sinumerik {

using program::EventKind;

namespace {

constexpr double largest_number = 1e9;  ///< of words that are whole numbers

bool is_whole(double value) {
    return value == std::floor(value) && std::abs(value) < largest_number;
}

/// As it was written, for messages and events: `G54`, `SPOS=90`.
std::string written(const Word& word) {
    std::string text(word.name);
    if (word.extension != 0) text += fmt::format("{}=", word.extension);
    if (!word.index.empty()) text += fmt::format("[{}]", word.index);
    if (word.has_text) return text + fmt::format("=\"{}\"", word.text);
    if (!word.has_value) return text;
    const bool equals = word.name.size() > 1 && word.extension == 0;
    return text + fmt::format("{}{}", equals ? "=" : "", word.value);
}

std::string message_of(const Word& word) {
    return word.arguments.empty() ? "MSG()" : fmt::format("MSG(\"{}\")", word.arguments.front().text);
}

/// Whether M6 stands anywhere outside comments.
bool says_m6(const ProgramText& text) {
    LineScanner lines(text);
    for (std::string_view line; lines.next(line);) {
        line = line.substr(0, line.find(';'));
        for (std::size_t i = 0; i < line.size(); ++i) {
            if (upper(line[i]) != 'M' || (i > 0 && (is_letter(line[i - 1]) || line[i - 1] == '_'))) continue;
            std::size_t end = i + 1;
            while (end < line.size() && line[end] == '0') ++end;
            if (end < line.size() && line[end] == '6' && (end + 1 == line.size() || !is_digit(line[end + 1])))
                return true;
        }
    }
    return false;
}

}  // namespace

SinumerikReader::SinumerikReader(const ProgramText& text, std::string_view file_name, const ReadOptions& options,
                                 Control control)
    : BlockReader(file_name, options, Dialect::sinumerik),
      interpreter_(text, file_name, findings_, is_word, {.lines = options.most_repeated_lines}),
      control_(std::move(control)) {
    if (options.units == Units::inch) modes_.unit_mm = modes_.feed_unit_mm = inch_mm;
    position_mm_.setConstant(unknown);
    programmed_mm_.setConstant(unknown);
    second_mm_.setConstant(unknown);
    rotary_rad_.fill(unknown);
}

BlockReader::Step SinumerikReader::read_block() {
    if (finished_) return Step::end;
    switch (interpreter_.next(block_)) {
        case Interpreter::Step::end:
            return Step::end;
        case Interpreter::Step::refused:
            return Step::refused;
        case Interpreter::Step::block:
            break;
    }
    return block() ? Step::block : Step::refused;
}

bool SinumerikReader::refuse(std::string_view code, const Word& word, std::string text, std::string_view hint) {
    return findings_.refuse(code, block_.spot(word), std::move(text), written(word), hint);
}

/// The words of a block act together, in whatever order they stand: modes first, then the tool, then motion.
bool SinumerikReader::block() {
    said_.clear();
    said_.forget_uses();
    groups_.fill(Meaning::unknown);
    frame_word_ = call_ = modal_call_ = stop_ = tool_word_ = edge_word_ = change_word_ = nullptr;
    polynomials_.clear();
    exact_stop_once_ = false;
    for (const Word& word : block_.words)
        if (!take(word)) return false;
    return tool_words() && feed_word() && spline_degree() && carry_out() && check_use() && finish_block();
}

bool SinumerikReader::take(const Word& word) {
    if (word.is_list) return polynomial_word(word);
    return word.name.size() == 1 ? letter(word.name.front(), word) : name(word);
}

bool SinumerikReader::letter(char c, const Word& word) {
    switch (c) {
        case 'X':
            return put(Address::x, word);
        case 'Y':
            return put(Address::y, word);
        case 'Z':
            return put(Address::z, word);
        case 'I':
            return put(Address::i, word);
        case 'J':
            return put(Address::j, word);
        case 'K':
            return put(Address::k, word);
        case 'G':
            return g_word(word);
        case 'F':
            return put(Address::feed, word);
        case 'M':
            return m_word(word);
        case 'S':
            return word.extension > 1 ? event(EventKind::spindle, false, written(word)) : put(Address::speed, word);
        case 'T':
            return once(tool_word_, word);
        case 'D':
            return once(edge_word_, word);
        case 'H':
            return event(EventKind::other, false, written(word));
        default:
            return axis_letter(c, word);
    }
}

bool SinumerikReader::axis_letter(char c, const Word& word) {
    const std::size_t index = static_cast<std::size_t>(c - 'A');
    switch (control_.kind(index)) {
        case Control::Letter::rotary:
            return put(static_cast<Address>(static_cast<std::size_t>(Address::rotary_1) + control_.axis(index)), word);
        case Control::Letter::silent:
            return true;
        case Control::Letter::following:
            findings_.ignored(block_.spot(word), word.name);
            return true;
        default:
            break;
    }
    if (!control_.has_machine())
        return refuse("NC0608", word, "this axis needs a machine that has it", "-m says which");
    return refuse("NC0609", word, "the machine has no such axis",
                  "another machine (-m), or [words] following = [...] in its file for a letter that is no axis");
}

bool SinumerikReader::put(Address address, const Word& word) {
    if (!word.has_value || !word.index.empty()) return refuse("NC0614", word, "this word needs a number");
    if (said_.has(address)) return refuse("NC0607", word, "the same address twice in a block");
    said_.put(address, word);
    return true;
}

/// Keeps a word that stands once in a block and acts when all of them are known.
bool SinumerikReader::once(const Word*& kept, const Word& word) {
    if (kept) return refuse("NC0607", word, "the same word twice in a block");
    kept = &word;
    return true;
}

bool SinumerikReader::name(const Word& word) {
    const WordRule rule = rule_of_name(word.name);
    switch (rule.meaning) {
        case Meaning::address:
            return put(static_cast<Address>(rule.which), word);
        case Meaning::harmless:
            return true;
        case Meaning::ignored:
            findings_.ignored(block_.spot(word), word.name);
            return true;
        case Meaning::message:
            return event(EventKind::other, false, message_of(word));
        case Meaning::spindle_event:
            return event(EventKind::spindle, true, written(word));
        case Meaning::smoothing_cycle:
            return smoothing_cycle(word);
        case Meaning::spline_axes:
        case Meaning::polynomial_axes:
            return curve_axes(word);
        case Meaning::feed_group:
            return feed_group(word);
        case Meaning::feed_reference:
            return feed_reference(word);
        case Meaning::translate:
        case Meaning::rotate:
        case Meaning::scale:
        case Meaning::mirror:
            return once(frame_word_, word);
        case Meaning::swivel:
        case Meaning::drilling:
        case Meaning::pattern:
            return once(call_, word);
        case Meaning::modal_call:
            return once(modal_call_, word);
        default:
            return mode(rule, word);
    }
}

bool SinumerikReader::g_word(const Word& word) {
    if (!word.has_value || !is_whole(word.value) || word.extension != 0)
        return refuse("NC0204", word, "unknown word: it might change motion");
    const int number = static_cast<int>(word.value);
    return own_word('G', number) || mode(rule_of_g(number), word);
}

/// CYCLE832 chooses one of G64, G641, G642 and G645; switched off it leaves the path control that holds after a reset.
bool SinumerikReader::smoothing_cycle(const Word& word) {
    modes_.exact_stop = false;
    findings_.count("NC0659", Severity::note, block_.spot(word), "CYCLE832",
                    "CYCLE832 switches to continuous path; of its tolerances those of the plan are taken",
                    "--tip-tolerance and --orientation-tolerance; G60 behind it for exact stops");
    return true;
}

/// A word that the machine file declares. LinuxCNC's own words for TCP, which count where it declares none, do not
/// here.
bool SinumerikReader::own_word(char letter, int number) {
    constexpr int most = 100000;
    if (!options_.machine || number < 0 || number > most) return false;
    const machine::ControlWords& words = options_.machine->words;
    const Control::Role role = control_.role({letter, number * 10, 0});
    if (role == Control::Role::none) return false;
    if (role == Control::Role::ignore) return true;
    if (words.tcp_on.empty() && words.tcp_off.empty()) return false;
    set_transform(role == Control::Role::tcp_on);
    return true;
}

bool SinumerikReader::enter_group(Group group, Meaning meaning, const Word& word) {
    if (group == Group::none) return true;
    Meaning& in_force = groups_[static_cast<std::size_t>(group)];
    if (in_force != Meaning::unknown) return refuse("NC0606", word, "two words of one group in a block");
    in_force = meaning;
    return true;
}

bool SinumerikReader::mode(const WordRule& rule, const Word& word) {
    if (!enter_group(rule.group, rule.meaning, word)) return false;
    switch (rule.meaning) {
        case Meaning::harmless:
        case Meaning::dwell:
        case Meaning::suppress:
            return true;
        case Meaning::rapid:
        case Meaning::line:
        case Meaning::clockwise:
        case Meaning::counter_clockwise:
        case Meaning::via_point:
        case Meaning::tangential:
        case Meaning::spline:
        case Meaning::polynomial:
            modes_.motion = rule.meaning;
            return rule.meaning == Meaning::spline || end_spline();
        case Meaning::plane:
            modes_.normal_axis = rule.which;
            return true;
        case Meaning::offset:
            return select_offset(word);
        case Meaning::exact_stop_once:
            return exact_stop_once_ = true;
        case Meaning::exact_stop:
        case Meaning::continuous:
            modes_.exact_stop = rule.meaning == Meaning::exact_stop;
            return exact_stop_said_ = true;
        case Meaning::unit_inch:
        case Meaning::unit_inch_feed:
            stated_.inch = true;
            if (options_.units != Units::none) return true;
            modes_.unit_mm = inch_mm;
            modes_.feed_unit_mm = rule.meaning == Meaning::unit_inch_feed ? inch_mm : 1;
            return true;
        case Meaning::unit_mm:
        case Meaning::unit_mm_feed:
            stated_.mm = true;
            if (options_.units == Units::none) modes_.unit_mm = modes_.feed_unit_mm = 1;
            return true;
        case Meaning::absolute:
        case Meaning::incremental:
            modes_.absolute = rule.meaning == Meaning::absolute;
            return true;
        case Meaning::inverse_time:
        case Meaning::per_minute:
        case Meaning::per_revolution:
            if (rule.meaning != modes_.feed_kind) modes_.feed = 0;
            modes_.feed_kind = rule.meaning;
            return true;
        default:
            return orientation_mode(rule.meaning, word);
    }
}

bool SinumerikReader::orientation_mode(Meaning meaning, const Word& word) {
    switch (meaning) {
        case Meaning::transform_on:
            for (std::size_t i = 1; i < word.arguments.size(); ++i)
                if (word.arguments[i].kind != Argument::Kind::empty)
                    return refuse("NC0617", word, "TRAORI with a base orientation of the tool is not supported",
                                  "TRAORI or TRAORI(1)");
            set_transform(true);
            return true;
        case Meaning::transform_off:
            set_transform(false);
            return true;
        case Meaning::vectors_in_plane:
        case Meaning::axes_linear:
        case Meaning::second_curve:
            modes_.axes_linear = meaning == Meaning::axes_linear;
            modes_.second_curve = meaning == Meaning::second_curve;
            return true;
        case Meaning::in_workpiece:
        case Meaning::in_machine:
            modes_.in_machine = meaning == Meaning::in_machine;
            return true;
        case Meaning::euler_angles:
        case Meaning::rpy_angles:
            modes_.angles = meaning;
            return true;
        default:
            return not_supported(meaning, word);
    }
}

/// Under TRAORI the tool stands as it stood: after vectors its rotary axes stay where path building chose.
void SinumerikReader::set_transform(bool on) {
    modes_.transform = on;
    if (on && !swivelled_) law_ = program::OrientationLaw::rotary;
}

bool SinumerikReader::not_supported(Meaning meaning, const Word& word) {
    switch (meaning) {
        case Meaning::changes_motion:
            return refuse("NC0601", word, "changes motion and is not supported", "post the path without it");
        case Meaning::lathe_feed:
            return refuse("NC0601", word, "constant cutting speed is not supported", "G94 F or G95 F with S");
        case Meaning::curve:
            return refuse("NC0602", word, "this curve is not supported", "BSPLINE and POLY are; or lines and circles");
        case Meaning::lead_and_tilt:
            return refuse("NC0638", word, "LEAD, TILT and surface normals are not supported",
                          "post tool vectors: A3 B3 C3 under ORIVECT");
        case Meaning::compensation:
            return refuse("NC0603", word, "cutter radius compensation is not supported",
                          "post the path of the tool's centre, with G40");
        case Meaning::machining_cycle:
            return refuse("NC0604", word, "this cycle is not carried out", "post the path that it mills");
        default:
            return refuse("NC0204", word, "unknown word: it might change motion",
                          "a word of this control that does not can be declared in the machine file: [words] ignore");
    }
}

/// G500 takes the offset away, G54 … choose one by its name.
bool SinumerikReader::select_offset(const Word& word) {
    const int number = static_cast<int>(word.value);
    std::uint16_t chosen = 0;
    if (number != 500) {
        const auto index = index_in(program_.offsets, fmt::format("G{}", number));
        if (!index) return refuse("NC0008", word, "more offsets than are read");
        chosen = *index;
    }
    if (chosen != modes_.offset && !swivelled_) law_ = program::OrientationLaw::rotary;  // vectors count in the offset
    if (chosen != modes_.offset && swivelled_) whole_pose_needed_ = true;
    modes_.offset = chosen;
    return true;
}

bool SinumerikReader::m_word(const Word& word) {
    if (!word.has_value || !(word.value >= 0) || !is_whole(word.value))
        return refuse("NC0614", word, "an M word is a whole number");
    const int number = static_cast<int>(word.value);
    if (own_word('M', number)) return true;
    const WordRule rule = rule_of_m(number);
    switch (rule.meaning) {
        case Meaning::pause:
        case Meaning::end:
            if (!stop_ || rule.meaning == Meaning::end) stop_ = &word;
            return true;
        case Meaning::tool_change:
            return once(change_word_, word);
        case Meaning::spindle:
            return event(EventKind::spindle, true, written(word));
        case Meaning::coolant:
            return event(EventKind::coolant, false, written(word));
        default:
            return event(EventKind::other, true, written(word));
    }
}

/// T chooses the next tool and M6 puts it in, with its first cutting edge unless D stands beside T or M6. Where the
/// program never says M6, T itself changes the tool. D without them changes the edge of the tool in use.
bool SinumerikReader::tool_words() {
    if (!tool_word_ && !edge_word_ && !change_word_) return true;
    if (edge_word_ && (!edge_word_->has_value || !(edge_word_->value >= 0) || !is_whole(edge_word_->value)))
        return refuse("NC0614", *edge_word_, "a cutting edge is a whole number");
    const int edge = edge_word_ ? static_cast<int>(edge_word_->value) : 1;
    if (tool_word_ && !select_tool(*tool_word_)) return false;
    if (tool_word_) tool_.prepared_edge = edge;
    if (change_word_) {
        event(EventKind::tool, true, written(*change_word_));
        tool_.changed_by_m6 = true;
    }
    if (tool_.prepared && (change_word_ || (tool_word_ && !is_changed_by_m6()))) {
        tool_.name = *tool_.prepared;
        return use_tool(edge_word_ ? edge : tool_.prepared_edge, change_word_ ? *change_word_ : *tool_word_);
    }
    return !edge_word_ || use_tool(edge, *edge_word_);
}

bool SinumerikReader::is_changed_by_m6() {
    if (!tool_.changed_by_m6) tool_.changed_by_m6 = says_m6(text().again());
    return *tool_.changed_by_m6;
}

bool SinumerikReader::select_tool(const Word& word) {
    if (word.extension > 1) return refuse("NC0614", word, "tools of a second spindle are not supported");
    if (!word.has_text && (!word.has_value || !(word.value >= 0) || !is_whole(word.value)))
        return refuse("NC0614", word, "a tool is a whole number or a name");
    tool_.prepared = word.has_text ? word.text : fmt::format("{}", word.value);
    event(EventKind::tool, !is_changed_by_m6(), written(word));
    return true;
}

/// D1, and the habit to say D8 with T8, is the tool as the setup lists it; D0, and no tool at all, is no length. With
/// D0 the tool still hangs in the spindle.
bool SinumerikReader::use_tool(int edge, const Word& word) {
    std::string listed = tool_.name;
    if (tool_.name == "0")
        listed += " D0";
    else if (edge > 1 && fmt::format("{}", edge) != tool_.name)
        listed += fmt::format(" D{}", edge);
    const auto in_spindle = index_in(program_.tools, listed);
    const auto counted = edge == 0 ? index_in(program_.tools, tool_.name + " D0") : in_spindle;
    if (!in_spindle || !counted) return refuse("NC0008", word, "more tools than are read");
    tool_.in_spindle = *in_spindle;
    tool_.index = *counted;
    return true;
}

/// FGROUP: F is the speed along X, Y and Z, and along the rotary axes that are named, at FGREF's radius.
bool SinumerikReader::feed_group(const Word& word) {
    modes_.rotary_in_feed = false;
    int linear = 0;
    for (const Argument& argument : word.arguments) {
        const char c = argument.text.size() == 1 ? upper(argument.text.front()) : ' ';
        const bool rotary = is_letter(c) && control_.kind(static_cast<std::size_t>(c - 'A')) == Control::Letter::rotary;
        linear += c >= 'X' && c <= 'Z' ? 1 : 0;
        modes_.rotary_in_feed = modes_.rotary_in_feed || rotary;
        if (!rotary && !(c >= 'X' && c <= 'Z'))
            return refuse("NC0627", word, "FGROUP takes the letters of this machine's axes");
    }
    if (!word.arguments.empty() && linear != 3)
        return refuse("NC0627", word, "FGROUP without one of X, Y and Z is not supported", "FGROUP(X,Y,Z)");
    return true;
}

bool SinumerikReader::feed_reference(const Word& word) {
    const char c = word.index.size() == 1 ? upper(word.index.front()) : ' ';
    if (!is_letter(c) || control_.kind(static_cast<std::size_t>(c - 'A')) != Control::Letter::rotary)
        return refuse("NC0627", word, "FGREF takes the letter of a rotary axis of this machine");
    if (!word.has_value || !(word.value > 0)) return refuse("NC0627", word, "a radius must be positive");
    modes_.reference_mm[control_.axis(static_cast<std::size_t>(c - 'A'))] = word.value * modes_.unit_mm;
    return true;
}

/// F and S; beside G4 they are its time.
bool SinumerikReader::feed_word() {
    if (groups_[static_cast<std::size_t>(Group::once)] == Meaning::dwell) return true;
    if (said_.has(Address::speed)) {
        const double speed = said_[Address::speed];
        if (!(speed >= 0))
            return refuse("NC0614", spot(Address::speed), "a speed is not negative", fmt::format("S{}", speed));
        modes_.spindle_rpm = speed;
        event(EventKind::spindle, false, fmt::format("S{}", speed));
        said_.use(Address::speed);
    }
    if (!said_.has(Address::feed)) return true;
    const double feed = said_[Address::feed] * (modes_.feed_kind == Meaning::inverse_time ? 1 : modes_.feed_unit_mm);
    if (!(feed > 0) || !std::isfinite(60 / feed))
        return refuse("NC0206", spot(Address::feed), "a feed must be positive",
                      fmt::format("F{}", said_[Address::feed]));
    if (modes_.unit_mm != modes_.feed_unit_mm)
        findings_.count("NC0656", Severity::note, spot(Address::feed), "F",
                        "under G70 lengths are inches and F is mm/min", "G700 takes both in inches");
    modes_.feed = feed;
    said_.use(Address::feed);
    return true;
}

bool SinumerikReader::carry_out() {
    const bool moves =
        groups_[static_cast<std::size_t>(Group::once)] != Meaning::dwell && !frame_word_ && !modal_call_ && !call_;
    if (!polynomials_.empty() && (!moves || modes_.motion != Meaning::polynomial))
        return refuse("NC0634", *polynomials_.front(), "PO needs POLY");
    if (groups_[static_cast<std::size_t>(Group::once)] == Meaning::dwell) return dwell();
    if ((frame_word_ || call_ || modal_call_) && !end_spline()) return false;
    if (frame_word_) return frame_statement();
    if (modal_call_) return modal_call();
    if (call_) return call(*call_);
    return motion();
}

bool SinumerikReader::dwell() {
    said_.use(Address::feed);
    said_.use(Address::speed);
    const bool seconds = said_.has(Address::feed), turns = said_.has(Address::speed);
    if (seconds == turns)
        return refuse("NC0625", block_.place, "G4 needs its time: F in seconds or S in turns", {}, "G4 F2");
    const double count = said_[seconds ? Address::feed : Address::speed];
    if (!(count >= 0) || (turns && !(modes_.spindle_rpm > 0)))
        return refuse("NC0625", spot(seconds ? Address::feed : Address::speed),
                      turns ? "turns of a spindle whose speed is not known" : "a time is not negative");
    event(EventKind::dwell, true, fmt::format("G4 {}{}", seconds ? 'F' : 'S', count),
          seconds ? count : count * 60 / modes_.spindle_rpm);
    return true;
}

/// An address that nothing made use of might have been meant to change motion.
bool SinumerikReader::check_use() {
    const auto unused = said_.left_over();
    if (!unused) return true;
    return refuse("NC0613", spot(*unused), "this word has no use in this block");
}

bool SinumerikReader::finish_block() {
    if (!stop_) return true;
    event(EventKind::stop, true, written(*stop_));
    finished_ = rule_of_m(static_cast<int>(stop_->value)).meaning == Meaning::end;
    return true;
}

}  // namespace trunnion::nc::sinumerik

namespace trunnion::nc {

Result<std::unique_ptr<BlockReader>> open_sinumerik(const ProgramText& text, std::string_view file_name,
                                                    const ReadOptions& options) {
    auto control = Control::make(options.machine);
    if (!control) return fail(std::move(control.error()));
    return std::make_unique<sinumerik::SinumerikReader>(text, file_name, options, std::move(*control));
}

}  // namespace trunnion::nc
