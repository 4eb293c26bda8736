#include "trunnion/pipeline/surface_motion.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include <Eigen/Geometry>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "trunnion/base/quantity.hpp"
#include "trunnion/geometry/great_circle.hpp"
#include "trunnion/surfacing/orientation_surface.hpp"

#include "detail/freed_json.hpp"
#include "detail/surface_motion_mover.hpp"

namespace trunnion::pipeline {

using interpolation::SurfaceTool;
using program::Program;
using program::RotaryStand;
using surfacing::Pass;

namespace {

constexpr double axis_misfit_rad = 0.5 * degree, stand_slack_rad = 1e-6;

/// Moves of a program in which a pass is gone: the one that ends at its first contact, and its last one.
struct MoveSpan {
    std::size_t first, last;
};

bool ends_at(const program::Move& move, const surfacing::Contact& contact) {
    return move.position_mm == contact.pose.tip_mm && move.axis == contact.pose.axis;
}

/// Where the passes lie in the program, in order. PIPE0130.
Result<std::vector<MoveSpan>> spans_of(const surfacing::SurfacePlan& plan) {
    std::vector<MoveSpan> out;
    const auto& moves = plan.program.moves;
    std::size_t at = 0;
    for (const Pass& pass : plan.passes) {
        while (at < moves.size() && !ends_at(moves[at], pass.contacts.front())) ++at;
        const MoveSpan span{at, at + pass.contacts.size() - 1};
        bool fits = span.last < moves.size();
        for (std::size_t k = 0; fits && k < pass.contacts.size(); ++k) fits = ends_at(moves[at + k], pass.contacts[k]);
        if (!fits)
            return fail(
                {.code = "PIPE0130",
                 .text = fmt::format("the program of a surface plan does not go through its pass {}", out.size() + 1)});
        out.push_back(span);
        at = span.last + 1;
    }
    return out;
}

/// Moves from one index to another, the first one as the pose where motion starts.
Program part_of(const Program& whole, std::size_t first, std::size_t last) {
    Program out{.name = whole.name,
                .source = whole.source,
                .dialect = whole.dialect,
                .tools = whole.tools,
                .offsets = whole.offsets};
    out.moves.assign(whole.moves.begin() + static_cast<std::ptrdiff_t>(first),
                     whole.moves.begin() + static_cast<std::ptrdiff_t>(last) + 1);
    return out;
}

std::vector<RotaryStand> part_of(const std::vector<RotaryStand>& whole, std::size_t first, std::size_t last) {
    return {whole.begin() + static_cast<std::ptrdiff_t>(first), whole.begin() + static_cast<std::ptrdiff_t>(last) + 1};
}

/// How far a contact's axis is from that of a tool with a lead and tilt, fed towards the next contact.
double misfit_rad(const surfacing::Contact& at, const surfacing::Contact& next, const SurfaceTool& tool) {
    const Eigen::Vector3d way = next.point_mm - at.point_mm;
    const Eigen::Vector3d t = (way - way.dot(at.normal) * at.normal).normalized();
    const Eigen::Vector3d axis = at.normal + std::tan(tool.lead_rad) * t + std::tan(tool.tilt_rad) * at.normal.cross(t);
    return geometry::angle_between(axis, at.pose.axis);
}

Result<SurfaceTool> on_orientation(const Pass& pass, const surfacing::Cutter& cutter) {
    const surfacing::OrientationSurface& orientation = *pass.orientation;
    double largest = 0;
    for (const surfacing::Contact& at : pass.contacts)
        largest = std::max(largest, geometry::angle_between(orientation.axis(at.place), at.pose.axis));
    if (largest > 2 * orientation.slack_rad())
        return fail({.code = "PIPE0132",
                     .text = "the poses of a pass are not those of its orientation surface",
                     .value = fmt::format("{:.3f} deg", largest / degree),
                     .limit = fmt::format("{:.3f} deg", 2 * orientation.slack_rad() / degree)});
    return SurfaceTool{
        .radius_mm = cutter.radius_mm(), .corner_mm = cutter.corner_mm(), .orientation = &orientation.surface()};
}

/// The tool as it stands on a pass: tilt is the same way in passes to and fro, so seen from the feed its sign changes.
/// PIPE0132.
Result<SurfaceTool> tool_on(const Pass& pass, const surfacing::Cutter& cutter,
                            const surfacing::SurfaceOptions& surface) {
    if (pass.orientation) return on_orientation(pass, cutter);
    SurfaceTool tool{cutter.radius_mm(), cutter.corner_mm(), surface.lead_rad, surface.tilt_rad};
    SurfaceTool other = tool;
    other.tilt_rad = -tool.tilt_rad;
    const auto largest = [&](const SurfaceTool& one) {
        double out = 0;
        for (std::size_t k = 0; k + 1 < pass.contacts.size(); ++k)
            out = std::max(out, misfit_rad(pass.contacts[k], pass.contacts[k + 1], one));
        return out;
    };
    // Towards the next contact is half a step's turn of the feed off.
    const double bent = pass.contacts.size() > 2 ? 0.1 : 0.2;
    const double own = largest(tool), turned = largest(other);
    const double allowed = axis_misfit_rad + bent * std::hypot(std::tan(tool.lead_rad), std::tan(tool.tilt_rad));
    if (std::min(own, turned) > allowed)
        return fail({.code = "PIPE0132",
                     .text = "the poses of a pass do not have the lead and tilt of the options",
                     .value = fmt::format("{:.3f} deg", std::min(own, turned) / degree),
                     .limit = fmt::format("{:.3f} deg", allowed / degree)});
    return own <= turned ? tool : other;
}

Result<interpolation::SurfaceCurve> curve_of_pass(const Pass& pass, std::span<const surfacing::Face> faces,
                                                  const SurfaceTool& tool, double tolerance_mm) {
    std::vector<geometry::SurfacePlace> places;
    for (const surfacing::Contact& contact : pass.contacts) places.push_back(contact.place);
    return curve_of(faces[static_cast<std::size_t>(pass.contacts.front().face)], places, tool, tolerance_mm);
}

void set_pose(program::Move& move, const machine::Pose& pose) {
    move.position_mm = pose.tip_in_workpiece_mm;
    move.axis = pose.axis_in_workpiece;
}

/// Passes of a plan, with the links between them led exactly to where the curves begin and end.
class PassPlanner {
  public:
    PassPlanner(const surfacing::SurfacePlan& plan, const machine::Machine& machine, const machine::Setup& setup,
                std::vector<RotaryStand> stands, SurfaceMotionPlanner& planner)
        : plan_(plan), machine_(machine), setup_(setup), stands_(std::move(stands)), planner_(planner) {}

