#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <vector>

#include "trunnion/base/result.hpp"
#include "trunnion/machine/kinematics.hpp"
#include "trunnion/path/tool_path.hpp"

namespace trunnion::path {

namespace detail {
class PolePiece;
}  // namespace detail

/// A place on a path: piece and distance from that piece's start. A sum of both would lose digits on long paths that
/// the third difference of setpoints needs.
struct PathPlace {
    std::size_t piece = 0;
    double offset_mm = 0;
};

/// The machine axes and the tool at one place, with derivatives by p.
struct AxisSample {
    std::array<Taylor3, machine::max_axes> axes;  ///< order of AxisVector; mm, rad per mm^k
    machine::VectorSeries tip;                    ///< tip in the workpiece, mm; in machine space too
    machine::VectorSeries tool_axis;              ///< unit tool axis in the workpiece
    double feed_rate =
        0;  ///< path length that a tip_speed feed counts, per mm of p: |dtip/dp| (machine space: of the linear axes)
    double turn_rate = 0;  ///< Euclidean |d(rotary words)/dp|, rad/mm; law vector: |dn/dp|
};

/// The image of one stretch of tool path through the machine: continuous branch and winding, exact derivatives.
/// Keeps references to the tool path and the machine, which must outlive it. Immutable; evaluate() is thread safe.
class AxisPath {
  public:
    /// `near`: under law vector the rotary axes begin on the branch and winding nearest to it and go on from there
    /// without a jump. Where the stretch begins at the pole, the axis that is free there begins where the path leaves
    /// the pole, on the side and winding nearest to `near`, and at `near` itself where it never leaves. Under law
    /// rotary and in machine space `near` is not used. Ranges are checked everywhere, not only at stations: what an
    /// axis may do between two places is bounded by the Bernstein hull of the septic polynomial through its values and
    /// derivatives there, and looked at more finely where that leaves room for doubt. Errors: PATH0101 orientation out
    /// of reach, PATH0102 an axis leaves its range (place, value, limit), PATH0103 the path passes the pole too closely
    /// to follow.
    static Result<AxisPath> make(const ToolPath& path, const machine::Machine& machine,
                                 const machine::RotaryPosition& near);

    const ToolPath& tool_path() const { return *path_; }
    const machine::Machine& machine() const { return *machine_; }
    int axis_count() const { return machine_->axis_count; }
    double length_mm() const { return path_->length_mm(); }
    machine::AxisPosition begin_position() const { return position(stations_.front()); }
    machine::AxisPosition end_position() const { return position(stations_.back()); }

    /// Cost 0.3-0.6 µs, no allocation. Precondition: 0 ≤ offset ≤ length of the piece (to rounding).
    void evaluate(PathPlace place, AxisSample& sample) const noexcept;
    machine::AxisPosition position(PathPlace place) const noexcept;

    /// Where pieces begin, where branch following needed a finer step, and the end: p ascending. Between two stations
    /// no rotary axis turns more than some 20° under the vector law. The last one is the end of the last piece.
    const std::vector<PathPlace>& stations() const { return stations_; }

  private:
    AxisPath(const ToolPath& path, const machine::Machine& machine) : path_(&path), machine_(&machine) {}
    bool follows_vectors() const {
        return path_->law == OrientationLaw::vector && path_->space == Space::workpiece && machine_->rotary_count > 0;
    }
    Diagnostic diagnose(PathPlace place, std::string code, std::string text) const;
    Diagnostic out_of_reach(PathPlace place) const;
    Diagnostic out_of_range(PathPlace place, int which, double value) const;
    Diagnostic too_close_to_pole(PathPlace place) const;
    Eigen::Vector3d tool_axis(PathPlace place) const;
    machine::RotarySolutions solutions(PathPlace place) const;
    Result<machine::RotaryPosition> beginning(const machine::RotaryPosition& near) const;
    Result<void> follow(const machine::RotaryPosition& near);
    Result<void> check_reach() const;
    Result<void> check_ranges() const;
    Result<void> check_ranges(PathPlace from, const AxisSample& at_from, double length_mm,
                              const AxisSample& at_to) const;
    machine::RotaryPosition reference(PathPlace place) const noexcept;
    void find_pole_pieces();
    const detail::PolePiece* pole_piece(std::size_t index) const noexcept;
    machine::RotarySeries rotary_at(PathPlace place, const machine::VectorSeries& tool_axis) const noexcept;

    const ToolPath* path_;
    const machine::Machine* machine_;
    std::vector<PathPlace> stations_;
    std::vector<machine::RotaryPosition> rotary_at_station_;  // law vector in workpiece space
    std::vector<std::size_t> first_station_of_piece_;
    std::shared_ptr<const std::vector<detail::PolePiece>> pole_pieces_;  // ascending; null: none
};

}  // namespace trunnion::path
