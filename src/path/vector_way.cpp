#include "detail/vector_way.hpp"

#include <fmt/format.h>

namespace trunnion::path::detail {

using machine::Kinematics;
using machine::RotaryPosition;
using machine::RotarySolutions;

Result<ToolPose> VectorWay::end_of(std::size_t move, const Eigen::Vector3d& tip_before_mm) const {
    const program::Move& to = program_->moves[move];
    auto in = surroundings_->of(to);
    if (!in) return fail(in.error());
    Eigen::Vector3d position = to.position_mm;
    if (position.hasNaN())
        position = position.array().isNaN().select(into_offset(*in->offset, tip_before_mm), position);
    return ToolPose{out_of_offset(*in->offset, position), in->offset->rotation * to.axis};
}

Result<PosesBetween> VectorWay::between(std::size_t move, const ToolPose& from, const ToolPose& to) const {
    const program::Move& of = program_->moves[move];
    if (of.curve_part != program::no_curve_part) return along_curve(move, from, to);
    if (geometry::angle_between(from.axis, to.axis) > opposite_rad) return fail(half_a_turn(move));
    if (of.arc == program::no_arc) return PosesBetween(from, to, std::nullopt);
    auto in = surroundings_->of(of);
    if (!in) return fail(in.error());
    const program::Arc& arc = program_->arcs[static_cast<std::size_t>(of.arc)];
    return PosesBetween(from, to,
                        geometry::Helix(from.tip_mm, to.tip_mm, out_of_offset(*in->offset, arc.centre_mm),
                                        in->offset->rotation * arc.normal, arc.angle_rad));
}

Result<PosesBetween> VectorWay::along_curve(std::size_t move, const ToolPose& from, const ToolPose& to) const {
    const program::Move& of = program_->moves[move];
    auto in = surroundings_->of(of);
    if (!in) return fail(in.error());
    CurvePiece curve = surroundings_->curve_of(of);
    if (!curve.orientation && geometry::angle_between(from.axis, to.axis) > opposite_rad)
        return fail(half_a_turn(move));
    curve.position = curve.position.mapped(in->offset->rotation, in->offset->origin_mm);
    if (curve.orientation) curve.orientation = curve.orientation->mapped(in->offset->rotation, Eigen::Vector3d::Zero());
    if (auto fits = fit_ends(curve, {from.tip_mm, from.axis}, {to.tip_mm, to.axis}, true, *program_, of); !fits)
        return fail(fits.error());
    return PosesBetween(from, to, curve);
}

Result<RotarySolutions> VectorWay::solutions_at_end(std::size_t move) const {
    const program::Move& to = program_->moves[move];
    auto in = surroundings_->of(to);
    if (!in) return fail(in.error());
    const auto out = in->kinematics->rotary_for(in->offset->rotation * to.axis);
    if (out.count == 0) return fail(out_of_reach(move));
    return out;
}

std::vector<RotaryPosition> VectorWay::leaving_pole(const Kinematics& kinematics, const ToolPose& from,
                                                    const ToolPose& to) const {
    const geometry::GreatCircle circle(from.axis, to.axis);
    const auto solutions_at = [&](double w) { return kinematics.rotary_for(circle.at(w)); };
    const auto at_pole = solutions_at(0);
    std::vector<RotaryPosition> out;
    for (int branch = 0; branch < solutions_at(1).count; ++branch) {
        const auto side = side_of_pole(kinematics, solutions_at, 0, 1, [&](const RotarySolutions& leaving) {
            return std::optional(solution_of(kinematics, leaving, branch, {}));
        });
        if (side) out.push_back(solution_of(kinematics, at_pole, 0, side->rotary_rad).rotary_rad);
    }
    return out;
}

Diagnostic VectorWay::out_of_reach(std::size_t move) const {
    const program::Move& to = program_->moves[move];
    return at_move(*program_, to, "PATH0101",
                   fmt::format("the machine cannot bring its tool to the direction ({:.6f}, {:.6f}, {:.6f})",
                               to.axis.x(), to.axis.y(), to.axis.z()));
}

Diagnostic VectorWay::half_a_turn(std::size_t move) const {
    return at_move(*program_, program_->moves[move], "PATH0005",
                   "the tool axis is turned by half a turn: the plane is undefined");
}

Diagnostic VectorWay::lost(std::size_t move, const Lost& lost) const {
    if (lost.why == Lost::Why::out_of_reach) {
        auto out = out_of_reach(move);
        out.text += ", or to one on the way there";
        return out;
    }
    return too_close_to_pole(move);
}

Diagnostic VectorWay::too_close_to_pole(std::size_t move) const {
    auto out = at_move(*program_, program_->moves[move], "PATH0103",
                       "the tool axis passes the pole too closely for the rotary axes to follow");
    out.hint = "turn the part on the table, or lead the tool a little to one side";
    return out;
}

}  // namespace trunnion::path::detail
