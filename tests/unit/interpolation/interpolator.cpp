#include "trunnion/interpolation/interpolator.hpp"

#include <gtest/gtest.h>

namespace trunnion::interpolation {
namespace {

using motion::ProfilePiece;
using path::AxisPath;
using path::ToolPath;

/// Three linear axes, everything along X.
struct Straight {
    machine::Machine machine;
    machine::Kinematics kinematics = make();
    ToolPath tool_path;
    motion::FeedProfile profile;

    machine::Kinematics make() {
        machine.axis_count = 3;
        machine.chain = {0, 1, 2};
        for (int i = 0; i < 3; ++i) {
            machine.axes[i].letter = "XYZ"[i];
            machine.axes[i].direction = Eigen::Vector3d::Unit(i);
        }
        return machine::Kinematics::make(machine, {}, 0).value();
    }

    /// Constant jerk 600 for 0.1 s (0.1 mm), its mirror in the middle at constant x″ … down to a stop: 0.1 + 0.2 + 0.1
    /// mm.
    Straight() {
        tool_path.kinematics = &kinematics;
        for (int k = 0; k < 2; ++k) {
            path::PathPiece piece{0.2 * k, 0.2, {}};
            piece.coefficient[0] = {5 + 0.2 * k, 0.2};
            piece.coefficient[5] = {1};
            tool_path.pieces.push_back(piece);
        }
        tool_path.blocks = {{0, 0.15, {}, 11, 0.15}, {0.15, 0.4, {}, 12, 0.25}};
        const double v = 3.0;  // 600·0.1²/2
        const auto add = [&](ProfilePiece::Kind kind, std::size_t piece, double offset, double length,
                             double duration) {
            ProfilePiece p{.kind = kind, .path_piece = piece, .path_offset_mm = offset, .length_mm = length};
            p.begin_s = profile.duration_s();
            p.duration_s = duration;
            p.x0 = v * v;
            p.jerk_mm_s3 = 600;
            profile.pieces.push_back(p);
        };
        add(ProfilePiece::Kind::rest_start, 0, 0, 0.1, 0.1);
        add(ProfilePiece::Kind::cubic, 0, 0.1, 0.1, 0.1 / v);
        add(ProfilePiece::Kind::cubic, 1, 0.0, 0.1, 0.1 / v);
        add(ProfilePiece::Kind::rest_stop, 1, 0.1, 0.1, 0.1);
    }
};

TEST(Interpolator, follows_the_time_law_through_pieces_and_blocks) {
    const Straight s;
    const auto path = AxisPath::make(s.tool_path, s.machine, {});
    ASSERT_TRUE(path);
    Interpolator interpolator(*path, s.profile);
    const double cruise = 0.2 / 3.0, end = 0.2 + cruise;
    EXPECT_NEAR(interpolator.duration_s(), end, 1e-15);
    for (int k = 0; k <= 1000; ++k) {
        const double t = end * k / 1000;
        double p = 0;
        if (t < 0.1)
            p = 100 * t * t * t;
        else if (t < 0.1 + cruise)
            p = 0.1 + 3.0 * (t - 0.1);
        else
            p = 0.4 - 100 * std::pow(end - t, 3);
        const Instant now = interpolator.at(t);
        EXPECT_NEAR(now.position[0], 5 + p, 1e-12) << t;
        EXPECT_EQ(now.block, p >= 0.15 ? 1u : 0u) << t;
    }
}

TEST(Interpolator, stands_before_the_start_and_behind_the_end) {
    const Straight s;
    const auto path = AxisPath::make(s.tool_path, s.machine, {});
    Interpolator interpolator(*path, s.profile);
    EXPECT_EQ(interpolator.at(-1).position[0], 5);
    EXPECT_EQ(interpolator.at(0).tip_speed_mm_s, 0);
    const Instant end = interpolator.at(10);
    EXPECT_NEAR(end.position[0], 5.4, 1e-13);
    EXPECT_EQ(end.tip_speed_mm_s, 0);
}

}  // namespace
}  // namespace trunnion::interpolation
