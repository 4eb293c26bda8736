#include "trunnion/smoothing/link.hpp"

#include <algorithm>
#include <cmath>

namespace trunnion::smoothing {

namespace {

/// Derivatives of one corner curve at its end, along its own tangent.
struct EndDerivatives {
    double a, b, c;
};

EndDerivatives end_derivatives(const CornerSide& side) {
    const double inner = side.inner_mm, outer = side.outer_mm;
    return {6 * (outer - inner), 12 * (3 * inner - 2 * outer), -12 * ((7 + side.cosine) * inner - 4 * outer)};
}

/// Powers 4 to 7 of the polynomial of degree 7 with these first three at 0, seen from that end.
std::array<double, 7> hermite(const LinkEnd& near, const LinkEnd& far) {
    const double a1 = near.first, a2 = near.second / 2, a3 = near.third / 6;
    // What the last four must make up for at u = 1; the far end's even derivatives change sign when seen from here.
    const double r0 = 1 - a1 - a2 - a3, r1 = far.first - a1 - 2 * a2 - 3 * a3;
    const double r2 = -far.second - 2 * a2 - 6 * a3, r3 = far.third - 6 * a3;
    return {a1,
            a2,
            a3,
            35 * r0 - 15 * r1 + 2.5 * r2 - r3 / 6,
            -84 * r0 + 39 * r1 - 7 * r2 + r3 / 2,
            70 * r0 - 34 * r1 + 6.5 * r2 - r3 / 2,
            -20 * r0 + 10 * r1 - 2 * r2 + r3 / 6};
}

/// Bernstein coefficients of a polynomial of degree 6.
using Slope = std::array<double, 7>;

/// Whether it is above `least` on the interval: yes where all coefficients are, no where an end is not, else by halves.
bool stays_above(const Slope& slope, double least, int halvings) {
    if (std::ranges::all_of(slope, [&](double b) { return b > least; })) return true;
    if (!(slope.front() > least) || !(slope.back() > least) || halvings == 0) return false;
    Slope left, right = slope;
    for (std::size_t level = 0; level < slope.size(); ++level) {
        left[level] = right[0];
        for (std::size_t i = 0; i + level + 1 < slope.size(); ++i) right[i] = (right[i] + right[i + 1]) / 2;
    }
    return stays_above(left, least, halvings - 1) && stays_above(right, least, halvings - 1);
}

}  // namespace

LinkEnd closed_link_end(const CornerSide& bottom, const CornerSide& top, double rate) noexcept {
    const EndDerivatives b = end_derivatives(bottom), t = end_derivatives(top);
    LinkEnd end;
    end.first = rate * b.a / t.a;
    end.second = (rate * b.b - t.b * end.first * end.first) / t.a;
    end.third = (rate * b.c - t.c * end.first * end.first * end.first - 3 * t.b * end.first * end.second) / t.a;
    return end;
}

std::optional<ParameterLink> ParameterLink::through(const LinkEnd& entry, const LinkEnd& exit) noexcept {
    const ParameterLink link(hermite(entry, exit), hermite(exit, entry));
    if (!link.increases()) return std::nullopt;
    return link;
}

bool ParameterLink::increases() const noexcept {
    // b_k = Σ_{i ≤ k} C(k,i)/C(6,i)·d_i of the powers d_i of f′, as repeated sums.
    constexpr std::array<double, 7> choose{1, 6, 15, 20, 15, 6, 1};
    Slope slope;
    for (std::size_t i = 0; i < slope.size(); ++i) slope[i] = static_cast<double>(i + 1) * sides_[0][i] / choose[i];
    for (std::size_t from = 0; from + 1 < slope.size(); ++from)
        for (std::size_t i = slope.size() - 1; i > from; --i) slope[i] += slope[i - 1];
    double largest = 0;
    for (const double b : slope) largest = std::max(largest, std::abs(b));
    constexpr double smallest_share = 1e-9;
    constexpr int most_halvings = 24;
    return stays_above(slope, smallest_share * largest, most_halvings);
}

Taylor3 ParameterLink::at(double u) const noexcept {
    const bool mirrored = u > 0.5;
    const double v = mirrored ? 1 - u : u;
    const Powers& p = sides_[mirrored ? 1 : 0];
    double c0 = p[6], c1 = 0, c2 = 0, c3 = 0;
    const auto shift = [&](double next) {
        c3 = c3 * v + c2;
        c2 = c2 * v + c1;
        c1 = c1 * v + c0;
        c0 = c0 * v + next;
    };
    for (int k = 5; k >= 0; --k) shift(p[k]);
    shift(0);
    return mirrored ? Taylor3{1 - c0, c1, -c2, c3} : Taylor3{c0, c1, c2, c3};
}

double ParameterLink::inverse(double value) const noexcept {
    double low = 0, high = 1, u = value;
    constexpr int most_steps = 100;  // 53 halvings alone would do
    constexpr double last_step = 1e-16;
    for (int step = 0; step < most_steps && high - low > last_step; ++step) {
        const Taylor3 f = at(u);
        const double miss = f.value() - value, change = miss / f.d1();
        if (std::abs(change) <= last_step) return u;
        (miss > 0 ? high : low) = u;
        const double next = u - change;
        u = next > low && next < high ? next : low + (high - low) / 2;
    }
    return u;
}

std::optional<ParameterLink> closed_link(const DualCorner& corner) noexcept {
    return ParameterLink::through(closed_link_end(corner.bottom[0], corner.top[0], corner.rate[0]),
                                  closed_link_end(corner.bottom[1], corner.top[1], corner.rate[1]));
}

}  // namespace trunnion::smoothing
