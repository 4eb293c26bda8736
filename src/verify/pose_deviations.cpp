#include "detail/pose_deviations.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace trunnion::verify {

namespace {

constexpr std::ptrdiff_t least_stops = 40, most_stops = 4000;  // looked at to either side

}  // namespace

double Allowed::used_by(const Distance& distance) const {
    return std::max({distance.tip_mm / tip_mm, distance.height_mm / height_mm, distance.angle_rad / angle_rad});
}

Distance distance_between(const Joint6& a, const Joint6& b, const ToolHeights& tool, double flank_mm) {
    const Joint6 off = a - b;
    const Eigen::Vector3d axis = off.tail<3>() / flank_mm;
    const Eigen::Vector3d tip = off.head<3>() - tool.controlled_mm * axis;
    return {off.head<3>().norm(), (tip + off.tail<3>()).norm(), 2 * std::asin(std::min(1.0, axis.norm() / 2))};
}

PosePasses::PosePasses(const ProgrammedLine& line, const std::vector<Gauge>& rows, const std::vector<Place>& places,
                       double window_mm, const Allowed& allowed)
    : line_(line), rows_(rows), window_mm_(window_mm), allowed_(allowed) {
    double farthest = 0;
    for (std::size_t n = 0; n < rows.size(); ++n) {
        farthest = std::max(farthest, places[n].way_mm);
        const bool stands = n > 0 && rows[n].point_mm == rows[n - 1].point_mm && rows[n].axis == rows[n - 1].axis;
        if (stands)
            stops_.back().way_mm = farthest;
        else
            stops_.push_back({n, farthest});
    }
}

PosePasses::Pass PosePasses::at(std::size_t pose, const ProgrammedPose& programmed) const {
    const double way = line_.way_of(pose);
    const ToolHeights& tool = line_.tool_at(pose);
    const Joint6 point = joint_of(programmed.tip_mm, programmed.axis, tool, line_.flank_mm());
    const auto by_way = [](const Stop& stop, double x) { return stop.way_mm < x; };
    const auto count = static_cast<std::ptrdiff_t>(stops_.size());
    const auto find = [&](double x) {
        return std::lower_bound(stops_.begin(), stops_.end(), x, by_way) - stops_.begin();
    };
    const std::ptrdiff_t middle = find(way);
    const auto low = std::clamp(find(way - window_mm_), middle - most_stops, middle - least_stops);
    const auto high = std::clamp(find(way + window_mm_), middle + least_stops, middle + most_stops);
    const auto joint = [&](std::ptrdiff_t stop) {
        return joint_of(rows_[stops_[static_cast<std::size_t>(stop)].row], tool, line_.flank_mm());
    };
    double best2 = std::numeric_limits<double>::infinity(), least_used = std::numeric_limits<double>::infinity();
    Joint6 best = point;
    std::ptrdiff_t best_stop = 0;
    Pass kept;
    const std::ptrdiff_t last = std::min(high, count - 1);
    std::ptrdiff_t stop = std::clamp<std::ptrdiff_t>(low, 0, last);
    Joint6 begin = joint(stop);
    for (; stop <= last; ++stop) {
        const Joint6 end = joint(std::min(stop + 1, last));
        const Joint6 chord = end - begin;
        const double length2 = chord.squaredNorm();
        const double share = length2 > 0 ? std::clamp((point - begin).dot(chord) / length2, 0.0, 1.0) : 0.0;
        const Joint6 foot = begin + share * chord;
        const double off2 = (point - foot).squaredNorm();
        if (off2 < best2) best2 = off2, best = foot, best_stop = stop;
        if ((point - foot).head<3>().norm() < std::min(1.0, least_used) * allowed_.tip_mm) {
            const Distance distance = distance_between(foot, point, tool, line_.flank_mm());
            const double used = allowed_.used_by(distance);
            if (used < least_used) least_used = used, kept = {distance, stops_[static_cast<std::size_t>(stop)].row};
        }
        begin = end;
    }
    const Distance nearest = distance_between(best, point, tool, line_.flank_mm());
    if (allowed_.used_by(nearest) > 1 && least_used <= 1) return kept;
    return {nearest, stops_[static_cast<std::size_t>(best_stop)].row};
}

}  // namespace trunnion::verify
