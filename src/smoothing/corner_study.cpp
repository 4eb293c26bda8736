#include "trunnion/smoothing/corner_study.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include <Eigen/LU>
#include <fmt/format.h>

namespace trunnion::smoothing {

namespace {

using Eigen::Vector3d;
using geometry::BsplineCurve;
using machine::VectorSeries;

Vector3d value_of(const VectorSeries& series) {
    return {series[0].value(), series[1].value(), series[2].value()};
}

VectorSeries constant(const Vector3d& v) {
    return {Taylor3{v.x()}, Taylor3{v.y()}, Taylor3{v.z()}};
}

/// A curve seen from one of its ends.
geometry::CurvePoint from_end(const BsplineCurve& curve, int end, double share) {
    return end == 0 ? point_at_share(curve, share) : backwards(point_at_share(curve, 1 - share));
}

/// Gauss-Legendre with five points, within one half of the curve.
double length_mm(const BsplineCurve& curve, int end, double from, double to) {
    constexpr std::array<double, 5> node{-0.906179845938664, -0.538469310105683, 0, 0.538469310105683,
                                         0.906179845938664};
    constexpr std::array<double, 5> weight{0.236926885056189, 0.478628670499366, 0.568888888888889, 0.478628670499366,
                                           0.236926885056189};
    double sum = 0;
    for (std::size_t i = 0; i < node.size(); ++i)
        sum += weight[i] * from_end(curve, end, (from + to) / 2 + node[i] * (to - from) / 2)[1].norm();
    return sum * (to - from) / 2;
}

/// The share of the bottom curve at a path length from an end, within the half there.
double share_at(const BsplineCurve& curve, int end, double distance_mm) {
    constexpr int steps = 20;
    double share = 0;
    for (int i = 0; i < steps; ++i) {
        const double miss = length_mm(curve, end, 0, share) - distance_mm;
        share = std::clamp(share - miss / from_end(curve, end, share)[1].norm(), 0.0, 0.5);
    }
    return share;
}

double least(const machine::AxisLimits& limits, const Taylor3& q) {
    return std::min({limits.velocity / std::abs(q.d1()), std::sqrt(limits.acceleration / std::abs(q.d2())),
                     std::cbrt(limits.jerk / std::abs(q.d3()))});
}

/// The tool axis over a bottom point held fast, as a series in the top curve's parameter.
VectorSeries axis_by_top(const Vector3d& bottom_mm, const geometry::CurvePoint& top) {
    VectorSeries d;
    for (int i = 0; i < 3; ++i) d[i] = {top[0][i] - bottom_mm[i], top[1][i], top[2][i] / 2, top[3][i] / 6};
    const Taylor3 inverse = 1.0 / sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    return {inverse * d[0], inverse * d[1], inverse * d[2]};
}

/// Newton-Raphson on the derivative of ½‖n(u) − expected‖²; negative where it does not settle in ]0, 1[.
double nearest_top(const BsplineCurve& top, int end, const Vector3d& bottom_mm, const Vector3d& expected,
                   double start) {
    constexpr int steps = 50;
    constexpr double settled = 1e-14;
    double u = start;
    for (int i = 0; i < steps; ++i) {
        const VectorSeries axis = axis_by_top(bottom_mm, from_end(top, end, u));
        double slope = 0, curvature = 0;
        for (int k = 0; k < 3; ++k) {
            const double miss = axis[k].value() - expected[k];
            slope += miss * axis[k].d1();
            curvature += axis[k].d1() * axis[k].d1() + miss * axis[k].d2();
        }
        const double change = slope / curvature;
        u -= change;
        if (!(u > 0 && u < 1)) return -1;
        if (std::abs(change) < settled) return u;
    }
    return -1;
}

/// What is known of a place from its pose alone: positions, no derivatives.
struct Place {
    Vector3d tip_mm, tool;
    AxisSeries axes{};
};

Place place_on(StudiedMachine& on, const Vector3d& tip_mm, const Vector3d& tool) {
    Place place{tip_mm, tool, machine_axes(on, {constant(tip_mm), constant(tool)})};
    for (int k = 0; k < on.machine.rotary_count; ++k) on.near[k] = place.axes[on.machine.linear_count() + k].value();
    return place;
}

Place place_on(StudiedMachine& on, const LinkedPose& pose) {
    return place_on(on, value_of(pose.tip_mm), value_of(pose.tool_axis));
}

/// Four places a step apart, in order.
using Steps = std::array<Place, 4>;

double criterion_of(const Steps& steps, double step_mm) {
    return orientation_criterion(std::array{steps[0].tool, steps[1].tool, steps[2].tool, steps[3].tool}, step_mm);
}

double feed_limit_of(const Steps& steps, double step_mm, const StudiedMachine& on) {
    AxisSeries rates;
    for (std::size_t i = 0; i < rates.size(); ++i) {
        const double a = steps[3].axes[i].value(), b = steps[2].axes[i].value();
        const double c = steps[1].axes[i].value(), d = steps[0].axes[i].value();
        rates[i] = {a, (a - b) / step_mm, (a - 2 * b + c) / (2 * step_mm * step_mm),
                    (a - 3 * b + 3 * c - d) / (6 * step_mm * step_mm * step_mm)};
    }
    return feed_limit_mm_s(on.machine, rates, on.programmed_mm_s);
}

/// The pose at a path length from the entry, on the segments too.
class Way {
  public:
    Way(const DualCorner& corner, const Link& link)
        : corner_(corner),
          link_(link),
          half_mm_(length_mm(corner.curves.bottom(), 0, 0, 0.5)),
          whole_mm_(half_mm_ + length_mm(corner.curves.bottom(), 1, 0, 0.5)) {}

