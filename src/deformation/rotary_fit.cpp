#include "detail/rotary_fit.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

#include <ceres/ceres.h>

#include "trunnion/base/quantity.hpp"
#include "trunnion/geometry/bspline_basis.hpp"

#include "detail/axis_vectors.hpp"
#include "detail/followed_path.hpp"
#include "detail/spline_equations.hpp"

namespace trunnion::deformation::detail {

using Eigen::Vector3d;
using machine::RotaryPosition;

namespace {

constexpr std::size_t influencing = 4;                        // control points of a cubic that have a part in a place
constexpr std::array<double, 3> places{0.1127, 0.5, 0.8873};  // of a knot interval, about Gauss' ones
constexpr std::array<double, 3> place_weights{5.0 / 18, 8.0 / 18, 5.0 / 18};
constexpr double acceleration_weight = 0.1;
constexpr std::array<double, 2> steepness{10, 100};  // of the penalties, one round each
constexpr double margin = 0.01;                      // inside the limits, in their units
constexpr double difference_rad = 1e-6;

/// What the sum of squares needs of a rotary axis.
struct RotaryAxis {
    double velocity, acceleration, range_min, range_max;
};

std::vector<RotaryAxis> rotary_axes(const machine::Machine& machine) {
    std::vector<RotaryAxis> out;
    for (int r = 0; r < machine.rotary_count; ++r) {
        const auto& axis = machine.axes[static_cast<std::size_t>(machine.linear_count()) + static_cast<std::size_t>(r)];
        out.push_back({axis.feed.velocity, axis.feed.acceleration, axis.range_min, axis.range_max});
    }
    return out;
}

/// One place of the path: velocities and accelerations of the rotary axes, and what is outside of the limits there.
class PlaceCost final : public ceres::CostFunction {
  public:
    struct Place {
        geometry::BasisFunctions basis;
        double seconds_per_u, weight;
        OrientationLimits::At at;
    };

    PlaceCost(const machine::Kinematics& kinematics, const std::vector<RotaryAxis>& axes,
              const OrientationLimits& limits, const Place& place, double steep)
        : kinematics_(kinematics), axes_(axes), limits_(limits), place_(place), steep_(steep) {
        set_num_residuals(static_cast<int>(4 * axes.size() + OrientationLimits::count));
        mutable_parameter_block_sizes()->assign(influencing, static_cast<int>(axes.size()));
    }

    bool Evaluate(double const* const* control, double* residuals, double** jacobians) const override {
        if (jacobians)
            for (std::size_t j = 0; j < influencing; ++j)
                if (jacobians[j]) std::fill_n(jacobians[j], num_residuals() * static_cast<int>(axes_.size()), 0.0);
        RotaryPosition at{};
        for (std::size_t r = 0; r < axes_.size(); ++r) {
            const Row row{residuals, jacobians, axes_.size(), r};
            at[r] = value(control, r, 0);
            const double rate = place_.weight / (place_.seconds_per_u * axes_[r].velocity);
            add_linear(row, 4 * r, rate, value(control, r, 1), 1);
            const double bend = acceleration_weight * place_.weight /
                                (place_.seconds_per_u * place_.seconds_per_u * axes_[r].acceleration);
            add_linear(row, 4 * r + 1, bend, value(control, r, 2), 2);
            add_hinge(row, 4 * r + 2, axes_[r].range_min - at[r], -1);
            add_hinge(row, 4 * r + 3, at[r] - axes_[r].range_max, 1);
        }
        add_limits(residuals, jacobians, at);
        return true;
    }

  private:
    struct Row {
        double* residuals;
        double** jacobians;
        std::size_t size, which;
        void set(std::size_t index, double value) const { residuals[index] = value; }
        void slope(std::size_t index, std::size_t block, double value) const {
            if (jacobians && jacobians[block]) jacobians[block][index * size + which] = value;
        }
    };

    double value(double const* const* control, std::size_t r, std::size_t order) const {
        double out = 0;
        for (std::size_t j = 0; j < influencing; ++j) out += place_.basis.derivative[order][j] * control[j][r];
        return out;
    }

    void add_linear(const Row& row, std::size_t index, double factor, double value, std::size_t order) const {
        row.set(index, factor * value);
        for (std::size_t j = 0; j < influencing; ++j) row.slope(index, j, factor * place_.basis.derivative[order][j]);
    }

    double penalty() const { return steep_ * place_.weight; }

    void add_hinge(const Row& row, std::size_t index, double excess_rad, double sense) const {
        const double beyond = excess_rad / degree + margin;
        row.set(index, beyond > 0 ? penalty() * beyond : 0);
        if (!(beyond > 0)) return;
        for (std::size_t j = 0; j < influencing; ++j)
            row.slope(index, j, penalty() * sense / degree * place_.basis.derivative[0][j]);
    }

    std::array<double, OrientationLimits::count> excess(const RotaryPosition& at) const {
        return limits_.excess(place_.at, kinematics_.tool_axis(at));
    }

