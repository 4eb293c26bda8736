#include "detail/branch_rule.hpp"

#include <cmath>
#include <numbers>

#include "trunnion/machine/kinematics.hpp"
#include "trunnion/path/rotary_stands.hpp"

namespace trunnion::controller {

using machine::RotaryPosition;
using motion::BranchRule;

namespace {

/// A control that takes the solution of each block as it comes to it.
class BlockByBlock {
  public:
    BlockByBlock(const machine::Machine& machine, const machine::Kinematics& kinematics, BranchRule rule)
        : machine_(machine), kinematics_(kinematics), rule_(rule) {}

    /// The solution for a tool axis from where the axes stand; where they stand if there is none.
    RotaryPosition next(const Eigen::Vector3d& tool_axis, const RotaryPosition& at) const {
        const auto solutions = kinematics_.rotary_for(tool_axis);
        RotaryPosition out = at;
        double least = INFINITY;
        for (int k = 0; k < solutions.count; ++k) {
            const RotaryPosition candidate =
                wound(solutions.rotary_rad[static_cast<std::size_t>(k)], at, solutions.degenerate);
            const double cost = cost_of(candidate, at);
            if (!(cost < least)) continue;
            least = cost;
            out = candidate;
        }
        return out;
    }

  private:
    const machine::Axis& axis(std::size_t rotary) const { return machine_.axes[3 + rotary]; }

    RotaryPosition wound(RotaryPosition solution, const RotaryPosition& at, bool at_pole) const {
        for (int a = 0; a < machine_.rotary_count; ++a) {
            const auto k = static_cast<std::size_t>(a);
            if (at_pole && a == kinematics_.rotary_nearest_workpiece()) {
                solution[k] = at[k];
                continue;
            }
            solution[k] = at[k] + std::remainder(solution[k] - at[k], 2 * std::numbers::pi);
            if (rule_ == BranchRule::nearest) continue;
            if (solution[k] > axis(k).range_max) solution[k] -= 2 * std::numbers::pi;
            if (solution[k] < axis(k).range_min) solution[k] += 2 * std::numbers::pi;
        }
        return solution;
    }

    /// The way there; of rule `positive` what it does not want costs far more, what the ranges do not have more still.
    double cost_of(const RotaryPosition& to, const RotaryPosition& at) const {
        constexpr double unwanted = 1e3, impossible = 1e6;
        double cost = 0;
        for (int a = 0; a < machine_.rotary_count; ++a) {
            const auto k = static_cast<std::size_t>(a);
            cost += std::abs(to[k] - at[k]);
            if (rule_ == BranchRule::nearest) continue;
            if (to[k] < axis(k).range_min || to[k] > axis(k).range_max) cost += impossible;
            const bool tilts = a != kinematics_.rotary_nearest_workpiece() || machine_.rotary_count == 1;
            if (tilts && to[k] < 0) cost += unwanted;
        }
        return cost;
    }

    const machine::Machine& machine_;
    const machine::Kinematics& kinematics_;
    BranchRule rule_;
};

}  // namespace

Result<std::vector<program::RotaryStand>> stands_by_rule(const program::Program& program,
                                                         const machine::Machine& machine, const machine::Setup& setup,
                                                         BranchRule rule) {
    auto stands = path::choose_rotary_stands(program, machine, setup);
    if (!stands || rule == BranchRule::least_turning) return stands;
    const auto kinematics = machine::Kinematics::make(machine, setup.workpiece, 0);
    if (!kinematics) return fail(kinematics.error());
    const BlockByBlock control(machine, *kinematics, rule);
    RotaryPosition at{};
    for (int a = 0; a < machine.rotary_count; ++a) {
        const auto start = setup.start.find(machine.axes[static_cast<std::size_t>(3 + a)].letter);
        if (start != setup.start.end()) at[static_cast<std::size_t>(a)] = start->second;
    }
    for (std::size_t i = 0; i < program.moves.size(); ++i) {
        const program::Move& move = program.moves[i];
        program::RotaryStand& stand = (*stands)[i];
        if (move.law == program::OrientationLaw::vector && move.space == program::Space::workpiece) {
            const auto offset = setup.offsets.find(program.offsets[move.offset]);
            const Eigen::Vector3d axis =
                offset == setup.offsets.end() ? move.axis : Eigen::Vector3d(offset->second.rotation * move.axis);
            stand = {control.next(axis, at), false};
        }
        at = stand.rotary_rad;
    }
    return stands;
}

}  // namespace trunnion::controller
