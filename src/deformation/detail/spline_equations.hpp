#pragma once

#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "trunnion/base/result.hpp"
#include "trunnion/deformation/dual_path.hpp"

namespace trunnion::deformation {

/// Tip and top point of a dual path together, or a derivative of them.
using DualPoint = Eigen::Matrix<double, 6, 1>;

DualPoint dual_point(const Eigen::Vector3d& tip, const Eigen::Vector3d& top);

/// Linear equations in the control points of two cubic splines over the same clamped knots: some hold exactly, the rest
/// in the least-square sense.
class SplineEquations {
  public:
    explicit SplineEquations(std::vector<double> knots) : knots_(std::move(knots)) {}

    /// Σ N_i^(order)(u) P_i = value.
    void add_exact(double u, int order, const DualPoint& value) { exact_.push_back({u, order, 1, value}); }
    /// Weight² (Σ N_i(u) P_i − value)² is part of the sum that becomes least.
    void add_near(double u, double weight, const DualPoint& value) { near_.push_back({u, 0, weight, value}); }

    /// The splines; none: the equations do not determine them. Without add_near as many equations as control points
    /// are needed.
    std::optional<geometry::DualSpline> solve() const;

  private:
    struct Row {
        double u;
        int order;
        double weight;
        DualPoint value;
    };
    std::vector<double> knots_;
    std::vector<Row> exact_, near_;
};

/// Knots with the ends fourfold around `inner`.
std::vector<double> clamped_knots(double begin, std::span<const double> inner, double end);

/// Knots without repetition.
std::vector<double> stations_of(const std::vector<double>& knots);

/// Adds to rising stations those of `more` that are not already there, to a billionth of the whole.
void add_apart(std::vector<double>& stations, const std::vector<double>& more);

/// The same tip curve over `stations` as knots, which hold those of the path; the top curve through the points at the
/// path's distance there. C²; first derivatives at the ends are those of the path. None: not to be solved.
std::optional<DualPath> with_distance(const DualPath& path, const std::vector<double>& stations);

}  // namespace trunnion::deformation
