#include "detail/path_samples.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "trunnion/feed/plan_stretch.hpp"

namespace trunnion::pipeline {

namespace {

/// ṗ that programmed feed and axis velocities allow at a place.
double speed_limit(const path::AxisSample& sample, const path::BlockSpan& block, const machine::Machine& machine,
                   bool rapid) {
    double limit = std::numeric_limits<double>::infinity();
    for (int i = 0; i < machine.axis_count; ++i) {
        const auto& limits = rapid ? machine.axes[i].rapid : machine.axes[i].feed;
        const double rate = std::abs(sample.axes[i].d1());
        if (rate > 0) limit = std::min(limit, limits.velocity / rate);
    }
    const double cap = feed::feed_speed_cap(block, sample);
    return std::min(limit, cap);
}

}  // namespace

void hand_out_path_samples(const path::AxisPath& path, const motion::FeedProfile& profile, const StretchTable& table,
                           double p_begin_mm, double flank_height_mm, PlanObserver& observer) {
    const path::ToolPath& tool_path = path.tool_path();
    constexpr int parts = 4;
    std::size_t block = 0;
    for (std::size_t i = 0; i < profile.pieces.size(); ++i) {
        const auto& piece = profile.pieces[i];
        const bool last = i + 1 == profile.pieces.size();
        for (int k = 0; k < parts + (last ? 1 : 0); ++k) {
            const double delta = piece.length_mm * k / parts;
            path::AxisSample at;
            path.evaluate({piece.path_piece, piece.path_offset_mm + delta}, at);
            PathSample out;
            const double p = table.p_mm[i] + delta;
            while (block + 1 < tool_path.blocks.size() && p >= tool_path.blocks[block].end_mm) ++block;
            out.p_mm = p_begin_mm + p;
            out.tip_mm = {at.tip[0].value(), at.tip[1].value(), at.tip[2].value()};
            out.axis = {at.tool_axis[0].value(), at.tool_axis[1].value(), at.tool_axis[2].value()};
            out.s_mm = table.s_mm[i] + (out.tip_mm - table.tip_mm[i]).norm();
            out.speed_mm_s = motion::state_at(piece, delta).speed_mm_s;
            out.speed_limit_mm_s = speed_limit(at, tool_path.blocks[block], path.machine(), tool_path.rapid);
            Eigen::Vector3d top;
            for (int c = 0; c < 3; ++c) top[c] = at.tip[c].d1() + flank_height_mm * at.tool_axis[c].d1();
            out.feed_top_mm_s = top.norm() * out.speed_mm_s;
            out.axes = at.axes;
            observer.path_sample(out);
        }
    }
}

}  // namespace trunnion::pipeline
