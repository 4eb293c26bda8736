#pragma once

#include <optional>
#include <vector>

#include "trunnion/base/result.hpp"
#include "trunnion/machine/kinematics.hpp"
#include "trunnion/program/program.hpp"

namespace trunnion::path {

/// Where the rotary axes stand at the end of every move, in the control's count: one entry a move.
///
/// Law rotary, and moves with TCP off: the literal words; an axis without a word stays where it stands, at the
/// beginning at Setup::start, else at 0.
///
/// Law vector: of the ways that keep rotary and linear axes inside their ranges the one with the least rotary motion
/// (sum over the axes, rad, counted from where they stand before the program), over the whole program: branch and
/// winding are chosen at its beginning, on rapids, and where the tool stands along the axis nearest to the workpiece
/// (the pole), so that this axis is free: at a standstill there, and along moves that stay there. A rapid on which the
/// choice is another one than the turn of the tool axis in one plane leads to is marked `rebranched`; so is a move at
/// the pole along which the free axis turns. Between these places the axes go on without a jump. At the pole the free
/// axis stands where the next pose off the pole wants it, and stays where it is when none comes.
/// A feed move of law vector after literal words goes on from where these put the axes.
///
/// `pole_tolerance_rad` > 0: where cutting moves of law vector pass the pole within it, the axes may also go through
/// it, as on vectors shifted sideways (pole_passage.hpp); smoothing has to lead the path so. That is weighed by rotary
/// motion like everything else. At the poses meanwhile they stand as the programmed vectors want them, on the branch of
/// the side of the passage: where the branch changes from one pose to the next a run goes through the pole.
///
/// `standing`: the axes stand so at moves[0], as a part of the program before this one left them; without it they begin
/// where the least motion wants them.
///
/// The path between poses is otherwise the programmed one. Ranges are looked at every 2° of turn: AxisPath judges the
/// path that is moved.
///
/// Errors: PATH0001, PATH0002, PATH0003, PATH0006, PATH0010, PATH0011 as PathBuilder, those of Kinematics::make; PATH0005
/// opposite tool axes; PATH0101 orientation out of reach; PATH0102 no choice keeps the axes inside their ranges: which
/// one leaves first on the way that lasts longest, and after which retract and turn it would go on; PATH0103 the
/// programmed path passes the pole too closely to follow. Cost: 0.5-1 µs a move, linear; 60 bytes a move. Source:
/// dynamic programming over the stretches between retracts.
Result<std::vector<program::RotaryStand>> choose_rotary_stands(
    const program::Program& program, const machine::Machine& machine, const machine::Setup& setup,
    double pole_tolerance_rad = 0, const std::optional<machine::RotaryPosition>& standing = {});

}  // namespace trunnion::path
