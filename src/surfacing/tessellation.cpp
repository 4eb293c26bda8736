#include "detail/tessellation.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>
#include <vector>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "detail/bezier_patch.hpp"

namespace trunnion::surfacing::detail {

using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

template <class Visit>
void each_edge(const Face& face, const Visit& visit) {
    for (const Loop& loop : face.loops)
        for (std::size_t i = 0, before = loop.size() - 1; i < loop.size(); before = i++) visit(loop[before], loop[i]);
}

/// Whether an edge has points inside the open rectangle: what its part within the slab of v leaves of u.
bool crosses(const Vector2d& a, const Vector2d& b, const Vector2d& low, const Vector2d& high) {
    double from = 0, to = 1;
    for (int axis = 0; axis < 2; ++axis) {
        const double way = b[axis] - a[axis];
        if (way == 0) {
            if (a[axis] <= low[axis] || a[axis] >= high[axis]) return false;
            continue;
        }
        const double enter = (low[axis] - a[axis]) / way, leave = (high[axis] - a[axis]) / way;
        from = std::max(from, std::min(enter, leave));
        to = std::min(to, std::max(enter, leave));
    }
    return from < to;
}

using Edges = std::vector<std::pair<Vector2d, Vector2d>>;

Edges edges_of(const Face& face) {
    Edges out;
    each_edge(face, [&](const Vector2d& a, const Vector2d& b) { out.emplace_back(a, b); });
    return out;
}

/// Those that a patch's height has to do with.
Edges beside(const Edges& edges, const BezierPatch& patch) {
    Edges out;
    std::ranges::copy_if(edges, std::back_inserter(out), [&](const auto& edge) {
        const auto& [a, b] = edge;
        return std::min(a.y(), b.y()) <= patch.high.y() && std::max(a.y(), b.y()) >= patch.low.y();
    });
    return out;
}

/// The part of a face within one patch, cut at every height v where a border begins, ends or leaves the patch: between
/// two such heights borders are straight and do not meet, so that pairs of them enclose trapezoids.
class Cut {
  public:
    Cut(const Edges& edges, const BezierPatch& patch) : patch_(patch) {
        heights_ = {patch.low.y(), patch.high.y()};
        for (const auto& [a, b] : edges) {
            add_height(a.y());
            if (a.y() == b.y()) continue;
            edges_.emplace_back(a, b);
            add_height(b.y());
            for (const double u : {patch_.low.x(), patch_.high.x()})
                if ((a.x() < u) != (b.x() < u)) add_height(a.y() + (b.y() - a.y()) * (u - a.x()) / (b.x() - a.x()));
        }
        std::ranges::sort(heights_);
    }

    template <class Trapezoid>
    void each(const Trapezoid& trapezoid) const {
        for (std::size_t k = 0; k + 1 < heights_.size(); ++k)
            if (heights_[k] < heights_[k + 1]) slab(heights_[k], heights_[k + 1], trapezoid);
    }

  private:
    void add_height(double v) {
        if (v > patch_.low.y() && v < patch_.high.y()) heights_.push_back(v);
    }
    double u_at(const std::pair<Vector2d, Vector2d>& edge, double v) const {
        const auto& [a, b] = edge;
        const double u = a.x() + (b.x() - a.x()) * (v - a.y()) / (b.y() - a.y());
        return std::clamp(u, patch_.low.x(), patch_.high.x());
    }
    template <class Trapezoid>
    void slab(double from, double to, const Trapezoid& trapezoid) const {
        std::vector<const std::pair<Vector2d, Vector2d>*> across;
        const double middle = 0.5 * (from + to);
        for (const auto& edge : edges_)
            if ((edge.first.y() > middle) != (edge.second.y() > middle)) across.push_back(&edge);
        std::ranges::sort(across, {}, [&](const auto* edge) { return u_at(*edge, middle); });
        for (std::size_t k = 0; k + 1 < across.size(); k += 2)
            trapezoid(Vector2d(u_at(*across[k], from), from), Vector2d(u_at(*across[k + 1], from), from),
                      Vector2d(u_at(*across[k + 1], to), to), Vector2d(u_at(*across[k], to), to));
    }

    const BezierPatch& patch_;
    std::vector<double> heights_;
    Edges edges_;
};

class Tessellation {
  public:
    Tessellation(const Face& face, std::int32_t index, double tolerance, std::vector<Triangle>& out)
        : face_(face), index_(index), tolerance_(tolerance), out_(out) {}

