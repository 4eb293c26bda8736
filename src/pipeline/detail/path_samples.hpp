#pragma once

#include "trunnion/pipeline/plan.hpp"

#include "detail/stretch_table.hpp"

namespace trunnion::pipeline {

/// Hands the path samples of a planned stretch to the observer: four a profile piece. `p_begin_mm`: where the stretch
/// begins on the program's path.
void hand_out_path_samples(const path::AxisPath& path, const motion::FeedProfile& profile, const StretchTable& table,
                           double p_begin_mm, double flank_height_mm, PlanObserver& observer);

}  // namespace trunnion::pipeline
