#pragma once

#include <algorithm>
#include <optional>
#include <vector>

#include "detail/bumps.hpp"
#include "detail/measure.hpp"

namespace trunnion::smoothing {

/// Everything that says which curve a stretch of programmed path becomes.
struct Curve {
    Polyline line;
    Measure measure;
    Bumps bumps;
    std::vector<double> cap;  ///< largest width of each vertex, counted as in Bumps
    std::vector<double> raw_width;

    Curve(Polyline polyline, const Measure& how);
    /// Lever with which a deviation at a vertex is weighed; vertices as in Bumps.
    double lever(std::size_t vertex) const {
        return std::max(line.lever[bumps.source(vertex) - bumps.first()], least_lever);
    }
    double use(const Coordinates& deviation, std::size_t vertex) const { return measure.use(deviation, lever(vertex)); }
    /// Use of the tolerances by a deviation at a place, at equal p and from the nearest places: where tip and tool axis
    /// slip along the path by different amounts, the nearest place may leave the tip more than equal p does. Places on
    /// several blocks that are as near count all.
    double use_nearby(const Coordinates& deviation, Place at) const {
        std::optional<Coordinates> tangent;
        return use_nearby(deviation, at, tangent);
    }
    /// The same; c′ at the place is left in `tangent`, or taken from there, where it is needed.
    double use_nearby(const Coordinates& deviation, Place at, std::optional<Coordinates>& tangent) const;
};

/// The programmed path as chords between which kinks are so small that several of them share one width.
Polyline chords(const path::Run& run, VertexRange range, const Measure& measure);

/// Finds shares and widths that use the tolerances: total variation along the scale for curves, what is left for
/// corners. They hold at vertices and in the middle of blocks as far as sums go; the certificate decides.
void find_widths(Curve& curve);

/// How much of the tolerances a deviation uses, and the curve bumps alone.
struct Use {
    double curve = 0, total = 0;
};

/// Where a deviation is too large: within `extent_mm` of a place (vertices and blocks as in Bumps).
struct Excess {
    Place at;
    double extent_mm = 0;
    Use use;
};

/// A vertex whose widths changed, and the reach of the wider of its bumps before and after.
struct Moved {
    std::size_t vertex = 0;
    double reach_mm = 0;
};

/// Narrows the bumps that make deviations too large. `round` counts the attempts from 0: later ones take less care.
std::vector<Moved> narrow(Curve& curve, const std::vector<Excess>& places, int round);

}  // namespace trunnion::smoothing
