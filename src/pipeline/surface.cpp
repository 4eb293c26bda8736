#include "trunnion/pipeline/surface.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "trunnion/base/quantity.hpp"
#include "trunnion/deformation/dual_path_program.hpp"
#include "trunnion/geometry/great_circle.hpp"
#include "trunnion/surfacing/leave_out.hpp"
#include "trunnion/surfacing/plan_region.hpp"

#include "detail/part_looks.hpp"

namespace trunnion::pipeline {

using deformation::FittedDualPath;
using deformation::ReplacedStretch;
using program::Program;
using surfacing::Contact;
using surfacing::Cutter;
using surfacing::Face;
using surfacing::Pass;
using surfacing::SurfaceOptions;

namespace {

constexpr double contact_share = 0.125;  ///< of the chord tolerance, for straight steps between contacts
constexpr double spline_share = 0.25;    ///< for the tip off the contacts' tips, and for the axis
constexpr double axis_first_rad = 0.01 * degree, axis_first_tip_mm = 0.05;  ///< of the spline of the axis
constexpr std::size_t fewest_contacts = 4;

/// Of the gouge tolerance: what the chords of passes that are freed may take, and the triangles of the part.
constexpr double freed_chord_share = 0.25, freed_part_share = 0.25;
constexpr double any_depth_mm = 1e6;

/// Contacts close enough to stand for the true passes; ridges as high as without.
SurfaceOptions close_contacts(SurfaceOptions options) {
    const double kept_mm = (1 - contact_share) * options.chord_tolerance_mm;
    options.scallop_mm -= kept_mm;
    options.chord_tolerance_mm -= kept_mm;
    return options;
}

std::vector<machine::Pose> poses_of(const Pass& pass) {
    std::vector<machine::Pose> out;
    for (const Contact& contact : pass.contacts) out.push_back({contact.pose.tip_mm, contact.pose.axis});
    return out;
}

/// Puts dual splines into a plan in place of straight moves.
class PassSplines {
  public:
    PassSplines(std::span<const Face> faces, const Cutter& cutter, double chord_tolerance_mm)
        : faces_(faces), cutter_(cutter), tip_tolerance_mm_(spline_share * chord_tolerance_mm) {}

    SplineAccount put_into(surfacing::SurfacePlan& plan) {
        std::vector<ReplacedStretch> replaced;
        std::size_t move = 0;
        for (Pass& pass : plan.passes) {
            move = first_move(plan.program, pass, move);
            const std::size_t last = move + pass.contacts.size() - 1;
            const auto fitted = fit(pass);
            if (!fitted) {
                ++account_.left_straight;
                continue;
            }
            take(pass, *fitted);
            replaced.push_back(
                {{move + 1, last}, fitted->path, {fitted->parameters.begin() + 1, fitted->parameters.end()}});
        }
        plan.program = deformation::with_dual_paths(plan.program, replaced);
        account_.curves = replaced.size();
        account_.spans = plan.program.curve_parts.size();
        return account_;
    }

  private:
    /// The move that ends at the pass's first contact.
    static std::size_t first_move(const Program& program, const Pass& pass, std::size_t from) {
        const auto begins = [&](const program::Move& move) {
            return move.kind == program::MoveKind::feed && move.position_mm == pass.contacts.front().pose.tip_mm;
        };
        const auto found = std::ranges::find_if(program.moves.begin() + static_cast<std::ptrdiff_t>(from),
                                                program.moves.end(), begins);
        return static_cast<std::size_t>(found - program.moves.begin());
    }

    /// Where the tool touches wherever its axis points, a spline of the axis comes first, and the tips follow it.
    std::optional<FittedDualPath> fit(const Pass& pass) const {
        if (pass.contacts.size() < fewest_contacts) return {};
        const auto poses = poses_of(pass);
        const double tip_mm = tip_tolerance_mm_, turn_rad = tip_tolerance_mm_ / cutter_.radius_mm();
        if (!turns_freely(pass)) return near(poses, tip_mm, turn_rad);
        const auto axes = near(poses, axis_first_tip_mm, axis_first_rad);
        return axes ? near(touching(pass, *axes), tip_mm, turn_rad) : std::nullopt;
    }

    static std::optional<FittedDualPath> near(const std::vector<machine::Pose>& poses, double tip_mm, double turn_rad) {
        auto fitted =
            deformation::fit_dual_path(poses, {.tip_tolerance_mm = tip_mm, .orientation_tolerance_rad = turn_rad});
        return fitted ? std::optional(std::move(*fitted)) : std::nullopt;
    }

    /// A ball, or a tool that leans far more than its axis may be off: on its flat end a turn lifts it off.
    bool turns_freely(const Pass& pass) const {
        constexpr double far = 20;
        return cutter_.is_ball() || std::ranges::all_of(pass.contacts, [](const Contact& contact) {
                   return contact.normal.cross(contact.pose.axis).norm() > far * axis_first_rad;
               });
    }

