#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "trunnion/surfacing/cutter.hpp"
#include "trunnion/surfacing/plan_surface.hpp"

#include "detail/region.hpp"

namespace trunnion::surfacing::detail {

/// A curve on a region: through places, over s, the length of their polyline in space. In between cubic in (u, v) of
/// one face. Where it crosses a joint, two places, one on either face, count as one: there it may have a corner, and
/// ends and begins what is called an arc. On one face it is smooth.
class Way {
  public:
    Way() = default;
    /// The region must outlive it. Places of different faces in a row are the two of a joint.
    Way(const Region& region, const std::vector<Place>& places);

    const std::vector<Place>& places() const noexcept { return places_; }
    const std::vector<double>& lengths() const noexcept { return lengths_; }
    double length() const noexcept { return lengths_.empty() ? 0 : lengths_.back(); }

    std::size_t arcs() const noexcept { return begins_.size(); }
    /// Places of an arc: from one up to one before another.
    std::size_t arc_begin(std::size_t arc) const noexcept { return begins_[arc]; }
    std::size_t arc_end(std::size_t arc) const noexcept {
        return arc + 1 < begins_.size() ? begins_[arc + 1] : places_.size();
    }
    std::size_t arc_of(std::size_t place) const noexcept;
    /// Whether the next place is the other one of a joint.
    bool leads_over(std::size_t i) const noexcept {
        return begins_.size() > 1 && i + 1 < places_.size() && places_[i].chart != places_[i + 1].chart;
    }

    Place place(double s) const noexcept;  ///< at a joint on the later arc
    Place place(double s, std::size_t arc) const noexcept;
    Eigen::Vector2d slope(double s) const noexcept;  ///< (du/ds, dv/ds)
    Eigen::Vector2d slope(double s, std::size_t arc) const noexcept;
    Eigen::Vector2d slope_at_place(std::size_t i) const noexcept;

    /// s of the point of the polyline that is nearest to a place of the region and as near on the surface as it is in
    /// space: not beyond a seam, nor on the other side of a thin edge. Nothing where there is none.
    std::optional<double> nearest(const Place& from, const geometry::SurfaceShape& shape) const noexcept;

    /// Distance of a point from that polyline, mm.
    double distance_mm(const Eigen::Vector3d& point) const noexcept;

    /// The same curve through places at equal distances of about `spacing` from joint to joint, and closer where the
    /// surface turns more than 0.2 rad from one to the next, as round an edge that is sharper than the spacing. One
    /// place stays one.
    Way resampled(double spacing) const;

  private:
    struct Piece;
    struct Foot {
        double s, squared;
    };
    /// A ball round some steps of the polyline, so that feet are looked for near a point alone.
    struct Part {
        Eigen::Vector3d middle;
        double radius;
        std::size_t begin, end;  ///< of its steps
    };
    /// Where a way is looked at, and the surface's normal there.
    struct End {
        double s;
        std::optional<Eigen::Vector3d> normal;
    };
    std::optional<Eigen::Vector3d> normal_at(const Place& place) const;
    void resample(std::size_t arc, double spacing, std::vector<Place>& out) const;
    void close(std::size_t arc, const End& from, const End& to, int depth, std::vector<Place>& out) const;
    void gather();
    template <class Accept>
    Foot foot_of(const Eigen::Vector3d& point, const Accept& accept) const noexcept;
    Piece piece_at(double s) const noexcept;
    Piece piece_at(double s, std::size_t arc) const noexcept;
    Piece piece(double s, std::size_t k, std::size_t arc) const noexcept;
    Eigen::Vector2d slope_within(std::size_t arc, std::size_t i) const noexcept;
    const Region* region_ = nullptr;
    std::vector<Place> places_;
    std::vector<Eigen::Vector3d> points_;
    std::vector<double> lengths_;
    std::vector<std::size_t> begins_;  ///< of arcs
    std::vector<Part> parts_;
};

/// A tool on a way.
struct Station {
    Place place;
    geometry::SurfaceShape shape;
    Eigen::Vector3d along, across;  ///< unit: the way's direction, and normal × along
    CutterPose pose;
};

/// What a plan is about.
struct Job {
    const Region& region;
    const Cutter& cutter;
    const SurfaceOptions& options;

    /// Of a region of one face, that face.
    const Face& face() const noexcept { return region.face(0); }
    std::optional<geometry::SurfaceShape> shape(const Place& place) const noexcept { return region.shape(place); }
    /// `backwards`: the tool moves against the way's direction. Nothing where the surface has no normal.
    std::optional<Station> station(const Way& way, double s, bool backwards) const noexcept {
        return station(way.place(s), way.slope(s), backwards);
    }
    std::optional<Station> station(const Way& way, double s, std::size_t arc, bool backwards) const noexcept {
        return station(way.place(s, arc), way.slope(s, arc), backwards);
    }
    std::optional<Station> station_at_place(const Way& way, std::size_t i, bool backwards) const noexcept {
        return station(way.places()[i], way.slope_at_place(i), backwards);
    }
    /// A tool that moves in a tangent direction.
    Station standing(const Place& place, const geometry::SurfaceShape& shape, const Eigen::Vector3d& along,
                     bool backwards) const noexcept;
    /// Ridges are planned that high.
    double ridge_mm() const noexcept { return options.scallop_mm - options.chord_tolerance_mm; }
    bool backwards(int index) const noexcept { return options.zigzag && index % 2 != 0; }

  private:
    std::optional<Station> station(const Place& place, const Eigen::Vector2d& slope, bool backwards) const noexcept;
};

}  // namespace trunnion::surfacing::detail
