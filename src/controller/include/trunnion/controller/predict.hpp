#pragma once

#include <functional>
#include <optional>

#include "trunnion/base/result.hpp"
#include "trunnion/machine/machine.hpp"
#include "trunnion/motion/controller.hpp"
#include "trunnion/motion/prediction.hpp"
#include "trunnion/program/program.hpp"

namespace trunnion::controller {

struct PredictOptions {
    double feed_override = 1;         ///< of the programmed feeds, > 0
    std::optional<double> feed_mm_s;  ///< replaces the programmed feeds
    double contact_lead_rad = 0;      ///< see contact_feed.hpp
    bool uncertainty = true;          ///< whether to vary what is not identified: some 30 predictions more
    double first_chord_mm = 0.004;    ///< resampling begins with it (1° counts as 1 mm) …
    double convergence = 5e-4;        ///< … and goes on with a quarter until the time changes by less than that
};

/// Takes the rows of the prediction as they come, in order.
using RowTaker = std::function<void(const motion::PredictedRow&)>;

/// What a control of any kind but `ideal` makes of a program: docs/theory/prediction.md. The time of LinuxCNC runs from
/// the first to the last motion, words before and behind them left out.
///
/// Rows stand where the law of the speed changes: ends of segments, begin and end of cruising; between two rows the
/// axes go straight. Pass an empty taker where they are not wanted. Length over feed knows no axes: its rows are the
/// ends of blocks, with standstill nowhere.
///
/// Guarantees, for kind `blocks`, the program's blocks staying the same: a lower limit, feed, tolerance, share or
/// velocity step is never faster, nor a shorter look-ahead, a longer cycle, preparation, filter or settling time; exact
/// stop at every block is slowest.
///
/// Errors: those of path::choose_rotary_stands and PathBuilder, for kind `linuxcnc` of run_as_linuxcnc; CTRL0201 a
/// block without a feed or time above 0; CTRL0203 an axis leaves its range by the control's own choice of branch;
/// CTRL0204 a lead angle of a quarter turn or more; CTRL0205 kind `ideal`, which is predicted elsewhere; CTRL0206 a
/// feed or override that is not above 0. Told: CTRL0202 blocks that do not move, CTRL0207 moves before the first whole
/// pose, which the reader has left out. Cost: 1-3 µs a segment, 30 times that with uncertainty. Memory: some 300 bytes
/// a block of the longest run.
Result<motion::Prediction> predict(const program::Program& program, const machine::Machine& machine,
                                   const machine::Setup& setup, const motion::Controller& controller,
                                   const PredictOptions& options, const RowTaker& take_row = {});

}  // namespace trunnion::controller
