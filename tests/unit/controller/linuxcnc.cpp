#include "trunnion/controller/linuxcnc.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include <fmt/format.h>

#include "linuxcnc_running.hpp"

namespace trunnion::controller {
namespace {

constexpr double period_s = 0.001;

/// Of the way between the rows too.
double distance_to(const std::vector<LinuxcncRow>& rows, const Eigen::Vector3d& point) {
    double nearest = 1e9;
    for (std::size_t k = 1; k < rows.size(); ++k) {
        const Eigen::Vector3d step = rows[k].tip_mm - rows[k - 1].tip_mm, away = point - rows[k - 1].tip_mm;
        const double share = step.isZero(0) ? 0 : std::clamp(away.dot(step) / step.squaredNorm(), 0.0, 1.0);
        nearest = std::min(nearest, (away - share * step).norm());
    }
    return nearest;
}

/// Periods in which the planner stands still between its first and its last motion.
int standstill(const std::vector<LinuxcncRow>& rows) {
    std::size_t first = rows.size(), last = 0;
    for (std::size_t k = 1; k < rows.size(); ++k)
        if (rows[k].tip_mm != rows[k - 1].tip_mm) first = std::min(first, k), last = k;
    int still = 0;
    for (std::size_t k = first; k < last; ++k) still += rows[k].tip_mm == rows[k - 1].tip_mm;
    return still;
}

double largest_step_change(const std::vector<LinuxcncRow>& rows, int axis) {
    double most = 0;
    for (std::size_t k = 2; k < rows.size(); ++k)
        most = std::max(most, std::abs(rows[k].tip_mm[axis] - 2 * rows[k - 1].tip_mm[axis] + rows[k - 2].tip_mm[axis]));
    return most / (period_s * period_s);
}

TEST(Linuxcnc, a_line_is_a_trapezoid) {
    const Running r("G61.1\nG1 X0 Y0 Z0 A0 C0 F3000\nX100\n");
    ASSERT_TRUE(r.run) << to_string(r.run.error());
    // 100 mm at 50 mm/s with 2500 mm/s²; the last periods creep, and the smoother adds two
    EXPECT_NEAR(r.seconds(), 100.0 / 50 + 50.0 / 2500, 5 * period_s);
    EXPECT_NEAR(r.run->length_over_feed_s, 2.0, 1e-12);
    EXPECT_NEAR(r.run->peak_velocity[0], 50, 1e-9);
    EXPECT_NEAR(r.run->peak_acceleration[0], 2500, 1e-6);
    EXPECT_NEAR(r.rows.back().tip_mm.x(), 100, 1e-9);
    EXPECT_NEAR(r.rows.back().axes[0], 100, 1e-9);
}

TEST(Linuxcnc, rows_are_one_period_apart_and_counted) {
    const Running r("G61\nG1 X10 Y0 Z0 A0 C0 F3000\nY10 A20\n");
    ASSERT_TRUE(r.run);
    ASSERT_EQ(r.rows.size(), r.run->rows);
    for (std::size_t k = 0; k < r.rows.size(); ++k)
        EXPECT_NEAR(r.rows[k].time_s, period_s * static_cast<double>(k), 1e-12);
    EXPECT_EQ(r.rows.front().tip_mm, Eigen::Vector3d::Zero());
    ASSERT_EQ(r.run->blocks.size(), 2U);
    EXPECT_EQ(r.run->blocks[0].line, 3);
    EXPECT_EQ(r.run->blocks[1].line, 4);
    EXPECT_NEAR(r.run->blocks[1].begin_s, r.run->blocks[0].end_s, 1e-12);
}

TEST(Linuxcnc, joints_follow_two_periods_later_through_a_cubic) {
    const Running r("G64\nG1 X10 Y3 Z1 A0 C0 F6000\nX20 Y-5\n");
    ASSERT_TRUE(r.run);
    const auto at = [&](std::size_t k) { return r.rows[k].tip_mm; };
    for (std::size_t k = 3; k < r.rows.size(); ++k)
        for (int i = 0; i < 3; ++i)
            EXPECT_NEAR(r.rows[k].axes[static_cast<std::size_t>(i)],
                        (at(k - 3)[i] + 4 * at(k - 2)[i] + at(k - 1)[i]) / 6, 1e-12);
}

TEST(Linuxcnc, exact_path_brakes_at_nine_tenths_and_exact_stop_fully) {
    const std::string corner = "G1 X40 Y0 Z0 A0 C0 F12000\nY40\nX0\n";
    const Running exact("G61\n" + corner), stop("G61.1\n" + corner), blend("G64\n" + corner);
    ASSERT_TRUE(exact.run && stop.run && blend.run);
    EXPECT_NEAR(largest_step_change(exact.rows, 1), 0.9 * 3000, 1e-3);
    EXPECT_NEAR(largest_step_change(stop.rows, 1), 3000, 1e-3);
    EXPECT_LT(stop.seconds(), exact.seconds());
    EXPECT_LT(blend.seconds(), stop.seconds());
    EXPECT_LT(distance_to(exact.rows, {40, 40, 0}), 1e-6);
}

TEST(Linuxcnc, exact_path_passes_tangent_joints_and_exact_stop_does_not) {
    const std::string straight = "G1 X20 Y0 Z0 A0 C0 F6000\nX40\nX60\nX80\n";
    const Running exact("G61\n" + straight), stop("G61.1\n" + straight);
    ASSERT_TRUE(exact.run && stop.run);
    EXPECT_NEAR(exact.seconds(), 0.8 + 100.0 / 2500, 6 * period_s);
    EXPECT_NEAR(stop.seconds(), exact.seconds() + 3 * 100.0 / 2500, 10 * period_s);
}

TEST(Linuxcnc, an_arc_keeps_to_the_tolerance_and_uses_it) {
    for (const double tolerance : {0.02, 0.1, 0.5}) {
        const Running r(fmt::format("G64 P{} Q0\nG1 X40 Y0 Z0 A0 C0 F6000\nY40\n", tolerance));
        ASSERT_TRUE(r.run);
        EXPECT_EQ(r.run->arc_blends, 1U);
        const double off = distance_to(r.rows, {40, 0, 0});
        EXPECT_LE(off, 1.005 * tolerance) << tolerance;  // the rows cut the arc's way into chords
        EXPECT_GE(off, 0.3 * tolerance) << tolerance;
    }
}

TEST(Linuxcnc, blocks_that_turn_have_half_the_acceleration_and_no_look_ahead) {
    std::string turning, still;
    for (int i = 1; i <= 50; ++i) {
        turning += fmt::format("X{} A{}\n", i, 0.01 * i);
        still += fmt::format("X{}\n", i);
    }
    const std::string begin = "G64 P0.01 Q0\nG1 X0 Y0 Z0 A0 C0 F6000\n";
    const Running r(begin + turning), straight(begin + still);
    ASSERT_TRUE(r.run && straight.run);
    EXPECT_NEAR(largest_step_change(straight.rows, 0), 2500, 1e-3);
    EXPECT_LE(largest_step_change(r.rows, 0), 2500 + 1e-3);
    EXPECT_NEAR(straight.seconds(), 0.5 + 100.0 / 2500, 30 * period_s);  // the last block brakes at half
    // equal blocks overlap at √(a/2·L): 35 mm/s here in place of 100
    EXPECT_NEAR(r.seconds(), 50 / std::sqrt(2500.0 / 2 * 1), 0.1);
}

TEST(Linuxcnc, short_blocks_are_merged_within_the_tolerance) {
    std::string blocks;
    for (int i = 1; i <= 250; ++i) blocks += fmt::format("X{:.3f} Y{:.4f}\n", 0.2 * i, 0.004 * (i % 2));
    const auto segments = [&](const std::string& mode) {
        const Running r(mode + "\nG1 X0 Y0 Z0 A0 C0 F6000\n" + blocks);
        return r.run ? r.run->segments : 0;
    };
    EXPECT_EQ(segments("G64 P0.01"), 3U);  // 101 points a chain
    EXPECT_EQ(segments("G64 P0.01 Q0.01"), 3U);
    EXPECT_EQ(segments("G64 P0.01 Q0"), 250U);
    EXPECT_EQ(segments("G64"), 250U);
    EXPECT_EQ(segments("G61"), 250U);
    EXPECT_GT(segments("G64 P0.01 Q0.001"), 50U);
}

TEST(Linuxcnc, one_command_a_period) {
    std::string blocks;
    for (int i = 1; i <= 2000; ++i) blocks += fmt::format("X{:.3f}\n", 0.002 * i);
    const Running r("G64 P0.01 Q0\nG1 X0 Y0 Z0 A0 C0 F6000\n" + blocks);
    ASSERT_TRUE(r.run);
    EXPECT_EQ(r.run->segments, 2000U);
    EXPECT_GE(r.run->rows, 2000U);
    EXPECT_LT(r.run->rows, 2200U);
}

TEST(Linuxcnc, waits_stand_still_for_their_time) {
    const auto periods = [](const std::string& word) {
        const Running r("G64 P0.05\nG1 X20 Y0 Z0 A0 C0 F3000\n" + word + "\nX40\n");
        return standstill(r.rows);
    };
    EXPECT_EQ(periods("G4 P0.25"), 255);
    EXPECT_EQ(periods("M5"), 4);
    EXPECT_EQ(periods("S1000 M3"), 4);
    EXPECT_EQ(periods("M8"), 100);
    EXPECT_EQ(periods("T1"), 0);
    EXPECT_EQ(periods("T1 M6"), 422);
    EXPECT_EQ(periods("T1\nM6"), 222);
}

TEST(Linuxcnc, inverse_time_feeds_and_arcs) {
    // 30 mm in 1/60 min; a quarter of 10 mm radius at 30 mm/s
    const Running r("G61\nG93\nG1 X30 Y0 Z0 A0 C0 F60\nG94\nG3 X40 Y10 I0 J10 F1800\n");
    ASSERT_TRUE(r.run) << to_string(r.run.error());
    EXPECT_NEAR(r.run->length_over_feed_s, 1 + 5 * 3.14159265358979 / 30, 1e-9);
    EXPECT_NEAR(r.seconds(), r.run->length_over_feed_s, 0.05);
    EXPECT_LT(distance_to(r.rows, {30 + 10 * std::sin(0.5), 10 - 10 * std::cos(0.5), 0}), 0.03);
}

TEST(Linuxcnc, joints_are_driven_beyond_their_limits_for_the_tip) {
    const Running r("G1 X400 Y0 Z0 A0 C0 F10000\nA90 C120 F100000\n");
    ASSERT_TRUE(r.run);
    EXPECT_GT(std::max(r.run->peak_velocity[0], r.run->peak_velocity[1]), 1.01 * 500);
    EXPECT_LE(r.run->peak_velocity[3], 90 * degree * (1 + 1e-9));
    EXPECT_LE(r.run->peak_velocity[4], 120 * degree * (1 + 1e-9));
}

TEST(Linuxcnc, overrides_change_the_time) {
    LinuxcncSettings settings = recorded_settings();
    settings.feed_override = 0.5;
    const std::string line = "G61\nG1 X0 Y0 Z0 A0 C0 F3000\nX100\n";
    const Running half(line, settings), whole(line);
    ASSERT_TRUE(half.run && whole.run);
    EXPECT_NEAR(half.seconds(), 4 + 25.0 / 2500, 6 * period_s);
    settings.max_feed_override = settings.feed_override = 1.2;
    EXPECT_NEAR(Running(line, settings).seconds(), 100 / 60.0 + 60.0 / 2500, 6 * period_s);
}

TEST(Linuxcnc, limits_can_be_those_of_the_file_instead) {
    LinuxcncSettings settings = recorded_settings();
    settings.axis_limits['X'] = {10, 100};
    const Running r("G61\nG1 X0 Y0 Z0 A0 C0 F3000\nX100\n", settings);
    EXPECT_NEAR(r.seconds(), 10 + 10.0 / 100, 6 * period_s);
    settings = recorded_settings();
    settings.servo_period_s = 0.002;
    const Running slow("G61.1\nG1 X0 Y0 Z0 A0 C0 F3000\nX100\n", settings);
    EXPECT_NEAR(slow.seconds(), 2.02, 5 * 0.002);
    EXPECT_NEAR(slow.rows[1].time_s, 0.002, 1e-12);
}

TEST(Linuxcnc, motion_begins_where_the_setup_or_the_program_says) {
    const std::string program = "G61\nG1 X10 Y0 Z0 A0 C0 F3000\nX20\n";
    const Running from_zero(program), from_first(program, recorded_settings(), {});
    ASSERT_TRUE(from_zero.run && from_first.run);
    EXPECT_EQ(from_zero.run->segments, 2U);
    EXPECT_EQ(from_first.run->segments, 1U);
    EXPECT_NEAR(from_first.rows.front().tip_mm.x(), 10, 1e-12);
}

TEST(Linuxcnc, with_tcp_off_the_axes_themselves_are_straight) {
    const std::string moves = "G1 X50 Y0 Z0 A0 C0 F3000\nX60 C90\n";
    const Running on("M428\n" + moves), off("M429\n" + moves);
    ASSERT_TRUE(on.run && off.run) << to_string(off.run.error());
    double on_aside = 0, off_aside = 0;
    for (const LinuxcncRow& row : on.rows) on_aside = std::max(on_aside, std::abs(row.axes[1]));
    for (const LinuxcncRow& row : off.rows) off_aside = std::max(off_aside, std::abs(row.axes[1]));
    EXPECT_NEAR(on_aside, 60, 1e-9);
    EXPECT_LT(off_aside, 1e-9);
}

TEST(Linuxcnc, offsets_and_machine_positions_lead_where_they_say) {
    machine::Setup setup = at_zero();
    setup.offsets["G55"].origin_mm = {5, 0, 0};
    const Running r("G1 X10 Y0 Z0 A0 C0 F3000\nG55 X10\nG53 G0 X30\n", recorded_settings(), setup);
    ASSERT_TRUE(r.run) << to_string(r.run.error());
    EXPECT_LT(distance_to(r.rows, {15, 0, 0}), 1e-9);
    EXPECT_NEAR(r.rows.back().axes[0], 30, 1e-9);
}

TEST(Linuxcnc, the_same_bits_again) {
    const std::string text = "G64 P0.1\nG1 X10 Y0 Z0 A0 C0 F6000\nY10\nG3 X0 Y20 R10\nG1 X5 Y7 A10\nX0\n";
    const Running first(text), second(text);
    ASSERT_EQ(first.rows.size(), second.rows.size());
    for (std::size_t k = 0; k < first.rows.size(); ++k) EXPECT_EQ(first.rows[k].axes, second.rows[k].axes);
}

/// The code of a refused run; `change` spoils program, machine or setup.
using Change = std::function<void(program::Program&, machine::Machine&, machine::Setup&, LinuxcncSettings&)>;

std::string refusal(const std::string& text, const Change& change) {
    machine::Machine machine = recorded_table();
    auto program = program_of("G21 G90 G94 G17\n" + text, machine);
    if (!program) return to_string(program.error());
    machine::Setup setup = at_zero();
    LinuxcncSettings settings = recorded_settings();
    change(*program, machine, setup, settings);
    const auto run = run_as_linuxcnc(*program, machine, setup, settings);
    return run ? "accepted" : run.error().code;
}

TEST(Linuxcnc, bad_input_is_refused_with_its_code) {
    const std::string line = "G1 X10 Y0 Z0 A0 C0 F3000\nX20 A5\n", arc = "G1 X10 Y0 Z0 A0 C0 F3000\nG2 X20 I5 J0\n";
    EXPECT_EQ(refusal(line, [](auto&, auto&, auto&, auto&) {}), "accepted");
    EXPECT_EQ(refusal(line, [](auto&, auto& m, auto&, auto&) { m.axes[0].letter = 'U'; }), "CTRL0101");
    EXPECT_EQ(refusal(line, [](auto&, auto& m, auto&, auto&) { m.axes[3].letter = 'B'; }), "CTRL0102");
    EXPECT_EQ(refusal(line, [](auto& p, auto&, auto&, auto&) { p.moves[1].law = program::OrientationLaw::vector; }),
              "CTRL0103");
    const Eigen::Matrix3d turned = Eigen::Vector3d(-1, -1, 1).asDiagonal();
    EXPECT_EQ(refusal(line, [&](auto&, auto&, auto& s, auto&) { s.workpiece.rotation = turned; }), "CTRL0104");
    EXPECT_EQ(refusal(line, [&](auto&, auto&, auto& s, auto&) { s.offsets["G54"].rotation = turned; }), "CTRL0104");
    EXPECT_EQ(refusal(line, [](auto& p, auto&, auto&, auto&) { p.moves[1].feed = {}; }), "CTRL0105");
    EXPECT_EQ(refusal(arc, [](auto& p, auto&, auto&, auto&) { p.arcs[0].angle_rad = 0; }), "CTRL0106");
    EXPECT_EQ(refusal(arc, [](auto& p, auto&, auto&, auto&) { p.arcs[0].centre_mm = {10, 0, 0}; }), "CTRL0106");
    EXPECT_EQ(
        refusal(arc, [](auto& p, auto&, auto&, auto&) { p.arcs[0].normal = Eigen::Vector3d(0, 1, 1).normalized(); }),
        "CTRL0106");
    EXPECT_EQ(refusal(line, [](auto& p, auto&, auto&, auto&) { p.moves.resize(1); }), "CTRL0108");
    EXPECT_EQ(refusal("G1 X0 Y0 Z0 A0 C0 F3000\nX1\n", [](auto& p, auto&, auto&, auto&) { p.moves[1] = p.moves[0]; }),
              "CTRL0108");
    EXPECT_EQ(refusal("T1 M6\nG43\n" + line, [](auto&, auto&, auto& s, auto&) { s.tools["2"] = {}; }), "CTRL0109");
    EXPECT_EQ(refusal("G55\n" + line, [](auto&, auto&, auto&, auto&) {}), "CTRL0110");
    EXPECT_EQ(refusal(line, [](auto& p, auto&, auto&, auto&) { p.moves[1].position_mm.x() = 2e7; }), "CTRL0111");
}

TEST(Linuxcnc, what_never_ends_is_refused) {
    const auto slow = [](const std::string& text) {
        return refusal(text, [](auto&, auto&, auto&, LinuxcncSettings& settings) { settings.longest_run_s = 10; });
    };
    EXPECT_EQ(slow("G1 X0 Y0 Z0 A0 C0 F600\nX90\n"), "accepted");
    EXPECT_EQ(slow("G1 X0 Y0 Z0 A0 C0 F600\nX110\n"), "CTRL0112");
    EXPECT_EQ(slow("G1 X0 Y0 Z0 A0 C0 F600\nX10\nG4 P1000000000000000000000\nX20\n"), "CTRL0112");
}

TEST(Linuxcnc, settings_without_meaning_are_refused) {
    const std::string line = "G1 X10 Y0 Z0 A0 C0 F3000\nX20\n";
    const auto with = [&](const std::function<void(LinuxcncSettings&)>& change) {
        return refusal(line, [&](auto&, auto&, auto&, LinuxcncSettings& settings) { change(settings); });
    };
    EXPECT_EQ(with([](auto& s) { s.servo_period_s = 0; }), "CTRL0107");
    EXPECT_EQ(with([](auto& s) { s.servo_period_s = std::nan(""); }), "CTRL0107");
    EXPECT_EQ(with([](auto& s) { s.max_linear_velocity_mm_s = -1; }), "CTRL0107");
    EXPECT_EQ(with([](auto& s) { s.feed_override = 1.5; }), "CTRL0107");
    EXPECT_EQ(with([](auto& s) { s.rapid_override = 0; }), "CTRL0107");
    EXPECT_EQ(with([](auto& s) { s.optimization_depth = -1; }), "CTRL0107");
    EXPECT_EQ(with([](auto& s) { s.ramp_frequency_hz = 0; }), "CTRL0107");
    EXPECT_EQ(with([](auto& s) { s.kink_ratio = 0; }), "CTRL0107");
    EXPECT_EQ(with([](auto& s) { s.queue_full = 1; }), "CTRL0107");
    EXPECT_EQ(with([](auto& s) { s.longest_run_s = 0; }), "CTRL0107");
    EXPECT_EQ(with([](auto& s) { s.start_tolerance_mm = -0.1; }), "CTRL0107");
    EXPECT_EQ(with([](auto& s) { s.waits[LinuxcncWait::coolant] = -1; }), "CTRL0107");
    EXPECT_EQ(with([](auto& s) { s.axis_limits['B'] = {1, 1}; }), "CTRL0107");
    EXPECT_EQ(with([](auto& s) { s.axis_limits['X'] = {1, 0}; }), "CTRL0107");
}

TEST(Linuxcnc, a_negative_tolerance_is_refused) {
    const auto machine = recorded_table();
    for (const char* word : {"G64 P-1", "G64 P1 Q-0.1"}) {
        const auto program = program_of(std::string(word) + "\nG1 X0 Y0 Z0 A0 C0 F100\nX1\n", machine);
        ASSERT_FALSE(program) << word;
        EXPECT_EQ(program.error().code, "NC0314") << word;
    }
}

TEST(Linuxcnc, words_of_path_control_reach_the_model) {
    const auto machine = recorded_table();
    const auto program = program_of(
        "G21 G90 G94 G61\nG1 X0 Y0 Z0 A0 C0 F100\nG61.1 X1\nG64 X2\nG20 G64 P0.1 X3\nG64 P0.1 Q0.2 X4\n", machine);
    ASSERT_TRUE(program) << to_string(program.error());
    const auto& words = program->path_controls;
    ASSERT_EQ(words.size(), 5U);
    using program::PathControlKind;
    const PathControlKind kinds[] = {PathControlKind::exact, PathControlKind::stop, PathControlKind::blend,
                                     PathControlKind::blend, PathControlKind::blend};
    const double tolerances[] = {0, 0, 0, 2.54, 2.54}, merges[] = {0, 0, 0, 2.54, 5.08};
    for (std::size_t i = 0; i < 5; ++i) {
        EXPECT_EQ(words[i].kind, kinds[i]) << i;
        EXPECT_NEAR(words[i].tolerance_mm, tolerances[i], 1e-12) << i;
        EXPECT_NEAR(words[i].merge_tolerance_mm, merges[i], 1e-12) << i;
        EXPECT_EQ(words[i].before_move, i) << i;
    }
}

}  // namespace
}  // namespace trunnion::controller
