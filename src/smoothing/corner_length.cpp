#include "detail/corner_length.hpp"

#include <algorithm>
#include <cmath>

namespace trunnion::smoothing {

namespace {

/// Gauss-Legendre rule of ten points on [−1, 1], the positive half of it.
constexpr std::array<double, 5> node{0.1488743389816312, 0.4333953941292472, 0.6794095682990244, 0.8650633666889845,
                                     0.9739065285171717};
constexpr std::array<double, 5> weight{0.2955242247147529, 0.2692667193099964, 0.2190863625159820, 0.1494513491505806,
                                       0.0666713443086881};
constexpr int most_newton_steps = 60;

double power_sum(const std::array<double, 5>& c, double u) {
    return c[0] + u * (c[1] + u * (c[2] + u * (c[3] + u * c[4])));
}

double speed(const std::array<double, 5>& square, double u) {
    return std::sqrt(std::max(power_sum(square, u), 0.0));
}

}  // namespace

std::array<Coordinates, 4> CornerPolygon::at(double u, Half half) const noexcept {
    constexpr std::array<double, 4> factorial{1, 1, 2, 6};
    const CornerBasis basis = corner_basis(u, half);
    std::array<Coordinates, 4> out;
    for (int k = 0; k < 4; ++k) {
        out[k].setZero();
        for (int i = 0; i < 5; ++i) out[k] += points_[i] * (basis(i, k) / factorial[k]);
    }
    return out;
}

CornerLength::CornerLength(const CornerPolygon& curve) {
    for (const Half half : {Half::first, Half::second}) {
        const auto c = curve.at(0, half);  // the second half's polynomials, continued
        const std::array<Coordinates, 3> rate{c[1], 2 * c[2], 3 * c[3]};
        auto& square = square_speed_[static_cast<std::size_t>(half)];
        for (std::size_t i = 0; i < 3; ++i)
            for (std::size_t k = 0; k < 3; ++k) square[i + k] += rate[i].dot(rate[k]);
    }
    for (int i = 0; i < parts; ++i) {
        const double from = static_cast<double>(i) / parts, to = static_cast<double>(i + 1) / parts;
        at_border_[i + 1] = at_border_[i] + integral(from, to, 2 * i < parts ? Half::first : Half::second);
    }
}

double CornerLength::integral(double from, double to, Half half) const noexcept {
    const double middle = 0.5 * (from + to), reach = 0.5 * (to - from);
    const auto& square = square_speed_[static_cast<std::size_t>(half)];
    double sum = 0;
    for (std::size_t k = 0; k < node.size(); ++k)
        sum += weight[k] * (speed(square, middle - node[k] * reach) + speed(square, middle + node[k] * reach));
    return reach * sum;
}

Taylor3 CornerLength::at(double u, Half half) const noexcept {
    // A part that lies in the half: at ½ the one before it or behind.
    const int first = half == Half::first ? 0 : parts / 2;
    const int part = std::clamp(static_cast<int>(u * parts), first, first + parts / 2 - 1);
    const double from = static_cast<double>(part) / parts;
    const double length = at_border_[part] + integral(from, u, half);
    const auto& c = square_speed_[static_cast<std::size_t>(half)];
    const Taylor3 square{power_sum(c, u), c[1] + u * (2 * c[2] + u * (3 * c[3] + u * 4 * c[4])),
                         c[2] + u * (3 * c[3] + u * 6 * c[4]), 0};
    const Taylor3 rate = sqrt(square);  // its first three coefficients are exact
    return {length, rate.c[0], rate.c[1] / 2, rate.c[2] / 3};
}

double CornerLength::parameter_at(double length_mm) const noexcept {
    const auto border = std::upper_bound(at_border_.begin() + 1, at_border_.end() - 1, length_mm);
    const auto part = border - at_border_.begin() - 1;
    double low = static_cast<double>(part) / parts, high = static_cast<double>(part + 1) / parts;
    const Half half = 2 * part < parts ? Half::first : Half::second;
    double u = low + (high - low) * std::clamp((length_mm - at_border_[part]) / (*border - at_border_[part]), 0.0, 1.0);
    for (int step = 0; step < most_newton_steps; ++step) {
        const double miss = at_border_[part] + integral(static_cast<double>(part) / parts, u, half) - length_mm;
        (miss < 0 ? low : high) = u;
        double next = u - miss / speed(square_speed_[static_cast<std::size_t>(half)], u);
        if (!(next >= low && next <= high)) next = 0.5 * (low + high);
        if (std::abs(next - u) <= 1e-15) return next;
        u = next;
    }
    return u;
}

}  // namespace trunnion::smoothing
