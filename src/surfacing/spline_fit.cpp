#include "detail/spline_fit.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "trunnion/geometry/bspline_basis.hpp"

namespace trunnion::surfacing::detail {

using Eigen::Vector3d;
using geometry::SurfacePlace;

Collocation::Collocation(std::span<const double> knots, std::span<const double> sites) : rows_(sites.size()) {
    const int n = static_cast<int>(sites.size());
    for (int i = 0; i < n; ++i) {
        const auto basis = geometry::basis_functions(3, knots, sites[static_cast<std::size_t>(i)]);
        for (int k = 0; k <= 3; ++k) {
            const int off = static_cast<int>(basis.first) + k - i;
            if (std::abs(off) <= reach) rows_[static_cast<std::size_t>(i)].entry[off + reach] = basis.derivative[0][k];
        }
    }
    for (int i = 0; i < n; ++i)
        for (int below = i + 1; below < std::min(n, i + reach + 1); ++below) {
            Row& row = rows_[static_cast<std::size_t>(below)];
            const Row& pivot = rows_[static_cast<std::size_t>(i)];
            double& factor = row.entry[i - below + reach];
            if (factor == 0) continue;
            factor /= pivot.entry[reach];
            for (int off = 1; off <= reach; ++off)
                row.entry[i + off - below + reach] -= factor * pivot.entry[off + reach];
        }
}

void Collocation::solve(Vector3d* values, std::size_t stride) const {
    const int n = static_cast<int>(rows_.size());
    const auto value = [&](int i) -> Vector3d& { return values[static_cast<std::size_t>(i) * stride]; };
    for (int i = 0; i < n; ++i)
        for (int before = std::max(0, i - reach); before < i; ++before)
            value(i) -= rows_[static_cast<std::size_t>(i)].entry[before - i + reach] * value(before);
    for (int i = n - 1; i >= 0; --i) {
        const Row& row = rows_[static_cast<std::size_t>(i)];
        for (int after = i + 1; after < std::min(n, i + reach + 1); ++after)
            value(i) -= row.entry[after - i + reach] * value(after);
        value(i) /= row.entry[reach];
    }
}

geometry::SurfaceDirection FitDirection::direction() const {
    geometry::SurfaceDirection out{.degree = 3, .knots = std::vector<double>(4, breaks.front())};
    for (std::size_t k = 1; k + 1 < breaks.size(); ++k)
        out.knots.insert(out.knots.end(), static_cast<std::size_t>(multiplicity[k]), breaks[k]);
    out.knots.insert(out.knots.end(), 4, breaks.back());
    return out;
}

void FitDirection::divide(const std::vector<int>& parts) {
    FitDirection out;
    for (std::size_t k = 0; k + 1 < breaks.size(); ++k)
        for (int part = 0; part < parts[k]; ++part) {
            out.breaks.push_back(breaks[k] + (breaks[k + 1] - breaks[k]) * part / parts[k]);
            out.multiplicity.push_back(part == 0 ? multiplicity[k] : 1);
        }
    out.breaks.push_back(breaks.back());
    out.multiplicity.push_back(multiplicity.back());
    *this = std::move(out);
}

std::vector<double> greville(const geometry::SurfaceDirection& direction) {
    std::vector<double> out;
    for (std::size_t i = 0; i < direction.points(); ++i) {
        double sum = 0;
        for (int k = 1; k <= direction.degree; ++k) sum += direction.knots[i + static_cast<std::size_t>(k)];
        out.push_back(sum / direction.degree);
    }
    return out;
}

Result<geometry::BsplineSurface> interpolate(const FitDirection& u, const FitDirection& v, const SurfaceValue& value) {
    const auto along_u = u.direction(), along_v = v.direction();
    const auto rows = greville(along_u), columns = greville(along_v);
    std::vector<Vector3d> points;
    points.reserve(rows.size() * columns.size());
    for (const double at_u : rows)
        for (const double at_v : columns) {
            const auto there = value({at_u, at_v});
            if (!there)
                return fail({.code = "SURF0303",
                             .text = "the surface has no normal at a place, or no orientation there",
                             .value = fmt::format("u = {:.6g}, v = {:.6g}", at_u, at_v),
                             .hint = "cut the pole or the edge that is one point off the face"});
            points.push_back(*there);
        }
    const Collocation by_u(along_u.knots, rows), by_v(along_v.knots, columns);
    for (std::size_t i = 0; i < rows.size(); ++i) by_v.solve(&points[i * columns.size()], 1);
    for (std::size_t j = 0; j < columns.size(); ++j) by_u.solve(&points[j], columns.size());
    return geometry::BsplineSurface::make(along_u, along_v, std::move(points));
}

namespace {

/// Into how many parts rows and columns of rectangles are to be divided, by the errors in them.
class Refinement {
  public:
    Refinement(const geometry::BsplineSurface& surface, const FitDirection& u, const FitDirection& v,
               const SurfaceValue& value, double tolerance)
        : surface_(surface),
          u_(u),
          v_(v),
          value_(value),
          tolerance_(tolerance),
          parts_u(u.breaks.size() - 1, 1),
          parts_v(v.breaks.size() - 1, 1) {}

