#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "trunnion/path/pole_passage.hpp"

namespace trunnion::path::detail {

/// A place where programmed vectors pass a pole so closely that they may be shifted onto it. p counts from there.
struct PoleCandidate {
    std::size_t move = 0;  ///< along which the tool axis comes nearest
    double share = 0;      ///< of that move
    Eigen::Vector3d pole = Eigen::Vector3d::UnitZ();
    Eigen::Vector3d shift = Eigen::Vector3d::Zero();  ///< from the nearest direction to the pole
    double reach_before_mm = 0, reach_after_mm = 0;   ///< of the shift
    std::size_t first = 0, last = 0;                  ///< moves that the shift touches
    double begin_mm = 0;                              ///< p where moves[first] begins
    std::vector<double> length_mm;                    ///< dp of these moves

    Eigen::Vector3d shift_at(double p_mm) const {
        return shift_share(p_mm < 0 ? -p_mm / reach_before_mm : p_mm / reach_after_mm) * shift;
    }
};

/// The tool axis along consecutive moves of law vector.
struct VectorBlock {
    std::size_t move = 0;
    Eigen::Vector3d from, to;     ///< unit, in the workpiece
    double length_mm = 0;         ///< dp
    bool begins_at_rest = false;  ///< the path before is another run, or turns back here
};

/// The places at which these blocks pass a pole within `tolerance_rad`, each with a stretch of its own in which the
/// tool comes at least `least_tilts` times as far away from it on both sides.
std::vector<PoleCandidate> pole_candidates(std::span<const VectorBlock> blocks, std::span<const Eigen::Vector3d> poles,
                                           double tolerance_rad);

}  // namespace trunnion::path::detail
