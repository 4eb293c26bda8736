#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

namespace trunnion::report::detail {

/// One place of the drawn tool path. NaN: not known.
struct PathPlace {
    double time_s = 0, path_length_mm = 0;
    Eigen::Vector3d tip_mm = Eigen::Vector3d::Zero(), axis = Eigen::Vector3d::UnitZ();
    double feed_mm_s = 0, programmed_feed_mm_s = 0, contact_feed_mm_s = 0;
    double deviation_mm = 0, turn_rad_s = 0;
    std::int32_t line = 0;
    std::uint8_t cause = 0;
    bool rapid = false;
};

/// Leaves out the places that straight steps between the others tell of: tip within 2 µm, tool axis within 0.1°, feeds
/// within a hundredth of the greatest, deviation within 0.5 µm. Begin and end of every block stay. Where more than
/// `most` places would stay all of these become twice as wide, as often as it takes.
/// One pass: of each quantity the slopes that lead past every place left out so far within the tolerance, a step may
/// go on to the next place while its own slope is one of them (swing filter). Cost about 0.2 µs a place.
class PathThinning {
  public:
    static constexpr std::size_t most_places = 100'000;
    explicit PathThinning(std::size_t most = most_places) : most_(most) {}

    void add(const PathPlace& place);
    void finish();
    const std::vector<PathPlace>& places() const { return places_; }

  private:
    static constexpr int quantities = 10;
    using Values = std::array<double, quantities>;
    struct Slopes {
        Values least, greatest;
    };

    void take(const PathPlace& place);
    void keep(const PathPlace& place);
    bool may_reach(const PathPlace& place) const;
    void narrow_by(const PathPlace& place);
    bool must_stay_between(const PathPlace& before, const PathPlace& after) const;
    Values tolerances() const;
    void thin_again();

    std::size_t most_;
    int doublings_ = 0;
    double greatest_feed_mm_s_ = 0;
    std::vector<PathPlace> places_;
    std::optional<PathPlace> pending_;  // the last place; not kept yet
    Slopes slopes_{};
    double way_ = 0;  // from the last kept place to pending_
};

/// Which places, by index, are enough for a picture that moves: at most some `most` of them, the first and the last
/// among them; the rest lies within the tolerances above, doubled as often as it takes. Cost O(n).
std::vector<std::int32_t> coarse_places(const std::vector<PathPlace>& places, std::size_t most);

}  // namespace trunnion::report::detail
