#pragma once

#include <memory>

#include "trunnion/base/result.hpp"
#include "trunnion/machine/machine.hpp"
#include "trunnion/program/program_parts.hpp"

namespace trunnion::pipeline {

/// The program with the passes of its surfaces in their places: every Program::surface_jobs gives way to moves of law
/// vector, laid by surfacing::plan_surface with the tool that the setup has under its name. A program without surfaces
/// comes back as it is, at no cost: give it away by std::move.
///
/// The tool goes by a straight rapid from where it stands to the retract level above the first pass, and ends at the
/// retract level above the last one. Moves have the tool, the offset and the line of their job, and its feed; 0, not
/// known, stays 0. Events keep their places: of those at the place of a job, the ones up to the event `G324 …` that the
/// reader leaves for it come before the passes, the rest behind; all before them where there is none. That event is
/// taken away. Following axes stand still on the passes.
///
/// A job that is freed of gouges: as make_surface_program() with freeing in the limits of lean_limits(), of gouges
/// deeper than twice the chord tolerance, against the job's surface and its others. Passes that were turned are
/// simulated.
///
/// Errors, placed at the job's line: PIPE0120 the setup has not its tool; those of geometry::BsplineSurface,
/// surfacing::Cutter, plan_surface and make_surface_program; PIPE0123 freed passes that go into the surfaces all the
/// same. Told in the program's diagnostics: PIPE0123 freed passes leave higher ridges than asked for, PIPE0124 how many
/// were turned. Cost: that of plan_surface, or of make_surface_program and check_surface_program; memory for the
/// passes.
Result<program::Program> expand_surfaces(program::Program program, const machine::Setup& setup);

/// The same for a program that is read meanwhile: the passes of a part belong to that part. Nothing is planned before
/// its part is asked for. `setup` must stay.
std::unique_ptr<program::ProgramParts> expand_surfaces(std::unique_ptr<program::ProgramParts> parts,
                                                       const machine::Setup& setup);

}  // namespace trunnion::pipeline
