#include <gtest/gtest.h>

#include "made_motions.hpp"

namespace trunnion::verify::test {
namespace {

using Tips = std::vector<Eigen::Vector3d>;

Verdict verdict_of(const SetpointTable& motion, const std::vector<ProgrammedPose>& poses, CheckOptions options = {}) {
    auto verdict = check(motion, poses, boundless(), peer_setup(), options);
    EXPECT_TRUE(verdict) << (verdict ? "" : to_string(verdict.error()));
    return verdict.value_or(Verdict{});
}

CheckOptions tip_tolerance(double mm) {
    CheckOptions out;
    out.tip_tolerance_mm = mm;
    return out;
}

TEST(Deviations, CornerCutByAKnownAmount) {
    const Tips corner{{0, 0, 0}, {50, 0, 0}, {50, 50, 0}};
    const auto motion = along({{0, 0, 0}, {49.9, 0, 0}, {50, 0.1, 0}, {50, 50, 0}}, 0.01);
    auto v = verdict_of(motion, poses_at(corner), tip_tolerance(0.08));
    EXPECT_TRUE(v.ok) << broken_things(v);
    EXPECT_NEAR(v.tip_deviation_mm, 0.05, 5e-3);
    EXPECT_NEAR(v.tip_to_poses_mm, 0.1 / std::sqrt(2), 1e-9);
    EXPECT_NEAR(v.height_deviation_mm, v.tip_deviation_mm, 1e-9);
    EXPECT_LT(v.orientation_deviation_deg, 1e-9);
    EXPECT_EQ(v.path_covered, 1);

    v = verdict_of(motion, poses_at(corner), tip_tolerance(0.06));
    EXPECT_TRUE(only_broken(v, {"tip_to_poses_mm"})) << broken_things(v);
    EXPECT_EQ(v.first_of("tip_to_poses_mm")->line, 1);
    EXPECT_NEAR(v.first_of("tip_to_poses_mm")->time_s, 4.997, 0.003);
    EXPECT_NEAR(v.first_of("tip_to_poses_mm")->limit, 0.06, 1e-12);

    v = verdict_of(motion, poses_at(corner), tip_tolerance(0.03));
    EXPECT_TRUE(only_broken(v, {"tip_to_poses_mm", "tip_deviation_mm"})) << broken_things(v);
    const auto* first = v.first_of("tip_deviation_mm");
    EXPECT_NEAR(first->time_s, 4.990 + 0.005, 0.0021);  // 0.03 mm off after 0.03·√2 of the cut
    EXPECT_GT(first->value, 0.03);
    EXPECT_LT(first->value, 0.04);
    EXPECT_EQ(first->line, 1);
}

TEST(Deviations, SkippedSpikeIsMissedByItsPose) {
    const auto poses = poses_at({{0, 0, 0}, {20, 0, 0}, {20, 10, 0}, {20, 0, 0}, {40, 0, 0}});
    const auto v = verdict_of(along({{0, 0, 0}, {40, 0, 0}}, 0.05), poses);
    EXPECT_FALSE(v.ok);
    ASSERT_TRUE(v.first_of("tip_to_poses_mm"));
    EXPECT_NEAR(v.tip_to_poses_mm, 10, 1e-9);
    EXPECT_EQ(v.first_of("tip_to_poses_mm")->line, 2);
    EXPECT_NEAR(v.first_of("tip_to_poses_mm")->time_s, 0.4, 0.0021);
    EXPECT_LT(v.tip_deviation_mm, 0.2);  // until the path is found again
    EXPECT_EQ(v.path_covered, 1);
}

TEST(Deviations, SkippedSideOfASquareIsFound) {
    const auto poses = poses_at({{0, 0, 0}, {30, 0, 0}, {30, 30, 0}, {0, 30, 0}});
    const auto v = verdict_of(along({{0, 0, 0}, {30, 0, 0}, {0, 30, 0}}, 0.05), poses);
    EXPECT_FALSE(v.ok);
    EXPECT_GT(v.tip_deviation_mm, 10);
    EXPECT_NEAR(v.first_of("tip_deviation_mm")->time_s, 0.601, 0.0011);
    EXPECT_NEAR(v.tip_to_poses_mm, 30 / std::sqrt(2), 0.1);
    EXPECT_EQ(v.first_of("tip_to_poses_mm")->line, 2);
}

TEST(Deviations, RunningBackwardsIsNotFollowing) {
    const auto v = verdict_of(along({{100, 0, 0}, {0, 0, 0}}, 0.1), poses_at({{0, 0, 0}, {100, 0, 0}}));
    EXPECT_FALSE(v.ok);
    EXPECT_NEAR(v.start_error_mm, 100, 1e-9);
    EXPECT_NEAR(v.end_error_mm, 100, 1e-9);
    EXPECT_TRUE(v.first_of("start_error_mm"));
    EXPECT_TRUE(v.first_of("end_error_mm"));
    EXPECT_EQ(v.first_of("start_error_mm")->time_s, 0);
    EXPECT_GT(v.tip_deviation_mm, 50);
}

TEST(Deviations, GoingBackOnTheWayIsFound) {
    const auto poses = poses_at({{0, 0, 0}, {100, 0, 0}});
    const auto v = verdict_of(along({{0, 0, 0}, {60, 0, 0}, {55, 0, 0}, {100, 0, 0}}, 0.1), poses);
    EXPECT_TRUE(only_broken(v, {"tip_deviation_mm"})) << broken_things(v);
    EXPECT_GT(v.tip_deviation_mm, 2.4);  // half of it where the places stand in the middle
    EXPECT_LT(v.tip_deviation_mm, 5.1);
    EXPECT_NEAR(v.first_of("tip_deviation_mm")->time_s, 0.59, 0.02);
}

TEST(Deviations, ReversalIsFollowedInOrder) {
    const Tips there_and_back{{0, 0, 0}, {10, 0, 0}, {0, 0, 0}, {10, 0, 0}};
    for (const double step : {0.001, 0.1}) {
        const auto v = verdict_of(along(there_and_back, step), poses_at(there_and_back));
        EXPECT_TRUE(v.ok) << broken_things(v);
        EXPECT_LT(v.tip_deviation_mm, 1e-9);
    }
    // turning 0.2 mm too early, the last time not at all
    const auto early =
        verdict_of(along({{0, 0, 0}, {9.8, 0, 0}, {0, 0, 0}, {10, 0, 0}}, 0.01), poses_at(there_and_back));
    EXPECT_TRUE(only_broken(early, {"tip_to_poses_mm"})) << broken_things(early);
    EXPECT_NEAR(early.tip_to_poses_mm, 0.2, 1e-9);
    const auto once = verdict_of(along({{0, 0, 0}, {10, 0, 0}}, 0.01), poses_at(there_and_back));
    EXPECT_FALSE(once.ok);
    EXPECT_LT(once.path_covered, 0.5);
    EXPECT_TRUE(once.first_of("path_covered"));
    EXPECT_TRUE(once.first_of("tip_to_poses_mm"));
}

/// Passes 0.03 mm apart, the motion 0.02 mm off towards the next one: only the order tells which one is meant.
TEST(Deviations, RasterPassesThatNearlyTouch) {
    Tips passes, shifted;
    for (int n = 0; n < 8; ++n)
        for (const bool begin : {true, false}) {
            passes.emplace_back((n % 2 == 0) == begin ? 0.0 : 10.0, 0.03 * n, 0.0);
            shifted.emplace_back(passes.back() + Eigen::Vector3d(0, 0.02, 0));
        }
    const auto v = verdict_of(along(shifted, 0.007), poses_at(passes), tip_tolerance(0.021));
    EXPECT_TRUE(v.ok) << broken_things(v);
    EXPECT_NEAR(v.tip_deviation_mm, 0.02, 1e-9);
    EXPECT_NEAR(v.tip_to_poses_mm, 0.02, 1e-9);
    EXPECT_FALSE(verdict_of(along(shifted, 0.007), poses_at(passes), tip_tolerance(0.015)).ok);
}

TEST(Deviations, ASecondRoundIsNotTheFirst) {
    Tips once;
    for (int n = 0; n <= 72; ++n) once.emplace_back(10 * std::cos(n * 5 * degree), 10 * std::sin(n * 5 * degree), 0);
    Tips twice = once;
    twice.insert(twice.end(), once.begin() + 1, once.end());
    EXPECT_TRUE(verdict_of(along(twice, 0.02), poses_at(twice)).ok);
    const auto v = verdict_of(along(once, 0.02), poses_at(twice));
    EXPECT_TRUE(v.first_of("path_covered")) << broken_things(v);
    EXPECT_NEAR(v.path_covered, 0.5, 0.01);
}

/// A third of a millimetre long, on the spot where the path comes by again: the place of the second coming is nearer to
/// the shifted rows than the corner of the first.
TEST(Deviations, ASmallLoopThatEndsWhereItBegan) {
    const Tips loop{{-0.11, 0.069, 0},  {-0.044, -0.043, 0}, {-0.003, -0.051, 0}, {0.044, 0.026, 0},
                    {-0.033, 0.007, 0}, {-0.003, -0.051, 0}, {-0.003, -0.051, 2}};
    Tips shifted;
    for (const auto& tip : loop) shifted.emplace_back(tip + Eigen::Vector3d(0.008, 0.012, 0));
    const double off = std::hypot(0.008, 0.012);
    const auto v = verdict_of(along(shifted, 0.002), poses_at(loop), tip_tolerance(1.001 * off));
    EXPECT_TRUE(v.ok) << broken_things(v);
    EXPECT_GT(v.tip_deviation_mm, 0.9 * off);

    Tips left_out = loop;
    left_out.erase(left_out.begin() + 3, left_out.begin() + 6);
    const auto missed = verdict_of(along(left_out, 0.002), poses_at(loop));
    EXPECT_TRUE(only_broken(missed, {"tip_to_poses_mm"})) << broken_things(missed);
    EXPECT_NEAR(missed.tip_to_poses_mm, std::hypot(0.047, 0.077), 1e-9);
}

/// Near the pole C goes a long way while the tool hardly turns: C's reversal is cut short by what the tolerance allows.
TEST(Deviations, ReversalOfARotaryAxisNearThePole) {
    const Eigen::Vector3d tip(10, -4, 39), lift(0, 0, 0.05);
    const double a = 14 * degree, forth = 28 * degree, back = -38 * degree;
    const std::vector poses{pose_by_words(tip, a, 0, 1), pose_by_words(tip + lift, a, forth, 2),
                            pose_by_words(tip, a, back, 3)};
    const auto turned_short_by = [&](double angle) {
        std::vector<motion::Setpoint> rows;
        const auto add = [&](double share_of_forth, double c) {
            rows.push_back(row(rows.size(), axes_for(tip + share_of_forth * lift, a, c)));
        };
        for (double c = 0; c < forth - angle; c += 0.01 * degree) add(c / forth, c);
        for (double c = forth - angle; c > back; c -= 0.01 * degree) add((c - back) / (forth - back), c);
        add(0, back);
        return verdict_of(*setpoint_table(rows), poses);
    };
    const auto kept = turned_short_by(0.4 * degree);
    EXPECT_TRUE(kept.ok) << broken_things(kept);
    EXPECT_NEAR(kept.orientation_to_poses_deg, 0.4 * std::sin(a), 0.01);
    const auto cut = turned_short_by(1 * degree);
    EXPECT_TRUE(only_broken(cut, {"orientation_to_poses_deg"})) << broken_things(cut);
    EXPECT_NEAR(cut.orientation_to_poses_deg, std::sin(a), 0.01);
}

/// A pose is passed with the axis off, and nearer in tip and axis together, but too far by the tip, on the next pass.
TEST(Deviations, APosePassedByTheRightBranchIsKept) {
    const Tips passes{{0, 0, 0}, {2, 0, 0}, {2, 0.035, 0}, {0, 0.035, 0}};
    const auto tilted_by = [&](double angle, double tip_off) {
        std::vector<motion::Setpoint> rows;
        const auto add = [&](double x, double y, double a) {
            rows.push_back(row(rows.size(), axes_for({x, y, 0}, a, 0)));
        };
        for (int n = 0; n <= 400; ++n) add(0.005 * n, -tip_off, angle);
        for (int n = 1; n <= 20; ++n) add(2, n * (0.035 + tip_off) / 20 - tip_off, angle * (20 - n) / 20);
        for (int n = 400; n >= 0; --n) add(0.005 * n, 0.035, 0);
        return verdict_of(*setpoint_table(rows), poses_at(passes));
    };
    const auto kept = tilted_by(0.08 * degree, 0.005);
    EXPECT_TRUE(kept.ok) << broken_things(kept);
    EXPECT_NEAR(kept.orientation_to_poses_deg, 0.08, 1e-3);
    const auto tip_off = tilted_by(0.08 * degree, 0.025);
    EXPECT_TRUE(tip_off.first_of("tip_to_poses_mm")) << broken_things(tip_off);
    const auto turned_off = tilted_by(0.12 * degree, 0.005);
    EXPECT_FALSE(turned_off.ok);
}

/// While the tool turns fast the nearest place is that of the axis: a tip that lags behind it has a place in between
/// that keeps both tolerances, or none.
TEST(Deviations, ALaggingTipIsJudgedWhereBothTolerancesAreKept) {
    const double turn = 30 * degree;
    const std::vector poses{pose({0, 0, 0}, 1, axis_of(0, 0)), pose({1, 0, 0}, 2, axis_of(turn, 0))};
    const auto lagging_by = [&](double lag) {
        std::vector<motion::Setpoint> rows;
        for (int n = 0; n <= 2000; ++n) {
            const double u = n / 2000.0;
            rows.push_back(row(rows.size(), axes_for({u - lag * std::sin(180 * degree * u), 0, 0}, u * turn, 0)));
        }
        return verdict_of(*setpoint_table(rows), poses);
    };
    const auto kept = lagging_by(0.0205);
    EXPECT_TRUE(kept.ok) << broken_things(kept);
    EXPECT_GT(kept.tip_deviation_mm, 0.018);
    const auto broken = lagging_by(0.03);
    EXPECT_TRUE(only_broken(broken, {"tip_deviation_mm"})) << broken_things(broken);
    EXPECT_NEAR(broken.tip_deviation_mm, 0.03, 5e-4);
}

TEST(Deviations, StandingStill) {
    const auto motion = along({{3, 4, 0}, {3, 4, 0}, {3, 4, 0}}, 1);
    EXPECT_TRUE(verdict_of(motion, poses_at({{3, 4, 0}})).ok);
    EXPECT_TRUE(verdict_of(motion, poses_at({{3, 4, 0}, {3, 4, 0}})).ok);
    const auto v = verdict_of(motion, poses_at({{3, 4, 0}, {8, 4, 0}}));
    EXPECT_TRUE(only_broken(v, {"path_covered", "end_error_mm", "tip_to_poses_mm"})) << broken_things(v);
    EXPECT_EQ(v.path_covered, 0);
    EXPECT_NEAR(v.end_error_mm, 5, 1e-9);
}

TEST(Deviations, LongStandstillOnTheWay) {
    auto motion = along({{0, 0, 0}, {5, 0, 0}, {10, 0, 0}}, 0.05);
    std::vector<motion::Setpoint> rows(motion.rows.begin(), motion.rows.begin() + 101);
    rows.insert(rows.end(), 10000, rows.back());
    rows.insert(rows.end(), motion.rows.begin() + 101, motion.rows.end());
    for (std::size_t n = 0; n < rows.size(); ++n) rows[n].time_s = static_cast<double>(n) * period_s;
    EXPECT_TRUE(verdict_of(*setpoint_table(rows), poses_at({{0, 0, 0}, {5, 0, 0}, {10, 0, 0}})).ok);
}

/// Blocks of 5 µm: many hypotheses live at once and are settled in between.
TEST(Deviations, DenseBlocks) {
    Tips dense;
    for (int n = 0; n <= 20000; ++n) dense.emplace_back(n * 0.005, 0.5 * std::sin(n * 0.005), 0);
    const auto motion = along(dense, 0.0025);
    const auto v = verdict_of(motion, poses_at(dense));
    EXPECT_TRUE(v.ok) << broken_things(v);
    EXPECT_LT(v.tip_deviation_mm, 1e-9);
    auto off = motion;
    off.rows[30000].position[1] += 0.05;
    const auto w = verdict_of(off, poses_at(dense));
    EXPECT_TRUE(only_broken(w, {"tip_deviation_mm"})) << broken_things(w);
    EXPECT_NEAR(w.first_of("tip_deviation_mm")->time_s, 30.0, 1e-9);
    EXPECT_GT(w.tip_deviation_mm, 0.04);
}

SetpointTable turning(double a0, double a1, double c0, double c1, Eigen::Vector3d tip, int count = 1000) {
    std::vector<motion::Setpoint> rows;
    for (int n = 0; n <= count; ++n) {
        const double w = static_cast<double>(n) / count;
        rows.push_back(row(rows.size(), axes_for(tip, a0 + w * (a1 - a0), c0 + w * (c1 - c0))));
    }
    return *setpoint_table(std::move(rows));
}

TEST(Deviations, PureRotationAboutTheTip) {
    const Eigen::Vector3d tip(7, -3, 12);
    const auto v = verdict_of(turning(0, 90 * degree, 0, 0, tip),
                              {pose_by_words(tip, 0, 0, 1), pose_by_words(tip, 90 * degree, 0, 2)});
    EXPECT_TRUE(v.ok) << broken_things(v);
    EXPECT_LT(v.tip_deviation_mm, 1e-9);
    EXPECT_LT(v.orientation_deviation_deg, 1e-6);
    EXPECT_EQ(v.path_covered, 1);
}

TEST(Deviations, WindingOverManyTurns) {
    const Eigen::Vector3d tip(1, 2, 3);
    const double many = 3600 * degree;
    const std::vector poses{pose_by_words(tip, 20 * degree, 0, 1), pose_by_words(tip, 20 * degree, many, 2)};
    const auto v = verdict_of(turning(20 * degree, 20 * degree, 0, many, tip, 20000), poses);
    EXPECT_TRUE(v.ok) << broken_things(v);
    EXPECT_LT(v.orientation_deviation_deg, 1e-6);
    const auto short_of = verdict_of(turning(20 * degree, 20 * degree, 0, many - 360 * degree, tip, 20000), poses);
    EXPECT_TRUE(only_broken(short_of, {"path_covered"})) << broken_things(short_of);
    EXPECT_NEAR(short_of.path_covered, 0.9, 1e-6);
}

/// Between C0 and C90 at A10 the two laws are 2.9° apart (10° − atan(tan 10° cos 45°)).
TEST(Deviations, TheLawOfTheOrientationMatters) {
    const Eigen::Vector3d tip(0, 0, 0);
    const std::vector words{pose_by_words(tip, 10 * degree, 0, 1), pose_by_words(tip, 10 * degree, 90 * degree, 2)};
    auto vectors = words;
    for (auto& p : vectors) p.kind = PoseKind::vector;
    const auto motion = turning(10 * degree, 10 * degree, 0, 90 * degree, tip);
    EXPECT_TRUE(verdict_of(motion, words).ok);
    const auto v = verdict_of(motion, vectors);
    EXPECT_TRUE(only_broken(v, {"orientation_deviation_deg"})) << broken_things(v);
    EXPECT_NEAR(v.orientation_deviation_deg, 10 - std::atan(std::tan(10 * degree) * std::cos(45 * degree)) / degree,
                1e-4);
    EXPECT_LT(v.tip_deviation_mm, 1e-9);
}

TEST(Deviations, VectorLawIsExactOnLongTurns) {
    const Eigen::Vector3d from(0, 0, 0), to(40, 0, 0);
    const Eigen::Vector3d u = Eigen::Vector3d(0.5, 0.2, 1).normalized(),
                          v = Eigen::Vector3d(-0.7, 0.6, 0.4).normalized();
    const double angle = std::acos(u.dot(v));
    std::vector<motion::Setpoint> rows;
    for (int n = 0; n <= 1000; ++n) {
        const double w = n / 1000.0;
        const auto [a, c] = words_for((std::sin((1 - w) * angle) * u + std::sin(w * angle) * v) / std::sin(angle));
        rows.push_back(row(rows.size(), axes_for(from + w * (to - from), a, c)));
    }
    const auto verdict = verdict_of(*setpoint_table(rows), {pose(from, 1, u), pose(to, 2, v)});
    EXPECT_TRUE(verdict.ok) << broken_things(verdict);
    EXPECT_LT(verdict.tip_deviation_mm, 1e-7);
    EXPECT_LT(verdict.orientation_deviation_deg, 1e-6);
    EXPECT_EQ(verdict.path_covered, 1);
}

TEST(Deviations, OrientationByAngleOrByFlank) {
    // the tool leans by 0.2° all the way: 0.105 mm at 30 mm
    const auto motion = along({{0, 0, 0}, {20, 0, 0}}, 0.05, 0.2 * degree);
    const auto poses = poses_at({{0, 0, 0}, {20, 0, 0}});
    auto v = verdict_of(motion, poses);
    EXPECT_TRUE(only_broken(v, {"orientation_deviation_deg", "orientation_to_poses_deg"})) << broken_things(v);
    EXPECT_NEAR(v.orientation_deviation_deg, 0.2, 1e-9);
    EXPECT_NEAR(v.height_deviation_mm, 2 * 30 * std::sin(0.1 * degree), 1e-9);
    EXPECT_NEAR(v.first_of("orientation_deviation_deg")->value, 0.2, 1e-9);
    EXPECT_NEAR(v.first_of("orientation_deviation_deg")->limit, 0.1, 1e-9);

    CheckOptions flank;
    flank.flank_tolerance_mm = 0.11;
    EXPECT_TRUE(verdict_of(motion, poses, flank).ok);
    flank.flank_tolerance_mm = 0.1;
    v = verdict_of(motion, poses, flank);
    EXPECT_TRUE(only_broken(v, {"height_deviation_mm", "height_to_poses_mm"})) << broken_things(v);
    flank.flank_height_mm = 20;
    EXPECT_TRUE(verdict_of(motion, poses, flank).ok);
}

/// The ball's centre keeps its line while the tool leans: the tip does not.
TEST(Deviations, ControlledPointMayBeUpTheAxis) {
    const double lean = 0.05 * degree, radius = 30;
    const Eigen::Vector3d off = radius * (Eigen::Vector3d::UnitZ() - axis_of(lean, 0));
    const auto motion = along({off, Eigen::Vector3d(20, 0, 0) + off}, 0.05, lean);
    const auto poses = poses_at({{0, 0, 0}, {20, 0, 0}});
    CheckOptions options = tip_tolerance(0.03);
    EXPECT_TRUE(verdict_of(motion, poses, options).ok);
    EXPECT_NEAR(verdict_of(motion, poses, options).tip_deviation_mm, off.norm(), 1e-5);
    options.controlled_height_mm = radius;
    EXPECT_LT(verdict_of(motion, poses, options).tip_deviation_mm, 1e-9);
}

TEST(Deviations, ToolsOfDifferentLength) {
    auto poses = poses_at({{0, 0, 0}, {10, 0, 0}, {10, 0, -20}, {20, 0, -20}});
    for (std::size_t n = 0; n < 4; ++n) poses[n].tool_length_mm = n < 2 ? 0 : 20;
    // the gauge point goes straight on: with the longer tool the tip is 20 mm lower
    const auto motion = along({{0, 0, 0}, {10, 0, 0}, {20, 0, 0}}, 0.05);
    const auto v = verdict_of(motion, poses);
    EXPECT_TRUE(v.ok) << broken_things(v);
    poses[3].tool_length_mm = poses[2].tool_length_mm = 20.1;
    EXPECT_FALSE(verdict_of(motion, poses).ok);
}

TEST(Deviations, BadInputIsRefused) {
    const auto motion = along({{0, 0, 0}, {20, 0, 0}}, 0.05);
    const auto poses = poses_at({{0, 0, 0}, {20, 0, 0}});
    const auto code = [&](const SetpointTable& m, const std::vector<ProgrammedPose>& p, CheckOptions o,
                          machine::Machine machine = boundless()) {
        const auto verdict = check(m, p, machine, peer_setup(), o);
        return verdict ? std::string("none") : verdict.error().code;
    };
    EXPECT_EQ(code(motion, poses, {}), "none");
    EXPECT_EQ(code({}, poses, {}), "VER0301");
    EXPECT_EQ(code(motion, {}, {}), "VER0302");
    EXPECT_EQ(code(motion, poses, tip_tolerance(0)), "VER0303");
    EXPECT_EQ(code(motion, poses, tip_tolerance(NAN)), "VER0303");
    CheckOptions options;
    options.orientation_tolerance_rad = 0;
    EXPECT_EQ(code(motion, poses, options), "VER0303");
    options.flank_tolerance_mm = 1;
    EXPECT_EQ(code(motion, poses, options), "none");
    auto lame = boundless();
    lame.axes[3].feed.jerk = 0;
    EXPECT_EQ(code(motion, poses, {}, lame), "VER0303");
    auto broken = motion;
    broken.rows[7].position[2] = NAN;
    EXPECT_EQ(code(broken, poses, {}), "VER0108");
    auto over = poses;
    over[1].axis = -over[0].axis;
    EXPECT_EQ(code(motion, over, {}), "VER0105");
    EXPECT_EQ(code(motion, {pose_by_words({0, 0, 0}, 0, 0, 1), pose_by_words({0, 0, 0}, 0, 1e9, 2)}, {}), "VER0304");
}

}  // namespace
}  // namespace trunnion::verify::test
