#pragma once

#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include "trunnion/base/quantity.hpp"
#include "trunnion/deformation/flank_milling.hpp"

namespace trunnion::deformation {

template <class T>
T taken(Result<T> result) {
    if (!result) throw std::runtime_error(to_string(result.error()));
    return std::move(*result);
}

/// Guide curves of a blade of 100 mm length, 30 mm high, slightly arched, whose rulings lean by −twist/2 … twist/2
/// along it; with three rows the one in the middle is pushed out by `belly_mm`.
inline std::vector<std::vector<Eigen::Vector3d>> blade_rows(double twist_rad, double belly_mm = 0) {
    std::vector<std::vector<Eigen::Vector3d>> out(belly_mm == 0 ? 2 : 3);
    for (int i = 0; i <= 20; ++i) {
        const double w = i / 20.0, lean = twist_rad * (w - 0.5);
        const Eigen::Vector3d bottom(100 * w, 12 * w * (1 - w), 0);
        const Eigen::Vector3d up(0.05, std::sin(lean), std::cos(lean));
        for (std::size_t r = 0; r < out.size(); ++r) {
            const double v = static_cast<double>(r) / static_cast<double>(out.size() - 1);
            out[r].push_back(bottom + 30 * v * up + 4 * v * (1 - v) * belly_mm * Eigen::Vector3d::UnitY());
        }
    }
    return out;
}

inline SplineSurface blade(double twist_rad, double belly_mm = 0) {
    return taken(guided_surface(blade_rows(twist_rad, belly_mm), Side::against));
}

/// Positioned on both edges, as a dual path.
inline DualPath two_point_path(const DesignedSurface& surface, const FlankTool& tool, int poses = 25,
                               double lower_height_mm = 2) {
    return taken(fit_dual_path(taken(two_point_poses(surface, tool, poses, lower_height_mm)))).path;
}

inline FlankRange blade_range() {
    return {.from_height_mm = 2, .to_height_mm = 32};
}

}  // namespace trunnion::deformation
