#pragma once

#include "detail/bernstein.hpp"
#include "detail/bezier_patch.hpp"

namespace trunnion::surfacing::detail {

/// What a patch's rational polynomials are made of: w S = a. Of a patch whose weights are all one, w is constant.
struct PatchPolynomials {
    ScalarBernstein w;
    VectorBernstein a;
    VectorBernstein along_u, along_v;  ///< w² S_u and w² S_v; with constant w: w S_u and w S_v

    explicit PatchPolynomials(const BezierPatch& patch);
};

VectorBernstein points_of(const BezierPatch& patch);

/// The same polynomial with degrees that are higher by n and m.
VectorBernstein raised(int n, int m, const VectorBernstein& a);
ScalarBernstein raised(int n, int m, const ScalarBernstein& a);

}  // namespace trunnion::surfacing::detail
