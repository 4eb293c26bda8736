#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include <ceres/ceres.h>
#include <fmt/format.h>

#include "trunnion/deformation/flank_milling.hpp"
#include "trunnion/geometry/bspline_basis.hpp"

#include "detail/envelope.hpp"
#include "detail/flank_walk.hpp"

namespace trunnion::deformation {

using Eigen::Vector3d;

namespace {

constexpr int degree = 3;
constexpr int most_iterations = 8;
constexpr double worthwhile = 0.9;      // of what was reached before: less is worth more of the movement along the path
constexpr double length_weight = 0.05;  // of | |g − f| − h | against a deviation
constexpr double across_weight = 2e-4;  // of a control point's movement across path and axis
constexpr double along_axis_weight = 0.03;            // at least
constexpr std::array along_weights{0.3, 0.03, 0.01};  // along the path, one after the other
constexpr double depth_weight = 30;                   // of what lies deeper than allowed
constexpr int one_sided_rounds = 6;
constexpr double peak_exponent = 1;  // weights grow with |deviation| to this power, round by round
constexpr double least_weight = 0.05;
constexpr double kept_mm = 1e-9;
constexpr int places_per_interval = 3;  // of the optimisation

double value_of(double x) {
    return x;
}
template <int N>
double value_of(const ceres::Jet<double, N>& x) {
    return x.a;
}

/// One height at one place, as the optimisation sees it.
struct HeightTerm {
    double height_mm = 0;
    FlankTool::Outline outline;
    SurfaceFoot facing;
    double weight = 1;
};

/// Jets of a place: derivatives by f, f′, D = g − f and D′ there.
constexpr int slopes = 12;
using Jet = ceres::Jet<double, slopes>;

Vector<Jet> variable(const Vector3d& value, int first) {
    return {Jet(value[0], first), Jet(value[1], first + 1), Jet(value[2], first + 2)};
}

/// The heights at one u as functions of the four control points of f and of g that count there: of every height its
/// deviation and what lies too deep, behind them the distance. The derivative of a distance by the point is the normal
/// at its foot.
class PlaceCost final : public ceres::CostFunction {
  public:
    PlaceCost(const geometry::BasisFunctions& basis, std::vector<HeightTerm> terms, const DesignedSurface& surface,
              double distance_mm, double deepest_mm)
        : basis_(basis),
          terms_(std::move(terms)),
          surface_(surface),
          distance_mm_(distance_mm),
          deepest_mm_(deepest_mm) {
        mutable_parameter_block_sizes()->assign(2 * points, 3);
        set_num_residuals(static_cast<int>(2 * terms_.size() + 1));
    }

    bool Evaluate(const double* const* parameters, double* residuals, double** jacobians) const override {
        const Vector3d f = sum(0, parameters), f_rate = sum(1, parameters);
        const Vector3d d = sum(0, parameters + points) - f, d_rate = sum(1, parameters + points) - f_rate;
        if (jacobians)
            return fill<Jet>(variable(f, 0), variable(f_rate, 3), variable(d, 6), variable(d_rate, 9), residuals,
                             jacobians);
        return fill<double>(f, f_rate, d, d_rate, residuals, jacobians);
    }

  private:
    static constexpr int points = degree + 1;

    Vector3d sum(std::size_t order, const double* const* control) const {
        Vector3d out = Vector3d::Zero();
        for (std::size_t k = 0; k < points; ++k)
            out += basis_.derivative[order][k] * Eigen::Map<const Vector3d>(control[k]);
        return out;
    }

    template <class T>
    bool fill(const Vector<T>& f, const Vector<T>& f_rate, const Vector<T>& d, const Vector<T>& d_rate,
              double* residuals, double** jacobians) const {
        using std::sqrt;
        const ToolMotion<T> motion = tool_motion<T>(f, f_rate, d, d_rate);
        for (std::size_t j = 0; j < terms_.size(); ++j) {
            const auto deviation = deviation_of(motion, terms_[j]);
            if (!deviation) return false;
            const bool too_deep = value_of(*deviation) < -deepest_mm_;
            put(2 * j, *deviation * T(terms_[j].weight), residuals, jacobians);
            put(2 * j + 1, too_deep ? (*deviation + T(deepest_mm_)) * T(depth_weight) : T(0), residuals, jacobians);
        }
        put(2 * terms_.size(), (sqrt(d.dot(d)) - T(distance_mm_)) * T(length_weight), residuals, jacobians);
        return true;
    }

