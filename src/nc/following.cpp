#include "trunnion/nc/following.hpp"

#include <algorithm>
#include <iterator>
#include <vector>

#include <fmt/format.h>

#include "trunnion/base/number.hpp"

#include "detail/text.hpp"

namespace trunnion::nc {

std::string following_word(std::span<const char> letters, std::span<const double> way_mm) {
    std::string out;
    for (std::size_t i = 0; i < letters.size(); ++i)
        if (way_mm[i] != 0)
            fmt::format_to(std::back_inserter(out), "{}{}{}", out.empty() ? "" : " ", letters[i], way_mm[i]);
    return out;
}

bool add_following_word(std::span<const char> letters, std::string_view word, std::span<double> sum) {
    word = trimmed(word);
    if (word.empty()) return false;
    std::vector<double> with_word(sum.begin(), sum.end());
    for (; !word.empty(); word = skip_blanks(word)) {
        const auto letter = std::ranges::find(letters, word.front());
        if (letter == letters.end()) return false;
        word.remove_prefix(1);
        const auto number = take_number(word, Exponent::allowed);
        if (!number) return false;
        with_word[static_cast<std::size_t>(letter - letters.begin())] += *number;
    }
    std::ranges::copy(with_word, sum.begin());
    return true;
}

bool add_following_travel(const program::Program& program, const program::Event& event, std::span<double> sum_mm) {
    if (event.kind != program::EventKind::dwell || program.following_letters.empty()) return false;
    return add_following_word(program.following_letters, event.word, sum_mm);
}

double following_standing(const program::Program& program, std::size_t first, std::size_t last, std::size_t axis) {
    std::vector<double> way_mm(program.following_letters.size(), 0);
    auto event = std::ranges::lower_bound(program.events, first, {}, &program::Event::before_move);
    for (; event != program.events.end() && event->before_move <= last; ++event)
        add_following_travel(program, *event, way_mm);
    return way_mm[axis];
}

double following_at_begin(const program::Program& program, std::size_t move, std::size_t axis) {
    return (move == 0 ? 0 : following_at_end(program, move - 1, axis)) + following_standing(program, move, move, axis);
}

}  // namespace trunnion::nc
