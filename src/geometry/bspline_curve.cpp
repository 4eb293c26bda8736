#include "trunnion/geometry/bspline_curve.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace trunnion::geometry {

namespace {

std::unexpected<Diagnostic> refuse(const char* code, std::string text) {
    Diagnostic refusal{.code = code, .text = std::move(text)};
    return fail(std::move(refusal));
}

/// Index of a knot that stands more often than the curve bears, or −1.
int too_frequent_knot(const std::vector<double>& knots, int degree, double begin, double end) {
    std::size_t run = 1;
    for (std::size_t i = 1; i <= knots.size(); ++i) {
        if (i < knots.size() && knots[i] == knots[i - 1]) {
            ++run;
            continue;
        }
        const bool inside = knots[i - 1] > begin && knots[i - 1] < end;
        if (run > static_cast<std::size_t>(inside ? degree : degree + 1)) return static_cast<int>(i - 1);
        run = 1;
    }
    return -1;
}

template <class Point>
using Local = std::array<Point, max_degree + 1>;

/// Control points of the derivative of the given order from those of the order before. In a non-empty interval no
/// denominator is 0: all knots on the left of it are below those on the right.
template <class Point>
void differentiate(Local<Point>& local, const double* knot, int degree, int order) noexcept {
    const double* left = knot - degree + order;
    const double* right = knot + 1;
    const int lower = degree - order;
    for (int j = 0; j <= lower; ++j) local[j] = (lower + 1) / (right[j] - left[j]) * (local[j + 1] - local[j]);
}

/// The polar form of an interval's polynomial: u_of(r) is the argument of step r = 1 … degree. All alike: the value.
template <class Point, class Argument>
Point polar_form(Local<Point> local, const double* knot, int degree, const Argument& u_of) noexcept {
    const double* left = knot - degree;
    const double* right = knot + 1;
    for (int r = 1; r <= degree; ++r)
        for (int j = degree; j >= r; --j) {
            const double share = (u_of(r) - left[j]) / (right[j - r] - left[j]);
            local[j] = (1 - share) * local[j - 1] + share * local[j];
        }
    return local[degree];
}

template <class Point>
std::array<Point, 4> derivatives(Local<Point> local, const double* knot, int degree, double u) noexcept {
    std::array<Point, 4> out;
    out.fill(Point::Zero());
    for (int order = 0; order <= std::min(3, degree); ++order) {
        if (order > 0) differentiate(local, knot, degree, order);
        out[order] = polar_form(local, knot, degree - order, [u](int) { return u; });
    }
    return out;
}

}  // namespace

Result<BsplineCurve> BsplineCurve::make(int degree, std::vector<double> knots, std::vector<Eigen::Vector3d> points,
                                        std::vector<double> weights) {
    if (degree < 1 || degree > max_degree)
        return refuse("GEOM0101",
                      fmt::format("a spline of degree {} is not possible, only 1 to {}", degree, max_degree));
    const std::size_t order = static_cast<std::size_t>(degree) + 1;
    if (points.size() < order || knots.size() != points.size() + order)
        return refuse("GEOM0102", fmt::format("{} knots and {} control points do not make a spline of degree {}",
                                              knots.size(), points.size(), degree));
    if (!std::ranges::all_of(knots, [](double t) { return std::isfinite(t); }) || !std::ranges::is_sorted(knots))
        return refuse("GEOM0103", "the knots of a spline decrease or are not finite");
    const double begin = knots[order - 1], end = knots[points.size()];
    if (!(begin < end)) return refuse("GEOM0104", "the knots of a spline leave it an empty domain");
    if (const int at = too_frequent_knot(knots, degree, begin, end); at >= 0)
        return refuse("GEOM0104", fmt::format("the knot {} stands so often that the spline breaks there",
                                              knots[static_cast<std::size_t>(at)]));
    if (!std::ranges::all_of(points, [](const Eigen::Vector3d& p) { return p.allFinite(); }))
        return refuse("GEOM0105", "a control point of a spline is not finite");
    const bool positive = std::ranges::all_of(weights, [](double w) { return w > 0 && std::isfinite(w); });
    if (!positive || (!weights.empty() && weights.size() != points.size()))
        return refuse("GEOM0107", "the weights of a spline are not one a control point, or not all positive");
    BsplineCurve out;
    out.degree_ = degree;
    out.knots_ = std::move(knots);
    out.points_ = std::move(points);
    out.weights_ = std::move(weights);
    return out;
}

