// LinuxCNC's planner told as a prediction: times, causes, doubts.
#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include "trunnion/controller/predict.hpp"

#include "linuxcnc_running.hpp"

namespace trunnion::controller {
namespace {

using motion::LimitKind;
using motion::ParameterId;

/// As the control was recorded, nothing in doubt.
motion::Controller recorded_control() {
    motion::Controller out{.name = "recorded", .kind = motion::ControllerKind::linuxcnc};
    out[ParameterId::arc_blend_ramp_freq] = {20, motion::Source::identified, 0, true};
    out[ParameterId::max_linear_velocity] = {500, motion::Source::identified, 0, true};
    return out;
}

struct Told {
    explicit Told(const std::string& text, const motion::Controller& control = recorded_control(),
                  PredictOptions options = {.uncertainty = false})
        : machine(recorded_table()) {
        const auto program = program_of("G21 G90 G94 G17\n" + text, machine);
        if (!program) {
            ADD_FAILURE() << to_string(program.error());
            return;
        }
        auto found = predict(*program, machine, at_zero(), control, options,
                             [&](const motion::PredictedRow& row) { rows.push_back(row); });
        if (!found)
            code = found.error().code;
        else
            told = std::move(*found);
    }

    /// Share of the cutting time in which something limits.
    double share(const std::string& cause) const {
        double sum = 0;
        for (const motion::LimitTime& limit : told.limits)
            if (to_string(limit.limit, machine) == cause) sum += limit.time_s;
        return sum / told.cut_time_s;
    }
    /// What costs most in the drop of the feed that costs most.
    std::string worst_cause() const {
        const auto worst = std::ranges::max_element(told.feed_drops, {}, &motion::PredictedDrop::lost_s);
        return worst == told.feed_drops.end() ? "none" : to_string(worst->cause, machine);
    }

