#pragma once

#include "trunnion/controller/predict.hpp"

namespace trunnion::controller {

/// LinuxCNC's planner told as a prediction: rows are its servo periods; velocities, accelerations and jerks of the
/// joints their differences.
Result<motion::Prediction> predict_linuxcnc(const program::Program& program, const machine::Machine& machine,
                                            const machine::Setup& setup, const motion::Controller& controller,
                                            const PredictOptions& options, const RowTaker& take_row);

}  // namespace trunnion::controller