    void divide(const BezierPatch& patch, std::size_t most) { divide(patch, edges_of(face_), most); }

  private:
    /// `edges`: of the face, that may go through the patch.
    void divide(const BezierPatch& patch, const Edges& edges, std::size_t most) {
        if (out_.size() > most) return;
        const Edges here = beside(edges, patch);
        const auto goes_through = [&](const auto& edge) {
            return crosses(edge.first, edge.second, patch.low, patch.high);
        };
        const Vector2d middle = 0.5 * (patch.low + patch.high);
        if (std::ranges::none_of(here, goes_through)) {
            if (contains(face_, {middle.x(), middle.y()})) fill(patch, most);
        } else if (const BezierPatch::Bend bend = patch.bend(); bend.triangle_error_mm > tolerance_) {
            for (const BezierPatch& half : patch.halves(bend.more_along_u)) divide(half, here, most);
        } else {
            Cut(here, patch).each([&](const auto&... corners) { add(corners...); });
        }
    }
    /// Of a patch that is all within the face.
    void fill(const BezierPatch& patch, std::size_t most) {
        if (out_.size() > most) return;
        if (const BezierPatch::Bend bend = patch.bend(); bend.triangle_error_mm > tolerance_)
            for (const BezierPatch& half : patch.halves(bend.more_along_u)) fill(half, most);
        else
            add({patch.low.x(), patch.low.y()}, {patch.high.x(), patch.low.y()}, {patch.high.x(), patch.high.y()},
                {patch.low.x(), patch.high.y()});
    }
    /// Corners turning left in (u, v).
    void add(const Vector2d& a, const Vector2d& b, const Vector2d& c, const Vector2d& d) {
        const auto at = [&](const Vector2d& p) { return face_.surface.at(p.x(), p.y()); };
        const Vector3d pa = at(a), pb = at(b), pc = at(c), pd = at(d);
        add(pa, pb, pc);
        add(pa, pc, pd);
    }
    void add(const Vector3d& a, const Vector3d& b, const Vector3d& c) {
        constexpr double flat = 1e-24;
        if ((b - a).cross(c - a).squaredNorm() < flat) return;
        out_.push_back({face_.side == geometry::Side::along ? std::array{a, b, c} : std::array{a, c, b}, index_});
    }

    const Face& face_;
    std::int32_t index_;
    double tolerance_;
    std::vector<Triangle>& out_;
};

}  // namespace

Overlap overlap(const Face& face, const Vector2d& low, const Vector2d& high) {
    bool crossed = false;
    each_edge(face, [&](const Vector2d& a, const Vector2d& b) { crossed = crossed || crosses(a, b, low, high); });
    if (crossed) return Overlap::part;
    const Vector2d middle = 0.5 * (low + high);
    return contains(face, {middle.x(), middle.y()}) ? Overlap::all : Overlap::none;
}

Result<void> tessellate(const Face& face, std::int32_t index, double tolerance, std::size_t most,
                        std::vector<Triangle>& out) {
    const ParameterBox box = parameter_box(face);
    const geometry::BsplineSurface& surface = face.surface;
    const Vector2d low = box.low.cwiseMax(Vector2d(surface.u().begin(), surface.v().begin()));
    const Vector2d high = box.high.cwiseMin(Vector2d(surface.u().end(), surface.v().end()));
    const auto patches =
        patches_of(surface, breaks_of(surface.u(), low.x(), high.x()), breaks_of(surface.v(), low.y(), high.y()));
    // The error falls with the square of the fineness, so that cells are in proportion to it.
    double expected = 0;
    for (const BezierPatch& patch : patches)
        if (overlap(face, patch.low, patch.high) != Overlap::none)
            expected += patch.bend().triangle_error_mm / tolerance;
    constexpr double far_too_many = 20;  // coarse patches are far from what they bound
    Tessellation tessellation(face, index, tolerance, out);
    if (expected < far_too_many * static_cast<double>(most))
        for (const BezierPatch& patch : patches) tessellation.divide(patch, most);
    if (out.size() <= most && expected < far_too_many * static_cast<double>(most)) return {};
    return fail({.code = "SURF0302",
                 .text = fmt::format("the part's faces within {:.3g} mm take too many triangles", tolerance),
                 .limit = fmt::format("{} triangles", most),
                 .hint = "a coarser tolerance, or fewer faces"});
}

}  // namespace trunnion::surfacing::detail