    template <class T>
    std::optional<T> deviation_of(const ToolMotion<T>& motion, const HeightTerm& at) const {
        const auto found = characteristic_point(motion, at.height_mm, at.outline, -at.facing.normal);
        if (!found.exists) return {};
        const Vector3d point(value_of(found.point[0]), value_of(found.point[1]), value_of(found.point[2]));
        const auto foot = surface_.foot(point, at.facing.place);
        if (!foot) return {};
        T out(0);
        for (int i = 0; i < 3; ++i) out += (found.point[i] - T(foot->point_mm[i])) * T(foot->normal[i]);
        return out;
    }

    static void put(std::size_t row, double value, double* residuals, double** /*jacobians*/) {
        residuals[row] = value;
    }

    /// By control points: f = Σ N P, D = Σ N (Q − P), and so their rates with N′.
    void put(std::size_t row, const Jet& value, double* residuals, double** jacobians) const {
        residuals[row] = value.a;
        for (std::size_t k = 0; k < points; ++k) {
            const double n = basis_.derivative[0][k], rate = basis_.derivative[1][k];
            const Vector3d by_g = n * value.v.segment<3>(6) + rate * value.v.segment<3>(9);
            const Vector3d by_f = n * value.v.segment<3>(0) + rate * value.v.segment<3>(3) - by_g;
            if (jacobians[k]) Eigen::Map<Vector3d>(jacobians[k] + 3 * row) = by_f;
            if (jacobians[points + k]) Eigen::Map<Vector3d>(jacobians[points + k] + 3 * row) = by_g;
        }
    }

    geometry::BasisFunctions basis_;
    std::vector<HeightTerm> terms_;
    const DesignedSurface& surface_;
    double distance_mm_, deepest_mm_;
};

/// A control point stays where it was: nearly free across the path and the axis, held along both, where a movement
/// would shift the tool over the surface instead of towards it.
struct MovementCost {
    Vector3d start;
    Eigen::Matrix3d weighed;  ///< rows: directions by their weights

    template <class T>
    bool operator()(const T* point, T* residual) const {
        Eigen::Map<Vector<T>> out(residual);
        out = weighed.cast<T>() * (Eigen::Map<const Vector<T>>(point) - start.cast<T>());
        return true;
    }
};

class Deformation {
  public:
    Deformation(const DualPath& path, const FlankTool& tool, const DesignedSurface& surface,
                const FlankDeformation& options)
        : start_(path), tool_(tool), surface_(surface), options_(options), allowed_mm_(options.deepest_mm) {}

    Result<DeformedFlank> run() {
        auto before = deviation_map(start_, tool_, surface_, options_.range);
        if (!before) return fail(before.error());
        best_ = DeformedFlank{start_, *before, *before};
        best_found_ = keeps_side(*before);
        DualPath path = start_;
        if (auto done = flatten(path); !done) return fail(done.error());
        for (int round = 0; round < one_sided_rounds && !best_found_; ++round) {
            allowed_mm_ -= 1.1 * (-best_try_.deepest_mm - options_.deepest_mm);
            if (auto done = flatten(path); !done) return fail(done.error());
        }
        if (!best_found_) return fail(out_of_reach());
        best_.movement_mm = movement(best_.path);
        best_.distance_error_mm = distance_error_mm(best_.path);
        best_.iterations = iterations_;
        return std::move(best_);
    }

  private:
    bool keeps_side(const DeviationMap& map) const { return map.deepest_mm >= -options_.deepest_mm - kept_mm; }

