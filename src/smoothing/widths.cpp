#include "detail/widths.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <numbers>

#include "trunnion/smoothing/kernel.hpp"

#include "detail/scale.hpp"

namespace trunnion::smoothing {

namespace {

constexpr double cap_at_10um_mm = 6;
constexpr double chord_part = 1.0 / 40;  // of the tolerances: an arc or curve from its chords
constexpr double variation_aim = 0.8;
constexpr double corner_radius_part = 0.2;  // of the raw width: within it kinks count as one corner
constexpr double least_corner_radius_mm = 0.05;
constexpr double corner_use = 0.97;  // of what the curve's bumps leave
constexpr double least_left_for_corner = 0.1;
constexpr double grow_use = 0.95;
constexpr int grow_rounds = 2;
constexpr std::size_t samples_beside = 8;  // a corner grows by the largest use within four blocks
constexpr double curve_use_limit = 0.9, total_use_limit = 0.985;
constexpr double one_move_part = 0.1;  // of the reach: changes so near to each other are told as one
constexpr int repair_rounds = 6, careful_rounds = 3;

double cap_of(const Polyline& line, const Measure& measure) {
    double length = 0;
    for (const double gap : line.gap_mm) length += gap;
    return std::min(length, cap_at_10um_mm * std::max(1.0, std::sqrt(measure.tip_tolerance_mm() / 0.01)));
}

std::vector<double> caps_of(const Bumps& bumps, const Polyline& line) {
    std::vector<double> cap(bumps.size(), bumps.cap_mm());
    for (std::size_t k = bumps.first(); k <= bumps.last(); ++k)
        cap[k] = std::min(bumps.cap_mm(), line.widest_mm[k - bumps.first()]);
    return cap;
}

double smoothstep(double x) {
    x = std::clamp(x, 0.0, 1.0);
    return x * x * (3 - 2 * x);
}

double cluster_radius(const Curve& curve, std::size_t vertex) {
    return std::min(curve.cap[vertex], std::max(corner_radius_part * curve.raw_width[vertex], least_corner_radius_mm));
}

/// The corners' kinks near a vertex as one kink.
class CornerClusters {
  public:
    explicit CornerClusters(const Bumps& bumps) : bumps_(bumps) {
        for (std::size_t k = 0; k < bumps.size(); ++k)
            if (bumps.corner_share[k] > 0) corners_.push_back(k);
    }

    Coordinates at(std::size_t vertex, double radius_mm) const {
        Coordinates sum = Coordinates::Zero();
        const auto add = [&](std::size_t j, double distance_mm) {
            sum += bumps_.jump[j] * (bumps_.corner_share[j] * (1 - distance_mm / radius_mm));
        };
        const auto behind = std::lower_bound(corners_.begin(), corners_.end(), vertex);
        for (auto j = behind; j != corners_.end() && bumps_.distance(vertex, *j) < radius_mm; ++j)
            add(*j, bumps_.distance(vertex, *j));
        for (auto j = behind; j != corners_.begin() && bumps_.distance(*std::prev(j), vertex) < radius_mm; --j)
            add(*std::prev(j), bumps_.distance(*std::prev(j), vertex));
        return sum;
    }

