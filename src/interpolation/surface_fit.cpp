#include "trunnion/interpolation/surface_fit.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <fmt/format.h>

#include "trunnion/geometry/bspline_basis.hpp"

namespace trunnion::interpolation {

using geometry::BsplineCurve;
using geometry::SurfacePlace;

namespace {

constexpr int fullest_degree = 5;
constexpr double shortest_step_mm = 1e-9;

/// Places with the length of their polyline.
struct Polyline {
    std::vector<SurfacePlace> places;
    std::vector<double> length_mm;
    std::size_t size() const { return places.size(); }
};

Polyline polyline_of(const geometry::BsplineSurface& surface, std::span<const SurfacePlace> places) {
    Polyline out;
    Eigen::Vector3d before(0, 0, 0);
    for (const SurfacePlace& place : places) {
        const Eigen::Vector3d point = surface.at(place.u, place.v);
        const double step = out.places.empty() ? 0 : (point - before).norm();
        if (!out.places.empty() && !(step > shortest_step_mm)) continue;
        out.length_mm.push_back(out.places.empty() ? 0 : out.length_mm.back() + step);
        out.places.push_back(place);
        before = point;
    }
    return out;
}

/// Knots such that every interval holds as many places as any other; as many control points as places: averages, which
/// interpolate (Piegl & Tiller, The NURBS Book, eq. 9.8, 9.68 and 9.69).
std::vector<double> knots_for(const std::vector<double>& t, std::size_t points, int degree) {
    const auto p = static_cast<std::size_t>(degree);
    std::vector<double> out(p + 1, t.front());
    for (std::size_t j = 1; j + p < points; ++j) {
        if (points == t.size()) {
            double sum = 0;
            for (std::size_t i = j; i < j + p; ++i) sum += t[i];
            out.push_back(sum / static_cast<double>(p));
            continue;
        }
        const double at = static_cast<double>(j) * static_cast<double>(t.size()) / static_cast<double>(points - p);
        const auto i = static_cast<std::size_t>(at);
        const double share = at - static_cast<double>(i);
        out.push_back((1 - share) * t[i - 1] + share * t[i]);
    }
    out.resize(out.size() + p + 1, t.back());
    return out;
}

/// Symmetric positive definite equations with few diagonals, for u and v at once: Cholesky's LDLᵀ in place.
class BandedEquations {
  public:
    explicit BandedEquations(std::size_t size) : rows_(size), right_(size, Eigen::Vector2d(0, 0)) {}

    void add(std::size_t i, std::size_t j, double value) {
        if (j <= i) rows_[i][i - j] += value;
    }
    void add_right(std::size_t i, const Eigen::Vector2d& value) { right_[i] += value; }

    /// False: not positive definite.
    bool solve(std::vector<Eigen::Vector2d>& x) {
        for (std::size_t i = 0; i < rows_.size(); ++i)
            if (!eliminate(i)) return false;
        x = right_;
        for (std::size_t i = 0; i < x.size(); ++i)
            for (std::size_t k = 1; k <= reach(i); ++k) x[i] -= rows_[i][k] * x[i - k];
        for (std::size_t i = 0; i < x.size(); ++i) x[i] /= rows_[i][0];
        for (std::size_t i = x.size(); i-- > 0;)
            for (std::size_t k = 1; k <= reach(i); ++k) x[i - k] -= rows_[i][k] * x[i];
        return true;
    }

  private:
    static std::size_t reach(std::size_t i) { return std::min<std::size_t>(i, fullest_degree); }

    bool eliminate(std::size_t i) {
        auto& row = rows_[i];
        const double whole = row[0];
        for (std::size_t k = reach(i); k > 0; --k) {
            const std::size_t j = i - k;
            for (std::size_t m = k + 1; m <= reach(i) && m - k <= reach(j); ++m)
                row[k] -= row[m] * rows_[j][m - k];  // rows of i still times D
        }
        for (std::size_t k = 1; k <= reach(i); ++k) {
            const double scaled = row[k] / rows_[i - k][0];
            row[0] -= scaled * row[k];
            row[k] = scaled;
        }
        return row[0] > 1e-13 * whole;
    }

