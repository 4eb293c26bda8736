#include "detail/widths.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "trunnion/smoothing/kernel.hpp"

#include "detail/scale.hpp"

namespace trunnion::smoothing {

namespace {

constexpr double cap_at_10um_mm = 6;
constexpr std::size_t most_neighbours = 256;
constexpr double variation_aim = 0.8;
constexpr double corner_radius_part = 0.2;  // of the raw width: within it kinks count as one corner
constexpr double least_corner_radius_mm = 0.05;
constexpr double corner_use = 0.97;  // of what the curve's bumps leave
constexpr double least_left_for_corner = 0.1;
constexpr double grow_use = 0.95;
constexpr int grow_rounds = 2;
constexpr double curve_use_limit = 0.9, total_use_limit = 0.985;
constexpr double as_near_mm = 0.004;  // places whose distances differ by less are equally near
constexpr double worth_a_look = 0.2;  // below, no nearest place breaks a tolerance
constexpr std::size_t most_blocks_beside = 12;
constexpr int looks_aside = 10;  // before and behind a place, as far as the path may slip
constexpr int repair_rounds = 6, careful_rounds = 3;

double cap_of(const Polyline& line, const Measure& measure) {
    double length = 0;
    for (const double gap : line.gap_mm) length += gap;
    return std::min(length, cap_at_10um_mm * std::max(1.0, std::sqrt(measure.tip_tolerance_mm() / 0.01)));
}

/// `cap_mm`, or the distance to the farthest neighbour that may take part.
double cap_at(const Bumps& bumps, std::size_t vertex, double cap_mm) {
    const std::size_t right = std::min(most_neighbours, bumps.gap.size() - vertex),
                      left = std::min(most_neighbours, vertex);
    double distance = 0;
    for (std::size_t k = 0; k < right && distance < cap_mm; ++k) distance += bumps.gap[vertex + k];
    if (right == most_neighbours) cap_mm = std::min(cap_mm, distance);
    distance = 0;
    for (std::size_t k = 1; k <= left && distance < cap_mm; ++k) distance += bumps.gap[vertex - k];
    return left == most_neighbours ? std::min(cap_mm, distance) : cap_mm;
}

std::vector<double> caps_of(const Bumps& bumps, const Polyline& line) {
    std::vector<double> cap(bumps.size(), bumps.cap_mm());
    for (std::size_t k = bumps.first(); k <= bumps.last(); ++k)
        cap[k] = std::min(cap_at(bumps, k, bumps.cap_mm()), line.widest_mm[k - bumps.first()]);
    return cap;
}

/// A place of the programmed path beside a deviated point: its distance, and the use of the tolerances from there.
struct NearPlace {
    double distance_mm = 0, use = 0;
    bool beside = false;  // the foot lies inside the block
};

double smoothstep(double x) {
    x = std::clamp(x, 0.0, 1.0);
    return x * x * (3 - 2 * x);
}

double cluster_radius(const Curve& curve, std::size_t vertex) {
    return std::min(curve.cap[vertex], std::max(corner_radius_part * curve.raw_width[vertex], least_corner_radius_mm));
}

/// Kinks near a vertex as one kink: rounding noise cancels in it, a corner made of two short blocks does not.
template <class Share>
Coordinates cluster(const Curve& curve, std::size_t vertex, Share&& share) {
    const double radius = cluster_radius(curve, vertex);
    Coordinates sum = Coordinates::Zero();
    curve.bumps.around({vertex, 0}, radius, radius, [&](std::size_t j, double d) {
        sum += curve.bumps.jump[j] * (share(j) * (1 - std::abs(d) / radius));
    });
    return sum;
}

/// On a curve the clustered kink makes 0.44 of the deviation, whatever curvature and spacing; at a lone kink all of it.
void find_corner_shares(Curve& curve) {
    Bumps& bumps = curve.bumps;
    for (std::size_t k = bumps.first(); k <= bumps.last(); ++k) {
        const Coordinates kink = cluster(curve, k, [](std::size_t) { return 1.0; });
        const double part = curve.use(kink, k) * DetectionKernel::peak * curve.raw_width[k] / variation_aim;
        bumps.corner_share[k] = smoothstep((part - 0.65) / 0.30);
    }
    bumps.mirror();
}

void find_corner_widths(Curve& curve) {
    Bumps& bumps = curve.bumps;
    const auto share = [&](std::size_t j) { return bumps.corner_share[j]; };
    std::vector<double> width = bumps.corner_width;
    for (std::size_t k = bumps.first(); k <= bumps.last(); ++k) {
        width[k] = curve.cap[k];
        const double clustered = curve.use(cluster(curve, k, share), k);
        const double kink = CornerKernel::peak * std::max(clustered, curve.use(bumps.jump[k] * share(k), k));
        if (!(kink > 0)) continue;
        const double left = std::max(1 - curve.use(bumps.deviation({k, 0}).curve, k), least_left_for_corner);
        width[k] = std::min(width[k], corner_use * left / kink);
    }
    bumps.corner_width = width;
    bumps.limit_slope(bumps.corner_width, corner_width_slope);
    bumps.mirror();
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
        return {curve_.use_nearby(d.curve, where), curve_.use_nearby(d.curve + d.corner, where)};
    }

