#pragma once

#include <optional>
#include <vector>

#include "trunnion/base/result.hpp"

#include "detail/way.hpp"

namespace trunnion::surfacing::detail {

/// The surroundings of the region's faces in (u, v): ways go on some way beyond its borders, on the surfaces continued.
struct Field {
    std::vector<ParameterBox> boxes;  ///< one a face
    Place middle;                     ///< of the first face
    double spacing_mm = 1;            ///< of a way's places
    double longest_way_mm = 0;        ///< that any sensible way across the region has
    double face_box_mm2 = 0;          ///< area of the surfaces over the faces' boxes, not behind joints

    bool holds(const Place& place) const noexcept {
        const ParameterBox& box = boxes[static_cast<std::size_t>(place.chart)];
        return place.u >= box.low.x() && place.u <= box.high.x() && place.v >= box.low.y() && place.v <= box.high.y();
    }
};
/// Errors: SURF0205 no normal in the middle.
Result<Field> field_of(const Job& job);

/// The plane sections of one direction: points x with normal · x = offset.
struct Planes {
    Eigen::Vector3d normal;
    double offset_mm;
};

/// Moves along the surface until the point lies in the plane. Nothing where the surface runs along it.
std::optional<Place> onto_plane(const Job& job, const Planes& plane, Place place);

/// The way through a place in a tangent direction, to both sides until it leaves the field: straight on the surface (a
/// geodesic), or in a plane.
Way way_through(const Job& job, const Field& field, const Place& place, const Eigen::Vector3d& direction,
                const Planes* plane);

/// The way through the places to which a way's places moved, without loops, from border to border of the field. Nothing
/// where fewer than two places are left within the field.
std::optional<Way> way_of_moved(const Job& job, const Field& field, const Way& before,
                                const std::vector<std::optional<Place>>& moved);

/// The way of one constant parameter across the field.
Way parameter_way(const Job& job, const Field& field, bool along_u, double at);

}  // namespace trunnion::surfacing::detail