    void divide(std::size_t row, std::size_t column, double error) {
        constexpr int most = 4;  // what is found on coarse patches says little
        const double ratio = std::isfinite(error) ? std::pow(1.5 * error / tolerance_, 0.25) : 2;
        const int parts = std::clamp(static_cast<int>(std::ceil(ratio)), 2, most);
        const double u0 = u_.breaks[row], u1 = u_.breaks[row + 1], v0 = v_.breaks[column], v1 = v_.breaks[column + 1];
        const double by_u = std::max(off({0.5 * (u0 + u1), v0}), off({0.5 * (u0 + u1), v1}));
        const double by_v = std::max(off({u0, 0.5 * (v0 + v1)}), off({u1, 0.5 * (v0 + v1)}));
        const double larger = std::max(by_u, by_v);
        if (by_u >= 0.3 * larger) parts_u[row] = std::max(parts_u[row], parts);
        if (by_v >= 0.3 * larger) parts_v[column] = std::max(parts_v[column], parts);
    }

  private:
    double off(const SurfacePlace& place) const {
        const auto there = value_(place);
        return there ? (surface_.at(place.u, place.v) - *there).norm() : 0;
    }
    const geometry::BsplineSurface& surface_;
    const FitDirection &u_, &v_;
    const SurfaceValue& value_;
    double tolerance_;

  public:
    std::vector<int> parts_u, parts_v;
};

}  // namespace

Result<Fit> fit(FitDirection u, FitDirection v, const SurfaceValue& value, const FitError& error, double tolerance,
                std::size_t most) {
    while (true) {
        auto surface = interpolate(u, v, value);
        if (!surface) return fail(std::move(surface.error()));
        const std::vector<double> errors = error(*surface, u, v);
        const double largest = std::ranges::max(errors);
        if (largest <= tolerance) return Fit{std::move(*surface), u, v, largest, errors.size()};
        Refinement refinement(*surface, u, v, value, tolerance);
        const std::size_t columns = v.breaks.size() - 1;
        for (std::size_t k = 0; k < errors.size(); ++k)
            if (errors[k] > tolerance) refinement.divide(k / columns, k % columns, errors[k]);
        u.divide(refinement.parts_u);
        v.divide(refinement.parts_v);
        if ((u.breaks.size() - 1) * (v.breaks.size() - 1) > most)
            return fail({.code = "SURF0305",
                         .text = "a guiding or orientation surface does not get within its tolerance",
                         .value = fmt::format("{:.3g} mm with {} patches", largest, errors.size()),
                         .limit = fmt::format("{:.3g} mm with {} patches", tolerance, most),
                         .hint = "a coarser tolerance"});
    }
}

geometry::BsplineCurve curve_through(const std::vector<double>& parameters, std::vector<Vector3d> points) {
    const std::size_t n = points.size();
    const int degree = static_cast<int>(std::min<std::size_t>(3, n - 1));
    std::vector<double> knots(static_cast<std::size_t>(degree) + 1, parameters.front());
    if (degree == 3) {
        for (std::size_t k = 2; k + 2 < n; ++k) knots.push_back(parameters[k]);
        knots.insert(knots.end(), 4, parameters.back());
        Collocation(knots, parameters).solve(points.data(), 1);
        return geometry::BsplineCurve::make(3, std::move(knots), std::move(points)).value();
    }
    knots.insert(knots.end(), static_cast<std::size_t>(degree) + 1, parameters.back());
    if (degree == 2) {  // the middle control point of the parabola through three points
        const double w = (parameters[1] - parameters[0]) / (parameters[2] - parameters[0]);
        points[1] = (points[1] - (1 - w) * (1 - w) * points[0] - w * w * points[2]) / (2 * w * (1 - w));
    }
    return geometry::BsplineCurve::make(degree, std::move(knots), std::move(points)).value();
}

}  // namespace trunnion::surfacing::detail
