#include "detail/rs274_reader.hpp"

namespace trunnion::nc {

namespace {

/// G54 … G59.3, by their number on LinuxCNC, 1 … 9.
std::string offset_named(int number) {
    return number <= 6 ? fmt::format("G{}", 53 + number) : fmt::format("G59.{}", number - 6);
}

}  // namespace

void Rs274Reader::use_shift() {
    word_shift_ = {};
    if (frame_.space == program::Space::machine) return;
    word_shift_ = g92_;
    const auto found = offset_shifts_.find(frame_.offset);
    if (found == offset_shifts_.end()) return;
    word_shift_.mm += found->second.mm;
    for (std::size_t i = 0; i < word_shift_.rad.size(); ++i) word_shift_.rad[i] += found->second.rad[i];
}

bool Rs274Reader::shift() {
    if (request_.of(Group::shift) == Meaning::unknown) return true;
    const auto following_before_mm = g92_.following_mm;
    switch (request_.of(Group::shift)) {
        case Meaning::shift_to_here: {
            const auto other = offset_shifts_.find(modal_.offset);
            if (!shift_to_here(g92_, other == offset_shifts_.end() ? WordShift{} : other->second, "G92") ||
                !shift_following_to_here())
                return false;
            kept_g92_ = g92_;
            break;
        }
        case Meaning::local_shift:
            return local_shift();
        case Meaning::end_shift:
            g92_ = kept_g92_ = {};
            break;
        case Meaning::pause_shift:
            g92_ = {};
            break;
        case Meaning::resume_shift:
            g92_ = kept_g92_;
            break;
        case Meaning::set_data:
            return set_data();
        case Meaning::go_home:
            return go_home();
        default:
            return true;
    }
    tell_following_shift(following_before_mm);
    use_shift();
    return true;
}

/// Makes the axes stand at the words of the block: `base` and `other` together are what is added to words.
bool Rs274Reader::shift_to_here(WordShift& base, const WordShift& other, std::string_view what) {
    if (axes_ == 0) return true;
    enter(frame_in_force());
    for (std::uint32_t letters = axes_; letters != 0; letters &= letters - 1) {
        const char letter = static_cast<char>('A' + std::countr_zero(letters));
        const std::size_t index = Block::index(letter);
        const bool linear = control_.kind(index) == Control::Letter::linear;
        const std::size_t axis = control_.axis(index);
        const auto along = static_cast<Eigen::Index>(axis);
        const double position = linear ? position_mm_[along] : rotary_rad_[axis];
        if (std::isnan(position))
            return refuse("NC0342", block_.spot(letter), fmt::format("{} at a position that is not known", what),
                          {&letter, 1}, "say the position by G0 before it, or count from the work offset without it");
        const double word = block_.value[index] * (linear ? modal_.unit_mm : degree);
        double& value = linear ? base.mm[along] : base.rad[axis];
        value = position - word - (linear ? other.mm[along] : other.rad[axis]);
        if (!std::isfinite(value))
            return refuse("NC0201", block_.spot(letter), "the shift is not finite", {&letter, 1});
    }
    return true;
}

/// G52 says the shift itself; it is G92's.
bool Rs274Reader::local_shift() {
    for (std::uint32_t letters = axes_; letters != 0; letters &= letters - 1) {
        const std::size_t index = static_cast<std::size_t>(std::countr_zero(letters));
        const bool linear = control_.kind(index) == Control::Letter::linear;
        const std::size_t axis = control_.axis(index);
        double& value = linear ? g92_.mm[static_cast<Eigen::Index>(axis)] : g92_.rad[axis];
        value = block_.value[index] * (linear ? modal_.unit_mm : degree);
        if (!std::isfinite(value))
            return refuse("NC0201", block_.at(block_.column[index]), "the shift is not finite", "G52");
    }
    kept_g92_ = g92_;
    use_shift();
    return true;
}

/// G10 L20 of the offset in force is carried out; the others set what the setup says.
bool Rs274Reader::set_data() {
    const auto refused = [&](std::string_view hint) {
        return refuse("NC0341", spot_of(Group::shift), "G10 that sets what the setup says",
                      block_.has('L') ? fmt::format("G10 L{}", block_['L']) : "G10", hint);
    };
    if (!block_.has('L')) return refused("G10 L20 P0 counts from where the axes stand");
    if (block_['L'] != 20) return refused("offsets and tools are in the setup: [offsets], [tools]");
    const double number = block_.has('P') ? block_['P'] : 0;
    if (number != std::floor(number) || number < 0 || number > 9)
        return refuse("NC0314", block_.spot('P'), "a work offset has a number from 0 to 9", fmt::format("P{}", number));
    if (block_.has('R')) return refused("turned offsets are not supported");
    if (number != 0 && offset_named(static_cast<int>(number)) != program_.offsets[modal_.offset])
        return refuse("NC0342", block_.spot('P'), "where the axes stand in an offset that is not in force",
                      fmt::format("P{}", number), "P0 is the one in force");
    if (!shift_to_here(offset_shifts_[modal_.offset], g92_, "G10 L20")) return false;
    use_shift();
    return true;
}

/// At the start nothing is known anyway. Behind it, nothing is known until the program says it: only at the end can the
/// way be left out.
bool Rs274Reader::go_home() {
    if (program_.moves.empty()) {
        findings_.count("NC0347", Severity::warning, spot_of(Group::shift), "G28",
                        "the way home at the start is left out: where it leads is not known");
        position_mm_.setConstant(unknown_word);
        rotary_rad_.fill(unknown_word);
    } else if (!left_out_home_) {
        left_out_home_ = spot_of(Group::shift);
    }
    return true;
}

}  // namespace trunnion::nc
