#include "detail/programmed_distance.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace trunnion::report::detail {

ProgrammedDistance::ProgrammedDistance(std::vector<verify::ProgrammedPose> poses) : poses_(std::move(poses)) {}

double ProgrammedDistance::to_segment(std::size_t segment, const Eigen::Vector3d& point, double height_mm) const {
    const auto controlled = [height_mm](const verify::ProgrammedPose& pose) {
        return Eigen::Vector3d(pose.tip_mm + height_mm * pose.axis);
    };
    const Eigen::Vector3d from = controlled(poses_[segment - 1]), way = controlled(poses_[segment]) - from;
    const double square = way.squaredNorm();
    const double share = square > 0 ? std::clamp(way.dot(point - from) / square, 0.0, 1.0) : 0;
    return (point - from - share * way).norm();
}

/// Forwards to the next segment of the line, where one is near.
void ProgrammedDistance::go_to_line(std::int32_t line) {
    constexpr std::size_t far = 100'000;
    if (poses_[segment_].line == line) return;
    const std::size_t end = std::min(poses_.size(), segment_ + far);
    for (std::size_t k = segment_ + 1; k < end; ++k)
        if (poses_[k].line == line) {
            segment_ = k;
            return;
        }
}

double ProgrammedDistance::at(const Eigen::Vector3d& tip_mm, const Eigen::Vector3d& axis, std::int32_t line,
                              double controlled_height_mm) {
    if (poses_.size() < 2) return std::numeric_limits<double>::quiet_NaN();
    constexpr std::size_t back = 3, ahead = 8;
    constexpr int most_steps = 64;
    go_to_line(line);
    const Eigen::Vector3d point = tip_mm + controlled_height_mm * axis;
    double nearest = std::numeric_limits<double>::infinity();
    for (int step = 0; step < most_steps; ++step) {
        std::size_t best = segment_;
        nearest = to_segment(segment_, point, controlled_height_mm);
        const std::size_t from = segment_ > back ? segment_ - back : 1, to = std::min(poses_.size(), segment_ + ahead);
        for (std::size_t k = from; k < to; ++k) {
            const double distance = to_segment(k, point, controlled_height_mm);
            if (distance < nearest || (distance == nearest && poses_[k].line == line && poses_[best].line != line)) {
                nearest = distance;
                best = k;
            }
        }
        if (best == segment_) break;
        segment_ = best;
    }
    return nearest;
}

}  // namespace trunnion::report::detail
