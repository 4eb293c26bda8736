#pragma once

#include <array>

namespace trunnion::smoothing {

/// Kernels that replace the kink |x|/2 of a polyline by a smooth bump: on |t| ≤ 1
///
///     g″ = k − δ,   g and its first three derivatives 0 at |t| = 1,
///
/// so a unit kink plus w·g(x/w) is |x|/2 convolved with k of width w. Each function takes t in [−1, 1];
/// slope(t) is g′ (at t = 0 its right limit), density(t) is k, density_slope(t) is k′. even[m] belongs to t²ᵐ in
/// g = Σ even[m]·t²ᵐ − |t|/2.

/// For the smooth part: moments 1 to 3 of k vanish, so a curve is displaced only by O(w⁴). Not positive.
struct CurveKernel {
    static constexpr double peak = 35.0 / 512;  ///< g(0)
    static constexpr std::array<double, 5> even{35.0 / 512, 420.0 / 512, -350.0 / 512, 196.0 / 512, -45.0 / 512};
    static constexpr double fourth_moment = 1.0 / 33;  ///< −∫ t⁴ k
    static double bump(double t) {
        const double s = t * t;
        return (35 + s * (420 + s * (-350 + s * (196 - 45 * s)))) / 512 - (t < 0 ? -t : t) / 2;
    }
    static double slope(double t) {
        const double s = t * t;
        return t * (840 + s * (-1400 + s * (1176 - 360 * s))) / 512 - (t < 0 ? -0.5 : 0.5);
    }
    static double density(double t) {
        const double s = t * t;
        return 105.0 / 64 * (1 - s) * (1 - s) * (1 - 3 * s);
    }
    static double density_slope(double t) {
        const double s = t * t;
        return 105.0 / 64 * t * (-10 + s * (28 - 18 * s));
    }
};

/// For corners: triweight, positive, so the rounded corner stays inside the corner's triangle.
struct CornerKernel {
    static constexpr double peak = 35.0 / 256;
    static constexpr std::array<double, 5> even{35.0 / 256, 140.0 / 256, -70.0 / 256, 28.0 / 256, -5.0 / 256};
    static double bump(double t) {
        const double s = t * t;
        return (35 + s * (140 + s * (-70 + s * (28 - 5 * s)))) / 256 - (t < 0 ? -t : t) / 2;
    }
    static double slope(double t) {
        const double s = t * t;
        return t * (280 + s * (-280 + s * (168 - 40 * s))) / 256 - (t < 0 ? -0.5 : 0.5);
    }
    static double density(double t) {
        const double r = 1 - t * t;
        return 35.0 / 32 * r * r * r;
    }
    static double density_slope(double t) {
        const double r = 1 - t * t;
        return -105.0 / 16 * t * r * r;
    }
};

/// Biweight: only measures how far a kink stands alone (C³ path, never shipped).
struct DetectionKernel {
    static constexpr double peak = 5.0 / 32;
    static constexpr std::array<double, 5> even{5.0 / 32, 15.0 / 32, -5.0 / 32, 1.0 / 32, 0};
    static double bump(double t) {
        const double s = t * t;
        return (5 + s * (15 + s * (-5 + s))) / 32 - (t < 0 ? -t : t) / 2;
    }
};

}  // namespace trunnion::smoothing
