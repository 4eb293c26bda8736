#include "detail/stage.hpp"

#include <algorithm>
#include <limits>

namespace trunnion::feed {
namespace {

/// What rounding leaves of a pivot is never taken for less than this share of the diagonal that it came from.
double pivot_inverse(double pivot, double diagonal) {
    constexpr double smallest_share = 1e-13;
    return 1 / std::max({pivot, smallest_share * diagonal, std::numeric_limits<double>::min()});
}

/// (x, d, e0) after e1 = −(k1 · (x, d, e0)).
struct Reduced {
    double xx, xd, x0, dd, d0, e00;
};

Reduced substitute(const StageMatrix<double>& m, const StageGain& k) {
    const double sx = m.x1 - k.k1x * m.e11, sd = m.d1 - k.k1d * m.e11, s0 = m.e01 - k.k1e * m.e11;
    return {m.xx - k.k1x * m.x1 - sx * k.k1x, m.xd - k.k1x * m.d1 - sx * k.k1d,  m.x0 - k.k1x * m.e01 - sx * k.k1e,
            m.dd - k.k1d * m.d1 - sd * k.k1d, m.d0 - k.k1d * m.e01 - sd * k.k1e, m.e00 - k.k1e * m.e01 - s0 * k.k1e};
}

void rule_gain(double h, double kappa, StageGain& gain) {
    const double inverse = 1 / (h / 2 + kappa * h * h / 6);
    gain.k1x = kappa * inverse;
    gain.k1d = (1 + kappa * h) * inverse;
    gain.k1e = (h / 2 + kappa * h * h / 3) * inverse;
    gain.inverse1 = 0;
}

void optimal_gain(const StageMatrix<double>& m, StageGain& gain) {
    gain.inverse1 = pivot_inverse(m.e11, m.e11);
    gain.k1x = m.x1 * gain.inverse1;
    gain.k1d = m.d1 * gain.inverse1;
    gain.k1e = m.e01 * gain.inverse1;
}

}  // namespace

StageGain eliminate(const StageMatrix<double>& m, double h, const EndRule& end, CostToGo& cost) {
    StageGain gain;
    if (end.active)
        rule_gain(h, end.kappa, gain);
    else
        optimal_gain(m, gain);
    const Reduced r = substitute(m, gain);
    gain.inverse0 = pivot_inverse(r.e00, m.e00);
    gain.k0x = r.x0 * gain.inverse0;
    gain.k0d = r.d0 * gain.inverse0;
    cost = {std::max(r.xx - gain.k0x * r.x0, 0.0), r.xd - gain.k0x * r.d0, std::max(r.dd - gain.k0d * r.d0, 0.0)};
    return gain;
}

}  // namespace trunnion::feed
