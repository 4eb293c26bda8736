#pragma once

#include <memory>
#include <string>

#include "trunnion/machine/kinematics.hpp"
#include "trunnion/machine/machine.hpp"

#include "arguments.hpp"

namespace trunnion::python {

/// The setup of an argument that may be None: program zero at the machine zero, tool length 0.
const machine::Setup& setup_of(py::handle object);

/// mm, or degrees in rad.
inline double unit_of(const machine::Axis& axis) {
    return axis.rotary ? degree : 1.0;
}

/// The geometry of a machine with the tool and the workpiece of a setup, as Python sees it. Immutable.
struct BoundKinematics {
    std::shared_ptr<const machine::Machine> machine;
    machine::Kinematics kinematics;
};
BoundKinematics kinematics_of(std::shared_ptr<machine::Machine> machine, py::handle setup);

}  // namespace trunnion::python
