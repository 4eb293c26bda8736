#include "trunnion/path/run.hpp"

#include <algorithm>
#include <cmath>

namespace trunnion::path {

namespace {

constexpr double least_lever = 0.1;  // a rotary word that leaves the pose unchanged still has a length

double turn_of_axes(const Run& run, const PathCoordinates& from, const PathCoordinates& to) {
    const int nearest = run.kinematics ? run.kinematics->rotary_nearest_workpiece() : -1;
    const bool has_lever = run.kinematics && run.kinematics->rotary_count() == 2;
    machine::RotaryPosition middle{};
    for (std::size_t a = 0; a < middle.size(); ++a) middle[a] = 0.5 * (from.orientation[a] + to.orientation[a]);
    double sum = 0;
    for (int a = 0; a < 3; ++a) {
        double d = to.orientation[a] - from.orientation[a];
        if (has_lever && a == nearest) d *= std::max(run.kinematics->lever(middle), least_lever);
        sum += d * d;
    }
    return std::sqrt(sum);
}

double turn_of_vectors(const PathCoordinates& from, const PathCoordinates& to) {
    const auto& a = from.orientation;
    const auto& b = to.orientation;
    const double cross = std::hypot(a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]);
    return std::atan2(cross, a[0] * b[0] + a[1] * b[1] + a[2] * b[2]);
}

}  // namespace

double turn_rad(const Run& run, const PathCoordinates& from, const PathCoordinates& to) {
    const bool vectors = run.law == OrientationLaw::vector && run.space == Space::workpiece;
    return vectors ? turn_of_vectors(from, to) : turn_of_axes(run, from, to);
}

geometry::Helix helix_between(const program::Arc& arc, const PathCoordinates& from, const PathCoordinates& to) {
    return {Eigen::Vector3d(from.position_mm.data()), Eigen::Vector3d(to.position_mm.data()), arc.centre_mm, arc.normal,
            arc.angle_rad};
}

double block_length_mm(const Run& run, const PathCoordinates& from, const PathCoordinates& to,
                       const program::Arc* arc) {
    const auto& a = from.position_mm;
    const auto& b = to.position_mm;
    const double way = arc ? helix_between(*arc, from, to).length() : std::hypot(b[0] - a[0], b[1] - a[1], b[2] - a[2]);
    return std::hypot(way, reference_height_mm * turn_rad(run, from, to));
}

}  // namespace trunnion::path