    double length() const { return whole_mm_; }
    LinkedPose at(double s) const {
        const BsplineCurve& bottom = corner_.curves.bottom();
        if (s < 0) return segment_pose(corner_, 0, -s);
        if (s > whole_mm_) return segment_pose(corner_, 1, s - whole_mm_);
        const double share = s < half_mm_ ? share_at(bottom, 0, s) : 1 - share_at(bottom, 1, whole_mm_ - s);
        return linked_pose(bottom, corner_.curves.top(), share, link_(share));
    }

  private:
    const DualCorner& corner_;
    const Link& link_;
    double half_mm_, whole_mm_;
};

struct EndPoints {
    std::array<double, 3> bottom, top;
};

std::unexpected<Diagnostic> refuse(const char* code, std::string text, double value, std::string hint) {
    Diagnostic refusal{
        .code = code, .text = std::move(text), .value = fmt::format("{:.6g} mm", value), .hint = std::move(hint)};
    return fail(std::move(refusal));
}

/// The three points after an end, seen from there, one after the other.
Result<EndPoints> settle_points(const DualCorner& corner, int end, double step_mm) {
    std::array<Vector3d, 3> past;  // newest first
    for (int k = 0; k < 3; ++k) past[k] = value_of(segment_pose(corner, end, k * step_mm).tool_axis);
    EndPoints out{};
    for (std::size_t k = 0; k < 3; ++k) {
        const double share = share_at(corner.curves.bottom(), end, static_cast<double>(k + 1) * step_mm);
        const Vector3d bottom = from_end(corner.curves.bottom(), end, share)[0];
        const Vector3d expected = 3 * past[0] - 3 * past[1] + past[2];  // no third difference
        const double top = nearest_top(corner.curves.top(), end, bottom, expected, share);
        if (top < 0)
            return refuse("SMTH0122", "no top parameter gives the tool axis that the points before ask for", step_mm,
                          "take a shorter step");
        out.bottom[k] = share;
        out.top[k] = top;
        past = {value_of(axis_by_top(bottom, from_end(corner.curves.top(), end, top))), past[0], past[1]};
    }
    return out;
}

/// Cubic through eight points of a function; knots are means of three abscissae (Piegl & Tiller, Eq. 9.8). Since x
/// itself is reproduced the curve's parameter is x.
Result<BsplineCurve> interpolating(const std::array<double, 8>& x, const std::array<double, 8>& y) {
    std::vector<double> knots{0, 0, 0, 0};
    for (std::size_t i = 1; i < 5; ++i) knots.push_back((x[i] + x[i + 1] + x[i + 2]) / 3);
    knots.insert(knots.end(), 4, 1.0);
    Eigen::Matrix<double, 8, 8> basis;
    for (int column = 0; column < 8; ++column) {
        std::vector<Vector3d> unit(8, Vector3d::Zero());
        unit[column].x() = 1;
        auto function = BsplineCurve::make(3, knots, unit);
        if (!function) return fail(std::move(function.error()));
        for (int row = 0; row < 8; ++row) basis(row, column) = function->evaluate(x[row])[0].x();
    }
    Eigen::Matrix<double, 8, 2> values;
    for (int row = 0; row < 8; ++row) values.row(row) << x[row], y[row];
    const Eigen::Matrix<double, 8, 2> control = basis.partialPivLu().solve(values);
    std::vector<Vector3d> points;
    points.reserve(8);
    for (int row = 0; row < 8; ++row) points.emplace_back(control(row, 0), control(row, 1), 0);
    return BsplineCurve::make(3, std::move(knots), std::move(points));
}

/// Appends samples of one part of the way and follows the rotary axes.
class Sampler {
  public:
    Sampler(const StudiedMachine& on, double height_mm, std::vector<CornerSample>& out)
        : on_(on), height_mm_(height_mm), out_(out) {}

