#pragma once

#include <span>
#include <vector>

#include "trunnion/path/tool_path.hpp"

#include "detail/section.hpp"

namespace trunnion::smoothing {

/// The shift that leads a path through a pole (trunnion/path/pole_passage.hpp): added to the orientation, and to the
/// position so much less that the controlled point stays. p counts from the begin of the range.
struct PoleShift {
    double at_mm = 0;
    Eigen::Vector3d pole = Eigen::Vector3d::UnitZ();
    Eigen::Vector3d vector = Eigen::Vector3d::Zero();
    double begin_mm = 0, whole_from_mm = 0, whole_to_mm = 0, end_mm = 0;  ///< ascending, at_mm in the middle
    bool used = false;                                                    ///< else the path is left as it is

    bool touches(double from_mm, double to_mm) const { return used && from_mm < end_mm && to_mm > begin_mm; }
    PoleShift counted_from(double origin_mm) const;
    bool operator==(const PoleShift&) const = default;
};

/// A piece of the path before it is shifted.
struct PlainPiece {
    double begin_mm = 0;
    const path::PathPiece* piece = nullptr;
};

/// Shifts for the passages of a run that lie in a range.
class PoleShifts {
  public:
    PoleShifts(const path::Run& run, VertexRange range, const Measure& measure);

    bool empty() const { return passages_.empty(); }
    const std::vector<PoleShift>& shifts() const { return shifts_; }

    /// From the path before it is shifted: place, vector and reach of every shift. A passage that is too far from the
    /// pole by now is left as it is.
    void find(std::span<const PlainPiece> path);

    /// Shifts pieces that begin at `origin_mm`; their own begins count from there. They are divided at the pole and
    /// where the shift begins and is whole.
    void apply(double origin_mm, std::vector<path::PathPiece>& pieces) const;

    /// Where a shift lies under an excess the curve has to give way: blames it. Where rounding itself leads the path so
    /// far from the pole that the shift is too long, that is the only excess: the rest follows from it.
    void blame_curve(const Bumps& bumps, std::vector<Excess>& places) const;

    /// Largest length of a shift.
    double largest() const;

  private:
    std::vector<Excess> too_long(const Bumps& bumps) const;

    struct Passage {
        double near_mm;
        Eigen::Vector3d pole;
    };

    std::vector<Passage> passages_;
    std::vector<PoleShift> shifts_;
    double length_mm_ = 0, tolerance_rad_, controlled_height_mm_;
};

/// Represents the stale sections of a curve: `plain` before the shifts, `sections` with them. Shifts are found anew;
/// where they changed sections become stale too.
void lead_through_poles(PoleShifts& shifts, const Curve& curve, std::vector<Section>& plain,
                        std::vector<Section>& sections, std::vector<char>& stale);

/// Leads a stretch of blocks as programmed through the poles of its range, and widens its bound.
void lead_through_poles(const path::Run& run, VertexRange range, const SmoothingOptions& options, path::ToolPath& path);

}  // namespace trunnion::smoothing