    std::vector<machine::Pose> touching(const Pass& pass, const FittedDualPath& axes) const {
        std::vector<machine::Pose> out;
        for (std::size_t i = 0; i < pass.contacts.size(); ++i) {
            const Contact& contact = pass.contacts[i];
            const auto [tip, axis] = axes.path.at(axes.parameters[i]);
            out.push_back({cutter_.touching(contact.point_mm, contact.normal, axis).tip_mm, axis});
        }
        return out;
    }

    /// The poses of the spline in place of the planner's, and how far both are apart.
    void take(Pass& pass, const FittedDualPath& fitted) {
        account_.tip_error_mm = std::max(account_.tip_error_mm, fitted.tip_deviation_mm);
        std::vector<Contact> driven;
        for (std::size_t i = 0; i < pass.contacts.size(); ++i) {
            const double u = fitted.parameters[i];
            if (i > 0) {
                const double middle = 0.5 * (fitted.parameters[i - 1] + u);
                if (auto between = half_way(pass.contacts[i - 1], pass.contacts[i], fitted.path, middle))
                    driven.push_back(*between);
            }
            driven.push_back(led(pass.contacts[i], fitted.path, u));
            account_.axis_error_rad = std::max(
                account_.axis_error_rad, geometry::angle_between(driven.back().pose.axis, pass.contacts[i].pose.axis));
        }
        for (const Contact& contact : driven)
            account_.touch_error_mm =
                std::max(account_.touch_error_mm, std::abs(cutter_.distance_mm(contact.pose, contact.point_mm)));
        pass.contacts = std::move(driven);
    }

    static Contact led(Contact contact, const deformation::DualPath& path, double u) {
        const machine::Pose pose = path.at(u);
        contact.pose = {pose.tip_in_workpiece_mm, pose.axis_in_workpiece};
        return contact;
    }

    std::optional<Contact> half_way(const Contact& a, const Contact& b, const deformation::DualPath& path,
                                    double u) const {
        if (a.face != b.face) return std::nullopt;
        const Face& face = faces_[static_cast<std::size_t>(a.face)];
        Contact out = a;
        out.place = {0.5 * (a.place.u + b.place.u), 0.5 * (a.place.v + b.place.v)};
        const auto shape = shape_at(face.surface, out.place, face.side);
        if (!shape) return std::nullopt;
        out.point_mm = shape->point;
        out.normal = shape->normal;
        return led(out, path, u);
    }

    std::span<const Face> faces_;
    const Cutter& cutter_;
    double tip_tolerance_mm_;
    SplineAccount account_;
};

/// The faces that are machined first.
std::vector<Face> part_of(std::span<const Face> faces, const SurfaceProgramOptions& options) {
    std::vector<Face> out(faces.begin(), faces.end());
    out.insert(out.end(), options.others.begin(), options.others.end());
    return out;
}

/// Plans passes that may gouge, and frees them.
class FreePlanning {
  public:
    FreePlanning(std::span<const Face> faces, const Cutter& cutter, const SurfaceOptions& passes,
                 const SurfaceProgramOptions& options)
        : faces_(faces),
          cutter_(cutter),
          options_(options),
          passes_(passes),
          part_(part_of(faces, options)),
          tolerance_mm_(passes.gouge_tolerance_mm) {
        passes_.chord_tolerance_mm = std::min(passes.chord_tolerance_mm, freed_chord_share * tolerance_mm_);
        passes_.gouge_tolerance_mm = any_depth_mm;
        passes_.across_joints = false;  // passes are freed face by face
    }

    Result<SurfaceResult> run() const {
        auto plan = surfacing::plan_region(faces_, cutter_, passes_);
        if (!plan) return fail(plan.error());
        const auto body = surfacing::PartBody::make(part_, freed_part_share * tolerance_mm_);
        if (!body) return fail(body.error());
        auto freed = surfacing::free_of_gouges(
            std::move(*plan), faces_, cutter_, *body, passes_,
            {.tolerance_mm = tolerance_mm_, .limits = *options_.freeing, .holder = options_.holder});
        if (!freed) return fail(freed.error());
        SurfaceResult out{.freed = account_of(*freed)};
        out.plan = std::move(freed->plan);
        return out;
    }

  private:
    FreedAccount account_of(const surfacing::FreedPlan& freed) const {
        FreedAccount out{.gouges = freed.gouges,
                         .worst = freed.worst,
                         .tolerance_mm = tolerance_mm_,
                         .passes_turned = freed.passes_turned,
                         .largest_turn_rad = freed.largest_turn_rad,
                         .largest_step_rad = freed.largest_step_rad,
                         .rounds = freed.rounds,
                         .links_raised = freed.links_raised,
                         .highest_link_mm = freed.highest_link_mm};
        if (freed.worst) out.worst_face = part_[static_cast<std::size_t>(freed.worst->face)].number;
        return out;
    }

