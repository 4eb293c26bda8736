#include "detail/scale.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "trunnion/smoothing/kernel.hpp"

namespace trunnion::smoothing {

namespace {

constexpr int levels = 9;  // widths cap, cap/2, … cap/256

/// δ at a vertex for each width of the ladder, by one walk outwards.
template <class Kernel, class Share>
std::array<Coordinates, levels> deviations(const Curve& curve, std::size_t vertex, Share&& share) {
    const Bumps& bumps = curve.bumps;
    const double cap = curve.cap[vertex];
    std::array<Coordinates, levels> sum;
    for (auto& s : sum) s.setZero();
    bumps.around({vertex, 0}, cap, cap, [&](std::size_t j, double d) {
        const double distance = std::abs(d), part = share(j);
        if (part == 0) return;
        double width = cap;
        for (int l = 0; l < levels && distance < width; ++l, width *= 0.5)
            sum[l] += bumps.jump[j] * (part * width * Kernel::bump(distance / width));
    });
    return sum;
}

/// Where the variation, known at cap·2^−l and rising with the width, reaches `aim`.
double crossing(const std::array<double, levels>& variation, double cap, double aim) {
    if (variation[0] <= aim) return cap;
    int l = 0;
    while (l < levels && variation[l] > aim) ++l;
    if (l == levels) return std::ldexp(cap, 1 - levels) * aim / variation[levels - 1];
    const double low = std::log(std::max(variation[l], 1e-12)), high = std::log(variation[l - 1]);
    const double step = high > low ? (std::log(aim) - low) / (high - low) : 0;
    return std::ldexp(cap, -l) * std::exp2(std::clamp(step, 0.0, 1.0));
}

template <class Kernel, class Share>
void widths_by_variation(const Curve& curve, double aim, std::vector<double>& width, Share&& share) {
    for (std::size_t k = curve.bumps.first(); k <= curve.bumps.last(); ++k) {
        const auto delta = deviations<Kernel>(curve, k, share);
        std::array<double, levels> variation{};
        double sum = 0;
        for (int l = levels - 1; l >= 0; --l) {
            const Coordinates finer = l + 1 < levels ? delta[l + 1] : Coordinates(Coordinates::Zero());
            variation[l] = sum += curve.use(delta[l] - finer, k);
        }
        width[k] = crossing(variation, curve.cap[k], aim);
    }
}

}  // namespace

void find_raw_widths(Curve& curve, double aim) {
    widths_by_variation<DetectionKernel>(curve, aim, curve.raw_width, [](std::size_t) { return 1.0; });
}

void find_curve_widths(Curve& curve, double aim) {
    const auto share = [&](std::size_t j) { return 1 - curve.bumps.corner_share[j]; };
    widths_by_variation<CurveKernel>(curve, aim, curve.bumps.curve_width, share);
}

}  // namespace trunnion::smoothing
