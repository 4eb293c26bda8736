#include "trunnion/motion/feed_profile.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace trunnion::motion {
namespace {

constexpr int max_newton_steps = 30;
constexpr int max_halvings = 30, max_panels = 100;  // far more than any x > 0 of a plan needs
// Eight Gauss points reach 1e-12 on x^(-1/2) while x changes no more than this much within a panel.
constexpr double max_panel_ratio = 1.7;

struct GaussPoint {
    double abscissa, weight;
};
constexpr std::array<GaussPoint, 4> gauss8{{{0.18343464249564980494, 0.36268378337836198297},
                                            {0.52553240991632898582, 0.31370664587788728734},
                                            {0.79666647741362673959, 0.22238103445337447054},
                                            {0.96028985649753623168, 0.10122853629037625915}}};

/// ṗ² of a cubic piece and its derivatives by p.
struct Square {
    double x, d, e;
};

Square square_at(const ProfilePiece& piece, double delta) noexcept {
    const double third = (piece.e1 - piece.e0) / piece.length_mm;
    const double e = piece.e0 + third * delta;
    return {piece.x0 + delta * (piece.d0 + delta * (piece.e0 / 2 + delta * third / 6)),
            piece.d0 + delta * (piece.e0 + delta * third / 2), e};
}

double panel_time(const ProfilePiece& piece, double begin, double end) noexcept {
    const double middle = (begin + end) / 2, half = (end - begin) / 2;
    double sum = 0;
    for (const GaussPoint& g : gauss8) {
        const double step = half * g.abscissa;
        sum += g.weight *
               (1 / std::sqrt(square_at(piece, middle - step).x) + 1 / std::sqrt(square_at(piece, middle + step).x));
    }
    return half * sum;
}

/// Whether x stays within max_panel_ratio on the panel, by its Bézier values.
bool is_gentle(const ProfilePiece& piece, double begin, double end) noexcept {
    const Square a = square_at(piece, begin), b = square_at(piece, end);
    const double third = (end - begin) / 3;
    const auto [low, high] = std::minmax({a.x, a.x + third * a.d, b.x - third * b.d, b.x});
    return low > 0 && high <= max_panel_ratio * low;
}

double cubic_time(const ProfilePiece& piece, double end_mm) noexcept {
    double begin = 0, total = 0;
    for (int panel = 1; begin < end_mm; ++panel) {
        double end = end_mm;
        for (int k = 0; k < max_halvings && panel < max_panels && !is_gentle(piece, begin, end); ++k)
            end = (begin + end) / 2;
        if (!(end > begin)) break;
        total += panel_time(piece, begin, end);
        begin = end;
    }
    return total;
}

/// Constant jerk from rest: δ = j t³/6.
double rest_time(double distance, double jerk) noexcept {
    return std::cbrt(6 * std::max(distance, 0.0) / jerk);
}

double cubic_distance(const ProfilePiece& piece, double time) noexcept {
    const double total = cubic_time(piece, piece.length_mm);
    if (time >= total) return piece.length_mm;
    double low = 0, high = piece.length_mm;
    double delta = std::clamp(time * (std::sqrt(piece.x0) + time * piece.d0 / 4), 0.0, high);
    for (int k = 0; k < max_newton_steps; ++k) {
        const double error = cubic_time(piece, delta) - time;
        (error > 0 ? high : low) = delta;
        const double step = error * std::sqrt(square_at(piece, delta).x);
        double next = delta - step;
        if (!(next >= low && next <= high)) next = (low + high) / 2;
        if (std::abs(next - delta) <= 1e-15 * piece.length_mm || high <= low) return next;
        const bool converged = std::abs(step) <= 1e-8 * piece.length_mm;  // the next error is its square
        delta = next;
        if (converged) return delta;
    }
    return delta;
}

PathState rest_state(double delta, double time, double jerk, double direction) noexcept {
    return {0, delta, jerk * time * time / 2, direction * jerk * time, jerk};
}

}  // namespace

PathState state_at(const ProfilePiece& piece, double delta_mm) noexcept {
    if (piece.kind == ProfilePiece::Kind::rest_start)
        return rest_state(delta_mm, rest_time(delta_mm, piece.jerk_mm_s3), piece.jerk_mm_s3, 1);
    if (piece.kind == ProfilePiece::Kind::rest_stop)
        return rest_state(delta_mm, rest_time(piece.length_mm - delta_mm, piece.jerk_mm_s3), piece.jerk_mm_s3, -1);
    const Square s = square_at(piece, delta_mm);
    const double speed = std::sqrt(s.x);
    return {0, delta_mm, speed, s.d / 2, s.e / 2 * speed};
}

double time_to(const ProfilePiece& piece, double delta_mm) noexcept {
    if (piece.kind == ProfilePiece::Kind::rest_start) return rest_time(delta_mm, piece.jerk_mm_s3);
    if (piece.kind == ProfilePiece::Kind::rest_stop)
        return rest_time(piece.length_mm, piece.jerk_mm_s3) - rest_time(piece.length_mm - delta_mm, piece.jerk_mm_s3);
    return cubic_time(piece, std::clamp(delta_mm, 0.0, piece.length_mm));
}

double distance_at(const ProfilePiece& piece, double time_s) noexcept {
    if (time_s <= 0) return 0;
    if (piece.kind == ProfilePiece::Kind::cubic) return cubic_distance(piece, time_s);
    const double jerk = piece.jerk_mm_s3;
    if (piece.kind == ProfilePiece::Kind::rest_start)
        return std::min(jerk * time_s * time_s * time_s / 6, piece.length_mm);
    const double left = std::max(rest_time(piece.length_mm, jerk) - time_s, 0.0);
    return std::max(piece.length_mm - jerk * left * left * left / 6, 0.0);
}

}  // namespace trunnion::motion
