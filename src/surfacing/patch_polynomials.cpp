#include "detail/patch_polynomials.hpp"

#include <algorithm>
#include <cmath>

namespace trunnion::surfacing::detail {

using Eigen::Vector3d;

namespace {

ScalarBernstein weights_of(const BezierPatch& patch) {
    const double first = patch.control.front()[3];
    const bool even = std::ranges::all_of(
        patch.control, [first](const Eigen::Vector4d& c) { return std::abs(c[3] - first) <= 1e-15 * first; });
    if (even) return bernstein<double>(0, 0, 0.0, [first](int, int) { return first; });
    return bernstein<double>(patch.degree_u, patch.degree_v, 0.0, [&](int i, int j) { return patch.at(i, j)[3]; });
}

ScalarBernstein ones(int n, int m) {
    return bernstein<double>(n, m, 0.0, [](int, int) { return 1.0; });
}

}  // namespace

VectorBernstein points_of(const BezierPatch& patch) {
    return bernstein<Vector3d>(patch.degree_u, patch.degree_v, Vector3d(0, 0, 0),
                               [&](int i, int j) -> Vector3d { return patch.at(i, j).head<3>(); });
}

VectorBernstein raised(int n, int m, const VectorBernstein& a) {
    return times(ones(n, m), a);
}
ScalarBernstein raised(int n, int m, const ScalarBernstein& a) {
    return times(ones(n, m), a);
}

PatchPolynomials::PatchPolynomials(const BezierPatch& patch)
    : w(weights_of(patch)), a(points_of(patch)), along_u(by_u(a)), along_v(by_v(a)) {
    if (w.degree_u == 0 && w.degree_v == 0) return;
    along_u = minus(times(w, along_u), times(by_u(w), a));
    along_v = minus(times(w, along_v), times(by_v(w), a));
}

}  // namespace trunnion::surfacing::detail
