#pragma once

#include "trunnion/smoothing/smoothing.hpp"

namespace trunnion::smoothing {

/// How far from the pole vectors may pass so that they may be led through it (choose_rotary_stands), rad: 0.8 of the
/// orientation tolerance, or of the angle that the flank tolerance allows at the flank height; the rest is left for
/// rounding. 0 where smoothing gives
/// nothing away, and for roundings other than Rounding::smooth.
double pole_tolerance_rad(const SmoothingOptions& options);

}  // namespace trunnion::smoothing
