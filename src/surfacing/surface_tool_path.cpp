#include "trunnion/surfacing/surface_tool_path.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "trunnion/geometry/great_circle.hpp"
#include "trunnion/surfacing/path_interval.hpp"

#include "detail/spline_fit.hpp"

namespace trunnion::surfacing {

using Eigen::Vector3d;
using geometry::SurfacePlace;

namespace {

SurfacePlace between(const SurfacePlace& a, const SurfacePlace& b, double w) {
    return {(1 - w) * a.u + w * b.u, (1 - w) * a.v + w * b.v};
}

CutterPose between(const CutterPose& a, const CutterPose& b, double w) {
    return {(1 - w) * a.tip_mm + w * b.tip_mm, geometry::slerp(a.axis, b.axis, w)};
}

bool holds(const geometry::BsplineSurface& surface, const SurfacePlace& place) {
    const auto in = [](const geometry::SurfaceDirection& direction, double at) {
        const double slack = 1e-6 * (direction.end() - direction.begin());  // places on a border may be drawn off it
        return at >= direction.begin() - slack && at <= direction.end() + slack;
    };
    return in(surface.u(), place.u) && in(surface.v(), place.v);
}

Diagnostic too_few_places() {
    return {.code = "SURF0309", .text = "a pass on a guiding surface has fewer than two places"};
}

Result<void> check_above_zero(const char* name, double value) {
    if (value > 0 && std::isfinite(value)) return {};
    return fail({.code = "SURF0301",
                 .text = fmt::format("{} of a pass on a guiding surface is out of its range", name),
                 .value = fmt::format("{}", value),
                 .limit = "above 0"});
}

/// Poses between two places of a polyline.
class Division {
  public:
    Division(const GuidedTool& tool, const SurfacePathOptions& options, std::vector<Contact>& out)
        : tool_(tool), options_(options), out_(out) {}

    /// Appends what the move from the last contact to a place needs, the place included.
    Result<void> to(const SurfacePlace& place, const Vector3d& along, int level = 0) {
        const Contact from = out_.back();
        auto there = contact_at(tool_, place, along);
        if (!there) return fail(std::move(there.error()));
        constexpr int deepest = 20;
        if (straight(from, *there)) {
            out_.push_back(*there);
            return {};
        }
        if (level == deepest) return fail(leans_through_normal(from));
        if (auto first = to(between(from.place, place, 0.5), along, level + 1); !first) return first;
        return to(place, along, level + 1);
    }

  private:
    static Diagnostic leans_through_normal(const Contact& at) {
        return {
            .code = "SURF0312",
            .text = fmt::format("the tool's contact jumps across its end at ({:.3f} {:.3f} {:.3f})", at.point_mm.x(),
                                at.point_mm.y(), at.point_mm.z()),
            .value = fmt::format("axis {:.3g} rad from the normal", geometry::angle_between(at.pose.axis, at.normal)),
            .hint = "keep the lead on one side of 0, or tilt the tool"};
    }
    bool straight(const Contact& from, const Contact& to) const {
        if ((to.point_mm - from.point_mm).norm() > options_.longest_step_mm) return false;
        for (const double w : {0.25, 0.5, 0.75}) {
            const auto at = geometry::shape_at(tool_.face.surface, between(from.place, to.place, w), tool_.face.side);
            if (!at) return true;
            const double off = gap_nearby_mm(tool_.cutter, *at, between(from.pose, to.pose, w));
            if (std::abs(off) > options_.chord_tolerance_mm) return false;
        }
        return true;
    }

    const GuidedTool& tool_;
    const SurfacePathOptions& options_;
    std::vector<Contact>& out_;
};

/// A smooth curve in (u, v) through places.
class PlaceCurve {
  public:
    PlaceCurve(const GuidedTool& tool, std::span<const SurfacePlace> places) {
        std::vector<double> lengths;
        std::vector<Vector3d> points;
        Vector3d before;
        for (const SurfacePlace& place : places) {
            const Vector3d at = tool.face.surface.at(place.u, place.v);
            const double step = points.empty() ? 0 : (at - before).norm();
            if (!points.empty() && !(step > 1e-9)) continue;
            lengths.push_back(points.empty() ? 0 : lengths.back() + step);
            points.emplace_back(place.u, place.v, 0);
            before = at;
        }
        if (points.size() >= 2) curve_ = detail::curve_through(lengths, std::move(points));
    }
    bool empty() const { return !curve_; }
    double length() const { return curve_->end(); }
    SurfacePlace place(double s) const {
        const Vector3d at = curve_->evaluate(s)[0];
        return {at.x(), at.y()};
    }
    Result<Contact> contact(const GuidedTool& tool, double s) const {
        const auto at = curve_->evaluate(s);
        const auto on = tool.face.surface.evaluate(at[0].x(), at[0].y());
        return contact_at(tool, {at[0].x(), at[0].y()}, at[1].x() * on.by_u + at[1].y() * on.by_v);
    }

