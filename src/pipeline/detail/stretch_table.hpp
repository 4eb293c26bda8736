#pragma once

#include <vector>

#include <Eigen/Core>

#include "trunnion/motion/feed_profile.hpp"
#include "trunnion/path/axis_path.hpp"

namespace trunnion::pipeline {

/// The tip's way and the path parameter at the start of every profile piece of a stretch, the end of the last one
/// added: what reporting needs beside the profile. The way is measured in chords over profile pieces.
struct StretchTable {
    std::vector<double> p_mm, s_mm;
    std::vector<Eigen::Vector3d> tip_mm;

    static StretchTable of(const path::AxisPath& path, const motion::FeedProfile& profile, double s_begin_mm);
    /// The next piece of a profile that grows, as of() would have it; `s_begin_mm` counts for the first one.
    void add(const path::AxisPath& path, const motion::ProfilePiece& piece, double s_begin_mm);
    /// Time from the stretch's start at which the motion passes p.
    double time_at(const motion::FeedProfile& profile, double at_mm) const;
    /// The tip's way at p.
    double way_at(double at_mm) const;
    std::size_t piece_at(double at_mm) const;

  private:
    void add_place(const path::AxisPath& path, path::PathPlace place, double s_begin_mm);
};

}  // namespace trunnion::pipeline