    /// Least squares, first with movement towards the surface alone, then along the path too as long as that helps: a
    /// lean along the path twists the envelope, but leads far where nothing is to be won. Then with weights where
    /// deviations are large. Keeps the best.
    Result<void> flatten(DualPath& path) {
        weights_.clear();
        double reached_mm = HUGE_VAL;
        for (const double hold : along_weights) {
            auto next = step(path, hold);
            if (!next) return fail(next.error());
            if (!(next->map.mean_square_root_mm < worthwhile * reached_mm)) break;
            reached_mm = next->map.mean_square_root_mm;
            path = std::move(next->path);
            hold_ = hold;
        }
        double peak_mm = HUGE_VAL;
        for (int round = 0; round < options_.peak_rounds; ++round) {
            if (auto weighed = weigh(path); !weighed) return weighed;
            auto next = step(path, hold_);
            if (!next) return fail(next.error());
            path = std::move(next->path);
            if (!(next->map.peak_mm < peak_mm)) break;
            peak_mm = next->map.peak_mm;
        }
        return {};
    }

    struct Step {
        DualPath path;
        DeviationMap map;
    };

    Result<Step> step(const DualPath& from, double hold) {
        const auto samples = walk_flank(from, tool_, surface_, coarse());
        if (!samples) return fail(samples.error());
        if (weights_.empty()) weights_.assign(samples->size(), 1);
        DualPath path = solved(from, *samples, hold);
        auto map = deviation_map(path, tool_, surface_, options_.range);
        if (!map) return fail(map.error());
        take(path, *map);
        return Step{std::move(path), std::move(*map)};
    }

    FlankRange coarse() const {
        FlankRange out = options_.range;
        out.places_per_interval = places_per_interval;
        return out;
    }

    void take(const DualPath& path, const DeviationMap& map) {
        const bool keeps = keeps_side(map);
        if (!keeps && (best_found_ || (tried_ && map.deepest_mm < best_try_.deepest_mm))) return;
        tried_ = true;
        best_try_ = map;
        if (!keeps) return;
        const bool better = !best_found_ || map.peak_mm < best_.after.peak_mm;
        best_found_ = true;
        if (!better) return;
        best_.path = path;
        best_.after = map;
    }

    Result<void> weigh(const DualPath& path) {
        const auto map = deviation_map(path, tool_, surface_, coarse());
        if (!map) return fail(map.error());
        double sum = 0;
        for (std::size_t i = 0; i < weights_.size(); ++i) {
            const double share = std::abs(map->deviation_mm[i]) / std::max(map->peak_mm, kept_mm);
            weights_[i] *= std::pow(std::max(share, least_weight), peak_exponent);
            sum += weights_[i] * weights_[i];
        }
        const double scale = std::sqrt(static_cast<double>(weights_.size()) / sum);
        for (double& weight : weights_) weight *= scale;
        return {};
    }

    DualPath solved(const DualPath& from, const std::vector<FlankSample>& samples, double hold) {
        std::array<std::vector<Vector3d>, 2> control{from.spline.bottom().control_points_mm(),
                                                     from.spline.top().control_points_mm()};
        ceres::Problem problem;
        add_movement(problem, control, hold);
        add_places(problem, control, samples);
        ceres::Solver::Options how;
        how.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
        how.logging_type = ceres::SILENT;
        how.max_num_iterations = most_iterations;
        how.function_tolerance = 1e-6;
        ceres::Solver::Summary summary;
        ceres::Solve(how, &problem, &summary);
        iterations_ += static_cast<int>(summary.iterations.size());
        return with_points(from, std::move(control));
    }

    void add_movement(ceres::Problem& problem, std::array<std::vector<Vector3d>, 2>& control, double hold) const {
        const double most = options_.most_movement_mm / std::sqrt(3.0);
        for (const bool top : {false, true}) {
            const auto& start = (top ? start_.spline.top() : start_.spline.bottom()).control_points_mm();
            for (std::size_t i = 0; i < start.size(); ++i) {
                double* const point = control[top ? 1 : 0][i].data();
                problem.AddResidualBlock(new ceres::AutoDiffCostFunction<MovementCost, 3, 3>(
                                             new MovementCost{start[i], movement_weights(i, hold)}),
                                         nullptr, point);
                for (int k = 0; std::isfinite(most) && k < 3; ++k) {
                    problem.SetParameterLowerBound(point, k, start[i][k] - most);
                    problem.SetParameterUpperBound(point, k, start[i][k] + most);
                }
            }
        }
    }

