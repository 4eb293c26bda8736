#include "detail/heidenhain_reader.hpp"

#include <algorithm>
#include <bit>

namespace trunnion::nc::heidenhain {

using program::EventKind;

namespace {

constexpr double largest_number = 1e9;  ///< of words that are whole numbers
constexpr std::size_t most_functions = 100;

bool is_whole(double value) {
    return value == std::floor(value) && std::abs(value) < largest_number;
}

std::string written(const MWord& word) {
    return fmt::format("M{}", word.number);
}

/// Address of X Y Z, NX NY NZ, TX TY TZ by their last letter.
Address along(Address first, char letter) {
    return static_cast<Address>(static_cast<int>(first) + (letter - 'X'));
}

}  // namespace

std::optional<Address> Addresses::other_than(std::uint32_t allowed) const {
    const std::uint32_t rest = said_ & ~allowed;
    if (rest == 0) return {};
    return static_cast<Address>(std::countr_zero(rest));
}

HeidenhainReader::HeidenhainReader(const ProgramText& text, std::string_view file_name, const ReadOptions& options,
                                   Control control)
    : BlockReader(file_name, options, Dialect::heidenhain),
      interpreter_(text, file_name, findings_, options.most_repeated_lines),
      control_(std::move(control)) {
    position_mm_.setConstant(unknown);
    programmed_mm_.setConstant(unknown);
    centre_mm_.setConstant(unknown);
    rotary_rad_.fill(unknown);
}

BlockReader::Step HeidenhainReader::read_block() {
    if (finished_) return Step::end;
    switch (interpreter_.next()) {
        case Interpreter::Step::end:
            return Step::end;
        case Interpreter::Step::refused:
            return Step::refused;
        case Interpreter::Step::block:
            break;
    }
    return block() ? Step::block : Step::refused;
}

bool HeidenhainReader::block() {
    said_.clear();
    m_words_.clear();
    turning_ = Turning::not_said;
    feed_word_ = FeedWord::none;
    machine_datum_ = false;
    to_plane_ = 0;
    first_word_ = cursor().next_index();
    const std::string_view name = cursor().name();
    return block_of_kind(kind_of_block(name), name);
}

bool HeidenhainReader::block_of_kind(BlockKind kind, std::string_view name) {
    switch (kind) {
        case BlockKind::words:
            cursor().go_back_to(first_word_);
            return path_block(kind);
        case BlockKind::line:
        case BlockKind::line_with_vector:
        case BlockKind::polar_line:
        case BlockKind::circle:
        case BlockKind::circle_by_radius:
        case BlockKind::tangential:
        case BlockKind::polar_circle:
            return path_block(kind);
        case BlockKind::centre:
            return centre();
        case BlockKind::rounding:
            return rounding();
        case BlockKind::chamfer:
            return refuse("NC0719", first_word_, "chamfers are not supported", {}, "post the line that CHF stands for");
        case BlockKind::begin:
            return begin();
        case BlockKind::blank:
            return true;  // the blank moves nothing
        case BlockKind::tool:
            return tool();
        case BlockKind::cycle:
            return cycle();
        case BlockKind::plane:
            return plane();
        case BlockKind::function:
            return function_block();
        case BlockKind::shift:
            return trans();
        case BlockKind::stop:
            return stop_block();
        case BlockKind::contour:
            return refuse("NC0703", first_word_, "a path that the control works out itself is not supported", name,
                          "post lines and circles");
        case BlockKind::other_control:
            return refuse("NC0701", first_word_, "changes motion and is not supported", name);
        case BlockKind::unknown:
            break;
    }
    return refuse("NC0204", first_word_, "unknown block: it might change motion",
                  name.empty() ? cursor().rest().substr(0, 12) : name);
}

bool HeidenhainReader::begin() {
    (interpreter_.inch() ? stated_.inch : stated_.mm) = true;
    return true;
}

bool HeidenhainReader::want_end() {
    if (cursor().at_end()) return true;
    return refuse("NC0204", cursor().index(), "unknown word: it might change motion", cursor().rest().substr(0, 12));
}

// ------------------------------------------------------------------------------------------------- words of a path

bool HeidenhainReader::path_block(BlockKind kind) {
    if (!path_words() || !start_functions() || !keep_feed()) return false;
    bool moved = true;
    switch (kind) {
        case BlockKind::line:
        case BlockKind::words:
        case BlockKind::line_with_vector:
            moved = line(kind == BlockKind::line_with_vector);
            break;
        default:
            moved = circle(kind);
            break;
    }
    return moved && end_functions();
}

bool HeidenhainReader::path_words() {
    while (!cursor().at_end()) {
        const std::size_t place = cursor().index();
        if (!word(cursor().name(), place)) return false;
    }
    return true;
}

/// Words of a block that has neither feed nor M words.
bool HeidenhainReader::numbers_alone(std::uint32_t allowed) {
    if (!path_words() || !check_addresses(allowed)) return false;
    if (m_words_.empty() && feed_word_ == FeedWord::none && turning_ == Turning::not_said) return true;
    return refuse("NC0711", first_word_, "a feed, DR or M word has no use in this block");
}

bool HeidenhainReader::word(std::string_view name, std::size_t place) {
    if (name.empty()) return refuse("NC0202", place, "not expected here", cursor().rest().substr(0, 1));
    if (name.size() == 1) {
        switch (name.front()) {
            case 'X':
            case 'Y':
            case 'Z':
                return put(along(Address::x, name.front()), false, place);
            case 'F':
                return feed_word(place);
            case 'M':
                return m_word(place);
            case 'R':
                return radius_word(place);
            default:
                return axis_word(name.front(), false, place);
        }
    }
    if (name.size() == 2 && name.front() == 'I') {
        const char letter = name.back();
        return letter >= 'X' && letter <= 'Z' ? put(along(Address::x, letter), true, place)
                                              : axis_word(letter, true, place);
    }
    return long_word(name, place);
}

bool HeidenhainReader::long_word(std::string_view name, std::size_t place) {
    const bool of_vector = name.size() == 2 && name.back() >= 'X' && name.back() <= 'Z';
    if (of_vector && name.front() == 'N') return put(along(Address::nx, name.back()), false, place);
    if (of_vector && name.front() == 'T') return put(along(Address::tx, name.back()), false, place);
    if (name == "DR") return turning_word(place);
    if (name == "PA" || name == "IPA") return put(Address::polar_angle, name.size() == 3, place);
    if (name == "PR" || name == "IPR") return put(Address::polar_radius, name.size() == 3, place);
    if (name == "RL" || name == "RR")
        return refuse("NC0702", place, "cutter radius compensation is not supported", name,
                      "post the path of the tool's centre, with R0");
    if (name.starts_with('F')) return feed_with_suffix(name, place);
    return refuse("NC0204", place, "unknown word: it might change motion", name);
}

bool HeidenhainReader::axis_word(char letter, bool incremental, std::size_t place) {
    if (!is_letter(letter)) return refuse("NC0202", place, "not expected here", std::string_view(&letter, 1));
    const std::size_t index = static_cast<std::size_t>(letter - 'A');
    if (modes_.spatial_angles && letter >= 'A' && letter <= 'C')
        return put(static_cast<Address>(static_cast<int>(Address::rotary_1) + (letter - 'A')), incremental, place);
    if (control_.kind(index) != Control::Letter::rotary) return letter_without_axis(letter, place);
    const std::size_t axis = control_.axis(index);
    const auto address = static_cast<Address>(static_cast<std::size_t>(Address::rotary_1) + axis);
    if (said_.has(address)) return refuse("NC0706", place, "the same word twice in a block");
    double value = 0;
    int position = -1;
    if (!values().rotary_value(value, position)) return false;
    if (position >= 0 && position != letter - 'A')
        return refuse("NC0732", place, "Q120, Q121 and Q122 are the positions of A, B and C");
    if (position >= 0) to_plane_ |= 1u << axis;
    said_.put(address, value, incremental, place);
    return true;
}

bool HeidenhainReader::letter_without_axis(char letter, std::size_t place) {
    double value = 0;
    const Control::Letter kind = control_.kind(static_cast<std::size_t>(letter - 'A'));
    if (kind == Control::Letter::silent || kind == Control::Letter::following) {
        if (!values().value(value)) return false;
        if (kind == Control::Letter::following) findings_.ignored(cursor().spot(place), std::string_view(&letter, 1));
        return true;
    }
    if (letter == 'S') return speed_of_spindle();
    constexpr std::string_view axes = "ABCUVW";
    if (axes.find(letter) == axes.npos)
        return refuse("NC0204", place, "unknown word: it might change motion", std::string_view(&letter, 1));
    if (!control_.has_machine())
        return refuse("NC0707", place, "this axis needs a machine that has it", std::string_view(&letter, 1),
                      "-m says which");
    return refuse("NC0708", place, "the machine has no such axis", std::string_view(&letter, 1),
                  "another machine (-m)");
}

bool HeidenhainReader::put(Address address, bool incremental, std::size_t place) {
    if (said_.has(address)) return refuse("NC0706", place, "the same word twice in a block");
    double value = 0;
    if (!values().value(value)) return false;
    said_.put(address, value, incremental, place);
    return true;
}

/// R0, or the radius of CR.
bool HeidenhainReader::radius_word(std::size_t place) {
    const std::string_view rest = cursor().rest();
    const bool off = rest.starts_with('0') && (rest.size() == 1 || is_blank(rest[1]));
    if (off) {
        cursor().skip(1);
        return true;
    }
    const bool paraxial = rest.size() == 1 || (rest.size() > 1 && is_blank(rest[1]));
    if (paraxial)
        return refuse("NC0702", place, "cutter radius compensation is not supported", "R",
                      "post the path of the tool's centre, with R0");
    return put(Address::radius, false, place);
}

bool HeidenhainReader::turning_word(std::size_t place) {
    if (turning_ != Turning::not_said) return refuse("NC0706", place, "the same word twice in a block");
    const bool left = cursor().take('+');
    if (!left && !cursor().take('-')) return refuse("NC0717", place, "DR has a sign: DR+ or DR-");
    turning_ = left ? Turning::counter_clockwise : Turning::clockwise;
    return true;
}

// ------------------------------------------------------------------------------------------------- feed and speed

/// Behind an F: MAX, AUTO or a value.
bool HeidenhainReader::feed_words(FeedWord& kind, double& value, std::size_t place) {
    if (kind != FeedWord::none) return refuse("NC0706", place, "the same word twice in a block");
    if (cursor().take_word("MAX")) return kind = FeedWord::rapid, true;
    if (cursor().take_word("AUTO")) return kind = FeedWord::of_tool_call, true;
    kind = FeedWord::value;
    return values().value(value);
}

bool HeidenhainReader::feed_word(std::size_t place) {
    return feed_words(feed_word_, feed_value_, place);
}

bool HeidenhainReader::feed_with_suffix(std::string_view name, std::size_t place) {
    if (name == "FZ" || name == "FT" || name == "FMAXT")
        return refuse("NC0723", place, "a feed per tooth, or by time, is not supported", name, "post F in mm/min");
    if (name != "FMAX" && name != "FAUTO" && name != "FU")
        return refuse("NC0204", place, "unknown word: it might change motion", name);
    if (feed_word_ != FeedWord::none) return refuse("NC0706", place, "the same word twice in a block");
    feed_word_ = name == "FMAX" ? FeedWord::rapid : name == "FAUTO" ? FeedWord::of_tool_call : FeedWord::per_turn;
    return name != "FU" || values().value(feed_value_);
}

/// FMAX is of its block alone; the others stay.
bool HeidenhainReader::keep_feed() {
    if (feed_word_ == FeedWord::none || feed_word_ == FeedWord::rapid) return true;
    if (feed_word_ == FeedWord::of_tool_call) {
        modes_.feed = modes_.tool_call_feed;
        modes_.feed_per_turn = false;
        return true;
    }
    modes_.feed_per_turn = feed_word_ == FeedWord::per_turn || modes_.per_turn;
    const double feed = feed_value_ * (modes_.feed_per_turn ? unit_mm() : feed_unit_mm());
    if (!(feed > 0) || !std::isfinite(60 / feed))
        return refuse("NC0206", first_word_, "a feed must be positive", fmt::format("F{}", feed_value_));
    if (inch() && !modes_.feed_per_turn)
        findings_.count("NC0756", Severity::note, spot_of_motion(), "F",
                        "F of a program in inches counts in tenths of an inch a minute, as on the control",
                        "--feed-override 1000% where the post wrote whole inches");
    modes_.feed = feed;
    return true;
}

bool HeidenhainReader::speed_of_spindle() {
    const std::size_t place = cursor().index();
    double speed = 0;
    if (!values().value(speed)) return false;
    if (!(speed >= 0)) return refuse("NC0711", place, "a speed is not negative", fmt::format("S{}", speed));
    modes_.spindle_rpm = speed;
    return event(EventKind::spindle, false, fmt::format("S{}", speed));
}

// ------------------------------------------------------------------------------------------------- M functions

bool HeidenhainReader::m_word(std::size_t place) {
    double number = 0;
    if (!values().value(number)) return false;
    if (!(number >= 0) || !is_whole(number)) return refuse("NC0711", place, "an M word is a whole number");
    if (m_words_.size() >= most_functions) return refuse("NC0711", place, "more M words than a block has");
    MWord word{.number = static_cast<int>(number), .place = place};
    if (function_of(word.number) == Function::machine_datum) machine_datum_ = true;
    if (!words_of_function(word)) return false;
    m_words_.push_back(word);
    return true;
}

/// What stands behind some M words and is theirs.
bool HeidenhainReader::words_of_function(MWord& word) {
    switch (word.number) {
        case 94:
            for (char letter = 'A'; letter <= 'W'; ++letter)
                if (control_.kind(static_cast<std::size_t>(letter - 'A')) == Control::Letter::rotary &&
                    cursor().take_word(std::string_view(&letter, 1)))
                    word.rotary_axes |= 1u << control_.axis(static_cast<std::size_t>(letter - 'A'));
            return true;
        case 128:
            if (cursor().front() != 'F') return true;
            findings_.ignored(cursor().spot(cursor().index()), "M128 F");
            cursor().skip(1);
            return feed_words(word.feed_word, word.feed, word.place);
        case 140:
            if (!cursor().take_word("MB"))
                return refuse("NC0724", word.place, "M140 needs its way: MB and a length, or MB MAX");
            word.to_limit = cursor().take_word("MAX");
            if (!word.to_limit && !values().value(word.distance)) return false;
            if (cursor().front() != 'F') return true;
            if (cursor().take_word("FMAX")) return true;
            cursor().skip(1);
            return feed_words(word.feed_word, word.feed, word.place);
        case 118:
        case 120:
        case 124:
        case 138:
            while (!cursor().at_end() && cursor().front() != 'M' && cursor().front() != 'F') cursor().bare();
            return true;
        default:
            return true;
    }
}

bool HeidenhainReader::start_functions() {
    for (const MWord& word : m_words_)
        if (!start_function(word)) return false;
    return true;
}

bool HeidenhainReader::end_functions() {
    for (const MWord& word : m_words_)
        if (!end_function(word)) return false;
    return true;
}

/// Those that act before the block moves.
bool HeidenhainReader::start_function(const MWord& word) {
    if (own_word(word.number)) return true;
    switch (function_of(word.number)) {
        case Function::spindle:
            if (word.number > 10) event(EventKind::coolant, false, written(word));
            return event(EventKind::spindle, true, written(word));
        case Function::coolant:
            return event(EventKind::coolant, false, written(word));
        case Function::event:
            return event(EventKind::other, true, written(word));
        case Function::reduce:
            return reduce_rotary(word), true;
        case Function::rotary_mm:
            return modes_.rotary_in_mm = true;
        case Function::shortest:
            return modes_.shortest = true;
        case Function::transform_on:
            modes_.spatial_angles = modes_.vectors = modes_.axes_in_feed = false;
            return set_transform(true), true;
        case Function::per_turn:
        case Function::per_minute:
            modes_.per_turn = function_of(word.number) == Function::per_turn;
            return true;
        case Function::retract:
            return retract(word);
        case Function::ignored:
            return findings_.ignored(cursor().spot(word.place), written(word)), true;
        case Function::refused:
            return refused_function(word);
        default:
            return true;
    }
}

/// Those that act when the block has moved.
bool HeidenhainReader::end_function(const MWord& word) {
    switch (function_of(word.number)) {
        case Function::stop:
            return event(EventKind::stop, true, written(word));
        case Function::end:
            if (!interpreter_.in_main_program())
                return refuse("NC0745", word.place, "the end of all programs in a program that is called",
                              written(word), "END PGM goes back to the caller");
            finished_ = true;
            return event(EventKind::stop, true, written(word));
        case Function::spindle_off:
            return event(EventKind::spindle, true, written(word));
        case Function::coolant_off:
            return event(EventKind::coolant, false, written(word));
        case Function::tool_change:
            return event(EventKind::tool, true, written(word));
        case Function::rotary_degrees:
            modes_.rotary_in_mm = false;
            return true;
        case Function::literal:
            modes_.shortest = false;
            return true;
        case Function::transform_off:
            return set_transform(false), true;
        case Function::modal_call:
            modal_call_ = true;
            return call_cycle(word.place);
        case Function::block_call:
            modal_call_ = false;
            return call_cycle(word.place);
        default:
            return true;
    }
}

bool HeidenhainReader::refused_function(const MWord& word) {
    return refuse("NC0701", word.place, "changes motion and is not supported", written(word),
                  word.number == 92 ? "M91 counts from the machine's zero" : "post the path without it");
}

/// A word that the machine file declares. LinuxCNC's own words for TCP, which count where it declares none, do not
/// here.
bool HeidenhainReader::own_word(int number) {
    constexpr int most = 100'000;
    if (!options_.machine || number > most) return false;
    const machine::ControlWords& words = options_.machine->words;
    const Control::Role role = control_.role({'M', number * 10, 0});
    if (role == Control::Role::ignore) return true;
    if (role == Control::Role::none || (words.tcp_on.empty() && words.tcp_off.empty())) return false;
    set_transform(role == Control::Role::tcp_on);
    return true;
}

/// After the tool was turned by vectors its rotary axes stay where path building chose.
void HeidenhainReader::set_transform(bool on) {
    if (modes_.transform == on) return;
    modes_.transform = on;
    if (!frames_.plane) law_ = program::OrientationLaw::rotary;
}

/// M94: the count of an axis loses its whole turns; it stands where it stood.
void HeidenhainReader::reduce_rotary(const MWord& word) {
    constexpr double turn = 2 * std::numbers::pi;
    for (std::size_t i = 0; i < rotary_rad_.size(); ++i) {
        if (word.rotary_axes != 0 && (word.rotary_axes & (1u << i)) == 0) continue;
        if (!std::isnan(rotary_rad_[i])) reduced_rad_[i] = turn * std::trunc(rotary_rad_[i] / turn);
    }
}

// ------------------------------------------------------------------------------------------------- tools

bool HeidenhainReader::tool() {
    if (cursor().take_word("CALL")) return tool_call();
    if (cursor().take_word("DEF")) return tool_definition();
    return refuse("NC0204", first_word_, "unknown block: it might change motion", "TOOL");
}

/// A number, with a point and the step of an indexed tool, or a name; `said` is false where none stands there.
bool HeidenhainReader::tool_name(std::string& name, bool& said) {
    const std::size_t place = cursor().next_index();
    said = true;
    if (cursor().front() == '"') {
        const auto quoted = cursor().quoted();
        if (!quoted) return refuse("NC0711", place, "the name of a tool is not closed", {}, "close it with \"");
        name = *quoted;
        return true;
    }
    said = is_digit(cursor().front()) || cursor().front() == 'Q' || cursor().front() == '+';
    double number = 0;
    if (!said) return true;
    if (!values().value(number)) return false;
    if (!(number >= 0) || !(number < largest_number))
        return refuse("NC0711", place, "the number of a tool is not negative");
    name = fmt::format("{}", number);
    return true;
}

bool HeidenhainReader::tool_call() {
    const std::size_t place = cursor().next_index();
    std::string name;
    bool said = false;
    if (!tool_name(name, said) || !tool_words()) return false;
    return !said || change_tool(name, place);
}

/// The tool's axis, S, F and oversizes behind TOOL CALL.
bool HeidenhainReader::tool_words() {
    while (!cursor().at_end()) {
        const std::size_t place = cursor().index();
        const std::string_view name = cursor().name();
        double value = 0;
        if (name == "Z") continue;
        if (name == "X" || name == "Y" || name == "U" || name == "V" || name == "W")
            return refuse("NC0722", place, "a tool axis other than Z is not supported", name);
        if (name == "S") {
            if (!speed_of_spindle()) return false;
        } else if (name == "F") {
            feed_word_ = FeedWord::none;
            if (!feed_words(feed_word_, feed_value_, place) || !keep_feed()) return false;
            modes_.tool_call_feed = modes_.feed;
        } else if (name == "DL" || name == "DR") {
            const bool second = name == "DR" && cursor().rest().starts_with('2');
            if (second) cursor().skip(1);
            const bool length = name == "DL";
            if (!cursor().take(':')) cursor().take('=');
            if (!values().value(value)) return false;
            if (length && value != 0)
                return refuse("NC0722", place, "an oversize of the tool's length moves the path and is not supported",
                              fmt::format("DL{:+}", value), "the tool's length in the setup, with DL+0");
            if (!length && value != 0) findings_.ignored(cursor().spot(place), second ? "DR2" : "DR");
        } else {
            return refuse("NC0204", place, "unknown word: it might change motion",
                          name.empty() ? cursor().rest().substr(0, 1) : name);
        }
    }
    return true;
}

/// Tool 0 has no length.
bool HeidenhainReader::change_tool(const std::string& name, std::size_t place) {
    const auto index = index_in(program_.tools, name == "0" ? "0 D0" : name);
    if (!index) return refuse("NC0008", place, "more tools than are read");
    event(EventKind::tool, true, "TOOL CALL " + name);
    tool_ = *index;
    return true;
}

/// TOOL DEF prepares a tool; its L and R are of the setup here.
bool HeidenhainReader::tool_definition() {
    std::string name;
    bool said = false;
    const std::size_t place = cursor().next_index();
    if (!tool_name(name, said)) return false;
    if (!said) return refuse("NC0711", place, "TOOL DEF needs a tool");
    event(EventKind::tool, false, "TOOL DEF " + name);
    while (!cursor().at_end()) {
        const std::size_t at = cursor().index();
        const std::string_view word = cursor().name();
        if (word != "L" && word != "R") return want_end();
        findings_.ignored(cursor().spot(at), word == "L" ? "TOOL DEF L" : "TOOL DEF R");
        double value = 0;
        if (!values().value(value)) return false;
    }
    return true;
}

/// STOP, and M words behind it.
bool HeidenhainReader::stop_block() {
    if (!path_words()) return false;
    event(EventKind::stop, true, "STOP");
    return start_functions() && check_addresses(0) && end_functions();
}

// ------------------------------------------------------------------------------------------------- FUNCTION

bool HeidenhainReader::function_block() {
    const std::size_t place = cursor().next_index();
    if (cursor().take_word("TCPM")) return tcpm();
    if (cursor().take_word("RESET")) {
        if (!cursor().take_word("TCPM"))
            return refuse("NC0701", place, "changes motion and is not supported", "FUNCTION RESET");
        set_transform(false);
        modes_.spatial_angles = modes_.vectors = modes_.axes_in_feed = false;
        return want_end();
    }
    if (cursor().take_word("MODE") && cursor().take_word("MILL")) return true;
    return refuse("NC0701", place, "changes motion and is not supported", "FUNCTION");
}

bool HeidenhainReader::tcpm() {
    bool to_tip = false, of_axes = false, positions = false, angles = false, axes = false, vectors = false;
    while (!cursor().at_end()) {
        const std::size_t place = cursor().index();
        const std::string name(cursor().name());
        const std::string value(cursor().name());
        to_tip = to_tip || (name == "F" && value == "TCP");
        of_axes = of_axes || (name == "F" && value == "CONT");
        positions = positions || (name == "AXIS" && value == "POS");
        angles = angles || (name == "AXIS" && value == "SPAT");
        axes = axes || (name == "PATHCTRL" && value == "AXIS");
        vectors = vectors || (name == "PATHCTRL" && value == "VECTOR");
        const bool tip = name == "REFPNT" && value == "TIP";
        const bool centre = name == "REFPNT" && value == "CENTER";
        if (tip && cursor().take('-') && (cursor().take_word("TIP") || cursor().take_word("CENTER"))) continue;
        if (centre && cursor().take('-'))
            return refuse("NC0701", place, "REFPNT CENTER programs the tool's centre and is not supported", {},
                          "REFPNT TIP-TIP");
        const bool known = (name == "F" && (value == "TCP" || value == "CONT")) ||
                           (name == "AXIS" && (value == "POS" || value == "SPAT")) ||
                           (name == "PATHCTRL" && (value == "AXIS" || value == "VECTOR"));
        if (!known) return refuse("NC0204", place, "unknown word: it might change motion", name);
    }
    if ((to_tip && of_axes) || (positions && angles) || (axes && vectors))
        return refuse("NC0706", first_word_, "FUNCTION TCPM contradicts itself");
    modes_.axes_in_feed = of_axes;
    modes_.spatial_angles = angles;
    modes_.vectors = vectors;
    set_transform(true);
    return true;
}

bool HeidenhainReader::check_addresses(std::uint32_t allowed) {
    const auto unused = said_.other_than(allowed);
    if (unused) return refuse("NC0711", said_.place(*unused), "this word has no use in this block");
    return true;
}

}  // namespace trunnion::nc::heidenhain

namespace trunnion::nc {

Result<std::unique_ptr<BlockReader>> open_heidenhain(const ProgramText& text, std::string_view file_name,
                                                     const ReadOptions& options) {
    auto control = Control::make(options.machine);
    if (!control) return fail(std::move(control.error()));
    return std::make_unique<heidenhain::HeidenhainReader>(text, file_name, options, std::move(*control));
}

}  // namespace trunnion::nc
