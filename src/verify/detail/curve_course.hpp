#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "trunnion/program/program.hpp"

namespace trunnion::verify {

/// The part of a program's curve that one move follows, at shares w ∈ [0, 1] of its parameter, in the frame that the
/// move is written in: by the definition of the basis functions.
class CurveCourse {
  public:
    /// Whether the numbers of a curve make one: sizes that fit, all finite, knots in order, weights positive.
    static bool is_curve(const program::Curve& curve, std::size_t rotary_letters);

    /// The curve that a move follows; null: the program has no such part or curve.
    static const program::Curve* curve_of(const program::Program& program, const program::Move& move);

    /// Empty: the part is empty, outside of its curve or goes over a knot. Keeps a reference to the curve.
    /// Precondition: curve_of(program, move) is there, and is_curve.
    static std::optional<CurveCourse> make(const program::Program& program, const program::Move& move);

    bool says_axis() const { return !curve_->axis.empty(); }
    bool says_rotary() const { return !curve_->rotary_rad.empty(); }

    Eigen::Vector3d position(double w) const;
    /// Not unit; 0 where it vanishes.
    Eigen::Vector3d axis(double w) const;
    std::array<double, program::max_rotary_letters> rotary_rad(double w) const;

  private:
    static constexpr int highest_degree = 7;
    using Shares = std::array<double, highest_degree + 1>;
    /// N_i(u) w_i / Σ N_j(u) w_j of the degree + 1 control points from `first_` on.
    Shares shares(double w) const;
    Eigen::Vector3d sum(const std::vector<Eigen::Vector3d>& points, double w) const;

    const program::Curve* curve_ = nullptr;
    double from_u_ = 0, to_u_ = 1;
    std::size_t span_ = 0, first_ = 0;  // knots[span] ≤ from_u, to_u ≤ knots[span + 1]
};

}  // namespace trunnion::verify
