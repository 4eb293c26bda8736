#include "trunnion/geometry/dual_spline.hpp"

namespace trunnion::geometry {

Result<DualSpline> DualSpline::make(BsplineCurve bottom, BsplineCurve top) {
    if (bottom.degree() == top.degree() && bottom.knots() == top.knots())
        return DualSpline(std::move(bottom), std::move(top));
    Diagnostic refusal{.code = "GEOM0106", .text = "the two curves of a dual spline differ in degree or knots"};
    return fail(std::move(refusal));
}

std::array<Taylor3, 3> DualSpline::axis(double u) const noexcept {
    const CurvePoint from = bottom_.evaluate(u), to = top_.evaluate(u);
    std::array<Taylor3, 3> d;
    for (int i = 0; i < 3; ++i)
        d[i] = {to[0][i] - from[0][i], to[1][i] - from[1][i], (to[2][i] - from[2][i]) / 2, (to[3][i] - from[3][i]) / 6};
    const Taylor3 inverse = 1.0 / sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    return {inverse * d[0], inverse * d[1], inverse * d[2]};
}

}  // namespace trunnion::geometry