    /// By central differences: what a clearance is nobody here knows.
    void add_limits(double* residuals, double** jacobians, const RotaryPosition& at) const {
        const auto here = excess(at);
        const std::size_t first = 4 * axes_.size();
        for (std::size_t i = 0; i < here.size(); ++i)
            residuals[first + i] = here[i] + margin > 0 ? penalty() * (here[i] + margin) : 0;
        if (!jacobians) return;
        for (std::size_t r = 0; r < axes_.size(); ++r) {
            RotaryPosition more = at, less = at;
            more[r] += difference_rad;
            less[r] -= difference_rad;
            const auto above = excess(more), below = excess(less);
            const Row row{residuals, jacobians, axes_.size(), r};
            for (std::size_t i = 0; i < here.size(); ++i) {
                if (!(residuals[first + i] > 0)) continue;
                const double slope = penalty() * (above[i] - below[i]) / (2 * difference_rad);
                for (std::size_t j = 0; j < influencing; ++j)
                    row.slope(first + i, j, slope * place_.basis.derivative[0][j]);
            }
        }
    }

    const machine::Kinematics& kinematics_;
    const std::vector<RotaryAxis>& axes_;
    const OrientationLimits& limits_;
    const Place& place_;
    double steep_;
};

std::vector<PlaceCost::Place> places_of(const DualPath& path, const Machining& machining,
                                        const OrientationLimits& limits) {
    const auto& knots = path.spline.bottom().knots();
    const std::vector<double> at = stations_of(knots);
    std::vector<PlaceCost::Place> out;
    double whole = 0;
    for (std::size_t k = 0; k + 1 < at.size(); ++k)
        for (std::size_t i = 0; i < places.size(); ++i) {
            const double u = at[k] + (at[k + 1] - at[k]) * places[i];
            const double seconds = seconds_per_u(path, u, machining);
            const double weight = place_weights[i] * (at[k + 1] - at[k]) * seconds;
            out.push_back({geometry::basis_functions(3, knots, u), seconds, weight, limits.at(u)});
            whole += weight;
        }
    for (auto& place : out) place.weight = std::sqrt(place.weight / whole);
    return out;
}

/// Control points of the spline over the path's knots that has the values at the control places.
Result<std::vector<Vector3d>> through(const DualPath& path, const std::vector<Vector3d>& values) {
    SplineEquations equations(path.spline.bottom().knots());
    const std::vector<double> at = control_places(path);
    for (std::size_t i = 0; i < at.size(); ++i) equations.add_exact(at[i], 0, dual_point(values[i], values[i]));
    const auto solved = equations.solve();
    if (solved) return solved->bottom().control_points_mm();
    return fail({.code = "DEFO0201", .text = "the path's knots do not determine a spline through its control places"});
}

/// Rotary positions along the path as it is, at the control places.
Result<std::vector<Vector3d>> rotary_at_control_places(const DualPath& path, const Machining& machining) {
    const auto followed = FollowedPath::make(path, machining, *machining.begin_rad, path.end());
    if (!followed) return fail(followed.error());
    const auto& stations = followed->axes().stations();
    std::vector<Vector3d> out;
    for (const double u : control_places(path)) {
        const auto after =
            std::ranges::partition_point(stations, [&](path::PathPlace p) { return followed->u_of(p) <= u; });
        const auto before = std::prev(after == stations.begin() ? std::next(after) : after);
        const path::PathPlace place{before->piece, before->offset_mm + (u - followed->u_of(*before))};
        const auto at = followed->axes().position(place);
        const auto first = static_cast<std::size_t>(machining.machine.linear_count());
        out.emplace_back(at[first], machining.machine.rotary_count > 1 ? at[first + 1] : 0, 0);
    }
    return out;
}

void solve(std::vector<RotaryPosition>& control, const std::vector<PlaceCost::Place>& where,
           const machine::Kinematics& kinematics, const std::vector<RotaryAxis>& axes, const OrientationLimits& limits,
           double steep) {
    ceres::Problem problem;
    for (auto& block : control) problem.AddParameterBlock(block.data(), static_cast<int>(axes.size()));
    for (const auto& place : where) {
        std::vector<double*> blocks(influencing);
        for (std::size_t j = 0; j < influencing; ++j) blocks[j] = control[place.basis.first + j].data();
        problem.AddResidualBlock(new PlaceCost(kinematics, axes, limits, place, steep), nullptr,
                                 blocks);  // which owns the cost
    }
    problem.SetParameterBlockConstant(control.front().data());
    problem.SetParameterBlockConstant(control.back().data());
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
    options.max_num_iterations = 60;
    options.function_tolerance = 1e-5;
    options.num_threads = 1;
    options.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
}

}  // namespace

Result<std::vector<Vector3d>> calmer_axis_vectors(const DualPath& path, const Machining& machining,
                                                  const OrientationLimits& limits) {
    const auto now = rotary_at_control_places(path, machining);
    if (!now) return fail(now.error());
    const auto start = through(path, *now);
    if (!start) return fail(start.error());
    std::vector<RotaryPosition> control;
    for (const Vector3d& point : *start) control.push_back({point[0], point[1]});
    const auto axes = rotary_axes(machining.machine);
    const auto where = places_of(path, machining, limits);
    for (const double steep : steepness) solve(control, where, machining.kinematics, axes, limits, steep);

    std::vector<Vector3d> tool;
    for (const double u : control_places(path)) {
        const auto basis = geometry::basis_functions(3, path.spline.bottom().knots(), u);
        RotaryPosition at{};
        for (std::size_t j = 0; j < influencing; ++j)
            for (std::size_t r = 0; r < axes.size(); ++r) at[r] += basis.derivative[0][j] * control[basis.first + j][r];
        tool.emplace_back(path.distance_mm * machining.kinematics.tool_axis(at));
    }
    auto out = through(path, tool);
    if (!out) return fail(out.error());
    const auto before = axis_vectors(path);
    out->front() = before.front();
    out->back() = before.back();
    return out;
}

}  // namespace trunnion::deformation::detail
