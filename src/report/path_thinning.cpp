#include "detail/path_thinning.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace trunnion::report::detail {

namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();
constexpr double tip_tolerance_mm = 0.002, axis_tolerance = 0.0017, feed_share = 0.01, least_feed_mm_s = 0.02,
                 deviation_tolerance_mm = 0.0005, turn_tolerance_rad_s = 0.02;
// After so many doublings the ends of blocks, and those of rapids, no longer stay by themselves.
constexpr int doublings_with_blocks = 3, doublings_with_rapids = 10;
constexpr double axis_length_mm = 30, standstill_mm_s = 1e-3;

/// Rising from place to place, at a standstill too.
double way_between(const PathPlace& a, const PathPlace& b) {
    return (b.tip_mm - a.tip_mm).norm() + axis_length_mm * (b.axis - a.axis).norm() +
           standstill_mm_s * (b.time_s - a.time_s);
}

double known(double value) {
    return std::isfinite(value) ? value : 0;
}

std::array<double, 10> values_of(const PathPlace& p) {
    return {p.tip_mm.x(), p.tip_mm.y(), p.tip_mm.z(),        p.axis.x(),     p.axis.y(),
            p.axis.z(),   p.feed_mm_s,  p.contact_feed_mm_s, p.deviation_mm, p.turn_rad_s};
}

}  // namespace

void PathThinning::add(const PathPlace& place) {
    take(place);
    if (places_.size() >= most_) thin_again();
}

void PathThinning::finish() {
    if (pending_) keep(*std::exchange(pending_, std::nullopt));
}

void PathThinning::take(const PathPlace& place) {
    greatest_feed_mm_s_ = std::max(greatest_feed_mm_s_, known(place.feed_mm_s));
    if (places_.empty() && !pending_) {
        keep(place);
        return;
    }
    if (pending_ && must_stay_between(*pending_, place)) keep(*pending_);
    way_ += way_between(pending_ ? *pending_ : places_.back(), place);
    if (pending_ && !may_reach(place)) {
        const double step = way_between(*pending_, place);
        keep(*pending_);
        way_ = step;
    }
    narrow_by(place);
    pending_ = place;
}

void PathThinning::keep(const PathPlace& place) {
    places_.push_back(place);
    slopes_.least.fill(-infinite);
    slopes_.greatest.fill(infinite);
    way_ = 0;
    pending_.reset();
}

PathThinning::Values PathThinning::tolerances() const {
    const double wider = std::ldexp(1.0, doublings_);
    const double tip = tip_tolerance_mm * wider, axis = axis_tolerance * wider,
                 feed = std::max(least_feed_mm_s, feed_share * greatest_feed_mm_s_) * wider;
    return {tip, tip, tip, axis, axis, axis, feed, feed, deviation_tolerance_mm * wider, turn_tolerance_rad_s * wider};
}

bool PathThinning::may_reach(const PathPlace& place) const {
    if (!(way_ > 0)) return true;
    const Values from = values_of(places_.back()), to = values_of(place);
    for (int k = 0; k < quantities; ++k) {
        const double slope = (known(to[k]) - known(from[k])) / way_;
        if (slope < slopes_.least[k] || slope > slopes_.greatest[k]) return false;
    }
    return true;
}

void PathThinning::narrow_by(const PathPlace& place) {
    if (!(way_ > 0)) return;
    const Values from = values_of(places_.back()), at = values_of(place), room = tolerances();
    for (int k = 0; k < quantities; ++k) {
        const double change = known(at[k]) - known(from[k]);
        slopes_.least[k] = std::max(slopes_.least[k], (change - room[k]) / way_);
        slopes_.greatest[k] = std::min(slopes_.greatest[k], (change + room[k]) / way_);
    }
}

bool PathThinning::must_stay_between(const PathPlace& before, const PathPlace& after) const {
    if (before.rapid != after.rapid && doublings_ < doublings_with_rapids) return true;
    return doublings_ < doublings_with_blocks && (before.line != after.line || before.cause != after.cause);
}

void PathThinning::thin_again() {
    while (places_.size() >= most_) {
        ++doublings_;
        const std::vector<PathPlace> kept = std::exchange(places_, {});
        const auto last = std::exchange(pending_, std::nullopt);
        for (const PathPlace& place : kept) take(place);
        if (last) take(*last);
    }
}

std::vector<std::int32_t> coarse_places(const std::vector<PathPlace>& places, std::size_t most) {
    PathThinning thinning(most);
    for (const PathPlace& place : places) thinning.add(place);
    thinning.finish();
    std::vector<std::int32_t> out;
    out.reserve(thinning.places().size());
    std::size_t at = 0;
    for (const PathPlace& kept : thinning.places()) {
        while (places[at].time_s < kept.time_s) ++at;
        out.push_back(static_cast<std::int32_t>(at));
    }
    return out;
}

}  // namespace trunnion::report::detail
