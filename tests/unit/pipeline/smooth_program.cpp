// Programs that are smoothed and given as programs again.
#include "trunnion/pipeline/smooth_program.hpp"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "trunnion/base/quantity.hpp"
#include "trunnion/files/machine_file.hpp"
#include "trunnion/geometry/great_circle.hpp"

namespace trunnion::pipeline {
namespace {

using program::FeedRule;
using program::Move;
using program::MoveKind;
using program::OrientationLaw;
using program::Program;

machine::Machine five_axes() {
    return *files::read_machine_file(TRUNNION_SOURCE_DIR "/data/machines/ucp710.toml");
}

/// A rapid, then a round of radius 20 mm in chords of half a degree, the tool leaning outwards by 10 degrees.
Program rim(OrientationLaw law) {
    Program out;
    if (law == OrientationLaw::rotary) out.rotary_letters = {'A', 'C'};
    const auto at = [&](double angle, MoveKind kind) {
        Move move;
        move.law = law;
        move.kind = kind;
        move.position_mm = {20 * std::cos(angle), 20 * std::sin(angle), 0};
        move.axis = {std::sin(10 * degree) * std::cos(angle), std::sin(10 * degree) * std::sin(angle),
                     std::cos(10 * degree)};
        move.rotary_rad = {10 * degree, angle, 0};
        if (kind == MoveKind::feed) move.feed = {FeedRule::tip_speed, 50};
        move.line = static_cast<std::int32_t>(out.moves.size()) + 1;
        out.moves.push_back(move);
    };
    at(-0.1, MoveKind::rapid);
    at(0, MoveKind::rapid);
    for (int k = 1; k <= 720; ++k) at(k * 0.5 * degree, MoveKind::feed);
    return out;
}

double radius_of(const Eigen::Vector3d& position) {
    return std::hypot(position.x(), position.y());
}

/// Half of the tolerance and a quarter are used, of 20 µm on a circle that the program has to 0.2 µm.
TEST(SmoothProgram, gives_dense_poses_as_few_points) {
    const Program program = rim(OrientationLaw::vector);
    const auto smoothed = smooth_program(program, five_axes(), {}, {}, SmoothedForm::points);
    ASSERT_TRUE(smoothed) << to_string(smoothed.error());
    const auto& moves = smoothed->program.moves;
    EXPECT_EQ(smoothed->smoothed_moves, 720u);
    EXPECT_EQ(smoothed->kept_moves, 2u);
    EXPECT_EQ(smoothed->written_moves + 2, moves.size());
    // A chord of a circle within 5 µm turns by 2.56 degrees; its place may be off by what rounding left.
    EXPECT_LT(moves.size(), 250u);
    EXPECT_GT(moves.size(), 360 / 2.57);
    EXPECT_LE(smoothed->tip_deviation_mm, 0.015);
    EXPECT_EQ(moves.back().position_mm, program.moves.back().position_mm) << "the end is exact";
    for (const Move& move : moves) {
        EXPECT_NEAR(radius_of(move.position_mm), 20, 0.015);
        EXPECT_NEAR(std::acos(move.axis.z()), 10 * degree, 0.075 * degree);
    }
    for (std::size_t k = 2; k < moves.size(); ++k) EXPECT_EQ(moves[k].feed, program.moves.back().feed);
}

TEST(SmoothProgram, gives_splines) {
    for (const OrientationLaw law : {OrientationLaw::vector, OrientationLaw::rotary}) {
        const Program program = rim(law);
        const auto smoothed = smooth_program(program, five_axes(), {}, {}, SmoothedForm::curves);
        ASSERT_TRUE(smoothed) << to_string(smoothed.error());
        const Program& out = smoothed->program;
        ASSERT_EQ(out.curves.size(), 1u);
        const auto& curve = out.curves[0];
        EXPECT_EQ(curve.degree, 3);
        EXPECT_EQ(curve.knots.size(), curve.position_mm.size() + 4);
        EXPECT_EQ(law == OrientationLaw::vector ? curve.axis.size() : curve.rotary_rad.size(),
                  curve.position_mm.size());
        EXPECT_EQ(out.curve_parts.size(), out.moves.size() - 2) << "one move for each span";
        EXPECT_LT(out.curve_parts.size(), 130u) << "fewer than chords";
        EXPECT_LE(smoothed->tip_deviation_mm, 0.015);
        EXPECT_LT((curve.position_mm.front() - out.moves[1].position_mm).norm(), 1e-9);
        for (const Move& move : out.moves) EXPECT_NEAR(radius_of(move.position_mm), 20, 0.015);
    }
}

TEST(SmoothProgram, keeps_events_and_feeds_at_their_places) {
    Program program = rim(OrientationLaw::rotary);
    program.events.push_back({program::EventKind::coolant, false, 0, "M8", 300, 300});
    for (std::size_t k = 500; k < program.moves.size(); ++k) program.moves[k].feed.value = 20;
    for (const SmoothedForm form : {SmoothedForm::points, SmoothedForm::curves}) {
        const auto smoothed = smooth_program(program, five_axes(), {}, {}, form);
        ASSERT_TRUE(smoothed) << to_string(smoothed.error());
        const auto& moves = smoothed->program.moves;
        const Move& before = moves[smoothed->program.events[0].before_move - 1];
        EXPECT_LT((before.position_mm - program.moves[299].position_mm).norm(), 0.02);
        std::size_t change = 2;
        while (moves[change].feed.value == 50) ++change;
        EXPECT_LT((moves[change - 1].position_mm - program.moves[499].position_mm).norm(), 0.02);
        for (std::size_t k = change; k < moves.size(); ++k) EXPECT_EQ(moves[k].feed.value, 20);
    }
}

/// Times as a post rounds them, and half the speed from move 500 on.
TEST(SmoothProgram, times_of_blocks_add_up) {
    Program program = rim(OrientationLaw::vector);
    for (std::size_t k = 2; k < program.moves.size(); ++k)
        program.moves[k].feed = {FeedRule::block_time,
                                 (k < 500 ? 0.01 : 0.02) * (1 + 0.01 * static_cast<double>(k % 3))};
    double asked = 0;
    for (const Move& move : program.moves) asked += move.feed.value;
    for (const SmoothedForm form : {SmoothedForm::points, SmoothedForm::curves}) {
        const auto smoothed = smooth_program(program, five_axes(), {}, {}, form);
        ASSERT_TRUE(smoothed) << to_string(smoothed.error());
        const auto& moves = smoothed->program.moves;
        EXPECT_LT(moves.size(), 250u) << "not a point for every block";
        double time = 0;
        for (const Move& move : moves) time += move.feed.value;
        EXPECT_NEAR(time, asked, 1e-6);
        for (std::size_t k = 3; k < moves.size(); ++k) {
            const double mm_s = (moves[k].position_mm - moves[k - 1].position_mm).norm() / moves[k].feed.value;
            const double full = 20 * 0.5 * degree / 0.0101;
            const bool slow = std::abs(mm_s - full / 2) < 0.03 * full;
            EXPECT_TRUE(slow || std::abs(mm_s - full) < 0.03 * full) << k << ": " << mm_s << " of " << full;
        }
    }
}

TEST(SmoothProgram, keeps_what_needs_no_smoothing) {
    Program corner = rim(OrientationLaw::vector);
    corner.moves.resize(4);
    corner.moves[3].position_mm += Eigen::Vector3d(30, 0, 0);
    const auto kept = smooth_program(corner, five_axes(), {}, {}, SmoothedForm::points);
    ASSERT_TRUE(kept);
    EXPECT_EQ(kept->kept_moves, 4u);
    EXPECT_EQ(kept->program.moves[3].position_mm, corner.moves[3].position_mm);
    Program upright = rim(OrientationLaw::vector);
    for (Move& move : upright.moves) move.axis = Eigen::Vector3d::UnitZ();
    const auto three_axes = smooth_program(upright, five_axes(), {}, {}, SmoothedForm::points);
    ASSERT_TRUE(three_axes);
    EXPECT_EQ(three_axes->kept_moves, upright.moves.size());
}

TEST(SmoothProgram, refuses_tolerances_that_leave_nothing) {
    smoothing::SmoothingOptions none;
    none.tip_tolerance_mm = 0;
    const auto refused = smooth_program(rim(OrientationLaw::vector), five_axes(), {}, none, SmoothedForm::points);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, "PIPE0016");
}

}  // namespace
}  // namespace trunnion::pipeline
