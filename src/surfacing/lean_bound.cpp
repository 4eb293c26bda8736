#include "detail/lean_bound.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "detail/patch_polynomials.hpp"

namespace trunnion::surfacing::detail {

using Eigen::Vector3d;

namespace {

/// Along the feed and along N × feed, both times something positive: S_u or S_v and N × it, or of a direction d what
/// is in the tangent plane of it, (N × d) × N, and N × d.
struct Tangents {
    VectorBernstein feed, across;
};
Tangents tangents_of(const FeedReference& feed, const PatchPolynomials& face, const VectorBernstein& normal) {
    if (feed.along == FeedReference::Along::u) return {face.along_u, cross(normal, face.along_u)};
    if (feed.along == FeedReference::Along::v) return {face.along_v, cross(normal, face.along_v)};
    const VectorBernstein d = bernstein<Vector3d>(0, 0, Vector3d(0, 0, 0), [&](int, int) { return feed.direction; });
    const VectorBernstein across = cross(normal, d);
    return {cross(across, normal), across};
}

/// A bound of |e − wanted|, e the component of a way along a direction D: way·D/|D|.
///
/// Either by |e| alone, or, where way·D has the sign of `wanted` everywhere, by e − t = (e² − t²)/(e + t) with e² − t²
/// = ((way·D)² − t² D²)/D², which has no root.
double component_error(const VectorBernstein& way, const VectorBernstein& direction, double wanted) {
    const ScalarBernstein along = dot(way, direction), square = dot(direction, direction);
    const double least_square = range(square).low;
    if (!(least_square > 0)) return std::numeric_limits<double>::infinity();
    const HullRange hull = range(along);
    const double largest = std::max(hull.high, -hull.low) / std::sqrt(least_square);
    const double by_length = largest + std::abs(wanted);
    const bool one_sided = wanted > 0 ? hull.low > 0 : hull.high < 0;
    if (wanted == 0 || !one_sided) return by_length;
    ScalarBernstein target = raised(2 * way.degree_u, 2 * way.degree_v, square);
    for (double& c : target.c) c *= wanted * wanted;
    const HullRange off = range(minus(times(along, along), target));
    return std::min(by_length, std::max(off.high, -off.low) / (least_square * std::abs(wanted)));
}

}  // namespace

double lean_error_bound_mm(const LeanField& field, const BezierPatch& face_patch, const BezierPatch& guiding,
                           const BezierPatch& orientation) {
    const PatchPolynomials face(face_patch);
    VectorBernstein normal = cross(face.along_u, face.along_v);
    if (field.side == geometry::Side::against)
        for (Vector3d& c : normal.c) c = -c;
    const VectorBernstein way = minus(points_of(orientation), points_of(guiding));
    const double tan_lead = std::tan(field.lean.lead_rad), tan_tilt = std::tan(field.lean.tilt_rad);
    const double up_mm = field.height_mm / std::hypot(1, tan_lead, tan_tilt);
    const Tangents tangents = tangents_of(field.feed, face, normal);
    const double off_normal = component_error(way, normal, up_mm);
    const double off_feed = component_error(way, tangents.feed, up_mm * tan_lead);
    const double off_across = component_error(way, tangents.across, up_mm * tan_tilt);
    return std::hypot(off_normal, off_feed, off_across);
}

}  // namespace trunnion::surfacing::detail
