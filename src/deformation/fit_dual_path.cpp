#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "trunnion/base/quantity.hpp"
#include "trunnion/deformation/dual_path.hpp"
#include "trunnion/geometry/great_circle.hpp"
#include "trunnion/path/run.hpp"

#include "detail/pose_checks.hpp"
#include "detail/spline_equations.hpp"

namespace trunnion::deformation {

using Eigen::Vector3d;

namespace {

constexpr int most_rounds = 40;
constexpr int most_shifts = 60;
constexpr double shift_beyond = 1.2;  // of a pose that lies too deep: so much more than it lacks

/// Deviations of a path from the poses.
struct Deviation {
    double tip_mm = 0, axis_rad = 0, deepest_mm = 0;
};

class PoseFit {
  public:
    PoseFit(std::span<const Pose> poses, const DualFit& fit, std::vector<double> parameters)
        : poses_(poses), fit_(fit), u_(std::move(parameters)) {}

    Result<FittedDualPath> run() {
        const bool near = fit_.tip_tolerance_mm > 0;
        auto path = near ? approximate() : interpolate();
        if (!path) return fail(path.error());
        return hold_distance(*path);
    }

  private:
    std::size_t count() const { return poses_.size(); }

    DualPoint wanted(std::size_t i) const {
        const Pose& pose = poses_[i];
        return dual_point(pose.tip_in_workpiece_mm,
                          pose.tip_in_workpiece_mm + fit_.distance_mm * pose.axis_in_workpiece);
    }

    void add_end_conditions(SplineEquations& equations) const {
        if (fit_.ends == EndCondition::not_a_knot) return;
        const bool natural = fit_.ends == EndCondition::natural;
        for (const bool begin : {true, false}) {
            const PoseTangent& tangent = begin ? fit_.tangent_at_begin : fit_.tangent_at_end;
            const Vector3d top = tangent.tip + fit_.distance_mm * tangent.axis;
            equations.add_exact(begin ? u_.front() : u_.back(), natural ? 2 : 1,
                                natural ? DualPoint::Zero() : dual_point(tangent.tip, top));
        }
    }

    Result<DualPath> interpolate() const {
        const std::size_t left_out = fit_.ends == EndCondition::not_a_knot ? 2 : 1;
        const std::span<const double> inner(u_.data() + left_out, count() - 2 * left_out);
        if (inner.size() + 4 > fit_.most_control_points)
            return fail(too_many_knots("a path through all poses", inner.size() + 4));
        SplineEquations equations(clamped_knots(u_.front(), inner, u_.back()));
        for (std::size_t i = 0; i < count(); ++i) equations.add_exact(u_[i], 0, wanted(i));
        add_end_conditions(equations);
        auto solved = equations.solve();
        if (!solved) return fail(undetermined());
        return DualPath{std::move(*solved), fit_.distance_mm};
    }

    /// Few knots, more where a pose lies too far; all of them where that leaves a span without poses.
    Result<DualPath> approximate() const {
        std::vector<std::size_t> breaks;
        Deviation reached{HUGE_VAL, HUGE_VAL, HUGE_VAL};
        while (true) {
            if (breaks.size() + 4 > fit_.most_control_points) return fail(out_of_reach(reached));
            auto path = squares(breaks);
            if (!path) return interpolate();
            const std::vector<bool> bad = too_far(*path, breaks, reached);
            if (std::ranges::none_of(bad, [](bool b) { return b; })) return std::move(*path);
            auto finer = divided(breaks, bad);
            if (finer.size() == breaks.size()) return interpolate();
            breaks = std::move(finer);
        }
    }

    /// Break b: a knot in the middle between pose b − 1 and pose b.
    std::vector<double> knots_at(const std::vector<std::size_t>& breaks) const {
        std::vector<double> inner;
        for (const std::size_t b : breaks) inner.push_back(0.5 * (u_[b - 1] + u_[b]));
        return clamped_knots(u_.front(), inner, u_.back());
    }

    /// One-sided: poses that come out too deep are wanted so much higher until none does.
    std::optional<DualPath> squares(const std::vector<std::size_t>& breaks) const {
        std::vector<double> lift(count(), 0);
        for (int round = 0; round < most_shifts; ++round) {
            auto path = squares(breaks, lift);
            if (!path || fit_.normals.empty() || !raise(*path, lift)) return path;
        }
        return squares(breaks, lift);
    }