    std::span<const Face> faces_;
    const Cutter& cutter_;
    const SurfaceProgramOptions& options_;
    SurfaceOptions passes_;
    std::vector<Face> part_;
    double tolerance_mm_;
};

/// Plans passes that may gouge, and cuts away where they do.
Result<SurfaceResult> planned_within_reach(std::span<const Face> faces, const Cutter& cutter,
                                           const SurfaceOptions& passes, const SurfaceProgramOptions& options) {
    auto plan = surfacing::plan_region(faces, cutter, passes);
    if (!plan) return fail(plan.error());
    const auto body = surfacing::PartBody::make(part_of(faces, options), part_tolerance_mm(passes.gouge_tolerance_mm));
    if (!body) return fail(body.error());
    const double tolerance_mm = passing_depth_mm(passes.gouge_tolerance_mm);
    auto reached = surfacing::leave_out_gouges(std::move(*plan), faces, cutter, *body, passes,
                                               {.tolerance_mm = tolerance_mm, .holder = options.holder});
    if (!reached) return fail(reached.error());
    SurfaceResult out{.left = LeftAccount{.way_mm = reached->left_way_mm,
                                          .deepest_mm = reached->deepest_mm,
                                          .passes_lost = reached->passes_lost,
                                          .ridges_too_high = reached->ridges_too_high}};
    out.plan = std::move(reached->plan);
    return out;
}

Result<SurfaceResult> planned_as_it_is(std::span<const Face> faces, const Cutter& cutter, const SurfaceOptions& passes,
                                       const SurfaceProgramOptions& options) {
    auto plan = surfacing::plan_region(faces, cutter, passes);
    if (!plan) return fail(plan.error());
    if (options.others.empty() && options.holder.radius_mm == 0) return SurfaceResult{.plan = std::move(*plan)};
    // Of a part that is too fine to be looked at, the links keep clear of the faces alone.
    if (const auto body =
            surfacing::PartBody::make(part_of(faces, options), part_tolerance_mm(passes.gouge_tolerance_mm)))
        surfacing::lead_links_clear(
            *plan, cutter, *body, passes,
            {.tolerance_mm = passing_depth_mm(passes.gouge_tolerance_mm), .holder = options.holder});
    return SurfaceResult{.plan = std::move(*plan)};
}

/// Tool and spindle before the first move, spindle off and the end behind the last.
void add_events(Program& program, const SurfaceProgramOptions& options) {
    using program::EventKind;
    const auto add = [&](EventKind kind, bool stops, std::string word, std::size_t before) {
        program.events.push_back({.kind = kind, .stops_motion = stops, .word = std::move(word), .before_move = before});
    };
    const std::size_t end = program.moves.size();
    if (!options.tool_name.empty()) {
        program.tools.push_back(options.tool_name);
        for (program::Move& move : program.moves) move.tool = 1;
        add(EventKind::tool, true, "T" + options.tool_name, 0);
    }
    if (options.spindle_rad_s > 0) {
        add(EventKind::spindle, false, fmt::format("S{:g}", options.spindle_rad_s * 30 / std::numbers::pi), 0);
        add(EventKind::spindle, true, "M3", 0);
        add(EventKind::spindle, true, "M5", end);
    }
    add(EventKind::stop, true, "M30", end);
}

}  // namespace

surfacing::OrientationLimits lean_limits(const Cutter& cutter, double lead_rad) {
    constexpr double far = 60 * degree, least = 1 * degree;
    const bool keeps_its_sign = !cutter.is_ball() && lead_rad > 0;
    return {.least_lead_rad = keeps_its_sign ? std::min(least, 0.5 * lead_rad) : -far,
            .most_lead_rad = far,
            .most_tilt_rad = far};
}

Result<SurfaceResult> make_surface_program(std::span<const Face> faces, const Cutter& cutter,
                                           const SurfaceProgramOptions& options) {
    const SurfaceOptions passes = options.splines ? close_contacts(options.passes) : options.passes;
    if (options.freeing && passes.leave_out)
        return fail({.code = "PIPE0119", .text = "gouges are either freed or left out, not both"});
    auto planned = options.freeing    ? FreePlanning(faces, cutter, passes, options).run()
                   : passes.leave_out ? planned_within_reach(faces, cutter, passes, options)
                                      : planned_as_it_is(faces, cutter, passes, options);
    if (!planned) return planned;
    SurfaceResult& out = *planned;
    for (const Pass& pass : out.plan.passes) out.contacts += pass.contacts.size();
    if (options.splines) out.splines = PassSplines(faces, cutter, options.passes.chord_tolerance_mm).put_into(out.plan);
    if (out.splines && out.splines->left_straight > 0)
        out.plan.program.diagnostics.push_back({.code = "PIPE0114",
                                                .severity = Severity::warning,
                                                .text = "passes that are written as straight moves, not as splines",
                                                .count = static_cast<int>(out.splines->left_straight)});
    add_events(out.plan.program, options);
    return planned;
}

}  // namespace trunnion::pipeline
