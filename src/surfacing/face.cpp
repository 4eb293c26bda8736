#include "trunnion/surfacing/face.hpp"

#include <utility>

namespace trunnion::surfacing {

Face whole_face(geometry::BsplineSurface surface, geometry::Side side) {
    const double u0 = surface.u().begin(), u1 = surface.u().end(), v0 = surface.v().begin(), v1 = surface.v().end();
    return {.surface = std::move(surface), .side = side, .loops = {{{u0, v0}, {u1, v0}, {u1, v1}, {u0, v1}}}};
}

bool contains(const Face& face, const geometry::SurfacePlace& place) noexcept {
    bool inside = false;
    for (const Loop& loop : face.loops)
        for (std::size_t i = 0, before = loop.size() - 1; i < loop.size(); before = i++) {
            const Eigen::Vector2d &a = loop[before], &b = loop[i];
            if ((a.y() > place.v) == (b.y() > place.v)) continue;
            if (place.u < a.x() + (b.x() - a.x()) * (place.v - a.y()) / (b.y() - a.y())) inside = !inside;
        }
    return inside;
}

ParameterBox parameter_box(const Face& face) {
    ParameterBox box{face.loops.front().front(), face.loops.front().front()};
    for (const Loop& loop : face.loops)
        for (const Eigen::Vector2d& p : loop) {
            box.low = box.low.cwiseMin(p);
            box.high = box.high.cwiseMax(p);
        }
    return box;
}

}  // namespace trunnion::surfacing