    void add(double length, double share, const LinkedPose& pose) {
        CornerSample sample{.length_mm = length, .share = share, .pose = pose, .axes = machine_axes(on_, pose)};
        sample.criterion_rad_mm3 = orientation_criterion(pose.tool_axis);
        sample.feed_limit_mm_s = feed_limit_mm_s(on_.machine, sample.axes, on_.programmed_mm_s);
        Vector3d point_rate;
        for (int k = 0; k < 3; ++k) point_rate[k] = pose.tip_mm[k].d1() + height_mm_ * pose.tool_axis[k].d1();
        sample.height_feed_mm_s = point_rate.norm() * sample.feed_limit_mm_s;
        const int linear = on_.machine.linear_count();
        for (int k = 0; k < on_.machine.rotary_count; ++k) on_.near[k] = sample.axes[linear + k].value();
        out_.push_back(sample);
    }

  private:
    StudiedMachine on_;
    double height_mm_;
    std::vector<CornerSample>& out_;
};

}  // namespace

double orientation_criterion(const VectorSeries& tool_axis) noexcept {
    return Vector3d(tool_axis[0].d3(), tool_axis[1].d3(), tool_axis[2].d3()).norm();
}

double orientation_criterion(const std::array<Vector3d, 4>& tool_axes, double step_mm) noexcept {
    const Vector3d difference = tool_axes[3] - 3 * tool_axes[2] + 3 * tool_axes[1] - tool_axes[0];
    return difference.norm() / (step_mm * step_mm * step_mm);
}

AxisSeries machine_axes(const StudiedMachine& on, const LinkedPose& pose) noexcept {
    const machine::RotarySeries rotary = on.kinematics.rotary_series(pose.tool_axis, on.near);
    const VectorSeries linear = on.kinematics.linear_for(pose.tip_mm, rotary);
    AxisSeries axes;
    std::copy(linear.begin(), linear.end(), axes.begin());
    for (int k = 0; k < on.kinematics.rotary_count(); ++k) axes[on.machine.linear_count() + k] = rotary[k];
    return axes;
}

double feed_limit_mm_s(const machine::Machine& machine, const AxisSeries& axes, double programmed_mm_s) noexcept {
    double limit = programmed_mm_s;
    for (int k = 0; k < machine.axis_count; ++k) limit = std::min(limit, least(machine.axes[k].feed, axes[k]));
    return limit;
}

double least_feed_limit_mm_s(const BsplineCurve& corner, const std::array<machine::AxisLimits, 3>& limits,
                             int samples) noexcept {
    double out = std::numeric_limits<double>::infinity();
    for (int i = 0; i <= 2 * samples; ++i) {
        const auto point = point_at_share(corner, 0.5 * i / samples);
        // A top point that goes along with the tip: the tool axis has no part.
        auto raised = point;
        raised[0].z() += 1;
        const LinkedPose pose = linked_pose(point, raised, {0, 1, 0, 0});
        for (int k = 0; k < 3; ++k) out = std::min(out, least(limits[k], pose.tip_mm[k]));
    }
    return out;
}

LinkedPose segment_pose(const DualCorner& corner, int end, double outside_mm) noexcept {
    const auto& bottom = corner.curves.bottom().control_points_mm();
    const auto& top = corner.curves.top().control_points_mm();
    const int outer = end == 0 ? 0 : 4, inner = end == 0 ? 1 : 3;
    const double forward = end == 0 ? 1 : -1;
    const Vector3d along = forward * (bottom[inner] - bottom[outer]).normalized();
    const Vector3d top_along = forward * corner.rate[end] * (top[inner] - top[outer]).normalized();
    const Vector3d zero = Vector3d::Zero();
    const double way = -forward * outside_mm;
    return linked_pose({bottom[outer] + way * along, along, zero, zero},
                       {top[outer] + way * top_along, top_along, zero, zero}, {0, 1, 0, 0});
}

std::vector<CornerSample> sample_corner(const DualCorner& corner, const Link& link, const StudiedMachine& on,
                                        double margin_mm, double height_mm, int per_part) {
    const BsplineCurve& bottom = corner.curves.bottom();
    const double step = margin_mm / per_part;
    std::vector<CornerSample> out;
    Sampler sampler(on, height_mm, out);
    for (int i = per_part; i >= 0; --i) sampler.add(-i * step, 0, segment_pose(corner, 0, i * step));
    double length = 0;
    for (int i = 0; i <= 2 * per_part; ++i) {
        const double share = 0.5 * i / per_part, before = 0.5 * (i - 1) / per_part;
        if (i > 0) length += length_mm(bottom, 0, before, share);
        sampler.add(length, share, linked_pose(bottom, corner.curves.top(), share, link(share)));
    }
    for (int i = 0; i <= per_part; ++i) sampler.add(length + i * step, 1, segment_pose(corner, 1, i * step));
    return out;
}

Taylor3 DiscreteLink::at(double u_bottom) const noexcept {
    const auto point = spline.evaluate(u_bottom);
    return {point[0].y(), point[1].y(), point[2].y() / 2, point[3].y() / 6};
}

Result<DiscreteLink> discrete_link(const DualCorner& corner, double step_mm) {
    const BsplineCurve& bottom = corner.curves.bottom();
    const double shorter = std::min(length_mm(bottom, 0, 0, 0.5), length_mm(bottom, 1, 0, 0.5));
    if (!(step_mm > 0) || !(3 * step_mm < shorter))
        return refuse("SMTH0121", "three steps from either end do not fit into the corner", step_mm,
                      fmt::format("the corner is {:.6g} mm long", 2 * shorter));
    auto entry = settle_points(corner, 0, step_mm);
    if (!entry) return fail(std::move(entry.error()));
    auto exit = settle_points(corner, 1, step_mm);
    if (!exit) return fail(std::move(exit.error()));
    std::array<double, 8> x{0, 0, 0, 0, 0, 0, 0, 1}, y = x;
    for (std::size_t k = 0; k < 3; ++k) {
        x[1 + k] = entry->bottom[k];
        y[1 + k] = entry->top[k];
        x[6 - k] = 1 - exit->bottom[k];
        y[6 - k] = 1 - exit->top[k];
    }
    auto spline = interpolating(x, y);
    if (!spline) return fail(std::move(spline.error()));
    return DiscreteLink{x, y, std::move(*spline)};
}

std::vector<CornerStep> walk_corner(const DualCorner& corner, const Link& link, const StudiedMachine& on,
                                    double margin_mm, double step_mm) {
    const Way way(corner, link);
    StudiedMachine followed = on;
    Steps steps;
    for (std::size_t k = 0; k < 3; ++k)
        steps[k + 1] = place_on(followed, way.at(-margin_mm - static_cast<double>(3 - k) * step_mm));
    std::vector<CornerStep> out;
    const double end = way.length() + margin_mm;
    for (int i = 0; i * step_mm - margin_mm <= end; ++i) {
        const double s = i * step_mm - margin_mm;
        steps = {steps[1], steps[2], steps[3], place_on(followed, way.at(s))};
        out.push_back({s, criterion_of(steps, step_mm), feed_limit_of(steps, step_mm, on)});
    }
    return out;
}

std::vector<SensitivitySample> first_point_sensitivity(const DualCorner& corner, double step_mm,
                                                       std::span<const double> tops, const StudiedMachine& on) {
    StudiedMachine followed = on;
    Steps steps;
    for (std::size_t k = 0; k < 3; ++k)
        steps[k] = place_on(followed, segment_pose(corner, 0, static_cast<double>(2 - k) * step_mm));
    const Vector3d tip = point_at_share(corner.curves.bottom(), share_at(corner.curves.bottom(), 0, step_mm))[0];
    std::vector<SensitivitySample> out;
    for (const double top : tops) {
        steps[3] = place_on(followed, tip, (point_at_share(corner.curves.top(), top)[0] - tip).normalized());
        out.push_back({top, criterion_of(steps, step_mm), feed_limit_of(steps, step_mm, on)});
    }
    return out;
}

}  // namespace trunnion::smoothing
