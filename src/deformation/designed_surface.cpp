#include "trunnion/deformation/designed_surface.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/LU>

#include "trunnion/geometry/bspline_basis.hpp"

#include "detail/spline_equations.hpp"

namespace trunnion::deformation {

using Eigen::Vector3d;
using geometry::BsplineCurve;
using geometry::BsplineSurface;

namespace {

constexpr double margin = 0.2;
constexpr int degree = 3;
constexpr std::size_t most_rows = geometry::max_degree + 1;
constexpr int places_looked_at = 40;  // in each direction, for a normal

using PointNet = std::vector<std::vector<Vector3d>>;  // by u, then by v

std::unexpected<Diagnostic> refuse(const char* text) {
    return fail({.code = "DEFO0112", .text = text});
}

/// The Bézier points of the polynomial through points at even distances.
Eigen::MatrixXd bezier_of_row(std::size_t rows) {
    const int v_degree = static_cast<int>(rows) - 1;
    const std::vector<double> knots = [&] {
        std::vector<double> out(rows, 0.0);
        out.insert(out.end(), rows, 1.0);
        return out;
    }();
    Eigen::MatrixXd values(rows, rows);
    for (int r = 0; r <= v_degree; ++r) {
        const auto basis = geometry::basis_functions(v_degree, knots, static_cast<double>(r) / v_degree);
        for (int j = 0; j <= v_degree; ++j) values(r, j) = basis.derivative[0][static_cast<std::size_t>(j)];
    }
    return values.inverse();
}

Result<SplineSurface> made(int u_degree, std::vector<double> u_knots, const PointNet& curves, Side side) {
    const std::size_t rows = curves.size(), count = curves.front().size();
    const Eigen::MatrixXd bezier = bezier_of_row(rows);
    std::vector<Vector3d> net;
    for (std::size_t i = 0; i < count; ++i)
        for (std::size_t j = 0; j < rows; ++j) {
            Vector3d point = Vector3d::Zero();
            for (std::size_t r = 0; r < rows; ++r)
                point += bezier(static_cast<Eigen::Index>(j), static_cast<Eigen::Index>(r)) * curves[r][i];
            net.push_back(point);
        }
    std::vector<double> v_knots(rows, 0.0);
    v_knots.insert(v_knots.end(), rows, 1.0);
    auto surface = BsplineSurface::make({u_degree, std::move(u_knots)},
                                        {static_cast<int>(rows) - 1, std::move(v_knots)}, std::move(net));
    if (!surface) return refuse(surface.error().text.c_str());
    SplineSurface out(std::move(*surface), side);
    for (int i = 0; i <= places_looked_at; ++i)
        for (int j = 0; j <= places_looked_at; ++j)
            if (!out.shape(
                    out.place_at(static_cast<double>(i) / places_looked_at, static_cast<double>(j) / places_looked_at)))
                return refuse("the surface has no normal somewhere");
    return out;
}

/// Mean over the rows of the chord lengths, summed up.
std::optional<std::vector<double>> mean_chord_parameters(std::span<const std::vector<Vector3d>> rows) {
    std::vector<double> out{0};
    for (std::size_t i = 1; i < rows.front().size(); ++i) {
        double step = 0;
        for (const auto& row : rows) {
            const double chord = (row[i] - row[i - 1]).norm();
            if (!(chord > 0) || !std::isfinite(chord)) return {};
            step += chord / static_cast<double>(rows.size());
        }
        out.push_back(out.back() + step);
    }
    return out;
}

/// Control points of the cubic not-a-knot spline through a row.
std::optional<std::vector<Vector3d>> control_points(const std::vector<Vector3d>& row, const std::vector<double>& u,
                                                    const std::vector<double>& knots) {
    SplineEquations equations(knots);
    for (std::size_t i = 0; i < row.size(); ++i) equations.add_exact(u[i], 0, dual_point(row[i], row[i]));
    const auto solved = equations.solve();
    if (!solved) return {};
    return solved->bottom().control_points_mm();
}

}  // namespace

std::optional<SurfaceFoot> SplineSurface::foot(const Vector3d& point_mm, SurfacePlace guess) const {
    const SurfacePlace place = geometry::closest_place(surface_, point_mm, guess, margin);
    const auto found = shape(place);
    if (!found) return {};
    return SurfaceFoot{found->point, found->normal, place};
}

std::optional<SurfaceFoot> SplineSurface::foot(const Vector3d& point_mm) const {
    return foot(point_mm, geometry::closest_place(surface_, point_mm));
}

std::optional<geometry::SurfaceShape> SplineSurface::shape(SurfacePlace place) const {
    return geometry::shape_at(surface_, place, side_);
}

SurfacePlace SplineSurface::place_at(double u_share, double v_share) const {
    return {std::lerp(surface_.u().begin(), surface_.u().end(), u_share),
            std::lerp(surface_.v().begin(), surface_.v().end(), v_share)};
}

Result<SplineSurface> ruled_surface(const BsplineCurve& bottom, const BsplineCurve& top, Side material_free) {
    if (bottom.degree() != top.degree() || bottom.knots() != top.knots())
        return refuse("the two curves of a ruled surface differ in degree or knots");
    if (!bottom.weights().empty() || !top.weights().empty()) return refuse("a curve of a ruled surface has weights");
    return made(bottom.degree(), bottom.knots(), {bottom.control_points_mm(), top.control_points_mm()}, material_free);
}

Result<SplineSurface> guided_surface(std::span<const std::vector<Vector3d>> rows_mm, Side material_free) {
    if (rows_mm.size() < 2 || rows_mm.size() > most_rows) return refuse("a surface takes 2 to 8 guide curves");
    const std::size_t count = rows_mm.front().size();
    if (!std::ranges::all_of(rows_mm, [&](const auto& row) { return row.size() == count; }))
        return refuse("the guide curves have different numbers of points");
    if (count < degree + 1) return refuse("a guide curve has fewer than 4 points");
    const auto u = mean_chord_parameters(rows_mm);
    if (!u) return refuse("points of a guide curve repeat or are not finite");
    std::vector<double> knots = clamped_knots(u->front(), {u->data() + 2, count - 4}, u->back());
    PointNet curves;
    for (const auto& row : rows_mm) {
        auto points = control_points(row, *u, knots);
        if (!points) return refuse("points of a guide curve determine no spline");
        curves.push_back(std::move(*points));
    }
    return made(degree, std::move(knots), curves, material_free);
}

}  // namespace trunnion::deformation