    void add_places(ceres::Problem& problem, std::array<std::vector<Vector3d>, 2>& control,
                    const std::vector<FlankSample>& samples) const {
        const auto heights = static_cast<std::size_t>(options_.range.heights);
        for (std::size_t first = 0; first < samples.size(); first += heights) {
            std::vector<HeightTerm> terms;
            for (std::size_t j = first; j < first + heights; ++j)
                terms.push_back({samples[j].height_mm, tool_.at(samples[j].height_mm), samples[j].facing, weights_[j]});
            const auto basis = geometry::basis_functions(degree, start_.spline.bottom().knots(), samples[first].u);
            double* const f = control[0][basis.first].data();
            double* const g = control[1][basis.first].data();
            problem.AddResidualBlock(new PlaceCost(basis, std::move(terms), surface_, start_.distance_mm, allowed_mm_),
                                     nullptr, f, f + 3, f + 6, f + 9, g, g + 3, g + 6, g + 9);
        }
    }

    /// At the mean of its inner knots, where a control point counts most.
    Eigen::Matrix3d movement_weights(std::size_t point, double hold) const {
        const auto& knots = start_.spline.bottom().knots();
        const double u = (knots[point + 1] + knots[point + 2] + knots[point + 3]) / degree;
        const Vector3d axis = start_.at(u).axis_in_workpiece;
        const Vector3d way = (start_.spline.bottom().evaluate(u)[1] + start_.spline.top().evaluate(u)[1]).normalized();
        const Vector3d across = axis.cross(way).normalized();
        Eigen::Matrix3d out;
        out << std::max(hold, along_axis_weight) * axis.transpose(), hold * across.cross(axis).transpose(),
            across_weight * across.transpose();
        return out;
    }

    /// Knots as they are: BsplineCurve takes them again.
    static DualPath with_points(const DualPath& like, std::array<std::vector<Vector3d>, 2> control) {
        const auto& knots = like.spline.bottom().knots();
        auto bottom = geometry::BsplineCurve::make(degree, knots, std::move(control[0]));
        auto top = geometry::BsplineCurve::make(degree, knots, std::move(control[1]));
        return {*geometry::DualSpline::make(std::move(*bottom), std::move(*top)), like.distance_mm};
    }

    double movement(const DualPath& path) const {
        double worst = 0;
        for (const bool top : {false, true}) {
            const auto& to = (top ? path.spline.top() : path.spline.bottom()).control_points_mm();
            const auto& from = (top ? start_.spline.top() : start_.spline.bottom()).control_points_mm();
            for (std::size_t i = 0; i < to.size(); ++i) worst = std::max(worst, (to[i] - from[i]).norm());
        }
        return worst;
    }

    Diagnostic out_of_reach() const {
        return {.code = "DEFO0115",
                .text = "the tool cuts deeper into the part than allowed, and cannot be moved far enough",
                .value = fmt::format("{:.4g} mm", options_.deepest_mm),
                .limit = fmt::format("{:.4g} mm", -best_try_.deepest_mm),
                .hint = "the limit could be kept; or more movement, or a thinner tool"};
    }

    const DualPath& start_;
    const FlankTool& tool_;
    const DesignedSurface& surface_;
    const FlankDeformation& options_;
    double allowed_mm_;
    std::vector<double> weights_;
    double hold_ = along_weights.front();
    DeformedFlank best_{start_};
    DeviationMap best_try_;
    bool best_found_ = false, tried_ = false;
    int iterations_ = 0;
};

}  // namespace

Result<DeformedFlank> deform_flank(const DualPath& path, const FlankTool& tool, const DesignedSurface& surface,
                                   const FlankDeformation& options) {
    if (!(options.most_movement_mm > 0) || !(options.deepest_mm >= 0) || options.peak_rounds < 0)
        return fail({.code = "DEFO0105", .text = "movement, depth or rounds of a deformation are out of range"});
    if (auto fits = check_hollows(path, tool, surface, options.range); !fits) return fail(fits.error());
    return Deformation(path, tool, surface, options).run();
}

}  // namespace trunnion::deformation
