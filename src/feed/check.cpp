#include "detail/check.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "detail/loads.hpp"
#include "detail/rest_arc.hpp"

namespace trunnion::feed {
namespace {

using motion::ProfilePiece;

constexpr double known_well = 1e-4;  // of a limit, between a bound and what is certainly reached
constexpr int deepest_halving = 7;
// A tightened row lets the peak move: a little more than the excess is taken off, but no step that makes another peak.
constexpr double more = 1.3, reserve = 2e-4;
constexpr double infinite = std::numeric_limits<double>::infinity();

Speed speed_on(const ProfilePiece& piece, double begin, double length) {
    const double third = (piece.e1 - piece.e0) / piece.length_mm;
    const auto x_at = [&](double u) { return piece.x0 + u * (piece.d0 + u * (piece.e0 / 2 + u * third / 6)); };
    const auto d_at = [&](double u) { return piece.d0 + u * (piece.e0 + u * third / 2); };
    const double end = begin + length, xa = x_at(begin), xb = x_at(end), da = d_at(begin), db = d_at(end);
    const double ea = piece.e0 + third * begin, eb = piece.e0 + third * end;
    return {{xa, xa + length / 3 * da, xb - length / 3 * db, xb}, {da, da + length / 2 * ea, db}, {ea, eb}};
}

/// A lower bound of x^(−½): its tangent at the middle of x, in degree 6. Not positive where x varies too much for it.
Bernstein<double, 6> tangent(const Bernstein<double, 3>& x) {
    const double middle = (x[0] + x[1] + x[2] + x[3]) / 4, root = 1 / std::sqrt(middle);
    Bernstein<double, 3> out;
    for (int i = 0; i < 4; ++i) out[i] = root * (1.5 - x[i] / (2 * middle));
    return elevated(elevated(elevated(out)));
}

/// Its inverse; infinite where there is no such bound.
Bernstein<double, 6> inverse_room(const Bernstein<double, 3>& x) {
    Bernstein<double, 6> out = tangent(x);
    for (double& room : out) room = room > 0 ? 1 / room : infinite;
    return out;
}

InverseLimits inverse_of(const LimitSet& limits) {
    InverseLimits out;
    for (int c = 0; c < coordinates; ++c) {
        GroupLoads& group = out[c / group_size];
        group.velocity[c % group_size] = 1 / limits.of[c].velocity;
        group.acceleration[c % group_size] = 1 / limits.of[c].acceleration;
        group.jerk[c % group_size] = 1 / limits.of[c].jerk;
    }
    return out;
}

/// The bound of |f| / room, where room is 1 or the tangent of x^(−½), known to `known_well`.
class Closer {
  public:
    /// f against 1.
    template <std::size_t n>
    static double bound(const std::array<double, n>& f) {
        Closer closer;
        closer.look(f, deepest_halving);
        return closer.bound_;
    }
    /// f against x^(−½).
    static double bound(const Bernstein<double, 6>& f, const Bernstein<double, 3>& x) {
        Closer closer;
        closer.look(f, x, deepest_halving);
        return closer.bound_;
    }

  private:
    void settle(double hull, double reached) {
        reached_ = std::max(reached_, reached);
        bound_ = std::max(bound_, hull);
    }
    bool is_known(double hull) const { return hull <= std::max(reached_ + known_well, bound_); }

    template <std::size_t n>
    void look(const std::array<double, n>& f, int depth) {
        double hull = 0;
        for (const double value : f) hull = std::max(hull, std::abs(value));
        reached_ = std::max({reached_, std::abs(f.front()), std::abs(f.back())});
        if (depth == 0 || is_known(hull)) return settle(hull, reached_);
        std::array<double, n> left, right;
        halve(f, left, right);
        look(left, depth - 1);
        look(right, depth - 1);
    }
    void look(const Bernstein<double, 6>& f, const Bernstein<double, 3>& x, int depth) {
        const Bernstein<double, 6> room = tangent(x);
        double hull = 0;
        for (int i = 0; i <= 6; ++i) hull = room[i] > 0 ? std::max(hull, std::abs(f[i]) / room[i]) : infinite;
        reached_ = std::max({reached_, std::abs(f[0]) * std::sqrt(x[0]), std::abs(f[6]) * std::sqrt(x[3])});
        if (depth == 0 || is_known(hull)) return settle(hull, reached_);
        Bernstein<double, 6> left, right;
        Bernstein<double, 3> x_left, x_right;
        halve(f, left, right);
        halve(x, x_left, x_right);
        look(left, x_left, depth - 1);
        look(right, x_right, depth - 1);
    }

