#include "trunnion/smoothing/connection.hpp"

#include <cmath>
#include <string>
#include <utility>

#include <fmt/format.h>

namespace trunnion::smoothing {

namespace {

using geometry::CurvePoint;
using machine::VectorSeries;

constexpr double most_orientation_jump_rad = 1e-6;
constexpr double least_top_speed = 1e-9;  // mm of the top across the tool, per mm of the bottom

std::unexpected<Diagnostic> refuse(const char* code, std::string text, std::string value, std::string hint) {
    Diagnostic refusal{.code = code, .text = std::move(text), .value = std::move(value), .hint = std::move(hint)};
    return fail(std::move(refusal));
}

Eigen::Vector3d coefficient(const VectorSeries& series, std::size_t order) {
    return {series[0].c[order], series[1].c[order], series[2].c[order]};
}

VectorSeries series_of(const CurvePoint& point) {
    VectorSeries out;
    for (int i = 0; i < 3; ++i) out[i] = {point[0][i], point[1][i], point[2][i] / 2, point[3][i] / 6};
    return out;
}

/// The series with its variable replaced by one that is 0 at the point of expansion.
VectorSeries substituted(const VectorSeries& series, const Taylor3& variable) {
    VectorSeries out;
    for (int i = 0; i < 3; ++i)
        out[i] = compose(variable, series[i].c[0], series[i].c[1], series[i].c[2], series[i].c[3]);
    return out;
}

/// u − u₀ as a series in the path length of the curve.
Taylor3 parameter_by_length(const CurvePoint& point) {
    const double s1 = point[1].norm();
    const double s2 = point[1].dot(point[2]) / s1;
    const double s3 = (point[2].squaredNorm() + point[1].dot(point[3]) - s2 * s2) / s1;
    const double g1 = 1 / s1, g2 = -s2 * g1 * g1 * g1;
    return {0, g1, g2 / 2, (3 * s2 * s2 * g1 - s3) * g1 * g1 * g1 * g1 / 6};
}

/// The part across the tool.
Eigen::Vector3d across(const Eigen::Vector3d& v, const Eigen::Vector3d& tool) {
    return v - v.dot(tool) * tool;
}

/// Settles one derivative of the link; all lower ones are, and the axis is affine in it, so that one step is enough.
void newton_step(int order, const VectorSeries& path, const CurvePoint& bottom, const CurvePoint& top,
                 const Eigen::Vector3d& top_across, LinkEnd& end) {
    const VectorSeries axis = linked_pose(bottom, top, {0, end.first, end.second / 2, end.third / 6}).tool_axis;
    const double factorial = order == 3 ? 6 : order;
    const Eigen::Vector3d miss = factorial * (coefficient(path, order) - coefficient(axis, order));
    const Eigen::Vector3d by_unknown = top_across / std::pow(bottom[1].norm(), order) / (top[0] - bottom[0]).norm();
    double& unknown = order == 1 ? end.first : order == 2 ? end.second : end.third;
    unknown += miss.dot(by_unknown) / by_unknown.squaredNorm();
}

std::array<double, 4> jumps(const VectorSeries& path, const VectorSeries& pair) {
    constexpr std::array<double, 4> factorial{1, 1, 2, 6};
    std::array<double, 4> out;
    for (std::size_t k = 0; k < 4; ++k) out[k] = factorial[k] * (coefficient(pair, k) - coefficient(path, k)).norm();
    return out;
}

/// Whether the top curve leaves in the direction that the path asks for.
Result<void> check_direction(const VectorSeries& path, const CurvePoint& bottom, const CurvePoint& top,
                             const Eigen::Vector3d& top_across, double tolerance_rad) {
    const Eigen::Vector3d tool = (top[0] - bottom[0]).normalized();
    // Across the tool, per mm of the bottom, the top point has to move like this.
    const Eigen::Vector3d wanted =
        (top[0] - bottom[0]).norm() * across(coefficient(path, 1), tool) + across(bottom[1].normalized(), tool);
    const double forward = wanted.dot(top_across.normalized());
    const double aside = (wanted - forward * top_across.normalized()).norm();
    if (std::atan2(aside, std::abs(forward)) > tolerance_rad && aside > least_top_speed)
        return refuse("SMTH0113", "the top curve is not tangent to the path that it continues",
                      fmt::format("{:.3g} deg", std::atan2(aside, std::abs(forward)) * 57.29577951308232),
                      "the second control point has to lie in the line of the path's own top point");
    if (forward < least_top_speed)
        return refuse("SMTH0114", "the top curve would have to be run backwards where it joins the path",
                      fmt::format("{:.3g} mm/mm", forward), "let the top curve start the other way");
    return {};
}

Diagnostic no_increasing_link() {
    return {.code = "SMTH0115",
            .text = "no increasing link of the curves' parameters meets both ends",
            .hint = "lengthen the top curve's outer legs against its inner ones, or give it less tolerance"};
}

}  // namespace

CurvePoint point_at_share(const geometry::BsplineCurve& curve, double share) noexcept {
    const double range = curve.end() - curve.begin();
    // At the very ends the domain's own bounds, lest rounding step over them.
    CurvePoint point = curve.evaluate(share == 1 ? curve.end() : curve.begin() + share * range);
    double scale = 1;
    for (std::size_t k = 1; k < point.size(); ++k) point[k] *= (scale *= range);
    return point;
}

LinkedPose linked_pose(const CurvePoint& bottom, const CurvePoint& top, const Taylor3& link) noexcept {
    const Taylor3 by_length = parameter_by_length(bottom);
    const Taylor3 top_by_length = compose(by_length, 0, link.c[1], link.c[2], link.c[3]);
    LinkedPose pose{substituted(series_of(bottom), by_length), substituted(series_of(top), top_by_length)};
    VectorSeries& d = pose.tool_axis;
    for (int i = 0; i < 3; ++i) d[i] -= pose.tip_mm[i];
    const Taylor3 inverse = 1.0 / sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    for (Taylor3& x : d) x = inverse * x;
    return pose;
}

LinkedPose linked_pose(const geometry::BsplineCurve& bottom, const geometry::BsplineCurve& top, double share,
                       const Taylor3& link) noexcept {
    return linked_pose(point_at_share(bottom, share), point_at_share(top, link.value()), link);
}

VectorSeries backwards(const VectorSeries& series) noexcept {
    VectorSeries out = series;
    for (Taylor3& x : out) {
        x.c[1] = -x.c[1];
        x.c[3] = -x.c[3];
    }
    return out;
}

CurvePoint backwards(const CurvePoint& point) noexcept {
    return {point[0], -point[1], point[2], -point[3]};
}

VectorSeries tool_axis_by_length(const geometry::DualSpline& path, double u) noexcept {
    return linked_pose(path.bottom().evaluate(u), path.top().evaluate(u), {0, 1, 0, 0}).tool_axis;
}

Result<Connection> connect_end(const VectorSeries& path, const CurvePoint& bottom, const CurvePoint& top,
                               double tangent_tolerance_rad) {
    const double height = (top[0] - bottom[0]).norm();
    const Eigen::Vector3d tool = (top[0] - bottom[0]).stableNormalized();
    const Eigen::Vector3d top_across = across(top[1], tool);
    if (!(height > 0) || !(bottom[1].norm() > 0) || !(top_across.norm() > least_top_speed * top[1].norm()))
        return refuse("SMTH0111", "at this join the curves say nothing of how the tool turns",
                      fmt::format("{:.6g} mm apart", height), "the curves must be apart and move across the tool");
    const double jump = (tool - coefficient(path, 0)).norm();
    if (!(jump <= most_orientation_jump_rad))
        return refuse("SMTH0112", "the orientation jumps at this join", fmt::format("{:.3g} rad", jump),
                      "the curves have to start where the path ends");
    if (auto usable = check_direction(path, bottom, top, top_across, tangent_tolerance_rad); !usable)
        return fail(std::move(usable.error()));

    Connection out{.end = {0, 0, 0}};
    for (int order = 1; order <= 3; ++order) newton_step(order, path, bottom, top, top_across, out.end);
    const Taylor3 link{0, out.end.first, out.end.second / 2, out.end.third / 6};
    out.jump = jumps(path, linked_pose(bottom, top, link).tool_axis);
    return out;
}

Result<ParameterLink> connect(const geometry::DualSpline& before, const geometry::BsplineCurve& bottom,
                              const geometry::BsplineCurve& top, const geometry::DualSpline& after,
                              double tangent_tolerance_rad) {
    auto entry = connect_end(tool_axis_by_length(before, before.end()), point_at_share(bottom, 0),
                             point_at_share(top, 0), tangent_tolerance_rad);
    if (!entry) return fail(std::move(entry.error()));
    auto exit = connect_end(backwards(tool_axis_by_length(after, after.begin())), backwards(point_at_share(bottom, 1)),
                            backwards(point_at_share(top, 1)), tangent_tolerance_rad);
    if (!exit) return fail(std::move(exit.error()));
    if (const auto link = ParameterLink::through(entry->end, exit->end)) return *link;
    return fail(no_increasing_link());
}

}  // namespace trunnion::smoothing