/// The s with t_s ≤ u < t_{s+1} within the domain; of the ends, the outermost non-empty interval.
std::size_t BsplineCurve::span_of(double u) const noexcept {
    const auto first = knots_.begin() + degree_, last = knots_.begin() + static_cast<std::ptrdiff_t>(points_.size());
    auto after = std::upper_bound(first, last, u);
    if (after == last) after = std::lower_bound(first, last, *last);
    if (after == first) after = std::upper_bound(first, last, *first);
    return static_cast<std::size_t>(after - knots_.begin()) - 1;
}

std::array<Eigen::Vector3d, max_degree + 1> BsplineCurve::local_points(std::size_t span) const noexcept {
    Local<Eigen::Vector3d> out;
    out.fill(Eigen::Vector3d::Zero());
    const auto first = points_.begin() + static_cast<std::ptrdiff_t>(span) - degree_;
    std::copy(first, first + degree_ + 1, out.begin());
    return out;
}

std::array<Eigen::Vector4d, max_degree + 1> BsplineCurve::local_homogeneous(std::size_t span) const noexcept {
    Local<Eigen::Vector4d> out;
    out.fill(Eigen::Vector4d::Zero());
    const std::size_t first = span - static_cast<std::size_t>(degree_);
    for (std::size_t k = 0; k <= static_cast<std::size_t>(degree_); ++k) {
        const double weight = weights_.empty() ? 1 : weights_[first + k];
        out[k] << weight * points_[first + k], weight;
    }
    return out;
}

CurvePoint BsplineCurve::evaluate(double u) const noexcept {
    const std::size_t span = span_of(u);
    if (weights_.empty()) return derivatives(local_points(span), &knots_[span], degree_, u);
    return quotient(derivatives(local_homogeneous(span), &knots_[span], degree_, u));
}

std::pair<double, double> BsplineCurve::interval_at(double u) const noexcept {
    const std::size_t span = span_of(u);
    return {knots_[span], knots_[span + 1]};
}

BezierPiece BsplineCurve::piece(double from, double to) const noexcept {
    const std::size_t span = span_of(0.5 * (from + to));
    const Local<Eigen::Vector4d> local = local_homogeneous(span);
    BezierPiece out;
    out.degree = degree_;
    for (int k = 0; k <= degree_; ++k)
        out.control[k] = polar_form(local, &knots_[span], degree_, [&](int r) { return r <= k ? to : from; });
    return out;
}

std::vector<PolynomialPiece> BsplineCurve::pieces() const {
    std::vector<PolynomialPiece> out;
    for (std::size_t span = static_cast<std::size_t>(degree_); span < points_.size(); ++span) {
        if (!(knots_[span] < knots_[span + 1])) continue;
        PolynomialPiece piece{.u_begin = knots_[span], .u_end = knots_[span + 1], .degree = degree_};
        piece.coefficients_mm.fill(Eigen::Vector3d::Zero());
        Local<Eigen::Vector3d> local = local_points(span);
        double scale = 1;  // h^k / k!
        for (int k = 0; k <= degree_; ++k) {
            if (k > 0) {
                differentiate(local, &knots_[span], degree_, k);
                scale *= (piece.u_end - piece.u_begin) / k;
            }
            piece.coefficients_mm[k] =
                scale * polar_form(local, &knots_[span], degree_ - k, [&](int) { return piece.u_begin; });
        }
        out.push_back(piece);
    }
    return out;
}

}  // namespace trunnion::geometry
