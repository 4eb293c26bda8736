#include "detail/bumps.hpp"

#include <algorithm>

#include "trunnion/smoothing/kernel.hpp"

namespace trunnion::smoothing {

namespace {

/// How many vertices after the first end lie nearer than `reach_mm`, and one more if there is one.
template <class GapAt>
std::size_t vertices_within(std::size_t blocks, double reach_mm, GapAt&& gap_at) {
    std::size_t k = 0;
    for (double d = 0; k < blocks && d < reach_mm; ++k) d += gap_at(k);
    return k;
}

}  // namespace

Bumps::Bumps(const Polyline& line, double cap_mm) : cap_(cap_mm), count_(line.vertex.size()) {
    const std::size_t n = line.blocks();
    lead_ = vertices_within(n, cap_mm, [&](std::size_t k) { return line.gap_mm[k]; });
    const std::size_t trail = vertices_within(n, cap_mm, [&](std::size_t k) { return line.gap_mm[n - 1 - k]; });
    for (std::size_t k = 0; k < lead_ + n + trail; ++k) {
        const std::size_t block = k < lead_ ? lead_ - 1 - k : k < lead_ + n ? k - lead_ : lead_ + 2 * n - 1 - k;
        gap.push_back(line.gap_mm[block]);
        slope.push_back(line.slope[block]);
    }
    jump.resize(gap.size() + 1, Coordinates::Zero());
    for (std::size_t k = 1; k < gap.size(); ++k) jump[k] = slope[k] - slope[k - 1];
    jump[first()].setZero();
    jump[last()].setZero();
    corner_share.assign(size(), 0);
    curve_width.assign(size(), cap_mm);
    corner_width.assign(size(), cap_mm);
    mirror();
}

std::size_t Bumps::source(std::size_t vertex) const {
    if (vertex < lead_) return 2 * lead_ - vertex;
    return vertex > last() ? 2 * last() - vertex : vertex;
}

void Bumps::mirror() {
    for (std::size_t k = 0; k < size(); ++k) {
        const std::size_t from = source(k);
        corner_share[k] = corner_share[from];
        curve_width[k] = curve_width[from];
        corner_width[k] = corner_width[from];
    }
    const auto own = [&](std::size_t k) {
        return corner_share[k] > 0 ? std::max(curve_width[k], corner_width[k]) : curve_width[k];
    };
    reach_from_left_.resize(size());
    reach_from_right_.resize(size());
    for (std::size_t k = 0; k < size(); ++k)
        reach_from_left_[k] = k > 0 ? std::max(own(k), reach_from_left_[k - 1] - gap[k - 1]) : own(k);
    for (std::size_t k = size(); k-- > 0;)
        reach_from_right_[k] = k + 1 < size() ? std::max(own(k), reach_from_right_[k + 1] - gap[k]) : own(k);
}

void Bumps::limit_slope(std::vector<double>& width, double per_mm) const {
    for (std::size_t k = first() + 1; k <= last(); ++k)
        width[k] = std::min(width[k], width[k - 1] + per_mm * gap[k - 1]);
    for (std::size_t k = last(); k-- > first();) width[k] = std::min(width[k], width[k + 1] + per_mm * gap[k]);
}

Deviation Bumps::deviation(Place at) const {
    Deviation sum;
    touching(at, 0, [&](std::size_t j, double d) {
        const double distance = d < 0 ? -d : d;
        const double f = corner_share[j], w = curve_width[j], v = corner_width[j];
        if (f < 1 && distance < w) sum.curve += jump[j] * ((1 - f) * w * CurveKernel::bump(d / w));
        if (f > 0 && distance < v) sum.corner += jump[j] * (f * v * CornerKernel::bump(d / v));
    });
    return sum;
}

Jet Bumps::jet(Place at) const {
    Jet c;
    for (Coordinates& x : c) x.setZero();
    c[1] = slope[at.block];
    touching(at, 0, [&](std::size_t j, double d) {
        const double distance = d < 0 ? -d : d;
        std::array<double, 4> factor{};
        const auto add = [&](auto kernel, double share, double w) {
            if (share <= 0 || distance >= w) return;
            const double inverse = 1 / w, t = d * inverse;
            factor[0] += share * w * kernel.bump(t);
            factor[1] += share * kernel.slope(t);
            factor[2] += share * inverse * kernel.density(t);
            factor[3] += share * inverse * inverse * kernel.density_slope(t);
        };
        add(CurveKernel{}, 1 - corner_share[j], curve_width[j]);
        add(CornerKernel{}, corner_share[j], corner_width[j]);
        for (int k = 0; k < 4; ++k) c[k] += factor[k] * jump[j];
    });
    return c;
}

}  // namespace trunnion::smoothing
