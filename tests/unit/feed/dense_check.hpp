#pragma once

#include <algorithm>
#include <cmath>

#include "trunnion/feed/plan_stretch.hpp"

namespace trunnion::test {

/// Worst ratio of any axis limit and of a tip_speed feed at evenly spaced points of every profile piece, straight from
/// the path: q̇ = q′ṗ, q̈ = q″ṗ² + q′p̈, q⃛ = q‴ṗ³ + 3q″ṗp̈ + q′p⃛. Infinite where something is not finite.
inline double worst_ratio(const path::AxisPath& path, const motion::FeedProfile& profile, int points = 16) {
    double worst = 0;
    for (const motion::ProfilePiece& piece : profile.pieces)
        for (int k = 0; k <= points; ++k) {
            const double delta = piece.length_mm * k / points;
            path::AxisSample at;
            path.evaluate({piece.path_piece, piece.path_offset_mm + delta}, at);
            const motion::PathState s = motion::state_at(piece, delta);
            const double v = s.speed_mm_s, a = s.acceleration_mm_s2;
            for (int i = 0; i < path.axis_count(); ++i) {
                const machine::AxisLimits& limit =
                    path.tool_path().rapid ? path.machine().axes[i].rapid : path.machine().axes[i].feed;
                const Taylor3& q = at.axes[i];
                const double jerk = q.d3() * v * v * v + 3 * q.d2() * v * a + q.d1() * s.jerk_mm_s3;
                const double ratio =
                    std::max({std::abs(q.d1() * v) / limit.velocity,
                              std::abs(q.d2() * v * v + q.d1() * a) / limit.acceleration, std::abs(jerk) / limit.jerk});
                if (!std::isfinite(ratio)) return ratio;
                worst = std::max(worst, ratio);
            }
            const path::Feed& feed = path.tool_path().blocks.front().feed;
            if (feed.rule == path::FeedRule::tip_speed) worst = std::max(worst, v * at.feed_rate / feed.value);
        }
    return worst;
}

/// Largest jump of ṗ relative to its neighbours, or of position in the path, from one piece to the next.
inline double worst_joint(const path::AxisPath& path, const motion::FeedProfile& profile) {
    double worst = 0;
    const auto& pieces = path.tool_path().pieces;
    for (std::size_t k = 0; k + 1 < profile.pieces.size(); ++k) {
        const motion::ProfilePiece &a = profile.pieces[k], &b = profile.pieces[k + 1];
        const double v0 = motion::state_at(a, a.length_mm).speed_mm_s, v1 = motion::state_at(b, 0).speed_mm_s;
        worst = std::max(worst, std::abs(v0 - v1) / std::max(v0, v1));
        const double end = pieces[a.path_piece].begin_mm + a.path_offset_mm + a.length_mm;
        worst = std::max(worst, std::abs(end - pieces[b.path_piece].begin_mm - b.path_offset_mm) / path.length_mm());
        worst = std::max(worst, std::abs(a.begin_s + a.duration_s - b.begin_s) / profile.duration_s());
    }
    return worst;
}

}  // namespace trunnion::test
