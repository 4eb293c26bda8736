#include "detail/followed_path.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include <fmt/format.h>

#include "trunnion/path/pole_passage.hpp"
#include "trunnion/path/run.hpp"

#include "detail/pole_approach.hpp"
#include "detail/spline_equations.hpp"

namespace trunnion::deformation::detail {

using Eigen::Vector3d;
using machine::RotaryPosition;

namespace {

constexpr double full_turn = 2 * std::numbers::pi;

/// The cubic over [from, to] as powers of (u − from)/(to − from).
path::PathPiece piece_of(const DualPath& path, double begin_u, double from, double to) {
    const auto bottom = path.spline.bottom().evaluate(from), top = path.spline.top().evaluate(from);
    path::PathPiece out{from - begin_u, to - from, {}};
    double power = 1;
    for (std::size_t i = 0; i < 4; ++i) {
        for (std::size_t k = 0; k < 3; ++k) {
            const auto row = static_cast<Eigen::Index>(k);
            out.coefficient[k][i] = bottom[i][row] * power;
            out.coefficient[3 + k][i] = (top[i] - bottom[i])[row] * power / path.distance_mm;
        }
        power *= (to - from) / static_cast<double>(i + 1);
    }
    return out;
}

std::vector<double> piece_ends(const DualPath& path, const machine::Kinematics& kinematics, double end_u) {
    std::vector<double> out = stations_of(path.spline.bottom().knots());
    for (const PoleApproach& approach : pole_approaches(path, path::poles_of(kinematics)))
        if (approach.distance_rad < through_pole_rad && !approach.at_end) out.push_back(approach.u);
    std::ranges::sort(out);
    const double shortest = 1e-9 * (path.end() - path.begin());
    out.erase(std::unique(out.begin(), out.end(), [&](double a, double b) { return b - a < shortest; }), out.end());
    std::erase_if(out, [&](double u) { return u > end_u - shortest; });
    out.push_back(end_u);
    return out;
}

}  // namespace

Result<void> check_cubic(const DualPath& path) {
    const auto& bottom = path.spline.bottom();
    const auto& knots = bottom.knots();
    const bool plain = bottom.degree() == 3 && bottom.weights().empty() && path.spline.top().weights().empty();
    if (plain && knots.front() == bottom.begin() && knots.back() == bottom.end() && path.distance_mm > 0) return {};
    Diagnostic out{.code = "DEFO0201", .text = "the path is not made of two clamped cubic splines without weights"};
    out.hint = "fit a dual path to its poses";
    return fail(std::move(out));
}

Result<void> check_machining(const Machining& machining) {
    Diagnostic out{.code = "DEFO0202"};
    const machine::Tool& tool = machining.tool;
    const auto& begin = machining.begin_rad;
    if (!(machining.feed_mm_s > 0) || !std::isfinite(machining.feed_mm_s)) {
        out.text = "the feed is not above 0";
        out.value = fmt::format("{} mm/s", machining.feed_mm_s);
    } else if (!(tool.diameter_mm >= 0) || !(tool.corner_radius_mm >= 0) || !std::isfinite(tool.diameter_mm) ||
               !std::isfinite(tool.corner_radius_mm)) {
        out.text = "the tool's diameter or corner radius is below 0";
    } else if (begin && !std::ranges::all_of(*begin, [](double rad) { return std::isfinite(rad); })) {
        out.text = "the rotary axes begin where no number says";
    } else {
        return {};
    }
    return fail(std::move(out));
}

double seconds_per_u(const DualPath& path, double u, const Machining& machining) noexcept {
    const auto axis = path.spline.axis(u);
    const Vector3d turn(axis[0].d1(), axis[1].d1(), axis[2].d1());
    const Vector3d way = path.spline.bottom().evaluate(u)[1] + machining.tool.controlled_height_mm() * turn;
    return std::max(way.norm(), path::reference_height_mm * turn.norm()) / machining.feed_mm_s;
}

Result<FollowedPath> FollowedPath::make(const DualPath& path, const Machining& machining, const RotaryPosition& near,
                                        double end_u) {
    FollowedPath out;
    out.begin_u_ = path.begin();
    out.geometry_ = std::make_unique<path::ToolPath>();
    out.geometry_->kinematics = &machining.kinematics;
    const std::vector<double> ends = piece_ends(path, machining.kinematics, end_u);
    for (std::size_t i = 0; i + 1 < ends.size(); ++i)
        out.geometry_->pieces.push_back(piece_of(path, out.begin_u_, ends[i], ends[i + 1]));
    auto axes = path::AxisPath::make(*out.geometry_, machining.machine, near);
    if (!axes) return fail(axes.error());
    out.axes_ = std::make_unique<path::AxisPath>(std::move(*axes));
    return out;
}

std::vector<RotaryPosition> beginnings(const DualPath& path, const Machining& machining) {
    if (machining.begin_rad) return {*machining.begin_rad};
    const auto solutions = machining.kinematics.rotary_for(path.at(path.begin()).axis_in_workpiece);
    const machine::Machine& machine = machining.machine;
    std::vector<RotaryPosition> out(solutions.rotary_rad.begin(), solutions.rotary_rad.begin() + solutions.count);
    for (int r = 0; r < machine.rotary_count; ++r) {
        const auto which = static_cast<std::size_t>(r);
        const machine::Axis& axis = machine.axes[static_cast<std::size_t>(machine.linear_count()) + which];
        if (std::isinf(axis.range_min) && std::isinf(axis.range_max)) continue;
        std::vector<RotaryPosition> wound;
        for (const RotaryPosition& at : out)
            for (const double turns : {-1.0, 0.0, 1.0}) {
                RotaryPosition other = at;
                other[which] += turns * full_turn;
                if (other[which] >= axis.range_min && other[which] <= axis.range_max) wound.push_back(other);
            }
        if (!wound.empty()) out = std::move(wound);
    }
    std::ranges::stable_sort(out, {}, [](const RotaryPosition& at) { return std::abs(at[0]) + std::abs(at[1]); });
    if (out.empty()) out.emplace_back();
    return out;
}

}  // namespace trunnion::deformation::detail
