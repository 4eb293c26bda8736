#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>

#include "trunnion/path/run.hpp"
#include "trunnion/path/tool_path.hpp"

namespace trunnion::pipeline {

/// How far a fit may lie from the smoothed path.
struct FitTolerance {
    double tip_mm = 0;  ///< of the controlled point
    double orientation_rad = 0;
    double flank_mm = 0, flank_height_mm = 0;  ///< > 0: of the point at the flank height, in place of the angle
    double controlled_height_mm = 0;
};

/// The largest distances of a fit.
struct FitDeviation {
    double tip_mm = 0, orientation_rad = 0, height_mm = 0;

    void add(const FitDeviation& other);
    bool within(const FitTolerance& tolerance) const;
};

/// A smoothed stretch as a curve of poses over p.
class StretchCurve {
  public:
    StretchCurve(const path::ToolPath& path, const path::Run& run) : path_(&path), run_(&run) {}

    double length_mm() const { return path_->length_mm(); }
    bool by_vectors() const { return path_->law == path::OrientationLaw::vector; }

    /// Tip; tool axis, unit, or rotary words of the machine's axes.
    struct Pose {
        Eigen::Vector3d tip_mm, orientation;
    };
    Pose at(double p_mm) const;
    /// d/dp of both, the vector's that of the unit one.
    Pose slope(double p_mm) const;
    Eigen::Vector3d tool_axis(const Pose& pose) const;
    FitDeviation deviation(const Pose& fit, double p_mm, const FitTolerance& tolerance) const;

  private:
    std::array<Taylor3, 6> series(double p_mm) const;

    const path::ToolPath* path_;
    const path::Run* run_;
};

/// Where straight moves between them keep the tolerance: ascending p, from 0 to the end, every break among them. As few
/// as going as far as possible each time gives. Adds what they deviate to `deviation`.
std::vector<double> chord_ends(const StretchCurve& curve, const std::vector<double>& breaks,
                               const FitTolerance& tolerance, FitDeviation& deviation);

}  // namespace trunnion::pipeline
