#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "trunnion/feed/live_planner.hpp"

#include "synthetic_paths.hpp"

namespace trunnion::test {

/// Runs a LivePlanner and holds every setpoint against the limits, in two ways that know nothing of the planner: by the
/// first three differences of the axis positions, which a jump of position, speed or acceleration would break by far,
/// and by the path's derivatives at the state that it tells.
class LiveDrive {
  public:
    static constexpr double period_s = 1e-3;

    explicit LiveDrive(const Stretch& stretch, const feed::FeedOptions& options = {})
        : stretch_(stretch), planner_(*feed::LivePlanner::make(*stretch.axis_path, options, period_s)) {
        note(stretch.axis_path->begin_position());
        state_.place = {};
    }

    feed::LivePlanner& planner() { return planner_; }
    const feed::LiveState& state() const { return state_; }
    double p_mm() const { return p_of(state_.place); }
    std::size_t ticks() const { return ticks_; }
    bool failed() const { return failed_; }
    /// Peak of the differences and of the states, of the limits.
    double worst_difference() const { return worst_difference_; }
    double worst_state() const { return worst_state_; }
    /// Programmed feed of the present block's tip, mm/s; 0 where there is none.
    double tip_feed() const { return tip_feed_; }

    bool tick() {
        const auto next = planner_.tick();
        ++ticks_;
        failed_ = !next;
        if (failed_) return false;
        if (p_of(next->place) < p_mm()) went_back_ = true;
        state_ = *next;
        path::AxisSample at;
        stretch_.axis_path->evaluate(state_.place, at);
        machine::AxisPosition position;
        for (int i = 0; i < stretch_.axis_path->axis_count(); ++i) position[i] = at.axes[i].value();
        note(position);
        check_state(at);
        return state_.status != feed::LiveStatus::finished;
    }
    bool went_back() const { return went_back_; }
    /// Ticks until the machine does not move any more; it may stand for the two periods until a command takes effect.
    void run_until_standing(int most = 200000) {
        for (int k = 0; k < most && tick(); ++k)
            if (k > 2 && state_.status != feed::LiveStatus::moving) return;
    }

  private:
    double p_of(path::PathPlace place) const {
        return stretch_.tool_path.pieces[place.piece].begin_mm + place.offset_mm;
    }
    const machine::AxisLimits& limits(int axis) const {
        return stretch_.tool_path.rapid ? stretch_.machine.axes[axis].rapid : stretch_.machine.axes[axis].feed;
    }
    void note(const machine::AxisPosition& position) {
        if (last_.empty()) last_.assign(4, position);
        last_.erase(last_.begin());
        last_.push_back(position);
        for (int i = 0; i < stretch_.axis_path->axis_count(); ++i) {
            const double d = last_[3][i], c = last_[2][i], b = last_[1][i], a = last_[0][i];
            const machine::AxisLimits& limit = limits(i);
            worst_difference_ = std::max({worst_difference_, std::abs(d - c) / period_s / limit.velocity,
                                          std::abs(d - 2 * c + b) / (period_s * period_s) / limit.acceleration,
                                          std::abs(d - 3 * c + 3 * b - a) / std::pow(period_s, 3) / limit.jerk});
        }
    }
    void check_state(const path::AxisSample& at) {
        const double v = state_.speed_mm_s, a = state_.acceleration_mm_s2;
        for (int i = 0; i < stretch_.axis_path->axis_count(); ++i) {
            const Taylor3& q = at.axes[i];
            const machine::AxisLimits& limit = limits(i);
            const double jerk = q.d3() * v * v * v + 3 * q.d2() * v * a + q.d1() * state_.jerk_mm_s3;
            worst_state_ =
                std::max({worst_state_, std::abs(q.d1() * v) / limit.velocity,
                          std::abs(q.d2() * v * v + q.d1() * a) / limit.acceleration, std::abs(jerk) / limit.jerk});
        }
        tip_feed_ = v * at.feed_rate;
    }

    const Stretch& stretch_;
    feed::LivePlanner planner_;
    feed::LiveState state_;
    std::vector<machine::AxisPosition> last_;
    std::size_t ticks_ = 0;
    double worst_difference_ = 0, worst_state_ = 0, tip_feed_ = 0;
    bool failed_ = false, went_back_ = false;
};

/// The least time in which one axis comes from a speed and an acceleration to rest.
inline double axis_stopping_time(double v, double a, const machine::AxisLimits& limit) {
    const double left =
        v + a * std::abs(a) / (2 * limit.jerk);  // the speed when the acceleration is taken back at once
    if (left < 0) v = -v, a = -a;
    const double peak =
        std::min(std::max(limit.acceleration, std::abs(a)), std::sqrt(std::max(limit.jerk * v + a * a / 2, 0.0)));
    if (!(peak > 0)) return 0;
    const double t1 = (a + peak) / limit.jerk, v1 = v + t1 * (a - limit.jerk * t1 / 2);
    const double t2 = std::max(0.0, (v1 - peak * peak / (2 * limit.jerk)) / peak);
    return t1 + t2 + peak / limit.jerk;
}

/// No stop along the path is shorter than the longest of its axes' own. Exact on a straight line.
inline double stopping_bound_s(const Stretch& stretch, const feed::LiveState& state) {
    path::AxisSample at;
    stretch.axis_path->evaluate(state.place, at);
    double out = 0;
    for (int i = 0; i < stretch.axis_path->axis_count(); ++i) {
        const double v = at.axes[i].d1() * state.speed_mm_s;
        const double a =
            at.axes[i].d2() * state.speed_mm_s * state.speed_mm_s + at.axes[i].d1() * state.acceleration_mm_s2;
        out = std::max(out, axis_stopping_time(v, a, stretch.machine.axes[i].feed));
    }
    return out;
}

}  // namespace trunnion::test
