#include <cmath>
#include <utility>

#include "trunnion/nc/following.hpp"

#include "detail/g_code_writer.hpp"

namespace trunnion::nc {

namespace {

constexpr std::string_view set_counting = "G92 ";

}  // namespace

std::int64_t GCodeWriter::following_steps(std::size_t i) const {
    return following_grid_.steps(following_mm_[i] / unit_mm() - said_following_[i].origin);
}

bool GCodeWriter::says_following() const {
    for (std::size_t i = 0; i < said_following_.size(); ++i)
        if (following_steps(i) != said_following_[i].steps) return true;
    return false;
}

void GCodeWriter::following_words() {
    for (std::size_t i = 0; i < said_following_.size(); ++i) {
        const std::int64_t goal = following_steps(i), said = std::exchange(said_following_[i].steps, goal);
        if (goal != said)
            word({&program_.following_letters[i], 1}, following_grid_, follows_incrementally_ ? goal - said : goal);
    }
}

bool GCodeWriter::following_event(const program::Event& event) {
    if (event.kind == program::EventKind::dwell) return follow_alone(event);
    const std::string_view word = event.word;
    if (word == "M82" || word == "M83") {
        follows_incrementally_ = word == "M83";
        line(word);
        return true;
    }
    return word.starts_with(set_counting) && count_following(word.substr(set_counting.size()));
}

/// F is what takes the time of the event. It stays in force, as the reader takes it.
bool GCodeWriter::follow_alone(const program::Event& event) {
    std::vector<double> way_mm(following_mm_.size(), 0);
    if (!add_following_travel(program_, event, way_mm)) return false;
    if (!says_following()) return true;
    begin_block();
    motion_word(1);
    following_words();
    double squares = 0;
    for (const double way : way_mm) squares += way * way;
    if (event.dwell_s > 0) put_feed({FeedWord::Kind::per_minute, std::sqrt(squares) / event.dwell_s * 60 / unit_mm()});
    out_.end_line();
    return true;
}

/// G92 E0. What the text says is counted on, so that roundings do not add up.
bool GCodeWriter::count_following(std::string_view words) {
    std::vector<double> count_mm(following_mm_.size(), 0);
    if (!add_following_word(program_.following_letters, words, count_mm)) return false;
    begin_block();
    out_.gap();
    out_.put("G92");
    for (std::size_t i = 0; i < count_mm.size(); ++i) {
        const char letter = program_.following_letters[i];
        if (!words.contains(letter)) continue;
        SaidFollowing& said = said_following_[i];
        const std::int64_t count = following_grid_.steps(count_mm[i] / unit_mm());
        said.origin += following_grid_.value(said.steps) - following_grid_.value(count);
        said.steps = count;
        word({&letter, 1}, following_grid_, count);
    }
    out_.end_line();
    return true;
}

}  // namespace trunnion::nc
