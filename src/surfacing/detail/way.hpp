#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "trunnion/surfacing/cutter.hpp"
#include "trunnion/surfacing/plan_surface.hpp"

namespace trunnion::surfacing::detail {

/// A smooth curve on a surface: through places, over s, the length of their polyline in space. In between cubic in (u,
/// v).
class Way {
  public:
    Way() = default;
    Way(const geometry::BsplineSurface& surface, std::vector<geometry::SurfacePlace> places);

    const std::vector<geometry::SurfacePlace>& places() const noexcept { return places_; }
    const std::vector<double>& lengths() const noexcept { return lengths_; }
    double length() const noexcept { return lengths_.empty() ? 0 : lengths_.back(); }

    geometry::SurfacePlace place(double s) const noexcept;
    Eigen::Vector2d slope(double s) const noexcept;  ///< (du/ds, dv/ds)

    /// s of the point of the polyline that is nearest to a place of the surface and as near on the surface as it is in
    /// space: not beyond a seam, nor on the other side of a thin edge. Nothing where there is none.
    std::optional<double> nearest(const geometry::SurfacePlace& from,
                                  const geometry::SurfaceShape& shape) const noexcept;

    /// Distance of a point from that polyline, mm.
    double distance_mm(const Eigen::Vector3d& point) const noexcept;

    /// The same curve through places at equal distances of about `spacing`, and closer where the surface turns more
    /// than 0.2 rad from one to the next, as round an edge that is sharper than the spacing. One place stays one.
    Way resampled(const geometry::BsplineSurface& surface, double spacing) const;

  private:
    struct Piece;
    struct Foot {
        double s, squared;
    };
    /// A ball round some steps of the polyline, so that feet are looked for near a point alone.
    struct Stretch {
        Eigen::Vector3d middle;
        double radius;
        std::size_t begin, end;  ///< of its steps
    };
    /// Where a way is looked at, and the surface's normal there.
    struct End {
        double s;
        std::optional<Eigen::Vector3d> normal;
    };
    void close(const geometry::BsplineSurface& surface, const End& from, const End& to, int depth,
               std::vector<geometry::SurfacePlace>& out) const;
    void gather();
    template <class Accept>
    Foot foot_of(const Eigen::Vector3d& point, const Accept& accept) const noexcept;
    Piece piece_at(double s) const noexcept;
    Eigen::Vector2d slope_at_node(std::size_t i) const noexcept;
    std::vector<geometry::SurfacePlace> places_;
    std::vector<Eigen::Vector3d> points_;
    std::vector<double> lengths_;
    std::vector<Stretch> stretches_;
};

/// A tool on a way.
struct Station {
    geometry::SurfacePlace place;
    geometry::SurfaceShape shape;
    Eigen::Vector3d along, across;  ///< unit: the way's direction, and normal × along
    CutterPose pose;
};

/// What a plan is about.
struct Job {
    const Face& face;
    const Cutter& cutter;
    const SurfaceOptions& options;
    ParameterBox box = parameter_box(face);

    std::optional<geometry::SurfaceShape> shape(const geometry::SurfacePlace& place) const noexcept {
        return geometry::shape_at(face.surface, place, face.side);
    }
    /// `backwards`: the tool moves against the way's direction. Nothing where the surface has no normal.
    std::optional<Station> station(const Way& way, double s, bool backwards) const noexcept;
    /// Ridges are planned that high.
    double ridge_mm() const noexcept { return options.scallop_mm - options.chord_tolerance_mm; }
    bool backwards(int index) const noexcept { return options.zigzag && index % 2 != 0; }
};

}  // namespace trunnion::surfacing::detail
