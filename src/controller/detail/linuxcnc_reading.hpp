#pragma once

#include <deque>
#include <map>
#include <vector>

#include "trunnion/base/result.hpp"
#include "trunnion/machine/kinematics.hpp"
#include "trunnion/program/program.hpp"

#include "detail/linuxcnc_canonical.hpp"

namespace trunnion::controller::linuxcnc {

/// How the planner's coordinates count: with TCP on they are the tip in the workpiece, with TCP off the tip as it would
/// be with the rotary axes at 0.
struct Geometry {
    const machine::Kinematics* kinematics = nullptr;
    bool tcp = true;
    bool operator==(const Geometry&) const = default;
};

/// Hands the moves and events of a program to the canonical layer, one after the other, in the planner's coordinates.
class Reading {
  public:
    /// Errors: CTRL0101 to CTRL0104, CTRL0108 to CTRL0110, those of Kinematics::make.
    static Result<Reading> make(const program::Program& program, const machine::Machine& machine,
                                const machine::Setup& setup, const LinuxcncWaits& waits);

    /// Where motion begins; before anything else.
    Result<void> start(Canonical& canonical);
    bool at_end() const { return next_ >= program_->moves.size(); }
    /// One move with the words before it; behind the last one the words at the end. Errors: CTRL0103 to CTRL0106,
    /// CTRL0109 to CTRL0111.
    Result<void> read_on(Canonical& canonical);

    machine::AxisPosition axes_at(const Coordinates& position, std::size_t geometry) const;

  private:
    Reading(const program::Program& program, const machine::Machine& machine, const machine::Setup& setup,
            const LinuxcncWaits& waits)
        : program_(&program), machine_(&machine), setup_(&setup), waits_(&waits) {}
    Result<void> check_machine() const;
    Result<void> find_letters();
    Result<const machine::Kinematics*> kinematics_of(const program::Move& move);
    Result<Vector3d> origin_of(const program::Move& move) const;
    std::size_t index_of(const Geometry& geometry);
    Result<void> enter(const program::Move& move, Canonical& canonical);
    Result<Coordinates> end_of(const program::Move& move) const;
    Result<Circle> circle_of(const program::Move& move, const Coordinates& end, int& normal_axis) const;
    Result<void> move(const program::Move& move, Canonical& canonical);
    void words_before(std::size_t move, Canonical& canonical);
    void event(const program::Event& event, Canonical& canonical);
    Coordinates coordinates_of(const machine::AxisPosition& axes, const Geometry& geometry) const;
    machine::RotaryPosition rotary_of(const Coordinates& position) const;
    Diagnostic at(const program::Move& move, std::string code, std::string text) const;

    const program::Program* program_;
    const machine::Machine* machine_;
    const machine::Setup* setup_;
    const LinuxcncWaits* waits_;
    std::map<double, std::size_t> kinematics_by_length_;
    std::deque<machine::Kinematics> kinematics_;
    std::vector<Geometry> geometries_;
    std::size_t geometry_ = 0;
    std::vector<int> letter_slot_;                           // A B C of Program::rotary_letters
    std::array<int, machine::max_rotary_axes> axis_slot_{};  // of the machine's rotary axes
    std::size_t next_ = 1, event_ = 0, control_ = 0;
    Coordinates position_;
    std::uint16_t offset_ = 0, tool_ = 0;
    std::int32_t prepared_line_ = 0;  // of the last T word
};

}  // namespace trunnion::controller::linuxcnc
