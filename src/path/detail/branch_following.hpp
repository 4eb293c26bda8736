#pragma once

#include <cmath>
#include <expected>
#include <numbers>
#include <optional>

#include "trunnion/machine/kinematics.hpp"

/// How the rotary axes go along a way of the tool axis: on one branch, without a jump.
namespace trunnion::path::detail {

inline constexpr double full_turn = 2 * std::numbers::pi;
inline constexpr int unknown_branch = -1;  // at the pole, and with fewer than two rotary axes

inline double wound_near(double angle, double near) {
    return near + std::remainder(angle - near, full_turn);
}

/// A position of the rotary axes and the branch it is on: index in RotarySolutions.
struct Followed {
    machine::RotaryPosition rotary_rad{};
    int branch = unknown_branch;
};

/// The larger of the ways of the two axes.
inline double largest_turn(const machine::RotaryPosition& a, const machine::RotaryPosition& b) {
    return std::max(std::abs(a[0] - b[0]), std::abs(a[1] - b[1]));
}

/// One of the solutions in the winding nearest to `near`; at the pole the free axis stays at `near`.
Followed solution_of(const machine::Kinematics& kinematics, const machine::RotarySolutions& solutions, int branch,
                     const machine::RotaryPosition& near);

/// The solution that goes on from `from`: on its branch where that is no farther than `turn_rad`, else the nearest one.
/// Nothing when the orientation is out of reach.
std::optional<Followed> solution_after(const machine::Kinematics& kinematics, const machine::RotarySolutions& solutions,
                                       const Followed& from, double turn_rad);

/// Why a way cannot be followed, and where (the parameter of the way).
struct Lost {
    enum class Why { out_of_reach, too_close_to_pole } why = Why::out_of_reach;
    double at = 0;
};

/// How fine to look: no axis turns more than `half_turn_rad` in half a step; a step shorter than `shortest` (of the
/// way's parameter) that still turns more is given up.
struct FollowingSteps {
    double half_turn_rad = 0, shortest = 0;
};

/// The parameter between `pole` and `off_pole` at which the tool axis is off the pole by `tilt_rad`, or `off_pole`
/// where that is nearer.
template <class SolutionsAt>
double place_of_tilt(const machine::Kinematics& kinematics, const SolutionsAt& solutions_at, double pole,
                     double off_pole, double tilt_rad) {
    constexpr int halvings = 50;
    const auto is_nearer = [&](double place) {
        const auto solutions = solutions_at(place);
        return solutions.degenerate || kinematics.lever(solutions.rotary_rad[0]) < tilt_rad;
    };
    if (is_nearer(off_pole)) return off_pole;
    for (int k = 0; k < halvings; ++k) {
        const double middle = 0.5 * (pole + off_pole);
        (is_nearer(middle) ? pole : off_pole) = middle;
    }
    return off_pole;
}

/// Where the rotary axes are at the pole when a way leaves it, or comes to it.
struct PoleSide {
    machine::RotaryPosition rotary_rad{};
    double rest_rad = 0;  ///< how far the free axis still is from that where it stops being free
};

/// The side on which a way between the pole and a place off it is: `choose(solutions)` says which of the solutions near
/// the pole. The free axis' position at the pole is extrapolated from tilts of 1e-6 and 2e-6 rad: nearer by, the tool
/// axis' own rounding would be felt. Precondition: at the pole at `pole`, not at `off_pole`.
template <class SolutionsAt, class Choose>
std::optional<PoleSide> side_of_pole(const machine::Kinematics& kinematics, const SolutionsAt& solutions_at,
                                     double pole, double off_pole, const Choose& choose) {
    constexpr double far_tilt_rad = 2e-6, near_tilt_rad = 1e-6, edge_tilt_rad = 2e-8;
    const auto tilt = [&](const Followed& at) { return kinematics.lever(at.rotary_rad); };
    const double far = place_of_tilt(kinematics, solutions_at, pole, off_pole, far_tilt_rad);
    const std::optional<Followed> at_far = choose(solutions_at(far));
    if (!at_far) return std::nullopt;
    const auto beside = [&](double tilt_rad) {
        const auto solutions = solutions_at(place_of_tilt(kinematics, solutions_at, pole, far, tilt_rad));
        return solution_after(kinematics, solutions, *at_far, 1);
    };
    const auto at_near = beside(near_tilt_rad), at_edge = beside(edge_tilt_rad);
    if (!at_near || !at_edge) return std::nullopt;
    PoleSide out{at_near->rotary_rad};
    const double spread = tilt(*at_far) - tilt(*at_near);
    for (std::size_t a = 0; a < out.rotary_rad.size() && spread > edge_tilt_rad; ++a)
        out.rotary_rad[a] -= (at_far->rotary_rad[a] - at_near->rotary_rad[a]) * tilt(*at_near) / spread;
    const int free = kinematics.rotary_nearest_workpiece();
    out.rest_rad = std::abs(at_edge->rotary_rad[free] - out.rotary_rad[free]);
    return out;
}

/// A way that bends where the free axis stops being free cannot be followed: the axis would have to start at once.
inline constexpr double most_rest_rad = 1e-7;  // a fiftieth of an arc second: no encoder sees it

/// Goes from one parameter to another, fine enough that the nearest solution is the continuous one: small turns, and no
/// change of branch but at the pole itself. A change of branch between two places is a passage of the pole that was
/// jumped over. A step is only believed when its middle agrees. `solutions_at(u)`: RotarySolutions at a parameter;
/// `on_station(u, Followed)` is called at the end of every step.
template <class SolutionsAt, class OnStation>
std::expected<Followed, Lost> follow(const machine::Kinematics& kinematics, const SolutionsAt& solutions_at,
                                     double from, double to, const Followed& at_from, const FollowingSteps& steps,
                                     OnStation& on_station) {
    const auto continues = [&](const Followed& a, const Followed& b) {
        const bool branch = a.branch == b.branch || a.branch == unknown_branch || b.branch == unknown_branch;
        return branch && largest_turn(a.rotary_rad, b.rotary_rad) < steps.half_turn_rad;
    };
    bool bends_at_pole = false;
    const auto side_between = [&](double pole, double off_pole, const Followed& near) {
        const auto side = side_of_pole(kinematics, solutions_at, pole, off_pole, [&](const auto& beside) {
            return solution_after(kinematics, beside, near, steps.half_turn_rad);
        });
        bends_at_pole = bends_at_pole || (side && side->rest_rad > most_rest_rad);
        return side;
    };
    const auto next = [&](double place, double before, const Followed& at_before) -> std::optional<Followed> {
        const auto solutions = solutions_at(place);
        auto out = solution_after(kinematics, solutions, at_before, steps.half_turn_rad);
        if (!out || (!solutions.degenerate && at_before.branch != unknown_branch)) return out;
        const bool was_at_pole = solutions_at(before).degenerate;
        if (solutions.degenerate == was_at_pole) return out;
        // The free axis arrives where the way comes from beside the pole, not where it was a step before, and has to
        // leave where it arrived.
        if (solutions.degenerate) {
            const auto side = side_between(place, before, at_before);
            return side ? solution_of(kinematics, solutions, 0, side->rotary_rad) : out;
        }
        const auto side = side_between(before, place, at_before);
        bends_at_pole = bends_at_pole || (side && largest_turn(side->rotary_rad, at_before.rotary_rad) > most_rest_rad);
        return out;
    };
    const double middle = 0.5 * (from + to);
    const auto at_middle = next(middle, from, at_from);
    if (!at_middle) return std::unexpected(Lost{Lost::Why::out_of_reach, middle});
    const auto at_end = next(to, middle, *at_middle);
    if (!at_end) return std::unexpected(Lost{Lost::Why::out_of_reach, to});
    if (continues(at_from, *at_middle) && continues(*at_middle, *at_end)) {
        if (bends_at_pole) return std::unexpected(Lost{Lost::Why::too_close_to_pole, from});
        on_station(to, *at_end);
        return *at_end;
    }
    if (to - from < steps.shortest) return std::unexpected(Lost{Lost::Why::too_close_to_pole, from});
    const auto half = follow(kinematics, solutions_at, from, middle, at_from, steps, on_station);
    if (!half) return half;
    return follow(kinematics, solutions_at, middle, to, *half, steps, on_station);
}

}  // namespace trunnion::path::detail
