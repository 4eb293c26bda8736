#include "trunnion/geometry/bezier_piece.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

#include "trunnion/geometry/great_circle.hpp"

namespace trunnion::geometry {

namespace {

using Control = std::array<Eigen::Vector4d, max_degree + 1>;

/// One or more steps of de Casteljau's scheme: from `degree` down to `lower`.
void reduce(Control& control, int degree, int lower, double v) noexcept {
    for (int d = degree; d > lower; --d)
        for (int k = 0; k < d; ++k) control[k] = (1 - v) * control[k] + v * control[k + 1];
}

Eigen::Vector3d point_of(const Eigen::Vector4d& homogeneous) noexcept {
    return homogeneous.head<3>() / homogeneous[3];
}

/// The end of [0, v] in place: control points of that part.
Control before(const Control& control, int degree, double v) noexcept {
    Control scheme = control, out = control;
    for (int k = 1; k <= degree; ++k) {
        for (int j = 0; j + k <= degree; ++j) scheme[j] = (1 - v) * scheme[j] + v * scheme[j + 1];
        out[k] = scheme[0];
    }
    return out;
}

Control reversed(Control control, int degree) noexcept {
    std::reverse(control.begin(), control.begin() + degree + 1);
    return control;
}

/// Calls visit(share of k − 1, index k − 1, share of k, index k) for the control points k = 0 … degree + 1 of a product
/// with a linear function.
template <class Visit>
void raise_degree(int degree, const Visit& visit) noexcept {
    for (int k = 0; k <= degree + 1; ++k) {
        const double share = static_cast<double>(k) / (degree + 1);
        visit(share, std::max(k - 1, 0), 1 - share, std::min(k, degree));
    }
}

}  // namespace

CurvePoint quotient(const HomogeneousPoint& h) noexcept {
    const auto a = [&](int k) -> Eigen::Vector3d { return h[k].head<3>(); };
    const auto w = [&](int k) { return h[k][3]; };
    CurvePoint c;
    c[0] = a(0) / w(0);
    c[1] = (a(1) - w(1) * c[0]) / w(0);
    c[2] = (a(2) - 2 * w(1) * c[1] - w(2) * c[0]) / w(0);
    c[3] = (a(3) - 3 * w(1) * c[2] - 3 * w(2) * c[1] - w(3) * c[0]) / w(0);
    return c;
}

CurvePoint BezierPiece::evaluate(double v) const noexcept {
    const int highest = std::min(3, degree);
    Control scheme = control;
    reduce(scheme, degree, highest, v);
    HomogeneousPoint out;
    out.fill(Eigen::Vector4d::Zero());
    for (int order = highest; order >= 0; --order) {
        // the last order + 1 points of the scheme: their highest difference is the derivative
        Control difference = scheme;
        double factor = 1;
        for (int k = 0; k < order; ++k) {
            factor *= degree - k;
            for (int j = 0; j + k < order; ++j) difference[j] = difference[j + 1] - difference[j];
        }
        out[order] = factor * difference[0];
        if (order > 0) reduce(scheme, order, order - 1, v);
    }
    return quotient(out);
}

Eigen::Vector3d BezierPiece::at(double v) const noexcept {
    Control scheme = control;
    reduce(scheme, degree, 0, v);
    return point_of(scheme[0]);
}

BezierPiece BezierPiece::part(double from, double to) const noexcept {
    BezierPiece out;
    out.degree = degree;
    out.control = before(control, degree, to);
    out.control = reversed(before(reversed(out.control, degree), degree, 1 - from / to), degree);
    return out;
}

BezierPiece BezierPiece::mapped(const Eigen::Matrix3d& turn, const Eigen::Vector3d& shift) const noexcept {
    BezierPiece out = *this;
    for (int k = 0; k <= degree; ++k) out.control[k].head<3>() = turn * control[k].head<3>() + control[k][3] * shift;
    return out;
}

void BezierPiece::fit_ends(const Eigen::Vector3d& start, const Eigen::Vector3d& end) noexcept {
    const Eigen::Vector3d at_start = start - at(0), at_end = end - at(1);
    for (int k = 1; k < degree; ++k) {
        const double share = static_cast<double>(k) / degree;
        control[k].head<3>() += control[k][3] * ((1 - share) * at_start + share * at_end);
    }
    control[0].head<3>() = control[0][3] * start;
    control[degree].head<3>() = control[degree][3] * end;
}

double BezierPiece::polygon_length() const noexcept {
    double sum = 0;
    for (int k = 0; k < degree; ++k) sum += (point_of(control[k + 1]) - point_of(control[k])).norm();
    return sum;
}

double BezierPiece::chord_error() const noexcept {
    const Eigen::Vector3d start = point_of(control[0]), end = point_of(control[degree]);
    double off = 0, least_weight = control[0][3];
    for (int k = 1; k <= degree; ++k) least_weight = std::min(least_weight, control[k][3]);
    raise_degree(degree, [&](double share_before, int k_before, double share, int k) {
        const Eigen::Vector3d by_end = control[k_before].head<3>() - control[k_before][3] * end;
        const Eigen::Vector3d by_start = control[k].head<3>() - control[k][3] * start;
        off = std::max(off, (share_before * by_end + share * by_start).norm());
    });
    return off / least_weight;
}

double BezierPiece::chord_turn() const noexcept {
    const Eigen::Vector3d start = control[0].head<3>().normalized(), end = control[degree].head<3>().normalized();
    // The chord is nowhere shorter than its middle m, the curve nowhere than its part along m/|m|.
    const Eigen::Vector3d middle = 0.5 * (start + end);
    double along = control[0].head<3>().dot(middle), across = 0;
    for (int k = 1; k <= degree; ++k) along = std::min(along, control[k].head<3>().dot(middle));
    if (!(along > 0)) return std::numbers::pi;
    raise_degree(degree, [&](double share_before, int k_before, double share, int k) {
        const Eigen::Vector3d product =
            share_before * control[k_before].head<3>().cross(end) + share * control[k].head<3>().cross(start);
        across = std::max(across, product.norm());
    });
    const double sine = across / along;
    return sine < 1 ? std::asin(sine) : std::numbers::pi;
}

double BezierPiece::polygon_turn() const noexcept {
    double sum = 0;
    for (int k = 0; k < degree; ++k) {
        const Eigen::Vector3d a = control[k].head<3>(), b = control[k + 1].head<3>();
        sum += a.isZero(0) || b.isZero(0) ? std::numbers::pi : angle_between(a, b);
    }
    return sum;
}

}  // namespace trunnion::geometry
