#pragma once

#include <memory>
#include <span>

#include "trunnion/base/result.hpp"
#include "trunnion/machine/machine.hpp"
#include "trunnion/path/run.hpp"
#include "trunnion/program/program.hpp"

namespace trunnion::path {

namespace detail {
class Surroundings;
struct Surrounding;
}  // namespace detail

/// Turns the moves of a program into runs, one after another, in the frame of the setup's workpiece: work offsets
/// applied, tools resolved to their length, untransformed coordinates turned into machine axes, coordinates that a move
/// leaves open taken from where the machine stands, blocks shorter than 1e-7 mm of p dropped, cut where motion stands
/// still (rapids, stopping events, exact stops, changes of space, tool or orientation law). Holds the kinematics that
/// the runs point to and must outlive them; keeps references to program, machine, setup and stands.
///
/// `stands`: where the rotary axes stand at the end of every move (choose_rotary_stands), one a move. Moves that are
/// marked rebranched come as runs of law rotary. Where they change to the other branch inside a run it has a passage
/// through the pole.
/// A named tool is looked up in Setup::tools; a setup without that table gives its one [tool] to the first name that
/// the program calls. G54 without an entry is the workpiece itself.
///
/// Errors: PATH0001 no motion, PATH0002 tool not in the setup, PATH0003 work offset not in the setup, PATH0006 rotary
/// words on a machine without such an axis, PATH0008 an arc in untransformed coordinates where the linear axes do not
/// stand at right angles, PATH0009 an arc that begins on its own axis, PATH0010 a move beyond or longer than 10 km, or
/// not finite, PATH0011 surfaces whose passes are not laid, PATH0121 … PATH0123 and PATH0125 a curve or a part of it that cannot be followed (PATH0121 no such part
/// or curve, PATH0122 the curve is none, PATH0123 the part is empty, outside or goes over a knot, PATH0125 a tool axis
/// that vanishes or is given without TCP), PATH0124 a part that does not begin where the move before ends, or end where
/// its move does, within 1 µm and the same at the reference height; and those of Kinematics::make.
class PathBuilder {
  public:
    static Result<PathBuilder> make(const program::Program& program, const machine::Machine& machine,
                                    const machine::Setup& setup, std::span<const program::RotaryStand> stands);
    PathBuilder(PathBuilder&&) noexcept;
    PathBuilder& operator=(PathBuilder&&) noexcept;
    ~PathBuilder();

    /// The next run with at least one block; false when the program is at its end.
    Result<bool> next(Run& run);

    /// Notes and warnings met so far.
    const std::vector<Diagnostic>& diagnostics() const;

  private:
    /// Where the positions of a move lie in its run: map·x + shift.
    struct Placement {
        Eigen::Matrix3d map = Eigen::Matrix3d::Identity();
        Eigen::Vector3d shift_mm = Eigen::Vector3d::Zero();
    };

    PathBuilder(const program::Program& program, const machine::Machine& machine,
                std::span<const program::RotaryStand> stands, detail::Surroundings surroundings);
    Result<void> begin();
    Result<void> begin_run(Run& run);
    Result<void> add_move(Run& run);
    Result<PathCoordinates> coordinates_of(std::size_t move, const detail::Surrounding& in) const;
    Placement placement_of(const program::Move& move, const detail::Surrounding& in) const;
    Result<program::Arc> arc_of(const program::Move& move, const detail::Surrounding& in) const;
    Result<CurvePiece> curve_of(std::size_t move, const PathCoordinates& to, const detail::Surrounding& in) const;
    geometry::BezierPiece machine_axes_of(const geometry::BezierPiece& words, const PathCoordinates& from) const;
    Result<Block> block_to(std::size_t move, const PathCoordinates& to, Run& run);
    Eigen::Vector3d tool_axis() const;
    machine::AxisPosition here() const;
    void stand_where_it_leaves_the_pole(Run& run) const;
    void find_passages(Run& run) const;
    OrientationLaw law_of(std::size_t move) const;
    StopCause stop_before(std::size_t move) const;
    void take_events(Run& run);

    const program::Program* program_;
    const machine::Machine* machine_;
    std::span<const program::RotaryStand> stands_;
    std::unique_ptr<detail::Surroundings> surroundings_;
    PathCoordinates at_;  // in space_ and law_
    Space space_ = Space::workpiece;
    OrientationLaw law_ = OrientationLaw::vector;
    const machine::Tool* tool_ = nullptr;
    const machine::Kinematics* kinematics_ = nullptr;
    std::size_t move_ = 0, event_ = 0;
};

}  // namespace trunnion::path
