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

#include "detail/join_passes.hpp"
#include "detail/node.hpp"

namespace trunnion::surfacing::detail {

namespace {

struct Span {
    double from, to;
};

/// Of a pass: what runs along it, on one arc of its way.
struct Run {
    const Way& way;
    std::size_t arc;
    bool backwards;
};

constexpr double just_before = 1e-4;  ///< a border that is one point, as a share of a way towards it

/// Of ways that run along a border of the domain, all or nothing: places count as drawn a little towards the middle.
/// They end just before a border that is one point: beyond it the normal has turned to the other side.
bool within(const Job& job, const Way& way, double s) {
    const Place at = way.place(s);
    const ParameterBox& box = job.region.box(at.chart);
    const Eigen::Vector2d out =
        Eigen::Vector2d(at.u, at.v) + just_before * (Eigen::Vector2d(at.u, at.v) - 0.5 * (box.low + box.high));
    const Eigen::Vector2d ahead = out.cwiseMax(box.low).cwiseMin(box.high);
    if (!job.shape({{ahead.x(), ahead.y()}, at.chart})) return false;
    constexpr double draw = 1e-7;
    return job.region.contains({{at.u + draw * (0.5 * (box.low.x() + box.high.x()) - at.u),
                                 at.v + draw * (0.5 * (box.low.y() + box.high.y()) - at.v)},
                                at.chart});
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
double straight_error_mm(const Job& job, const Run& run, double from, double to) {
    const auto station = [&](double s) { return job.station(run.way, s, run.arc, run.backwards); };
    const auto a = station(from), b = station(to);
    constexpr double unknown_mm = std::numeric_limits<double>::infinity();  // as short a step as there is
    if (!a || !b) return unknown_mm;
    const geometry::GreatCircle turn(a->pose.axis, b->pose.axis);
    const double slope = ridge_slope(job, *a), corner = job.cutter.corner_mm();
    double largest = 0;
    constexpr int parts = 4;
    for (int k = 1; k < parts; ++k) {
        const double w = static_cast<double>(k) / parts;
        const auto at = station(from + w * (to - from));
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
            Place place{{station.place.u + step.x(), station.place.v + step.y()}, station.place.chart};
            if (!job.region.is_before_joints(place)) place = job.region.closest(job.region.at(place), place);
            if (!contains(job.region.face(place.chart), place)) continue;
            const Eigen::Vector3d point = job.region.at(place);
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

/// Stations from which straight moves lead on, on one arc.
std::vector<Station> stations_on(const Job& job, const Run& run, const Span& span) {
    const auto error = [&](double from, double to) { return straight_error_mm(job, run, from, to); };
    auto at = chord_steps(error, span.from, span.to, job.options.chord_tolerance_mm, job.options.longest_step_mm);
    if (run.backwards) std::ranges::reverse(at);
    std::vector<Station> out;
    for (const double s : at)
        if (auto station = job.station(run.way, s, run.arc, run.backwards)) out.push_back(std::move(*station));
    return out;
}

/// Where a way has a corner at a joint a leaning tool turns round its contact: stations before the last one, in turns
/// so small that the tool, its tip led straight, stays on the contact.
std::vector<Station> turns_between(const Job& job, const Station& from, const Station& to, bool backwards) {
    constexpr double most_rad = 0.01;
    const double turn = geometry::angle_between(from.pose.axis, to.pose.axis);
    std::vector<Station> out;
    const int parts = static_cast<int>(std::ceil(turn / most_rad));
    for (int k = 1; k < parts; ++k) {
        const double w = static_cast<double>(k) / parts;
        const Eigen::Vector3d along = (1 - w) * from.along + w * to.along;
        const Eigen::Vector3d& normal = to.shape.normal;
        out.push_back(job.standing(to.place, to.shape, (along - along.dot(normal) * normal).normalized(), backwards));
    }
    return out;
}

/// Parts of a span, each on one arc of the way.
std::vector<std::pair<std::size_t, Span>> by_arcs(const Way& way, const Span& span) {
    std::vector<std::pair<std::size_t, Span>> out;
    constexpr double shortest_mm = 1e-6;
    for (std::size_t arc = 0; arc < way.arcs(); ++arc) {
        const Span on{std::max(span.from, way.lengths()[way.arc_begin(arc)]),
                      std::min(span.to, way.lengths()[way.arc_end(arc) - 1])};
        if (way.arcs() == 1 || on.to - on.from > shortest_mm) out.emplace_back(arc, on);
    }
    return out;
}

Result<Pass> stood(const Job& job, const std::vector<Station>& stations, int index) {
    Pass out{.contacts = {}, .index = index};
    for (const Station& at : stations) {
        if (!job.options.leave_out) {
            if (auto fits = check_fit(job, at); !fits) return fail(std::move(fits.error()));
            if (auto clear = check_body(job, at); !clear) return fail(std::move(clear.error()));
        }
        out.contacts.push_back(
            {at.place, at.shape.point, at.shape.normal, at.pose, static_cast<int>(job.region.number(at.place.chart))});
    }
    return out;
}

Result<Pass> pass_of(const Job& job, const Way& way, const Span& span, int index, bool backwards) {
    Pass pass{.contacts = {}, .index = index};
    auto parts = by_arcs(way, span);
    if (backwards) std::ranges::reverse(parts);
    std::optional<Station> before;
    for (const auto& [arc, on] : parts) {
        auto stations = stations_on(job, {way, arc, backwards}, on);
        if (stations.empty()) continue;
        if (before) {
            const auto turns = turns_between(job, *before, stations.front(), backwards);
            stations.insert(stations.begin(), turns.begin(), turns.end());
        }
        before = stations.back();
        auto part = stood(job, stations, index);
        if (!part) return fail(std::move(part.error()));
        append(pass, std::move(*part));
    }
    return pass;
}

/// Whether a loop has a corner at a point: more than 15°, or an end of an edge that is one point.
bool is_corner(const Job& job, const Loop& loop, std::size_t i) {
    const auto at = [&](std::size_t k) {
        const Eigen::Vector2d& p = loop[k % loop.size()];
        return job.face().surface.at(p.x(), p.y());
    };
    const Eigen::Vector3d in = at(i) - at(i + loop.size() - 1), out = at(i + 1) - at(i);
    constexpr double corner_rad = std::numbers::pi / 12, one_point_mm = 1e-9;
    const std::size_t before = (i + loop.size() - 1) % loop.size(), after = (i + 1) % loop.size();
    if (in.norm() < one_point_mm || out.norm() < one_point_mm) return loop[before] != loop[i] && loop[i] != loop[after];
    return geometry::angle_between(in, out) > corner_rad;
}

/// The loop's points from one place of it to a later one, with points on long straight pieces between: numbers of its
/// points, with the share of the way to the next one.
Way border_way(const Job& job, const Loop& loop, double from, double to) {
    std::vector<Place> places;
    constexpr int parts = 8;
    for (double begin = from; begin < to;) {
        const double number = std::floor(begin), end = std::min(number + 1, to), share = begin - number;
        const auto k = static_cast<std::size_t>(number);
        const Eigen::Vector2d &a = loop[k % loop.size()], &b = loop[(k + 1) % loop.size()];
        for (int part = begin == from ? 0 : 1; part <= parts; ++part) {
            const Eigen::Vector2d p = a + (b - a) * (share + (end - begin) * part / parts);
            places.push_back({{p.x(), p.y()}});
        }
        begin = end;
    }
    return {job.region, places};
}

/// Where border passes begin and end: corners, and ends of joints; the first one once more at the end of the loop.
std::vector<double> ends_along(const Job& job, std::size_t number, std::span<const Stretch* const> joints) {
    const Loop& loop = job.face().loops[number];
    const auto size = static_cast<double>(loop.size());
    std::vector<double> ends;
    for (std::size_t i = 0; i < loop.size(); ++i)
        if (is_corner(job, loop, i)) ends.push_back(static_cast<double>(i));
    constexpr double same = 1e-3;  // of the way to the next point
    const auto add = [&](double along) {
        const auto near = [&](double end) {
            const double off = std::abs(end - along);
            return std::min(off, size - off) < same;
        };
        if (std::ranges::none_of(ends, near)) ends.push_back(along);
    };
    for (const Stretch* joint : joints)
        if (joint->loop == number && !joint->closed) {
            add(std::fmod(joint->points.front().along, size));
            add(std::fmod(joint->points.back().along, size));
        }
    std::ranges::sort(ends);
    if (ends.empty()) ends.push_back(0);
    ends.push_back(ends.front() + size);
    return ends;
}

/// A way without ends where the surface has no normal.
Span with_normals(const Job& job, const Way& way) {
    const double end = way.length(), off = just_before * end;
    return {job.station(way, 0.0, false) ? 0 : off, job.station(way, end, false) ? end : end - off};
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

Result<void> append_border_passes(const Job& job, std::span<const Stretch* const> joints,
                                  const std::function<bool(const Way&)>& wanted, std::vector<Pass>& out) {
    for (std::size_t number = 0; number < job.face().loops.size(); ++number) {
        const Loop& loop = job.face().loops[number];
        const auto ends = ends_along(job, number, joints);
        for (std::size_t k = 0; k + 1 < ends.size(); ++k) {
            const double middle = 0.5 * (ends[k] + ends[k + 1]);
            const auto is_there = [&](const Stretch* joint) {
                return joint->loop == number && joint->holds(middle, loop.size());
            };
            if (std::ranges::any_of(joints, is_there)) continue;
            const Way way = border_way(job, loop, ends[k], ends[k + 1]);
            if (way.places().size() < 2 || !wanted(way)) continue;  // an edge that is one point
            auto pass = pass_of(job, way, with_normals(job, way), -1, false);
            if (!pass) return fail(std::move(pass.error()));
            if (pass->contacts.size() > 1) out.push_back(std::move(*pass));
        }
    }
    return {};
}

}  // namespace trunnion::surfacing::detail
