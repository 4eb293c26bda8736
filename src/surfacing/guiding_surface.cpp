#include "trunnion/surfacing/guiding_surface.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include <fmt/format.h>

#include "detail/bernstein.hpp"
#include "detail/bezier_patch.hpp"
#include "detail/face_box.hpp"
#include "detail/tessellation.hpp"

namespace trunnion::surfacing {

using detail::BezierPatch;
using detail::ScalarBernstein;
using detail::VectorBernstein;
using Eigen::Vector3d;
using geometry::SurfacePlace;

namespace {

const Vector3d zero = Vector3d::Zero();

VectorBernstein points_of(const BezierPatch& patch) {
    return detail::bernstein<Vector3d>(patch.degree_u, patch.degree_v, zero,
                                       [&](int i, int j) -> Vector3d { return patch.at(i, j).head<3>(); });
}
ScalarBernstein weights_of(const BezierPatch& patch) {
    return detail::bernstein<double>(patch.degree_u, patch.degree_v, 0.0,
                                     [&](int i, int j) { return patch.at(i, j)[3]; });
}
bool even_weights(const BezierPatch& patch) {
    const double first = patch.control.front()[3];
    return std::ranges::all_of(patch.control,
                               [first](const Eigen::Vector4d& c) { return std::abs(c[3] - first) <= 1e-15 * first; });
}

VectorBernstein ones(int n, int m, const VectorBernstein& a) {
    const ScalarBernstein one = detail::bernstein<double>(n, m, 0.0, [](int, int) { return 1.0; });
    return detail::times(one, a);
}

/// A patch of the face and one of the guiding surface over the same rectangle: w S = A.
struct Offset {
    const BezierPatch &face, &guiding;
    double radius, turn;  ///< r; −1 where the normal is against S_u × S_v

    ScalarBernstein w() const {
        if (!even_weights(face)) return weights_of(face);
        return detail::bernstein<double>(0, 0, 0.0, [&](int, int) { return face.control.front()[3]; });
    }
    /// Along the normal: a multiple of S_u × S_v.
    VectorBernstein normal(const ScalarBernstein& weight, const VectorBernstein& a) const {
        return scaled(detail::normal_of(weight, a));
    }

    VectorBernstein scaled(VectorBernstein n) const {
        for (Vector3d& c : n.c) c *= turn;
        return n;
    }
};

struct OffsetBound {
    double error = std::numeric_limits<double>::infinity();
    bool regular = false;
};

OffsetBound bound_of(const Offset& offset) {
    using namespace detail;
    const ScalarBernstein w = offset.w();
    const VectorBernstein a = points_of(offset.face), t = points_of(offset.guiding);
    const double least_weight = range(w).low;
    const int n = std::max(w.degree_u + 3, a.degree_u), m = std::max(w.degree_v + 3, a.degree_v);
    const VectorBernstein tw = times(w, t);
    // w (S₁ − S), both parts raised to the same degrees.
    const VectorBernstein e =
        minus(ones(n - tw.degree_u, m - tw.degree_v, tw), ones(n - a.degree_u, m - a.degree_v, a));
    OffsetBound out;
    if (offset.radius == 0) return {longest(e) / least_weight, true};
    const VectorBernstein normal = offset.normal(w, a);
    const double least_normal = shortest(normal);
    out.regular = range(dot(offset.scaled(cross(by_u(t), by_v(t))), normal)).low > 0;
    if (!(least_normal > 0) || !(range(dot(e, normal)).low > 0)) return out;
    const double aside = longest(cross(e, normal)) / (least_weight * least_normal);
    const double square = offset.radius * offset.radius;
    ScalarBernstein ww = times(w, w);
    for (double& c : ww.c) c *= square;
    ScalarBernstein ee = dot(e, e);
    const ScalarBernstein raised = times(
        bernstein<double>(ee.degree_u - ww.degree_u, ee.degree_v - ww.degree_v, 0.0, [](int, int) { return 1.0; }), ww);
    const HullRange off = range(minus(std::move(ee), raised));
    const double more = std::max(off.high, 0.0) / (least_weight * least_weight);
    const double less = std::max(-off.low, 0.0) / (least_weight * least_weight) + aside * aside;
    // √(r² + x) − r without cancellation.
    const auto along = [&](double x) { return std::abs(x) / (std::sqrt(std::max(square + x, 0.0)) + offset.radius); };
    out.error = std::hypot(aside, std::max(along(more), along(-less)));
    return out;
}

class GuidingFit {
  public:
    GuidingFit(const Face& face, double radius, double tolerance)
        : face_(face), radius_(radius), tolerance_(tolerance) {}

    std::optional<Vector3d> value(const SurfacePlace& place) const {
        if (radius_ == 0) return face_.surface.at(place.u, place.v);
        const auto shape = shape_at(face_.surface, place, face_.side);
        if (!shape) return std::nullopt;
        return shape->point + radius_ * shape->normal;
    }

