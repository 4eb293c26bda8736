#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "trunnion/path/run.hpp"

#include "../unit/smoothing/runs.hpp"

namespace trunnion::test {

/// What a part of a random run is made of.
enum class Part {
    dense,    ///< blocks of some 0.1 mm along a curve
    digits,   ///< the same, given with 1e-3 mm and 1e-3°
    corners,  ///< lone blocks of 1 … 20 mm
    noise,    ///< blocks of 0.2 … 2 mm, every pose up to 20 µm and 0.05° off
    arcs      ///< with a little helix, between short straight blocks
};

std::string name_of(Part part);

struct Laws {
    path::OrientationLaw law = path::OrientationLaw::vector;
    path::Space space = path::Space::workpiece;
};

std::string name_of(const Laws& laws);

/// A walk of tip and tool through parts, on the table of tests/unit/smoothing.
class RandomRun {
  public:
    RandomRun(std::uint64_t seed, Laws laws);
    RandomRun& add(Part part, double length_mm);
    path::Run run() const;

  private:
    void place(bool digits = false, double off_mm = 0);
    void step(double length_mm, double turn_per_mm);
    void dense(double length_mm, bool digits);
    void corners(double length_mm);
    void noise(double length_mm);
    void arcs(double length_mm);
    Eigen::Vector3d any_direction();

    smoothing::test::Random random_;
    Laws laws_;
    std::vector<smoothing::test::Pose> poses_;
    struct PlacedArc {
        std::size_t block;
        program::Arc arc;
    };
    std::vector<PlacedArc> arcs_;
    Eigen::Vector3d tip_mm_ = Eigen::Vector3d::Zero(), way_ = Eigen::Vector3d::UnitX();
    std::array<double, 2> words_{0.4, 0.3}, turning_{};
};

}  // namespace trunnion::test