    Result<void> pass(const interpolation::SurfaceCurve& curve, const MoveSpan& span, double feed_mm_s) {
        const machine::Pose begin = curve.pose(curve.contact(curve.begin()));
        if (auto linked = link_to(span.first, &begin); !linked) return linked;
        const auto moved =
            planner_.pass(curve, feed_mm_s, plan_.program.moves[span.last].line, stands_[span.first].rotary_rad);
        at_ = span.last;
        end_ = curve.pose(curve.contact(curve.end()));
        return moved;
    }
    Result<void> finish() { return link_to(plan_.program.moves.size() - 1, nullptr); }

  private:
    Result<void> link_to(std::size_t last, const machine::Pose* to) {
        if (at_ == last) return {};
        if (auto chosen = stand_where_the_pass_ended(); !chosen) return chosen;
        Program part = part_of(plan_.program, at_, last);
        if (end_) set_pose(part.moves.front(), *end_);
        if (to) set_pose(part.moves.back(), *to);
        return planner_.link(part, part_of(stands_, at_, last));
    }

    /// Between its contacts a pass may go round a pole on the other side than straight moves do; then the axes stand a
    /// turn away from where these end, and what is behind begins from there.
    Result<void> stand_where_the_pass_ended() {
        const auto standing = planner_.standing();
        if (!standing) return {};
        bool there = true;
        for (int a = 0; a < machine_.rotary_count; ++a)
            there = there && std::abs((*standing)[a] - stands_[at_].rotary_rad[a]) < stand_slack_rad;
        if (there) return {};
        Program rest = part_of(plan_.program, at_, plan_.program.moves.size() - 1);
        set_pose(rest.moves.front(), *end_);
        const auto stands = surface_stands(rest, machine_, setup_, standing);
        if (!stands) return fail(stands.error());
        std::ranges::copy(*stands, stands_.begin() + static_cast<std::ptrdiff_t>(at_));
        return {};
    }

