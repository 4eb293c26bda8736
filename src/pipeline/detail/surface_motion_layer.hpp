#pragma once

#include <cstddef>
#include <vector>

#include "trunnion/base/result.hpp"
#include "trunnion/surfacing/plan_surface.hpp"

namespace trunnion::pipeline {

using SurfacePlaces = std::vector<geometry::SurfacePlace>;

/// The passes of Lin & Koren's rule over a whole face, one after the other, from the border of least v on. What it is
/// made from must outlive it.
class SurfacePassLayer {
  public:
    SurfacePassLayer(const surfacing::Face& face, const surfacing::Cutter& cutter,
                     const surfacing::SurfaceOptions& options)
        : face_(face), cutter_(cutter), options_(options) {}

    /// The parts of the next pass within the face, in the direction of u; none behind the border of largest v. Errors:
    /// INTP0003 no normal, SURF0203 the surface rises above the tool's rim.
    Result<std::vector<SurfacePlaces>> next();

    /// Of the face that lies behind the last pass, by v.
    double share() const;

  private:
    /// A place with its shape, and the unit direction across the pass, towards growing v.
    struct Station {
        geometry::SurfaceShape shape;
        Eigen::Vector3d across;
    };

    SurfacePlaces along_border(double v) const;
    Result<Station> station(std::size_t i) const;
    Result<void> move_on();
    SurfacePlaces at_even_u(const SurfacePlaces& moved) const;
    std::vector<SurfacePlaces> parts_within(double border, double shortest_u) const;

    const surfacing::Face& face_;
    const surfacing::Cutter& cutter_;
    const surfacing::SurfaceOptions& options_;
    SurfacePlaces front_;
    bool at_end_ = false;
};

}  // namespace trunnion::pipeline
