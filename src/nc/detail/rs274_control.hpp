#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "trunnion/base/result.hpp"
#include "trunnion/machine/machine.hpp"

#include "detail/rs274_block.hpp"

namespace trunnion::nc {

/// What the letters and the own words of one control mean: its axes, and the words that its machine file declares.
class Control {
  public:
    enum class Letter : std::uint8_t { fixed, linear, rotary, following, silent };
    enum class Role : std::uint8_t { none, tcp_on, tcp_off, ignore };

    /// Without a machine: X, Y, Z and no own words. Errors: NC0007 a declared word is no letter with a number (or, for
    /// those that are ignored, a letter), or a following letter is an axis of the machine or has a meaning of its own.
    static Result<Control> make(const machine::Machine* machine);

    Letter kind(std::size_t letter) const { return kind_[letter]; }
    /// Of a linear letter: 0…2 for X, Y, Z. Of a rotary letter: its place among the machine's rotary axes.
    std::size_t axis(std::size_t letter) const { return axis_[letter]; }
    Role role(const Code& code) const {
        for (const OwnWord& own : own_words_)
            if (own.code.letter == code.letter && own.code.tenths == code.tenths) return own.role;
        return Role::none;
    }
    bool has_machine() const { return has_machine_; }
    std::uint32_t axis_letters() const { return axis_letters_; }
    std::uint32_t following_letters() const { return following_letters_; }
    char rotary_letter(std::size_t axis) const { return rotary_letters_[axis]; }

  private:
    struct OwnWord {
        Code code;
        Role role;
    };
    bool declare(const std::vector<std::string>& words, Role role);
    Result<void> declare_following(const machine::Machine& machine);
    void set_letter(char letter, Letter kind, std::size_t axis);

    std::array<Letter, 26> kind_{};
    std::array<std::uint8_t, 26> axis_{};
    std::array<char, machine::max_axes> rotary_letters_{};
    std::vector<OwnWord> own_words_;
    std::uint32_t axis_letters_ = 0, following_letters_ = 0;
    bool has_machine_ = false;
};

}  // namespace trunnion::nc
