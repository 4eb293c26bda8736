#pragma once

#include "trunnion/controller/predict.hpp"

namespace trunnion::controller {

/// LinuxCNC's planner told as a prediction: rows are its servo periods, velocities their differences. What limits the
/// speed it does not say.
Result<motion::Prediction> predict_linuxcnc(const program::Program& program, const machine::Machine& machine,
                                            const machine::Setup& setup, const PredictOptions& options,
                                            const RowTaker& take_row);

}  // namespace trunnion::controller
