#include "trunnion/deformation/reduce_rotary.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "trunnion/base/quantity.hpp"

#include "detail/axis_vectors.hpp"
#include "detail/followed_path.hpp"
#include "detail/orientation_limits.hpp"
#include "detail/rotary_fit.hpp"
#include "detail/spline_equations.hpp"

namespace trunnion::deformation {

using detail::OrientationLimits;
using Eigen::Vector3d;

namespace {

constexpr int looks = 16;            // a knot interval
constexpr double rounding = 1e-9;    // of a limit that a path just keeps
constexpr double slower = 1 + 1e-6;  // of the time: what it is known to
constexpr std::array<double, 9> shares{1, 0.99, 0.97, 0.94, 0.9, 0.8, 0.6, 0.4, 0.2};  // of the way to what came out

Result<void> check_freedom(const DualPath& path, const Machining& machining, const OrientationFreedom& freedom) {
    if (auto ok = detail::check_cubic(path); !ok) return ok;
    if (auto ok = detail::check_machining(machining); !ok) return ok;
    if (machining.machine.rotary_count == 0)
        return fail({.code = "DEFO0206", .text = "the machine has no rotary axis whose motion could be reduced"});
    Diagnostic out{.code = "DEFO0202"};
    if (!(freedom.orientation_tolerance_rad > 0) || !std::isfinite(freedom.orientation_tolerance_rad)) {
        out.text = "the orientation tolerance is not above 0";
        out.value = fmt::format("{} deg", freedom.orientation_tolerance_rad / degree);
        return fail(std::move(out));
    }
    for (const AngleRange& range : {freedom.lead, freedom.tilt})
        if (freedom.surface_normal && !(range.least_rad <= range.most_rad)) {
            out.text = "the range of lead or tilt is empty";
            out.value = fmt::format("{} … {} deg", range.least_rad / degree, range.most_rad / degree);
            return fail(std::move(out));
        }
    return {};
}

/// The largest excess over any limit, where it is, and the least clearance.
struct Worst {
    double excess = -HUGE_VAL, u = 0, clearance_mm = HUGE_VAL;
    std::size_t limit = 0;
};

Worst worst_of(const DualPath& path, const OrientationLimits& limits, bool with_clearance) {
    const std::vector<double> at = stations_of(path.spline.bottom().knots());
    Worst out;
    for (std::size_t k = 0; k + 1 < at.size(); ++k)
        for (int i = 0; i <= looks; ++i) {
            const double u = at[k] + (at[k + 1] - at[k]) * i / looks;
            const auto place = limits.at(u);
            const Vector3d axis = path.at(u).axis_in_workpiece;
            const auto excess = limits.excess(place, axis);
            const auto largest = std::ranges::max_element(excess);
            if (*largest > out.excess) {
                out.excess = *largest;
                out.u = u;
                out.limit = static_cast<std::size_t>(largest - excess.begin());
            }
            if (with_clearance) out.clearance_mm = std::min(out.clearance_mm, limits.clearance_mm(place, axis));
        }
    if (!with_clearance) out.clearance_mm = 0;
    return out;
}

Diagnostic outside(const DualPath& path, const Worst& worst) {
    static constexpr std::array<const char*, OrientationLimits::count> names{
        "orientation", "least lead", "largest lead", "least tilt", "largest tilt", "clearance"};
    const Vector3d tip = path.at(worst.u).tip_in_workpiece_mm;
    Diagnostic out{.code = "DEFO0205"};
    out.text = fmt::format("the path given is already outside of its freedom ({}) at the tip ({:.3f}, {:.3f}, {:.3f})",
                           names[worst.limit], tip.x(), tip.y(), tip.z());
    out.hint = "widen the range, or begin with a path inside of it";
    return out;
}

DualPath drawn_back(const DualPath& path, const std::vector<Vector3d>& vectors, double share, double height_mm) {
    std::vector<Vector3d> out = detail::axis_vectors(path);
    for (std::size_t i = 0; i < out.size(); ++i)
        if (vectors[i] != out[i]) out[i] += share * (vectors[i] - out[i]);
    return detail::with_axis_vectors(path, out, height_mm);
}

}  // namespace

Result<RotaryReduced> reduce_rotary(const DualPath& path, const Machining& machining,
                                    const OrientationFreedom& freedom) {
    if (auto ok = check_freedom(path, machining, freedom); !ok) return fail(ok.error());
    const auto before = rotary_use(path, machining);
    if (!before) return fail(before.error());
    const OrientationLimits limits(path, machining.tool, freedom);
    const bool with_clearance = static_cast<bool>(freedom.clearance_mm);
    const Worst given = worst_of(path, limits, with_clearance);
    if (given.excess > rounding) return fail(outside(path, given));

    Machining from_there = machining;
    from_there.begin_rad = before->begin_rad;
    const auto vectors = detail::calmer_axis_vectors(path, from_there, limits);
    if (!vectors) return fail(vectors.error());
    RotaryReduced out{.path = path, .least_clearance_mm = given.clearance_mm, .before = *before, .after = *before};
    for (const double share : shares) {
        DualPath tried = drawn_back(path, *vectors, share, machining.tool.controlled_height_mm());
        const OrientationChange change = orientation_change(path, tried, machining.tool);
        const Worst worst = worst_of(tried, limits, with_clearance);
        if (change.orientation_deviation_rad > freedom.orientation_tolerance_rad || worst.excess > rounding) continue;
        const auto after = rotary_use(tried, from_there);
        if (!after || after->travel_rad > before->travel_rad ||
            after->velocity_limited_time_s > before->velocity_limited_time_s * slower)
            continue;
        return RotaryReduced{std::move(tried), true, change, worst.clearance_mm, *before, *after};
    }
    return out;
}

Result<PosesRotaryReduced> reduce_rotary(std::span<const Pose> poses, const DualFit& fit, const Machining& machining,
                                         const OrientationFreedom& freedom) {
    const auto fitted = fit_dual_path(poses, fit);
    if (!fitted) return fail(fitted.error());
    auto reduced = reduce_rotary(fitted->path, machining, freedom);
    if (!reduced) return fail(reduced.error());
    auto out = detail::poses_about(poses, fitted->parameters, reduced->path, machining.tool.controlled_height_mm());
    return PosesRotaryReduced{std::move(out), std::move(*reduced)};
}

}  // namespace trunnion::deformation
