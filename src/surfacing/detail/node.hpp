#pragma once

#include <algorithm>
#include <optional>
#include <vector>

#include "trunnion/base/result.hpp"

#include "detail/way.hpp"

namespace trunnion::surfacing::detail {

constexpr double ridge_accuracy = 0.01;                  ///< share of the scallop
constexpr double least_change = 0.6, most_change = 1.5;  ///< of an interval at once
constexpr int most_attempts = 6;
/// Where a ridge is far too high after those, as before an edge that is much sharper than what came before it.
constexpr int utmost_attempts = 14;
constexpr int most_ways = 20000;
constexpr std::size_t most_work = 600'000;  ///< places at which ridges are measured, some 100 µs each

/// What is known at a place of a way.
struct Node {
    std::optional<Station> station;
    bool inside = false;    ///< of the face
    double interval = 0;    ///< to the next way, by curvatures
    double longest = 0;     ///< that the tool's end bears
    double correction = 1;  ///< of that interval, by ridges

    void correct(double factor) { correction = std::min(correction * factor, longest / interval); }
    bool at_reach() const { return interval * correction >= longest; }
};

/// At every place of a way; `correction` is what they begin with. Errors: SURF0203.
Result<std::vector<Node>> nodes_of(const Job& job, const Way& way, bool backwards, double correction);

/// path_interval_mm() with an axis and a direction across the feed in place of the station's.
double interval_mm(const Job& job, const Station& at, const Eigen::Vector3d& axis, const Eigen::Vector3d& across,
                   double ridge_mm);

/// What an interval wants so that the ridge becomes the wanted one, if it were as far off before and behind.
double interval_factor(const Job& job, const Station& at, double ridge_mm, double wanted_mm);

/// SURF0203 where the tool does not fit into the surface at a station.
Result<void> check_fit(const Job& job, const Station& station);

/// Whether a ridge is so far beyond what was asked for that the plan cannot stand.
bool is_unbearable(const Job& job, double highest_mm);

/// SURF0209 where a ridge is beyond what was asked for although intervals were corrected.
Result<void> check_ridge(const Job& job, double highest_mm, const Eigen::Vector3d& at_mm);

/// SURF0206: passes without end, as where a surface is rough or the scallop far too small for it.
std::unexpected<Diagnostic> too_much_work(std::size_t ways);

/// SURF0206.
std::unexpected<Diagnostic> too_many_ways();

}  // namespace trunnion::surfacing::detail