    machine::Machine machine;
    motion::Prediction told;
    std::vector<motion::PredictedRow> rows;
    std::string code;
};

TEST(LinuxcncPrediction, TimesAreThoseOfTheRunAndAddUp) {
    const std::string text =
        "M3 S900\nG0 X20 Y0 Z0 A0 C0\nG1 X40 F3000\nG4 P0.25\nX60\nT1 M6\nX80\nM8\nM5\nX90\nG0 Z20\nM9\n";
    const Told predicted(text);
    const Running running(text);
    ASSERT_TRUE(running.run);
    const motion::Prediction& p = predicted.told;
    EXPECT_EQ(p.cycle_time_s, running.seconds());
    EXPECT_NEAR(p.dwell_time_s, 0.255, 1e-9);
    EXPECT_NEAR(p.tool_change_time_s, 0.422, 1e-9);
    EXPECT_NEAR(p.other_stop_time_s, 0.1,
                1e-9);  // M8 and M5 drain the queue together; M3 is before, M9 behind the motion
    EXPECT_NEAR(p.cut_time_s + p.rapid_time_s + p.dwell_time_s + p.tool_change_time_s + p.other_stop_time_s,
                p.cycle_time_s, 1e-9);
    EXPECT_NEAR(p.rapid_time_s, 2 * std::sqrt(20 / 2500.0) + 2 * std::sqrt(20 / (2100.0 / 2)),
                0.01);  // the last at half
    EXPECT_NEAR(p.cut_time_s, 70.0 / 50 + 4 * 50.0 / 2500, 0.1);
    EXPECT_EQ(p.standstills, 6u);
    double cut = 0;
    for (const motion::LimitTime& limit : p.limits) cut += limit.time_s;
    EXPECT_NEAR(cut, p.cut_time_s, 0.01);
}

TEST(LinuxcncPrediction, CausesOfCruising) {
    const std::string start = "G61\nG1 X0 Y0 Z0 A0 C0 F3000\n";
    EXPECT_GT(Told(start + "X100\n").share("feed"), 0.9);
    EXPECT_GT(Told(start + "X400 F60000\n").share("X velocity"), 0.55);
    EXPECT_GT(Told(start + "A80 F60000\n").share("A velocity"), 0.45);
    motion::Controller slow = recorded_control();
    slow[ParameterId::max_linear_velocity].value = 30;
    EXPECT_GT(Told(start + "X100\n", slow).share("linear velocity"), 0.9);
    EXPECT_EQ(Told(start + "X100\n", slow).share("feed"), 0);
    EXPECT_GT(Told("G61\nG1 X0 Y0 Z0 A0 C0 F60000\nG2 X0 Y0 I5 J0 P9\n").share("X curvature"), 0.6);
}

TEST(LinuxcncPrediction, CausesOfSpeedingUpAndBraking) {
    const Told line("G61\nG1 X0 Y0 Z0 A0 C0 F60000\nY20\n");  // never reaches 1000 mm/s
    EXPECT_GT(line.share("Y acceleration"), 0.8);
    EXPECT_EQ(line.worst_cause(), "stop");
}

TEST(LinuxcncPrediction, CausesOfSlowPlaces) {
    const std::string start = "G1 X0 Y0 Z0 A0 C0 F6000\n";
    const std::string corner = start + "X100\nY100\nX0\n";
    EXPECT_EQ(Told("G61\n" + corner).worst_cause(), "stop");
    EXPECT_EQ(Told("G64 P0.01\n" + corner).worst_cause(), "transition");
    const std::string curve = start + "X20\nX40\nX60\nX80\nY60\n";  // braking begins in front of the last tangent joint
    EXPECT_EQ(Told("G61\n" + curve).worst_cause(), "stop");
    motion::Controller without = recorded_control();
    without.arc_blend_enable.way = motion::Switch::off;
    EXPECT_EQ(Told("G64 P0.01\n" + corner, without).worst_cause(), "transition");

    // Where rotary axes turn no block is looked beyond.
    std::string turning, still;
    for (int i = 1; i <= 60; ++i) {
        turning += "X" + std::to_string(i) + " A" + std::to_string(0.01 * i) + "\n";
        still += "X" + std::to_string(0.1 * i) + "\n";
    }
    EXPECT_EQ(Told("G64 P0.01 Q0\n" + start + turning).worst_cause(), "look-ahead");
    EXPECT_NE(Told("G64 P0.01 Q0\n" + start + still).worst_cause(), "look-ahead");
    motion::Controller near = recorded_control();
    near[ParameterId::arc_blend_optimization_depth] = {2, motion::Source::identified, 0, true};
    EXPECT_EQ(Told("G64 P0.01 Q0\n" + start + still, near).worst_cause(), "look-ahead");
}

TEST(LinuxcncPrediction, BlocksShorterThanAPeriodAreBoundByIt) {
    std::string blocks;
    for (int i = 1; i <= 2000; ++i) blocks += "X" + std::to_string(0.03 * i) + "\n";
    const Told told("G64 P0.01 Q0\nG1 X0 Y0 Z0 A0 C0 F6000\n" + blocks);  // 0.03 mm at 100 mm/s: 0.3 ms
    EXPECT_GT(told.share("block time") + told.share("command rate"), 0.9);
    EXPECT_LT(told.share("feed"), 0.05);
}

TEST(LinuxcncPrediction, EveryMomentHasACause) {
    const Told told(
        "G64 P0.05\nG1 X10 Y0 Z0 A0 C0 F6000\nX40\nY20\nG3 X20 Y40 R20\nG1 X5 Y7 A10\nA20\nG0 Z30\nG1 X0 F300\n");
    for (const motion::PredictedRow& row : told.rows) {
        EXPECT_NE(row.limit.kind, LimitKind::planner) << row.time_s;
        const bool of_axis = row.limit.kind == LimitKind::velocity || row.limit.kind == LimitKind::acceleration;
        EXPECT_EQ(row.limit.axis >= 0, of_axis || row.limit.kind == LimitKind::curvature) << row.time_s;
    }
    EXPECT_EQ(told.rows.back().limit.kind, LimitKind::stop);
}

TEST(LinuxcncPrediction, LoadsAreThoseOfTheJoints) {
    const Told told("G61.1\nG1 X0 Y0 Z0 A0 C0 F60000\nX400\nA50\n");
    EXPECT_NEAR(told.told.axes[0].velocity_ratio, 1, 1e-9);
    EXPECT_NEAR(told.told.axes[0].acceleration_ratio, 1, 1e-9);
    // A step of the acceleration goes through the mean of two periods and the cubic of three: 1, 5, 5, 1 twelfths.
    EXPECT_NEAR(told.told.axes[0].jerk_ratio, 5.0 / 12 * 2500 / 1e-3 / 5000, 1e-4);
    EXPECT_EQ(told.told.axes[2].jerk_ratio, 0);
}

TEST(LinuxcncPrediction, SettingsAreThoseOfTheControllerFile) {
    const std::string line = "G61.1\nG1 X0 Y0 Z0 A0 C0 F3000\nX100\n";
    const auto with = [&](ParameterId id, double value) {
        motion::Controller control = recorded_control();
        control[id] = {value, motion::Source::identified, 0, true};
        return Told(line, control).told.cycle_time_s;
    };
    const double before = Told(line).told.cycle_time_s;
    EXPECT_GT(with(ParameterId::max_linear_velocity, 25), before + 1.9);
    EXPECT_NEAR(std::remainder(with(ParameterId::servo_period, 0.01), 0.01), 0, 1e-9);
    motion::Controller limited = recorded_control();
    auto& of_x = limited.axis_limits['X'];
    of_x[0] = {20, motion::Source::identified, 0, true};
    EXPECT_NEAR(Told(line, limited).told.cycle_time_s, 5 + 20.0 / 2500, 0.006);
    of_x[1] = {100, motion::Source::identified, 0, true};
    EXPECT_NEAR(Told(line, limited).told.cycle_time_s, 5 + 20.0 / 100, 0.006);
    limited.axis_limits['B'] = of_x;
    EXPECT_EQ(Told(line, limited).code, "CTRL0107");
    motion::Controller fallback = recorded_control();
    fallback.arc_blend_fallback_enable.way = motion::Switch::on;
    EXPECT_EQ(Told(line, fallback).code, "CTRL0113");
    EXPECT_EQ(Told(line, recorded_control(), {.feed_override = 1.2}).code, "CTRL0107");
    motion::Controller faster = recorded_control();
    faster[ParameterId::max_feed_override] = {1.2, motion::Source::identified, 0, true};
    EXPECT_NEAR(Told(line, faster, {.feed_override = 1.2, .uncertainty = false}).told.cycle_time_s,
                100.0 / 60 + 60.0 / 2500, 0.006);
}

TEST(LinuxcncPrediction, WaitsMakeTheTimeUncertain) {
    const std::string text = "G64 P0.05\nG1 X20 Y0 Z0 A0 C0 F3000\nM8\nX40\nM3\nX60\nM5\nX80\n";
    EXPECT_EQ(Told(text, recorded_control(), {}).told.uncertainty_s, 0);
    motion::Controller control = recorded_control();
    control[ParameterId::coolant_time] = {0.1, motion::Source::guessed, 0.05, true};
    control[ParameterId::spindle_time] = {0.5, motion::Source::guessed, 0.2, true};
    control[ParameterId::tool_change_time] = {6, motion::Source::guessed, 3, true};
    const auto told = Told(text, control, {}).told;
    ASSERT_EQ(told.doubts.size(), 3u);
    EXPECT_EQ(told.doubts[0].parameter, "spindle_time");
    EXPECT_NEAR(told.doubts[0].time_high_s - told.doubts[0].time_low_s, 2 * 0.4, 1e-9);
    EXPECT_EQ(told.doubts[2].time_high_s, told.doubts[2].time_low_s);  // no tool change
    EXPECT_NEAR(told.uncertainty_s, std::hypot(0.4, 0.05), 1e-9);
    motion::Controller longer = control;
    longer[ParameterId::spindle_time].value = 0.7;
    EXPECT_NEAR(Told(text, longer, {}).told.cycle_time_s, told.doubts[0].time_high_s, 1e-9);
}

TEST(LinuxcncPrediction, ShortBlocksMakeTheTimeUncertain) {
    std::string blocks;
    for (int i = 1; i <= 2000; ++i) blocks += "X" + std::to_string(0.03 * i) + "\n";
    motion::Controller control = recorded_control();
    control[ParameterId::missed_command_periods] = {0, motion::Source::guessed, 0.13, true};
    const auto dense = Told("G64 P0.01 Q0\nG1 X0 Y0 Z0 A0 C0 F6000\n" + blocks, control, {}).told;
    EXPECT_GT(dense.uncertainty_s, 0.04 * dense.cycle_time_s);
    EXPECT_LT(dense.uncertainty_s, 0.1 * dense.cycle_time_s);
    const auto coarse = Told("G64 P0.01 Q0\nG1 X0 Y0 Z0 A0 C0 F6000\nX100\nX200 Y1\n", control, {}).told;
    EXPECT_LT(coarse.uncertainty_s, 0.002);
}

/// The last digits are worth tenths of a percent where arcs blend short segments, nothing elsewhere.
TEST(LinuxcncPrediction, LastDigitsMakeTheTimeUncertain) {
    std::string walk;
    double x = 0, y = 0;
    std::uint64_t state = 3;
    const auto draw = [&] {
        state = state * 6364136223846793005u + 1442695040888963407u;
        return static_cast<double>(state >> 40) / (1 << 24) - 0.5;
    };
    for (int i = 0; i < 300; ++i) {
        x += draw();
        y += draw();
        walk += "X" + std::to_string(x) + " Y" + std::to_string(y) + "\n";
    }
    const std::string begin = "G64 P0.1 Q0\nG1 X0 Y0 Z0 A0 C0 F6000\n";
    const auto chaotic = Told(begin + walk, recorded_control(), {}).told;
    ASSERT_EQ(chaotic.doubts.size(), 1u);
    EXPECT_EQ(chaotic.doubts[0].parameter, "last digits");
    EXPECT_GT(chaotic.uncertainty_s, 0.002);
    EXPECT_LT(chaotic.uncertainty_s, 0.02 * chaotic.cycle_time_s);
    EXPECT_LT(Told(begin + "X40\nY40\nX0\n", recorded_control(), {}).told.uncertainty_s, 0.0015);
}

TEST(LinuxcncPrediction, MovesBeforeTheFirstWholePoseAreToldOf) {
    const std::string text = "G0 X10\nY5\nG1 Z0 A0 C0 F3000\nX40\n";
    const auto told = Told(text).told;
    const auto found = std::ranges::find(told.diagnostics, "CTRL0207", &Diagnostic::code);
    ASSERT_NE(found, told.diagnostics.end());
    EXPECT_GE(found->count, 2);
    EXPECT_EQ(found->severity, Severity::warning);
    const auto whole = Told("G0 X10 Y5 Z0 A0 C0\nG1 X40 F3000\n").told;
    EXPECT_EQ(std::ranges::find(whole.diagnostics, "CTRL0207", &Diagnostic::code), whole.diagnostics.end());
}

}  // namespace
}  // namespace trunnion::controller
