#include "detail/branch_following.hpp"

#include <algorithm>

namespace trunnion::path::detail {

using machine::Kinematics;
using machine::RotaryPosition;
using machine::RotarySolutions;

Followed solution_of(const Kinematics& kinematics, const RotarySolutions& solutions, int branch,
                     const RotaryPosition& near) {
    Followed out{solutions.rotary_rad[branch], solutions.count == 2 ? branch : unknown_branch};
    if (solutions.degenerate) {
        const int free = kinematics.rotary_nearest_workpiece();
        out = {out.rotary_rad, unknown_branch};
        out.rotary_rad[free] = near[free];
    }
    for (int a = 0; a < kinematics.rotary_count(); ++a) out.rotary_rad[a] = wound_near(out.rotary_rad[a], near[a]);
    return out;
}

std::optional<Followed> solution_after(const Kinematics& kinematics, const RotarySolutions& solutions,
                                       const Followed& from, double turn_rad) {
    if (solutions.count == 0) return std::nullopt;
    const Followed first = solution_of(kinematics, solutions, 0, from.rotary_rad);
    if (solutions.count == 1) return first;
    const Followed second = solution_of(kinematics, solutions, 1, from.rotary_rad);
    if (from.branch != unknown_branch) {
        const Followed& same = from.branch == 0 ? first : second;
        if (largest_turn(same.rotary_rad, from.rotary_rad) < turn_rad) return same;
    }
    const auto way = [&](const Followed& to) {
        return std::abs(to.rotary_rad[0] - from.rotary_rad[0]) + std::abs(to.rotary_rad[1] - from.rotary_rad[1]);
    };
    return way(first) <= way(second) ? first : second;
}

}  // namespace trunnion::path::detail
