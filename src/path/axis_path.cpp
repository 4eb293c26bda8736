#include "trunnion/path/axis_path.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "trunnion/base/quantity.hpp"

#include "detail/branch_following.hpp"
#include "detail/pole_piece.hpp"

namespace trunnion::path {

using detail::Followed;
using machine::AxisPosition;
using machine::RotaryPosition;
using machine::RotarySeries;
using machine::VectorSeries;

namespace {

constexpr double station_turn_rad = 20 * degree;
constexpr double shortest_station_mm = 1e-9;
constexpr double reach_rad = 1e-6;

VectorSeries normalised(const VectorSeries& v) {
    const Taylor3 inverse = 1.0 / sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    return {v[0] * inverse, v[1] * inverse, v[2] * inverse};
}

double rate_of(const VectorSeries& v) {
    return std::hypot(v[0].d1(), v[1].d1(), v[2].d1());
}

/// How far a function may come from its chord over an interval of which it has these values and derivatives at both
/// ends: Bernstein hull of the septic polynomial through them (Farin, Curves and Surfaces for CAGD, ch. 5).
double largest_distance_from_chord(const Taylor3& from, const Taylor3& to, double length_mm) {
    constexpr double binomial[4][4] = {{1, 0, 0, 0}, {1, 1, 0, 0}, {1, 2, 1, 0}, {1, 3, 3, 1}};
    constexpr double of_seven[4] = {1, 7, 21, 35};
    const double rise = to.value() - from.value();
    double out = 0;
    for (int j = 1; j < 4; ++j) {
        double near_from = 0, near_to = 0, power = 1;
        for (int k = 1; k <= j; ++k) {
            power *= length_mm;
            const double share = power * binomial[j][k] / of_seven[k];
            near_from += share * from.c[k];
            near_to += (k % 2 ? -share : share) * to.c[k];
        }
        out = std::max({out, std::abs(near_from - rise * j / 7), std::abs(near_to + rise * j / 7)});
    }
    return out;
}

/// Along a piece that begins or ends at the pole its own series tell where the axes are, at the pole too.
template <class IsReached, class OnStation>
std::expected<Followed, detail::Lost> follow_beside_pole(const machine::Kinematics& kinematics,
                                                         const detail::PolePiece& piece, const IsReached& is_reached,
                                                         double from, double to, const Followed& at_from,
                                                         const OnStation& on_station) {
    const auto after = [&](double offset, const Followed& before) {
        const RotarySeries at = piece.rotary(kinematics, offset, before.rotary_rad);
        return Followed{{at[0].value(), at[1].value()}};
    };
    const auto continues = [&](const Followed& a, const Followed& b) {
        return detail::largest_turn(a.rotary_rad, b.rotary_rad) < station_turn_rad / 2;
    };
    const double middle = 0.5 * (from + to);
    const Followed at_middle = after(middle, at_from), at_end = after(to, at_middle);
    if (!is_reached(to)) return std::unexpected(detail::Lost{detail::Lost::Why::out_of_reach, to});
    if (continues(at_from, at_middle) && continues(at_middle, at_end) &&
        piece.turn_bound_rad(from, to) < station_turn_rad) {
        on_station(to, at_end);
        return at_end;
    }
    if (to - from < shortest_station_mm)
        return std::unexpected(detail::Lost{detail::Lost::Why::too_close_to_pole, from});
    const auto half = follow_beside_pole(kinematics, piece, is_reached, from, middle, at_from, on_station);
    if (!half) return half;
    return follow_beside_pole(kinematics, piece, is_reached, middle, to, *half, on_station);
}

}  // namespace

Diagnostic AxisPath::diagnose(PathPlace place, std::string code, std::string text) const {
    const double p = path_->pieces[place.piece].begin_mm + place.offset_mm;
    const auto block = std::lower_bound(path_->blocks.begin(), path_->blocks.end(), p,
                                        [](const BlockSpan& span, double at) { return span.end_mm < at; });
    Diagnostic out{.code = std::move(code), .text = std::move(text)};
    if (block != path_->blocks.end()) out.place.line = block->line;
    return out;
}

Eigen::Vector3d AxisPath::tool_axis(PathPlace place) const {
    const auto at = path::evaluate(path_->pieces[place.piece], place.offset_mm);
    return Eigen::Vector3d(at[3].value(), at[4].value(), at[5].value()).normalized();
}

machine::RotarySolutions AxisPath::solutions(PathPlace place) const {
    return path_->kinematics->rotary_for(tool_axis(place));
}

Diagnostic AxisPath::out_of_reach(PathPlace place) const {
    const Eigen::Vector3d axis = tool_axis(place);
    return diagnose(place, "PATH0101",
                    fmt::format("the machine cannot bring its tool to the direction ({:.6f}, {:.6f}, {:.6f})", axis.x(),
                                axis.y(), axis.z()));
}

/// Where the rotary axes begin: on the solution nearest to `near`. At the pole that is the one with which the path
/// leaves it, up to where it does; it stays at `near` where it never leaves.
Result<RotaryPosition> AxisPath::beginning(const RotaryPosition& near) const {
    constexpr int looks = 8;
    const machine::Kinematics& kinematics = *path_->kinematics;
    const auto at_begin = solutions({0, 0});
    if (at_begin.count == 0) return fail(out_of_reach({0, 0}));
    if (!at_begin.degenerate) return detail::solution_after(kinematics, at_begin, {near}, 0)->rotary_rad;
    for (std::size_t i = 0; i < path_->pieces.size(); ++i) {
        const double length = path_->pieces[i].length_mm;
        const auto at = [&](double offset) { return solutions({i, offset}); };
        for (int k = 0; k < looks; ++k) {
            const double off = length * (k + 1) / looks;
            if (at(off).degenerate) continue;
            const auto side = detail::side_of_pole(kinematics, at, length * k / looks, off, [&](const auto& leaving) {
                return detail::solution_after(kinematics, leaving, {near}, 0);
            });
            if (!side) return fail(out_of_reach({i, off}));
            if (side->rest_rad > detail::most_rest_rad) return fail(too_close_to_pole({i, off}));
            return detail::solution_of(kinematics, at_begin, 0, side->rotary_rad).rotary_rad;
        }
    }
    return detail::solution_of(kinematics, at_begin, 0, near).rotary_rad;
}

Result<void> AxisPath::follow(const RotaryPosition& near) {
    const auto begin = beginning(near);
    if (!begin) return fail(begin.error());
    Followed at = *detail::solution_after(*path_->kinematics, solutions({0, 0}), {*begin}, 0);
    const auto add = [&](PathPlace place, const Followed& followed) {
        stations_.push_back(place);
        rotary_at_station_.push_back(followed.rotary_rad);
    };
    add({0, 0}, at);
    for (std::size_t i = 0; i < path_->pieces.size(); ++i) {
        if (i > 0) add({i, 0}, at);
        first_station_of_piece_.push_back(stations_.size() - 1);
        const auto solutions_at = [&](double offset) { return solutions({i, offset}); };
        const auto is_reached = [&](double offset) { return solutions({i, offset}).count > 0; };
        const auto on_station = [&](double offset, const Followed& followed) { add({i, offset}, followed); };
        const double length = path_->pieces[i].length_mm;
        const detail::PolePiece* beside_pole = pole_piece(i);
        const auto followed =
            beside_pole ? follow_beside_pole(*path_->kinematics, *beside_pole, is_reached, 0, length, at, on_station)
                        : detail::follow(*path_->kinematics, solutions_at, 0, length, at,
                                         {station_turn_rad / 2, shortest_station_mm}, on_station);
        if (!followed) {
            const PathPlace place{i, followed.error().at};
            const bool out = followed.error().why == detail::Lost::Why::out_of_reach;
            return fail(out ? out_of_reach(place) : too_close_to_pole(place));
        }
        at = *followed;
        if (beside_pole) at = *detail::solution_after(*path_->kinematics, solutions({i, length}), at, 0);
    }
    return {};
}

Diagnostic AxisPath::too_close_to_pole(PathPlace place) const {
    auto out = diagnose(place, "PATH0103", "the tool axis passes the pole too closely for the rotary axes to follow");
    out.hint = "turn the part on the table, or lead the tool a little to one side";
    return out;
}

/// A machine without rotary axes must have its tool where the vectors want it.
Result<void> AxisPath::check_reach() const {
    if (path_->law != OrientationLaw::vector || path_->space != Space::workpiece) return {};
    for (std::size_t i = 0; i < path_->pieces.size(); ++i)
        for (const double offset : {0.0, path_->pieces[i].length_mm})
            if ((path_->kinematics->tool_axis(RotaryPosition{}) - tool_axis({i, offset})).norm() > reach_rad)
                return fail(out_of_reach({i, offset}));
    return {};
}

Diagnostic AxisPath::out_of_range(PathPlace place, int which, double value) const {
    const machine::Axis& axis = machine_->axes[which];
    const double unit = axis.rotary ? degree : 1.0;
    const char* name = axis.rotary ? "deg" : "mm";
    auto out = diagnose(place, "PATH0102", fmt::format("axis {} leaves its range", axis.letter));
    out.value = fmt::format("{} = {:.4f} {}", axis.letter, value / unit, name);
    out.limit = fmt::format("{:.4f} … {:.4f} {}", axis.range_min / unit, axis.range_max / unit, name);
    out.hint = "check the setup's origin and tool length, or turn the part on the table";
    return out;
}

/// Between two places: inside where the axis cannot come farther from its chord than there is room, else halved.
Result<void> AxisPath::check_ranges(PathPlace from, const AxisSample& at_from, double length_mm,
                                    const AxisSample& at_to) const {
    bool certain = true;
    for (int i = 0; i < machine_->axis_count; ++i) {
        const machine::Axis& axis = machine_->axes[i];
        const Taylor3 &a = at_from.axes[i], &b = at_to.axes[i];
        const double slack = axis.rotary ? 1e-9 : 1e-6;
        const double low = axis.range_min - slack, high = axis.range_max + slack;
        if (!(a.value() >= low && a.value() <= high)) return fail(out_of_range(from, i, a.value()));
        if (!(b.value() >= low && b.value() <= high))
            return fail(out_of_range({from.piece, from.offset_mm + length_mm}, i, b.value()));
        if (std::isinf(low) && std::isinf(high)) continue;
        const double room = std::min({a.value() - low, high - a.value(), b.value() - low, high - b.value()});
        // twice: what the septic polynomial leaves out is less than what it adds to the chord
        certain = certain && 2 * largest_distance_from_chord(a, b, length_mm) <= std::max(room, slack);
    }
    if (certain || length_mm < shortest_station_mm) return {};
    const PathPlace middle{from.piece, from.offset_mm + length_mm / 2};
    AxisSample at_middle;
    evaluate(middle, at_middle);
    if (auto first = check_ranges(from, at_from, length_mm / 2, at_middle); !first) return first;
    return check_ranges(middle, at_middle, length_mm / 2, at_to);
}

Result<void> AxisPath::check_ranges() const {
    AxisSample before, after;
    evaluate(stations_.front(), before);
    for (std::size_t k = 1; k < stations_.size(); ++k, std::swap(before, after)) {
        const PathPlace &from = stations_[k - 1], &to = stations_[k];
        evaluate(to, after);
        const double length =
            (from.piece == to.piece ? to.offset_mm : path_->pieces[from.piece].length_mm) - from.offset_mm;
        if (auto inside = check_ranges(from, before, length, after); !inside) return inside;
    }
    return {};
}

Result<AxisPath> AxisPath::make(const ToolPath& path, const machine::Machine& machine, const RotaryPosition& near) {
    AxisPath out(path, machine);
    if (out.follows_vectors()) {
        out.find_pole_pieces();
        if (auto followed = out.follow(near); !followed) return fail(followed.error());
    } else {
        if (auto reached = out.check_reach(); !reached) return fail(reached.error());
        for (std::size_t i = 0; i < path.pieces.size(); ++i) out.stations_.push_back({i, 0});
        out.stations_.push_back({path.pieces.size() - 1, path.pieces.back().length_mm});
    }
    if (auto inside = out.check_ranges(); !inside) return fail(inside.error());
    return out;
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
    const auto& a = rotary_at_station_[static_cast<std::size_t>(before - stations_.begin())];
    const auto& b = rotary_at_station_[static_cast<std::size_t>(after - stations_.begin())];
    return {a[0] + w * (b[0] - a[0]), a[1] + w * (b[1] - a[1])};
}

void AxisPath::find_pole_pieces() {
    const auto poles = poles_of(*path_->kinematics);
    std::vector<detail::PolePiece> found;
    for (std::size_t i = 0; i < path_->pieces.size() && !poles.empty(); ++i)
        if (auto piece = detail::PolePiece::make(i, path_->pieces[i], *path_->kinematics, poles))
            found.push_back(*piece);
    if (!found.empty()) pole_pieces_ = std::make_shared<const std::vector<detail::PolePiece>>(std::move(found));
}

const detail::PolePiece* AxisPath::pole_piece(std::size_t index) const noexcept {
    if (!pole_pieces_) return nullptr;
    const auto piece = std::lower_bound(pole_pieces_->begin(), pole_pieces_->end(), index,
                                        [](const detail::PolePiece& p, std::size_t i) { return p.index() < i; });
    return piece != pole_pieces_->end() && piece->index() == index ? &*piece : nullptr;
}

RotarySeries AxisPath::rotary_at(PathPlace place, const VectorSeries& axis) const noexcept {
    const RotaryPosition near = reference(place);
    if (const detail::PolePiece* piece = pole_piece(place.piece))
        return piece->rotary(*path_->kinematics, place.offset_mm, near);
    return path_->kinematics->rotary_series(axis, near);
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
        rotary = follows_vectors() ? rotary_at(place, sample.tool_axis) : RotarySeries{};
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
