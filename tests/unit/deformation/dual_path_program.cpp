#include "trunnion/deformation/dual_path_program.hpp"

#include <cmath>
#include <cstdint>

#include <gtest/gtest.h>

#include "trunnion/base/quantity.hpp"

#include "flank_blades.hpp"

namespace {

using namespace trunnion;
using namespace trunnion::deformation;
using Eigen::Vector3d;
using program::Move;
using program::MoveKind;
using program::Program;

/// A rapid, nine moves with an event before the sixth, a rapid.
Program two_stretches() {
    Program out;
    const auto add = [&](double x, MoveKind kind) {
        Move move;
        move.position_mm = {x, 3 * std::sin(x / 9), 0};
        move.axis = Vector3d(std::sin(x / 80), 0, std::cos(x / 80));
        move.kind = kind;
        if (kind == MoveKind::feed) move.feed = {program::FeedRule::block_time, 0.5};
        move.line = static_cast<std::int32_t>(out.moves.size()) + 1;
        out.moves.push_back(move);
        out.following.push_back(2 * x);
    };
    out.following_letters = {'E'};
    add(0, MoveKind::rapid);
    for (int i = 1; i <= 9; ++i) add(5 * i, MoveKind::feed);
    add(60, MoveKind::rapid);
    program::Event event;
    event.before_move = 6;
    event.word = "M8";
    out.events.push_back(event);
    return out;
}

double time_of(const Program& program) {
    double out = 0;
    for (const Move& move : program.moves)
        if (move.feed.rule == program::FeedRule::block_time) out += move.feed.value;
    return out;
}

std::vector<ReplacedStretch> as_paths(const Program& program, const Vector3d& moved) {
    std::vector<ReplacedStretch> out;
    for (const CuttingStretch& stretch : cutting_stretches(program)) {
        auto poses = taken(poses_of(program, stretch));
        for (Pose& pose : poses.poses) pose.tip_in_workpiece_mm += moved;
        const auto fitted = taken(fit_dual_path(poses.poses));
        ReplacedStretch replaced{stretch, fitted.path, {}};
        for (const std::size_t pose : poses.move_end) replaced.move_end_u.push_back(fitted.parameters[pose]);
        out.push_back(replaced);
    }
    return out;
}

TEST(DualPathProgram, StretchesEndAtEventsAndRapids) {
    const auto stretches = cutting_stretches(two_stretches());
    ASSERT_EQ(stretches.size(), 2u);
    EXPECT_EQ(stretches[0].first, 1u);
    EXPECT_EQ(stretches[0].last, 5u);
    EXPECT_EQ(stretches[1].first, 6u);
    EXPECT_EQ(stretches[1].last, 9u);
    Program stops = two_stretches();
    stops.moves[3].exact_stop = true;
    EXPECT_EQ(cutting_stretches(stops).size(), 3u);
    Program words = two_stretches();
    for (Move& move : words.moves) move.law = program::OrientationLaw::rotary;
    EXPECT_TRUE(cutting_stretches(words).empty());
}

TEST(DualPathProgram, CurvesTakeTheirPlaceAndTheRestStays) {
    const Program before = two_stretches();
    for (const auto& chords : {std::optional<Chords>{}, std::optional(Chords{1e-3, 1e-4})}) {
        const Program after = with_dual_paths(before, as_paths(before, Vector3d::Zero()), chords);
        EXPECT_EQ(after.curves.size(), chords ? 0u : 2u);
        EXPECT_EQ(after.following.size(), after.moves.size());
        EXPECT_NEAR(time_of(after), time_of(before), 0.05) << "times of blocks are shared out";
        const Move& at_event = after.moves[after.events[0].before_move - 1];
        EXPECT_LT((at_event.position_mm - before.moves[5].position_mm).norm(), 1e-9);
        EXPECT_NEAR(after.following[after.events[0].before_move - 1], 50, 1e-6);
        EXPECT_EQ(after.moves.back().line, before.moves.back().line);
        for (std::size_t k = 1; k < after.moves.size(); ++k) EXPECT_GE(after.moves[k].line, after.moves[k - 1].line);
    }
}

TEST(DualPathProgram, ACurveReadFromAProgramIsTheSameCurve) {
    const Program before = two_stretches();
    const auto paths = as_paths(before, Vector3d::Zero());
    const Program after = with_dual_paths(before, paths);
    const auto stretches = cutting_stretches(after);
    ASSERT_EQ(stretches.size(), 2u);
    for (std::size_t i = 0; i < 2; ++i) {
        const DualPath again = taken(dual_path_of(after, stretches[i], 50));
        for (double u = again.begin(); u < again.end(); u += 0.3)
            EXPECT_LT((again.point_mm(u, 50) - paths[i].path.point_mm(u, 50)).norm(), 1e-11);
    }
    EXPECT_EQ(dual_path_of(before, cutting_stretches(before)[0], 50).error().code, "DEFO0108");
    const auto places = taken(poses_of(after, stretches[0]));
    EXPECT_GT(places.poses.size(), 8u * 2) << "a curve is looked at between its knots";
    Program broken = after;
    broken.curves[0].axis[1] = -broken.curves[0].axis[0];
    broken.curves[0].axis[2].setZero();
    broken.curves[0].position_mm.pop_back();
    EXPECT_EQ(poses_of(broken, stretches[0]).error().code, "DEFO0108");
}

/// Both ends move: the rapid goes to the new start, and a short move joins the second path to the first where they
/// differ.
TEST(DualPathProgram, NothingJumpsWhereAPathMoved) {
    const Program before = two_stretches();
    auto paths = as_paths(before, Vector3d(0, 0, 0.1));
    paths[1] = as_paths(before, Vector3d(0, 0, 0.3))[1];
    const Program after = with_dual_paths(before, paths);
    EXPECT_NEAR(after.moves[0].position_mm.z(), 0.1, 1e-9);
    std::size_t links = 0;
    for (std::size_t k = 1; k < after.moves.size(); ++k) {
        const Move& move = after.moves[k];
        if (move.curve_part == program::no_curve_part) {
            links += move.kind == MoveKind::feed;
            continue;
        }
        const auto& part = after.curve_parts[static_cast<std::size_t>(move.curve_part)];
        const auto& path = paths[static_cast<std::size_t>(part.curve)].path;
        EXPECT_LT((path.at(part.from_u).tip_in_workpiece_mm - after.moves[k - 1].position_mm).norm(), 1e-9);
    }
    EXPECT_EQ(links, 1u);
}

TEST(DualPathProgram, ArcsAreFollowed) {
    Program program;
    Move start;
    start.position_mm = {10, 0, 0};
    program.moves.push_back(start);
    Move arc = start;
    arc.position_mm = {0, 10, 0};
    arc.feed = {program::FeedRule::tip_speed, 10};
    arc.arc = 0;
    program.arcs.push_back({Vector3d::Zero(), Vector3d::UnitZ(), 90 * degree});
    program.moves.push_back(arc);
    const auto poses = taken(poses_of(program, {1, 1}));
    EXPECT_EQ(poses.poses.size(), 19u);
    const DualPath path = taken(fit_dual_path(poses.poses)).path;
    for (double u = 0; u < path.end(); u += 0.1) EXPECT_NEAR(path.at(u).tip_in_workpiece_mm.norm(), 10, 2e-5);
}

}  // namespace
