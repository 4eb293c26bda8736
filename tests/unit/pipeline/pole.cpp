// The tool passes the axis nearest to the workpiece closely: that axis turns by half a turn within micrometres.
#include <cmath>

#include <gtest/gtest.h>

#include "trunnion/base/quantity.hpp"
#include "trunnion/files/machine_file.hpp"
#include "trunnion/path/rotary_stands.hpp"
#include "trunnion/pipeline/plan.hpp"
#include "trunnion/verify/check.hpp"

namespace trunnion::pipeline {
namespace {

struct Rows : PlanObserver {
    std::vector<motion::Setpoint> rows;
    void setpoint(const motion::Setpoint& row) override { rows.push_back(row); }
};

/// 40 mm along X while the tool tilts from −12° to 12° and passes the pole so far off that the point 30 mm above the
/// tip is `beside_mm` beside it; the pole is not at a programmed pose.
program::Program past_the_pole(double beside_mm, int blocks) {
    program::Program program;
    const double aside = beside_mm / 30;
    for (int k = 0; k <= blocks; ++k) {
        program::Move move;
        const double x = -20 + 40.0 * k / blocks, tilt = 12 * degree * (x + 0.37) / 20;
        move.position_mm = {x, 0, 0};
        move.axis = {std::sin(tilt) * std::cos(aside), std::sin(aside), std::cos(tilt) * std::cos(aside)};
        move.feed = {program::FeedRule::tip_speed, 50};
        move.line = k + 1;
        program.moves.push_back(move);
    }
    return program;
}

void expect_sound(const machine::Machine& machine, const program::Program& program, double period_s,
                  const std::string& what) {
    PlanOptions options;
    options.period_s = period_s;
    Rows recorded;
    const auto summary = plan(program, machine, {}, options, recorded);
    ASSERT_TRUE(summary) << what << ": " << to_string(summary.error());
    EXPECT_TRUE(summary->usable()) << what << "\n" << summary->report();
    for (std::size_t k = 1; k < recorded.rows.size(); ++k)
        for (int i = 0; i < machine.axis_count; ++i)
            ASSERT_LE(std::abs(recorded.rows[k].position[i] - recorded.rows[k - 1].position[i]),
                      1.01 * machine.axes[i].feed.velocity * period_s)
                << what << ", row " << k;
    const auto table = verify::setpoint_table(std::move(recorded.rows));
    const auto stands = path::choose_rotary_stands(program, machine, {});
    ASSERT_TRUE(table && stands);
    const auto poses = verify::programmed_poses(program, machine, {}, *stands);
    ASSERT_TRUE(poses);
    verify::CheckOptions checking;
    checking.limit_excess = 1.005;
    const auto verdict = verify::check(*table, *poses, machine, {}, checking);
    ASSERT_TRUE(verdict) << what;
    for (const auto& broken : verdict->broken)
        ADD_FAILURE() << what << ": " << broken.what << " " << broken.value << ", limit " << broken.limit << " at "
                      << broken.time_s << " s";
}

TEST(Pole, passages_hold_limits_and_tolerances) {
    for (const char* name : {"ucp710", "head-head", "head-table", "xyzac-trt"}) {
        const auto machine =
            files::read_machine_file(std::string(TRUNNION_SOURCE_DIR "/data/machines/") + name + ".toml");
        ASSERT_TRUE(machine) << name;
        for (const double beside_mm : {0.0, 0.005, 0.05, 0.5}) {
            const auto what = std::string(name) + ", " + std::to_string(beside_mm) + " mm";
            expect_sound(*machine, past_the_pole(beside_mm, 40), 1e-3, what);
            expect_sound(*machine, past_the_pole(beside_mm, 1), 1e-3, what + " in one block");
            if (std::string(name) != "head-table")
                expect_sound(*machine, past_the_pole(beside_mm, 40), 1e-4, what + " at 0.1 ms");
        }
    }
}

TEST(Pole, the_free_axis_turns_along_a_move_at_the_pole) {
    const auto machine = files::read_machine_file(TRUNNION_SOURCE_DIR "/data/machines/ucp710.toml");
    ASSERT_TRUE(machine);
    program::Program program;
    const auto add = [&](double x, double a_deg, double c_deg) {
        program::Move move;
        const double a = a_deg * degree, c = c_deg * degree;
        move.position_mm = {x, 0, 0};
        move.axis = {std::sin(c) * std::sin(a), -std::cos(c) * std::sin(a), std::cos(a)};
        move.feed = {program::FeedRule::tip_speed, 50};
        move.line = static_cast<int>(program.moves.size()) + 1;
        program.moves.push_back(move);
    };
    add(0, 20, 10);
    add(10, 0, 0);
    add(30, 0, 0);
    add(40, 20, 70);
    expect_sound(*machine, program, 1e-3, "a move at the pole");
}

/// A corner just beyond the pole: rounding cuts it off on this side, and C turns the other way round.
program::Program corner_beyond_the_pole() {
    program::Program program;
    for (int k = -1; k <= 1; ++k) {
        program::Move move;
        move.position_mm = {10.0 * k, 0, 0};
        move.axis = Eigen::Vector3d(0.1 * k, k == 0 ? -2e-4 : 0.05, 1).normalized();
        move.feed = {program::FeedRule::tip_speed, 50};
        move.line = k + 2;
        program.moves.push_back(move);
    }
    return program;
}

TEST(Pole, rounding_that_passes_it_on_the_other_side_is_refused_before_rotary_words) {
    const auto machine = files::read_machine_file(TRUNNION_SOURCE_DIR "/data/machines/ucp710.toml");
    ASSERT_TRUE(machine);
    program::Program program = corner_beyond_the_pole();
    expect_sound(*machine, program, 1e-3, "vectors alone");
    const auto stands = path::choose_rotary_stands(program, *machine, {});
    ASSERT_TRUE(stands);
    program.rotary_letters = {'A', 'C'};
    program::Move words = program.moves.back();
    words.position_mm.x() += 10;
    words.law = program::OrientationLaw::rotary;
    words.rotary_rad = {stands->back().rotary_rad[0], stands->back().rotary_rad[1], 0};
    words.line = 4;
    program.moves.push_back(words);
    Rows recorded;
    const auto refused = plan(program, *machine, {}, {}, recorded);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, "PIPE0005") << to_string(refused.error());
    EXPECT_EQ(refused.error().place.line, 4);
    PlanOptions exact;
    exact.smoothing.rounding = smoothing::Rounding::none;
    EXPECT_TRUE(plan(program, *machine, {}, exact, recorded));
}

TEST(Pole, rapids_wind_back_before_a_cut_that_needs_the_room) {
    auto machine = files::read_machine_file(TRUNNION_SOURCE_DIR "/data/machines/ucp710.toml");
    ASSERT_TRUE(machine);
    machine->axes[4].range_min = -200 * degree;
    machine->axes[4].range_max = 200 * degree;
    program::Program program;
    const auto add = [&](double x, double y, double z, double c_deg, program::MoveKind kind) {
        program::Move move;
        const double a = 40 * degree, c = c_deg * degree;  // on the other branch A would be at −40°, out of range
        move.position_mm = {x, y, z};
        move.axis = {std::sin(c) * std::sin(a), -std::cos(c) * std::sin(a), std::cos(a)};
        move.kind = kind;
        if (kind == program::MoveKind::feed) move.feed = {program::FeedRule::tip_speed, 50};
        move.line = static_cast<int>(program.moves.size()) + 1;
        program.moves.push_back(move);
    };
    using enum program::MoveKind;
    for (int k = 0; k <= 6; ++k) add(k, 0, 0, 100 + 10 * k, feed);
    add(6, 0, 30, 160, rapid);
    add(0, 5, 30, 170, rapid);
    add(0, 5, 0, 170, rapid);
    for (int k = 1; k <= 15; ++k) add(k, 5, 0, 170 + 10 * k, feed);
    const auto stands = path::choose_rotary_stands(program, *machine, {});
    ASSERT_TRUE(stands) << to_string(stands.error());
    EXPECT_TRUE((*stands)[7].rebranched || (*stands)[8].rebranched || (*stands)[9].rebranched);
    expect_sound(*machine, program, 1e-3, "winding back");
}

/// Time of a plan; what it cannot do fails the test.
double time_of(const machine::Machine& machine, const program::Program& program,
               double orientation_tolerance_deg = 0.1) {
    PlanOptions options;
    options.smoothing.orientation_tolerance_rad = orientation_tolerance_deg * degree;
    Rows recorded;
    const auto summary = plan(program, machine, {}, options, recorded);
    EXPECT_TRUE(summary) << to_string(summary.error());
    EXPECT_TRUE(summary && summary->usable());
    return summary ? summary->cycle_time_s : 0;
}

TEST(Pole, passages_within_the_orientation_tolerance_take_no_longer_than_the_pole_itself) {
    struct Gain {
        const char* machine;
        double least;  // time around the pole / time through it
    };
    for (const Gain& gain :
         {Gain{"ucp710", 2}, Gain{"head-head", 2}, Gain{"head-table", 1.5}, Gain{"nutating-head", 1.8}}) {
        const auto machine =
            files::read_machine_file(std::string(TRUNNION_SOURCE_DIR "/data/machines/") + gain.machine + ".toml");
        ASSERT_TRUE(machine) << gain.machine;
        const double through = time_of(*machine, past_the_pole(0, 40));
        for (const int blocks : {1, 40, 400})
            for (const double aside_deg : {0.001, 0.02, 0.076}) {
                const auto program = past_the_pole(30 * aside_deg * degree, blocks);
                const std::string what = std::string(gain.machine) + ", " + std::to_string(aside_deg) + " deg, " +
                                         std::to_string(blocks) + " blocks";
                const double time = time_of(*machine, program), around = time_of(*machine, program, 1e-4);
                EXPECT_LE(time, 1.01 * through) << what;
                EXPECT_GE(around, gain.least * time) << what;
            }
        const auto too_far = past_the_pole(30 * 0.081 * degree, 40);
        EXPECT_GE(time_of(*machine, too_far), gain.least * through) << gain.machine;
    }
}

TEST(Pole, an_axis_without_room_on_the_other_side_leads_around_the_pole) {
    auto machine = files::read_machine_file(TRUNNION_SOURCE_DIR "/data/machines/ucp710.toml");
    ASSERT_TRUE(machine);
    machine->axes[3].range_min = -5 * degree;
    const auto program = past_the_pole(30 * 0.05 * degree, 40);
    expect_sound(*machine, program, 1e-3, "around");
    EXPECT_NEAR(time_of(*machine, program), time_of(*machine, program, 1e-4), 0.05);
}

TEST(Pole, passages_to_and_fro_with_noise_hold_limits_and_tolerances) {
    const auto machine = files::read_machine_file(TRUNNION_SOURCE_DIR "/data/machines/ucp710.toml");
    ASSERT_TRUE(machine);
    program::Program program;
    std::uint64_t state = 20261122;
    const auto noise = [&] {  // even in [−1, 1]
        state = state * 6364136223846793005u + 1442695040888963407u;
        return static_cast<double>(state >> 11) * 0x1p-52 - 1;
    };
    for (int pass = 0; pass < 4; ++pass)
        for (int k = -100; k <= 100; ++k) {
            program::Move move;
            const double x = (pass % 2 ? -0.1 : 0.1) * k, tilt = 6 * degree * x / 10;
            const double nx = std::sin(tilt) + 1e-4 * noise(), ny = 0.04 * degree + 1e-4 * noise();
            move.position_mm = {x, 1.0 * pass, 0};
            move.axis = Eigen::Vector3d(nx, ny, std::cos(tilt)).normalized();
            move.feed = {program::FeedRule::tip_speed, 50};
            move.line = static_cast<int>(program.moves.size()) + 1;
            program.moves.push_back(move);
        }
    expect_sound(*machine, program, 1e-3, "to and fro");
    EXPECT_LT(time_of(*machine, program), 0.6 * time_of(*machine, program, 0.04)) << "seed " << state;
}

}  // namespace
}  // namespace trunnion::pipeline
