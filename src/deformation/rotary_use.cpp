#include "trunnion/deformation/rotary_use.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "detail/followed_path.hpp"

namespace trunnion::deformation {

using detail::FollowedPath;
using path::AxisSample;
using path::PathPlace;

namespace {

constexpr int parts_of_station = 8;  // even: Simpson's rule
constexpr int refinements = 30;

/// Adds up what rotary_use() tells.
class UseSum {
  public:
    UseSum(const FollowedPath& followed, const DualPath& path, const Machining& machining)
        : followed_(followed), path_(path), machining_(machining), machine_(machining.machine) {}

    RotaryUse sum() {
        const auto& stations = followed_.axes().stations();
        for (std::size_t i = 0; i + 1 < stations.size(); ++i)
            if (stations[i].piece == stations[i + 1].piece) add(stations[i], stations[i + 1].offset_mm);
        for (std::size_t r = 0; r < rotary(); ++r)
            use_.velocity_ratio = std::max(use_.velocity_ratio, use_.velocity[r] / limit(linear() + r));
        use_.begin_rad = rotary_of(followed_.axes().begin_position());
        use_.end_rad = rotary_of(followed_.axes().end_position());
        return use_;
    }

  private:
    std::size_t linear() const { return static_cast<std::size_t>(machine_.linear_count()); }
    std::size_t rotary() const { return static_cast<std::size_t>(machine_.rotary_count); }
    double limit(std::size_t axis) const { return machine_.axes[axis].feed.velocity; }

    machine::RotaryPosition rotary_of(const machine::AxisPosition& position) const {
        machine::RotaryPosition out{};
        for (std::size_t r = 0; r < rotary(); ++r) out[r] = position[linear() + r];
        return out;
    }

    double seconds_at(PathPlace place) const { return detail::seconds_per_u(path_, followed_.u_of(place), machining_); }

    double velocity(PathPlace place, std::size_t which) const {
        AxisSample sample;
        followed_.axes().evaluate(place, sample);
        return std::abs(sample.axes[linear() + which].d1()) / seconds_at(place);
    }

    void add(PathPlace from, double to_mm) {
        const double step = (to_mm - from.offset_mm) / parts_of_station;
        machine::RotaryPosition before{};
        AxisSample sample;
        for (int k = 0; k <= parts_of_station; ++k) {
            const PathPlace place{from.piece, from.offset_mm + k * step};
            followed_.axes().evaluate(place, sample);
            add_time(place, sample, step / 3 * (k == 0 || k == parts_of_station ? 1 : 2 + 2 * (k % 2)));
            for (std::size_t r = 0; r < rotary(); ++r) {
                const double at = sample.axes[linear() + r].value();
                if (k > 0) use_.travel_rad += std::abs(at - before[r]);
                before[r] = at;
            }
        }
        for (std::size_t r = 0; r < rotary(); ++r) add_peak(from, step, r);
    }

    void add_time(PathPlace place, const AxisSample& sample, double weight) {
        const double at_feed = seconds_at(place);
        double needed = at_feed;
        for (std::size_t a = 0; a < linear() + rotary(); ++a)
            needed = std::max(needed, std::abs(sample.axes[a].d1()) / limit(a));
        use_.time_at_feed_s += weight * at_feed;
        use_.velocity_limited_time_s += weight * needed;
    }

    /// The largest of the places looked at, then golden section between its neighbours.
    void add_peak(PathPlace from, double step, std::size_t which) {
        const auto at = [&](double offset) { return velocity({from.piece, offset}, which); };
        int best = 0;
        double peak = 0;
        for (int k = 0; k <= parts_of_station; ++k)
            if (const double here = at(from.offset_mm + k * step); here > peak) peak = here, best = k;
        if (peak > use_.velocity[which] * 0.9) {
            constexpr double golden = 0.3819660112501051;
            double a = from.offset_mm + std::max(best - 1, 0) * step;
            double b = from.offset_mm + std::min(best + 1, parts_of_station) * step;
            for (int i = 0; i < refinements; ++i) {
                const double left = a + golden * (b - a), right = b - golden * (b - a);
                const double at_left = at(left), at_right = at(right);
                peak = std::max({peak, at_left, at_right});
                (at_left < at_right ? a : b) = at_left < at_right ? left : right;
            }
        }
        use_.velocity[which] = std::max(use_.velocity[which], peak);
    }

    const FollowedPath& followed_;
    const DualPath& path_;
    const Machining& machining_;
    const machine::Machine& machine_;
    RotaryUse use_;
};

}  // namespace

RotaryUse detail::use_of(const FollowedPath& followed, const DualPath& path, const Machining& machining) {
    return UseSum(followed, path, machining).sum();
}

Result<RotaryUse> rotary_use(const DualPath& path, const Machining& machining) {
    if (auto ok = detail::check_cubic(path); !ok) return fail(ok.error());
    if (auto ok = detail::check_machining(machining); !ok) return fail(ok.error());
    constexpr double less_rad = 1e-9;
    std::optional<RotaryUse> best;
    std::optional<Diagnostic> refusal;
    for (const auto& begin : detail::beginnings(path, machining)) {
        const auto followed = FollowedPath::make(path, machining, begin, path.end());
        if (!followed) {
            if (!refusal) refusal = followed.error();
            continue;
        }
        const RotaryUse use = detail::use_of(*followed, path, machining);
        if (!best || use.travel_rad < best->travel_rad - less_rad) best = use;
    }
    if (!best) return fail(std::move(*refusal));
    return *best;
}

}  // namespace trunnion::deformation
