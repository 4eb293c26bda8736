#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

#include "trunnion/base/quantity.hpp"
#include "trunnion/geometry/great_circle.hpp"
#include "trunnion/geometry/helix.hpp"

#include "detail/branch_following.hpp"
#include "detail/surroundings.hpp"

namespace trunnion::path::detail {

/// The tool in the frame of the setup's workpiece.
struct ToolPose {
    Eigen::Vector3d tip_mm = Eigen::Vector3d::Zero(), axis = Eigen::Vector3d::UnitZ();
};

/// The poses of one move as functions of w ∈ [0, 1]: the share of its length, along a curve the share of u.
class PosesBetween {
  public:
    PosesBetween(const ToolPose& from, const ToolPose& to, std::optional<geometry::Helix> arc)
        : from_mm_(from.tip_mm), to_(to), circle_(from.axis, to.axis), arc_(std::move(arc)) {}
    PosesBetween(const ToolPose& from, const ToolPose& to, const CurvePiece& curve)
        : from_mm_(from.tip_mm),
          to_(to),
          circle_(curve.orientation ? to.axis : from.axis, to.axis),  // one it says nothing of is not asked for
          curve_(curve) {}

    double turn_rad() const { return says_axis() ? curve_->orientation->polygon_turn() : circle_.angle_rad(); }
    double length_mm() const {
        if (curve_) return curve_->position.polygon_length();
        return arc_ ? arc_->length() : (to_.tip_mm - from_mm_).norm();
    }
    bool says_axis() const { return curve_ && curve_->orientation; }
    /// So many that what lies between can be followed from part to part.
    double parts_to_look_at() const {
        constexpr double look_every_rad = 5 * degree, least_of_curve = 4;
        if (arc_) return std::ceil(std::abs(arc_->angle_rad()) / look_every_rad);
        return curve_ ? std::max(least_of_curve, std::ceil(turn_rad() / look_every_rad)) : 1;
    }
    Eigen::Vector3d axis_at(double w) const {
        if (w == 1) return to_.axis;
        return says_axis() ? curve_->orientation->at(w).normalized() : circle_.at(w);
    }
    Eigen::Vector3d tip_at(double w) const {
        if (curve_) return curve_->position.at(w);
        return arc_ ? arc_->at(w) : Eigen::Vector3d(from_mm_ + w * (to_.tip_mm - from_mm_));
    }
    ToolPose at(double w) const { return {tip_at(w), axis_at(w)}; }

  private:
    Eigen::Vector3d from_mm_;
    ToolPose to_;
    geometry::GreatCircle circle_;
    std::optional<geometry::Helix> arc_;
    std::optional<CurvePiece> curve_;
};

/// The rotary axes on a way from pose to pose.
struct AlongWay {
    Followed at;
    int last_branch = unknown_branch;  ///< the one before the pole, while there
};

/// Moves of law vector as programmed, pose by pose, with the rotary axes followed along.
class VectorWay {
  public:
    VectorWay(const program::Program& program, Surroundings& surroundings)
        : program_(&program), surroundings_(&surroundings) {}

    /// The pose at the end of a move that begins with the tip at `tip_before_mm`.
    Result<ToolPose> end_of(std::size_t move, const Eigen::Vector3d& tip_before_mm) const;

    /// Errors: PATH0005 opposite tool axes, where nothing says how to turn.
    Result<PosesBetween> between(std::size_t move, const ToolPose& from, const ToolPose& to) const;

    /// The solutions at a move's end.
    Result<machine::RotarySolutions> solutions_at_end(std::size_t move) const;

    /// On which sides a move leaves the pole at which it begins: the positions there, one a branch, in the winding
    /// nearest to 0. Precondition: `from` is at the pole, `to` is not.
    std::vector<machine::RotaryPosition> leaving_pole(const machine::Kinematics& kinematics, const ToolPose& from,
                                                      const ToolPose& to) const;

    /// Goes along one move. `at_begin`: where the axes stand at its beginning; moved to where the path leaves the pole
    /// when it begins there. `on_place(rotary, tip, kinematics)` is called every 2° of turn and at the end.
    template <class OnPlace>
    Result<void> go(std::size_t move, const ToolPose& from, const ToolPose& to, AlongWay& along,
                    machine::RotaryPosition& at_begin, OnPlace&& on_place) const;

