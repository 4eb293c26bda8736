#include "detail/follower.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace trunnion::verify {

namespace {

constexpr std::size_t longest_trail = 2'000'000;
constexpr double tie_mm2 = 1e-12;

}  // namespace

void Follower::step(const Gauge& row) {
    joint_tool_.length_mm = std::numeric_limits<double>::quiet_NaN();
    const std::uint32_t last = last_to_look_at(row);
    advance(row, last);
    drop_hopeless();
    last_row_ = row;
    if (trail_.size() > longest_trail) settle();
}

/// The last piece that begins within the window, and never before those that are still alive.
std::uint32_t Follower::last_to_look_at(const Gauge& row) {
    const auto& pieces = line_.pieces();
    double front = 0, ahead = reach_.window_mm;
    std::uint32_t last = first_;
    if (!now_.empty()) {
        const State& state = now_[best()];
        const double moved = (joint_of(row, {}, line_.flank_mm()) - joint_of(last_row_, {}, line_.flank_mm())).norm();
        front = pieces[first_ + best()].way_mm;
        ahead += 2 * moved;
        moved_since_look_ += moved;
        last += static_cast<std::uint32_t>(now_.size()) - 1;
        const double distance = std::sqrt(state.distance2);
        if (distance > reach_.lost_mm && moved_since_look_ >= 1) {
            ahead += reach_.far_mm + 4 * distance;
            moved_since_look_ = 0;
        }
    }
    while (last + 1 < pieces.size() && pieces[last + 1].way_mm <= front + ahead) ++last;
    return last;
}

/// Square of the distance from a piece's chord.
double Follower::distance2(const Gauge& row, std::size_t index) {
    const auto& piece = line_.pieces()[index];
    if (!(piece.tool == joint_tool_)) {
        joint_tool_ = piece.tool;
        joint_ = joint_of(row, joint_tool_, line_.flank_mm());
    }
    const Joint6 off = joint_ - piece.begin;
    const double share = piece.chord2 > 0 ? std::clamp(off.dot(piece.chord) / piece.chord2, 0.0, 1.0) : 0.0;
    return (off - share * piece.chord).squaredNorm();
}

void Follower::advance(const Gauge& row, std::uint32_t last) {
    const bool begins = now_.empty();
    before_.swap(now_);
    now_.clear();
    rows_.push_back({trail_.size(), first_});
    double entry = begins ? 0.0 : std::numeric_limits<double>::infinity();
    std::uint32_t from = first_;
    for (std::uint32_t piece = first_; piece <= last; ++piece) {
        const std::size_t at = piece - first_;
        if (at < before_.size() && before_[at].cost <= entry) entry = before_[at].cost, from = piece;
        const double square = distance2(row, piece);
        now_.push_back({entry + square, square});
        trail_.push_back(from);
    }
}

void Follower::drop_hopeless() {
    double least = std::numeric_limits<double>::infinity();
    for (const State& state : now_) least = std::min(least, state.cost);
    for (State& state : now_) state.cost -= least;
    const auto alive = [this](const State& state) { return state.cost <= reach_.beam_mm2; };
    const auto begin = std::find_if(now_.begin(), now_.end(), alive);
    const auto end = std::find_if(now_.rbegin(), now_.rend(), alive).base();
    first_ += static_cast<std::uint32_t>(begin - now_.begin());
    now_.erase(end, now_.end());
    now_.erase(now_.begin(), begin);
}

/// The last of the best hypotheses: of equal ones that which has come farthest.
std::size_t Follower::best() const {
    const auto found = std::find_if(now_.rbegin(), now_.rend(), [](const State& s) { return s.cost <= tie_mm2; });
    return static_cast<std::size_t>(now_.rend() - found) - 1;
}

std::uint32_t Follower::before(std::size_t row, std::uint32_t piece) const {
    return trail_[rows_[row].trail + (piece - rows_[row].first)];
}

/// Settles the rows up to where all hypotheses come from one. Where they never do, only the best one lives on.
void Follower::settle() {
    std::vector<std::uint32_t> alive(now_.size());
    for (std::size_t n = 0; n < alive.size(); ++n) alive[n] = first_ + static_cast<std::uint32_t>(n);
    std::size_t row = rows_.size() - 1;
    for (; row > 0 && alive.size() > 1; --row) {
        for (std::uint32_t& piece : alive) piece = before(row, piece);
        std::sort(alive.begin(), alive.end());
        alive.erase(std::unique(alive.begin(), alive.end()), alive.end());
    }
    if (alive.size() == 1) settle_rows(row + 1, alive.front());
    if (trail_.size() <= longest_trail / 2) return;
    const State state = now_[best()];
    first_ += static_cast<std::uint32_t>(best());
    now_.assign(1, state);
    settle_rows(rows_.size(), first_);
}

void Follower::settle_rows(std::size_t count, std::uint32_t piece) {
    const std::size_t begin = settled_.size();
    for (std::size_t row = count; row-- > 0;) {
        settled_.push_back(piece);
        piece = before(row, piece);
    }
    std::reverse(settled_.begin() + static_cast<std::ptrdiff_t>(begin), settled_.end());
    const std::size_t used = count < rows_.size() ? rows_[count].trail : trail_.size();
    trail_.erase(trail_.begin(), trail_.begin() + static_cast<std::ptrdiff_t>(used));
    rows_.erase(rows_.begin(), rows_.begin() + static_cast<std::ptrdiff_t>(count));
    for (Row& row : rows_) row.trail -= used;
}

std::vector<std::uint32_t> Follower::finish() {
    if (!rows_.empty()) settle_rows(rows_.size(), first_ + static_cast<std::uint32_t>(best()));
    return std::move(settled_);
}

std::vector<Place> places_in_order(const ProgrammedLine& line, const std::vector<Gauge>& rows, const Reach& reach) {
    Follower follower(line, reach);
    for (const Gauge& row : rows) follower.step(row);
    const auto pieces = follower.finish();
    std::vector<Place> out;
    out.reserve(rows.size());
    for (std::size_t n = 0; n < rows.size(); ++n) out.push_back(line.refine(rows[n], pieces[n]));
    return out;
}

}  // namespace trunnion::verify