    std::optional<DualPath> squares(const std::vector<std::size_t>& breaks, const std::vector<double>& lift) const {
        SplineEquations equations(knots_at(breaks));
        equations.add_exact(u_.front(), 0, wanted(0));
        equations.add_exact(u_.back(), 0, wanted(count() - 1));
        add_end_conditions(equations);
        for (std::size_t i = 0; i < count(); ++i) {
            DualPoint near = wanted(i);
            if (lift[i] > 0) near += lift[i] * dual_point(fit_.normals[i], fit_.normals[i]);
            equations.add_near(u_[i], fit_.weights.empty() ? 1 : std::sqrt(fit_.weights[i]), near);
        }
        auto solved = equations.solve();
        if (!solved) return {};
        return DualPath{std::move(*solved), fit_.distance_mm};
    }

    double depth(const DualPath& path, std::size_t i) const {
        const Pose& pose = poses_[i];
        const Vector3d point = pose.tip_in_workpiece_mm + fit_.side_height_mm * pose.axis_in_workpiece;
        return fit_.normals[i].dot(point - path.point_mm(u_[i], fit_.side_height_mm));
    }

    bool raise(const DualPath& path, std::vector<double>& lift) const {
        bool raised = false;
        for (std::size_t i = 0; i < count(); ++i) {
            const double lacking = depth(path, i) - fit_.deepest_mm;
            if (lacking <= 0) continue;
            lift[i] += shift_beyond * lacking;
            raised = true;
        }
        return raised;
    }

    Deviation deviation(const DualPath& path, std::size_t i) const {
        const Pose got = path.at(u_[i]);
        return {(got.tip_in_workpiece_mm - poses_[i].tip_in_workpiece_mm).norm(),
                geometry::angle_between(got.axis_in_workpiece, poses_[i].axis_in_workpiece),
                fit_.normals.empty() ? 0 : depth(path, i)};
    }

    Deviation deviation(const DualPath& path) const {
        Deviation worst{0, 0, fit_.normals.empty() ? 0 : -HUGE_VAL};
        for (std::size_t i = 0; i < count(); ++i) {
            const Deviation here = deviation(path, i);
            worst = {std::max(worst.tip_mm, here.tip_mm), std::max(worst.axis_rad, here.axis_rad),
                     std::max(worst.deepest_mm, here.deepest_mm)};
        }
        return worst;
    }

    bool is_within(const Deviation& d) const {
        return d.tip_mm <= fit_.tip_tolerance_mm && d.axis_rad <= fit_.orientation_tolerance_rad &&
               d.deepest_mm <= fit_.deepest_mm + rounding_mm;
    }

    /// Of every span of poses between breaks, whether one of them is out of tolerance.
    std::vector<bool> too_far(const DualPath& path, const std::vector<std::size_t>& breaks, Deviation& worst) const {
        std::vector<bool> out(breaks.size() + 1, false);
        worst = deviation(path);
        for (std::size_t i = 0; i < count(); ++i)
            if (!is_within(deviation(path, i)))
                out[static_cast<std::size_t>(std::ranges::upper_bound(breaks, i) - breaks.begin())] = true;
        return out;
    }

    std::vector<std::size_t> divided(const std::vector<std::size_t>& breaks, const std::vector<bool>& which) const {
        std::vector<std::size_t> out;
        for (std::size_t k = 0; k < which.size(); ++k) {
            const std::size_t from = k == 0 ? 0 : breaks[k - 1], to = k < breaks.size() ? breaks[k] : count();
            if (which[k] && to - from >= 4) out.push_back((from + to) / 2);
            if (k < breaks.size()) out.push_back(breaks[k]);
        }
        return out;
    }

    /// Halves knot intervals where the distance is not kept; the top curve anew through the points of the axis at their
    /// ends, the tip's curve stays what it is.
    Result<FittedDualPath> hold_distance(const DualPath& fitted) const {
        DualPath path = fitted;
        bool through_poses = fit_.tip_tolerance_mm == 0;
        for (int round = 0; round < most_rounds; ++round) {
            std::vector<double> at = stations_of(path.spline.bottom().knots());
            const std::vector<double> bad = far_intervals(path, at);
            if (bad.empty() && (through_poses || is_within(deviation(path)))) return account(std::move(path));
            through_poses |= bad.empty();
            if (through_poses) add_apart(at, u_);
            add_apart(at, bad);
            if (at.size() + 2 > fit_.most_control_points) break;
            auto renewed = with_distance(fitted, at);
            if (!renewed) break;
            path = std::move(*renewed);
        }
        return fail({.code = "DEFO0107",
                     .text = "the distance of the two curves cannot be kept",
                     .value = fmt::format("{:.4g} mm", distance_error_mm(path)),
                     .limit = fmt::format("{:.4g} mm", fit_.distance_tolerance_mm),
                     .hint = "poses closer together, a larger distance tolerance, or more control points"});
    }

