#pragma once

#include <array>
#include <optional>

#include <Eigen/Core>

#include "detail/sinumerik_frames.hpp"

namespace trunnion::nc::heidenhain {

using sinumerik::CoordinateFrame;

/// Datum shift, mirror, rotation and scales (cycles 7, 8, 10, 11, 26), which act in this order whatever the order in
/// which they are said: the reader refuses those of which the order would matter.
struct Transformations {
    Eigen::Vector3d shift_mm = Eigen::Vector3d::Zero();
    std::array<bool, 3> mirrored{};
    double rotation_rad = 0;
    double scale = 1;
    Eigen::Vector3d axis_scales = Eigen::Vector3d::Ones();
    Eigen::Vector3d scale_centre_mm = Eigen::Vector3d::Zero();

    bool shifts() const { return !shift_mm.isZero(0); }
    bool mirrors() const { return mirrored[0] || mirrored[1] || mirrored[2]; }
    bool turns() const { return rotation_rad != 0; }
    bool scales() const { return scale != 1 || axis_scales != Eigen::Vector3d::Ones(); }
    bool is_identity() const { return !shifts() && !mirrors() && !turns() && !scales(); }
    CoordinateFrame frame() const;
};

/// The frames of a program: what was said before the plane was tilted, the tilted plane, what was said in it.
struct Frames {
    Transformations before, within;
    std::optional<CoordinateFrame> plane;

    Transformations& said_now() { return plane ? within : before; }
    CoordinateFrame in_force() const;
    /// The plane ends; what was said in it stays.
    void leave_plane();
};

}  // namespace trunnion::nc::heidenhain
