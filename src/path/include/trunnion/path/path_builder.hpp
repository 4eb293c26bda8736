#pragma once

#include <deque>
#include <map>

#include "trunnion/base/result.hpp"
#include "trunnion/machine/machine.hpp"
#include "trunnion/path/run.hpp"
#include "trunnion/program/program.hpp"

namespace trunnion::path {

/// Turns the moves of a program into runs, one after another, in the frame of the setup's workpiece: work offsets
/// applied, tools resolved to their length, blocks shorter than 1e-7 mm of p dropped, cut where motion stands still
/// (rapids, stopping events, exact stops, changes of space or tool). Holds the kinematics that the runs point to and
/// must outlive them; keeps references to program, machine and setup.
///
/// A named tool is looked up in Setup::tools; a setup without that table gives its one [tool] to the first name that
/// the program calls. G54 without an entry is the workpiece itself.
/// Rotary axes that the program never names stand at Setup::start, else at 0.
///
/// Errors: PATH0001 no motion, PATH0002 tool not in the setup, PATH0003 work offset not in the setup, PATH0004 the
/// program changes between vectors and rotary words, PATH0005 opposite tool axes in consecutive poses, PATH0006 rotary
/// words on a machine without such an axis; and those of Kinematics::make.
class PathBuilder {
  public:
    static Result<PathBuilder> make(const program::Program& program, const machine::Machine& machine,
                                    const machine::Setup& setup);

    /// The next run with at least one block; false when the program is at its end.
    Result<bool> next(Run& run);

    /// Notes and warnings met so far.
    const std::vector<Diagnostic>& diagnostics() const { return diagnostics_; }

    /// Where the axes are before the first motion as far as anybody can know: rotary axes at Setup::start, else 0.
    /// Where a program of tool vectors begins with the tool along the axis nearest to the workpiece, that axis already
    /// stands where the first tilted pose wants it.
    machine::AxisPosition home() const;

  private:
    PathBuilder(const program::Program& program, const machine::Machine& machine, const machine::Setup& setup)
        : program_(&program), machine_(&machine), setup_(&setup) {}
    Result<void> begin();
    Result<const machine::Kinematics*> kinematics_for(double tool_length_mm);
    Result<const machine::Tool*> tool_of(const program::Move& move);
    Result<machine::Frame> offset_of(const program::Move& move) const;
    Result<PathCoordinates> coordinates_of(const program::Move& move);
    Result<void> enter(const program::Move& move);
    PathCoordinates converted(program::Space space) const;
    void take_events(Run& run);
    StopCause stop_before(std::size_t move) const;
    bool event_stops_before(std::size_t move) const;

    const program::Program* program_;
    const machine::Machine* machine_;
    const machine::Setup* setup_;
    std::map<double, std::size_t> kinematics_by_length_;
    std::deque<machine::Kinematics> kinematics_;
    std::vector<Diagnostic> diagnostics_;
    PathCoordinates at_;
    program::Space space_ = program::Space::workpiece;
    const machine::Tool* tool_ = nullptr;
    const machine::Kinematics* in_use_ = nullptr;
    std::string borrowed_tool_;  // the name that uses [tool]
    std::size_t move_ = 0, event_ = 0;
};

}  // namespace trunnion::path
