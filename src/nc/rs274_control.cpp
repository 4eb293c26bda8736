#include "detail/rs274_control.hpp"

#include <cmath>
#include <utility>

#include "trunnion/base/number.hpp"

namespace trunnion::nc {

namespace {

bool is_one_letter(std::string_view word) {
    return word.size() == 1 && is_letter(word.front());
}

std::optional<Code> code_of(std::string_view word) {
    word = trimmed(word);
    if (word.size() < 2 || (upper(word.front()) != 'G' && upper(word.front()) != 'M')) return {};
    const char letter = upper(word.front());
    word.remove_prefix(1);
    const auto number = take_number(word);
    if (!number || !word.empty() || !(*number >= 0) || *number > 1e5) return {};
    return Code{letter, static_cast<int>(std::round(*number * 10)), 0};
}

Diagnostic bad_declaration(const std::string& file, const char* text, std::string value, const char* hint) {
    return {.code = "NC0007", .text = text, .place = {.file = file}, .value = std::move(value), .hint = hint};
}

}  // namespace

Result<Control> Control::make(const machine::Machine* machine) {
    Control control;
    for (std::size_t i = 0; i < 3; ++i) control.set_letter("XYZ"[i], Letter::linear, i);
    if (!machine) return control;
    control.has_machine_ = true;
    machine::ControlWords words = machine->words;
    if (words.tcp_on.empty() && words.tcp_off.empty() && machine->rotary_count > 0) {
        words.tcp_on = {"M428"};  // as in the 5-axis configurations that LinuxCNC ships
        words.tcp_off = {"M429"};
    }
    if (auto declared = control.declare_following(*machine); !declared) return fail(std::move(declared.error()));
    const bool good = control.declare(words.tcp_on, Role::tcp_on) && control.declare(words.tcp_off, Role::tcp_off) &&
                      control.declare(words.ignore, Role::ignore);
    if (!good)
        return fail(bad_declaration(machine->file,
                                    "a word that the machine file declares is not a G or M with its number", {},
                                    "write it like \"M428\"; following = [\"E\"] takes letters"));
    for (int i = machine->linear_count(); i < machine->axis_count; ++i)
        control.set_letter(machine->axes[i].letter, Letter::rotary,
                           static_cast<std::size_t>(i - machine->linear_count()));
    return control;
}

void Control::set_letter(char letter, Letter kind, std::size_t axis) {
    if (!is_letter(letter)) return;
    const std::size_t index = Block::index(upper(letter));
    kind_[index] = kind;
    axis_[index] = static_cast<std::uint8_t>(axis);
    if (kind == Letter::linear || kind == Letter::rotary) axis_letters_ |= Block::bit(upper(letter));
    if (kind == Letter::following)
        following_letters_ |= Block::bit(upper(letter));
    else
        following_letters_ &= ~Block::bit(upper(letter));
    if (kind == Letter::rotary) rotary_letters_[axis] = upper(letter);
}

Result<void> Control::declare_following(const machine::Machine& machine) {
    constexpr std::string_view letters_with_meaning = "FGIJKMNOPRSTXYZ";
    for (const std::string& word : machine.words.following) {
        if (!is_one_letter(word))
            return fail(
                bad_declaration(machine.file, "what follows is named by a letter", word, "following = [\"E\"]"));
        const char letter = upper(word.front());
        if (machine.index_of(letter) >= 0)
            return fail(bad_declaration(machine.file, "a following letter is an axis of the machine", word,
                                        "take it out of [words] following or out of the chain"));
        if (letters_with_meaning.contains(letter))
            return fail(bad_declaration(machine.file, "a following letter has another meaning in every program", word,
                                        "S, and outputs by M67 and M68, are events at their places anyway"));
        set_letter(letter, Letter::following, 0);
    }
    return {};
}

bool Control::declare(const std::vector<std::string>& words, Role role) {
    for (const std::string& word : words) {
        if (role == Role::ignore && is_one_letter(word)) {
            set_letter(word.front(), Letter::silent, 0);
            continue;
        }
        const auto code = code_of(word);
        if (!code) return false;
        own_words_.push_back({*code, role});
    }
    return true;
}

}  // namespace trunnion::nc
