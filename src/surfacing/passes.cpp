#include "detail/passes.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "trunnion/geometry/great_circle.hpp"
#include "trunnion/surfacing/chord_steps.hpp"
#include "trunnion/surfacing/path_interval.hpp"

#include "detail/node.hpp"

namespace trunnion::surfacing::detail {

using geometry::SurfacePlace;

namespace {

struct Span {
    double from, to;
};

constexpr double just_before = 1e-4;  ///< a border that is one point, as a share of a way towards it

/// Of ways that run along a border of the domain, all or nothing: places count as drawn a little towards the middle.
/// They end just before a border that is one point: beyond it the normal has turned to the other side.
bool within(const Job& job, const Way& way, double s) {
    const ParameterBox& box = job.box;
    const SurfacePlace at = way.place(s);
    const Eigen::Vector2d out =
        Eigen::Vector2d(at.u, at.v) + just_before * (Eigen::Vector2d(at.u, at.v) - 0.5 * (box.low + box.high));
    const Eigen::Vector2d ahead = out.cwiseMax(box.low).cwiseMin(box.high);
    if (!job.shape({ahead.x(), ahead.y()})) return false;
    constexpr double draw = 1e-7;
    return contains(job.face, {at.u + draw * (0.5 * (box.low.x() + box.high.x()) - at.u),
                               at.v + draw * (0.5 * (box.low.y() + box.high.y()) - at.v)});
}

/// Where a way enters or leaves the face, between a place within and one outside.
double border_crossing(const Job& job, const Way& way, double inside, double outside) {
    for (int halving = 0; halving < 50; ++halving) {
        const double middle = 0.5 * (inside + outside);
        (within(job, way, middle) ? inside : outside) = middle;
    }
    return inside;
}

std::vector<Span> spans_within(const Job& job, const Way& way) {
    std::vector<Span> out;
    const int steps = 4 * static_cast<int>(way.places().size());
    double before = 0;
    bool was_inside = false;
    for (int k = 0; k <= steps; ++k) {
        const double s = way.length() * k / steps;
        const bool inside = within(job, way, s);
        if (inside && !was_inside) out.push_back({k == 0 ? s : border_crossing(job, way, s, before), s});
        if (!inside && was_inside) out.back().to = border_crossing(job, way, before, s);
        if (inside && k == steps) out.back().to = s;
        before = s;
        was_inside = inside;
    }
    constexpr double shortest_mm = 1e-6;
    std::erase_if(out, [](const Span& span) { return span.to - span.from < shortest_mm; });
    return out;
}

/// What ridges rise by for one unit that a pass is off sideways: they have that slope at their top, no flank is steeper
/// than 45° there. Where the tool does not fit, no ridge counts.
double ridge_slope(const Job& job, const Station& at) {
    constexpr double steepest = 1;
    if (!(geometry::principal_curvatures(parting(job.cutter, at.shape, at.pose.axis)).smaller > 0)) return 0;
    const double interval =
        path_interval_mm(job.cutter, at.shape, at.pose.axis, at.shape.components(at.across), job.options.scallop_mm);
    return interval > 0 ? std::min(4 * job.options.scallop_mm / interval, steepest) : 0;
}

/// How far the tool, moved straight from one station to another, is off touching the surface in between, and what
/// ridges rise by where it is off its way sideways. Infinite where a place between them has no normal.
double straight_error_mm(const Job& job, const Way& way, bool backwards, double from, double to) {
    const auto a = job.station(way, from, backwards), b = job.station(way, to, backwards);
    constexpr double unknown_mm = std::numeric_limits<double>::infinity();  // as short a step as there is
    if (!a || !b) return unknown_mm;
    const geometry::GreatCircle turn(a->pose.axis, b->pose.axis);
    const double slope = ridge_slope(job, *a), corner = job.cutter.corner_mm();
    double largest = 0;
    constexpr int parts = 4;
    for (int k = 1; k < parts; ++k) {
        const double w = static_cast<double>(k) / parts;
        const auto at = job.station(way, from + w * (to - from), backwards);
        if (!at) return unknown_mm;
        const CutterPose pose{(1 - w) * a->pose.tip_mm + w * b->pose.tip_mm, turn.at(w)};
        const Eigen::Vector3d off = pose.tip_mm + corner * pose.axis - at->pose.tip_mm - corner * at->pose.axis;
        const double sideways = slope * std::abs(off.dot(at->across));
        largest = std::max(largest, std::abs(gap_nearby_mm(job.cutter, at->shape, pose)) + sideways);
    }
    return largest;
}

/// Deepest place of the surface within the tool's body, by points round the contact out to the tool's radius.
double depth_under_mm(const Job& job, const Station& station) {
    double deepest = 0;
    constexpr int directions = 12;
    for (int k = 0; k < directions; ++k) {
        const double angle = 2 * std::numbers::pi * k / directions;
        const Eigen::Vector3d way = std::cos(angle) * station.shape.e1 + std::sin(angle) * station.shape.e2;
        for (const double reach : {0.5, 1.0, 1.5}) {
            const Eigen::Vector2d step = station.shape.parameters_along(reach * job.cutter.radius_mm() * way);
            const SurfacePlace place{station.place.u + step.x(), station.place.v + step.y()};
            if (!contains(job.face, place)) continue;
            const Eigen::Vector3d point = job.face.surface.at(place.u, place.v);
            deepest = std::max(deepest, -job.cutter.distance_mm(station.pose, point));
        }
    }
    return deepest;
}

Result<void> check_body(const Job& job, const Station& station) {
    const double depth = depth_under_mm(job, station);
    if (depth <= job.options.gouge_tolerance_mm) return {};
    const Eigen::Vector3d& at = station.shape.point;
    return fail(
        {.code = "SURF0204",
         .text = fmt::format("touching the surface at ({:.3f} {:.3f} {:.3f}) the tool cuts into it beside its contact",
                             at.x(), at.y(), at.z()),
         .value = fmt::format("depth {:.4g} mm", depth),
         .limit = fmt::format("{:.4g} mm", job.options.gouge_tolerance_mm),
         .hint = "a smaller tool, or more lead"});
}

Result<Pass> pass_of(const Job& job, const Way& way, const Span& span, int index, bool backwards) {
    const auto error = [&](double from, double to) { return straight_error_mm(job, way, backwards, from, to); };
    auto at = chord_steps(error, span.from, span.to, job.options.chord_tolerance_mm, job.options.longest_step_mm);
    if (backwards) std::ranges::reverse(at);
    Pass pass{.contacts = {}, .index = index};
    for (std::size_t i = 0; i < at.size(); ++i) {
        const auto station = job.station(way, at[i], backwards);
        if (!station) continue;
        if (!job.options.leave_out) {
            if (auto fits = check_fit(job, *station); !fits) return fail(std::move(fits.error()));
            if (auto clear = check_body(job, *station); !clear) return fail(std::move(clear.error()));
        }
        pass.contacts.push_back({station->place, station->shape.point, station->shape.normal, station->pose});
    }
    return pass;
}

/// Whether a loop has a corner at a point: more than 15°, or an end of an edge that is one point.
bool is_corner(const Job& job, const Loop& loop, std::size_t i) {
    const auto at = [&](std::size_t k) {
        const Eigen::Vector2d& p = loop[k % loop.size()];
        return job.face.surface.at(p.x(), p.y());
    };
    const Eigen::Vector3d in = at(i) - at(i + loop.size() - 1), out = at(i + 1) - at(i);
    constexpr double corner_rad = std::numbers::pi / 12, one_point_mm = 1e-9;
    const std::size_t before = (i + loop.size() - 1) % loop.size(), after = (i + 1) % loop.size();
    if (in.norm() < one_point_mm || out.norm() < one_point_mm) return loop[before] != loop[i] && loop[i] != loop[after];
    return geometry::angle_between(in, out) > corner_rad;
}

/// The loop's points from one corner to the next, with points on long straight pieces between.
Way border_way(const Job& job, const Loop& loop, std::size_t from, std::size_t to) {
    std::vector<SurfacePlace> places;
    constexpr int parts = 8;
    for (std::size_t k = from; k < to; ++k) {
        const Eigen::Vector2d &a = loop[k % loop.size()], &b = loop[(k + 1) % loop.size()];
        for (int part = 0; part < parts; ++part) {
            const Eigen::Vector2d p = a + (b - a) * part / parts;
            places.push_back({p.x(), p.y()});
        }
    }
    places.push_back({loop[to % loop.size()].x(), loop[to % loop.size()].y()});
    return {job.face.surface, std::move(places)};
}

/// A way without ends where the surface has no normal.
Span with_normals(const Job& job, const Way& way) {
    const double end = way.length(), off = just_before * end;
    return {job.station(way, 0, false) ? 0 : off, job.station(way, end, false) ? end : end - off};
}

}  // namespace

Result<void> append_passes(const Job& job, const Way& way, int index, std::vector<Pass>& out) {
    const bool backwards = job.backwards(index);
    std::vector<Span> spans = spans_within(job, way);
    if (backwards) std::ranges::reverse(spans);
    for (const Span& span : spans) {
        auto pass = pass_of(job, way, span, index, backwards);
        if (!pass) return fail(std::move(pass.error()));
        if (pass->contacts.size() > 1) out.push_back(std::move(*pass));
    }
    return {};
}

Result<void> append_border_passes(const Job& job, const std::function<bool(const Way&)>& wanted,
                                  std::vector<Pass>& out) {
    for (const Loop& loop : job.face.loops) {
        std::vector<std::size_t> corners;
        for (std::size_t i = 0; i < loop.size(); ++i)
            if (is_corner(job, loop, i)) corners.push_back(i);
        if (corners.empty()) corners.push_back(0);
        corners.push_back(corners.front() + loop.size());
        for (std::size_t k = 0; k + 1 < corners.size(); ++k) {
            const Way way = border_way(job, loop, corners[k], corners[k + 1]);
            if (way.places().size() < 2 || !wanted(way)) continue;  // an edge that is one point
            auto pass = pass_of(job, way, with_normals(job, way), -1, false);
            if (!pass) return fail(std::move(pass.error()));
            if (pass->contacts.size() > 1) out.push_back(std::move(*pass));
        }
    }
    return {};
}

}  // namespace trunnion::surfacing::detail
