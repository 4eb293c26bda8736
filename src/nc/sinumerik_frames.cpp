#include "detail/sinumerik_frames.hpp"

#include <cmath>

#include <Eigen/Geometry>

namespace trunnion::nc::sinumerik {

namespace {

constexpr double rounding = 1e-15;   ///< an entry so small is 0: cos 90° in floating point
constexpr double distortion = 1e-9;  ///< relative: factors that differ less are one scale

Eigen::Matrix3d cleaned(const Eigen::Matrix3d& m) {
    return m.unaryExpr([](double entry) { return std::abs(entry) < rounding ? 0.0 : entry; });
}

bool alike(double a, double b) {
    return std::abs(a - b) <= distortion * std::max(std::abs(a), std::abs(b));
}

}  // namespace

CoordinateFrame::CoordinateFrame(const Eigen::Matrix3d& linear, const Eigen::Vector3d& origin_mm)
    : linear_(cleaned(linear)), inverse_(cleaned(linear_.inverse())), origin_mm_(origin_mm) {
    identity_ = linear_ == Eigen::Matrix3d::Identity() && origin_mm_.isZero(0);
}

CoordinateFrame CoordinateFrame::turned(int axis, double angle_rad) {
    return {Eigen::AngleAxisd(angle_rad, Eigen::Vector3d::Unit(axis)).toRotationMatrix(), Eigen::Vector3d::Zero()};
}

CoordinateFrame CoordinateFrame::turned_rpy(const Eigen::Vector3d& angles_rad) {
    return turned(2, angles_rad.z()).with(turned(1, angles_rad.y())).with(turned(0, angles_rad.x()));
}

CoordinateFrame CoordinateFrame::with(const CoordinateFrame& inner) const {
    if (identity_) return inner;
    return {linear_ * inner.linear_, origin_mm_ + linear_ * inner.origin_mm_};
}

std::optional<Eigen::Vector3d> CoordinateFrame::outward(const Eigen::Vector3d& programmed) const {
    if (identity_) return programmed;
    Eigen::Vector3d outer;
    for (Eigen::Index row = 0; row < 3; ++row) {
        int known = 0, unknown = 0;
        double sum = origin_mm_[row];
        for (Eigen::Index column = 0; column < 3; ++column) {
            if (linear_(row, column) == 0) continue;
            ++(std::isnan(programmed[column]) ? unknown : known);
            sum += linear_(row, column) * programmed[column];
        }
        if (known > 0 && unknown > 0) return {};
        outer[row] = sum;
    }
    return outer;
}

Eigen::Vector3d CoordinateFrame::inward(const Eigen::Vector3d& outer) const {
    if (identity_) return outer;
    Eigen::Vector3d programmed = Eigen::Vector3d::Zero();
    for (Eigen::Index row = 0; row < 3; ++row)
        for (Eigen::Index column = 0; column < 3; ++column)
            if (inverse_(row, column) != 0)
                programmed[row] += inverse_(row, column) * (outer[column] - origin_mm_[column]);
    return programmed;
}

std::optional<Eigen::Vector3d> CoordinateFrame::tool_axis(const Eigen::Vector3d& programmed) const {
    const double scale = linear_.col(0).norm();
    const bool similar = alike(scale, linear_.col(1).norm()) && alike(scale, linear_.col(2).norm()) &&
                         (linear_.transpose() * linear_).isApprox(Eigen::Matrix3d::Identity() * (scale * scale), 1e-9);
    if (!similar) return {};
    return (linear_ * programmed).normalized();
}

/// The plane's first and second axes are turned into each other by the angle, inside as outside: a mirror turns the
/// normal, and the angle stays.
std::optional<program::Arc> CoordinateFrame::arc(const program::Arc& programmed, int normal_axis) const {
    if (identity_) return programmed;
    const Eigen::Vector3d first = linear_ * Eigen::Vector3d::Unit((normal_axis + 1) % 3);
    const Eigen::Vector3d second = linear_ * Eigen::Vector3d::Unit((normal_axis + 2) % 3);
    const Eigen::Vector3d across = linear_ * Eigen::Vector3d::Unit(normal_axis);
    const Eigen::Vector3d normal = first.cross(second).normalized();
    if (!alike(first.norm(), second.norm()) || std::abs(first.dot(second)) > distortion * first.squaredNorm() ||
        across.cross(normal).norm() > distortion * across.norm())
        return {};
    return program::Arc{origin_mm_ + linear_ * programmed.centre_mm, normal, programmed.angle_rad};
}

}  // namespace trunnion::nc::sinumerik
