#include "trunnion/path/rotary_stands.hpp"

#include "detail/stand_choice.hpp"

namespace trunnion::path {

Result<std::vector<program::RotaryStand>> choose_rotary_stands(const program::Program& program,
                                                               const machine::Machine& machine,
                                                               const machine::Setup& setup, double pole_tolerance_rad,
                                                               const std::optional<machine::RotaryPosition>& standing) {
    auto surroundings = detail::Surroundings::make(program, machine, setup);
    if (!surroundings) return fail(surroundings.error());
    return detail::StandChoice(program, machine, std::move(*surroundings), pole_tolerance_rad, standing)();
}

}  // namespace trunnion::path
