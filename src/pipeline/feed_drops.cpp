#include "detail/feed_drops.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace trunnion::pipeline {

namespace {

constexpr double dropped_below = 0.9;  // of the programmed feed
constexpr double worth_telling_s = 0.005;

}  // namespace

void FeedDropCollector::add(const path::AxisPath& path, const feed::StretchPlan& plan, const StretchTable& table) {
    const path::ToolPath& tool_path = path.tool_path();
    if (tool_path.rapid) return;
    std::size_t block = 0;
    for (std::size_t i = 0; i < plan.profile.pieces.size(); ++i) {
        const auto& piece = plan.profile.pieces[i];
        const feed::Cause cause = plan.causes[i];
        if (cause.axis >= 0) limiting_s_[cause.axis] += piece.duration_s;
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
            open_ = {.line = tool_path.blocks[block].line, .s_from_mm = table.s_mm[i], .feed_min_mm_s = speed};
            is_open_ = true;
        }
        const double lost = piece.duration_s - way / programmed;
        open_.s_to_mm = table.s_mm[i + 1];
        open_.feed_min_mm_s = std::min(open_.feed_min_mm_s, speed);
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
    open_causes_.clear();
    is_open_ = false;
}

std::vector<FeedDrop> FeedDropCollector::take(std::size_t most) {
    if (drops_.size() > most) {
        std::vector<double> lost;
        lost.reserve(drops_.size());
        for (const FeedDrop& drop : drops_) lost.push_back(drop.lost_s);
        std::nth_element(lost.begin(), lost.begin() + static_cast<std::ptrdiff_t>(most), lost.end(), std::greater<>());
        std::erase_if(drops_, [least = lost[most]](const FeedDrop& drop) { return drop.lost_s <= least; });
    }
    return std::move(drops_);
}

}  // namespace trunnion::pipeline
