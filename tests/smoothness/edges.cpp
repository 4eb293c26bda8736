// Edges that are meant, between dense blocks whose digits are rounded: they stay edges, and the legs stay where they
// are.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "trunnion/base/quantity.hpp"

#include "planned.hpp"

namespace trunnion::test {
namespace {

constexpr double leg_mm = 30, radius_mm = 100, step_mm = 0.1;

/// Two legs on circles of 100 mm, both bending to the left, with an edge to the left between them at the origin.
struct Legs {
    double edge_rad;
    static constexpr double digit_mm = 1e-3;

    Eigen::Vector2d centre(bool second) const {
        const double heading = second ? edge_rad : 0;
        return radius_mm * Eigen::Vector2d(-std::sin(heading), std::cos(heading));
    }

    /// At a way from the edge, < 0 before it.
    Eigen::Vector2d at(double way_mm) const {
        const bool second = way_mm > 0;
        const double heading = (second ? edge_rad : 0) + way_mm / radius_mm;
        return centre(second) + radius_mm * Eigen::Vector2d(std::sin(heading), -std::cos(heading));
    }

    /// How far outside, to the right of the leg.
    double outside_mm(bool second, const Eigen::Vector2d& tip) const {
        return (tip - centre(second)).norm() - radius_mm;
    }

    path::Run run() const {
        path::Run run;
        run.kinematics = &table_kinematics();
        const int count = static_cast<int>(std::lround(leg_mm / step_mm));
        for (int k = -count; k <= count; ++k) {
            const Eigen::Vector2d tip = (at(k * step_mm) / digit_mm).array().round().matrix() * digit_mm;
            run.vertices.push_back({{tip.x(), tip.y(), 0}, {0, 0, 1}});
            if (run.vertices.size() == 1) continue;
            path::Block block;
            block.length_mm = path::block_length_mm(run, run.vertices.end()[-2], run.vertices.back());
            block.feed = {program::FeedRule::tip_speed, 10000.0 / 60};
            block.line = k;
            run.blocks.push_back(block);
        }
        return run;
    }
};

struct Found {
    double from_edge_mm = 1e9;  ///< the path's nearest place to the edge
    double bulge_mm = 0;        ///< outside of the legs
    double inside_mm = 0;       ///< inside of the legs, farther than 2 mm from the edge and 8 mm from the ends
    double near_ends_mm = 0;    ///< off the legs nearer to the ends of the run
};

Found look(const Legs& legs, const path::ToolPath& path) {
    const double edge_at = path.blocks[path.blocks.size() / 2].begin_mm;
    Found found;
    for (const path::PathPiece& piece : path.pieces)
        for (int k = 0; k <= 50; ++k) {
            const double offset = piece.length_mm * k / 50, p = piece.begin_mm + offset;
            const auto q = path::evaluate(piece, offset);
            const Eigen::Vector2d tip(q[0].value(), q[1].value());
            found.from_edge_mm = std::min(found.from_edge_mm, tip.norm());
            const double outside = legs.outside_mm(p > edge_at, tip);
            found.bulge_mm = std::max(found.bulge_mm, outside);
            if (std::min(p, path.length_mm() - p) < 8) {
                found.near_ends_mm = std::max(found.near_ends_mm, std::abs(outside));
            } else if (std::abs(p - edge_at) > 2) {
                found.inside_mm = std::max(found.inside_mm, -outside);
            }
        }
    return found;
}

struct Edge {
    int degrees;
    double most_s;
};

class DenseEdge : public testing::TestWithParam<Edge> {};

TEST_P(DenseEdge, StaysBetweenLegsThatDoNotBulge) {
    const auto [degrees, most_s] = GetParam();
    const Legs legs{degrees * degree};
    const Planned planned(smoothed_to_one(legs.run()));
    const Found found = look(legs, planned.path());
    fmt::print(
        "{:>2} deg: {:.4f} s, {:.2f} um from the edge, bound {:.2f} um; legs: {:.2f} um outside, {:.2f} um inside, "
        "near ends {:.2f} um off\n",
        degrees, planned.duration_s(), 1e3 * found.from_edge_mm, 1e3 * planned.path().bound.tip_mm,
        1e3 * found.bulge_mm, 1e3 * found.inside_mm, 1e3 * found.near_ends_mm);
    constexpr double noise_mm = 0.71 * Legs::digit_mm;
    EXPECT_LE(planned.path().bound.tip_mm, 0.01);
    EXPECT_LE(found.from_edge_mm, 0.01 + noise_mm);
    EXPECT_LE(found.bulge_mm, 1e-3 + noise_mm);
    EXPECT_LE(found.inside_mm, 1e-3 + noise_mm);
    EXPECT_LE(planned.duration_s(), most_s);
}

INSTANTIATE_TEST_SUITE_P(Of, DenseEdge,
                         testing::Values(Edge{90, 1.14}, Edge{30, 1.11}, Edge{10, 1.105}, Edge{3, 0.995}),
                         [](const auto& which) { return fmt::format("{}_degrees", which.param.degrees); });

}  // namespace
}  // namespace trunnion::test
