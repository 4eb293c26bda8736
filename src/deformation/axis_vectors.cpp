#include "detail/axis_vectors.hpp"

#include <algorithm>
#include <utility>

namespace trunnion::deformation::detail {

using Eigen::Vector3d;
using geometry::BsplineCurve;
using geometry::DualSpline;

namespace {

constexpr std::size_t degree = 3;

DualPath made_of(std::vector<double> knots, std::vector<Vector3d> bottom, std::vector<Vector3d> top,
                 double distance_mm) {
    auto f = BsplineCurve::make(static_cast<int>(degree), knots, std::move(bottom));
    auto g = BsplineCurve::make(static_cast<int>(degree), std::move(knots), std::move(top));
    return {std::move(DualSpline::make(std::move(*f), std::move(*g)).value()), distance_mm};
}

void insert(const std::vector<double>& knots, std::vector<Vector3d>& points, std::size_t span, double u) {
    std::vector<Vector3d> out(points.begin(), points.begin() + static_cast<std::ptrdiff_t>(span - degree + 1));
    for (std::size_t i = span - degree + 1; i <= span; ++i) {
        const double share = (u - knots[i]) / (knots[i + degree] - knots[i]);
        out.push_back((1 - share) * points[i - 1] + share * points[i]);
    }
    out.insert(out.end(), points.begin() + static_cast<std::ptrdiff_t>(span), points.end());
    points = std::move(out);
}

}  // namespace

std::vector<Vector3d> axis_vectors(const DualPath& path) {
    std::vector<Vector3d> out = path.spline.top().control_points_mm();
    const auto& bottom = path.spline.bottom().control_points_mm();
    for (std::size_t i = 0; i < out.size(); ++i) out[i] -= bottom[i];
    return out;
}

DualPath with_axis_vectors(const DualPath& path, std::span<const Vector3d> vectors, double controlled_height_mm) {
    std::vector<Vector3d> bottom = path.spline.bottom().control_points_mm(),
                          top = path.spline.top().control_points_mm();
    for (std::size_t i = 0; i < top.size(); ++i) {
        const Vector3d old = top[i] - bottom[i];
        if (vectors[i] == old) continue;
        bottom[i] -= controlled_height_mm / path.distance_mm * (vectors[i] - old);
        top[i] = bottom[i] + vectors[i];
    }
    return made_of(path.spline.bottom().knots(), std::move(bottom), std::move(top), path.distance_mm);
}

std::vector<double> control_places(const DualPath& path) {
    const auto& knots = path.spline.bottom().knots();
    std::vector<double> out(path.spline.bottom().control_points_mm().size());
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = (knots[i + 1] + knots[i + 2] + knots[i + 3]) / 3;
    return out;
}

DualPath with_knots(const DualPath& path, std::span<const double> at) {
    std::vector<double> knots = path.spline.bottom().knots();
    std::vector<Vector3d> bottom = path.spline.bottom().control_points_mm(),
                          top = path.spline.top().control_points_mm();
    for (const double u : at) {
        const auto after = std::ranges::upper_bound(knots, u);
        const auto span = static_cast<std::size_t>(after - knots.begin()) - 1;
        insert(knots, bottom, span, u);
        insert(knots, top, span, u);
        knots.insert(after, u);
    }
    return made_of(std::move(knots), std::move(bottom), std::move(top), path.distance_mm);
}

std::vector<Pose> poses_about(std::span<const Pose> before, std::span<const double> u, const DualPath& path,
                              double controlled_height_mm) {
    std::vector<Pose> out(before.begin(), before.end());
    for (std::size_t i = 0; i < out.size(); ++i) {
        const Vector3d axis = path.at(u[i]).axis_in_workpiece;
        out[i].tip_in_workpiece_mm += controlled_height_mm * (out[i].axis_in_workpiece - axis);
        out[i].axis_in_workpiece = axis;
    }
    return out;
}

}  // namespace trunnion::deformation::detail