    const Curve& curve_;
    std::vector<Use> uses_;
    std::vector<char> stale_;
};

std::vector<Moved> moves_since(const Bumps& bumps, const std::vector<double>& curve_before,
                               const std::vector<double>& corner_before) {
    std::vector<Moved> moved;
    for (std::size_t k = bumps.first(); k <= bumps.last(); ++k) {
        const bool curve = bumps.curve_width[k] != curve_before[k];
        const bool corner = bumps.corner_width[k] != corner_before[k] && bumps.corner_share[k] > 0;
        if (!curve && !corner) continue;
        const double reach = std::max(curve ? std::max(curve_before[k], bumps.curve_width[k]) : 0.0,
                                      corner ? std::max(corner_before[k], bumps.corner_width[k]) : 0.0);
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
            for (std::size_t i = s < 4 ? 0 : s - 4; i < std::min(s + 5, uses.size()); ++i)
                largest = std::max(largest, uses[i].total);
            bumps.corner_width[k] = std::min(curve.cap[k], before[k] * std::clamp(grow_use / largest, 1.0, 2.0));
        }
        bumps.limit_slope(bumps.corner_width, corner_width_slope);
        bumps.mirror();
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
    bumps.mirror();
}

double Curve::use_nearby(const Coordinates& deviation, Place at) const {
    const std::size_t here = std::min(at.block - bumps.first(), line.blocks() - 1);
    const double weight = std::max(lever(at.block), lever(bumps.first() + here));
    double use = measure.use(deviation, weight);
    if (measure.has_arm() || use < worth_a_look) return use;
    const double reach = std::sqrt(measure.product(deviation, deviation, weight)) + as_near_mm;
    const double offset = at.block - bumps.first() == here ? at.offset_mm : line.gap_mm[here];
    const Coordinates point = line.slope[here] * offset + deviation;
    const Coordinates ahead = bumps.jet(at)[1];
    const double slip = measure.product(deviation, ahead, weight) / measure.product(ahead, ahead, weight);
    use = std::max(use, measure.use(deviation - slip * ahead, weight));  // the curve's nearest place, seen from P
    for (int k = -looks_aside; k <= looks_aside; ++k)
        use =
            std::max(use, use_from_nearest(point + k * reach / looks_aside * ahead, {here, offset}, 2 * reach, weight));
    return use;
}

/// `point` counts from vertex `at.block` of the polyline.
double Curve::use_from_nearest(const Coordinates& point, Place at, double reach_mm, double weight) const {
    const std::size_t here = at.block;
    std::array<NearPlace, 2 * most_blocks_beside + 1> places;
    std::size_t count = 0;
    const auto look = [&](std::size_t block) {
        const Coordinates from = point + (line.vertex[here] - line.vertex[block]);
        const Coordinates& along = line.slope[block];
        const double foot = measure.product(from, along, weight) / measure.product(along, along, weight);
        const double kept = std::clamp(foot, 0.0, line.gap_mm[block]);
        const Coordinates rest = from - kept * along;
        places[count++] = {std::sqrt(measure.product(rest, rest, weight)), measure.use(rest, weight), kept == foot};
    };
    look(here);
    double way = at.offset_mm;
    for (std::size_t k = 1; k <= most_blocks_beside && k <= here && way < reach_mm; ++k) {
        look(here - k);
        way += line.gap_mm[here - k];
    }
    way = line.gap_mm[here] - at.offset_mm;
    for (std::size_t k = 1; k <= most_blocks_beside && here + k < line.blocks() && way < reach_mm; ++k) {
        look(here + k);
        way += line.gap_mm[here + k];
    }
    const auto nearest =
        std::min_element(places.begin(), places.begin() + static_cast<std::ptrdiff_t>(count),
                         [](const NearPlace& a, const NearPlace& b) { return a.distance_mm < b.distance_mm; });
    double use = nearest->use;
    for (std::size_t k = 0; k < count; ++k)
        if (places[k].beside && places[k].distance_mm <= nearest->distance_mm + as_near_mm)
            use = std::max(use, places[k].use);
    return use;
}

std::vector<Moved> narrow(Curve& curve, const std::vector<Excess>& places, int round) {
    Bumps& bumps = curve.bumps;
    const auto curve_before = bumps.curve_width, corner_before = bumps.corner_width;
    for (const Excess& place : places) {
        const double excess = std::max(place.use.total, place.use.curve);
        const bool curve_too_wide = place.use.curve > curve_use_limit || place.use.curve > 0.5 * place.use.total;
        const bool careful = round < careful_rounds;
        const double curve_factor = careful ? std::min(1.0, std::sqrt(0.97 * curve_use_limit / excess)) : 0.5;
        const double corner_factor = careful ? std::min(1.0, corner_use / excess) : 0.5;
        const double spread = place.extent_mm * (1 + 1e-9) + 0.25 * round * curve_before[place.at.block];
        bumps.touching(place.at, place.extent_mm, [&](std::size_t j, double d) {
            const std::size_t k = bumps.source(j);
            const double distance = std::abs(d);
            if (curve_too_wide && distance <= spread)
                bumps.curve_width[k] = std::min(bumps.curve_width[k], curve_factor * curve_before[k]);
            if (place.use.total > total_use_limit && distance - place.extent_mm < corner_before[k])
                bumps.corner_width[k] = std::min(bumps.corner_width[k], corner_factor * corner_before[k]);
        });
    }
    bumps.limit_slope(bumps.curve_width, curve_width_slope);
    bumps.limit_slope(bumps.corner_width, corner_width_slope);
    bumps.mirror();
    return moves_since(bumps, curve_before, corner_before);
}

void find_widths(Curve& curve) {
    Bumps& bumps = curve.bumps;
    find_raw_widths(curve, variation_aim);
    find_corner_shares(curve);
    find_curve_widths(curve, variation_aim);
    bumps.limit_slope(bumps.curve_width, curve_width_slope);
    bumps.mirror();
    find_corner_widths(curve);
    Samples samples(curve);
    grow_corners(curve, samples);
    repair(curve, samples);
}

}  // namespace trunnion::smoothing
