#pragma once

#include <memory>
#include <optional>

#include "trunnion/base/result.hpp"
#include "trunnion/path/axis_path.hpp"
#include "trunnion/program/program.hpp"

namespace trunnion::pipeline {

/// A shorter stretch is planned over as much of p: feed refuses less than 1 µm. A little more, so that rounding does
/// not matter.
inline constexpr double shortest_stretch_mm = 1.001e-3;

/// Makes p at least `shortest_stretch_mm` long. p is only a parameter: curve, feed and time stay what they are.
void lengthen_parameter(path::ToolPath& path);

/// Tool path and axis path of one stretch: the former stays where it is, for the latter points to it.
struct Stretch {
    path::ToolPath tool_path;
    machine::RotaryPosition near{};  ///< as given to AxisPath::make
    std::optional<path::AxisPath> axis_path;
    std::shared_ptr<const void> part;  ///< what the tool path points to

    /// Errors: those of AxisPath::make.
    static Result<std::shared_ptr<const Stretch>> make(path::ToolPath tool_path, const machine::Machine& machine,
                                                       const machine::RotaryPosition& near,
                                                       std::shared_ptr<const void> part);
};

/// The error with its file, and with the line where it has none of its own.
Diagnostic located(Diagnostic error, const program::Program& program, int line);

}  // namespace trunnion::pipeline
