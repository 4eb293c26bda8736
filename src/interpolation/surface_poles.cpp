#include "detail/surface_poles.hpp"

#include <algorithm>
#include <cstddef>

#include "trunnion/geometry/great_circle.hpp"
#include "trunnion/path/pole_passage.hpp"

namespace trunnion::interpolation::detail {

namespace {

constexpr int looks = 8;                 // between neighbouring breaks
constexpr double least_from_end = 1e-6;  // of the curve: nearer it ends at the pole

struct Beside {
    Eigen::Vector3d axis, slope;
};

Beside beside(const SurfaceCurve& curve, double w) {
    const machine::VectorSeries axis = curve.by_parameter(w).axis;
    return {{axis[0].value(), axis[1].value(), axis[2].value()}, {axis[0].d1(), axis[1].d1(), axis[2].d1()}};
}

/// Half the slope of the squared distance from the pole: negative on the way towards it.
double leaving(const SurfaceCurve& curve, double w, const Eigen::Vector3d& pole) {
    const Beside at = beside(curve, w);
    return path::beside_pole(at.axis, pole).dot(path::beside_pole(at.slope, pole));
}

/// The nearest place to the pole between two, the first of them on the way towards it, the second on the way from it.
double nearest(const SurfaceCurve& curve, double low, double high, const Eigen::Vector3d& pole) {
    for (int halving = 0; halving < 60; ++halving) {
        const double middle = 0.5 * (low + high);
        (leaving(curve, middle, pole) < 0 ? low : high) = middle;
    }
    return 0.5 * (low + high);
}

double angle_rad(const SurfaceCurve& curve, double w, const Eigen::Vector3d& pole) {
    return geometry::angle_between(curve.pose(curve.contact(w)).axis_in_workpiece, pole);
}

}  // namespace

std::vector<PoleOnCurve> poles_on(const SurfaceCurve& curve, const machine::Kinematics& kinematics,
                                  const std::vector<double>& breaks, double within_rad) {
    std::vector<PoleOnCurve> out;
    for (const Eigen::Vector3d& pole : path::poles_of(kinematics)) {
        double low = breaks.front(), at_low = leaving(curve, low, pole);
        for (std::size_t i = 0; i + 1 < breaks.size(); ++i)
            for (int k = 1; k <= looks; ++k) {
                const double high = breaks[i] + (breaks[i + 1] - breaks[i]) * k / looks;
                const double at_high = leaving(curve, high, pole);
                if (at_low < 0 && at_high >= 0) {
                    const double w = nearest(curve, low, high, pole);
                    if (angle_rad(curve, w, pole) <= within_rad) out.push_back({w, pole});
                }
                low = high, at_low = at_high;
            }
    }
    const double margin = least_from_end * (breaks.back() - breaks.front());
    std::erase_if(
        out, [&](const PoleOnCurve& at) { return at.w < breaks.front() + margin || at.w > breaks.back() - margin; });
    std::ranges::sort(out, {}, &PoleOnCurve::w);
    return out;
}

}  // namespace trunnion::interpolation::detail
