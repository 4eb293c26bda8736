#include "detail/rs274_reader.hpp"

namespace trunnion::nc {

namespace {

constexpr std::uint32_t always_used = Block::bit('F') | Block::bit('S') | Block::bit('T');
constexpr std::uint32_t parameter_letters = Block::bit('D') | Block::bit('E') | Block::bit('H') | Block::bit('I') |
                                            Block::bit('J') | Block::bit('K') | Block::bit('L') | Block::bit('P') |
                                            Block::bit('Q') | Block::bit('R');

bool is_one_of(char letter, std::string_view letters) {
    return letters.contains(letter);
}

/// Of the canned cycle with this G word, besides axis words.
std::string_view letters_of_cycle(int tenths) {
    switch (tenths) {
        case 730:
        case 830:
            return "RLQ";
        case 810:
        case 850:
            return "RL";
        default:
            return "RLP";
    }
}

std::string_view letters_of_curve(Meaning curve) {
    switch (curve) {
        case Meaning::cubic_curve:
            return "IJPQ";
        case Meaning::quadratic_curve:
            return "IJ";
        case Meaning::nurbs:
            return "PL";
        default:
            return "";
    }
}

}  // namespace

bool Rs274Reader::check_letters() {
    axes_ = block_.present & control_.axis_letters();
    axes_ever_ |= axes_;
    follows_ = block_.present & control_.following_letters();
    if (request_.asks(Group::user, Meaning::user_word)) take_parameters_of_user_word();
    for (std::uint32_t others = block_.present & ~(axes_ | always_used); others != 0; others &= others - 1)
        if (!check_letter(static_cast<char>('A' + std::countr_zero(others)))) return false;
    return true;
}

bool Rs274Reader::check_letter(char letter) {
    const Control::Letter kind = control_.kind(Block::index(letter));
    if (kind == Control::Letter::silent) return true;
    if (kind == Control::Letter::following) return check_following(letter);
    if ((parameter_letters & Block::bit(letter)) == 0 && letter != 'N') return absent_axis(letter);
    const bool dwells = request_.asks(Group::once, Meaning::dwell);
    const bool moves = uses(letter);
    if (moves && letter == 'P' && dwells)
        return refuse("NC0313", block_.spot(letter), "the letter has two uses in this block", {&letter, 1},
                      "give the dwell a block of its own");
    if (moves || request_.own_word || (letter == 'P' && dwells)) return true;
    if (letter == 'H' && request_.asks(Group::tool_length, Meaning::tool_length)) return true;
    if (request_.asks(Group::path_control, Meaning::continuous) && is_one_of(letter, "PQ")) {
        findings_.ignored(block_.spot(letter), letter == 'P' ? "G64 P" : "G64 Q");
        return true;
    }
    if (request_.of(Group::pins) != Meaning::unknown && is_one_of(letter, "PELQ")) return true;
    if (request_.asks(Group::tool_change, Meaning::tool_in_spindle) && letter == 'Q') return true;
    if (request_.asks(Group::subprogram, Meaning::call_program) && is_one_of(letter, "PL")) return true;
    if (request_.asks(Group::shift, Meaning::set_data) && is_one_of(letter, "LPRIJQ")) return true;
    return refuse("NC0313", block_.spot(letter), "the letter has no use in this block", {&letter, 1},
                  letter == 'E' ? "an extruder is declared in the machine file: [words] following = [\"E\"]" : "");
}

/// P and Q; on a machine with following axes, which prints, S, T and R too: M104 S205 T1 sets no spindle.
void Rs274Reader::take_parameters_of_user_word() {
    constexpr std::uint32_t of_users = Block::bit('P') | Block::bit('Q');
    constexpr std::uint32_t of_printers = of_users | Block::bit('S') | Block::bit('T') | Block::bit('R');
    user_parameters_ = block_.present & ~axes_ & (control_.following_letters() != 0 ? of_printers : of_users);
    if (control_.following_letters() != 0) block_.present &= ~user_parameters_;
}

void Rs274Reader::user_word() {
    const Code& code = request_.code_of(Group::user);
    const bool stops = control_.following_letters() == 0 || !sets_printer(code);
    event(program::EventKind::other, stops, with_letters(code, user_parameters_));
}

/// `M104 S205 T1`.
std::string Rs274Reader::with_letters(const Code& code, std::uint32_t letters) const {
    std::string out = name_of(code);
    for (; letters != 0; letters &= letters - 1) {
        const auto index = static_cast<std::size_t>(std::countr_zero(letters));
        out += fmt::format(" {}{}", static_cast<char>('A' + index), block_.value[index]);
    }
    return out;
}

/// A following letter beside the words of outputs, or alone beside a word of this control, belongs to them.
bool Rs274Reader::check_following(char letter) {
    const bool of_pins = request_.of(Group::pins) != Meaning::unknown && is_one_of(letter, "ELQ");
    const bool moves = axes_ != 0 || request_.of(Group::motion) != Meaning::unknown;
    if (of_pins || (request_.own_word && !moves)) {
        follows_ &= ~Block::bit(letter);
        return true;
    }
    if (request_.asks(Group::shift, Meaning::shift_to_here)) return true;
    const Meaning motion = motion_in_force();
    if (!request_.takes_axes && (motion < Meaning::nurbs || motion == Meaning::no_motion)) return true;
    return refuse("NC0313", block_.spot(letter), "the letter has no use in this block", {&letter, 1},
                  "following axes go with G0 to G5.1, and G92 sets what they count");
}

/// Whether the motion of the block has a use for this letter.
bool Rs274Reader::uses(char letter) const {
    if (moves_on_arc()) return is_one_of(letter, "IJKPR");
    if (request_.asks(Group::motion, Meaning::surface_machining))
        return is_one_of(letter, SurfaceWords::machining_letters);
    const Meaning motion = motion_in_force();
    const bool moves = !request_.takes_axes && (axes_ != 0 || request_.of(Group::motion) != Meaning::unknown);
    if (is_curve(motion) && (moves || nurbs_)) return is_one_of(letter, letters_of_curve(motion));
    if (motion != Meaning::cycle || !moves) return false;
    const bool asked = request_.asks(Group::motion, Meaning::cycle);
    return is_one_of(letter, letters_of_cycle((asked ? request_.code_of(Group::motion) : modal_.motion_code).tenths));
}

bool Rs274Reader::absent_axis(char letter) {
    if (!control_.has_machine())
        return refuse("NC0307", block_.spot(letter), "this axis needs a machine that has it", {&letter, 1},
                      "-m says which");
    return refuse("NC0306", block_.spot(letter), "the machine has no such axis", {&letter, 1},
                  "another machine (-m), or [words] following = [...] in its file for a letter that is no axis");
}

}  // namespace trunnion::nc
