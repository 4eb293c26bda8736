#pragma once

#include <cstdint>
#include <optional>

#include "trunnion/base/result.hpp"
#include "trunnion/geometry/bspline_curve.hpp"
#include "trunnion/path/run.hpp"
#include "trunnion/program/program.hpp"

namespace trunnion::path::detail {

/// Where a curve has to begin or end: position and orientation in the coordinates of the curve.
struct CurveEnd {
    Eigen::Vector3d position_mm, orientation;
};

/// Moves the ends of a curve onto those of its move, which differ by rounding. `vectors`: the orientation is a
/// direction, and unit at the ends. Errors: PATH0124 they differ by more than 1 µm, or that at the reference height.
Result<void> fit_ends(CurvePiece& curve, const CurveEnd& from, const CurveEnd& to, bool vectors,
                      const program::Program& program, const program::Move& move);

/// The curves that a program gives, checked, and the parts of them that its moves follow. Keeps a reference to the
/// program and the splines of the curve that was asked for last: moves follow one curve after another.
class ProgramCurves {
  public:
    explicit ProgramCurves(const program::Program& program) : program_(&program) {}

    /// Looks at every part that a move follows, and at its curve. Errors: PATH0121 no such part or curve, or an arc as
    /// well, PATH0122 the curve is none, PATH0123 the part is empty, outside the curve or goes over a knot, PATH0125
    /// the tool axis vanishes on the way, or it is given without TCP.
    Result<void> check();

    /// What a move follows, as written: the position in the move's space; law vector: the tool axis in the work offset;
    /// law rotary: the words. Precondition: checked.
    CurvePiece part(const program::Move& move);

  private:
    struct Splines {
        std::int32_t curve = -1;
        std::optional<geometry::BsplineCurve> position, axis, rotary;
    };

    Result<void> take(const program::Move& move);
    Result<void> check(const program::Move& move);

    const program::Program* program_;
    Splines splines_;
};

}  // namespace trunnion::path::detail
