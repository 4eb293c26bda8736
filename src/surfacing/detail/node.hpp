#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "trunnion/base/result.hpp"

#include "detail/way.hpp"

namespace trunnion::surfacing::detail {

constexpr double ridge_accuracy = 0.01;                  ///< share of the scallop
constexpr double least_change = 0.6, most_change = 1.5;  ///< of an interval at once
constexpr int most_attempts = 6;
/// Where a ridge is too high after those, as before an edge that is much sharper than what came before it.
constexpr int utmost_attempts = 14;
constexpr int most_ways = 20000;
constexpr std::size_t most_work = 600'000;  ///< places at which ridges are measured, some 100 µs each

/// What is known at a place of a way.
struct Node {
    std::optional<Station> station;
    bool inside = false;    ///< of the faces
    double interval = 0;    ///< to the next way, by curvatures
    double longest = 0;     ///< that the tool's end bears
    double correction = 1;  ///< of that interval, by ridges

    void correct(double factor) { correction = std::min(correction * factor, longest / interval); }
    bool at_reach() const { return interval * correction >= longest; }
};

/// Steps of a strategy with one number for all of a pass: the widest known whose highest ridge is as wanted or lower,
/// and the narrowest whose ridge is higher. Between them the step is looked for, so that the search ends.
struct StepBracket {
    double low = 0, low_ridge = 0, high = std::numeric_limits<double>::infinity(), high_ridge = 0;

    void narrow(double step, double ridge, double wanted) {
        if (ridge <= wanted)
            low = step, low_ridge = ridge;
        else
            high = step, high_ridge = ridge;
    }
    bool is_closed() const { return low > 0 && low < high && std::isfinite(high); }
    /// Ridges of leaning tools in narrow hollows rise faster than intervals tell: steps by these would go to and fro.
    double step_of(double ridge) const { return low + (high - low) * (ridge - low_ridge) / (high_ridge - low_ridge); }
};

/// At every place of a way, of the two of a joint at the later one alone; `correction` is what they begin with. Errors:
/// SURF0203.
Result<std::vector<Node>> nodes_of(const Job& job, const Way& way, bool backwards, double correction);

/// path_interval_mm() with an axis and a direction across the feed in place of the station's.
double interval_mm(const Job& job, const Station& at, const Eigen::Vector3d& axis, const Eigen::Vector3d& across,
                   double ridge_mm);

/// What an interval wants so that the ridge becomes the wanted one, if it were as far off before and behind.
double interval_factor(const Job& job, const Station& at, double ridge_mm, double wanted_mm);

/// SURF0203 where the tool does not fit into the surface at a station.
Result<void> check_fit(const Job& job, const Station& station);

/// Whether a ridge is beyond what was asked for, so that the plan cannot stand; one that is levelled place by place is
/// held to the accuracy of that.
bool is_unbearable(const Job& job, double highest_mm);

/// SURF0209 where a ridge is beyond what was asked for although intervals were corrected.
Result<void> check_ridge(const Job& job, double highest_mm, const Eigen::Vector3d& at_mm);

/// SURF0206: passes without end, as where a surface is rough or the scallop far too small for it. Of `places` where
/// ridges were measured over a share of what there is to cover: where they are too many, or on the way to it: twice too
/// many by a quarter of the work, ten times by a twentieth, not judged before that.
Result<void> check_work(std::size_t places, double covered_share, std::size_t ways);

/// SURF0206.
std::unexpected<Diagnostic> too_many_ways();

}  // namespace trunnion::surfacing::detail
