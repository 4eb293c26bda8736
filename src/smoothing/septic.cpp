#include "detail/septic.hpp"

namespace trunnion::smoothing {

path::PathPiece hermite_piece(double begin_mm, double length_mm, const HermiteEnd& start, const HermiteEnd& end) {
    const double h = length_mm;
    std::array<Coordinates, 8> a;
    a[0] = start.value;
    a[1] = h * start.first;
    a[2] = (h * h / 2) * start.second;
    a[3] = (h * h * h / 6) * start.third;
    // What the last four coefficients must make up for at u = 1: value and derivatives by u.
    const Coordinates r0 = end.value - a[1] - a[2] - a[3];
    const Coordinates r1 = h * end.first - a[1] - 2 * a[2] - 3 * a[3];
    const Coordinates r2 = h * h * end.second - 2 * a[2] - 6 * a[3];
    const Coordinates r3 = h * h * h * end.third - 6 * a[3];
    a[4] = 35 * r0 - 15 * r1 + 2.5 * r2 - r3 / 6;
    a[5] = -84 * r0 + 39 * r1 - 7 * r2 + r3 / 2;
    a[6] = 70 * r0 - 34 * r1 + 6.5 * r2 - r3 / 2;
    a[7] = -20 * r0 + 10 * r1 - 2 * r2 + r3 / 6;
    path::PathPiece piece{begin_mm, length_mm, {}};
    for (int k = 0; k < 6; ++k)
        for (int i = 0; i < 8; ++i) piece.coefficient[k][i] = a[i][k];
    return piece;
}

Coordinates progress(const path::PathPiece& piece, double u) {
    Coordinates value;
    for (int k = 0; k < 6; ++k) {
        const auto& c = piece.coefficient[k];
        double f = c[7];
        for (int i = 6; i > 0; --i) f = f * u + c[i];
        value[k] = f * u;
    }
    return value;
}

Bernstein bernstein(const path::PathPiece& piece) {
    // b_k = Σ_{i ≤ k} C(k,i)/C(7,i)·a_i, as repeated sums of a_i/C(7,i).
    constexpr std::array<double, 8> choose{1, 7, 21, 35, 35, 21, 7, 1};
    Bernstein b;
    for (int i = 0; i < 8; ++i)
        for (int k = 0; k < 6; ++k) b[i][k] = piece.coefficient[k][i] / choose[i];
    for (int from = 0; from < 7; ++from)
        for (int i = 7; i > from; --i) b[i] += b[i - 1];
    return b;
}

Bernstein split(Bernstein& polynomial, double u) {
    Bernstein before;
    for (int level = 0; level < 8; ++level) {
        before[level] = polynomial[0];
        for (int i = 0; i + level < 7; ++i) polynomial[i] += u * (polynomial[i + 1] - polynomial[i]);
    }
    return before;
}

}  // namespace trunnion::smoothing
