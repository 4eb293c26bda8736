#pragma once

#include <cmath>
#include <string_view>
#include <vector>

#include <Eigen/Geometry>

#include "trunnion/base/quantity.hpp"
#include "trunnion/verify/check.hpp"

/// A machine and motions made by hand, with inverse kinematics of the tests' own.
namespace trunnion::verify::test {

inline machine::Axis made_axis(char letter, Eigen::Vector3d direction, bool rotary, machine::AxisLimits limits) {
    machine::Axis out;
    out.letter = letter;
    out.rotary = rotary;
    out.direction = direction;
    out.feed = out.rapid = limits;
    return out;
}

/// Chain C A X Y Z, both rotary axes through the machine zero and counted against ISO 841.
inline machine::Machine peer_trunnion() {
    machine::Machine out;
    out.name = "peer trunnion";
    out.axis_count = 5;
    out.rotary_count = 2;
    out.axes[0] = made_axis('X', {1, 0, 0}, false, {500, 2500, 5000});
    out.axes[1] = made_axis('Y', {0, 1, 0}, false, {500, 3000, 5000});
    out.axes[2] = made_axis('Z', {0, 0, 1}, false, {500, 2100, 50000});
    out.axes[3] = made_axis('A', {1, 0, 0}, true, {90 * degree, 300 * degree, 1800 * degree});
    out.axes[4] = made_axis('C', {0, 0, 1}, true, {120 * degree, 300 * degree, 1800 * degree});
    for (int i = 0; i < 3; ++i) out.axes[i].range_min = -1000, out.axes[i].range_max = 1000;
    out.axes[3].range_min = -120 * degree, out.axes[3].range_max = 120 * degree;
    out.axes[3].reversed = out.axes[4].reversed = true;
    out.chain = {4, 3, 0, 1, 2};
    return out;
}

/// The same without limits that matter.
inline machine::Machine boundless() {
    auto out = peer_trunnion();
    for (auto& axis : out.axes) axis.feed = axis.rapid = {1e12, 1e15, 1e18};
    return out;
}

inline machine::Setup peer_setup() {
    machine::Setup out;
    out.workpiece.origin_mm = {0, 0, 50};
    return out;
}

inline Eigen::Matrix3d table_to_machine(double a, double c) {
    return (Eigen::AngleAxisd(-c, Eigen::Vector3d::UnitZ()) * Eigen::AngleAxisd(-a, Eigen::Vector3d::UnitX()))
        .toRotationMatrix();
}

/// Axes that bring the tip to a place with A and C as given.
inline machine::AxisPosition axes_for(const Eigen::Vector3d& tip, double a, double c,
                                      const machine::Setup& setup = peer_setup()) {
    const Eigen::Vector3d in_table = setup.workpiece.rotation * tip + setup.workpiece.origin_mm;
    const Eigen::Vector3d linear = table_to_machine(a, c).transpose() * in_table;
    return {{linear.x(), linear.y(), linear.z() + setup.tool.length_mm, a, c}};
}

inline Eigen::Vector3d axis_of(double a, double c) {
    return table_to_machine(a, c) * Eigen::Vector3d::UnitZ();
}

/// A and C for a tool axis, A ≥ 0 in the control's count.
inline std::array<double, 2> words_for(const Eigen::Vector3d& n) {
    const double a = std::atan2(std::hypot(n.x(), n.y()), n.z());
    return {a, a < 1e-12 ? 0.0 : std::atan2(n.x(), n.y())};
}

/// The same with C less than half a turn from `near`.
inline std::array<double, 2> words_near(const Eigen::Vector3d& n, double near) {
    const auto [a, c] = words_for(n);
    return {a, near + std::remainder(c - near, 360 * degree)};
}

inline ProgrammedPose pose(Eigen::Vector3d tip, std::int32_t line, Eigen::Vector3d axis = Eigen::Vector3d::UnitZ()) {
    ProgrammedPose out;
    out.tip_mm = tip;
    out.axis = axis.normalized();
    out.line = line;
    return out;
}

inline ProgrammedPose pose_by_words(Eigen::Vector3d tip, double a, double c, std::int32_t line) {
    ProgrammedPose out = pose(tip, line, axis_of(a, c));
    out.rotary_rad = {a, c};
    out.kind = PoseKind::rotary;
    return out;
}

/// Way of the time-optimal motion with bounded velocity, acceleration and jerk from rest to rest; the bounds are
/// reached.
class SevenPhases {
  public:
    SevenPhases(double way, double v, double a, double j) : way_(way), v_(v), a_(a), j_(j) {
        const double ramp = a / j, rise = v / a + ramp;
        ends_ = {ramp, v / a, rise, way / v};
        duration_ = way / v + rise;
    }
    double duration_s() const { return duration_; }
    double at(double t) const {
        if (t <= 0) return 0;
        if (t >= duration_) return way_;
        return t > duration_ / 2 ? way_ - rising(duration_ - t) : rising(t);
    }

  private:
    double rising(double t) const {
        if (t < ends_[0]) return j_ * t * t * t / 6;
        if (t < ends_[1])
            return a_ * a_ * a_ / (6 * j_ * j_) + a_ * a_ / (2 * j_) * (t - ends_[0]) +
                   a_ / 2 * (t - ends_[0]) * (t - ends_[0]);
        const double rise_way = v_ * ends_[2] / 2;
        if (t < ends_[2]) {
            const double left = ends_[2] - t;
            return rise_way - v_ * left + j_ * left * left * left / 6;
        }
        return rise_way + v_ * (t - ends_[2]);
    }
    double way_, v_, a_, j_;
    std::array<double, 4> ends_{};
    double duration_ = 0;
};

constexpr double period_s = 0.001;

inline motion::Setpoint row(std::size_t n, machine::AxisPosition position, std::int32_t line = 1) {
    motion::Setpoint out;
    out.time_s = static_cast<double>(n) * period_s;
    out.position = position;
    out.line = line;
    return out;
}

/// Rows along straight lines between tips, `step` mm a row, A and C constant. One line number a leg, from 1.
inline SetpointTable along(const std::vector<Eigen::Vector3d>& tips, double step, double a = 0, double c = 0) {
    std::vector<motion::Setpoint> rows{row(0, axes_for(tips.front(), a, c))};
    for (std::size_t n = 1; n < tips.size(); ++n) {
        const Eigen::Vector3d way = tips[n] - tips[n - 1];
        const auto count = std::max(1, static_cast<int>(std::lround(way.norm() / step)));
        for (int k = 1; k <= count; ++k)
            rows.push_back(
                row(rows.size(), axes_for(tips[n - 1] + way * k / count, a, c), static_cast<std::int32_t>(n)));
    }
    return *setpoint_table(std::move(rows));
}

inline std::vector<ProgrammedPose> poses_at(const std::vector<Eigen::Vector3d>& tips) {
    std::vector<ProgrammedPose> out;
    for (const auto& tip : tips) out.push_back(pose(tip, static_cast<std::int32_t>(out.size())));
    return out;
}

inline bool only_broken(const Verdict& verdict, std::vector<std::string_view> things) {
    if (verdict.broken.size() != things.size() || verdict.ok != things.empty()) return false;
    for (const auto thing : things)
        if (!verdict.first_of(thing)) return false;
    return true;
}

inline std::string broken_things(const Verdict& verdict) {
    std::string out;
    for (const auto& breach : verdict.broken) out += breach.what + " ";
    return out;
}

}  // namespace trunnion::verify::test
