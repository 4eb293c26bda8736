#include <algorithm>

#include "trunnion/nc/following.hpp"

#include "detail/rs274_reader.hpp"

namespace trunnion::nc {

using program::EventKind;

namespace {

constexpr char first_letter(std::uint32_t letters) {
    return static_cast<char>('A' + std::countr_zero(letters));
}

}  // namespace

/// M82 and M83: once said they decide, whatever G90 and G91 say.
void Rs274Reader::following_distance() {
    modal_.following_absolute = request_.asks(Group::following_distance, Meaning::absolute_following);
    code_event(EventKind::other, false, Group::following_distance);
}

/// Where the words of the block take the following axes, in mm.
bool Rs274Reader::follow_words() {
    const bool absolute = modal_.following_absolute.value_or(modal_.absolute);
    for (std::uint32_t letters = follows_; letters != 0; letters &= letters - 1) {
        const char letter = first_letter(letters);
        const std::size_t index = Block::index(letter);
        const double word_mm = block_.value[index] * modal_.unit_mm;
        const double end_mm = word_mm + (absolute ? g92_.following_mm[index] : following_mm_[index]);
        following_way_mm_[index] = end_mm - following_mm_[index];
        if (!std::isfinite(following_way_mm_[index]))
            return refuse("NC0201", block_.spot(letter), "the position is not finite", {&letter, 1});
        if (absolute && !modal_.absolute)
            findings_.count("NC0353", Severity::warning, block_.spot(letter), {&letter, 1},
                            "counted absolutely, as M82 says, though G91 is in force",
                            "some controls count it from where it is then: M83 says so to all of them");
        following_mm_[index] = end_mm;
        if (following_way_mm_[index] != 0) start_following(letter);
    }
    return true;
}

/// A block that moves nothing on the path: an event that takes as long as the following axes need at the feed in force,
/// with G0 too, as printers do it.
bool Rs274Reader::stand_while_following() {
    std::array<double, 26> way_mm{};
    double squares = 0;
    for (std::uint32_t letters = follows_; letters != 0; letters &= letters - 1) {
        const std::size_t index = Block::index(first_letter(letters));
        way_mm[index] = following_way_mm_[index];
        squares += way_mm[index] * way_mm[index];
    }
    if (modal_.motion == Meaning::no_motion)
        return refuse("NC0308", block_.spot(first_letter(follows_)), "a following axis, but no motion is in force", {},
                      "G0 or G1 before it");
    if (squares == 0) return true;
    double time_s = 0;
    if (!time_of_following(std::sqrt(squares), time_s)) return false;
    constexpr std::string_view alphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZ";
    event(EventKind::dwell, true, following_word(alphabet, way_mm), time_s);
    return true;
}

bool Rs274Reader::time_of_following(double way_mm, double& time_s) {
    const Spot spot = block_.spot(first_letter(follows_));
    if (modal_.feed_per_s == 0) {
        if (!options_.feed_given_elsewhere)
            return refuse("NC0205", spot, "a following axis goes alone without a feed", {}, "F before it");
        findings_.count("NC0354", Severity::warning, spot, {},
                        "following axes that go alone without a feed take no time", "F before them");
        time_s = 0;
        return true;
    }
    const bool by_time = modal_.feed_mode == FeedMode::inverse_time;
    time_s = by_time ? 1 / modal_.feed_per_s : way_mm / (modal_.feed_per_s * modal_.feed_unit_mm);
    return std::isfinite(time_s) || refuse("NC0201", spot, "the time of the block is not finite");
}

/// A column for this letter from the first move on, where it has none.
void Rs274Reader::start_following(char letter) {
    auto& letters = program_.following_letters;
    if (std::ranges::find(letters, letter) != letters.end()) return;
    const std::size_t columns = letters.size();
    letters.push_back(letter);
    std::vector<double> rows(program_.moves.size() * letters.size());
    for (std::size_t k = 0; k < program_.moves.size(); ++k)
        std::copy_n(program_.following.data() + k * columns, columns, rows.data() + k * letters.size());
    program_.following = std::move(rows);
}

void Rs274Reader::add_following_row() {
    for (const char letter : program_.following_letters)
        program_.following.push_back(following_mm_[Block::index(letter)]);
}

/// G92 E0: where the axis is counts as that from here on.
bool Rs274Reader::shift_following_to_here() {
    for (std::uint32_t letters = follows_; letters != 0; letters &= letters - 1) {
        const char letter = first_letter(letters);
        const std::size_t index = Block::index(letter);
        const double word_mm = block_.value[index] * modal_.unit_mm;
        g92_.following_mm[index] = following_mm_[index] - word_mm;
        if (!std::isfinite(g92_.following_mm[index]))
            return refuse("NC0201", block_.spot(letter), "the shift is not finite", {&letter, 1});
    }
    return true;
}

/// Writers count as the program did: an event for every letter of which G92 was said, or whose shift is another now.
void Rs274Reader::tell_following_shift(const std::array<double, 26>& before_mm) {
    std::string word;
    for (std::uint32_t letters = control_.following_letters(); letters != 0; letters &= letters - 1) {
        const char letter = first_letter(letters);
        const std::size_t index = Block::index(letter);
        if ((follows_ & Block::bit(letter)) == 0 && g92_.following_mm[index] == before_mm[index]) continue;
        word += fmt::format(" {}{}", letter, following_mm_[index] - g92_.following_mm[index]);
    }
    if (!word.empty()) event(EventKind::other, false, "G92" + word);
}

}  // namespace trunnion::nc
