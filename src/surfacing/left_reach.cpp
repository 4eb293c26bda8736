#include "detail/left_reach.hpp"

#include <algorithm>
#include <limits>

#include <Eigen/Geometry>

#include "trunnion/surfacing/path_interval.hpp"

namespace trunnion::surfacing::detail {

namespace {

double distance_mm(const Pass& pass, const Eigen::Vector3d& point) {
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k + 1 < pass.contacts.size(); ++k) {
        const Eigen::Vector3d from = pass.contacts[k].point_mm, way = pass.contacts[k + 1].point_mm - from;
        const double length = way.squaredNorm();
        const double w = length > 0 ? std::clamp((point - from).dot(way) / length, 0.0, 1.0) : 0;
        least = std::min(least, (from + w * way - point).norm());
    }
    return least;
}

}  // namespace

LeftReach::LeftReach(std::span<const Pass> planned, std::span<const Face> faces, const Cutter& cutter,
                     double scallop_mm)
    : faces_(faces), cutter_(cutter), scallop_mm_(scallop_mm) {
    for (const Pass& pass : planned)
        if (pass.index >= 0) by_index_[pass.index].push_back(&pass);
}

double LeftReach::between_mm(const Contact& from, const Contact& to, int index) const {
    const double diameter = 2 * cutter_.radius_mm();
    double reach = 0;
    if (index >= 0)
        reach = std::max(to_passes_beside_mm(from.point_mm, index), to_passes_beside_mm(to.point_mm, index));
    else
        reach = std::max(width_of_cut_mm(from, to), to_any_pass_mm(from.point_mm));
    return std::min(reach > 0 ? reach : width_of_cut_mm(from, to), diameter);
}

/// 0 without any.
double LeftReach::to_passes_beside_mm(const Eigen::Vector3d& point, int index) const {
    double farther = 0;
    for (const int beside : {index - 1, index + 1}) {
        const auto passes = by_index_.find(beside);
        if (passes == by_index_.end()) continue;
        double least = std::numeric_limits<double>::infinity();
        for (const Pass* pass : passes->second) least = std::min(least, distance_mm(*pass, point));
        farther = std::max(farther, least);
    }
    return farther;
}

/// 0 without any.
double LeftReach::to_any_pass_mm(const Eigen::Vector3d& point) const {
    double least = std::numeric_limits<double>::infinity();
    for (const auto& [index, passes] : by_index_)
        for (const Pass* pass : passes) least = std::min(least, distance_mm(*pass, point));
    return by_index_.empty() ? 0 : least;
}

double LeftReach::width_of_cut_mm(const Contact& from, const Contact& to) const {
    const Face& face = faces_[static_cast<std::size_t>(from.face)];
    const double least = 0.1 * cutter_.radius_mm();
    const auto shape = shape_at(face.surface, from.place, face.side);
    const Eigen::Vector3d across = from.normal.cross(to.point_mm - from.point_mm);
    if (!shape || !(across.norm() > 0)) return least;
    const Eigen::Vector2d direction = shape->components(across).normalized();
    return std::max(least, path_interval_mm(cutter_, *shape, from.pose.axis, direction, scallop_mm_));
}

}  // namespace trunnion::surfacing::detail
