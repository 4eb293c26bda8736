#pragma once

#include <memory>
#include <stdexcept>
#include <vector>

#include "trunnion/feed/plan_stretch.hpp"
#include "trunnion/path/axis_path.hpp"
#include "trunnion/smoothing/smoothing.hpp"

namespace trunnion::test {

/// C on A table of today's size, pivots at the machine zero, workpiece 50 mm above.
const machine::Machine& trunnion_table();
const machine::Kinematics& table_kinematics();

/// 10 µm and 0.1°.
inline smoothing::SmoothingOptions tolerances() {
    smoothing::SmoothingOptions options;
    options.tip_tolerance_mm = 0.01;
    return options;
}

std::vector<path::ToolPath> smoothed(const path::Run& run, const smoothing::SmoothingOptions& options = tolerances());

/// The one stretch of a run that needs no standstill inside. Throws std::runtime_error where there are more.
path::ToolPath smoothed_to_one(const path::Run& run, const smoothing::SmoothingOptions& options = tolerances());

/// A path with its fastest motion. The axis path points to the tool path: stays where it was made.
class Planned {
  public:
    /// Throws std::runtime_error with the diagnostic's words.
    explicit Planned(path::ToolPath path);
    Planned(const Planned&) = delete;
    Planned& operator=(const Planned&) = delete;

    const path::ToolPath& path() const { return path_; }
    double duration_s() const { return plan_.profile.duration_s(); }

    struct State {
        double time_s;
        Eigen::Vector3d tip_mm;
        std::array<double, 3> orientation;  ///< as in the tool path; a vector of length 1
        double tip_speed_mm_s;
    };
    /// In even steps of time.
    std::vector<State> walked(double step_s) const;

  private:
    path::ToolPath path_;
    std::unique_ptr<path::AxisPath> axis_path_;
    feed::StretchPlan plan_;
};

}  // namespace trunnion::test
