#include "trunnion/path/axis_path.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "trunnion/base/quantity.hpp"

namespace trunnion::path {

using machine::AxisPosition;
using machine::RotaryPosition;
using machine::RotarySeries;
using machine::VectorSeries;

namespace {

constexpr double full_turn = 2 * std::numbers::pi;
constexpr double station_turn_rad = 20 * degree;
constexpr double shortest_station_mm = 1e-9;
constexpr double reach_rad = 1e-6;

double wound_near(double angle, double near) {
    return angle + full_turn * std::round((near - angle) / full_turn);
}

VectorSeries normalised(const VectorSeries& v) {
    const Taylor3 inverse = 1.0 / sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    return {v[0] * inverse, v[1] * inverse, v[2] * inverse};
}

double rate_of(const VectorSeries& v) {
    return std::hypot(v[0].d1(), v[1].d1(), v[2].d1());
}

}  // namespace

bool AxisPath::continues(const Followed& a, const Followed& b) {
    const bool branch = a.branch == b.branch || a.branch == unknown_branch || b.branch == unknown_branch;
    return branch && std::abs(a.rotary_rad[0] - b.rotary_rad[0]) < station_turn_rad / 2 &&
           std::abs(a.rotary_rad[1] - b.rotary_rad[1]) < station_turn_rad / 2;
}

Diagnostic AxisPath::diagnose(PathPlace place, std::string code, std::string text) const {
    const double p = path_->pieces[place.piece].begin_mm + place.offset_mm;
    const auto block = std::lower_bound(path_->blocks.begin(), path_->blocks.end(), p,
                                        [](const BlockSpan& span, double at) { return span.end_mm < at; });
    Diagnostic out{.code = std::move(code), .text = std::move(text)};
    if (block != path_->blocks.end()) out.place.line = block->line;
    return out;
}

/// Position of the rotary axes that gives the tool axis at a place, on the branch and winding nearest to `near`.
Result<AxisPath::Followed> AxisPath::rotary_at(PathPlace place, const RotaryPosition& near) const {
    const auto series = path::evaluate(path_->pieces[place.piece], place.offset_mm);
    const Eigen::Vector3d axis = Eigen::Vector3d(series[3].value(), series[4].value(), series[5].value()).normalized();
    const RotarySeries rotary =
        path_->kinematics->rotary_series({Taylor3(axis.x()), Taylor3(axis.y()), Taylor3(axis.z())}, near);
    Followed found{{rotary[0].value(), rotary[1].value()}, unknown_branch};
    const double missed = (path_->kinematics->tool_axis(found.rotary_rad) - axis).norm();
    if (!(missed <= reach_rad))
        return fail(diagnose(place, "PATH0101",
                             fmt::format("the machine cannot bring its tool to the direction ({:.6f}, {:.6f}, {:.6f})",
                                         axis.x(), axis.y(), axis.z())));
    const auto solutions = path_->kinematics->rotary_for(axis);
    const int turning = path_->kinematics->rotary_nearest_workpiece();
    if (solutions.count == 2 && !solutions.degenerate)
        found.branch = std::cos(found.rotary_rad[turning] - solutions.rotary_rad[0][turning]) > 0 ? 0 : 1;
    return found;
}

/// Adds the stations of ]from, to], fine enough that the nearest solution is the continuous one: small turns, and no
/// change of branch but at the pole itself. A change of branch between two places is a passage of the pole that was
/// jumped over.
Result<void> AxisPath::follow(PathPlace from, PathPlace to, const Followed& at_from) {
    const PathPlace middle{from.piece, 0.5 * (from.offset_mm + to.offset_mm)};
    auto at_middle = rotary_at(middle, at_from.rotary_rad);
    if (!at_middle) return fail(at_middle.error());
    auto at_end = rotary_at(to, at_middle->rotary_rad);
    if (!at_end) return fail(at_end.error());
    if (continues(at_from, *at_middle) && continues(*at_middle, *at_end)) {
        stations_.push_back(to);
        rotary_at_station_.push_back(*at_end);
        return {};
    }
    if (to.offset_mm - from.offset_mm < shortest_station_mm) {
        auto lost =
            diagnose(from, "PATH0103", "the tool axis passes the pole too closely for the rotary axes to follow");
        lost.hint = "turn the part on the table, or lead the tool a little to one side";
        return fail(lost);
    }
    if (auto first = follow(from, middle, at_from); !first) return first;
    return follow(middle, to, rotary_at_station_.back());
}

Result<void> AxisPath::follow(const RotaryPosition& from) {
    stations_.clear();
    rotary_at_station_.clear();
    first_station_of_piece_.clear();
    auto at_begin = rotary_at({0, 0}, from);
    if (!at_begin) return fail(at_begin.error());
    stations_.push_back({0, 0});
    rotary_at_station_.push_back(*at_begin);
    for (std::size_t i = 0; i < path_->pieces.size(); ++i) {
        if (i > 0) {
            stations_.push_back({i, 0});
            rotary_at_station_.push_back(rotary_at_station_.back());
        }
        first_station_of_piece_.push_back(stations_.size() - 1);
        if (auto followed = follow({i, 0}, {i, path_->pieces[i].length_mm}, rotary_at_station_.back()); !followed)
            return followed;
    }
    return {};
}

/// Solutions for a tool axis in three windings, by travel from `near`. At the pole the free axis stays where it is.
std::vector<RotaryPosition> AxisPath::ranked_solutions(PathPlace place, const RotaryPosition& near) const {
    const auto series = path::evaluate(path_->pieces[place.piece], place.offset_mm);
    const auto solutions = path_->kinematics->rotary_for(
        Eigen::Vector3d(series[3].value(), series[4].value(), series[5].value()).normalized());
    const int turning = path_->kinematics->rotary_nearest_workpiece();
    std::vector<std::pair<double, RotaryPosition>> ranked;
    for (int branch = 0; branch < solutions.count; ++branch)
        for (int winding = -1; winding <= 1; ++winding) {
            RotaryPosition candidate = solutions.rotary_rad[branch];
            if (solutions.degenerate && turning >= 0) candidate[turning] = near[turning];
            for (int a = 0; a < machine_->rotary_count; ++a)
                candidate[a] = wound_near(candidate[a], near[a]) + (a == turning ? winding * full_turn : 0);
            ranked.emplace_back(std::abs(candidate[0] - near[0]) + std::abs(candidate[1] - near[1]), candidate);
        }
    std::stable_sort(ranked.begin(), ranked.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    std::vector<RotaryPosition> out;
    for (const auto& [travel, candidate] : ranked) out.push_back(candidate);
    return out;
}

/// Where a stretch that begins at the pole leaves it: the first place that tells where the free axis has to stand.
PathPlace AxisPath::departure() const {
    constexpr int looks = 8;
    for (std::size_t i = 0; i < path_->pieces.size(); ++i)
        for (int k = 0; k < looks; ++k) {
            const PathPlace place{i, path_->pieces[i].length_mm * (k + 1) / looks};
            const auto at = path::evaluate(path_->pieces[i], place.offset_mm);
            const Eigen::Vector3d axis = Eigen::Vector3d(at[3].value(), at[4].value(), at[5].value()).normalized();
            if (!path_->kinematics->rotary_for(axis).degenerate) return place;
        }
    return {0, 0};
}

/// Starting positions of the rotary axes to try, the best first.
std::vector<RotaryPosition> AxisPath::starts(const AxisPosition* start, const AxisPosition& home) const {
    const int linear = machine_->linear_count();
    const auto& reference = start ? *start : home;
    const RotaryPosition near{machine_->rotary_count > 0 ? reference[linear] : 0.0,
                              machine_->rotary_count > 1 ? reference[linear + 1] : 0.0};
    std::vector<RotaryPosition> out{near};
    if (!start) {
        if (auto first = ranked_solutions({0, 0}, near); !first.empty()) out = std::move(first);
        return out;
    }
    const auto at_begin = rotary_at({0, 0}, near);
    if (machine_->rotary_count < 2 || !at_begin || at_begin->branch != unknown_branch) return out;
    const auto leaving = ranked_solutions(departure(), near);
    out.insert(out.end(), leaving.begin(), leaving.end());
    return out;
}

Result<void> AxisPath::check_reach() const {
    if (path_->law != OrientationLaw::vector || path_->space != Space::workpiece) return {};
    for (std::size_t i = 0; i < path_->pieces.size(); ++i) {
        for (const double offset : {0.0, path_->pieces[i].length_mm})
            if (auto reached = rotary_at({i, offset}, {}); !reached) return fail(reached.error());
    }
    return {};
}

Result<void> AxisPath::check_ranges() const {
    for (const PathPlace& place : stations_) {
        const AxisPosition q = position(place);
        for (int i = 0; i < machine_->axis_count; ++i) {
            const machine::Axis& axis = machine_->axes[i];
            const double slack = axis.rotary ? 1e-9 : 1e-6;
            if (q[i] >= axis.range_min - slack && q[i] <= axis.range_max + slack) continue;
            const double unit = axis.rotary ? degree : 1.0;
            const char* name = axis.rotary ? "deg" : "mm";
            auto out = diagnose(place, "PATH0102", fmt::format("axis {} leaves its range", axis.letter));
            out.value = fmt::format("{} = {:.4f} {}", axis.letter, q[i] / unit, name);
            out.limit = fmt::format("{:.4f} … {:.4f} {}", axis.range_min / unit, axis.range_max / unit, name);
            out.hint = "check the setup's origin and tool length, or turn the part on the table";
            return fail(out);
        }
    }
    return {};
}

Result<AxisPath> AxisPath::make(const ToolPath& path, const machine::Machine& machine, const AxisPosition* start,
                                const AxisPosition& home) {
    AxisPath out(path, machine);
    if (!out.follows_vectors()) {
        if (auto reached = out.check_reach(); !reached) return fail(reached.error());
        for (std::size_t i = 0; i < path.pieces.size(); ++i) out.stations_.push_back({i, 0});
        out.stations_.push_back({path.pieces.size() - 1, path.pieces.back().length_mm});
        if (auto inside = out.check_ranges(); !inside) return fail(inside.error());
        return out;
    }
    Result<void> first_failure;
    for (const RotaryPosition& from : out.starts(start, home)) {
        auto followed = out.follow(from);
        if (followed) followed = out.check_ranges();
        if (followed) return out;
        if (first_failure) first_failure = followed;
    }
    return fail(first_failure.error());
}

/// Rotary positions near a place, close enough to tell branch and winding.
RotaryPosition AxisPath::reference(PathPlace place) const noexcept {
    const auto first = stations_.begin() + static_cast<std::ptrdiff_t>(first_station_of_piece_[place.piece]);
    const auto last = place.piece + 1 < first_station_of_piece_.size()
                          ? stations_.begin() + static_cast<std::ptrdiff_t>(first_station_of_piece_[place.piece + 1])
                          : stations_.end();
    auto after = std::upper_bound(first + 1, last, place.offset_mm,
                                  [](double at, const PathPlace& station) { return at < station.offset_mm; });
    if (after == last) --after;
    const auto before = after - 1;
    const double span = after->offset_mm - before->offset_mm;
    const double w = span > 0 ? std::clamp((place.offset_mm - before->offset_mm) / span, 0.0, 1.0) : 0;
    const auto& a = rotary_at_station_[static_cast<std::size_t>(before - stations_.begin())].rotary_rad;
    const auto& b = rotary_at_station_[static_cast<std::size_t>(after - stations_.begin())].rotary_rad;
    return {a[0] + w * (b[0] - a[0]), a[1] + w * (b[1] - a[1])};
}

void AxisPath::evaluate(PathPlace place, AxisSample& sample) const noexcept {
    const auto series = path::evaluate(path_->pieces[place.piece], place.offset_mm);
    const VectorSeries position{series[0], series[1], series[2]};
    const machine::Kinematics& kinematics = *path_->kinematics;
    const int linear = machine_->linear_count();
    RotarySeries rotary{series[3], series[4]};
    if (path_->law == OrientationLaw::vector && path_->space == Space::workpiece) {
        sample.tool_axis = normalised({series[3], series[4], series[5]});
        sample.turn_rate = rate_of(sample.tool_axis);
        rotary = follows_vectors() ? kinematics.rotary_series(sample.tool_axis, reference(place)) : RotarySeries{};
    } else {
        sample.tool_axis = kinematics.tool_axis(rotary);
        sample.turn_rate = std::hypot(rotary[0].d1(), rotary[1].d1());
    }
    const bool in_workpiece = path_->space == Space::workpiece;
    const VectorSeries axes = in_workpiece ? kinematics.linear_for(position, rotary) : position;
    sample.tip = in_workpiece ? position : kinematics.tip_for(position, rotary);
    sample.feed_rate = rate_of(position);
    for (int i = 0; i < linear; ++i) sample.axes[i] = axes[i];
    for (int i = 0; i < machine_->rotary_count; ++i) sample.axes[linear + i] = rotary[i];
    for (int i = machine_->axis_count; i < machine::max_axes; ++i) sample.axes[i] = {};
}

AxisPosition AxisPath::position(PathPlace place) const noexcept {
    AxisSample sample;
    evaluate(place, sample);
    AxisPosition out;
    for (int i = 0; i < machine_->axis_count; ++i) out[i] = sample.axes[i].value();
    return out;
}

}  // namespace trunnion::path
