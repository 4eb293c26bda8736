#include "detail/stretch.hpp"

namespace trunnion::pipeline {

void lengthen_parameter(path::ToolPath& path) {
    const double length = path.length_mm();
    if (length >= shortest_stretch_mm || !(length > 0)) return;
    const double factor = shortest_stretch_mm / length;
    for (path::PathPiece& piece : path.pieces) {  // coefficients are by the share of a piece: they stay
        piece.begin_mm *= factor;
        piece.length_mm *= factor;
    }
    for (path::BlockSpan& block : path.blocks) {
        block.begin_mm *= factor;
        block.end_mm *= factor;
        block.time_scale_mm *= factor;
    }
    path.blocks.back().end_mm = path.length_mm();
}

Result<std::shared_ptr<const Stretch>> Stretch::make(path::ToolPath tool_path, const machine::Machine& machine,
                                                     const machine::RotaryPosition& near,
                                                     std::shared_ptr<const void> part) {
    auto out = std::make_shared<Stretch>(std::move(tool_path), near);
    out->part = std::move(part);
    lengthen_parameter(out->tool_path);
    auto axis_path = path::AxisPath::make(out->tool_path, machine, near);
    if (!axis_path) return fail(axis_path.error());
    out->axis_path.emplace(std::move(*axis_path));
    return out;
}

Diagnostic located(Diagnostic error, const program::Program& program, int line) {
    error.place.file = program.source;
    if (error.place.line == 0) error.place.line = line;
    return error;
}

}  // namespace trunnion::pipeline
