#include "trunnion/pipeline/deform.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "trunnion/deformation/avoid_pole.hpp"
#include "trunnion/deformation/reduce_rotary.hpp"
#include "trunnion/geometry/great_circle.hpp"
#include "trunnion/machine/kinematics.hpp"
#include "trunnion/pipeline/convert.hpp"

namespace trunnion::pipeline {

using deformation::CuttingStretch;
using deformation::DualPath;
using Eigen::Vector3d;
using program::Program;

namespace {

constexpr double turning_precision_rad = 1e-5;
constexpr std::size_t fewest_poses = 4;
constexpr int places_compared = 16;

/// A stretch as a dual path, before and after.
struct Reshaped {
    DualPath path;
    double before = 0, after = 0;
};

class ProgramDeformation {
  public:
    ProgramDeformation(const Program& program, const machine::Machine& machine, const machine::Setup& setup,
                       const DeformOptions& options)
        : in_(program), machine_(machine), setup_(setup), options_(options) {}

    Result<DeformedProgram> run() {
        DeformedProgram out;
        std::vector<deformation::ReplacedStretch> replaced;
        for (const CuttingStretch& stretch : deformation::cutting_stretches(in_)) {
            const auto poses = deformation::poses_of(in_, stretch);
            if (!poses) return fail(poses.error());
            if (poses->poses.size() < fewest_poses) {
                ++out.left_alone;
                continue;
            }
            auto start = as_path(stretch, *poses);
            if (!start) return fail(located(start.error(), stretch));
            auto made = std::visit([&](const auto& aim) { return reshape(aim, start->path, stretch); }, options_.aim);
            if (!made) return fail(located(made.error(), stretch));
            out.stretches.push_back(account(stretch, start->path, *made));
            replaced.push_back({stretch, std::move(made->path), std::move(start->move_end_u)});
        }
        if (replaced.empty())
            return fail({.code = "PIPE0021",
                         .text = "the program has no stretch of cutting moves with 4 poses or more",
                         .place = {.file = in_.source}});
        out.program = deformation::with_dual_paths(in_, replaced, options_.chords);
        return out;
    }

  private:
    struct StartPath {
        DualPath path;
        std::vector<double> move_end_u;
    };

    Result<StartPath> as_path(const CuttingStretch& stretch, const deformation::StretchPoses& poses) const {
        if (auto native = deformation::dual_path_of(in_, stretch, options_.distance_mm)) {
            std::vector<double> ends;
            for (std::size_t k = stretch.first; k <= stretch.last; ++k)
                ends.push_back(in_.curve_parts[static_cast<std::size_t>(in_.moves[k].curve_part)].to_u);
            return StartPath{std::move(*native), std::move(ends)};
        }
        const double tolerance_mm = options_.fit_tolerance_mm;
        const auto fitted =
            deformation::fit_dual_path(poses.poses, {.distance_mm = options_.distance_mm,
                                                     .tip_tolerance_mm = tolerance_mm,
                                                     .orientation_tolerance_rad = tolerance_mm / options_.distance_mm});
        if (!fitted) return fail(fitted.error());
        std::vector<double> ends;
        for (const std::size_t pose : poses.move_end) ends.push_back(fitted->parameters[pose]);
        return StartPath{fitted->path, std::move(ends)};
    }

    const machine::Tool& tool_of(const CuttingStretch& stretch) const {
        const machine::Tool* tool = setup_.tool_named(in_.tools[in_.moves[stretch.first].tool]);
        return tool ? *tool : setup_.tool;
    }

    Result<Reshaped> reshape(const FitFlank& aim, const DualPath& path, const CuttingStretch& stretch) const {
        const machine::Tool& tool = tool_of(stretch);
        if (!(tool.diameter_mm > 0))
            return fail({.code = "PIPE0022",
                         .text = "the setup gives the tool no diameter",
                         .hint = "[tool] diameter in the setup file (--setup)"});
        deformation::FlankTool flank{.radius_mm = tool.diameter_mm / 2};
        if (aim.half_angle_rad) {
            flank.kind = deformation::FlankKind::cone;
            flank.half_angle_rad = *aim.half_angle_rad;
        } else if (aim.outline_radius_mm) {
            flank.kind = deformation::FlankKind::barrel;
            flank.outline_radius_mm = *aim.outline_radius_mm;
            flank.widest_height_mm = aim.widest_height_mm.value_or(0);
        }
        auto surface = surface_beside(aim, path);
        if (!surface) return fail(surface.error());
        auto made = deformation::deform_flank(path, flank, *surface, aim.options);
        if (!made) return fail(made.error());
        return Reshaped{std::move(made->path), made->before.peak_mm, made->after.peak_mm};
    }

    /// With its normals on the side of the tool.
    static Result<deformation::SplineSurface> surface_beside(const FitFlank& aim, const DualPath& path) {
        auto surface = deformation::guided_surface(aim.guide_curves_mm, deformation::Side::along);
        if (!surface) return surface;
        const double height_mm = 0.5 * (aim.options.range.from_height_mm + aim.options.range.to_height_mm);
        const Vector3d point = path.point_mm(0.5 * (path.begin() + path.end()), height_mm);
        const auto foot = surface->foot(point);
        if (foot && foot->normal.dot(point - foot->point_mm) < 0)
            return deformation::guided_surface(aim.guide_curves_mm, deformation::Side::against);
        return surface;
    }