    std::vector<std::array<double, fullest_degree + 1>> rows_;  // [i][k]: element (i, i − k)
    std::vector<Eigen::Vector2d> right_;
};

Eigen::Vector2d as_vector(const SurfacePlace& place) {
    return {place.u, place.v};
}

/// Least squares with the first and last control point given. Nothing where the places do not determine it.
Result<BsplineCurve> least_squares(const Polyline& line, std::size_t points, int degree) {
    std::vector<double> knots = knots_for(line.length_mm, points, degree);
    const std::size_t free = points - 2;
    BandedEquations equations(free);
    const Eigen::Vector2d first = as_vector(line.places.front()), last = as_vector(line.places.back());
    for (std::size_t i = 1; i + 1 < line.size(); ++i) {
        const auto basis = geometry::basis_functions(degree, knots, line.length_mm[i]);
        Eigen::Vector2d rest = as_vector(line.places[i]);
        for (std::size_t k = 0; k <= static_cast<std::size_t>(degree); ++k) {
            if (basis.first + k == 0) rest -= basis.derivative[0][k] * first;
            if (basis.first + k == points - 1) rest -= basis.derivative[0][k] * last;
        }
        for (std::size_t k = 0; k <= static_cast<std::size_t>(degree); ++k) {
            const std::size_t row = basis.first + k - 1;  // of the ends beyond `free`
            if (row >= free) continue;
            equations.add_right(row, basis.derivative[0][k] * rest);
            for (std::size_t m = 0; m <= static_cast<std::size_t>(degree); ++m)
                if (const std::size_t column = basis.first + m - 1; column < free)
                    equations.add(row, column, basis.derivative[0][k] * basis.derivative[0][m]);
        }
    }
    std::vector<Eigen::Vector2d> solution;
    if (!equations.solve(solution))
        return fail({.code = "INTP0005", .text = "the places of a pass do not make a curve"});
    std::vector<Eigen::Vector3d> control{{first.x(), first.y(), 0}};
    for (const Eigen::Vector2d& x : solution) control.emplace_back(x.x(), x.y(), 0);
    control.emplace_back(last.x(), last.y(), 0);
    return BsplineCurve::make(degree, std::move(knots), std::move(control));
}

/// Largest distance of a place from the curve, across it.
double deviation_mm(const geometry::BsplineSurface& surface, const Polyline& line, const BsplineCurve& curve) {
    double largest = 0;
    for (std::size_t i = 0; i < line.size(); ++i) {
        const geometry::CurvePoint at = curve.evaluate(line.length_mm[i]);
        const geometry::SurfacePoint s = surface.evaluate(at[0].x(), at[0].y());
        const Eigen::Vector3d along = (at[1].x() * s.by_u + at[1].y() * s.by_v).normalized();
        const Eigen::Vector3d off = surface.at(line.places[i].u, line.places[i].v) - s.at;
        largest = std::max(largest, (off - off.dot(along) * along).norm());
    }
    return largest;
}

}  // namespace

Result<BsplineCurve> fit_places(const geometry::BsplineSurface& surface, std::span<const SurfacePlace> places,
                                double tolerance_mm) {
    const Polyline line = polyline_of(surface, places);
    if (line.size() < 2)
        return fail({.code = "INTP0005",
                     .text = "a pass needs two places apart",
                     .value = fmt::format("{}", line.size()),
                     .limit = "2"});
    const std::size_t all = line.size();
    const int degree = std::min(fullest_degree, static_cast<int>(all) - 1);
    // With fewer than two places an interval of knots the ends are hardly determined: the curve runs off between
    // places.
    const std::size_t most = all / 2 + static_cast<std::size_t>(degree);
    constexpr std::size_t fewest = 8;
    for (std::size_t points = std::min(all, fewest); points < all && points <= most; points += points / 3) {
        auto curve = least_squares(line, points, degree);
        if (curve && deviation_mm(surface, line, *curve) <= tolerance_mm) return curve;
    }
    return least_squares(line, all, degree);
}

}  // namespace trunnion::interpolation