    double reached_ = 0, bound_ = 0;
};

template <std::size_t n>
std::array<double, n> coordinate_of(const std::array<Group, n>& f, int c, double scale) {
    std::array<double, n> out;
    for (std::size_t i = 0; i < n; ++i) out[i] = scale * f[i][c];
    return out;
}

void bound_half(const Half& half, const InverseLimits& inverse, const Interest& interest,
                std::array<Peaks::OfCoordinate, coordinates>& out) {
    static const BoundLoads bound_loads = bound_loads_here();
    GroupPolynomials loads;
    GroupLoads bounds;
    for (int c = 0; c < coordinates; ++c) {
        const int group = c / group_size, i = c % group_size;
        const GroupLoads& per = inverse[group];
        if (i == 0) bound_loads(half, group, per, loads, bounds);
        Peaks::OfCoordinate& own = out[c];
        own = {bounds.velocity[i], bounds.acceleration[i], bounds.jerk[i]};
        if (own.velocity > interest[c].velocity)
            own.velocity = Closer::bound(coordinate_of(loads.velocity, i, per.velocity[i]), half.speed.x);
        if (own.acceleration > interest[c].acceleration)
            own.acceleration = Closer::bound(coordinate_of(loads.acceleration, i, per.acceleration[i]));
        if (own.jerk > interest[c].jerk)
            own.jerk = Closer::bound(coordinate_of(loads.jerk, i, per.jerk[i]), half.speed.x);
    }
}

}  // namespace

BoundLoads bound_loads_here() {
#ifdef TRUNNION_WITH_AVX2
    if (__builtin_cpu_supports("avx2")) return avx2::bound_loads;
#endif
    return baseline::bound_loads;
}

Interest interest_from(double ratio) {
    Interest out;
    out.fill({ratio, ratio, ratio});
    return out;
}

Peaks::OfCoordinate Peaks::of(int c) const {
    return {std::max(half[0][c].velocity, half[1][c].velocity),
            std::max(half[0][c].acceleration, half[1][c].acceleration), std::max(half[0][c].jerk, half[1][c].jerk)};
}

Peaks::OfCoordinate Peaks::worst_of_each() const {
    OfCoordinate out;
    for (int c = 0; c < coordinates; ++c) {
        const OfCoordinate own = of(c);
        out = {std::max(out.velocity, own.velocity), std::max(out.acceleration, own.acceleration),
               std::max(out.jerk, own.jerk)};
    }
    return out;
}

double Peaks::worst() const {
    const OfCoordinate each = worst_of_each();
    return std::max({each.velocity, each.acceleration, each.jerk});
}

LoadCheck::LoadCheck(const LimitSet& limits) : limits_(&limits), inverse_(inverse_of(limits)) {}

Peaks LoadCheck::peaks(const Interval& interval, const ProfilePiece& piece, const Interest& interest) const {
    Peaks out;
    if (piece.kind != ProfilePiece::Kind::cubic) {
        const RestSide side = piece.kind == ProfilePiece::Kind::rest_start ? RestSide::start : RestSide::stop;
        out.half[0] = arc_loads(interval, side, *limits_, arc_alpha(piece.jerk_mm_s3));
        return out;
    }
    const double h = piece.length_mm / 2;
    for (int k = 0; k < 2; ++k) {
        const Speed speed = speed_on(piece, k * h, h);
        const Half half{interval.samples[k], interval.samples[k + 1], h, speed, inverse_room(speed.x)};
        bound_half(half, inverse_, interest, out.half[k]);
    }
    return out;
}

bool is_positive(const ProfilePiece& piece) {
    if (piece.kind != ProfilePiece::Kind::cubic) return piece.jerk_mm_s3 > 0;
    const double h = piece.length_mm;
    const Bernstein<double, 3> x = speed_on(piece, 0, h).x;
    if (!(x[0] > 0 && x[3] > 0)) return false;
    if (x[1] > 0 && x[2] > 0) return true;
    const double third = (piece.e1 - piece.e0) / h, root = piece.e0 * piece.e0 - 2 * third * piece.d0;
    if (root <= 0) return true;  // no inner extremum
    // The minimum is where x″ = +√root, in the form without cancellation.
    const double s = std::sqrt(root);
    const double at = piece.e0 >= 0 ? -2 * piece.d0 / (piece.e0 + s) : (s - piece.e0) / third;
    return !(at > 0 && at < h) || speed_on(piece, at, 0).x[0] > 0;
}

bool tighten(const Peaks& peaks, double trigger, Tightening& tightening) {
    Tightening::OfSamples none{1, 1, 1};
    bool changed = false;
    const auto raise = [&](int half, double ratio, double power, Tightening::OfSamples& factors,
                           Tightening::OfSamples& raised) {
        if (!(ratio > trigger)) return;
        const double factor = std::pow(1 + more * (ratio - 1) + reserve, power);
        for (const int sample : {half, half + 1}) raised[sample] = std::max(raised[sample], factor * factors[sample]);
        changed = true;
    };
    const auto take = [](const Tightening::OfSamples& raised, Tightening::OfSamples& factors) {
        for (int i = 0; i < samples_per_interval; ++i) factors[i] = std::max(factors[i], raised[i]);
    };
    Tightening::OfSamples speed = none;
    for (int c = 0; c < coordinates; ++c) {
        Tightening::OfSamples acceleration = none, jerk = none;
        for (int half = 0; half < 2; ++half) {
            const Peaks::OfCoordinate& peak = peaks.half[half][c];
            raise(half, peak.velocity, 2, tightening.speed, speed);
            raise(half, peak.acceleration, 1, tightening.acceleration[c], acceleration);
            raise(half, peak.jerk, 1, tightening.jerk[c], jerk);
        }
        take(acceleration, tightening.acceleration[c]);
        take(jerk, tightening.jerk[c]);
    }
    take(speed, tightening.speed);
    return changed;
}

void slow_down(std::span<ProfilePiece> pieces, double lambda) {
    for (ProfilePiece& piece : pieces) {
        piece.x0 *= lambda;
        piece.d0 *= lambda;
        piece.e0 *= lambda;
        piece.e1 *= lambda;
        piece.jerk_mm_s3 *= lambda * std::sqrt(lambda);
    }
}

double lambda_for(const Peaks& peaks) {
    const Peaks::OfCoordinate each = peaks.worst_of_each();
    const double jerk = std::cbrt(each.jerk);
    return 1 / std::max({1.0, each.velocity * each.velocity, each.acceleration, jerk * jerk});
}

}  // namespace trunnion::feed
