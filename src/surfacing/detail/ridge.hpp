#pragma once

#include <optional>
#include <vector>

#include "detail/way.hpp"

namespace trunnion::surfacing::detail {

/// A way with the poses of the tool that goes along it: in between cubic, through those at the way's places.
class Track {
  public:
    Track(const Job& job, const Way& way, bool backwards);

    const Way& way() const noexcept { return *way_; }
    /// Distance of the tool from a point, mm; 1e9 where the surface has no normal.
    double distance_mm(const Cutter& cutter, double s, const Eigen::Vector3d& point) const noexcept;
    std::optional<CutterPose> pose(double s) const noexcept;

  private:
    struct Node {
        CutterPose pose;
        Eigen::Vector3d tip_slope, axis_slope;
        bool sound = false;
    };
    void lead(std::size_t begin, std::size_t end);
    const Way* way_;
    std::vector<Node> nodes_;
};

/// Height of the ridge that the tool leaves between two ways beside each other, near the place `s` of the first one:
/// the highest place on the line to the nearest place of the second one. At most `limit_mm`. Nothing where an end of a
/// way is too near to tell. Cost about 30 µs.
std::optional<double> ridge_between_mm(const Job& job, const Track& first, double s, const Track& second,
                                       double limit_mm);

}  // namespace trunnion::surfacing::detail
