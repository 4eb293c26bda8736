#pragma once

#include <Eigen/Core>

#include "trunnion/path/run.hpp"

namespace trunnion::smoothing {

/// Position (mm) and orientation coordinates as one vector.
using Coordinates = Eigen::Matrix<double, 6, 1>;

inline Coordinates joined(const path::PathCoordinates& at) {
    Coordinates q;
    for (int k = 0; k < 3; ++k) {
        q[k] = at.position_mm[k];
        q[3 + k] = at.orientation[k];
    }
    return q;
}

/// The orientation is a vector (else: rotary axes).
inline bool has_vectors(const path::Run& run) {
    return run.law == path::OrientationLaw::vector && run.space == path::Space::workpiece;
}

/// The position does not go straight.
inline bool is_round(const path::Block& block) {
    return block.arc != program::no_arc || block.curve != path::no_curve;
}

/// Programmed vertices first … last of a run.
struct VertexRange {
    std::size_t first = 0, last = 0;
};

/// How far apart two places are, as a length.
inline double size_mm(const Coordinates& d) {
    return d.head<3>().norm() + path::reference_height_mm * d.tail<3>().norm();
}

/// A block shorter than this is a doubled point.
inline constexpr double shortest_block_mm = 1e-7;

}  // namespace trunnion::smoothing
