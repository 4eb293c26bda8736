#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "trunnion/machine/machine.hpp"
#include "trunnion/path/axis_path.hpp"
#include "trunnion/path/path_builder.hpp"
#include "trunnion/program/program.hpp"
#include "trunnion/smoothing/smoothing.hpp"

#include "arguments.hpp"

/// The stretches of a program from rest to rest, and places on them by the path parameter p.
namespace trunnion::python {

/// What the stretches of one program point to.
struct StretchOrigin {
    std::shared_ptr<const machine::Machine> machine;
    std::shared_ptr<const program::Program> program;
    machine::Setup setup;
    std::vector<program::RotaryStand> stands;
    std::optional<path::PathBuilder> builder;
};

/// One stretch; the axis path points into it, so that it stays where it was made. Immutable.
struct BoundStretch {
    std::shared_ptr<const StretchOrigin> origin;
    path::ToolPath tool_path;
    std::optional<path::AxisPath> axis_path;

    const machine::Machine& machine() const { return *origin->machine; }
    double p_of(const path::PathPlace& place) const { return tool_path.pieces[place.piece].begin_mm + place.offset_mm; }
    /// Precondition: p within the stretch.
    path::PathPlace place_at(double p_mm) const;
};
using SharedStretch = std::shared_ptr<const BoundStretch>;

/// Builds the path, smooths it, and takes it through the machine. Errors: those of path.
std::vector<SharedStretch> stretches_of(std::shared_ptr<StretchOrigin> origin,
                                        const smoothing::SmoothingOptions& options);

}  // namespace trunnion::python
