#include "detail/neighbour_difference.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <unordered_map>

namespace trunnion::report::detail {

namespace {

constexpr double other_pass = 3;  // times the reach, along the path
constexpr std::size_t most_looked_at = 400;

/// Steps of the path by the cells of a cubic grid that they touch, sampled so that none is missed by more than a cell.
class StepGrid {
  public:
    StepGrid(const std::vector<PathPlace>& places, double cell_mm) : places_(&places), cell_mm_(cell_mm) {
        for (std::size_t k = 1; k < places.size(); ++k)
            if (!places[k].rapid) add(static_cast<std::uint32_t>(k));
    }

    /// Steps in the cell of a place and its neighbours.
    template <class Visit>
    void near(const Eigen::Vector3d& point, Visit visit) const {
        const Eigen::Vector3i at = cell(point);
        for (int x = -1; x <= 1; ++x)
            for (int y = -1; y <= 1; ++y)
                for (int z = -1; z <= 1; ++z) {
                    const auto found = steps_.find(key(at + Eigen::Vector3i(x, y, z)));
                    if (found == steps_.end()) continue;
                    const auto& steps = found->second;
                    const std::size_t stride = 1 + steps.size() / most_looked_at;
                    for (std::size_t i = 0; i < steps.size(); i += stride) visit(steps[i]);
                }
    }

  private:
    Eigen::Vector3i cell(const Eigen::Vector3d& point) const {
        return (point / cell_mm_).array().floor().cast<int>().matrix();
    }
    static std::uint64_t key(const Eigen::Vector3i& cell) {
        constexpr std::uint64_t bits = 21, mask = (std::uint64_t{1} << bits) - 1;
        const auto part = [](int x) { return static_cast<std::uint64_t>(static_cast<std::int64_t>(x)) & mask; };
        return part(cell.x()) | part(cell.y()) << bits | part(cell.z()) << (2 * bits);
    }
    void add(std::uint32_t step) {
        const Eigen::Vector3d &from = (*places_)[step - 1].tip_mm, &to = (*places_)[step].tip_mm;
        const int parts = 1 + static_cast<int>((to - from).norm() / cell_mm_);
        std::uint64_t last = ~std::uint64_t{0};
        for (int i = 0; i <= parts; ++i) {
            const std::uint64_t here = key(cell(from + (to - from) * (static_cast<double>(i) / parts)));
            if (here != last) steps_[here].push_back(step);
            last = here;
        }
    }

    const std::vector<PathPlace>* places_;
    double cell_mm_;
    std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> steps_;
};

}  // namespace

std::vector<double> neighbour_reaches_mm(const std::vector<PathPlace>& places) {
    constexpr std::array shares{0.005, 0.02, 0.08};
    constexpr double most_mm = 20, least_mm = 0.01;
    Eigen::Vector3d low = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity()), high = -low;
    for (const PathPlace& place : places) {
        if (place.rapid) continue;
        low = low.cwiseMin(place.tip_mm);
        high = high.cwiseMax(place.tip_mm);
    }
    const double size = (high - low).norm(), used = std::isfinite(size) ? size : 0;
    std::vector<double> out;
    out.reserve(shares.size());
    for (const double share : shares) out.push_back(std::clamp(share * used, least_mm, most_mm));
    return out;
}

namespace {

/// For places that have no answer yet.
void look_within(double reach_mm, const std::vector<PathPlace>& places, std::vector<float>& out) {
    const StepGrid grid(places, reach_mm);
    for (std::size_t i = 0; i < places.size(); ++i) {
        const PathPlace& here = places[i];
        if (here.rapid || !std::isnan(out[i])) continue;
        double nearest = reach_mm, feed = std::numeric_limits<double>::quiet_NaN();
        grid.near(here.tip_mm, [&](std::uint32_t step) {
            const PathPlace &from = places[step - 1], &to = places[step];
            const Eigen::Vector3d way = to.tip_mm - from.tip_mm;
            const double square = way.squaredNorm();
            const double share = square > 0 ? std::clamp(way.dot(here.tip_mm - from.tip_mm) / square, 0.0, 1.0) : 0;
            const double along = std::lerp(from.path_length_mm, to.path_length_mm, share);
            if (std::abs(along - here.path_length_mm) < other_pass * reach_mm) return;
            const double distance = (here.tip_mm - from.tip_mm - share * way).norm();
            if (distance >= nearest) return;
            nearest = distance;
            feed = std::lerp(from.feed_mm_s, to.feed_mm_s, share);
        });
        if (std::isnan(feed)) continue;
        const double greater = std::max(here.feed_mm_s, feed);
        out[i] = static_cast<float>(greater > 0 ? std::abs(here.feed_mm_s - feed) / greater : 0);
    }
}

}  // namespace

std::vector<float> neighbour_differences(const std::vector<PathPlace>& places, const std::vector<double>& reaches_mm) {
    std::vector<float> out(places.size(), std::numeric_limits<float>::quiet_NaN());
    for (const double reach : reaches_mm) look_within(reach, places, out);
    return out;
}

}  // namespace trunnion::report::detail
