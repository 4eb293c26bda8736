#pragma once

#include <cmath>
#include <functional>
#include <vector>

#include "trunnion/machine/kinematics.hpp"
#include "trunnion/path/tool_path.hpp"

/// Curves on surfaces that are known exactly, and the same curves as programs give them: poses with finite digits.
namespace trunnion::test {

/// A place on the curve, with derivatives by the curve's own parameter u.
struct Place {
    machine::VectorSeries tip;   // mm
    machine::VectorSeries axis;  // unit
};

struct Curve {
    double from = 0, to = 0;  // of u
    std::function<Place(double u)> at;
};

/// Spiral of 1 mm pitch from a radius of 5 mm on z = 3 sin(2πx/60) sin(2πy/60), the tool leaning 30° from its normal
/// towards Y.
Curve spiral(double turns);

/// Row along X at a `y` of the surface z = 3 sin(x/12) cos(y/15), 80 mm, the tool leaning from its normal towards Y.
Curve sine_row(double y_mm, double lean_rad = 0);

Curve backwards(const Curve& curve);

enum class Digits {
    all,
    some  ///< 1e-3 mm, and 1e-3° for rotary words or five decimals for vectors
};

/// How a program gives a curve.
struct Posed {
    double step_mm = 0.1;
    Digits digits = Digits::all;
    bool uneven = false;   ///< steps times 0.3 … 1.7
    bool doubled = false;  ///< every seventh pose twice
    std::uint64_t seed = 1;
};

inline constexpr double feed_mm_s = 10000.0 / 60;

/// The blocks of a program that follows the curve, by vectors or by the words of the machine's rotary axes.
path::Run posed(const Curve& curve, const Posed& how, path::OrientationLaw law, const machine::Kinematics& kinematics);

/// The curve itself, as C³ septic pieces of some 0.4 mm that interpolate value and three derivatives.
path::ToolPath exact_path(const Curve& curve, path::OrientationLaw law, const machine::Kinematics& kinematics);

}  // namespace trunnion::test
