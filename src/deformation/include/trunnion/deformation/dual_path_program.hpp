#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "trunnion/base/result.hpp"
#include "trunnion/deformation/dual_path.hpp"
#include "trunnion/program/program.hpp"

namespace trunnion::deformation {

/// Cutting moves of a program that follow each other without a standstill: moves[first] … moves[last], which begin
/// where moves[first − 1] ends.
struct CuttingStretch {
    std::size_t first = 1, last = 1;
};

/// The stretches of a program, in order: moves of kind feed and law vector in the workpiece, under one tool and one
/// work offset, none but the last with an exact stop, no event between them. Moves of law rotary belong to none (the
/// pipeline turns them into law vector before).
std::vector<CuttingStretch> cutting_stretches(const program::Program& program);

/// The poses of a stretch, and which of them are ends of moves.
struct StretchPoses {
    std::vector<Pose> poses;
    std::vector<std::size_t> move_end;  ///< index in poses of the end of every move, first … last
};

/// Ends of straight moves; arcs also every 5°, curves of the program at 8 places of every part. In the frame of the
/// stretch's work offset. Precondition: a stretch of cutting_stretches(). Errors: DEFO0108 the program's own curve is
/// not sound (a wrong number of control points or a tool axis of length 0).
Result<StretchPoses> poses_of(const program::Program& program, const CuttingStretch& stretch);

/// The dual path that moves of the program already are: one cubic curve with control points of the axis, without
/// weights, whole. `distance_mm`: of the top curve made of it. Errors: DEFO0108 the stretch is no such curve.
Result<DualPath> dual_path_of(const program::Program& program, const CuttingStretch& stretch, double distance_mm);

/// The curve of a dual path as programs have it: control points of f, and g − f for the axis.
program::Curve curve_of(const DualPath& path);

/// A stretch and the path that takes its place, with the u that belong to the ends of its moves.
struct ReplacedStretch {
    CuttingStretch stretch;
    DualPath path;
    std::vector<double> move_end_u;
};

/// Straight moves, as many as keep tip and axis within these, for dialects without curves.
struct Chords {
    double tip_mm = 0, axis_rad = 0;  ///< > 0
};

/// The program with every stretch as one curve, a move a knot interval, so that the splines stay splines to the end of
/// the pipeline and in dialects that have them. Feeds and lines are those of the moves there, events and words of path
/// control keep their places, following axes go in proportion to u. Where a path begins elsewhere than its stretch did,
/// a straight rapid before it ends there; behind other moves a short cutting move leads there. Precondition: stretches
/// in order, u rising from the path's begin to its end. Allocates.
/// With `chords` straight moves take the place of curves.
program::Program with_dual_paths(const program::Program& program, const std::vector<ReplacedStretch>& replaced,
                                 std::optional<Chords> chords = {});

}  // namespace trunnion::deformation
