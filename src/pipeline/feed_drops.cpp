#include "detail/feed_drops.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

namespace trunnion::pipeline {

namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();
constexpr double dropped_below = 0.9;  // of the programmed feed
constexpr double worth_telling_s = 0.005;
constexpr double used_up = 0.9;  // of a tolerance
constexpr double bent = 1e-7;    // mm or rad off the straight within a path piece: less is rounding
constexpr std::size_t many_times = 16;
constexpr double widest_mm = 6;  // block transition at 10 µm, and as the root of the tolerance above (smoothing)

/// Whether rounding or an arc bends the path here: along a straight block the coordinates are linear.
bool is_bent(const path::PathPiece& piece) {
    const auto bends = [](const std::array<double, 8>& c) {
        return std::any_of(c.begin() + 2, c.end(), [](double x) { return std::abs(x) > bent; });
    };
    return std::any_of(piece.coefficient.begin(), piece.coefficient.end(), bends);
}

/// How much the block transition in which the place lies uses of its tolerance; 0 where it lies in none. ToolPath keeps
/// no widths: the nearer end of the block, where the path bends and is not farther from there than widths reach.
double transition_use_at(const path::ToolPath& tool_path, std::size_t path_piece, std::size_t block, double p_mm,
                         double reach_mm) {
    if (!is_bent(tool_path.pieces[path_piece])) return 0;
    const path::BlockSpan& span = tool_path.blocks[block];
    const double to_begin = p_mm - span.begin_mm, to_end = span.end_mm - p_mm;
    if (std::min(to_begin, to_end) > reach_mm) return 0;
    const bool at_begin = to_begin < to_end;
    if (at_begin && block == 0) return 0;
    const std::size_t transition = at_begin ? block - 1 : block;
    return transition < tool_path.transition_use.size() ? tool_path.transition_use[transition] : 0;
}

}  // namespace

FeedDropCollector::FeedDropCollector(double tip_tolerance_mm, std::size_t most)
    : reach_mm_(widest_mm * std::sqrt(std::max(1.0, tip_tolerance_mm / 0.01))), most_(most) {}

void FeedDropCollector::add(const path::AxisPath& path, const feed::StretchPlan& plan, const StretchTable& table) {
    const path::ToolPath& tool_path = path.tool_path();
    if (tool_path.rapid) return;
    std::size_t block = 0;
    for (std::size_t i = 0; i < plan.profile.pieces.size(); ++i) {
        const auto& piece = plan.profile.pieces[i];
        const feed::Cause cause = plan.causes[i];
        if (cause.axis >= 0 && cause.axis < machine::max_axes) limiting_s_[cause.axis] += piece.duration_s;
        const double middle = piece.path_offset_mm + 0.5 * piece.length_mm;
        const double p = tool_path.pieces[piece.path_piece].begin_mm + middle;
        while (block + 1 < tool_path.blocks.size() && p >= tool_path.blocks[block].end_mm) ++block;
        path::AxisSample sample;
        path.evaluate({piece.path_piece, middle}, sample);
        const double tip_rate = std::hypot(sample.tip[0].d1(), sample.tip[1].d1(), sample.tip[2].d1());
        const double programmed = tip_rate * feed::feed_speed_cap(tool_path.blocks[block], sample);
        const double way = table.s_mm[i + 1] - table.s_mm[i];
        const double speed = piece.duration_s > 0 ? way / piece.duration_s : programmed;
        if (!std::isfinite(programmed) || !(programmed > 0) || speed >= dropped_below * programmed) {
            close();
            continue;
        }
        if (!is_open_) {
            open_ = {.line = tool_path.blocks[block].line, .s_from_mm = table.s_mm[i], .feed_min_mm_s = infinite};
            is_open_ = true;
        }
        const double lost = piece.duration_s - way / programmed;
        open_.s_to_mm = table.s_mm[i + 1];
        if (speed < open_.feed_min_mm_s) {
            open_.feed_min_mm_s = speed;
            open_.at_tolerance = transition_use_at(tool_path, piece.path_piece, block, p, reach_mm_) > used_up;
        }
        open_.programmed_feed_mm_s = std::max(open_.programmed_feed_mm_s, programmed);
        open_.lost_s += lost;
        open_causes_[feed::name_of(cause, path.machine())] += lost;
    }
    close();
}

void FeedDropCollector::close() {
    if (!is_open_) return;
    const auto worst = std::max_element(open_causes_.begin(), open_causes_.end(),
                                        [](const auto& a, const auto& b) { return a.second < b.second; });
    open_.cause = worst->first;
    if (open_.lost_s > worth_telling_s) drops_.push_back(open_);
    if (drops_.size() > many_times * most_) drop_the_least();
    open_causes_.clear();
    is_open_ = false;
}

/// What falls out here would fall out among more drops too.
void FeedDropCollector::drop_the_least() {
    if (drops_.size() <= most_) return;
    std::vector<double> lost;
    lost.reserve(drops_.size());
    for (const FeedDrop& drop : drops_) lost.push_back(drop.lost_s);
    std::nth_element(lost.begin(), lost.begin() + static_cast<std::ptrdiff_t>(most_), lost.end(), std::greater<>());
    std::erase_if(drops_, [least = lost[most_]](const FeedDrop& drop) { return drop.lost_s <= least; });
}

std::vector<FeedDrop> FeedDropCollector::take() {
    drop_the_least();
    return std::move(drops_);
}

}  // namespace trunnion::pipeline