  private:
    const Bumps& bumps_;
    std::vector<std::size_t> corners_;
};

/// Where blocks are longer than the cluster and uneven, some vertices of a curve pass for corners: a corner keeps its
/// share as far as corners make the kink of all that lies within the raw width.
void weigh_against_surroundings(Curve& curve) {
    Bumps& bumps = curve.bumps;
    const CornerClusters corners(bumps);
    std::vector<double> share = bumps.corner_share;
    for (std::size_t k = bumps.first(); k <= bumps.last(); ++k) {
        if (share[k] == 0) continue;
        const double radius = std::min(curve.cap[k], curve.raw_width[k]);
        const double all = curve.use(bumps.cluster(k, radius), k);
        share[k] *= smoothstep((curve.use(corners.at(k, radius), k) / std::max(all, 1e-300) - 0.45) / 0.25);
    }
    for (std::size_t k = 0; k < bumps.size(); ++k) bumps.corner_share[k] = share[bumps.source(k)];
}

/// Kinks near a vertex as one kink: rounding noise cancels in it, a corner made of two short blocks does not.
/// On a curve the clustered kink makes 0.44 of the deviation, whatever curvature and spacing; at a lone kink all of it.
void find_corner_shares(Curve& curve) {
    Bumps& bumps = curve.bumps;
    for (std::size_t k = bumps.first(); k <= bumps.last(); ++k) {
        const Coordinates kink = bumps.cluster(k, cluster_radius(curve, k));
        const double part = curve.use(kink, k) * DetectionKernel::peak * curve.raw_width[k] / variation_aim;
        bumps.corner_share[k] = smoothstep((part - 0.65) / 0.30);
    }
    for (std::size_t k = 0; k < bumps.size(); ++k) bumps.corner_share[k] = bumps.corner_share[bumps.source(k)];
    weigh_against_surroundings(curve);
}

void find_corner_widths(Curve& curve) {
    Bumps& bumps = curve.bumps;
    const CornerClusters corners(bumps);
    std::vector<double> width = bumps.corner_width;
    for (std::size_t k = bumps.first(); k <= bumps.last(); ++k) {
        width[k] = curve.cap[k];
        const double clustered = curve.use(corners.at(k, cluster_radius(curve, k)), k);
        const double kink =
            CornerKernel::peak * std::max(clustered, curve.use(bumps.jump[k] * bumps.corner_share[k], k));
        if (!(kink > 0)) continue;
        const double left = std::max(1 - curve.use(bumps.deviation({k, 0}).curve, k), least_left_for_corner);
        width[k] = std::min(width[k], corner_use * left / kink);
    }
    bumps.corner_width = width;
    bumps.limit_slope(bumps.corner_width, corner_width_slope);
    bumps.settle();
}

/// Use of the tolerances at vertices (even) and middles of blocks (odd), kept up to date as widths change.
class Samples {
  public:
    explicit Samples(const Curve& curve) : curve_(curve), uses_(2 * curve.line.blocks() + 1), stale_(uses_.size(), 1) {}

    const std::vector<Use>& update() {
        for (std::size_t s = 0; s < uses_.size(); ++s)
            if (stale_[s]) uses_[s] = at(s);
        std::fill(stale_.begin(), stale_.end(), char{0});
        return uses_;
    }

    std::vector<Excess> excess() {
        std::vector<Excess> places;
        update();
        for (std::size_t s = 0; s < uses_.size(); ++s)
            if (uses_[s].curve > curve_use_limit || uses_[s].total > total_use_limit)
                places.push_back({place(s), place(s).offset_mm, uses_[s]});
        return places;
    }

    void forget(const std::vector<Moved>& moved) {
        const Bumps& bumps = curve_.bumps;
        for (const Moved& m : moved) {
            bumps.around({m.vertex, 0}, m.reach_mm, m.reach_mm, [&](std::size_t j, double) { mark(j); });
            mark(m.vertex);
        }
    }

  private:
    void mark(std::size_t vertex) {
        if (vertex < curve_.bumps.first() || vertex > curve_.bumps.last()) return;
        const std::size_t s = 2 * (vertex - curve_.bumps.first());
        stale_[s] = 1;
        if (s > 0) stale_[s - 1] = 1;
        if (s + 1 < stale_.size()) stale_[s + 1] = 1;
    }

    Place place(std::size_t s) const {
        const std::size_t vertex = curve_.bumps.first() + s / 2;
        return {vertex, s % 2 == 1 ? 0.5 * curve_.bumps.gap[vertex] : 0.0};
    }

    Use at(std::size_t s) const {
        const Place where = place(s);
        const Deviation d = curve_.bumps.deviation(where);
        std::optional<Coordinates> tangent;
        const double curve = curve_.use_nearby(d.curve, where, tangent);
        return {curve, d.corner.isZero(0) ? curve : curve_.use_nearby(d.curve + d.corner, where, tangent)};
    }

