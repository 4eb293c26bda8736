#pragma once

#include <cstddef>

#include "trunnion/base/result.hpp"
#include "trunnion/machine/machine.hpp"
#include "trunnion/program/program.hpp"
#include "trunnion/smoothing/smoothing.hpp"

namespace trunnion::pipeline {

/// What the smoothed path is given as.
enum class SmoothedForm {
    points,  ///< straight moves
    curves   ///< cubic B-splines, C², of tip and tool together (for sinumerik)
};

/// How the tolerances are shared out: the rest, a quarter, is left to the control that runs the program.
struct SmoothedShares {
    double rounding = 0.5;  ///< of smoothing::smooth
    double fitting = 0.25;  ///< of chords or splines against the smoothed path
};

struct SmoothedProgram {
    program::Program program;
    std::size_t smoothed_moves = 0;  ///< of the program, what they were replaced by below
    std::size_t written_moves = 0;
    std::size_t kept_moves = 0;
    double tip_deviation_mm = 0;  ///< from the program: the certified bound of the rounding and the fit's measured one
    double orientation_deviation_rad = 0;
};

/// A program for a real control: runs of cutting moves along which the tool turns are smoothed as plan() smooths them,
/// and given as few points or splines as keep the tolerances. Rapids, moves with TCP off, runs of one move, runs along
/// which the tool keeps its direction, and runs that would take more points than they have moves (lone corners, which a
/// control rounds better itself) stay as they are. Feeds hold where the blocks of the program had them,
/// events, exact stops and words of path control keep their places; lines are those of the program.
///
/// The rounding is certified as smoothing::smooth does it; the fit is measured at 8 places of every chord and 16 of
/// every span of a spline, at equal p. Tolerances and rounding as in `tolerances`; of feeds the program's own count.
/// Errors: those of path::choose_rotary_stands and path::PathBuilder. PIPE0016 a tolerance of 0 leaves nothing to
/// smooth; PIPE0017 a spline that does not settle.
Result<SmoothedProgram> smooth_program(const program::Program& program, const machine::Machine& machine,
                                       const machine::Setup& setup, const smoothing::SmoothingOptions& tolerances,
                                       SmoothedForm form, const SmoothedShares& shares = {});

}  // namespace trunnion::pipeline
