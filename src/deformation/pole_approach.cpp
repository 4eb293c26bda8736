#include "detail/pole_approach.hpp"

#include <algorithm>
#include <cmath>

#include "trunnion/geometry/great_circle.hpp"

#include "detail/spline_equations.hpp"

namespace trunnion::deformation::detail {

using Eigen::Vector3d;

namespace {

constexpr int looks = 8;  // a knot interval
constexpr int most_halvings = 80;

/// Half the derivative of the squared distance from the pole in the plane across it, D_across/D_along.
double outwards(const DualPath& path, double u, const Vector3d& pole) {
    const auto bottom = path.spline.bottom().evaluate(u), top = path.spline.top().evaluate(u);
    const Vector3d d = top[0] - bottom[0], slope = top[1] - bottom[1];
    const double height = d.dot(pole);
    if (height <= 0) return -1;
    const Vector3d beside = d / height - pole;
    return beside.dot(slope / height - d * (slope.dot(pole) / (height * height)));
}

double least_between(const DualPath& path, const Vector3d& pole, double from, double to) {
    for (int i = 0; i < most_halvings; ++i) {
        const double middle = 0.5 * (from + to);
        if (middle <= from || middle >= to) break;
        (outwards(path, middle, pole) < 0 ? from : to) = middle;
    }
    return 0.5 * (from + to);
}

}  // namespace

std::vector<PoleApproach> pole_approaches(const DualPath& path, std::span<const Vector3d> poles) {
    const std::vector<double> at = stations_of(path.spline.bottom().knots());
    std::vector<PoleApproach> out;
    const auto add = [&](const Vector3d& pole, double u, bool at_end) {
        const Vector3d axis = path.at(u).axis_in_workpiece;
        if (axis.dot(pole) > 0) out.push_back({u, pole, geometry::angle_between(axis, pole), at_end});
    };
    for (const Vector3d& pole : poles) {
        double before_u = at.front(), before = outwards(path, before_u, pole);
        if (before >= 0) add(pole, before_u, true);
        for (std::size_t k = 0; k + 1 < at.size(); ++k)
            for (int i = 1; i <= looks; ++i) {
                const double u = i == looks ? at[k + 1] : at[k] + (at[k + 1] - at[k]) * i / looks;
                const double here = outwards(path, u, pole);
                if (before < 0 && here >= 0) add(pole, least_between(path, pole, before_u, u), false);
                before_u = u;
                before = here;
            }
        if (before < 0) add(pole, before_u, true);
    }
    std::ranges::sort(out, {}, &PoleApproach::u);
    return out;
}

}  // namespace trunnion::deformation::detail