    const surfacing::SurfacePlan& plan_;
    const machine::Machine& machine_;
    const machine::Setup& setup_;
    std::vector<RotaryStand> stands_;
    SurfaceMotionPlanner& planner_;
    std::size_t at_ = 0;
    std::optional<machine::Pose> end_;  // of the pass before
};

}  // namespace

Result<SurfaceMotionSummary> move_surface(const surfacing::SurfacePlan& plan, std::span<const surfacing::Face> faces,
                                          const surfacing::SurfaceOptions& surface, const machine::Machine& machine,
                                          const machine::Setup& setup, const SurfaceMotionOptions& options,
                                          PlanObserver& observer) {
    if (auto sound = check_motion_options(options); !sound) return fail(sound.error());
    const auto cutter = surfacing::Cutter::make(setup.tool);
    if (!cutter) return fail(cutter.error());
    const auto spans = spans_of(plan);
    if (!spans) return fail(spans.error());
    const auto kinematics = machine::Kinematics::make(machine, setup.workpiece, setup.tool.length_mm);
    if (!kinematics) return fail(kinematics.error());
    auto stands = surface_stands(plan.program, machine, setup);
    if (!stands) return fail(stands.error());
    const auto plan_all = [&](const SurfaceMotionPlanner::Sink& sink) -> Result<void> {
        SurfaceMotionPlanner planner(machine, setup, *kinematics, options, sink);
        PassPlanner passes(plan, machine, setup, *std::move(stands), planner);
        for (std::size_t k = 0; k < plan.passes.size(); ++k) {
            const auto tool = tool_on(plan.passes[k], *cutter, surface);
            if (!tool) return fail(tool.error());
            const auto curve = curve_of_pass(plan.passes[k], faces, *tool, options.place_tolerance_mm);
            if (!curve) return fail(curve.error());
            if (auto moved = passes.pass(*curve, (*spans)[k], surface.feed_mm_s); !moved) return moved;
            planner.at_share(static_cast<double>(k + 1) / static_cast<double>(plan.passes.size()));
        }
        return passes.finish();
    };
    SurfaceMover mover(machine, setup, options, observer);
    if (auto moved = move_as_planned(plan_all, mover, observer, options.plan.threads); !moved)
        return fail(moved.error());
    return mover.finish();
}

Result<std::vector<verify::ProgrammedPose>> programmed_poses(const surfacing::SurfacePlan& plan,
                                                             const machine::Machine& machine,
                                                             const machine::Setup& setup) {
    const auto stands = surface_stands(plan.program, machine, setup);
    if (!stands) return fail(stands.error());
    return verify::programmed_poses(plan.program, machine, setup, *stands);
}

namespace {

std::string part_line(const SurfacePartCheck& part) {
    if (!part.in_part) return fmt::format("the tool goes into none of the part's {} faces\n", part.faces);
    const auto& in = *part.in_part;
    return fmt::format("NOT USABLE: THE {} GOES {:.4g} mm INTO face {} at ({:.3f} {:.3f} {:.3f})\n",
                       in.by_holder ? "HOLDER" : "TOOL", in.depth_mm, part.in_part_face, in.at_mm.x(), in.at_mm.y(),
                       in.at_mm.z());
}

std::string freed_line(const FreedAccount& freed) {
    if (!freed.worst) return "no gouges before anything was changed\n";
    return fmt::format("{} passes freed of gouges: deepest {:.4g} mm before; turned by {:.2f} deg at most, {} rounds\n",
                       freed.passes_turned, freed.worst->depth_mm, freed.largest_turn_rad / degree, freed.rounds);
}

nlohmann::ordered_json part_json(const SurfacePartCheck& part) {
    nlohmann::ordered_json in_part;
    if (const auto& in = part.in_part)
        in_part = {{"depth_mm", in->depth_mm},
                   {"face", part.in_part_face},
                   {"at_mm", point_json(in->at_mm)},
                   {"by_holder", in->by_holder}};
    return {{"faces", part.faces}, {"in_part", in_part}};
}

}  // namespace

std::string SurfaceMotionSummary::report() const {
    std::string out = motion.report();
    if (freed) out += freed_line(*freed);
    out += fmt::format("{} passes on the surface, {:.1f} mm in {:.3f} s, {:.1f} % of it at the programmed feed\n",
                       passes, pass_way_mm, pass_time_s, 100 * constant_feed_share);
    if (bridged_mm > 0)
        out += fmt::format("{:.1f} mm over knots of the surface and poles, up to {:.3f} um and {:.5f} deg off it\n",
                           bridged_mm, 1e3 * bridge_tip_mm, bridge_axis_rad / degree);
    out += fmt::format("first setpoints after {:.1f} ms; planned at least {:.2f} s ahead from then on\n",
                       1e3 * first_ready_s, least_ahead_s);
    if (part) out += part_line(*part);
    return out;
}

std::string to_json(const SurfaceMotionSummary& summary) {
    auto out = nlohmann::ordered_json::parse(to_json(summary.motion));
    out["surface"] = {{"passes", summary.passes},
                      {"pass_time_s", summary.pass_time_s},
                      {"pass_way_mm", summary.pass_way_mm},
                      {"constant_feed_share", summary.constant_feed_share},
                      {"fit_tip_mm", summary.fit_tip_mm},
                      {"fit_axis_deg", summary.fit_axis_rad / degree},
                      {"bridge_tip_mm", summary.bridge_tip_mm},
                      {"bridge_axis_deg", summary.bridge_axis_rad / degree},
                      {"bridged_mm", summary.bridged_mm},
                      {"first_ready_s", summary.first_ready_s},
                      {"least_ahead_s", summary.least_ahead_s},
                      {"freed", summary.freed ? freed_json(*summary.freed) : nlohmann::ordered_json(nullptr)},
                      {"part", summary.part ? part_json(*summary.part) : nlohmann::ordered_json(nullptr)}};
    out["usable"] = summary.usable();
    return out.dump(2) + "\n";
}

}  // namespace trunnion::pipeline
