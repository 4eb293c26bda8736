#include <utility>

#include "detail/stand_choice.hpp"

/// Stages at which the rotary axes may go through the pole where the program passes beside it.
namespace trunnion::path::detail {

using machine::RotaryPosition;

namespace {

bool within_some_winding(const machine::Axis& axis, double angle_rad) {
    const double turns = std::ceil((axis.range_min - rotary_slack_rad - angle_rad) / full_turn);
    return std::isinf(axis.range_min) || angle_rad + turns * full_turn <= axis.range_max + rotary_slack_rad;
}

/// Whether the axes have room for a direction on both branches.
bool has_room_on_both(const machine::Machine& machine, const machine::RotarySolutions& solutions) {
    bool room = solutions.count == 2;
    for (int branch = 0; branch < solutions.count; ++branch)
        for (int a = 0; a < machine.rotary_count; ++a)
            room =
                room && within_some_winding(machine.axes[machine.linear_count() + a], solutions.rotary_rad[branch][a]);
    return room;
}

using Tangent = Eigen::Matrix<double, 6, 1>;

Tangent chord(const ToolPose& from, const ToolPose& to) {
    Tangent out;
    out << to.tip_mm - from.tip_mm, reference_height_mm * (to.axis - from.axis);
    return out;
}

/// Smoothing stands still at such a vertex, on the programmed pose.
bool turns_back(const Tangent& before, const Tangent& after) {
    constexpr double cosine = -0.9;
    return before.dot(after) < cosine * before.norm() * after.norm();
}

}  // namespace

/// Where cutting moves from `first` to `last` may be led through the pole.
Result<std::vector<PoleCandidate>> StandChoice::candidates(std::size_t first, std::size_t last, const State& before) {
    if (!(pole_tolerance_rad_ > 0) || machine_.rotary_count < 2) return std::vector<PoleCandidate>{};
    const auto in = surroundings_.of(program_.moves[first]);
    if (!in) return fail(in.error());
    const auto poles = poles_of(*in->kinematics);
    auto pose = pose_before(first, before);
    if (!pose) return fail(pose.error());
    std::vector<VectorBlock> blocks;
    Tangent before_that = Tangent::Zero();
    bool after_curve = false;
    for (std::size_t k = first; k <= last && !poles.empty(); ++k) {
        const auto to = way_.end_of(k, pose->tip_mm);
        if (!to) return fail(to.error());
        if (k > 0 && !is_rapid(k)) {
            const auto poses = way_.between(k, *pose, *to);
            if (!poses) return fail(poses.error());
            const Tangent tangent = chord(*pose, *to);
            // Along a curve that says the tool axis nothing is shifted: it is no great circle.
            const bool at_rest = stop_between(program_, k) != StopCause::corner || turns_back(before_that, tangent) ||
                                 poses->says_axis() || after_curve;
            blocks.push_back({k, poses->says_axis() ? to->axis : pose->axis, to->axis,
                              std::hypot(poses->length_mm(), reference_height_mm * poses->turn_rad()), at_rest});
            before_that = tangent;
            after_curve = poses->says_axis();
        }
        pose = *to;
    }
    auto out = pole_candidates(blocks, poles, pole_tolerance_rad_);
    std::erase_if(out, [&](const PoleCandidate& candidate) {
        const auto& from = blocks[candidate.first - blocks.front().move].from;
        const auto& to = blocks[candidate.last - blocks.front().move].to;
        return !has_room_on_both(machine_, in->kinematics->rotary_for(from)) ||
               !has_room_on_both(machine_, in->kinematics->rotary_for(to));
    });
    return out;
}

/// The moves of law vector from `first` up to the next place of choice, divided where they come near the pole.
Result<std::vector<Stage>> StandChoice::vector_stages(std::size_t first, const State& before) {
    const auto last = end_of_vectors(first);
    if (!last) return fail(last.error());
    auto near_pole = candidates(first, *last, before);
    if (!near_pole) return fail(near_pole.error());
    std::vector<Stage> out;
    std::size_t next = first;
    for (PoleCandidate& candidate : *near_pole) {
        if (candidate.first > next)
            out.push_back({.goes_on = next > first, .first = next, .last = candidate.first - 1});
        next = candidate.last + 1;
        out.push_back({.goes_on = candidate.first > first,
                       .candidate = candidate,
                       .first = candidate.first,
                       .last = candidate.last});
    }
    if (next <= *last) out.push_back({.goes_on = next > first, .first = next, .last = *last});
    return out;
}

/// Around the pole as programmed, and through it.
Result<void> StandChoice::add_ways_past_pole(Stage& stage, const RotaryPosition& standing, const ToolPose& before) {
    const auto around = add_track(stage, Entry::fixed, true, standing, before);
    const Track through{.entry = Entry::fixed, .before_first = true, .through_pole = true, .begin = standing};
    if (!add_track(stage, through, before) && !around) return fail(around.error());
    return {};
}

}  // namespace trunnion::path::detail
