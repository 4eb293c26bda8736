#pragma once

#include "trunnion/controller/predict.hpp"

namespace trunnion::controller {

/// What CAM systems print: of every cutting block the tip's way over the feed (or the time or angle over the rate that
/// it asks for), of every rapid the way of the slowest axis over its rapid velocity, dwells as programmed; nothing for
/// acceleration, corners, tool changes. A pure rotation under a feed in mm/min takes no time. Exact sums.
Result<motion::Prediction> length_over_feed(const program::Program& program, const machine::Machine& machine,
                                            const machine::Setup& setup, const PredictOptions& options,
                                            const RowTaker& take_row);

}  // namespace trunnion::controller
