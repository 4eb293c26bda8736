#include <string_view>

#include <fmt/format.h>

#include "detail/stand_choice.hpp"

/// Why no choice of rotary stands is left, and what would help.
namespace trunnion::path::detail {

using machine::AxisPosition;
using machine::Kinematics;
using machine::RotaryPosition;

Result<Excess> StandChoice::first_excess(const Stage& stage, const Track& track, const std::array<double, axes>& turns,
                                         const ToolPose& before) {
    Excess out;
    RotaryPosition at_end_before = shifted(track.begin, turns), last = at_end_before;
    std::size_t at_move = stage.first;
    const auto look = [&](std::size_t move, const RotaryPosition& at, const Eigen::Vector3d& tip, const Kinematics& k) {
        if (out.found()) return;
        if (move != at_move) at_end_before = last;
        at_move = move;
        last = shifted(at, turns);
        const AxisPosition q = position(k, tip, last);
        if (const auto axis = outside(q)) out = {move, *axis, q[static_cast<std::size_t>(*axis)], at_end_before};
    };
    if (auto walked = walk(stage, track, before, look); !walked) return fail(walked.error());
    return out;
}

/// Whole turns to look at from a place on: near where the axes stand, and where it can be so that they are inside.
std::vector<std::array<double, axes>> StandChoice::turns_to_try(const RotaryPosition& begin,
                                                                const RotaryPosition& standing,
                                                                bool only_inside) const {
    constexpr double most = 2;
    std::array<std::vector<double>, axes> each;
    for (int a = 0; a < axes; ++a) {
        const double nearest = std::round((standing[a] - begin[a]) / full_turn);
        if (a < machine_.rotary_count) {
            const machine::Axis& range = machine_.axes[machine_.linear_count() + a];
            for (double k = nearest - most; k <= nearest + most; ++k) {
                const double at = begin[a] + k * full_turn;
                if (at >= range.range_min - rotary_slack_rad && at <= range.range_max + rotary_slack_rad)
                    each[a].push_back(k);
            }
        }
        if (each[a].empty() && (!only_inside || a >= machine_.rotary_count)) each[a] = {nearest};
    }
    std::vector<std::array<double, axes>> out;
    for (const double k0 : each[0])
        for (const double k1 : each[1]) out.push_back({k0, k1});
    return out;
}

/// Why no choice is left: the way that lasts longest, and what would help there.
Result<Diagnostic> StandChoice::explain(Stage& stage, const State& before) {
    const auto pose = pose_before(stage.first, before);
    if (!pose) return fail(pose.error());
    const RotaryPosition standing = rotary_of(machine_, before.end);
    Excess longest;
    bool any = false;
    for (const Track& track : stage.tracks)
        for (const auto& turns : turns_to_try(track.begin, standing, false)) {
            if (track.entry == Entry::fixed && way_of(shifted(track.begin, turns), standing) > same_position) continue;
            const auto excess = first_excess(stage, track, turns, *pose);
            if (!excess) return fail(excess.error());
            if (excess->found() && (!any || excess->move > longest.move)) longest = *excess;
            any = any || excess->found();
        }
    if (!any) {
        auto out = at_move(program_, program_.moves[stage.first], "PATH0102",
                           "an axis leaves its range while the rotary axes turn to where the next moves need them");
        out.hint = "retract farther before, or turn the part on the table";
        return out;
    }
    const machine::Axis& axis = machine_.axes[longest.axis];
    const double unit = axis.rotary ? degree : 1.0;
    const char* name = axis.rotary ? "deg" : "mm";
    auto out =
        at_move(program_, program_.moves[longest.move], "PATH0102",
                fmt::format("axis {} leaves its range, whatever branch and winding the rotary axes take", axis.letter));
    out.value = fmt::format("{} = {:.4f} {}", axis.letter, longest.value / unit, name);
    out.limit = fmt::format("{:.4f} … {:.4f} {}", axis.range_min / unit, axis.range_max / unit, name);
    auto hint = remedy(stage, longest, *pose);
    if (!hint) return fail(hint.error());
    out.hint = std::move(*hint);
    return out;
}

/// The retract and turn after which the axes stay inside longest. Every way that lasts beyond the excess is also there
/// at the end of the move before it, so that is the last place to retract.
Result<std::string> StandChoice::remedy(const Stage& stage, const Excess& excess, const ToolPose& before) {
    constexpr std::string_view nothing =
        "no retract and turn of the rotary axes would do; check the setup's origin and tool length, or turn the part "
        "on the table";
    if (excess.move == stage.first) return std::string(nothing);
    ToolPose pose = before;
    for (std::size_t k = stage.first; k < excess.move; ++k) {
        const auto next = way_.end_of(k, pose.tip_mm);
        if (!next) return fail(next.error());
        pose = *next;
    }
    const Stage rest{.first = excess.move, .last = stage.last};
    const auto in = surroundings_.of(program_.moves[rest.first]);
    if (!in) return fail(in.error());
    const auto solutions = in->kinematics->rotary_for(pose.axis);
    Excess longest{.move = excess.move};
    RotaryPosition best{};
    for (int branch = 0; branch < solutions.count; ++branch) {
        const RotaryPosition near = solution_of(*in->kinematics, solutions, branch, excess.before).rotary_rad;
        for (const auto& turns : turns_to_try(near, excess.before, true)) {
            const RotaryPosition begin = shifted(near, turns);
            const Track track{.entry = Entry::fixed, .before_first = true, .begin = begin};
            const auto end = first_excess(rest, track, {}, pose);
            if (!end) return fail(end.error());
            const bool nearer = end->move == longest.move && end->move != excess.move &&
                                way_of(begin, excess.before) < way_of(best, excess.before);
            if (end->move > longest.move || nearer) longest = *end, best = begin;
        }
    }
    if (longest.move == excess.move) return std::string(nothing);
    std::string standing, turning;
    for (int a = 0; a < machine_.rotary_count; ++a) {
        const double from = excess.before[a], by = best[a] - from;
        if (std::abs(by) < same_position) continue;
        const char letter = machine_.axes[machine_.linear_count() + a].letter;
        const char* joint = standing.empty() ? "" : ", ";
        standing += fmt::format("{}{} at {:.4g} deg", joint, letter, from / degree);
        turning += fmt::format("{}turn {} by {:.4g} deg to {:.4g} deg", joint, letter, by / degree, best[a] / degree);
    }
    const std::size_t last = longest.found() ? longest.move - 1 : stage.last;
    return fmt::format("retract before line {} ({}), {}, and go on: then the axes stay in range up to line {}",
                       program_.moves[excess.move].line, standing, turning, program_.moves[last].line);
}

}  // namespace trunnion::path::detail
