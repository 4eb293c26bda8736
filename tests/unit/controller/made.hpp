// A machine, a control and programs made for a question.
#pragma once

#include <cmath>
#include <initializer_list>
#include <vector>

#include <gtest/gtest.h>

#include "trunnion/base/quantity.hpp"
#include "trunnion/controller/predict.hpp"

namespace trunnion::test {

/// C on A table at the machine's zero: 500 mm/s, 2000 mm/s², 20 000 mm/s³; 2 rad/s, 10 rad/s², 100 rad/s³. Rapids twice
/// as fast.
inline machine::Machine made_machine() {
    machine::Machine out{.name = "made"};
    out.axis_count = 5;
    out.rotary_count = 2;
    constexpr char letters[] = "XYZAC";
    for (std::size_t a = 0; a < 5; ++a) {
        machine::Axis& axis = out.axes[a];
        axis.letter = letters[a];
        axis.rotary = a > 2;
        axis.direction = Eigen::Vector3d::Unit(a < 3 ? static_cast<int>(a) : a == 3 ? 0 : 2);
        axis.feed = axis.rotary ? machine::AxisLimits{2, 10, 100} : machine::AxisLimits{500, 2000, 20000};
        axis.rapid = axis.feed;
        axis.rapid.velocity *= 2;
    }
    out.axes[3].range_min = -100 * degree;
    out.axes[3].range_max = 100 * degree;
    out.chain = {4, 3, 0, 1, 2};
    return out;
}

/// Jerk-limited, arcs of 0.01 mm at transitions, without any limit of blocks.
inline motion::Controller made_control() {
    motion::Controller out{.name = "made"};
    const auto set = [&](motion::ParameterId id, double value) {
        out[id] = {value, motion::Source::identified, 0, true};
    };
    const double unlimited = std::numeric_limits<double>::infinity();
    using enum motion::ParameterId;
    for (const auto id : {look_ahead_blocks, look_ahead_distance, curvature_jump_share}) set(id, unlimited);
    for (const auto id : {block_buffer, velocity_share, acceleration_share, jerk_share, rapid_share}) set(id, 1);
    set(reference_radius, 1 / degree);
    set(rounding_tolerance, 0.01);
    out.transition.way = motion::Transition::rounding_arc;
    return out;
}

/// Cutting moves by rotary words: X, Y, Z in mm, A, C in deg; the first is where motion starts.
inline program::Program moves(double feed_mm_s, std::initializer_list<std::array<double, 5>> poses) {
    program::Program out{.source = "made"};
    out.rotary_letters = {'A', 'C'};
    for (const auto& pose : poses) {
        program::Move move{.law = program::OrientationLaw::rotary};
        move.position_mm = {pose[0], pose[1], pose[2]};
        move.rotary_rad = {pose[3] * degree, pose[4] * degree, 0};
        move.feed = {program::FeedRule::tip_speed, feed_mm_s};
        move.line = static_cast<int>(out.moves.size()) + 1;
        out.moves.push_back(move);
    }
    return out;
}

struct Predicted {
    motion::Prediction told;
    std::vector<motion::PredictedRow> rows;

    /// The highest speed of the tip on a line.
    double top_mm_s(int line) const {
        double out = 0;
        for (const auto& row : rows)
            if (row.line == line) out = std::max(out, row.tip_feed_mm_s);
        return out;
    }
    /// The speed of the tip where a line begins.
    double begin_mm_s(int line) const {
        for (const auto& row : rows)
            if (row.line == line) return row.tip_feed_mm_s;
        return NAN;
    }
};

inline Predicted predicted(const program::Program& program, const motion::Controller& control,
                           const machine::Setup& setup = {}, const controller::PredictOptions& options = {}) {
    Predicted out;
    const auto result = controller::predict(program, made_machine(), setup, control, options,
                                            [&](const motion::PredictedRow& row) { out.rows.push_back(row); });
    EXPECT_TRUE(result) << to_string(result.error());
    if (result) out.told = *result;
    return out;
}

}  // namespace trunnion::test
