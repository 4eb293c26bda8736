#include "trunnion/files/machine_file.hpp"

#include <cmath>

#include "trunnion/machine/kinematics.hpp"

#include "entries.hpp"

namespace trunnion::fuzz {

namespace {

void expect_sound(const machine::AxisLimits& limits) {
    for (const double limit : {limits.velocity, limits.acceleration, limits.jerk})
        expect(std::isfinite(limit) && limit > 0, "limits are above 0");
}

void expect_sound(const machine::Machine& machine) {
    expect(machine.linear_count() == 3, "three linear axes");
    expect(machine.rotary_count >= 0 && machine.rotary_count <= machine::max_rotary_axes, "at most two rotary axes");
    for (int i = 0; i < machine.axis_count; ++i) {
        const machine::Axis& axis = machine.axes[static_cast<std::size_t>(i)];
        expect(std::abs(axis.direction.norm() - 1) < 1e-9, "directions are unit vectors");
        expect(axis.point_mm.allFinite(), "points on axes are finite");
        expect(axis.range_min < axis.range_max, "ranges are not empty");
        expect_sound(axis.feed);
        expect_sound(axis.rapid);
        expect(machine.index_of(axis.letter) == i, "letters are there once");
    }
}

/// The first of the solutions for an orientation that the machine certainly reaches gives this orientation.
void expect_reached(const machine::Kinematics& kinematics) {
    const Eigen::Vector3d axis = kinematics.tool_axis(machine::RotaryPosition{0.3, 0.4});
    expect(std::abs(axis.norm() - 1) < 1e-9, "tool axes are unit vectors");
    const auto solutions = kinematics.rotary_for(axis);
    expect(solutions.count > 0, "an orientation that is reached has a solution");
    expect((kinematics.tool_axis(solutions.rotary_rad[0]) - axis).norm() < 1e-6, "solutions give the orientation");
}

}  // namespace

void take_machine_file(std::string_view bytes) {
    const auto machine = files::read_machine(bytes, "fuzz");
    if (!machine) return expect_sound(machine.error(), bytes);
    expect_sound(*machine);
    const auto kinematics = machine::Kinematics::make(*machine, {}, 0);
    if (!kinematics) return expect_sound(kinematics.error(), bytes);
    expect_reached(*kinematics);
}

}  // namespace trunnion::fuzz
