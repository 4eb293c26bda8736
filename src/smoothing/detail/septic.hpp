#pragma once

#include <array>

#include "trunnion/path/tool_path.hpp"

#include "detail/coordinates.hpp"

namespace trunnion::smoothing {

/// Value and derivatives by p at one end of a septic Hermite piece. At the start `value` is absolute; at the end it is
/// counted from the start, so that short pieces far from the origin lose no digits.
struct HermiteEnd {
    Coordinates value, first, second, third;
};

/// The polynomial of degree 7 that has these values and derivatives at its ends.
path::PathPiece hermite_piece(double begin_mm, double length_mm, const HermiteEnd& start, const HermiteEnd& end);

/// Value at u ∈ [0, 1], counted from the start.
Coordinates progress(const path::PathPiece& piece, double u);

/// A polynomial of degree 7 by its Bernstein coefficients on an interval: it stays within their convex hull, and the
/// first and last are its values at the ends.
using Bernstein = std::array<Coordinates, 8>;

Bernstein bernstein(const path::PathPiece& piece);

/// Splits at u ∈ [0, 1]: returns the part before u and leaves the part after it.
Bernstein split(Bernstein& polynomial, double u);

}  // namespace trunnion::smoothing
