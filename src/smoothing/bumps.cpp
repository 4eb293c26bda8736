#include "detail/bumps.hpp"

#include <algorithm>
#include <cmath>

#include "detail/half_bump.hpp"

namespace trunnion::smoothing {

namespace {

constexpr std::size_t worth_cells = 16;  // bumps that are summed faster by cells than one by one
constexpr std::size_t few = 16;          // vertices that are soon walked over

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
    position_.push_back(0);
    for (const double way : gap) position_.push_back(position_.back() + way);
    for (std::size_t k = 0; k < size(); ++k) {
        const Coordinates& own = line.vertex[source(k) - first()];
        const Coordinates& end = k < first() ? line.vertex.front() : line.vertex.back();
        place_.push_back(source(k) == k ? own : Coordinates(2 * end - own));
    }
    curves_ = BumpField<CurveKernel>(position_, jump);
    corners_ = BumpField<CornerKernel>(position_, jump);
}

std::size_t Bumps::source(std::size_t vertex) const {
    if (vertex < lead_) return 2 * lead_ - vertex;
    return vertex > last() ? 2 * last() - vertex : vertex;
}

Coordinates Bumps::cluster(std::size_t vertex, double radius_mm) const {
    const std::size_t before = std::max(vertex, few) - few, behind = std::min(vertex + few, size() - 1);
    if (distance(before, vertex) < radius_mm || distance(vertex, behind) < radius_mm)
        return (way(vertex, radius_mm) + way(vertex, -radius_mm)) / radius_mm;  // the polyline's second difference
    Coordinates sum = Coordinates::Zero();
    around({vertex, 0}, radius_mm, radius_mm,
           [&](std::size_t j, double d) { sum += jump[j] * (1 - std::abs(d) / radius_mm); });
    return sum;
}

/// P at `way_mm` behind a vertex (< 0: before it) − P there.
Coordinates Bumps::way(std::size_t vertex, double way_mm) const {
    const long double to = position_[vertex] + way_mm;
    const auto behind = std::upper_bound(position_.begin() + 1, position_.end() - 1, to) - position_.begin();
    const std::size_t block = static_cast<std::size_t>(behind) - 1;
    return place_[block] - place_[vertex] + slope[block] * static_cast<double>(to - position_[block]);
}

void Bumps::settle() {
    for (std::size_t k = 0; k < size(); ++k) {
        const std::size_t from = source(k);
        corner_share[k] = corner_share[from];
        curve_width[k] = curve_width[from];
        corner_width[k] = corner_width[from];
    }
    const auto of_corner = [&](std::size_t k) { return corner_share[k] > 0 ? corner_width[k] : -cap_; };
    note_reach(corner_reach_, of_corner);
    note_reach(reach_, [&](std::size_t k) { return std::max(curve_width[k], of_corner(k)); });
    curve_share_.resize(size());
    for (std::size_t k = 0; k < size(); ++k) curve_share_[k] = 1 - corner_share[k];
    curves_.update(curve_share_, curve_width);
    corners_.update(corner_share, corner_width);
}

template <class OwnReach>
void Bumps::note_reach(Reach& reach, OwnReach&& own) const {
    reach.from_left.resize(size());
    reach.from_right.resize(size());
    for (std::size_t k = 0; k < size(); ++k)
        reach.from_left[k] = k > 0 ? std::max(own(k), reach.from_left[k - 1] - gap[k - 1]) : own(k);
    for (std::size_t k = size(); k-- > 0;)
        reach.from_right[k] = k + 1 < size() ? std::max(own(k), reach.from_right[k + 1] - gap[k]) : own(k);
}

void Bumps::limit_slope(std::vector<double>& width, double per_mm) const {
    for (std::size_t k = first() + 1; k <= last(); ++k)
        width[k] = std::min(width[k], width[k - 1] + per_mm * gap[k - 1]);
    for (std::size_t k = last(); k-- > first();) width[k] = std::min(width[k], width[k + 1] + per_mm * gap[k]);
}

template <std::size_t orders>
void Bumps::add(Place at, std::array<Coordinates, orders>& curve, std::array<Coordinates, orders>& corner) const {
    if (curves_.halves_over(at.block) > worth_cells) {
        curves_.add(at.block, at.offset_mm, curve);
        const bool corners = corner_reach_.from_left[at.block] > at.offset_mm ||
                             corner_reach_.from_right[at.block + 1] > gap[at.block] - at.offset_mm;
        if (corners) corners_.add(at.block, at.offset_mm, corner);
        return;
    }
    touching(at, 0, [&](std::size_t j, double d) {
        if (j > at.block) d = std::min(d, least_ahead);
        add_bump<CurveKernel>(jump[j], 1 - corner_share[j], curve_width[j], d, curve);
        add_bump<CornerKernel>(jump[j], corner_share[j], corner_width[j], d, corner);
    });
}

Deviation Bumps::deviation(Place at) const {
    std::array<Coordinates, 1> curve{Coordinates::Zero()}, corner{Coordinates::Zero()};
    add(at, curve, corner);
    return {curve[0], corner[0]};
}

Coordinates Bumps::tangent(Place at) const {
    std::array<Coordinates, 2> c{Coordinates::Zero(), slope[at.block]};
    add(at, c, c);
    return c[1];
}

Jet Bumps::jet(Place at) const {
    Jet c{Coordinates::Zero(), slope[at.block], Coordinates::Zero(), Coordinates::Zero()};
    add(at, c, c);
    return c;
}

}  // namespace trunnion::smoothing