    const Curve& curve_;
    std::vector<Use> uses_;
    std::vector<char> stale_;
};

/// Changes of neighbours are told as one.
std::vector<Moved> moves_since(const Bumps& bumps, const std::vector<double>& curve_before,
                               const std::vector<double>& corner_before) {
    std::vector<Moved> moved;
    for (std::size_t k = bumps.first(); k <= bumps.last(); ++k) {
        const bool curve = bumps.curve_width[k] != curve_before[k];
        const bool corner = bumps.corner_width[k] != corner_before[k] && bumps.corner_share[k] > 0;
        if (!curve && !corner) continue;
        const double reach = std::max(curve ? std::max(curve_before[k], bumps.curve_width[k]) : 0.0,
                                      corner ? std::max(corner_before[k], bumps.corner_width[k]) : 0.0);
        const double way = moved.empty() ? 0 : bumps.distance(moved.back().vertex, k);
        if (!moved.empty() && way < one_move_part * std::min(reach, moved.back().reach_mm))
            moved.back().reach_mm = std::max(moved.back().reach_mm, reach + way);
        else
            moved.push_back({k, reach});
    }
    return moved;
}

/// Widens corners where neighbours leave room.
void grow_corners(Curve& curve, Samples& samples) {
    Bumps& bumps = curve.bumps;
    for (int round = 0; round < grow_rounds; ++round) {
        const std::vector<Use>& uses = samples.update();
        const auto before = bumps.corner_width;
        for (std::size_t k = bumps.first(); k <= bumps.last(); ++k) {
            const std::size_t s = 2 * (k - bumps.first());
            double largest = 1e-6;
            const std::size_t from = s < samples_beside ? 0 : s - samples_beside;
            for (std::size_t i = from; i < std::min(s + samples_beside + 1, uses.size()); ++i)
                largest = std::max(largest, uses[i].total);
            bumps.corner_width[k] = std::min(curve.cap[k], before[k] * std::clamp(grow_use / largest, 1.0, 2.0));
        }
        bumps.limit_slope(bumps.corner_width, corner_width_slope);
        bumps.settle();
        samples.forget(moves_since(bumps, bumps.curve_width, before));
    }
}

void repair(Curve& curve, Samples& samples) {
    for (int round = 0; round < repair_rounds; ++round) {
        const std::vector<Excess> places = samples.excess();
        if (places.empty()) return;
        samples.forget(narrow(curve, places, round));
    }
}

}  // namespace

Curve::Curve(Polyline polyline, const Measure& how)
    : line(std::move(polyline)),
      measure(how),
      bumps(line, cap_of(line, how)),
      cap(caps_of(bumps, line)),
      raw_width(cap) {
    bumps.curve_width = cap;
    bumps.corner_width = cap;
}

std::vector<Moved> narrow(Curve& curve, const std::vector<Excess>& places, int round) {
    Bumps& bumps = curve.bumps;
    const auto curve_before = bumps.curve_width, corner_before = bumps.corner_width;
    const auto lower = [&](std::vector<double>& width, std::size_t vertex, double to) {
        double& own = width[bumps.source(vertex)];
        own = std::min(own, to);
    };
    for (const Excess& place : places) {
        const double excess = std::max(place.use.total, place.use.curve);
        const bool curve_too_wide = place.use.curve > curve_use_limit || place.use.curve > 0.5 * place.use.total;
        const bool careful = round < careful_rounds;
        const double curve_factor = careful ? std::min(1.0, std::sqrt(0.97 * curve_use_limit / excess)) : 0.5;
        const double corner_factor = careful ? std::min(1.0, corner_use / excess) : 0.5;
        const std::size_t vertex = place.at.block, next = place.at.offset_mm > 0 ? vertex + 1 : vertex;
        const double spread = place.extent_mm * (1 + 1e-9) + 0.5 * shortest_block_mm +
                              0.25 * round * std::max(curve_before[vertex], curve_before[next]);
        if (curve_too_wide)
            bumps.around(place.at, spread, spread,
                         [&](std::size_t j, double) { lower(bumps.curve_width, j, curve_factor * curve_before[j]); });
        if (place.use.total > total_use_limit)
            bumps.corners_touching(place.at, place.extent_mm, [&](std::size_t j, double d) {
                if (std::abs(d) - place.extent_mm < corner_before[j])
                    lower(bumps.corner_width, j, corner_factor * corner_before[j]);
            });
    }
    bumps.limit_slope(bumps.curve_width, curve_width_slope);
    bumps.limit_slope(bumps.corner_width, corner_width_slope);
    bumps.settle();
    return moves_since(bumps, curve_before, corner_before);
}

Polyline chords(const path::Run& run, VertexRange range, const Measure& measure) {
    constexpr double degree = std::numbers::pi / 180;
    return make_polyline(run, range,
                         {std::clamp(2 * measure.turn_tolerance_rad(), 0.2 * degree, 2 * degree),
                          std::clamp(measure.tip_tolerance_mm() * chord_part, 1e-5, 1e-3),
                          std::clamp(measure.turn_tolerance_rad() * chord_part, 1e-7, 1e-4)});
}

void find_widths(Curve& curve) {
    Bumps& bumps = curve.bumps;
    find_raw_widths(curve, variation_aim);
    find_corner_shares(curve);
    find_curve_widths(curve, variation_aim);
    bumps.limit_slope(bumps.curve_width, curve_width_slope);
    bumps.settle();
    find_corner_widths(curve);
    Samples samples(curve);
    grow_corners(curve, samples);
    repair(curve, samples);
}

}  // namespace trunnion::smoothing
