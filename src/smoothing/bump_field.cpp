#include "detail/bump_field.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "trunnion/smoothing/kernel.hpp"

#include "detail/half_bump.hpp"

namespace trunnion::smoothing {

template <class Kernel>
BumpField<Kernel>::BumpField(std::span<const long double> position, std::span<const Coordinates> jump)
    : position_(position), jump_(jump), bumps_(position.size()), leaves_(std::bit_ceil(groups())) {}

/// The first vertex of a group; behind the last group: the last vertex.
template <class Kernel>
std::size_t BumpField<Kernel>::vertex_of(std::size_t group_index) const {
    return std::min(group_index * group, position_.size() - 1);
}

template <class Kernel>
void BumpField<Kernel>::update(std::span<const double> share, std::span<const double> width) {
    const std::size_t count = position_.size(), groups = this->groups();
    first_ending_.assign(groups + 1, count);
    first_beginning_.assign(groups + 1, count);
    std::size_t left = 0, right = 0, ending = 0, beginning = 0;
    for (std::size_t k = 0; k < count; ++k) {
        const long double begin = position_[k] - width[k], end = position_[k] + width[k];
        while (right + 1 < groups && position_[vertex_of(right + 1)] <= end) ++right;
        while (left + 1 < groups && position_[vertex_of(left + 1)] <= begin) ++left;
        while (ending <= right) first_ending_[ending++] = k;
        while (beginning <= left) first_beginning_[beginning++] = k;
        const Bump now{share[k], width[k], static_cast<std::int32_t>(left), static_cast<std::int32_t>(right)};
        if (now == bumps_[k]) continue;
        put(k, bumps_[k], -1);
        put(k, now, 1);
        bumps_[k] = now;
    }
}

template <class Kernel>
std::size_t BumpField<Kernel>::halves_over(std::size_t block) const {
    const std::size_t g = group_of(block), first = vertex_of(g), last = vertex_of(g + 1);
    const std::size_t from_behind = first - std::min(first, first_ending_[g + 1]);
    return from_behind + std::max(first_beginning_[g], last + 1) - (last + 1);
}

template <class Kernel>
void BumpField<Kernel>::put(std::size_t vertex, const Bump& bump, double sign) {
    if (!(bump.share > 0) || jump_[vertex].isZero(0)) return;
    const std::size_t after = vertex / group + 1, before = vertex % group == 0 ? vertex / group : after;
    const auto left = static_cast<std::size_t>(bump.left), right = static_cast<std::size_t>(bump.right);
    if (after < right) put_half(vertex, bump, sign, after, right, true);
    if (left + 2 < before) put_half(vertex, bump, sign, left + 1, before - 1, false);
}

/// Into the largest cells within groups first … behind.
template <class Kernel>
void BumpField<Kernel>::put_half(std::size_t vertex, const Bump& bump, double sign, std::size_t first,
                                 std::size_t behind, bool right) {
    cells_.resize(2 * leaves_);
    std::size_t size = 1;
    for (std::size_t l = first + leaves_, r = behind + leaves_; l < r; l /= 2, r /= 2, size *= 2) {
        const auto put_here = [&](std::size_t cell) {
            const std::size_t from = cell * size - leaves_;
            put_in_cell(cell, from, from + size, vertex, bump, sign, right);
        };
        if (l % 2 == 1) put_here(l++);
        if (r % 2 == 1) put_here(--r);
    }
}

template <class Kernel>
void BumpField<Kernel>::put_in_cell(std::size_t cell, std::size_t first, std::size_t behind, std::size_t vertex,
                                    const Bump& bump, double sign, bool right) {
    const long double begin = position_[vertex_of(first)], end = position_[vertex_of(behind)];
    const auto offset = static_cast<double>(0.5L * (begin + end) - position_[vertex]);
    const double t = offset / bump.width, per_s = 0.5 * static_cast<double>(end - begin) / bump.width;
    Octic q = even_part<Kernel>(t);
    q[0] -= right ? 0.5 * t : -0.5 * t;
    q[1] -= right ? 0.5 : -0.5;
    Cell& c = cells_[cell];
    if (c.halves++ == 0)
        for (Coordinates& x : c.coefficient) x.setZero();
    double scale = sign * bump.share * bump.width;
    for (std::size_t n = 0; n < q.size(); ++n, scale *= per_s) c.coefficient[n] += (scale * q[n]) * jump_[vertex];
}

template <class Kernel>
template <std::size_t orders>
void BumpField<Kernel>::add_cells(std::size_t at_group, long double at, std::array<Coordinates, orders>& sum) const {
    if (cells_.empty()) return;
    std::size_t size = 1;
    for (std::size_t cell = leaves_ + at_group; cell > 0; cell /= 2, size *= 2) {
        const Cell& c = cells_[cell];
        if (c.halves == 0) continue;
        const std::size_t first = cell * size - leaves_;
        const long double begin = position_[vertex_of(first)], end = position_[vertex_of(first + size)];
        const double per_mm = 2 / static_cast<double>(end - begin);
        const double s = static_cast<double>(at - 0.5L * (begin + end)) * per_mm;
        std::array<Coordinates, orders> taylor;
        for (Coordinates& x : taylor) x.setZero();
        for (std::size_t n = c.coefficient.size(); n-- > 0;) {
            for (std::size_t o = orders - 1; o > 0; --o) taylor[o] = taylor[o] * s + taylor[o - 1];
            taylor[0] = taylor[0] * s + c.coefficient[n];
        }
        double scale = 1;
        for (std::size_t o = 0; o < orders; scale *= static_cast<double>(++o) * per_mm) sum[o] += scale * taylor[o];
    }
}

template <class Kernel>
template <std::size_t orders>
void BumpField<Kernel>::add(std::size_t block, double offset_mm, std::array<Coordinates, orders>& sum) const {
    const std::size_t at_group = group_of(block);
    const std::size_t first = vertex_of(at_group), last = vertex_of(at_group + 1);
    const auto add_one = [&](std::size_t k, double distance) {
        add_bump<Kernel>(jump_[k], bumps_[k].share, bumps_[k].width, distance, sum);
    };
    for (std::size_t k = first; k <= last; ++k) {
        const double distance = static_cast<double>(position_[block] - position_[k]) + offset_mm;
        add_one(k, k <= block ? std::max(distance, 0.0) : std::min(distance, least_ahead));
    }
    const long double at = position_[block] + offset_mm;
    for (std::size_t k = first_ending_[at_group]; k < std::min(first, first_ending_[at_group + 1]); ++k)
        add_one(k, static_cast<double>(at - position_[k]));
    for (std::size_t k = std::max(last + 1, first_beginning_[at_group]); k < first_beginning_[at_group + 1]; ++k)
        add_one(k, static_cast<double>(at - position_[k]));
    add_cells(at_group, at, sum);
}

template class BumpField<CurveKernel>;
template class BumpField<CornerKernel>;
template void BumpField<CurveKernel>::add(std::size_t, double, std::array<Coordinates, 1>&) const;
template void BumpField<CurveKernel>::add(std::size_t, double, std::array<Coordinates, 2>&) const;
template void BumpField<CurveKernel>::add(std::size_t, double, std::array<Coordinates, 4>&) const;
template void BumpField<CornerKernel>::add(std::size_t, double, std::array<Coordinates, 1>&) const;
template void BumpField<CornerKernel>::add(std::size_t, double, std::array<Coordinates, 2>&) const;
template void BumpField<CornerKernel>::add(std::size_t, double, std::array<Coordinates, 4>&) const;

}  // namespace trunnion::smoothing
