#include "detail/surface_motion_layer.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "trunnion/surfacing/path_interval.hpp"

namespace trunnion::pipeline {

using geometry::SurfacePlace;

namespace {

constexpr int places_of_a_pass = 200;

Diagnostic too_hollow(const geometry::SurfaceShape& at) {
    return {.code = "SURF0203",
            .text = fmt::format("the surface is hollower than the tool is round at ({:.3f} {:.3f} {:.3f})",
                                at.point.x(), at.point.y(), at.point.z()),
            .hint = "Lin & Koren's rule is for surfaces that bulge towards the tool"};
}

}  // namespace

Result<std::vector<SurfacePlaces>> SurfacePassLayer::next() {
    if (at_end_) return std::vector<SurfacePlaces>{};
    const auto &u = face_.surface.u(), &v = face_.surface.v();
    if (front_.empty()) {
        front_ = along_border(v.begin());
        return std::vector<SurfacePlaces>{front_};
    }
    if (auto moved = move_on(); !moved) return fail(moved.error());
    auto inside = parts_within(v.end(), 1e-3 * (u.end() - u.begin()));
    at_end_ = inside.empty();
    if (at_end_) inside.push_back(along_border(v.end()));
    return inside;
}

double SurfacePassLayer::share() const {
    const auto& v = face_.surface.v();
    double least = v.end();
    for (const SurfacePlace& place : front_) least = std::min(least, place.v);
    return at_end_ ? 1 : (least - v.begin()) / (v.end() - v.begin());
}

SurfacePlaces SurfacePassLayer::along_border(double v) const {
    const auto& u = face_.surface.u();
    SurfacePlaces out;
    for (int k = 0; k <= places_of_a_pass; ++k)
        out.push_back({u.begin() + (u.end() - u.begin()) * k / places_of_a_pass, v});
    return out;
}

Result<SurfacePassLayer::Station> SurfacePassLayer::station(std::size_t i) const {
    const SurfacePlace &before = front_[i == 0 ? 0 : i - 1], &behind = front_[std::min(i + 1, front_.size() - 1)];
    const auto shape = geometry::shape_at(face_.surface, front_[i], face_.side);
    if (!shape)
        return fail({.code = "INTP0003",
                     .text = "the surface has no normal at a place of the curve",
                     .value = fmt::format("u = {}, v = {}", front_[i].u, front_[i].v)});
    const Eigen::Vector3d along = (behind.u - before.u) * shape->by_u + (behind.v - before.v) * shape->by_v;
    Eigen::Vector3d across = shape->normal.cross(along).normalized();
    if (across.dot(shape->by_v) < 0) across = -across;
    return Station{*shape, across};
}

/// All places by the least interval of any. SURF0203 where the surface rises above the tool's rim.
Result<void> SurfacePassLayer::move_on() {
    std::vector<Station> stations;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < front_.size(); ++i) {
        auto at = station(i);
        if (!at) return fail(at.error());
        const Eigen::Vector2d across = at->shape.components(at->across);
        const auto parting = surfacing::parting(cutter_, at->shape, at->shape.normal);
        const double rise =
            0.5 * geometry::principal_curvatures(parting).smaller * cutter_.radius_mm() * cutter_.radius_mm();
        if (rise < -options_.gouge_tolerance_mm) return fail(too_hollow(at->shape));
        least = std::min(least, surfacing::path_interval_mm(cutter_, at->shape, at->shape.normal, across,
                                                            options_.scallop_mm, true));
        stations.push_back(*std::move(at));
    }
    SurfacePlaces moved;
    for (std::size_t i = 0; i < front_.size(); ++i) {
        const Eigen::Vector3d step = least * stations[i].across;
        const Eigen::Vector2d way = stations[i].shape.parameters_along(step);
        constexpr double margin = 0.5;
        moved.push_back(geometry::closest_place(face_.surface, stations[i].shape.point + step,
                                                {front_[i].u + way.x(), front_[i].v + way.y()}, margin));
    }
    front_ = at_even_u(moved);
    return {};
}

/// The front from border to border in u. Where it folds over in a hollow the branch that is least far counts; beyond
/// its ends it goes on straight.
SurfacePlaces SurfacePassLayer::at_even_u(const SurfacePlaces& moved) const {
    SurfacePlaces out = along_border(std::numeric_limits<double>::infinity());
    const auto v_at = [](const SurfacePlace& a, const SurfacePlace& b, double u) {
        return a.v + (u - a.u) / (b.u - a.u) * (b.v - a.v);
    };
    for (std::size_t k = 0; k + 1 < moved.size(); ++k) {
        const SurfacePlace &a = moved[k], &b = moved[k + 1];
        const auto [low, high] = std::minmax(a.u, b.u);
        if (!(low < high)) continue;
        for (auto even = std::ranges::lower_bound(out, low, {}, &SurfacePlace::u); even != out.end() && even->u <= high;
             ++even)
            even->v = std::min(even->v, v_at(a, b, even->u));
    }
    const auto reached = [](const SurfacePlace& place) { return std::isfinite(place.v); };
    const auto first = std::ranges::find_if(out, reached);
    if (out.end() - first < 2) return moved;
    for (auto even = out.begin(); even != first; ++even) even->v = v_at(first[0], first[1], even->u);
    for (auto even = first; even != out.end(); ++even)
        if (!reached(*even)) even->v = v_at(even[-2], even[-1], even->u);
    return out;
}

/// Parts of the front with v below the border, cut there; stubs left out.
std::vector<SurfacePlaces> SurfacePassLayer::parts_within(double border, double shortest_u) const {
    std::vector<SurfacePlaces> out;
    const auto cut = [&](const SurfacePlace& a, const SurfacePlace& b) {
        return SurfacePlace{a.u + (b.u - a.u) * (border - a.v) / (b.v - a.v), border};
    };
    for (std::size_t i = 0; i < front_.size(); ++i) {
        const bool inside = front_[i].v < border, was_inside = i > 0 && front_[i - 1].v < border;
        if (inside && !was_inside) out.emplace_back();
        if (i > 0 && inside != was_inside) out.back().push_back(cut(front_[i - 1], front_[i]));
        if (inside) out.back().push_back(front_[i]);
    }
    std::erase_if(out, [&](const SurfacePlaces& part) { return part.back().u - part.front().u < shortest_u; });
    return out;
}

}  // namespace trunnion::pipeline
