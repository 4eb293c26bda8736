#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "trunnion/smoothing/kernel.hpp"

#include "detail/bump_field.hpp"
#include "detail/polyline.hpp"

namespace trunnion::smoothing {

/// A place on a polyline: block and distance from that block's start. Blocks and vertices are counted as Bumps does.
struct Place {
    std::size_t block = 0;
    double offset_mm = 0;
};

/// Deviation c − P at a place, by the two kinds of bumps.
struct Deviation {
    Coordinates curve = Coordinates::Zero(), corner = Coordinates::Zero();
};

/// c − P and the first three derivatives of c.
using Jet = std::array<Coordinates, 4>;

/// Kinks of a polyline and the widths of their bumps: the curve c. Vertices are continued beyond both ends by point
/// reflection, so that a sum over neighbours needs no end rule, leaves the ends in place and makes c″ = 0 there: real
/// vertices are first() … last(), the others mirror them.
///
/// Each kink is shared between a curve bump and a corner bump.
class Bumps {
  public:
    /// `cap_mm` bounds every width; the polyline must be at least that long.
    Bumps(const Polyline& line, double cap_mm);
    Bumps(const Bumps&) = delete;  // the fields see its jumps
    Bumps& operator=(const Bumps&) = delete;

    std::size_t first() const { return lead_; }
    std::size_t last() const { return lead_ + count_ - 1; }
    std::size_t size() const { return jump.size(); }
    std::size_t source(std::size_t vertex) const;  ///< the real vertex that this one is or mirrors
    double cap_mm() const { return cap_; }

    std::vector<double> gap;           ///< vertex k → k + 1
    std::vector<Coordinates> jump;     ///< Δ
    std::vector<Coordinates> slope;    ///< P′ on the block from k to k + 1
    std::vector<double> corner_share;  ///< of Δ that is rounded as a corner; the rest as a curve
    std::vector<double> curve_width, corner_width;

    /// The way from a vertex to another one at or behind it, mm.
    double distance(std::size_t from, std::size_t to) const {
        return static_cast<double>(position_[to] - position_[from]);
    }

    /// Σ Δ_j·(1 − |p_j − p_k|/radius) over the vertices nearer than the radius to vertex k.
    Coordinates cluster(std::size_t vertex, double radius_mm) const;

    /// Copies shares and widths of real vertices to those that mirror them and takes them into what follows. To be
    /// called after every change; slopes of widths are to be limited.
    void settle();

    /// width[k] ← min over j of width[j] + slope·|p_j − p_k|, real vertices.
    void limit_slope(std::vector<double>& width, double slope) const;

    Deviation deviation(Place at) const;
    Coordinates tangent(Place at) const;  ///< c′
    Jet jet(Place at) const;

    /// Calls visit(vertex, p − p_vertex) for every vertex within `reach_mm` of the place, outwards on each side.
    template <class Visit>
    void around(Place at, double reach_left_mm, double reach_right_mm, Visit&& visit) const {
        std::size_t j = at.block;
        for (double d = at.offset_mm; d < reach_left_mm; d += gap[j]) {
            visit(j, d);
            if (j-- == 0) break;
        }
        j = at.block + 1;
        for (double d = at.block < gap.size() ? gap[at.block] - at.offset_mm : reach_right_mm; d < reach_right_mm;
             d += gap[j - 1]) {
            visit(j, -d);
            if (++j == jump.size()) break;
        }
    }

    /// Calls visit(vertex, p − p_vertex) for the vertices whose bumps may come nearer than `extent_mm` to the place,
    /// and hardly any others.
    template <class Visit>
    void touching(Place at, double extent_mm, Visit&& visit) const {
        walk(reach_, at, extent_mm, visit);
    }
    /// The same of corner bumps.
    template <class Visit>
    void corners_touching(Place at, double extent_mm, Visit&& visit) const {
        walk(corner_reach_, at, extent_mm, visit);
    }

  private:
    /// How far the bumps at every vertex and before it reach beyond it, and those at and behind it the other way.
    struct Reach {
        std::vector<double> from_left, from_right;
    };

    template <class OwnReach>
    void note_reach(Reach& reach, OwnReach&& own) const;
    Coordinates way(std::size_t vertex, double way_mm) const;
    template <class Visit>
    void walk(const Reach& reach, Place at, double extent_mm, Visit&& visit) const {
        std::size_t j = at.block;
        for (double d = at.offset_mm; reach.from_left[j] > d - extent_mm; d += gap[j]) {
            visit(j, d);
            if (j-- == 0) break;
        }
        j = at.block + 1;
        for (double d = gap[at.block] - at.offset_mm; reach.from_right[j] > d - extent_mm; d += gap[j - 1]) {
            visit(j, -d);
            if (++j == jump.size()) break;
        }
    }
    template <std::size_t orders>
    void add(Place at, std::array<Coordinates, orders>& curve, std::array<Coordinates, orders>& corner) const;

    double cap_;
    std::size_t lead_ = 0, count_ = 0;
    Reach reach_, corner_reach_;
    std::vector<long double> position_;  // by p: ways of 1 nm are exact to 1e-9 of themselves 1 km from the start
    std::vector<Coordinates> place_;     // P at every vertex
    BumpField<CurveKernel> curves_;
    BumpField<CornerKernel> corners_;
    std::vector<double> curve_share_;
};

/// How much the curve bumps' width may change per mm. Noise cancels only between bumps of nearly equal widths.
inline constexpr double curve_width_slope = 0.5;
inline constexpr double corner_width_slope = 1.0;

}  // namespace trunnion::smoothing