    Diagnostic out_of_reach(std::size_t move) const;
    Diagnostic too_close_to_pole(std::size_t move) const;

  private:
    static constexpr double look_every_rad = 2 * degree;
    static constexpr double shortest_step = 1e-13;  // of a move
    static constexpr double opposite_rad = 3.14159265;

    Result<PosesBetween> along_curve(std::size_t move, const ToolPose& from, const ToolPose& to) const;
    Diagnostic lost(std::size_t move, const Lost& lost) const;
    Diagnostic half_a_turn(std::size_t move) const;
    template <class SolutionsAt>
    static std::optional<PoleSide> leave_pole(const machine::Kinematics& kinematics, const SolutionsAt& solutions_at,
                                              const AlongWay& along);

    const program::Program* program_;
    Surroundings* surroundings_;
};

/// Straight through the pole the free axis stays; with a corner there the path will be rounded past the pole on the
/// inner side, on the branch on which it came.
template <class SolutionsAt>
std::optional<PoleSide> VectorWay::leave_pole(const machine::Kinematics& kinematics, const SolutionsAt& solutions_at,
                                              const AlongWay& along) {
    constexpr double straight_rad = 1e-5;
    const machine::RotaryPosition before = along.at.rotary_rad;
    return side_of_pole(kinematics, solutions_at, 0, 1, [&](const machine::RotarySolutions& leaving) {
        auto nearest = solution_after(kinematics, leaving, {before}, 0);
        if (nearest && along.last_branch != unknown_branch && leaving.count == 2 &&
            largest_turn(nearest->rotary_rad, before) > straight_rad)
            nearest = solution_of(kinematics, leaving, along.last_branch, before);
        return nearest;
    });
}

template <class OnPlace>
Result<void> VectorWay::go(std::size_t move, const ToolPose& from, const ToolPose& to, AlongWay& along,
                           machine::RotaryPosition& at_begin, OnPlace&& on_place) const {
    const program::Move& to_move = program_->moves[move];
    auto in = surroundings_->of(to_move);
    if (!in) return fail(in.error());
    const machine::Kinematics& kinematics = *in->kinematics;
    const auto at_end = kinematics.rotary_for(to.axis);
    if (at_end.count == 0) return fail(out_of_reach(move));
    const auto arrive = [&](const Followed& there, const Eigen::Vector3d& tip_mm) {
        along.at = there;
        if (there.branch != unknown_branch) along.last_branch = there.branch;
        on_place(there.rotary_rad, tip_mm, kinematics);
    };
    // Short turns well off the pole, the rule in dense programs: nothing can happen between.
    constexpr double well_off = 10, short_turn_rad = 0.01;
    const double turn = (to.axis - from.axis).norm();
    const bool straight = to_move.arc == program::no_arc && to_move.curve_part == program::no_curve_part;
    if (straight && turn < short_turn_rad && !at_end.degenerate &&
        kinematics.lever(along.at.rotary_rad) > well_off * turn) {
        const auto next = solution_after(kinematics, at_end, along.at, look_every_rad / 2);
        if (next->branch == along.at.branch &&
            largest_turn(next->rotary_rad, along.at.rotary_rad) < look_every_rad / 2) {
            arrive(*next, to.tip_mm);
            return {};
        }
    }
    const auto poses = between(move, from, to);
    if (!poses) return fail(poses.error());
    const auto solutions_at = [&](double w) { return kinematics.rotary_for(poses->axis_at(w)); };
    const double parts = poses->parts_to_look_at();
    if (!at_end.degenerate && solutions_at(0).degenerate) {
        const auto side = leave_pole(kinematics, solutions_at, along);
        if (!side) return fail(out_of_reach(move));
        at_begin = solution_of(kinematics, solutions_at(0), 0, side->rotary_rad).rotary_rad;
        along.at = {at_begin, unknown_branch};
    }
    const auto on_station = [&](double w, const Followed& there) { arrive(there, poses->tip_at(w)); };
    for (double part = 1; part <= parts; ++part) {
        const double begin = (part - 1) / parts, end = part / parts;
        const auto followed =
            follow(kinematics, solutions_at, begin, end, along.at, {look_every_rad / 2, shortest_step}, on_station);
        if (!followed) return fail(lost(move, followed.error()));
    }
    return {};
}

}  // namespace trunnion::path::detail
