#include <algorithm>
#include <cmath>

#include <Eigen/SparseCholesky>
#include <fmt/format.h>

#include "trunnion/geometry/bspline_basis.hpp"
#include "trunnion/geometry/rotation.hpp"
#include "trunnion/surfacing/orientation_surface.hpp"

#include "detail/spline_fit.hpp"

namespace trunnion::surfacing {

using Eigen::Vector3d;
using geometry::SurfacePlace;

namespace {

/// The equations of moves of control points: least squares of rows Σ coefficient · move = wanted.
class MoveEquations {
  public:
    MoveEquations(std::size_t rows, std::size_t columns)
        : columns_(columns),
          size_(static_cast<Eigen::Index>(rows * columns)),
          wanted_(Eigen::MatrixX3d::Zero(size_, 3)) {}

    struct Term {
        std::size_t row, column;
        double coefficient;
    };
    void add(const std::vector<Term>& terms, const Vector3d& wanted, double weight) {
        for (const Term& a : terms) {
            for (const Term& b : terms)
                entries_.emplace_back(index(a), index(b), weight * a.coefficient * b.coefficient);
            wanted_.row(index(a)) += weight * a.coefficient * wanted.transpose();
        }
    }

    std::vector<Vector3d> solve() const {
        Eigen::SparseMatrix<double> matrix(size_, size_);
        matrix.setFromTriplets(entries_.begin(), entries_.end());
        const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factors(matrix);
        const Eigen::MatrixX3d moves = factors.solve(wanted_);
        std::vector<Vector3d> out;
        for (Eigen::Index i = 0; i < size_; ++i) out.emplace_back(moves.row(i).transpose());
        return out;
    }

