#include "detail/spline_equations.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

#include <Eigen/SparseCore>
#include <Eigen/SparseLU>

#include "trunnion/geometry/bspline_basis.hpp"

namespace trunnion::deformation {

using Eigen::Vector3d;
using geometry::BsplineCurve;
using geometry::DualSpline;

namespace {

constexpr int degree = 3;
constexpr double same_share = 1e-9;
using Entry = Eigen::Triplet<double>;
using Columns = Eigen::Matrix<double, Eigen::Dynamic, 6>;

std::optional<DualSpline> spline_of(const std::vector<double>& knots, const Columns& control) {
    const std::size_t count = knots.size() - degree - 1;
    std::vector<Vector3d> tip(count), top(count);
    for (std::size_t i = 0; i < count; ++i) {
        tip[i] = control.row(static_cast<Eigen::Index>(i)).head<3>();
        top[i] = control.row(static_cast<Eigen::Index>(i)).tail<3>();
    }
    auto bottom = BsplineCurve::make(degree, knots, std::move(tip));
    auto above = BsplineCurve::make(degree, knots, std::move(top));
    if (!bottom || !above) return {};
    auto made = DualSpline::make(std::move(*bottom), std::move(*above));
    if (!made) return {};
    return std::move(*made);
}

}  // namespace

DualPoint dual_point(const Vector3d& tip, const Vector3d& top) {
    DualPoint out;
    out << tip, top;
    return out;
}

/// Least squares under exact equations C x = d: [Σ w² N Nᵀ, Cᵀ; C, 0] (x, multipliers) = (Σ w² N value, d). Without the
/// first the matrix is C alone.
std::optional<DualSpline> SplineEquations::solve() const {
    const auto points = static_cast<int>(knots_.size()) - degree - 1, rows = static_cast<int>(exact_.size());
    const bool exact_only = near_.empty();
    if (exact_only && rows != points) return {};
    const int below = exact_only ? 0 : points, size = below + rows;
    std::vector<Entry> entries;
    Columns wanted = Columns::Zero(size, 6);
    for (const Row& row : near_) {
        const auto basis = geometry::basis_functions(degree, knots_, row.u);
        const auto first = static_cast<int>(basis.first);
        const auto& value = basis.derivative[0];
        for (int a = 0; a <= degree; ++a) {
            const double weighted = row.weight * row.weight * value[static_cast<std::size_t>(a)];
            wanted.row(first + a) += weighted * row.value.transpose();
            for (int b = 0; b <= degree; ++b)
                entries.emplace_back(first + a, first + b, weighted * value[static_cast<std::size_t>(b)]);
        }
    }
    for (int r = 0; r < rows; ++r) {
        const Row& row = exact_[static_cast<std::size_t>(r)];
        const auto basis = geometry::basis_functions(degree, knots_, row.u);
        wanted.row(below + r) = row.value.transpose();
        for (int a = 0; a <= degree; ++a) {
            const int column = static_cast<int>(basis.first) + a;
            const double value = basis.derivative[static_cast<std::size_t>(row.order)][static_cast<std::size_t>(a)];
            entries.emplace_back(below + r, column, value);
            if (!exact_only) entries.emplace_back(column, below + r, value);
        }
    }
    Eigen::SparseMatrix<double> matrix(size, size);
    matrix.setFromTriplets(entries.begin(), entries.end());
    Eigen::SparseLU<Eigen::SparseMatrix<double>> solver;
    solver.compute(matrix);
    if (solver.info() != Eigen::Success) return {};
    const Columns solved = solver.solve(wanted);
    if (!solved.allFinite()) return {};
    return spline_of(knots_, solved.topRows(points));
}

std::vector<double> clamped_knots(double begin, std::span<const double> inner, double end) {
    std::vector<double> out(degree + 1, begin);
    out.insert(out.end(), inner.begin(), inner.end());
    out.insert(out.end(), degree + 1, end);
    return out;
}

std::vector<double> stations_of(const std::vector<double>& knots) {
    std::vector<double> out = knots;
    out.erase(std::ranges::unique(out).begin(), out.end());
    return out;
}

void add_apart(std::vector<double>& stations, const std::vector<double>& more) {
    const double same = same_share * (stations.back() - stations.front());
    const std::vector<double> known = stations;
    for (const double u : more) {
        const auto after = std::ranges::lower_bound(known, u);
        const bool at_next = after != known.end() && *after - u <= same;
        const bool at_last = after != known.begin() && u - *std::prev(after) <= same;
        if (!at_next && !at_last) stations.push_back(u);
    }
    std::ranges::sort(stations);
}

std::optional<DualPath> with_distance(const DualPath& path, const std::vector<double>& stations) {
    const std::span<const double> inner(stations.data() + 1, stations.size() - 2);
    SplineEquations equations(clamped_knots(stations.front(), inner, stations.back()));
    for (const double u : stations)
        equations.add_exact(u, 0, dual_point(path.at(u).tip_in_workpiece_mm, path.point_mm(u, path.distance_mm)));
    for (const double u : {stations.front(), stations.back()}) {
        const Vector3d tip = path.spline.bottom().evaluate(u)[1];
        const auto axis = path.spline.axis(u);
        const Vector3d turn(axis[0].d1(), axis[1].d1(), axis[2].d1());
        equations.add_exact(u, 1, dual_point(tip, tip + path.distance_mm * turn));
    }
    auto solved = equations.solve();
    if (!solved) return {};
    return DualPath{std::move(*solved), path.distance_mm};
}

}  // namespace trunnion::deformation
