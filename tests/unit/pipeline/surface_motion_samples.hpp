#pragma once

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "trunnion/pipeline/surface_motion.hpp"
#include "trunnion/verify/check.hpp"

#include "planned.hpp"

namespace trunnion::pipeline::surface_motion_samples {

using geometry::BsplineSurface;
using surfacing::Face;

/// Bicubic, 40 × 12 mm; it falls to one side by 30° or so, so that the axis keeps away from the table's pole.
inline Face slope(bool knots_inside = false) {
    const geometry::SurfaceDirection one{3, {0, 0, 0, 0, 1, 1, 1, 1}}, two{3, {0, 0, 0, 0, 0.4, 0.7, 1, 1, 1, 1}};
    const geometry::SurfaceDirection& along = knots_inside ? two : one;
    const int rows = static_cast<int>(along.points());
    std::vector<Eigen::Vector3d> points;
    for (int i = 0; i < rows; ++i)
        for (int j = 0; j < 4; ++j) {
            const double x = 40.0 * i / (rows - 1), y = 4.0 * j;
            points.emplace_back(x, y, 0.6 * y + 4 * std::sin(0.12 * x) - 0.01 * (y - 6) * (y - 6));
        }
    return surfacing::whole_face(BsplineSurface::make(along, one, points).value());
}

struct SurfaceCase {
    machine::Machine machine = files::read_machine(test_table, "test.toml").value();
    machine::Setup setup;
    Face face;
    surfacing::SurfaceOptions surface;
    SurfaceMotionOptions options;

    explicit SurfaceCase(Face on, machine::Tool tool = {.kind = machine::ToolKind::ball,
                                                        .diameter_mm = 8,
                                                        .corner_radius_mm = 4})
        : face(std::move(on)) {
        setup.workpiece.origin_mm = {-20, -6, 30};
        setup.tool = tool;
        setup.tool.length_mm = 100;
        surface.strategy = surfacing::Strategy::along_u;
        surface.scallop_mm = 0.05;
        surface.chord_tolerance_mm = 0.001;
        surface.borders = false;
        surface.feed_mm_s = 30;
        surface.longest_step_mm = 0.5;  // turning in a plane from pose to pose is then near enough to true normals
    }

    surfacing::Cutter cutter() const { return surfacing::Cutter::make(setup.tool).value(); }
    /// Rows of passes have line 1, those of links 0.
    surfacing::SurfacePlan plan() const {
        auto out = surfacing::plan_surface(face, cutter(), surface).value();
        for (program::Move& move : out.program.moves)
            move.line = std::ranges::any_of(out.passes, [&](const surfacing::Pass& pass) {
                return move.position_mm == pass.contacts.back().pose.tip_mm;
            });
        return out;
    }
    Result<SurfaceMotionSummary> move(const surfacing::SurfacePlan& plan, PlanObserver& observer) const {
        return move_surface(plan, {&face, 1}, surface, machine, setup, options, observer);
    }
};

inline verify::Verdict verdict_of(const SurfaceCase& work, const surfacing::SurfacePlan& plan,
                                  const Recorder& recorder) {
    const auto table = verify::setpoint_table(recorder.rows).value();
    const auto poses = programmed_poses(plan, work.machine, work.setup).value();
    return verify::check(table, poses, work.machine, work.setup, {}).value();
}

/// Axis limits by differences of the setpoints alone.
inline double largest_ratio(const SurfaceCase& work, const Recorder& recorder) {
    double largest = 0;
    const double T = work.options.plan.period_s;
    const auto& rows = recorder.rows;
    for (int i = 0; i < work.machine.axis_count; ++i) {
        const auto q = [&](std::size_t k) { return rows[std::min(k, rows.size() - 1)].position[i]; };
        const machine::AxisLimits& limits = work.machine.axes[i].feed;
        for (std::size_t k = 0; k < rows.size(); ++k) {
            largest = std::max({largest, std::abs(q(k + 1) - q(k)) / T / limits.velocity,
                                std::abs(q(k + 2) - 2 * q(k + 1) + q(k)) / (T * T) / limits.acceleration,
                                std::abs(q(k + 3) - 3 * q(k + 2) + 3 * q(k + 1) - q(k)) / (T * T * T) / limits.jerk});
        }
    }
    return largest;
}

/// A patch of a cylinder of radius 60 about Y, 24 mm in x and 6 mm in y, that falls by `slope` along y: its normals
/// pass the table's pole at that angle.
inline Face hump(double slope = 0) {
    return surfacing::whole_face(
        geometry::polynomial_surface(
            2, 1, {{-12, 0, -1.2}, {0, 6, -6 * slope}, {24, 0, 4.8}, {0, 0, 0}, {0, 0, -4.8}, {0, 0, 0}})
            .value());
}

}  // namespace trunnion::pipeline::surface_motion_samples
