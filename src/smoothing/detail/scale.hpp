#pragma once

#include "detail/widths.hpp"

namespace trunnion::smoothing {

/// The width at which the deviation's total variation along the scale, Σ M(δ(w_l) − δ(w_l−1)), reaches `aim`. It rises
/// with the width, so the crossing is a continuous function of the data.
void find_raw_widths(Curve& curve, double aim);    ///< every kink, detection kernel → raw_width
void find_curve_widths(Curve& curve, double aim);  ///< the curve's share, its kernel → bumps.curve_width

}  // namespace trunnion::smoothing
