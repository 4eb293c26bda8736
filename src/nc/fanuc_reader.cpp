#include "detail/fanuc_reader.hpp"

#include <algorithm>

namespace trunnion::nc::fanuc {

using program::EventKind;

namespace {

constexpr double dwell_unit_s = 0.001;  ///< of P without a point
constexpr int most_of_a_number = 99999999;

/// As people write it, `G43.4`, `M98`.
std::string written(const Word& word) {
    return fmt::format("{}{}", word.letter, word.value);
}

bool is_length_or_angle(char letter) {
    return std::string_view("XYZIJKRQUVWABC").contains(letter);
}

}  // namespace

FanucReader::FanucReader(const ProgramText& text, std::string_view file_name, const ReadOptions& options,
                         Control control)
    : BlockReader(file_name, options, Dialect::fanuc),
      control_(std::move(control)),
      interpreter_(text, file_name, findings_, *this, {.lines = options.most_repeated_lines}) {
    program_.offsets.emplace_back("G54");  // in force when a program starts
    modes_.offset = 1;
    if (options.units == Units::inch) modes_.unit_mm = modes_.feed_unit_mm = inch_mm;
    position_mm_.setConstant(unknown);
    programmed_mm_.setConstant(unknown);
    rotary_rad_.fill(unknown);
}

BlockReader::Step FanucReader::read_block() {
    if (finished_) return Step::end;
    switch (interpreter_.next(block_)) {
        case Interpreter::Step::end:
            return Step::end;
        case Interpreter::Step::refused:
            return Step::refused;
        case Interpreter::Step::block:
            break;
    }
    if (!block()) return Step::refused;
    if (!interpreter_.program_name().empty()) program_.name = interpreter_.program_name();
    return Step::block;
}

/// What the control keeps in variables and is known here: units, distance, plane, and where the last block ended.
ControlParameters::Answer FanucReader::read(const ParameterReference& parameter, ParameterValue& value) const {
    constexpr int first_position = 5001, first_of_control = 1000, last_of_control = 89999;
    const int number = parameter.number;
    if (number < first_of_control || number > last_of_control) return Answer::not_its_own;
    const bool is_position = number >= first_position && number < first_position + 3;
    if (is_position && !std::isnan(programmed_mm_[number - first_position])) {
        value = programmed_mm_[number - first_position] / modes_.unit_mm;
        return Answer::known;
    }
    switch (number) {
        case 4002:
            value = 19 - modes_.normal_axis;
            return Answer::known;
        case 4003:
            value = modes_.absolute ? 90 : 91;
            return Answer::known;
        case 4006:
            value = modes_.unit_mm == 1 ? 21 : 20;
            return Answer::known;
        default:
            return Answer::unknown;
    }
}

/// Modes first, then the tool, then motion, then what ends the program, in whatever order the words stand.
bool FanucReader::block() {
    said_.clear();
    groups_.fill(Meaning::unknown);
    exact_stop_once_ = loose_letters_ = false;
    if (!sort_words()) return false;
    if (data_mode_) return true;
    const bool goes_on =
        said_.has('K') && std::ranges::all_of(groups_, [](Meaning m) { return m == Meaning::unknown; });
    if (!goes_on && !end_nurbs()) return false;
    return modes() && speed_and_tool() && carry_out() && check_use() && stops();
}

// --------------------------------------------------------------------------------------------------------------- words

bool FanucReader::sort_words() {
    for (const Word& word : block_.words) {
        const bool is_code = word.letter == 'G' || word.letter == 'M';
        if (data_mode_ && !(word.letter == 'G' && word.value == 11)) continue;
        if (is_code ? !sort_code(word) : !sort_letter(word)) return false;
    }
    return true;
}

bool FanucReader::sort_letter(const Word& word) {
    if (word.letter == 'O') return refuse("NC0802", word, "a program number stands at the start of a line");
    if (said_.has(word.letter)) return refuse("NC0824", word, "the same letter twice in a block");
    switch (control_.kind(Letters::index(word.letter))) {
        case Control::Letter::silent:
            return true;
        case Control::Letter::following:
            findings_.ignored(block_.spot(word), std::string_view(&word.letter, 1));
            return true;
        default:
            break;
    }
    if (is_length_or_angle(word.letter)) tell_number_without_point(word);
    said_.put(word);
    return true;
}

void FanucReader::tell_number_without_point(const Word& word) {
    if (word.has_point || word.value == 0) return;
    findings_.count("NC0864", Severity::note, block_.spot(word), "point",
                    "numbers without a decimal point are taken as whole mm, inches and degrees",
                    "where this control takes them as increments of 0.001, post them with a point");
}

bool FanucReader::sort_code(const Word& word) {
    const int tenths = tenths_of(word);
    if (tenths < 0) return refuse("NC0204", word, "no such word");
    if (word.letter == 'G' && word.value == 11) data_mode_ = false;
    if (own_word(word, tenths)) return true;
    const WordRule rule = word.letter == 'G' ? rule_of_g(tenths) : rule_of_m(tenths);
    switch (rule.meaning) {
        case Meaning::harmless:
        case Meaning::unknown:
        case Meaning::changes_motion:
        case Meaning::compensation:
        case Meaning::tcp_word:
            return not_supported(rule, word) && enter_group(rule, word);
        case Meaning::ignored:
            findings_.ignored(block_.spot(word), written(word));
            loose_letters_ = true;
            return enter_group(rule, word);
        case Meaning::exact_stop_once:
            return exact_stop_once_ = true;
        case Meaning::spindle:
            return event(EventKind::spindle, true, written(word));
        case Meaning::coolant:
            return event(EventKind::coolant, false, written(word));
        case Meaning::event:
            loose_letters_ = true;
            return event(EventKind::other, true, written(word));
        default:
            return enter_group(rule, word);
    }
}

/// A word that the machine file declares.
bool FanucReader::own_word(const Word& word, int tenths) {
    const Control::Role role = control_.role({word.letter, tenths, 0});
    if (role == Control::Role::none) return false;
    if (role == Control::Role::ignore)
        loose_letters_ = true;
    else
        modes_.own_tcp = role == Control::Role::tcp_on;
    return true;
}

bool FanucReader::not_supported(const WordRule& rule, const Word& word) {
    switch (rule.meaning) {
        case Meaning::harmless:
            return true;
        case Meaning::compensation:
            return refuse("NC0822", word, "cutter radius compensation is not supported",
                          "post the path of the tool's centre, with G40");
        case Meaning::tcp_word:
            return refuse("NC0851", word, "on several controls this word switches tool-centre-point programming",
                          "the machine file says what it does here: [words] tcp_on, tcp_off or ignore");
        case Meaning::changes_motion:
            return refuse("NC0821", word, "changes motion and is not supported", "post the path without it");
        default:
            return refuse("NC0204", word, "unknown word: it might change motion",
                          "a word of this control that does not can be declared in the machine file: [words] ignore");
    }
}

bool FanucReader::enter_group(const WordRule& rule, const Word& word) {
    if (rule.meaning == Meaning::harmless && rule.group == Group::once) return true;
    const auto group = static_cast<std::size_t>(rule.group);
    const bool same = groups_[group] == rule.meaning && codes_[group].value == word.value;
    if (groups_[group] != Meaning::unknown && !same)
        return refuse("NC0823", word, "two words of one group in a block",
                      fmt::format("it contradicts {}", written(codes_[group])));
    groups_[group] = rule.meaning;
    codes_[group] = word;
    return true;
}

bool FanucReader::whole(const Word& word, int most, int& number) {
    if (!(word.value >= 0 && word.value <= most && word.value == std::floor(word.value)))
        return refuse("NC0829", word, "a whole number is needed here, not below 0");
    number = static_cast<int>(word.value);
    return true;
}

// --------------------------------------------------------------------------------------------------------------- modes

bool FanucReader::modes() {
    units();
    if (const Meaning kind = asked(Group::feed_mode); kind != Meaning::unknown) {
        if (kind != modes_.feed_kind) modes_.feed = 0;
        modes_.feed_kind = kind;
    }
    if (asked(Group::plane) == Meaning::plane) modes_.normal_axis = 19 - static_cast<int>(code_of(Group::plane).value);
    if (const Meaning distance = asked(Group::distance); distance != Meaning::unknown)
        modes_.absolute = distance == Meaning::absolute;
    if (const Meaning control = asked(Group::path_control);
        control == Meaning::exact_stop || control == Meaning::continuous)
        modes_.exact_stop = control == Meaning::exact_stop;
    if (const Meaning level = asked(Group::return_level); level != Meaning::unknown)
        modes_.return_to_r = level == Meaning::return_r;
    return feed() && offset();
}

void FanucReader::units() {
    const Meaning unit = asked(Group::units);
    if (unit == Meaning::unknown) return;
    (unit == Meaning::mm ? stated_.mm : stated_.inch) = true;
    if (options_.units != Units::none) return;
    modes_.unit_mm = unit == Meaning::mm ? 1 : inch_mm;
    constexpr double increment_mm = 0.001, increment_inch = 0.0001;
    interpreter_.set_least_increment(unit == Meaning::mm ? increment_mm : increment_inch);
}

bool FanucReader::feed() {
    said_.use("F");
    if (modes_.feed_kind == Meaning::inverse_time) modes_.feed = 0;
    if (!said_.has('F')) return true;
    const double feed = said_['F'];
    if (!(feed > 0) || !std::isfinite(60 / feed)) return refuse("NC0206", said_.word('F'), "a feed must be positive");
    modes_.feed = feed;
    modes_.feed_unit_mm = modes_.unit_mm;
    return true;
}

bool FanucReader::offset() {
    const Meaning kind = asked(Group::offset);
    if (kind == Meaning::unknown) return true;
    const Word& word = code_of(Group::offset);
    std::string name = written(word);
    if (kind == Meaning::numbered_offset || (said_.has('P') && word.value == 54)) {
        int number = 0;
        if (!said_.has('P')) return refuse("NC0829", word, "the number of the work offset is missing", "P1");
        if (!whole(said_.word('P'), 999, number)) return false;
        said_.use("P");
        name = fmt::format("{} P{}", word.value == 54 ? "G54.1" : name, number);
    }
    const auto index = index_in(program_.offsets, name);
    if (!index) return refuse("NC0008", word, "more offsets than are read");
    if (*index != modes_.offset && plane_said_) whole_pose_needed_ = true;
    modes_.offset = *index;
    return true;
}

// --------------------------------------------------------------------------------------------------- speed and tool

bool FanucReader::speed_and_tool() {
    said_.use("STHDN");
    if (said_.has('S')) {
        if (!(said_['S'] >= 0)) return refuse("NC0829", said_.word('S'), "a speed is not negative");
        if (asked(Group::once) != Meaning::preset) {
            modes_.spindle_rpm = said_['S'];
            event(EventKind::spindle, false, fmt::format("S{}", said_['S']));
        }
    }
    if (said_.has('T')) {
        int number = 0;
        if (asked(Group::once) != Meaning::data) {
            if (!whole(said_.word('T'), most_of_a_number, number)) return false;
            prepared_tool_ = fmt::format("{}", number);
            event(EventKind::tool, false, fmt::format("T{}", number));
        }
    }
    if (asked(Group::tool_change) == Meaning::tool_change && !change_tool()) return false;
    return length();
}

bool FanucReader::change_tool() {
    event(EventKind::tool, true, written(code_of(Group::tool_change)));
    if (!prepared_tool_) return true;
    tool_ = *prepared_tool_;
    const auto index = index_in(program_.tools, tool_);
    if (!index) return refuse("NC0008", block_.place(), "more tools than are read");
    in_spindle_ = *index;
    return true;
}

/// G43 and the like take the length of the tool that H names, H0 none; without them none counts. A program that has
/// called no tool has that of the setup.
bool FanucReader::length() {
    const Meaning kind = asked(Group::length);
    if (kind != Meaning::unknown) modes_.length = kind;
    if (said_.has('H')) {
        int number = 0;
        if (!whole(said_.word('H'), most_of_a_number, number)) return false;
        modes_.length_number = number;
    }
    const bool counts = modes_.length != Meaning::no_length;
    if (counts && !modes_.length_number)
        return refuse("NC0839", code_of(Group::length), "which tool's length counts is not said", "H with its number");
    std::string name = counts ? fmt::format("{}", *modes_.length_number) : tool_;
    if (counts ? *modes_.length_number == 0 : !tool_.empty()) name = tool_ + " D0";
    const auto index = index_in(program_.tools, name);
    if (!index) return refuse("NC0008", block_.place(), "more tools than are read");
    length_tool_ = *index;
    if (kind == Meaning::tcp_rotary && !swivelled_) law_ = program::OrientationLaw::rotary;
    return true;
}

// ----------------------------------------------------------------------------------------------------------- carry out

bool FanucReader::carry_out() {
    if (asked(Group::mirror) != Meaning::unknown) return mirror(asked(Group::mirror) == Meaning::mirror);
    switch (asked(Group::turned)) {
        case Meaning::rotation:
            return rotation();
        case Meaning::tilted_plane:
            return tilted_plane();
        case Meaning::no_rotation:
            if (!no_rotation()) return false;
            break;
        default:
            break;
    }
    if (const Meaning dynamic = asked(Group::dynamic); dynamic != Meaning::unknown)
        if (!dynamic_offset(dynamic == Meaning::dynamic_offset)) return false;
    if (asked(Group::cycle) == Meaning::no_cycle) cycle_.number = 0;
    switch (asked(Group::once)) {
        case Meaning::dwell:
            return dwell();
        case Meaning::data:
            return data_setting();
        case Meaning::reference:
            return reference();
        case Meaning::local_shift:
            return local_shift();
        case Meaning::preset:
            return preset();
        case Meaning::no_preset:
            preset_mm_.setZero();
            frames_changed();
            return true;
        case Meaning::swivel:
            return swivel() && motion();
        default:
            return motion();
    }
}

/// X and U are seconds; P is milliseconds, or seconds where it has a point.
bool FanucReader::dwell() {
    const char letter = said_.has('P') ? 'P' : said_.has('X') ? 'X' : 'U';
    said_.use("PXU");
    if (!said_.has(letter) || !(said_[letter] >= 0))
        return refuse("NC0831", block_.place(), "a dwell needs its time", {}, "G4 P500 or G4 X0.5 is half a second");
    const bool thousandths = letter == 'P' && !said_.word('P').has_point;
    return event(EventKind::dwell, true, fmt::format("G4 {}{}", letter, said_[letter]),
                 said_[letter] * (thousandths ? dwell_unit_s : 1));
}

/// G10: work offsets are carried out, the tool table and parameters are those of the setup and the control.
bool FanucReader::data_setting() {
    const Word& word = code_of(Group::once);
    constexpr int coordinates = 2, numbered_coordinates = 20, parameters = 50, other_parameters = 52;
    int kind = 10, number = 0;
    if (said_.has('L') && !whole(said_.word('L'), 99, kind)) return false;
    if (said_.has('P') && !whole(said_.word('P'), most_of_a_number, number)) return false;
    if (kind == coordinates || kind == numbered_coordinates) return offset_data(kind == coordinates ? number : -number);
    said_.use("LPRZXYQABCT");
    if (kind == parameters || kind == other_parameters) {
        data_mode_ = true;
        findings_.ignored(block_.spot(word), fmt::format("G10 L{}", kind));
        return true;
    }
    if (kind < 10 || kind > 13)
        return refuse("NC0840", word, "this kind of G10 is not supported", "L2, L20, L10 … L13, L50");
    findings_.count("NC0866", Severity::warning, block_.spot(word), "G10",
                    "the tool table is that of the setup: lengths set by G10 are left out",
                    "[tools] of the setup file");
    return true;
}

/// The first values of an offset are where the setup has it; others later on shift it from there. Below 0: G54.1 P.
bool FanucReader::offset_data(int number) {
    const Word& word = code_of(Group::once);
    if (number == 0 || number > 6)
        return refuse("NC0840", word, "the offset of all offsets (P0) and P above 6 are not supported",
                      "L2 P1 … P6 for G54 … G59, L20 for G54.1");
    const auto offset =
        index_in(program_.offsets, number > 0 ? fmt::format("G{}", 53 + number) : fmt::format("G54.1 P{}", -number));
    if (!offset) return refuse("NC0008", word, "more offsets than are read");
    for (std::size_t i = 0; i < 26; ++i) {
        const char letter = static_cast<char>('A' + i);
        if (control_.kind(i) == Control::Letter::rotary && said_.has(letter) && said_[letter] != 0)
            return refuse("NC0840", said_.word(letter), "work offsets of rotary axes are not supported",
                          "write the angles with the offset worked in");
    }
    said_.use_mask(control_.axis_letters());
    said_.use("LPABC");
    Eigen::Vector3d values;
    if (!linear_words(values, unknown)) return false;
    const auto known = offset_data_.find(*offset);
    const bool used = is_moved_in(*offset);
    Eigen::Vector3d& shift = offset_shift_mm_.try_emplace(*offset, Eigen::Vector3d::Zero()).first->second;
    if (modes_.absolute && known == offset_data_.end()) {
        if (used) return refuse("NC0840", word, "a work offset is set after it was moved in: by how much is not known");
        offset_data_[*offset] = values;
        findings_.count("NC0865", Severity::warning, block_.spot(word), program_.offsets[*offset],
                        "the program sets this work offset: where it lies is taken from the setup",
                        "[offsets] of the setup file");
        return true;
    }
    for (Eigen::Index i = 0; i < 3; ++i) {
        if (std::isnan(values[i])) continue;
        const double by = modes_.absolute ? values[i] - known->second[i] : values[i];
        if (std::isnan(by))
            return refuse("NC0840", word, "a work offset is changed of which not all values were set before");
        shift[i] += by;
        if (known != offset_data_.end()) known->second[i] += by;
    }
    frames_changed();
    return true;
}

/// A letter that nothing made use of might have been meant to change motion.
bool FanucReader::check_use() {
    if (loose_letters_) said_.use("PQREKLIJ");
    const auto unused = said_.left_over();
    if (!unused) return true;
    const Word& word = said_.word(*unused);
    if (std::string_view("ABCUVWE").contains(*unused)) return absent_axis(word);
    return refuse("NC0825", word, "the letter has no use in this block");
}

bool FanucReader::absent_axis(const Word& word) {
    if (!control_.has_machine())
        return refuse("NC0826", word, "this axis needs a machine that has it", "-m says which");
    return refuse("NC0827", word, "the machine has no such axis",
                  "another machine (-m), or [words] following = [...] in its file for a letter that is no axis");
}

bool FanucReader::stops() {
    const Meaning stop = asked(Group::stop);
    if (stop == Meaning::unknown) return true;
    event(EventKind::stop, true, written(code_of(Group::stop)));
    finished_ = stop == Meaning::end;
    return true;
}

}  // namespace trunnion::nc::fanuc

namespace trunnion::nc {

Result<std::unique_ptr<BlockReader>> open_fanuc(const ProgramText& text, std::string_view file_name,
                                                const ReadOptions& options) {
    auto control = Control::make(options.machine);
    if (!control) return fail(std::move(control.error()));
    if (text.view().starts_with("%PM") || text.view().starts_with("%MM"))
        return fail(Diagnostic{.code = "NC0801",
                               .text = "MillPlus programs are not read: G70, G93 and B5= mean other things there",
                               .place = {.file = std::string(file_name), .line = 1, .column = 1},
                               .value = std::string(text.view().substr(0, 3)),
                               .hint = "post the program for another control, or as CL data"});
    return std::make_unique<fanuc::FanucReader>(text, file_name, options, std::move(*control));
}

}  // namespace trunnion::nc
