#pragma once

#include <cmath>
#include <filesystem>
#include <numbers>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "trunnion/base/quantity.hpp"
#include "trunnion/deformation/dual_path.hpp"
#include "trunnion/deformation/rotary_use.hpp"
#include "trunnion/files/machine_file.hpp"
#include "trunnion/geometry/rotation.hpp"

namespace trunnion::deformation {

inline std::filesystem::path machine_folder() {
    return std::filesystem::path(TRUNNION_SOURCE_DIR) / "data/machines";
}

inline machine::Machine shipped_machine(const std::string& name) {
    return files::read_machine_file(machine_folder() / (name + ".toml")).value();
}

/// A machine with a tool, for as long as a test runs.
struct Workshop {
    explicit Workshop(machine::Machine on, double feed_mm_min, machine::Tool with = {},
                      const machine::Frame& frame = {})
        : machine(std::move(on)),
          kinematics(machine::Kinematics::make(machine, frame, with.length_mm).value()),
          tool(with),
          feed_mm_s(feed_mm_min / 60) {}
    Machining machining() const { return {machine, kinematics, tool, feed_mm_s, {}}; }

    machine::Machine machine;
    machine::Kinematics kinematics;
    machine::Tool tool;
    double feed_mm_s;
};

inline machine::Tool ball(double diameter_mm, bool controls_centre) {
    return {machine::ToolKind::ball, diameter_mm, diameter_mm / 2, 0, controls_centre};
}

/// The tip goes 40 mm along X while the tool turns about Y from −10° to 10° beside a pole: 41 poses, the nearest one
/// `beside_deg` off the pole. Pole and path turned by `frame`.
inline std::vector<Pose> poses_past_pole(double beside_deg,
                                         const Eigen::Matrix3d& frame = Eigen::Matrix3d::Identity()) {
    std::vector<Pose> out;
    for (int i = 0; i <= 40; ++i) {
        const double tilt = (-10 + 0.5 * i) * degree, beside = beside_deg * degree;
        const Eigen::Vector3d axis(std::sin(tilt), std::sin(beside) * std::cos(tilt),
                                   std::cos(beside) * std::cos(tilt));
        out.push_back({frame * Eigen::Vector3d(-20 + i, 0, 0), frame * axis});
    }
    return out;
}

inline DualPath path_past_pole(double beside_deg, const Eigen::Matrix3d& frame = Eigen::Matrix3d::Identity()) {
    return fit_dual_path(poses_past_pole(beside_deg, frame)).value().path;
}

/// Largest angle between the tool axes of two paths, at 40 places a knot interval of the second one.
inline double sampled_deviation_rad(const DualPath& a, const DualPath& b) {
    double out = 0;
    const auto& knots = b.spline.bottom().knots();
    for (std::size_t k = 0; k + 1 < knots.size(); ++k)
        for (int i = 0; i < 40 && knots[k] < knots[k + 1]; ++i) {
            const double u = knots[k] + (knots[k + 1] - knots[k]) * i / 40;
            const Eigen::Vector3d first = a.at(u).axis_in_workpiece, second = b.at(u).axis_in_workpiece;
            out = std::max(out, std::atan2(first.cross(second).norm(), first.dot(second)));
        }
    return out;
}

/// Largest distance of the points at a height of the tool between two paths.
inline double sampled_distance_mm(const DualPath& a, const DualPath& b, double height_mm) {
    double out = 0;
    for (int i = 0; i <= 4000; ++i) {
        const double u = a.begin() + (a.end() - a.begin()) * i / 4000;
        out = std::max(out, (a.point_mm(u, height_mm) - b.point_mm(u, height_mm)).norm());
    }
    return out;
}

/// Jumps of the first and second derivative of the tool axis at inner knots, over their size.
inline double largest_jump(const DualPath& path) {
    double out = 0;
    const auto& knots = path.spline.bottom().knots();
    for (const double u : knots) {
        if (u <= path.begin() || u >= path.end()) continue;
        const double step = 1e-9 * (path.end() - path.begin());
        for (const auto& curve : {path.spline.bottom(), path.spline.top()}) {
            const auto left = curve.evaluate(u - step), right = curve.evaluate(u);
            for (std::size_t k = 0; k < 3; ++k)
                out = std::max(out, (right[k] - left[k]).norm() / (1 + right[k].norm()));
        }
    }
    return out;
}

}  // namespace trunnion::deformation
