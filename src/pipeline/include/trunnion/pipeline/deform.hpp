#pragma once

#include <cstddef>
#include <filesystem>
#include <limits>
#include <optional>
#include <variant>
#include <vector>

#include <Eigen/Core>

#include "trunnion/base/result.hpp"
#include "trunnion/deformation/deflection.hpp"
#include "trunnion/deformation/dual_path_program.hpp"
#include "trunnion/deformation/flank_milling.hpp"
#include "trunnion/machine/machine.hpp"
#include "trunnion/program/program.hpp"

namespace trunnion::pipeline {

/// The side of the tool is to leave this surface (deformation::deform_flank).
struct FitFlank {
    std::vector<std::vector<Eigen::Vector3d>>
        guide_curves_mm;  ///< of deformation::guided_surface; the tool's side is free
    deformation::FlankDeformation options;
    std::optional<double> half_angle_rad;                       ///< the tool is a cone: its diameter is that of the tip
    std::optional<double> outline_radius_mm, widest_height_mm;  ///< the tool is a barrel: its diameter is the largest
};

/// The tip bent by this field is to run where the program says (deformation::compensate_deflection). s counts on
/// through all stretches that are deformed.
struct CompensateDeflection {
    std::vector<deformation::DeflectionSample> samples;
    double tolerance_mm = 1e-3;
};

/// deformation::avoid_pole, by at most this.
struct AvoidPole {
    double orientation_tolerance_rad = 0;
};

/// deformation::reduce_rotary, by at most this.
struct ReduceRotary {
    double orientation_tolerance_rad = 0;
};

struct DeformOptions {
    std::variant<FitFlank, CompensateDeflection, AvoidPole, ReduceRotary> aim;
    double distance_mm = 50;  ///< of the two curves
    double fit_tolerance_mm =
        0;  ///< 0: the curves pass through every programmed pose; else within this, the axis within this / distance
    std::optional<deformation::Chords> chords;  ///< straight moves instead of curves
};

/// What happened to one stretch.
struct DeformedStretch {
    int first_line = 0, last_line = 0;
    double before = 0,
           after = 0;            ///< flank: peak deviation, mm; deflection: largest deflection and residual, mm;
                                 ///< pole: peak rotary velocity over its limit; rotary: travel of the rotary axes, rad
    double tip_movement_mm = 0;  ///< largest of the tip, at equal u
    double orientation_change_rad = 0;
};

struct DeformedProgram {
    program::Program program;
    std::vector<DeformedStretch> stretches;
    std::size_t left_alone = 0;  ///< stretches of fewer than 4 poses
};

/// A program whose cutting stretches are dual splines, deformed. Rotary words are turned into tool vectors first
/// (translate(), which tells its own); stretches of fewer than 4 poses and all other moves stay as they are. Curves
/// that already are dual splines are taken as they are.
///
/// Errors: those of translate() and of the deformation; PIPE0021 no stretch has 4 poses, PIPE0022 flank: the setup
/// gives the tool no diameter. The place of an error is the stretch's first line.
Result<DeformedProgram> deform(const program::Program& program, const machine::Machine& machine,
                               const machine::Setup& setup, const DeformOptions& options);

/// Guide curves of a surface, CSV: `row,x_mm,y_mm,z_mm`; rows from 0 at the tip's edge upwards, in order, each with the
/// same number of points. Errors: PIPE0023 not such a table; those of files::read_whole_file.
Result<std::vector<std::vector<Eigen::Vector3d>>> read_guide_curves(const std::filesystem::path& file);

/// Deflections, CSV: `s_mm,x_mm,y_mm,z_mm`. Errors as above.
Result<std::vector<deformation::DeflectionSample>> read_deflections(const std::filesystem::path& file);

}  // namespace trunnion::pipeline