    Result<Reshaped> reshape(const CompensateDeflection& aim, const DualPath& path, const CuttingStretch&) {
        const auto field = deformation::deflection_through(aim.samples);
        if (!field) return fail(field.error());
        const double from_mm = way_mm_;
        way_mm_ += deformation::tip_length_mm(path);
        const auto here = [&](double s_mm, const deformation::Pose& pose) { return (*field)(from_mm + s_mm, pose); };
        auto made = deformation::compensate_deflection(path, here, aim.tolerance_mm, aim.samples.back().s_mm - from_mm);
        if (!made) return fail(made.error());
        return Reshaped{std::move(made->path), made->largest_deflection_mm, made->residual_mm};
    }

    Result<Reshaped> reshape(const AvoidPole& aim, const DualPath& path, const CuttingStretch& stretch) const {
        const auto kinematics = kinematics_of(stretch);
        if (!kinematics) return fail(kinematics.error());
        auto made = deformation::avoid_pole(path, {machine_, *kinematics, tool_of(stretch), feed_of(stretch), {}},
                                            {.orientation_tolerance_rad = aim.orientation_tolerance_rad});
        if (!made) return fail(made.error());
        const double before = made->before ? made->before->velocity_ratio : HUGE_VAL;
        return Reshaped{std::move(made->path), before, made->after.velocity_ratio};
    }

    Result<Reshaped> reshape(const ReduceRotary& aim, const DualPath& path, const CuttingStretch& stretch) const {
        const auto kinematics = kinematics_of(stretch);
        if (!kinematics) return fail(kinematics.error());
        deformation::OrientationFreedom freedom;
        freedom.orientation_tolerance_rad = aim.orientation_tolerance_rad;
        auto made =
            deformation::reduce_rotary(path, {machine_, *kinematics, tool_of(stretch), feed_of(stretch), {}}, freedom);
        if (!made) return fail(made.error());
        return Reshaped{std::move(made->path), made->before.travel_rad, made->after.travel_rad};
    }

    /// The frame of the stretch's poses.
    Result<machine::Kinematics> kinematics_of(const CuttingStretch& stretch) const {
        machine::Frame frame = setup_.workpiece;
        const auto found = setup_.offsets.find(in_.offsets[in_.moves[stretch.first].offset]);
        if (found != setup_.offsets.end()) {
            frame.origin_mm += frame.rotation * found->second.origin_mm;
            frame.rotation = frame.rotation * found->second.rotation;
        }
        return machine::Kinematics::make(machine_, frame, tool_of(stretch).length_mm);
    }

    double feed_of(const CuttingStretch& stretch) const {
        double out = 0;
        for (std::size_t k = stretch.first; k <= stretch.last; ++k)
            if (in_.moves[k].feed.rule == program::FeedRule::tip_speed) out = std::max(out, in_.moves[k].feed.value);
        return out;
    }

    DeformedStretch account(const CuttingStretch& stretch, const DualPath& start, const Reshaped& made) const {
        DeformedStretch out{in_.moves[stretch.first].line, in_.moves[stretch.last].line, made.before, made.after};
        const auto& knots = start.spline.bottom().knots();
        for (std::size_t k = 0; k + 1 < knots.size(); ++k)
            for (int i = 0; i <= places_compared && knots[k] < knots[k + 1]; ++i) {
                const double u = std::lerp(knots[k], knots[k + 1], static_cast<double>(i) / places_compared);
                const auto was = start.at(u), is = made.path.at(u);
                out.tip_movement_mm =
                    std::max(out.tip_movement_mm, (is.tip_in_workpiece_mm - was.tip_in_workpiece_mm).norm());
                out.orientation_change_rad = std::max(
                    out.orientation_change_rad, geometry::angle_between(is.axis_in_workpiece, was.axis_in_workpiece));
            }
        return out;
    }

    Diagnostic located(Diagnostic diagnostic, const CuttingStretch& stretch) const {
        if (diagnostic.place.file.empty())
            diagnostic.place = {.file = in_.source, .line = in_.moves[stretch.first].line};
        return diagnostic;
    }

    const Program& in_;
    const machine::Machine& machine_;
    const machine::Setup& setup_;
    const DeformOptions& options_;
    double way_mm_ = 0;
};

}  // namespace

Result<DeformedProgram> deform(const Program& program, const machine::Machine& machine, const machine::Setup& setup,
                               const DeformOptions& options) {
    const auto by_words = [](const program::Move& move) { return move.law == program::OrientationLaw::rotary; };
    if (machine.rotary_count == 0 || std::ranges::none_of(program.moves, by_words))
        return ProgramDeformation(program, machine, setup, options).run();
    const auto vectors = translate(program, machine, setup, program::OrientationLaw::vector, turning_precision_rad);
    if (!vectors) return fail(vectors.error());
    return ProgramDeformation(*vectors, machine, setup, options).run();
}

}  // namespace trunnion::pipeline
