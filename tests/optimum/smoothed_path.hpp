#pragma once

#include <cmath>
#include <memory>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>
#include <fmt/format.h>

#include "trunnion/nc/read.hpp"
#include "trunnion/path/axis_path.hpp"
#include "trunnion/path/path_builder.hpp"
#include "trunnion/path/rotary_stands.hpp"
#include "trunnion/smoothing/smoothing.hpp"

/// Paths as programs give them: read, built and smoothed, before any speed is planned.
namespace trunnion::test {

template <class T>
T value_of(Result<T> result) {
    if (!result) throw std::runtime_error(to_string(result.error()));
    return std::move(*result);
}

/// The first stretch of a program. Machine, program and tool path stay where they were made: the axis path points to
/// them.
class SmoothedPath {
  public:
    /// Throws std::runtime_error with the diagnostic's words.
    SmoothedPath(machine::Machine machine, machine::Setup setup, std::string_view text,
                 const smoothing::SmoothingOptions& options)
        : machine_(std::move(machine)), setup_(std::move(setup)) {
        nc::ReadOptions reading;
        reading.machine = &machine_;
        program_ = value_of(nc::read_program(text, "program", reading));
        stands_ = value_of(path::choose_rotary_stands(program_, machine_, setup_));
        builder_ = value_of(path::PathBuilder::make(program_, machine_, setup_, stands_));
        path::Run run;
        value_of(builder_->next(run));
        std::vector<path::ToolPath> stretches;
        smoothing::smooth(run, options, stretches);
        tool_path_ = std::move(stretches.front());
        axis_path_ = value_of(path::AxisPath::make(tool_path_, machine_, stands_.front().rotary_rad));
    }
    SmoothedPath(const SmoothedPath&) = delete;
    SmoothedPath& operator=(const SmoothedPath&) = delete;

    const path::AxisPath& axis_path() const { return *axis_path_; }

  private:
    machine::Machine machine_;
    machine::Setup setup_;
    program::Program program_;
    std::vector<program::RotaryStand> stands_;
    std::optional<path::PathBuilder> builder_;
    path::ToolPath tool_path_;
    std::optional<path::AxisPath> axis_path_;
};

/// Cutter locations as post-processors take them, digits as CAM systems write them.
class CutterLocations {
  public:
    explicit CutterLocations(double feed_mm_min) : text_(fmt::format("UNITS / MM\nFEDRAT / {}, MMPM\n", feed_mm_min)) {}
    void go_to(const Eigen::Vector3d& tip_mm, const Eigen::Vector3d& axis) {
        text_ += fmt::format("GOTO / {:.9f}, {:.9f}, {:.9f}, $\n {:.12f}, {:.12f}, {:.12f}\n", tip_mm.x(), tip_mm.y(),
                             tip_mm.z(), axis.x(), axis.y(), axis.z());
    }
    std::string text() const { return text_ + "FINI\n"; }

  private:
    std::string text_;
};

/// Flank milling around a pyramid of 80 mm below and 50 mm above, 50 mm high.
inline std::string pyramid() {
    CutterLocations out(30000);
    const Eigen::Vector2d corners[] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}, {-1, -1}};
    for (const Eigen::Vector2d& corner : corners) {
        const Eigen::Vector3d bottom(40 * corner.x(), 40 * corner.y(), 0), top(25 * corner.x(), 25 * corner.y(), 50);
        out.go_to(bottom, (top - bottom).normalized());
    }
    return out.text();
}

/// Spiral of 1 mm pitch on z = 3 sin(2πx/60) sin(2πy/60), the tool leaning 30° from its normal towards Y.
inline std::string spiral(double length_mm, double step_mm) {
    CutterLocations out(30000);
    constexpr double wave = 2 * std::numbers::pi / 60, rise = 0.5 / std::numbers::pi;  // mm per rad
    const double tilt = std::tan(std::numbers::pi / 6);
    double angle = 0;
    for (double way = 0; way <= length_mm; way += step_mm) {
        const double radius = 5 + rise * angle, x = radius * std::cos(angle), y = radius * std::sin(angle);
        const double slope_x = 3 * wave * std::cos(wave * x) * std::sin(wave * y),
                     slope_y = 3 * wave * std::sin(wave * x) * std::cos(wave * y);
        out.go_to({x, y, 3 * std::sin(wave * x) * std::sin(wave * y)},
                  Eigen::Vector3d(-slope_x, -slope_y + tilt, 1).normalized());
        angle += step_mm / std::hypot(radius, rise);
    }
    return out.text();
}

}  // namespace trunnion::test
