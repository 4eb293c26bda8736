#include "trunnion/geometry/bspline_surface.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "trunnion/geometry/bspline_basis.hpp"
#include "trunnion/geometry/bspline_curve.hpp"

namespace trunnion::geometry {

namespace {

/// Σ Σ B_k(u) B_l(v) · net(k, l) for the six pairs of orders (0,0) (1,0) (0,1) (2,0) (1,1) (0,2).
template <class Point, class Net>
std::array<Point, 6> sums(const BasisFunctions& u, int degree_u, const BasisFunctions& v, int degree_v,
                          const Net& net) noexcept {
    std::array<Point, 6> out;
    out.fill(Point::Zero());
    for (int k = 0; k <= degree_u; ++k) {
        std::array<Point, 3> row;
        row.fill(Point::Zero());
        for (int l = 0; l <= degree_v; ++l) {
            const Point p = net(u.first + static_cast<std::size_t>(k), v.first + static_cast<std::size_t>(l));
            for (int order = 0; order < 3; ++order) row[order] += v.derivative[order][l] * p;
        }
        const double b0 = u.derivative[0][k], b1 = u.derivative[1][k], b2 = u.derivative[2][k];
        out[0] += b0 * row[0];
        out[1] += b1 * row[0];
        out[2] += b0 * row[1];
        out[3] += b2 * row[0];
        out[4] += b1 * row[1];
        out[5] += b0 * row[2];
    }
    return out;
}

SurfacePoint quotient(const std::array<Eigen::Vector4d, 6>& h) noexcept {
    const auto a = [&](int k) -> Eigen::Vector3d { return h[k].head<3>(); };
    const auto w = [&](int k) { return h[k][3]; };
    SurfacePoint s;
    s.at = a(0) / w(0);
    s.by_u = (a(1) - w(1) * s.at) / w(0);
    s.by_v = (a(2) - w(2) * s.at) / w(0);
    s.by_uu = (a(3) - 2 * w(1) * s.by_u - w(3) * s.at) / w(0);
    s.by_uv = (a(4) - w(1) * s.by_v - w(2) * s.by_u - w(4) * s.at) / w(0);
    s.by_vv = (a(5) - 2 * w(2) * s.by_v - w(5) * s.at) / w(0);
    return s;
}

/// Bernstein coefficients of one direction from those of powers, in place: b_k = Σ_i C(k, i)/C(n, i) a_i.
void powers_to_bernstein(Eigen::Vector3d* a, int n, std::size_t stride) {
    const auto binomial = [](int m, int k) {
        double out = 1;
        for (int i = 0; i < k; ++i) out = out * (m - i) / (i + 1);
        return out;
    };
    for (int k = n; k >= 0; --k) {
        Eigen::Vector3d sum = Eigen::Vector3d::Zero();
        for (int i = 0; i <= k; ++i) sum += binomial(k, i) / binomial(n, i) * a[static_cast<std::size_t>(i) * stride];
        a[static_cast<std::size_t>(k) * stride] = sum;
    }
}

SurfaceDirection one_piece(int degree) {
    SurfaceDirection out{.degree = degree, .knots = {}};
    if (degree < 1 || degree > max_degree) return out;
    out.knots.assign(static_cast<std::size_t>(degree) + 1, 0.0);
    out.knots.resize(2 * out.knots.size(), 1.0);
    return out;
}

struct Range {
    double from, to;
    double clamp(double x) const noexcept { return std::clamp(x, from, to); }
};

Range range_of(const SurfaceDirection& direction, double margin) noexcept {
    const double more = margin * (direction.end() - direction.begin());
    return {direction.begin() - more, direction.end() + more};
}

/// The step that Newton's method takes for (S − x)·S_u = (S − x)·S_v = 0; without the second derivatives where they
/// would lead away from the point.
Eigen::Vector2d newton_step(const SurfacePoint& s, const Eigen::Vector3d& off) noexcept {
    const Eigen::Vector2d slope(off.dot(s.by_u), off.dot(s.by_v));
    Eigen::Matrix2d first, all;
    first << s.by_u.squaredNorm(), s.by_u.dot(s.by_v), s.by_u.dot(s.by_v), s.by_v.squaredNorm();
    all << off.dot(s.by_uu), off.dot(s.by_uv), off.dot(s.by_uv), off.dot(s.by_vv);
    all += first;
    const bool convex = all(0, 0) > 0 && all.determinant() > 1e-3 * first.determinant();
    const Eigen::Matrix2d& matrix = convex ? all : first;
    const double determinant = matrix.determinant();
    if (!(determinant > 0))
        return {-slope[0] / std::max(first(0, 0), 1e-300), -slope[1] / std::max(first(1, 1), 1e-300)};
    return {(matrix(0, 1) * slope[1] - matrix(1, 1) * slope[0]) / determinant,
            (matrix(0, 1) * slope[0] - matrix(0, 0) * slope[1]) / determinant};
}

}  // namespace

Result<BsplineSurface> BsplineSurface::make(SurfaceDirection u, SurfaceDirection v, std::vector<Eigen::Vector3d> points,
                                            std::vector<double> weights) {
    const std::size_t rows = u.points(), columns = v.points();
    const auto refused = [&](const SurfaceDirection& direction, std::size_t along) {
        return BsplineCurve::make(direction.degree, direction.knots, std::vector(along, Eigen::Vector3d(0, 0, 0)));
    };
    if (const auto curve = refused(u, rows); !curve) return fail(curve.error());
    if (const auto curve = refused(v, columns); !curve) return fail(curve.error());
    if (points.size() != rows * columns)
        return fail(
            {.code = "GEOM0102", .text = "the control points of a surface are not rows × columns of its knots"});
    if (!std::ranges::all_of(points, [](const Eigen::Vector3d& p) { return p.allFinite(); }))
        return fail({.code = "GEOM0105", .text = "a control point of a surface is not finite"});
    const bool positive = std::ranges::all_of(weights, [](double w) { return w > 0 && std::isfinite(w); });
    if (!positive || (!weights.empty() && weights.size() != points.size()))
        return fail(
            {.code = "GEOM0107", .text = "the weights of a surface are not one a control point, or not all positive"});
    BsplineSurface out;
    out.u_ = std::move(u);
    out.v_ = std::move(v);
    out.points_ = std::move(points);
    out.weights_ = std::move(weights);
    return out;
}

SurfacePoint BsplineSurface::evaluate(double u, double v) const noexcept {
    const BasisFunctions by_u = basis_functions(u_.degree, u_.knots, u), by_v = basis_functions(v_.degree, v_.knots, v);
    const std::size_t columns = v_.points();
    if (weights_.empty()) {
        const auto s = sums<Eigen::Vector3d>(by_u, u_.degree, by_v, v_.degree,
                                             [&](std::size_t i, std::size_t j) { return points_[i * columns + j]; });
        return {s[0], s[1], s[2], s[3], s[4], s[5]};
    }
    return quotient(
        sums<Eigen::Vector4d>(by_u, u_.degree, by_v, v_.degree, [&](std::size_t i, std::size_t j) -> Eigen::Vector4d {
            const std::size_t k = i * columns + j;
            return {weights_[k] * points_[k].x(), weights_[k] * points_[k].y(), weights_[k] * points_[k].z(),
                    weights_[k]};
        }));
}

Result<BsplineSurface> polynomial_surface(int degree_u, int degree_v,
                                          const std::vector<Eigen::Vector3d>& coefficients) {
    SurfaceDirection u = one_piece(degree_u), v = one_piece(degree_v);
    auto points = coefficients;
    const std::size_t rows = u.points(), columns = v.points();
    if (rows > 0 && columns > 0 && points.size() == rows * columns) {
        for (std::size_t i = 0; i < rows; ++i) powers_to_bernstein(&points[i * columns], degree_v, 1);
        for (std::size_t j = 0; j < columns; ++j) powers_to_bernstein(&points[j], degree_u, columns);
    }
    return BsplineSurface::make(std::move(u), std::move(v), std::move(points));
}

SurfacePlace closest_place(const BsplineSurface& surface, const Eigen::Vector3d& point, SurfacePlace guess,
                           double margin) noexcept {
    const Range u = range_of(surface.u(), margin), v = range_of(surface.v(), margin);
    SurfacePlace place{u.clamp(guess.u), v.clamp(guess.v)};
    SurfacePoint s = surface.evaluate(place.u, place.v);
    double distance = (s.at - point).squaredNorm();
    for (int step = 0; step < 20; ++step) {
        Eigen::Vector2d way = newton_step(s, s.at - point);
        // At a border that it would cross, the other parameter alone is free.
        const bool u_held = u.clamp(place.u + way[0]) == place.u, v_held = v.clamp(place.v + way[1]) == place.v;
        if (u_held != v_held && u_held) way[1] = -(s.at - point).dot(s.by_v) / s.by_v.squaredNorm();
        if (u_held != v_held && v_held) way[0] = -(s.at - point).dot(s.by_u) / s.by_u.squaredNorm();
        bool nearer = false;
        for (int halving = 0; halving < 8 && !nearer; ++halving, way *= 0.5) {
            const SurfacePlace next{u.clamp(place.u + way[0]), v.clamp(place.v + way[1])};
            const SurfacePoint there = surface.evaluate(next.u, next.v);
            const double off = (there.at - point).squaredNorm();
            nearer = off < distance;
            if (!nearer) continue;
            place = next;
            s = there;
            distance = off;
        }
        if (!nearer || (way[0] * s.by_u + way[1] * s.by_v).squaredNorm() < 1e-24) break;
    }
    return place;
}

SurfacePlace closest_place(const BsplineSurface& surface, const Eigen::Vector3d& point, int per_interval) noexcept {
    SurfacePlace best{surface.u().begin(), surface.v().begin()};
    double least = (surface.at(best.u, best.v) - point).squaredNorm();
    const auto each_place = [per_interval](const SurfaceDirection& direction, const auto& visit) {
        for (std::size_t s = static_cast<std::size_t>(direction.degree); s < direction.points(); ++s) {
            const double from = direction.knots[s], to = direction.knots[s + 1];
            for (int k = 0; from < to && k <= per_interval; ++k) visit(from + (to - from) * k / per_interval);
        }
    };
    each_place(surface.u(), [&](double u) {
        each_place(surface.v(), [&](double v) {
            const double off = (surface.at(u, v) - point).squaredNorm();
            if (off < least) least = off, best = {u, v};
        });
    });
    return closest_place(surface, point, best);
}

}  // namespace trunnion::geometry
