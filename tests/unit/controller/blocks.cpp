// The block model against what can be reckoned by hand.
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "trunnion/machine/kinematics.hpp"

#include "made.hpp"

namespace {

using namespace trunnion;
using motion::LimitKind;
using motion::ParameterId;
using test::made_control;
using test::moves;
using test::predicted;

constexpr double acceleration = 2000, jerk = 20000;

/// Rest to rest with ramps of constant jerk and acceleration.
double s_curve_s(double length_mm, double speed_mm_s) {
    const double ramp = speed_mm_s > acceleration * acceleration / jerk
                            ? speed_mm_s / acceleration + acceleration / jerk
                            : 2 * std::sqrt(speed_mm_s / jerk);
    return length_mm / speed_mm_s + ramp;
}

TEST(Blocks, ALongLineTakesAsLongAsWithRampsOfConstantJerk) {
    const auto line = [](double speed) { return predicted(moves(speed, {{}, {200}}), made_control()).told; };
    EXPECT_NEAR(line(50).cycle_time_s, s_curve_s(200, 50), 1e-12);  // the jerk alone
    EXPECT_NEAR(line(100).cycle_time_s, s_curve_s(200, 100), 1e-12);
    EXPECT_NEAR(line(400).cycle_time_s, s_curve_s(200, 400), 0.02 * s_curve_s(200, 400));
    EXPECT_GE(line(400).cycle_time_s, s_curve_s(200, 400));
}

TEST(Blocks, AShortLineTakesAsLongAsWithRampsOfConstantJerk) {
    // Half the way is v·√(v/J): the time is 4·(way/2J)^(1/3).
    for (const double way : {0.01, 0.1, 1.0})
        EXPECT_NEAR(predicted(moves(1000, {{}, {way}}), made_control()).told.cycle_time_s,
                    4 * std::cbrt(way / 2 / jerk), 1e-12);
}

TEST(Blocks, TrapezoidsAreExact) {
    auto control = made_control();
    control.profile.way = motion::Profile::trapezoidal;
    EXPECT_NEAR(predicted(moves(100, {{}, {50}}), control).told.cycle_time_s, 50 / 100.0 + 100 / acceleration, 1e-12);
    EXPECT_NEAR(predicted(moves(1e4, {{}, {5}}), control).told.cycle_time_s, 2 * std::sqrt(5 / acceleration), 1e-12);
}

TEST(Blocks, StraightOnIsOneLine) {
    const auto one = predicted(moves(80, {{}, {30, 40}}), made_control());
    const auto two = predicted(moves(80, {{}, {3, 4}, {30, 40}}), made_control());
    EXPECT_NEAR(one.told.cycle_time_s, two.told.cycle_time_s, 1e-12);
    EXPECT_EQ(two.told.standstills, 1u);
}

TEST(Blocks, ACornerIsPassedOnTheArc) {
    // 90°: R = e·sin 45°/(1 − sin 45°); where the arc ends its acceleration is one axis' alone.
    const auto corner = predicted(moves(200, {{}, {100}, {100, 100}}), made_control());
    const double sine = std::sqrt(0.5), radius = 0.01 * sine / (1 - sine);
    EXPECT_NEAR(corner.begin_mm_s(3), std::sqrt(radius * acceleration), 1e-9);
    const auto& drop = corner.told.feed_drops.at(1);
    EXPECT_EQ(drop.cause.kind, LimitKind::transition);
    EXPECT_NEAR(drop.feed_min_mm_s, corner.begin_mm_s(3), 1e-9);
    EXPECT_LT(drop.s_from_mm, 100);
    EXPECT_GT(drop.s_to_mm, 100);
}

TEST(Blocks, TheArcHasRoomOnHalfOfTheShorterBlock) {
    auto control = made_control();
    control[ParameterId::rounding_tolerance].value = 100;
    // Its ends on half of 1 mm: R·cot(45°) = 0.5 mm.
    EXPECT_NEAR(predicted(moves(200, {{}, {100}, {100, 1}, {200, 1}}), control).begin_mm_s(3),
                std::sqrt(0.5 * acceleration), 1e-9);
}

TEST(Blocks, TheCentripetalShareIsTheCentripetalOne) {
    auto control = made_control();
    const auto with_share = [&](double share) {
        control[ParameterId::centripetal_share].value = share;
        return predicted(moves(200, {{}, {100}, {100, 100}}), control);
    };
    EXPECT_NEAR(with_share(0.25).begin_mm_s(3), 0.5 * with_share(0).begin_mm_s(3), 1e-9);
    EXPECT_GT(with_share(0.25).told.cycle_time_s, with_share(0).told.cycle_time_s);
}

TEST(Blocks, EveryAxisMayStepAsItMay) {
    auto control = made_control();
    control.transition.way = motion::Transition::velocity_step;
    control[ParameterId::velocity_step].value = 8;
    control[ParameterId::rotary_velocity_step].value = 0.1;
    EXPECT_NEAR(predicted(moves(200, {{}, {100}, {100, 100}}), control).begin_mm_s(3), 8, 1e-9);
    // X goes on, C begins to turn: 1 mm per degree, so that C makes √½ of the way.
    const auto turning = predicted(moves(200, {{}, {100}, {0, 100, 0, 0, 90}}), control);
    EXPECT_GT(turning.told.cycle_time_s, 0.1);
}

TEST(Blocks, AReversalStandsStill) {
    const auto there_and_back = predicted(moves(100, {{}, {50}, {0}}), made_control());
    EXPECT_NEAR(there_and_back.told.cycle_time_s, 2 * s_curve_s(50, 100), 1e-9);
    EXPECT_EQ(there_and_back.told.standstills, 2u);
}

TEST(Blocks, FilterAndInPositionAddUpAtEveryStandstill) {
    auto control = made_control();
    control[ParameterId::setpoint_filter].value = 0.02;
    control[ParameterId::in_position_time].value = 0.03;
    control.transition.way = motion::Transition::exact_stop;
    const auto told = predicted(moves(100, {{}, {20}, {40}, {60}}), control).told;
    EXPECT_NEAR(told.cycle_time_s, 3 * s_curve_s(20, 100) + 3 * 0.05, 1e-12);
    EXPECT_EQ(told.standstills, 3u);
}

TEST(Blocks, TheAxesThatMoveMayHaveToStayTheSame) {
    auto control = made_control();
    control.axis_set_change.way = motion::AxisSetChange::stop;
    const auto poses = moves(100, {{}, {100}, {200, 1}, {300, 2}, {400, 2}});
    EXPECT_EQ(predicted(poses, control).told.standstills, 3u);
    EXPECT_EQ(predicted(poses, made_control()).told.standstills, 1u);
}

TEST(Blocks, PreparationCountsOverTheBuffer) {
    auto control = made_control();
    control[ParameterId::block_preparation].value = 0.01;
    auto dense = moves(200, {{}});
    for (int k = 1; k <= 200; ++k) {
        dense.moves.push_back(dense.moves.back());
        dense.moves.back().position_mm.x() += k % 2 == 0 ? 0.5 : 1.5;
        dense.moves.back().line = k + 1;
    }
    EXPECT_NEAR(predicted(dense, control).top_mm_s(101), 50, 1e-9);
    control[ParameterId::block_buffer].value = 2;  // 2 mm in 20 ms, wherever they begin
    const auto buffered = predicted(dense, control);
    EXPECT_NEAR(buffered.top_mm_s(101), 100, 1e-9);
    EXPECT_EQ(buffered.told.limits.front().limit.kind, LimitKind::preparation);
}

TEST(Blocks, ItCanStopAtTheEndOfWhatItKnows) {
    auto control = made_control();
    auto dense = moves(300, {{}});
    for (int k = 1; k <= 300; ++k) {
        dense.moves.push_back(dense.moves.back());
        dense.moves.back().position_mm.x() += 1;
        dense.moves.back().line = k + 1;
    }
    control[ParameterId::look_ahead_blocks].value = 4;
    // v·√(v/J) = 4 mm
    const double speed = std::cbrt(4.0 * 4.0 * jerk);
    const auto known = predicted(dense, control);
    EXPECT_NEAR(known.begin_mm_s(150), speed, 1e-9);
    EXPECT_EQ(known.told.limits.front().limit.kind, LimitKind::look_ahead);
    control[ParameterId::look_ahead_blocks].value = 1000;
    control[ParameterId::look_ahead_distance].value = 4;
    EXPECT_NEAR(predicted(dense, control).begin_mm_s(150), speed, 1e-9);
}

TEST(Blocks, RapidsHaveTheirOwnLimits) {
    auto program = moves(10, {{}, {900}});
    program.moves[1].kind = program::MoveKind::rapid;
    program.moves[1].feed = {};
    const auto told = predicted(program, made_control());
    EXPECT_NEAR(told.top_mm_s(2), 1000, 150);
    EXPECT_GT(told.top_mm_s(2), 600);  // more than the feed limit of 500
    EXPECT_EQ(told.told.cut_time_s, 0);
    EXPECT_NEAR(told.told.rapid_time_s, told.told.cycle_time_s, 1e-12);
}

TEST(Blocks, TimesOfWordsAreTold) {
    auto control = made_control();
    control[ParameterId::tool_change_time].value = 7;
    control[ParameterId::spindle_time].value = 2;
    control[ParameterId::other_stop_time].value = 0.5;
    auto program = moves(100, {{}, {50}, {100}});
    program.events = {{program::EventKind::tool, true, 0, "T1 M6", 1, 1},
                      {program::EventKind::spindle, true, 0, "M3", 1, 1},
                      {program::EventKind::spindle, false, 0, "S900", 2, 2},
                      {program::EventKind::dwell, true, 0.25, "G4", 2, 2},
                      {program::EventKind::stop, true, 0, "M0", 3, 3}};
    const auto told = predicted(program, control).told;
    EXPECT_EQ(told.tool_change_time_s, 7);
    EXPECT_EQ(told.other_stop_time_s, 2.5);
    EXPECT_EQ(told.dwell_time_s, 0.25);
    EXPECT_NEAR(told.cut_time_s, 2 * s_curve_s(50, 100), 1e-9);
    EXPECT_NEAR(told.cycle_time_s, told.cut_time_s + 9.75, 1e-12);
}

TEST(Blocks, FeedRules) {
    auto program = moves(100, {{}, {100}});
    program.moves[1].feed = {program::FeedRule::block_time, 4};
    const auto timed = predicted(program, made_control());
    EXPECT_NEAR(timed.top_mm_s(2), 25, 1e-9);
    EXPECT_NEAR(timed.told.cycle_time_s, s_curve_s(100, 25), 1e-12);
    auto turn = moves(20, {{}, {0, 0, 0, 0, 90}});  // 20 mm/s, of a pure rotation 20 deg/s
    const auto top_turn = [](const test::Predicted& of) {
        double out = 0;
        for (const auto& row : of.rows) out = std::max(out, std::abs(row.velocity[4]));
        return out / degree;
    };
    EXPECT_NEAR(top_turn(predicted(turn, made_control())), 20, 1e-9);
    turn.moves[1].feed = {program::FeedRule::rotary_rate, 30 * degree};
    EXPECT_NEAR(top_turn(predicted(turn, made_control())), 30, 1e-9);
}

/// The tip goes straight while the table turns: only many segments in the axes' space are that.
TEST(Blocks, LongTurningBlocksAreResampled) {
    const auto program = moves(30, {{60, 0, 20}, {60, 40, 20, 50, 70}});
    const auto turning = predicted(program, made_control());
    const auto kinematics = machine::Kinematics::make(test::made_machine(), {}, 0).value();
    EXPECT_GT(turning.rows.size(), 30u);
    for (const auto& row : turning.rows) {
        const auto tip = kinematics.forward(row.position).tip_in_workpiece_mm;
        EXPECT_NEAR(tip.x(), 60, 0.01);
        EXPECT_NEAR(tip.z(), 20, 0.01);
    }
    controller::PredictOptions finest;
    finest.first_chord_mm = 1e-6;
    finest.convergence = 0.5;
    const double exact = predicted(program, made_control(), {}, finest).told.cycle_time_s;
    EXPECT_NEAR(turning.told.cycle_time_s, exact, 1e-3 * exact);
}

TEST(Blocks, LimitsOfTheAxesHold) {
    const auto turning =
        predicted(moves(500, {{60, 0, 20}, {60, 40, 20, 50, 70}, {-60, 40, 0, -50, 170}}), made_control());
    double hardest = 0;
    for (const auto& load : turning.told.axes) {
        EXPECT_LE(load.velocity_ratio, 1 + 1e-9) << load.letter;
        EXPECT_LE(load.acceleration_ratio, 1 + 1e-9) << load.letter;
        hardest = std::max({hardest, load.velocity_ratio, load.acceleration_ratio});
    }
    EXPECT_GT(hardest, 0.99);
}

TEST(Blocks, RowsAreOfOneMotion) {
    const auto turning =
        predicted(moves(50, {{60, 0, 20}, {60, 40, 20, 50, 70}, {60, 41, 20, 50, 70}}), made_control());
    ASSERT_GT(turning.rows.size(), 10u);
    EXPECT_EQ(turning.rows.front().time_s, 0);
    EXPECT_NEAR(turning.rows.back().time_s, turning.told.cycle_time_s, 1e-9);
    EXPECT_NEAR(turning.rows.back().path_length_mm, turning.told.path_length_mm, 1e-9);
    EXPECT_NEAR(turning.told.path_length_mm, 41, 1e-9);
    for (std::size_t i = 1; i < turning.rows.size(); ++i) {
        EXPECT_GE(turning.rows[i].time_s, turning.rows[i - 1].time_s);
        EXPECT_GE(turning.rows[i].path_length_mm, turning.rows[i - 1].path_length_mm);
    }
    double lines = 0;
    for (const auto& line : turning.told.lines) lines += line.duration_s;
    EXPECT_NEAR(lines, turning.told.cycle_time_s, 1e-9);
}

TEST(Blocks, WhatIsNotIdentifiedMakesTheTimeUncertain) {
    auto control = made_control();
    const auto program = moves(200, {{}, {50}, {50, 50}, {100, 50}});
    EXPECT_EQ(predicted(program, control).told.uncertainty_s, 0);
    auto& tolerance = control[ParameterId::rounding_tolerance];
    tolerance = {0.01, motion::Source::guessed, 0.005, true};
    const auto told = predicted(program, control).told;
    ASSERT_EQ(told.doubts.size(), 1u);
    EXPECT_EQ(told.doubts[0].parameter, "rounding_tolerance");
    tolerance.value = 0.005;
    EXPECT_NEAR(told.doubts[0].time_low_s, predicted(program, control).told.cycle_time_s, 1e-12);
    tolerance.value = 0.015;
    EXPECT_NEAR(told.doubts[0].time_high_s, predicted(program, control).told.cycle_time_s, 1e-12);
    EXPECT_NEAR(told.uncertainty_s, 0.5 * (told.doubts[0].time_low_s - told.doubts[0].time_high_s), 1e-12);
    EXPECT_GT(told.uncertainty_s, 0);
}

TEST(Blocks, BlocksThatDoNotMoveAreToldBlocksWithoutFeedRefused) {
    const auto told = predicted(moves(50, {{}, {10}, {10}, {10}, {20}}), made_control()).told;
    ASSERT_EQ(told.diagnostics.size(), 1u);
    EXPECT_EQ(told.diagnostics[0].code, "CTRL0202");
    EXPECT_EQ(told.diagnostics[0].count, 2);
    for (const double wrong : {0.0, -1.0, std::nan("")}) {
        auto program = moves(50, {{}, {10}});
        program.moves[1].feed = {program::FeedRule::block_time, wrong};
        const auto refused = controller::predict(program, test::made_machine(), {}, made_control(), {});
        ASSERT_FALSE(refused);
        EXPECT_EQ(refused.error().code, "CTRL0201");
        EXPECT_EQ(refused.error().place.line, 2);
    }
}

TEST(Blocks, BadOptionsAndOtherKindsAreRefused) {
    const auto code_of = [](const motion::Controller& control, const controller::PredictOptions& options) {
        const auto refused = controller::predict(moves(50, {{}, {10}}), test::made_machine(), {}, control, options);
        return refused ? std::string() : refused.error().code;
    };
    EXPECT_EQ(code_of(made_control(), {.feed_override = 0}), "CTRL0206");
    EXPECT_EQ(code_of(made_control(), {.feed_mm_s = -1}), "CTRL0206");
    EXPECT_EQ(code_of(made_control(), {.contact_lead_rad = 2}), "CTRL0204");
    EXPECT_EQ(code_of({.kind = motion::ControllerKind::ideal}, {}), "CTRL0205");
}

TEST(Branch, ControlsChooseDifferently) {
    auto control = made_control();
    program::Program program{.source = "made"};
    program::Move move;
    move.feed = {program::FeedRule::tip_speed, 50};
    for (const double tilt : {-20.0, -10.0, -5.0, 5.0, 15.0}) {  // in the plane Y Z, through the pole
        move.axis = {0, -std::sin(tilt * degree), std::cos(tilt * degree)};
        move.position_mm.y() += 10;
        program.moves.push_back(move);
    }
    const auto ends = [&](motion::BranchRule rule) {
        control.branch.way = rule;
        const auto rows = predicted(program, control).rows;
        return std::pair(rows.front().position, rows.back().position);
    };
    const auto [first, last] = ends(motion::BranchRule::nearest);
    EXPECT_NEAR(first[3] / degree, -20, 1e-9);
    EXPECT_NEAR(last[3] / degree, 15, 1e-9);
    const auto [first_positive, last_positive] = ends(motion::BranchRule::positive);
    EXPECT_NEAR(first_positive[3] / degree, 20, 1e-9);
    EXPECT_NEAR(last_positive[3] / degree, 15, 1e-9);
    EXPECT_NEAR(std::abs(last_positive[4] - first_positive[4]) / degree, 180, 1e-9);
}

TEST(LengthOverFeed, IsExact) {
    const motion::Controller cam{.name = "cam", .kind = motion::ControllerKind::length_over_feed};
    auto program = moves(50, {{}, {30, 40}, {30, 40, 10, 20, 30}, {30, 40, 10, 90, 0}, {-90, 40, 10, 90, 0}});
    program.moves[4].kind = program::MoveKind::rapid;
    program.moves[4].feed = {};
    program.events = {{program::EventKind::dwell, true, 1.5, "G4", 2, 2},
                      {program::EventKind::tool, true, 0, "T1", 2, 2}};
    const auto told = predicted(program, cam).told;
    EXPECT_DOUBLE_EQ(told.cut_time_s, 50 / 50.0 + 10 / 50.0);
    EXPECT_DOUBLE_EQ(told.rapid_time_s, 120.0 / 1000);
    EXPECT_EQ(told.dwell_time_s, 1.5);
    EXPECT_DOUBLE_EQ(told.cycle_time_s, 1.2 + 0.12 + 1.5);
    EXPECT_EQ(told.uncertainty_s, 0);
}

TEST(LengthOverFeed, ArcsByTheirLength) {
    const motion::Controller cam{.name = "cam", .kind = motion::ControllerKind::length_over_feed};
    auto program = moves(10, {{5, 0, 0}, {-5, 0, 0}});
    program.arcs.push_back({Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitZ(), 180 * degree});
    program.moves[1].arc = 0;
    EXPECT_NEAR(predicted(program, cam).told.cycle_time_s, 5 * 180 * degree / 10, 1e-12);
}

/// An arc is passed with the acceleration across it that its radius asks for.
TEST(Blocks, ArcsAreLimitedByTheirCurvature) {
    auto program = moves(450, {{-200, 0, 0}, {0, 0, 0}, {0, 20, 0}, {-200, 20, 0}});
    program.arcs.push_back({{0, 10, 0}, Eigen::Vector3d::UnitZ(), 180 * degree});
    program.moves[2].arc = 0;
    auto control = made_control();
    control[ParameterId::rounding_tolerance].value = 1;
    const auto around = predicted(program, control);
    // Each axis has its own limit: where the radius lies between X and Y both share the work.
    const double fastest = std::sqrt(10 * acceleration * std::sqrt(2.0));
    EXPECT_NEAR(around.top_mm_s(3), fastest, 0.01 * fastest);
}

}  // namespace
