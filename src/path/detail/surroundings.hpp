#pragma once

#include <deque>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "trunnion/base/result.hpp"
#include "trunnion/machine/kinematics.hpp"
#include "trunnion/path/run.hpp"
#include "trunnion/program/program.hpp"

#include "detail/program_curves.hpp"

namespace trunnion::path::detail {

/// Longer moves, and coordinates farther from zero, are slips of the pen: they would be planned for hours. Rotary
/// words: as many radians.
inline constexpr double longest_move_mm = 1e7;

/// What a move counts in: the tool with the geometry of the machine that carries it, and the work offset.
struct Surrounding {
    const machine::Tool* tool = nullptr;
    const machine::Kinematics* kinematics = nullptr;
    const machine::Frame* offset = nullptr;
    bool operator==(const Surrounding&) const = default;
};

/// The tools and work offsets that the moves of a program call, looked up once each. Keeps references to program,
/// machine and setup; what it hands out lives as long as it does and stays where it is when it is moved.
class Surroundings {
  public:
    /// Errors: PATH0001 no motion, PATH0010 a coordinate beyond 10 km or not finite, PATH0006 rotary words on a machine
    /// without such an axis, and those of ProgramCurves::check.
    static Result<Surroundings> make(const program::Program& program, const machine::Machine& machine,
                                     const machine::Setup& setup);

    /// Errors: PATH0002 tool not in the setup, PATH0003 work offset not in the setup, and those of Kinematics::make.
    Result<Surrounding> of(const program::Move& move);

    /// The part of a curve that a move follows, as written.
    CurvePiece curve_of(const program::Move& move) { return curves_.part(move); }

    /// Index in Move::rotary_rad of the words for a rotary axis of the machine; −1: the program never names it.
    int word_of_axis(int rotary) const { return word_of_axis_[static_cast<std::size_t>(rotary)]; }

    /// Where the rotary axes stand before the first motion: at Setup::start, else at 0.
    machine::RotaryPosition start() const;

    const std::vector<Diagnostic>& diagnostics() const { return diagnostics_; }

  private:
    Surroundings(const program::Program& program, const machine::Machine& machine, const machine::Setup& setup)
        : program_(&program), machine_(&machine), setup_(&setup), curves_(program) {}
    Result<void> find_words();
    Result<const machine::Tool*> tool_of(const program::Move& move);
    Result<const machine::Frame*> offset_of(const program::Move& move);
    Result<const machine::Kinematics*> kinematics_for(double tool_length_mm);

    const program::Program* program_;
    const machine::Machine* machine_;
    const machine::Setup* setup_;
    std::array<int, machine::max_rotary_axes> word_of_axis_{-1, -1};
    std::map<double, std::size_t> kinematics_by_length_;
    std::deque<machine::Kinematics> kinematics_;
    std::vector<Surrounding> tools_;              // by Move::tool; kinematics null: not yet asked for
    std::vector<const machine::Frame*> offsets_;  // by Move::offset
    std::deque<machine::Frame> no_offset_{1};     // in a deque: it stays where it is
    std::string borrowed_tool_;                   // the name that uses [tool]
    std::vector<Diagnostic> diagnostics_;
    ProgramCurves curves_;
};

/// A diagnostic that points to a move.
Diagnostic at_move(const program::Program& program, const program::Move& move, std::string code, std::string text);

/// The frame of a move's position and back: tip in the workpiece ↔ coordinates in the work offset.
Eigen::Vector3d out_of_offset(const machine::Frame& offset, const Eigen::Vector3d& position_mm);
Eigen::Vector3d into_offset(const machine::Frame& offset, const Eigen::Vector3d& tip_in_workpiece_mm);

/// A position of the machine from its linear and its rotary axes, and the latter from a position.
machine::AxisPosition axes_of(const machine::Machine& machine, const std::array<double, 3>& linear_mm,
                              const machine::RotaryPosition& rotary_rad);
machine::RotaryPosition rotary_of(const machine::Machine& machine, const machine::AxisPosition& position);

/// The end of a move in its own space with the coordinates that it leaves open (not a number) taken from where the
/// machine stands.
Eigen::Vector3d whole_position(const program::Move& move, const Surrounding& in, const machine::Machine& machine,
                               const machine::AxisPosition& here);

/// The linear axes at a position given in untransformed coordinates.
std::array<double, 3> linear_of_untransformed(const Surrounding& in, const Eigen::Vector3d& position_mm);

/// Whether the path from moves[move − 1] to moves[move] begins from standstill, and why; `corner`: it does not. The
/// program alone decides; changes of the orientation law are not seen here.
StopCause stop_between(const program::Program& program, std::size_t move);

}  // namespace trunnion::path::detail
