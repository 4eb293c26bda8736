#include "trunnion/path/tool_path.hpp"

namespace trunnion::path {

namespace {

/// Taylor coefficients at u of a polynomial in u: four Horner schemes in one pass.
Taylor3 expand(const std::array<double, 8>& c, double u) {
    double f0 = c[7], f1 = 0, f2 = 0, f3 = 0;
    for (int i = 6; i >= 0; --i) {
        f3 = f3 * u + f2;
        f2 = f2 * u + f1;
        f1 = f1 * u + f0;
        f0 = f0 * u + c[i];
    }
    return {f0, f1, f2, f3};
}

}  // namespace

std::array<Taylor3, 6> evaluate(const PathPiece& piece, double offset_mm) noexcept {
    const double per_mm = 1 / piece.length_mm;
    const double u = offset_mm * per_mm;
    std::array<Taylor3, 6> out;
    for (int k = 0; k < 6; ++k) {
        out[k] = expand(piece.coefficient[k], u);
        out[k].c[1] *= per_mm;
        out[k].c[2] *= per_mm * per_mm;
        out[k].c[3] *= per_mm * per_mm * per_mm;
    }
    return out;
}

}  // namespace trunnion::path
