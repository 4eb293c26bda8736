#include "detail/axis_limits.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

namespace trunnion::verify {

namespace {

constexpr double range_slack = 1e-9;  // mm, rad: rounding of degrees
constexpr std::array<const char*, 3> names{"velocity_ratio", "acceleration_ratio", "jerk_ratio"};

double limit_of(const machine::AxisLimits& limits, int order) {
    return order == 1 ? limits.velocity : order == 2 ? limits.acceleration : limits.jerk;
}

/// One axis over time, standing still before the first row and after the last one.
class AxisTrack {
  public:
    AxisTrack(const SetpointTable& setpoints, int axis) : setpoints_(setpoints), axis_(axis) {}

    /// Difference of order 1, 2 or 3 over rows i − order … i, divided by the period's power.
    double difference(std::ptrdiff_t i, int order) const {
        const double period = setpoints_.period_s;
        const double a = at(i), b = at(i - 1);
        if (order == 1) return (a - b) / period;
        const double c = at(i - 2);
        if (order == 2) return ((a - b) - (b - c)) / (period * period);
        const double d = at(i - 3);
        return (((a - b) - (b - c)) - ((b - c) - (c - d))) / (period * period * period);
    }

  private:
    double at(std::ptrdiff_t i) const {
        const auto last = static_cast<std::ptrdiff_t>(setpoints_.rows.size()) - 1;
        return setpoints_.rows[static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(i, 0, last))].position[axis_];
    }

    const SetpointTable& setpoints_;
    int axis_;
};

bool touches_rapid(const std::vector<bool>& at_rapid, std::ptrdiff_t i, int order) {
    const auto last = static_cast<std::ptrdiff_t>(at_rapid.size()) - 1;
    for (std::ptrdiff_t n = std::max<std::ptrdiff_t>(0, i - order); n <= std::min(i, last); ++n)
        if (at_rapid[static_cast<std::size_t>(n)]) return true;
    return false;
}

/// Peak / limit of one derivative; `worst_allowed` above which the first place is kept as a breach.
double peak_ratio(const SetpointTable& setpoints, const std::vector<bool>& at_rapid, const machine::Axis& axis,
                  int index, int order, double worst_allowed, Verdict& verdict) {
    const AxisTrack track(setpoints, index);
    const double feed = limit_of(axis.feed, order);
    const double rapid = std::max(feed, limit_of(axis.rapid, order));
    const auto rows = static_cast<std::ptrdiff_t>(setpoints.rows.size());
    double peak = 0;
    bool broken = false;
    for (std::ptrdiff_t i = 1; i < rows + order; ++i) {
        const double size = std::abs(track.difference(i, order));
        const double limit = rapid > feed && touches_rapid(at_rapid, i, order) ? rapid : feed;
        peak = std::max(peak, size / limit);
        if (broken || !(size > worst_allowed * limit)) continue;
        broken = true;
        const auto& row = setpoints.rows[static_cast<std::size_t>(std::min(i, rows - 1))];
        verdict.broken.push_back({fmt::format("axes.{}.{}", axis.letter, names[static_cast<std::size_t>(order - 1)]),
                                  row.time_s, row.line, size / limit, worst_allowed});
    }
    return peak;
}

double range_excess(const SetpointTable& setpoints, const machine::Axis& axis, int index, Verdict& verdict) {
    double worst = 0;
    bool broken = false;
    for (const auto& row : setpoints.rows) {
        const double x = row.position[index];
        const double excess = std::max(axis.range_min - x, x - axis.range_max);
        worst = std::max(worst, excess);
        if (broken || excess <= range_slack) continue;
        broken = true;
        verdict.broken.push_back({fmt::format("axes.{}.range_excess", axis.letter), row.time_s, row.line, excess, 0});
    }
    return worst;
}

}  // namespace

void check_axes(const SetpointTable& setpoints, const std::vector<bool>& at_rapid, const machine::Machine& machine,
                double limit_excess, Verdict& verdict) {
    for (int i = 0; i < machine.axis_count; ++i) {
        const machine::Axis& axis = machine.axes[i];
        AxisVerdict out;
        out.letter = axis.letter;
        out.rotary = axis.rotary;
        if (setpoints.rows.size() > 1) {
            out.velocity_ratio = peak_ratio(setpoints, at_rapid, axis, i, 1, limit_excess, verdict);
            out.acceleration_ratio = peak_ratio(setpoints, at_rapid, axis, i, 2, limit_excess, verdict);
            out.jerk_ratio = peak_ratio(setpoints, at_rapid, axis, i, 3, limit_excess, verdict);
        }
        out.range_excess = range_excess(setpoints, axis, i, verdict);
        verdict.axes.push_back(out);
    }
}

}  // namespace trunnion::verify