    std::vector<double> errors(const geometry::BsplineSurface& guiding, const detail::FitDirection& u,
                               const detail::FitDirection& v) {
        const auto faces = detail::patches_of(face_.surface, u.breaks, v.breaks),
                   fits = detail::patches_of(guiding, u.breaks, v.breaks);
        std::vector<double> out;
        folded_.reset();
        for (std::size_t k = 0; k < faces.size(); ++k) out.push_back(error(faces[k], fits[k], 0));
        return out;
    }

    /// Where the last fit could not be shown to be regular.
    const std::optional<SurfacePlace>& folded() const { return folded_; }

  private:
    double error(const BezierPatch& face, const BezierPatch& guiding, int level) {
        if (detail::overlap(face_, face.low, face.high) == detail::Overlap::none) return 0;
        const OffsetBound bound = bound_of({face, guiding, radius_, face_.side == geometry::Side::along ? 1.0 : -1.0});
        const bool known = std::isfinite(bound.error);
        if (known && (bound.regular || bound.error > tolerance_)) return bound.error;
        constexpr int deepest = 5;
        if (level == deepest) {
            const Eigen::Vector2d middle = 0.5 * (face.low + face.high);
            if (!bound.regular) folded_ = SurfacePlace{middle.x(), middle.y()};
            return bound.error;
        }
        double largest = 0;
        const bool across_u = level % 2 == 0;
        const auto a = face.halves(across_u), b = guiding.halves(across_u);
        for (int half = 0; half < 2; ++half) largest = std::max(largest, error(a[half], b[half], level + 1));
        return largest;
    }

    const Face& face_;
    double radius_, tolerance_;
    std::optional<SurfacePlace> folded_;
};

Diagnostic folds(const Face& face, const SurfacePlace& place, double radius) {
    const auto shape = shape_at(face.surface, place, face.side);
    const Vector3d at = face.surface.at(place.u, place.v);
    const double hollow = shape ? -geometry::principal_curvatures(shape->shape).smaller : 0;
    return {
        .code = "SURF0304",
        .text = fmt::format("the guiding surface folds over itself at ({:.3f} {:.3f} {:.3f})", at.x(), at.y(), at.z()),
        .value = hollow > 0 ? fmt::format("radius of the hollow {:.4g} mm", 1 / hollow) : std::string("no hollow"),
        .limit = fmt::format("corner radius {:.4g} mm", radius),
        .hint = "a tool with a smaller corner radius"};
}

/// The place of a grid within the face where the surface is hollowest, if r does not fit there.
std::optional<SurfacePlace> place_too_hollow(const Face& face, double radius) {
    const detail::FaceBox box = detail::face_box(face);
    double least = 0;
    std::optional<SurfacePlace> out;
    constexpr int places = 8;
    const auto each = [](const std::vector<double>& breaks, const auto& visit) {
        for (std::size_t k = 0; k + 1 < breaks.size(); ++k)
            for (int i = 0; i <= places; ++i) visit(breaks[k] + (breaks[k + 1] - breaks[k]) * i / places);
    };
    each(box.u.breaks, [&](double u) {
        each(box.v.breaks, [&](double v) {
            const auto shape = shape_at(face.surface, {u, v}, face.side);
            if (!shape || !contains(face, {u, v})) return;
            const double left = 1 + radius * geometry::principal_curvatures(shape->shape).smaller;
            if (left <= least) least = left, out = SurfacePlace{u, v};
        });
    });
    return out;
}

}  // namespace

Result<GuidingSurface> GuidingSurface::make(const Face& face, const Cutter& cutter, const GuidingOptions& options) {
    if (!(options.tolerance_mm > 0) || !std::isfinite(options.tolerance_mm))
        return fail({.code = "SURF0301",
                     .text = "the tolerance of a guiding surface is out of its range",
                     .value = fmt::format("{} mm", options.tolerance_mm),
                     .limit = "above 0"});
    const double radius = cutter.corner_mm();
    if (const auto hollow = place_too_hollow(face, radius); hollow && radius > 0)
        return fail(folds(face, *hollow, radius));
    if (radius > 0)
        if (auto smooth = detail::check_creases(face, options.tolerance_mm / radius); !smooth)
            return fail(std::move(smooth.error()));
    GuidingFit guiding(face, radius, options.tolerance_mm);
    const detail::FaceBox box = detail::face_box(face);
    auto made = detail::fit(
        box.u, box.v, [&](const SurfacePlace& place) { return guiding.value(place); },
        [&](const auto& surface, const auto& u, const auto& v) { return guiding.errors(surface, u, v); },
        options.tolerance_mm, options.most_patches);
    if (!made) return fail(std::move(made.error()));
    if (guiding.folded()) return fail(folds(face, *guiding.folded(), radius));
    return GuidingSurface(std::move(made->surface), made->error_mm, made->patches);
}

}  // namespace trunnion::surfacing
