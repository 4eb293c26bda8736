#include "surface_curve.hpp"

#include <algorithm>
#include <numbers>

#include "../unit/feed/synthetic_paths.hpp"

namespace trunnion::test {

namespace {

constexpr double piece_mm = 0.4;
using machine::VectorSeries;

VectorSeries normalised(const VectorSeries& v) {
    const Taylor3 inverse = 1.0 / sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    return {v[0] * inverse, v[1] * inverse, v[2] * inverse};
}

Taylor3 variable(double u) {
    return {u, 1, 0, 0};
}

/// d/du; its last coefficient is not known.
Taylor3 slope(const Taylor3& f) {
    return {f.c[1], 2 * f.c[2], 3 * f.c[3], 0};
}

/// dp/du to order 2: |dtip|² + (ρ dn)².
Taylor3 speed(const Place& place) {
    Taylor3 square;
    for (int k = 0; k < 3; ++k) {
        const Taylor3 tip = slope(place.tip[k]), axis = path::reference_height_mm * slope(place.axis[k]);
        square += tip * tip + axis * axis;
    }
    return sqrt(square);
}

/// A function of u as a function of p.
Taylor3 by_p(const Taylor3& f, const Taylor3& speed) {
    const double a = 1 / speed.c[0], second = speed.c[1] / 2, third = speed.c[2] / 3;
    const double b = -second * a * a * a, c = a * a * a * a * a * (2 * second * second - speed.c[0] * third);
    return {f.c[0], f.c[1] * a, f.c[1] * b + f.c[2] * a * a, f.c[1] * c + 2 * f.c[2] * a * b + f.c[3] * a * a * a};
}

/// ∫ dp by Gauss's rule of five points.
double length_mm(const Curve& curve, double from, double to) {
    constexpr std::array<double, 5> node{-0.9061798459386640, -0.5384693101056831, 0, 0.5384693101056831,
                                         0.9061798459386640};
    constexpr std::array<double, 5> weight{0.2369268850561891, 0.4786286704993665, 0.5688888888888889,
                                           0.4786286704993665, 0.2369268850561891};
    double sum = 0;
    for (std::size_t k = 0; k < node.size(); ++k)
        sum += weight[k] * speed(curve.at(0.5 * (from + to) + 0.5 * (to - from) * node[k])).value();
    return 0.5 * (to - from) * sum;
}

/// The coefficients in u = (p − begin)/length of the polynomial of degree 7 through value and derivatives at both ends.
std::array<double, 8> septic(const Taylor3& from, const Taylor3& to, double h) {
    std::array<double, 4> a{}, b{};
    for (int k = 0; k < 4; ++k) {
        a[k] = from.c[k] * std::pow(h, k);
        b[k] = to.c[k] * std::pow(h, k);
    }
    const double r0 = b[0] - a[0] - a[1] - a[2] - a[3], r1 = b[1] - a[1] - 2 * a[2] - 3 * a[3],
                 r2 = 2 * b[2] - 2 * a[2] - 6 * a[3], r3 = 6 * b[3] - 6 * a[3];
    return {a[0],
            a[1],
            a[2],
            a[3],
            35 * r0 - 15 * r1 + 2.5 * r2 - r3 / 6,
            -84 * r0 + 39 * r1 - 7 * r2 + r3 / 2,
            70 * r0 - 34 * r1 + 6.5 * r2 - r3 / 2,
            -20 * r0 + 10 * r1 - 2 * r2 + r3 / 6};
}

/// Coordinates of the path over u: position and orientation as the law has them. `near` goes along.
std::array<Taylor3, 6> coordinates(const Place& place, path::OrientationLaw law, const machine::Kinematics& kinematics,
                                   machine::RotaryPosition& near) {
    std::array<Taylor3, 6> out;
    std::copy(place.tip.begin(), place.tip.end(), out.begin());
    if (law == path::OrientationLaw::vector) {
        std::copy(place.axis.begin(), place.axis.end(), out.begin() + 3);
        return out;
    }
    const machine::RotarySeries words = kinematics.rotary_series(place.axis, near);
    std::copy(words.begin(), words.end(), out.begin() + 3);
    for (std::size_t k = 0; k < near.size(); ++k) near[k] = words[k].value();
    return out;
}

double rounded(double value, double step) {
    return std::round(value / step) * step;
}

path::PathCoordinates with_digits(std::array<double, 6> q, Digits digits, path::OrientationLaw law) {
    const double of_orientation = law == path::OrientationLaw::vector ? 1e-5 : 1e-3 * std::numbers::pi / 180;
    if (digits == Digits::some)
        for (int k = 0; k < 6; ++k) q[k] = rounded(q[k], k < 3 ? 1e-3 : of_orientation);
    const double length = law == path::OrientationLaw::vector ? std::hypot(q[3], q[4], q[5]) : 1;
    return {{q[0], q[1], q[2]}, {q[3] / length, q[4] / length, q[5] / length}};
}

/// Where on the curve the poses are, of about even or of random tip way between.
std::vector<double> places(const Curve& curve, const Posed& how) {
    Random random(how.seed);
    std::vector<double> us{curve.from};
    const double sign = curve.to < curve.from ? -1 : 1;
    while (true) {
        const Place place = curve.at(us.back());
        const double way = std::hypot(place.tip[0].d1(), place.tip[1].d1(), place.tip[2].d1());
        const double step = how.step_mm * (how.uneven ? random.between(0.3, 1.7) : 1) / way;
        if (std::abs(curve.to - us.back()) < 1.3 * step) break;
        us.push_back(us.back() + sign * step);
    }
    us.push_back(curve.to);
    return us;
}

}  // namespace

Curve spiral(double turns) {
    return {0, 2 * std::numbers::pi * turns, [](double u) {
                constexpr double wave = 2 * std::numbers::pi / 60;
                const double tilt = std::tan(std::numbers::pi / 6);
                const Taylor3 angle = variable(u), radius = 5.0 + (0.5 / std::numbers::pi) * angle;
                const auto [sine, cosine] = sin_cos(angle);
                const Taylor3 x = radius * cosine, y = radius * sine;
                const auto [sine_x, cosine_x] = sin_cos(wave * x);
                const auto [sine_y, cosine_y] = sin_cos(wave * y);
                const Taylor3 slope_x = 3 * wave * cosine_x * sine_y, slope_y = 3 * wave * sine_x * cosine_y;
                return Place{{x, y, 3 * sine_x * sine_y}, normalised({-slope_x, tilt - slope_y, 1.0})};
            }};
}

Curve sine_row(double y_mm, double lean_rad) {
    return {-40, 40, [y_mm, tilt = std::tan(lean_rad)](double u) {
                const Taylor3 x = variable(u);
                const auto [sine_x, cosine_x] = sin_cos(x * (1.0 / 12));
                const double sine_y = std::sin(y_mm / 15), cosine_y = std::cos(y_mm / 15);
                const Taylor3 slope_x = cosine_x * (cosine_y * 3 / 12), slope_y = sine_x * (-sine_y * 3 / 15);
                return Place{{x, y_mm, sine_x * (3 * cosine_y)}, normalised({-slope_x, tilt - slope_y, 1.0})};
            }};
}

Curve backwards(const Curve& curve) {
    return {curve.to, curve.from, curve.at};
}

path::Run posed(const Curve& curve, const Posed& how, path::OrientationLaw law, const machine::Kinematics& kinematics) {
    path::Run run;
    run.law = law;
    run.kinematics = &kinematics;
    machine::RotaryPosition near{};
    for (const double u : places(curve, how)) {
        const std::array<Taylor3, 6> series = coordinates(curve.at(u), law, kinematics, near);
        std::array<double, 6> q{};
        std::transform(series.begin(), series.end(), q.begin(), [](const Taylor3& s) { return s.value(); });
        run.vertices.push_back(with_digits(q, how.digits, law));
        if (how.doubled && run.vertices.size() % 7 == 0) run.vertices.push_back(run.vertices.back());
    }
    for (std::size_t i = 1; i < run.vertices.size(); ++i) {
        path::Block block;
        block.length_mm = path::block_length_mm(run, run.vertices[i - 1], run.vertices[i]);
        block.feed = {program::FeedRule::tip_speed, feed_mm_s};
        block.line = static_cast<std::int32_t>(i);
        run.blocks.push_back(block);
    }
    return run;
}

path::ToolPath exact_path(const Curve& curve, path::OrientationLaw law, const machine::Kinematics& kinematics) {
    path::ToolPath out;
    out.law = law;
    out.kinematics = &kinematics;
    const double direction = curve.to < curve.from ? -1 : 1;
    const int count = static_cast<int>(std::ceil(std::abs(length_mm(curve, curve.from, curve.to)) / piece_mm)) + 1;
    machine::RotaryPosition near{};
    const auto at = [&](double u) {
        const Place place = curve.at(u);
        std::array<Taylor3, 6> f = coordinates(place, law, kinematics, near);
        for (Taylor3& c : f) c = by_p(c, direction * speed(place));
        return f;
    };
    double u = curve.from;
    std::array<Taylor3, 6> from = at(u);
    for (int i = 1; i <= count; ++i) {
        const double next = curve.from + (curve.to - curve.from) * i / count;
        path::PathPiece piece{out.length_mm(), std::abs(length_mm(curve, u, next)), {}};
        const std::array<Taylor3, 6> to = at(next);
        for (int k = 0; k < 6; ++k) piece.coefficient[k] = septic(from[k], to[k], piece.length_mm);
        out.pieces.push_back(piece);
        u = next;
        from = to;
    }
    out.blocks.push_back({0, out.length_mm(), {program::FeedRule::tip_speed, feed_mm_s}, 1, out.length_mm()});
    return out;
}

}  // namespace trunnion::test
