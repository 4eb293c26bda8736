#include "trunnion/path/curve_way.hpp"

#include <algorithm>
#include <cmath>

namespace trunnion::path {

namespace {

constexpr int most_halvings = 12;
constexpr double length_slack = 1e-11;  // of the length, between one rule and two halves of it

std::array<Taylor3, 3> series_of(const geometry::CurvePoint& point) {
    std::array<Taylor3, 3> out;
    for (int k = 0; k < 3; ++k) out[k] = {point[0][k], point[1][k], point[2][k] / 2, point[3][k] / 6};
    return out;
}

/// d/dv of a series, good to order 2.
Taylor3 derivative(const Taylor3& a) {
    return {a.c[1], 2 * a.c[2], 3 * a.c[3], 0};
}

Taylor3 squared_norm(const Taylor3& x, const Taylor3& y, const Taylor3& z) {
    return x * x + y * y + z * z;
}

/// dp/dv as a series, good to order 2.
Taylor3 speed(const std::array<Taylor3, 6>& series) {
    std::array<Taylor3, 6> rate;
    std::ranges::transform(series, rate.begin(), derivative);
    for (std::size_t k = 3; k < 6; ++k) rate[k] *= reference_height_mm;
    const Taylor3 square = squared_norm(rate[0], rate[1], rate[2]) + squared_norm(rate[3], rate[4], rate[5]);
    return square.value() > 0 ? sqrt(square) : Taylor3(0);
}

/// Gauss-Legendre rule of five points.
constexpr std::array<double, 3> gauss_place{0, 0.5384693101056831, 0.9061798459386640};
constexpr std::array<double, 3> gauss_weight{0.5688888888888889, 0.4786286704993665, 0.2369268850561891};

template <class Function>
double gauss(const Function& f, double from, double to) {
    const double middle = 0.5 * (from + to), half = 0.5 * (to - from);
    double sum = gauss_weight[0] * f(middle);
    for (int k = 1; k < 3; ++k)
        sum += gauss_weight[k] * (f(middle - half * gauss_place[k]) + f(middle + half * gauss_place[k]));
    return half * sum;
}

template <class Function>
double integral(const Function& f, double from, double to, int depth = 0) {
    const double middle = 0.5 * (from + to), whole = gauss(f, from, to);
    const double halves = gauss(f, from, middle) + gauss(f, middle, to);
    if (depth == most_halvings || std::abs(whole - halves) <= length_slack * std::abs(halves)) return halves;
    return integral(f, from, middle, depth + 1) + integral(f, middle, to, depth + 1);
}

}  // namespace

CurveWay::CurveWay(const Run& run, std::size_t block)
    : CurveWay(run, run.curves[static_cast<std::size_t>(run.blocks[block].curve)], run.vertices[block],
               run.vertices[block + 1]) {}

CurveWay::CurveWay(const Run& run, const CurvePiece& curve, const PathCoordinates& from, const PathCoordinates& to)
    : curve_(&curve),
      from_(from),
      to_(to),
      vectors_(run.law == OrientationLaw::vector && run.space == Space::workpiece) {
    if (vectors_ && !curve_->orientation)
        turn_.emplace(Eigen::Vector3d(from_.orientation.data()), Eigen::Vector3d(to_.orientation.data()));
}

PathCoordinates CurveWay::at(double v) const {
    if (v == 0) return from_;
    if (v == 1) return to_;
    PathCoordinates out;
    Eigen::Map<Eigen::Vector3d>(out.position_mm.data()) = curve_->position.at(v);
    Eigen::Map<Eigen::Vector3d> orientation(out.orientation.data());
    if (curve_->orientation) {
        orientation = curve_->orientation->at(v);
        if (vectors_) orientation.normalize();
    } else if (turn_) {
        orientation = turn_->at(v);
    } else {
        for (std::size_t k = 0; k < 3; ++k)
            out.orientation[k] = from_.orientation[k] + v * (to_.orientation[k] - from_.orientation[k]);
    }
    return out;
}

std::array<Taylor3, 6> CurveWay::by_parameter(double v) const {
    const auto position = series_of(curve_->position.evaluate(v));
    std::array<Taylor3, 3> orientation;
    if (curve_->orientation) {
        orientation = series_of(curve_->orientation->evaluate(v));
        if (vectors_) {
            const Taylor3 length = sqrt(squared_norm(orientation[0], orientation[1], orientation[2]));
            for (Taylor3& n : orientation) n = n / length;
        }
    } else if (turn_) {
        orientation = turn_->at(Taylor3{v, 1, 0, 0});
    } else {
        for (std::size_t k = 0; k < 3; ++k) {
            const double turn = to_.orientation[k] - from_.orientation[k];
            orientation[k] = {from_.orientation[k] + v * turn, turn, 0, 0};
        }
    }
    return {position[0], position[1], position[2], orientation[0], orientation[1], orientation[2]};
}

double CurveWay::speed_mm(double v) const {
    return speed(by_parameter(v)).value();
}

/// The parameter as a function of p: dv/dp = 1/s, d²v/dp² = −s′/s³, d³v/dp³ = (3s′² − s·s″)/s⁵ with s = dp/dv.
std::array<Taylor3, 6> CurveWay::by_length(double v) const {
    const auto series = by_parameter(v);
    const Taylor3 rate = speed(series);
    const double s = rate.value(), per = 1 / s, slope = rate.d1() * per, bend = rate.d2() * per;
    const Taylor3 parameter{v, per, -slope * per * per / 2, (3 * slope * slope - bend) * per * per * per / 6};
    std::array<Taylor3, 6> out;
    for (std::size_t k = 0; k < 6; ++k)
        out[k] = compose(parameter, series[k].c[0], series[k].c[1], series[k].c[2], series[k].c[3]);
    return out;
}

double CurveWay::length_mm(double from, double to) const {
    return integral([this](double v) { return speed_mm(v); }, from, to);
}

double CurveWay::way_mm() const {
    return integral([this](double v) { return curve_->position.evaluate(v)[1].norm(); }, 0, 1);
}

double CurveWay::at_length(double share) const {
    if (share <= 0 || share >= 1) return std::clamp(share, 0.0, 1.0);
    constexpr int most_steps = 30;
    constexpr double close_enough = 1e-9;
    const double wanted = share * length_mm(0, 1);
    double low = 0, high = 1, v = share, reached = length_mm(0, v);
    for (int step = 0; step < most_steps; ++step) {
        (reached < wanted ? low : high) = v;
        const double speed = speed_mm(v);
        double next = speed > 0 ? v + (wanted - reached) / speed : low;
        if (!(next > low && next < high)) next = 0.5 * (low + high);
        reached += length_mm(v, next);
        const double moved = std::abs(next - v);
        v = next;
        if (moved < close_enough) break;
    }
    return v;
}

}  // namespace trunnion::path
