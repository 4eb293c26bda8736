#include "detail/bezier_patch.hpp"

#include <algorithm>
#include <cmath>

#include "trunnion/geometry/bspline_curve.hpp"

#include "detail/bernstein.hpp"

namespace trunnion::surfacing::detail {

using Eigen::Vector3d;
using Eigen::Vector4d;
using geometry::BezierPiece;
using geometry::BsplineCurve;

namespace {

BsplineCurve curve_of(const geometry::SurfaceDirection& direction, const std::vector<Vector4d>& homogeneous) {
    std::vector<Vector3d> points;
    std::vector<double> weights;
    for (const Vector4d& p : homogeneous) {
        points.push_back(p.head<3>() / p[3]);
        weights.push_back(p[3]);
    }
    // Knots come from a surface that has been made already.
    return BsplineCurve::make(direction.degree, direction.knots, std::move(points), std::move(weights)).value();
}

std::vector<BsplineCurve> columns_of(const geometry::BsplineSurface& surface) {
    const std::size_t rows = surface.u().points(), columns = surface.v().points();
    std::vector<BsplineCurve> out;
    for (std::size_t j = 0; j < columns; ++j) {
        std::vector<Vector4d> points;
        for (std::size_t i = 0; i < rows; ++i) {
            const std::size_t k = i * columns + j;
            const double w = surface.weights().empty() ? 1 : surface.weights()[k];
            const Vector3d& p = surface.control_points_mm()[k];
            points.emplace_back(w * p.x(), w * p.y(), w * p.z(), w);
        }
        out.push_back(curve_of(surface.u(), points));
    }
    return out;
}

/// Bounds of the first and second derivatives over a patch.
struct Bounds {
    double u = 0, v = 0, uu = 0, uv = 0, vv = 0;
};

template <class Net>
Bounds bounds_of(int p, int q, const Net& net) {
    Bounds out;
    const auto size = [](const auto& x) { return x.norm(); };
    for (int i = 0; i <= p; ++i)
        for (int j = 0; j <= q; ++j) {
            if (i < p) out.u = std::max(out.u, p * size(net(i + 1, j) - net(i, j)));
            if (j < q) out.v = std::max(out.v, q * size(net(i, j + 1) - net(i, j)));
            if (i + 1 < p) out.uu = std::max(out.uu, p * (p - 1) * size(net(i + 2, j) - 2 * net(i + 1, j) + net(i, j)));
            if (j + 1 < q) out.vv = std::max(out.vv, q * (q - 1) * size(net(i, j + 2) - 2 * net(i, j + 1) + net(i, j)));
            if (i < p && j < q)
                out.uv = std::max(out.uv, p * q * size(net(i + 1, j + 1) - net(i + 1, j) - net(i, j + 1) + net(i, j)));
        }
    return out;
}

bool has_even_weights(const BezierPatch& patch) {
    return std::ranges::all_of(patch.control, [&](const Vector4d& c) { return c[3] == patch.control.front()[3]; });
}

Bounds of_polynomial(const BezierPatch& patch) {
    const double weight = patch.control.front()[3];
    Bounds s =
        bounds_of(patch.degree_u, patch.degree_v, [&](int i, int j) -> Vector3d { return patch.at(i, j).head<3>(); });
    for (double* bound : {&s.u, &s.v, &s.uu, &s.uv, &s.vv}) *bound /= weight;
    return s;
}

/// By polynomials: with A = w S, P = w A_u − w_u A = w² S_u and w P_u − 2 w_u P = w³ S_uu, and so on. Norms of A's own
/// differences would count what cancels: of a cylinder the twist that weights feign.
Bounds of_rational(const BezierPatch& patch) {
    const Vector3d zero = Vector3d::Zero(), middle = patch.control.front().head<3>() / patch.control.front()[3];
    const auto w =
        bernstein<double>(patch.degree_u, patch.degree_v, 0.0, [&](int i, int j) { return patch.at(i, j)[3]; });
    const auto a = bernstein<Vector3d>(patch.degree_u, patch.degree_v, zero, [&](int i, int j) -> Vector3d {
        return patch.at(i, j).head<3>() - patch.at(i, j)[3] * middle;
    });
    const auto w_u = by_u(w), w_v = by_v(w);
    const auto p = minus(times(w, by_u(a)), times(w_u, a)), q = minus(times(w, by_v(a)), times(w_v, a));
    const auto twice = [](VectorBernstein b) {
        for (Vector3d& c : b.c) c *= 2;
        return b;
    };
    const double least = range(w).low, square = least * least, cube = square * least;
    Bounds s;
    s.u = longest(p) / square;
    s.v = longest(q) / square;
    s.uu = longest(minus(times(w, by_u(p)), twice(times(w_u, p)))) / cube;
    s.uv = longest(minus(times(w, by_v(p)), twice(times(w_v, p)))) / cube;
    s.vv = longest(minus(times(w, by_v(q)), twice(times(w_v, q)))) / cube;
    return s;
}

/// Both halves of one row of control points at their middle.
void halve(std::vector<Vector4d>& row, std::vector<Vector4d>& second) {
    const std::size_t n = row.size();
    second.resize(n);
    std::vector<Vector4d> work = row;
    for (std::size_t level = 0; level < n; ++level) {
        row[level] = work.front();
        second[n - 1 - level] = work.back();
        for (std::size_t k = 0; k + 1 < work.size(); ++k) work[k] = 0.5 * (work[k] + work[k + 1]);
        work.pop_back();
    }
}

}  // namespace

std::array<BezierPatch, 2> BezierPatch::halves(bool across_u) const {
    std::array<BezierPatch, 2> out{*this, *this};
    const int axis = across_u ? 0 : 1;
    out[0].high[axis] = out[1].low[axis] = 0.5 * (low[axis] + high[axis]);
    const int lines = across_u ? degree_v : degree_u, along = across_u ? degree_u : degree_v;
    const std::size_t columns = static_cast<std::size_t>(degree_v) + 1;
    std::vector<Vector4d> first, second;
    for (int line = 0; line <= lines; ++line) {
        const auto index = [&](int k) {
            return across_u ? static_cast<std::size_t>(k) * columns + static_cast<std::size_t>(line)
                            : static_cast<std::size_t>(line) * columns + static_cast<std::size_t>(k);
        };
        first.clear();
        for (int k = 0; k <= along; ++k) first.push_back(control[index(k)]);
        halve(first, second);
        for (int k = 0; k <= along; ++k) {
            out[0].control[index(k)] = first[static_cast<std::size_t>(k)];
            out[1].control[index(k)] = second[static_cast<std::size_t>(k)];
        }
    }
    return out;
}

BezierPatch::Bend BezierPatch::bend() const {
    const Bounds s = has_even_weights(*this) ? of_polynomial(*this) : of_rational(*this);
    const bool twisted = s.uv > std::max(s.uu, s.vv);
    return {0.25 * (std::max(s.uu, s.vv) + s.uv), twisted ? s.u > s.v : s.uu > s.vv};
}

std::vector<double> breaks_of(const geometry::SurfaceDirection& direction, double from, double to) {
    std::vector<double> out{from};
    for (const double knot : direction.knots)
        if (knot > out.back() && knot < to) out.push_back(knot);
    out.push_back(to);
    return out;
}

std::vector<BezierPatch> patches_of(const geometry::BsplineSurface& surface, const std::vector<double>& u_breaks,
                                    const std::vector<double>& v_breaks) {
    const std::vector<BsplineCurve> columns = columns_of(surface);
    const int p = surface.u().degree, q = surface.v().degree;
    std::vector<BezierPatch> out;
    for (std::size_t a = 0; a + 1 < u_breaks.size(); ++a) {
        std::vector<std::vector<Vector4d>> strip(static_cast<std::size_t>(p) + 1);
        for (const BsplineCurve& column : columns) {
            const BezierPiece piece = column.piece(u_breaks[a], u_breaks[a + 1]);
            for (std::size_t i = 0; i < strip.size(); ++i) strip[i].push_back(piece.control[i]);
        }
        std::vector<BsplineCurve> rows;
        for (const auto& row : strip) rows.push_back(curve_of(surface.v(), row));
        for (std::size_t b = 0; b + 1 < v_breaks.size(); ++b) {
            BezierPatch patch{.degree_u = p,
                              .degree_v = q,
                              .control = {},
                              .low = {u_breaks[a], v_breaks[b]},
                              .high = {u_breaks[a + 1], v_breaks[b + 1]}};
            for (const BsplineCurve& row : rows) {
                const BezierPiece piece = row.piece(v_breaks[b], v_breaks[b + 1]);
                patch.control.insert(patch.control.end(), piece.control.begin(), piece.control.begin() + q + 1);
            }
            out.push_back(std::move(patch));
        }
    }
    return out;
}

}  // namespace trunnion::surfacing::detail