  private:
    std::optional<geometry::BsplineCurve> curve_;
};

Result<PassSpline> spline_through(const GuidedTool& tool, const PlaceCurve& curve, std::size_t poses, double height) {
    std::vector<double> at;
    std::vector<Vector3d> tips, tops;
    for (std::size_t k = 0; k < poses; ++k) {
        at.push_back(curve.length() * static_cast<double>(k) / static_cast<double>(poses - 1));
        const auto contact = curve.contact(tool, at.back());
        if (!contact) return fail(contact.error());
        tips.push_back(contact->pose.tip_mm);
        tops.push_back(contact->pose.tip_mm + height * contact->pose.axis);
    }
    auto spline = geometry::DualSpline::make(detail::curve_through(at, std::move(tips)),
                                             detail::curve_through(at, std::move(tops)));
    PassSpline out{.spline = std::move(*spline), .poses = poses};
    for (std::size_t k = 0; k + 1 < poses; ++k)
        for (const double w : {0.2, 0.4, 0.6, 0.8}) {
            const double s = at[k] + w * (at[k + 1] - at[k]);
            const auto contact = curve.contact(tool, s);
            if (!contact) return fail(contact.error());
            const Vector3d tip = out.spline.bottom().evaluate(s)[0], top = out.spline.top().evaluate(s)[0];
            out.tip_error_mm = std::max(out.tip_error_mm, (tip - contact->pose.tip_mm).norm());
            out.axis_error_rad = std::max(out.axis_error_rad, geometry::angle_between(top - tip, contact->pose.axis));
        }
    return out;
}

}  // namespace

Result<Contact> contact_at(const GuidedTool& tool, const SurfacePlace& place, const Vector3d& along) {
    const GuidingSurface& guiding = tool.orientation.guiding();
    const auto shape = shape_at(tool.face.surface, place, tool.face.side);
    const auto place_text = [&] { return fmt::format("u = {:.6g}, v = {:.6g}", place.u, place.v); };
    if (!holds(guiding.surface(), place) || !holds(tool.orientation.surface(), place))
        return fail({.code = "SURF0309",
                     .text = "a place is outside the guiding and orientation surfaces",
                     .value = place_text()});
    if (!shape)
        return fail({.code = "SURF0303", .text = "the surface has no normal at a place", .value = place_text()});
    const Vector3d& normal = shape->normal;
    const double flat = tool.cutter.flat_radius_mm();
    Vector3d axis = tool.orientation.axis(place);
    if (auto allowed = OrientationSurface::check_rise(*shape, axis); !allowed) return fail(std::move(allowed.error()));
    const bool upright = flat > 0 && normal.cross(axis).norm() <= tool.orientation.slack_rad();
    if (upright) axis = normal;
    const Vector3d across =
        upright ? Vector3d(along.dot(normal) * normal - along) : Vector3d(normal - normal.dot(axis) * axis);
    const Vector3d inward = across.norm() > 0 ? across.normalized() : Vector3d(Vector3d::Zero());
    const Vector3d centre = guiding.at(place) + flat * inward;
    return Contact{place, shape->point, normal, {centre - tool.cutter.corner_mm() * axis, axis}};
}

Result<Pass> pass_on(const GuidedTool& tool, std::span<const SurfacePlace> polyline, int index,
                     const SurfacePathOptions& options) {
    for (const auto& [name, value] :
         {std::pair{"chord_tolerance_mm", options.chord_tolerance_mm}, {"longest_step_mm", options.longest_step_mm}})
        if (auto sound = check_above_zero(name, value); !sound) return fail(std::move(sound.error()));
    if (polyline.size() < 2) return fail(too_few_places());
    const auto way = [&](std::size_t k) -> Vector3d {
        const SurfacePlace &a = polyline[k], &b = polyline[k + 1];
        return tool.face.surface.at(b.u, b.v) - tool.face.surface.at(a.u, a.v);
    };
    Pass pass{.contacts = {}, .index = index};
    auto first = contact_at(tool, polyline.front(), way(0));
    if (!first) return fail(std::move(first.error()));
    pass.contacts.push_back(*first);
    Division division(tool, options, pass.contacts);
    for (std::size_t k = 0; k + 1 < polyline.size(); ++k)
        if (auto done = division.to(polyline[k + 1], way(k)); !done) return fail(std::move(done.error()));
    return pass;
}

Result<std::vector<Pass>> reoriented(const GuidedTool& tool, std::span<const Pass> passes,
                                     const SurfacePathOptions& options) {
    std::vector<Pass> out;
    for (const Pass& pass : passes) {
        std::vector<SurfacePlace> places;
        for (const Contact& contact : pass.contacts) places.push_back(contact.place);
        auto there = pass_on(tool, places, pass.index, options);
        if (!there) return fail(std::move(there.error()));
        out.push_back(std::move(*there));
    }
    return out;
}

Result<PassSpline> dual_spline_on(const GuidedTool& tool, std::span<const SurfacePlace> places,
                                  const PassSplineOptions& options) {
    for (const auto& [name, value] : {std::pair{"tip_tolerance_mm", options.tip_tolerance_mm},
                                      {"axis_tolerance_rad", options.axis_tolerance_rad},
                                      {"height_mm", options.height_mm}})
        if (auto sound = check_above_zero(name, value); !sound) return fail(std::move(sound.error()));
    const PlaceCurve curve(tool, places);
    if (curve.empty()) return fail(too_few_places());
    for (std::size_t poses = std::max<std::size_t>(8, places.size());; poses = 2 * poses - 1) {
        auto out = spline_through(tool, curve, poses, options.height_mm);
        if (!out) return out;
        if (out->tip_error_mm <= options.tip_tolerance_mm && out->axis_error_rad <= options.axis_tolerance_rad)
            return out;
        if (2 * poses > options.most_poses)
            return fail(
                {.code = "SURF0305",
                 .text = "the splines of a pass do not get within their tolerance",
                 .value =
                     fmt::format("{:.3g} mm, {:.3g} rad with {} poses", out->tip_error_mm, out->axis_error_rad, poses),
                 .limit = fmt::format("{:.3g} mm, {:.3g} rad", options.tip_tolerance_mm, options.axis_tolerance_rad)});
    }
}

}  // namespace trunnion::surfacing