  private:
    int index(const Term& term) const { return static_cast<int>(term.row * columns_ + term.column); }
    std::size_t columns_;
    Eigen::Index size_;
    std::vector<Eigen::Triplet<double>> entries_;
    Eigen::MatrixX3d wanted_;
};

/// Second differences of neighbouring moves, and a little of the moves themselves.
void add_smoothness(MoveEquations& equations, std::size_t rows, std::size_t columns, double hold) {
    const Vector3d none = Vector3d::Zero();
    for (std::size_t i = 0; i < rows; ++i)
        for (std::size_t j = 0; j < columns; ++j) {
            equations.add({{i, j, 1}}, none, hold);
            if (i + 2 < rows) equations.add({{i, j, 1}, {i + 1, j, -2}, {i + 2, j, 1}}, none, 1);
            if (j + 2 < columns) equations.add({{i, j, 1}, {i, j + 1, -2}, {i, j + 2, 1}}, none, 1);
            if (i + 1 < rows && j + 1 < columns)
                equations.add({{i, j, 1}, {i + 1, j, -1}, {i, j + 1, -1}, {i + 1, j + 1, 1}}, none, 2);
        }
}

std::vector<MoveEquations::Term> terms_at(const geometry::BsplineSurface& surface, const SurfacePlace& place) {
    const auto u = geometry::basis_functions(3, surface.u().knots, place.u);
    const auto v = geometry::basis_functions(3, surface.v().knots, place.v);
    std::vector<MoveEquations::Term> out;
    for (std::size_t k = 0; k <= 3; ++k)
        for (std::size_t l = 0; l <= 3; ++l)
            out.push_back({u.first + k, v.first + l, u.derivative[0][k] * v.derivative[0][l]});
    return out;
}

bool within(const geometry::BsplineSurface& surface, const SurfacePlace& place) {
    return place.u >= surface.u().begin() && place.u <= surface.u().end() && place.v >= surface.v().begin() &&
           place.v <= surface.v().end();
}

Diagnostic outside(const SurfacePlace& place) {
    return {.code = "SURF0309",
            .text = "a place is outside the guiding and orientation surfaces",
            .value = fmt::format("u = {:.6g}, v = {:.6g}", place.u, place.v)};
}

}  // namespace

Result<OrientationSurface> OrientationSurface::with(std::vector<Vector3d> control_points) const {
    auto surface = geometry::BsplineSurface::make(surface_.u(), surface_.v(), std::move(control_points));
    if (!surface) return fail(std::move(surface.error()));
    OrientationSurface out = *this;
    out.surface_ = std::move(*surface);
    return out;
}

Result<OrientationSurface> OrientationSurface::turned(const SurfacePlace& place, double radius_mm,
                                                      const Vector3d& turn) const {
    if (!within(surface_, place)) return fail(outside(place));
    if (!(radius_mm > 0) || !turn.allFinite())
        return fail({.code = "SURF0301",
                     .text = "a region or its turn is out of its range",
                     .value = fmt::format("radius {} mm", radius_mm),
                     .limit = "above 0"});
    const auto u = detail::greville(surface_.u()), v = detail::greville(surface_.v());
    const Vector3d middle = guiding_.at(place);
    auto points = surface_.control_points_mm();
    for (std::size_t i = 0; i < u.size(); ++i)
        for (std::size_t j = 0; j < v.size(); ++j) {
            const Vector3d below = guiding_.at({u[i], v[j]});
            const double x = (below - middle).norm() / radius_mm;
            if (x >= 1 || turn.norm() == 0) continue;
            const double share = std::pow(1 - x * x, 3);
            Vector3d& point = points[i * v.size() + j];
            point = below + geometry::rotation_about(turn, share * turn.norm()) * (point - below);
        }
    auto out = with(std::move(points));
    return out ? out->checked() : out;
}

Result<OrientationSurface> OrientationSurface::towards(std::span<const OrientationTarget> targets, double hold) const {
    auto out = moved_towards(targets, hold);
    return out ? out->checked() : out;
}

Result<OrientationSurface> OrientationSurface::moved_towards(std::span<const OrientationTarget> targets,
                                                             double hold) const {
    const std::size_t rows = surface_.u().points(), columns = surface_.v().points();
    MoveEquations equations(rows, columns);
    add_smoothness(equations, rows, columns, hold);
    constexpr double pull = 10'000;
    for (const OrientationTarget& target : targets) {
        if (!within(surface_, target.place)) return fail(outside(target.place));
        if (auto allowed = check(target.place, target.axis); !allowed) return fail(std::move(allowed.error()));
        const Vector3d wanted = guiding_.at(target.place) + options_.height_mm * target.axis;
        equations.add(terms_at(surface_, target.place), wanted - surface_.at(target.place.u, target.place.v), pull);
    }
    auto points = surface_.control_points_mm();
    const auto moves = equations.solve();
    for (std::size_t k = 0; k < points.size(); ++k) points[k] += moves[k];
    return with(std::move(points));
}

Result<OrientationSurface> OrientationSurface::blended(const OrientationSurface& other,
                                                       const std::function<double(const SurfacePlace&)>& weight) const {
    if (surface_.u().knots != other.surface_.u().knots || surface_.v().knots != other.surface_.v().knots)
        return fail({.code = "SURF0301",
                     .text = "only orientation surfaces over the same knots are blended",
                     .hint = "make both with the same spacing and tolerance"});
    const auto u = detail::greville(surface_.u()), v = detail::greville(surface_.v());
    auto points = surface_.control_points_mm();
    for (std::size_t i = 0; i < u.size(); ++i)
        for (std::size_t j = 0; j < v.size(); ++j) {
            const double w = weight({u[i], v[j]});
            if (!(w >= 0 && w <= 1))
                return fail({.code = "SURF0301",
                             .text = "a weight of blending is out of its range",
                             .value = fmt::format("{}", w),
                             .limit = "0 … 1"});
            const std::size_t k = i * v.size() + j;
            points[k] = (1 - w) * points[k] + w * other.surface_.control_points_mm()[k];
        }
    auto out = with(std::move(points));
    return out ? out->checked() : out;
}

}  // namespace trunnion::surfacing
