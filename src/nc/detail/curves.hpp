#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "trunnion/program/program.hpp"

namespace trunnion::nc {

/// What a curve says at one parameter.
struct CurvePose {
    Eigen::Vector3d position_mm;
    Eigen::Vector3d axis;  ///< not unit; zero where the curve has no axes
    std::array<double, program::max_rotary_letters> rotary_rad;
};

/// The pose at u, knots[p] ≤ u ≤ knots[n]; at a knot where the curve is not smooth, seen from before it. By de Boor's
/// scheme on homogeneous coordinates. Cost: O(p² + log n); allocates nothing.
CurvePose pose_at(const program::Curve& curve, double u);

/// The part of a curve from one parameter to another, from_u < to_u, as a curve of its own: of the same degree, both
/// ends knots of full multiplicity, its knots from 0, its first weight 1.
program::Curve part_of_curve(const program::Curve& curve, double from_u, double to_u);

/// Knots of a curve that starts and ends in its first and last control point: from 0, with these distances between.
std::vector<double> clamped_knots(int degree, std::span<const double> distances);

/// The spans of a B-spline whose control points say distances of knots.
struct Spans {
    std::vector<double> distances;
    std::vector<std::size_t> points;              ///< of each, the control point that says it
    std::size_t first_point = 0, last_point = 0;  ///< of those that count
};

/// lengths[i] is what control point i says of the distance between two knots, from i = 1. n + 1 control points of
/// degree p have n − p + 1 spans: of the n lengths, p − 1 are 0, behind the start, in front of the end, or some at each
/// end; the others are the spans in order, where a 0 repeats a knot, at most p times in all. One more 0 at an end is
/// good where repeats[i], control point i is the one before again: there is one point less then. Empty: no B-spline.
std::optional<Spans> spans_of(std::span<const double> lengths, const std::vector<bool>& repeats, int degree);

/// The Bézier ordinates over [0, 1] of Σ coefficients[k] tᵏ, as many as there are coefficients.
std::vector<double> bernstein_ordinates(std::span<const double> coefficients);

/// The other way round: the coefficients of the powers of t from the Bézier ordinates.
std::vector<double> power_coefficients(std::span<const double> ordinates);

/// Whether the tool axis of the curve can vanish nowhere: within every span the control vectors lie on one side of a
/// plane. Curves without axes are good.
bool has_direction_everywhere(const program::Curve& curve);

/// The curve that moves[move] follows; null: none, or there is no such move.
const program::Curve* curve_followed(const program::Program& program, std::size_t move);

/// How many moves from moves[first] on follow one curve without a break: at feed, in one frame, with no event and no
/// exact stop between them.
std::size_t moves_along_curve(const program::Program& program, std::size_t first);

/// Makes a move follow a part of a curve that the program has already.
void follow_curve(program::Program& program, program::Move& move, const program::CurvePart& part);

}  // namespace trunnion::nc
