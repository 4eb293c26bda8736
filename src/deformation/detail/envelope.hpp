#pragma once

#include <cmath>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "trunnion/deformation/flank_tool.hpp"

namespace trunnion::deformation {

template <class Scalar>
using Vector = Eigen::Matrix<Scalar, 3, 1>;

/// Where the tool is at one u of a dual path, and how it moves there (derivatives by u).
template <class Scalar>
struct ToolMotion {
    Vector<Scalar> tip, tip_rate, axis, axis_rate;
};

/// From f, f′ and D = g − f, D′: axis a = D/|D|, a′ = (D′ − (D′·a) a)/|D|.
template <class Scalar>
ToolMotion<Scalar> tool_motion(const Vector<Scalar>& tip, const Vector<Scalar>& tip_rate, const Vector<Scalar>& between,
                               const Vector<Scalar>& between_rate) {
    using std::sqrt;
    const Scalar inverse = Scalar(1) / sqrt(between.dot(between));
    const Vector<Scalar> axis = between * inverse;
    return {tip, tip_rate, axis, (between_rate - axis * axis.dot(between_rate)) * inverse};
}

/// A point of the tool's side that touches the envelope.
template <class Scalar>
struct CharacteristicPoint {
    Vector<Scalar> point, radial;  ///< radial: unit, from the axis to the point
    bool exists = false;
};

/// At a height z, where the tool's side moves along itself. The normal of the side is n = e − r′ a for the radial
/// direction e ⟂ a, the velocity of the point there V = f′ + z a′ − r (a′·e) a but for the spindle's turning, which
/// lies in the side. n·V = 0 becomes
///     e·w = r′ (a·f′),   w = f′ + (z + r r′) a′,
/// two directions e = k ŵ ± √(1 − k²) a × ŵ with ŵ the unit direction of w across a and k = r′ (a·f′)/|w across a|. The
/// one on the side of `towards` is taken. None where the tool does not move across its axis there, or |k| ≥ 1: the
/// section lies within the others' sweep.
template <class Scalar>
CharacteristicPoint<Scalar> characteristic_point(const ToolMotion<Scalar>& motion, double height,
                                                 const FlankTool::Outline& outline, const Eigen::Vector3d& towards) {
    using std::sqrt;
    constexpr double least_square = 1e-24;
    const auto& a = motion.axis;
    Vector<Scalar> w = motion.tip_rate + motion.axis_rate * Scalar(height + outline.radius_mm * outline.slope);
    w -= a * a.dot(w);
    const Scalar square = w.dot(w);
    if (!(square > least_square)) return {};
    const Scalar inverse = Scalar(1) / sqrt(square);
    const Vector<Scalar> ahead = w * inverse, across = a.cross(ahead);
    const Scalar k = a.dot(motion.tip_rate) * inverse * Scalar(outline.slope);
    const Scalar rest = Scalar(1) - k * k;
    if (!(rest > 0.0)) return {};
    const Scalar sideways = across.dot(towards.cast<Scalar>());
    const Scalar root = sideways > 0.0 ? sqrt(rest) : -sqrt(rest);
    CharacteristicPoint<Scalar> out;
    out.radial = ahead * k + across * root;
    out.point = motion.tip + a * Scalar(height) + out.radial * Scalar(outline.radius_mm);
    out.exists = true;
    return out;
}

}  // namespace trunnion::deformation