    /// Middles of the intervals in which the distance is not kept.
    std::vector<double> far_intervals(const DualPath& path, const std::vector<double>& at) const {
        std::vector<double> out;
        for (std::size_t k = 0; k + 1 < at.size(); ++k)
            if (!(distance_error_mm(path, at[k], at[k + 1]) <= fit_.distance_tolerance_mm))
                out.push_back(0.5 * (at[k] + at[k + 1]));
        return out;
    }

    Result<FittedDualPath> account(DualPath path) const {
        const Deviation worst = deviation(path);
        if (fit_.tip_tolerance_mm > 0 && !is_within(worst)) return fail(out_of_reach(worst));
        const double error = distance_error_mm(path);
        return FittedDualPath{std::move(path), u_, worst.tip_mm, worst.axis_rad, worst.deepest_mm, error};
    }

    Diagnostic out_of_reach(const Deviation& d) const {
        const auto said = [](double tip, double axis, double depth) {
            return fmt::format("{:.4g} mm, {:.4g} deg, {:.4g} mm deep", tip, axis / degree, depth);
        };
        return {.code = "DEFO0106",
                .text = "no path with so few control points keeps the tolerance",
                .value = std::isfinite(d.tip_mm) ? said(d.tip_mm, d.axis_rad, d.deepest_mm) : "",
                .limit = said(fit_.tip_tolerance_mm, fit_.orientation_tolerance_rad, fit_.deepest_mm),
                .hint = "the value given could be kept"};
    }

    Diagnostic too_many_knots(const char* what, std::size_t needed) const {
        return {.code = "DEFO0106",
                .text = fmt::format("{} needs more control points", what),
                .value = fmt::format("{}", needed),
                .limit = fmt::format("{}", fit_.most_control_points),
                .hint = "as many as the value says, or tolerances above 0"};
    }

    static Diagnostic undetermined() {
        return {.code = "DEFO0105", .text = "the poses and parameters determine no spline"};
    }

    std::span<const Pose> poses_;
    const DualFit& fit_;
    std::vector<double> u_;
};

std::vector<double> parameters_of(std::span<const Pose> poses, const DualFit& fit) {
    if (!fit.parameters.empty()) return fit.parameters;
    std::vector<double> out{0};
    for (std::size_t i = 1; i < poses.size(); ++i) {
        const double step = pose_step_mm(poses[i - 1], poses[i]);
        out.push_back(out.back() + (fit.parametrisation == Parametrisation::centripetal ? std::sqrt(step) : step));
    }
    return out;
}

std::optional<Diagnostic> contradiction(std::size_t count, const DualFit& fit) {
    const auto refuse = [](const char* text) { return Diagnostic{.code = "DEFO0105", .text = text}; };
    if (!(fit.distance_mm > 0 && std::isfinite(fit.distance_mm)))
        return refuse("the distance of the two curves is not above 0");
    if (!(fit.distance_tolerance_mm > 0)) return refuse("the tolerance of the distance is not above 0");
    const bool near = fit.tip_tolerance_mm > 0;
    if (near != (fit.orientation_tolerance_rad > 0) || !(fit.tip_tolerance_mm >= 0) ||
        !(fit.orientation_tolerance_rad >= 0))
        return refuse("tolerances of tip and orientation are both 0 or both above 0");
    if (!near && (!fit.weights.empty() || !fit.normals.empty()))
        return refuse("weights and normals count in least squares alone: give tolerances above 0");
    if (!fit.weights.empty() && (fit.weights.size() != count ||
                                 !std::ranges::all_of(fit.weights, [](double w) { return w > 0 && std::isfinite(w); })))
        return refuse("weights are not one a pose, or not above 0");
    const auto is_unit = [](const Vector3d& n) { return std::abs(n.norm() - 1) < unit_within; };
    if (!fit.normals.empty() && (fit.normals.size() != count || !std::ranges::all_of(fit.normals, is_unit)))
        return refuse("normals are not one a pose, or not unit");
    if (!(fit.deepest_mm >= 0)) return refuse("the depth allowed on the part's side is below 0");
    const auto& u = fit.parameters;
    if (!u.empty() && (u.size() != count || !std::ranges::all_of(u, [](double v) { return std::isfinite(v); }) ||
                       std::ranges::adjacent_find(u, std::greater_equal<>{}) != u.end()))
        return refuse("parameters are not one a pose, or do not rise");
    return {};
}

}  // namespace

Result<FittedDualPath> fit_dual_path(std::span<const Pose> poses, const DualFit& fit) {
    const std::size_t needed = fit.ends == EndCondition::not_a_knot ? 4 : 2;
    if (auto refused = check_poses(poses, needed)) return fail(std::move(*refused));
    if (auto refused = contradiction(poses.size(), fit)) return fail(std::move(*refused));
    return PoseFit(poses, fit, parameters_of(poses, fit)).run();
}

}  // namespace trunnion::deformation
