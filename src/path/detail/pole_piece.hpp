#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>

#include "trunnion/machine/kinematics.hpp"
#include "trunnion/path/tool_path.hpp"

namespace trunnion::path::detail {

/// A piece of law vector that begins or ends at a pole with the tool turning there. Beside the pole the direction of
/// the part across it is a quotient of two small numbers, at the pole it is 0/0. That part has the factor v, the
/// distance from the pole in shares of the piece: divided out once, what is left, m(v), tells the direction everywhere.
///
/// n(v) ∝ v·m(v) + height(v)·pole. Turned about the pole by −φ, φ the angle of m from m(0), it lies in one plane with
/// the pole; there the rotary positions are a function of the signed q = v·|m|/height alone, smooth through 0.
class PolePiece {
  public:
    /// Nothing where the piece does not begin or end at a pole, or does not leave it at once.
    static std::optional<PolePiece> make(std::size_t index, const PathPiece& piece,
                                         const machine::Kinematics& kinematics, std::span<const Eigen::Vector3d> poles);

    std::size_t index() const { return index_; }

    /// The rotary axes with three derivatives by p, on the branch and winding nearest to `near`. No allocation.
    machine::RotarySeries rotary(const machine::Kinematics& kinematics, double offset_mm,
                                 const machine::RotaryPosition& near) const noexcept;

    /// A bound on the turn of m about the pole between any two places of a part of the piece, rad: the angle that the
    /// Bernstein hull of m takes up as seen from the pole; π where that is not less than a right angle on either side.
    double turn_bound_rad(double from_mm, double to_mm) const noexcept;

  private:
    std::size_t index_ = 0;
    double length_mm_ = 0, from_mm_ = 0;  // from_mm_: where the pole is
    Eigen::Vector3d pole_, ahead_;        // ahead_: direction of m(0)
    std::array<double, 7> along_{}, across_{};
    std::array<double, 8> height_{};
    double sense_ = 1;  // rad of the axis nearest to the workpiece per rad about the pole
};

}  // namespace trunnion::path::detail
