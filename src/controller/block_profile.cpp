#include "detail/block_profile.hpp"

#include <algorithm>
#include <cmath>

namespace trunnion::controller {

using motion::Limit;
using motion::LimitKind;

void BlockPlanner::pass_forward() {
    for (std::size_t i = 0; i < pieces_.size(); ++i) {
        Joint& next = joints_[i + 1];
        const double most = std::min({next.speed_limit, pieces_[i].speed_limit,
                                      i + 1 < pieces_.size() ? pieces_[i + 1].speed_limit : next.speed_limit});
        const Ramp& ramp = ramps_[i];
        next.speed = most;
        const double from = ramp.distance(joints_[i].speed) + pieces_[i].length;
        if (ramp.distance(most) > from) next.speed = std::min(most, ramp.speed(from));
    }
}

void BlockPlanner::pass_backward() {
    for (std::size_t i = pieces_.size(); i-- > 0;) {
        const Ramp& ramp = ramps_[i];
        const double from = ramp.distance(joints_[i + 1].speed) + pieces_[i].length;
        double& speed = joints_[i].speed;
        if (ramp.distance(speed) > from) speed = std::min(speed, ramp.speed(from));
    }
}

/// What holds the speed down on a piece whose highest speed is `peak`.
Limit BlockPlanner::limit_of(std::size_t i, double peak) const {
    constexpr double reached = 1 - 1e-9, near_peak = 0.8;  // between limiting joints it hardly gets any faster
    if (peak >= reached * pieces_[i].speed_limit) return pieces_[i].limit;
    for (const std::size_t k : {i, i + 1}) {
        const Joint& joint = joints_[k];
        if (joint.speed >= reached * joint.speed_limit && joint.speed >= near_peak * peak) return joint.limit;
    }
    return jerk_limited_ && ramps_[i].is_jerk(peak) ? pieces_[i].jerk_limit : pieces_[i].acceleration_limit;
}

Limit BlockPlanner::limit_at(std::size_t joint, Limit otherwise) const {
    const Joint& at = joints_[joint];
    return at.speed >= at.speed_limit * (1 - 1e-9) ? at.limit : otherwise;
}

/// A move from rest to rest that never reaches a limit of its speed takes as long as with ramps of constant jerk.
void BlockPlanner::lengthen_rest_to_rest(std::vector<SegmentSpeed>* speeds, std::size_t first, std::size_t behind,
                                         double& sum) {
    double length = 0, accelerations = 0, root_jerks = 0;
    for (std::size_t i = first; i < behind; ++i) {
        length += pieces_[i].length;
        accelerations += pieces_[i].acceleration * pieces_[i].length;  // of half the way
        root_jerks += 0.5 * std::sqrt(pieces_[i].jerk) * pieces_[i].length;
    }
    const double least = 2 * length / stopping_speed(accelerations, root_jerks);
    if (!jerk_limited_ || !(least > sum) || !(sum > 0)) return;
    const double stretch = least / sum;
    sum = least;
    if (!speeds) return;
    for (std::size_t i = first; i < behind; ++i) {
        SegmentSpeed& s = (*speeds)[i];
        for (double* time : {&s.rise_s, &s.cruise_s, &s.fall_s}) *time *= stretch;
        for (double* speed : {&s.from_mm_s, &s.peak_mm_s, &s.to_mm_s}) *speed /= stretch;
    }
}

double BlockPlanner::time_of(std::vector<SegmentSpeed>* speeds) {
    double total = 0, section = 0;
    std::size_t first = 0;
    if (speeds) speeds->resize(pieces_.size());
    for (std::size_t i = 0; i < pieces_.size(); ++i) {
        const Piece& piece = pieces_[i];
        const Ramp& ramp = ramps_[i];
        const double from = joints_[i].speed, to = joints_[i + 1].speed;
        const double at_from = ramp.distance(from), at_to = ramp.distance(to);
        double peak = ramp.speed(0.5 * (piece.length + at_from + at_to));
        peak = std::max({std::min(peak, piece.speed_limit), from, to});
        const double at_peak = ramp.distance(peak), time_of_peak = ramp.time(peak);
        SegmentSpeed s;
        s.rise_mm = at_peak - at_from;
        s.fall_mm = at_peak - at_to;
        s.rise_s = time_of_peak - ramp.time(from);
        s.fall_s = time_of_peak - ramp.time(to);
        if (peak >= piece.speed_limit) s.cruise_s = std::max(0.0, piece.length - s.rise_mm - s.fall_mm) / peak;
        section += s.duration_s();
        if (speeds) {
            s.length_mm = piece.length;
            for (int a = 0; a < axes_; ++a) s.direction[a] = piece.direction[a] / weight_[a];
            s.from_mm_s = from;
            s.peak_mm_s = peak;
            s.to_mm_s = to;
            s.limit = limit_of(i, peak);
            s.from_limit = limit_at(i, s.limit);
            s.to_limit = limit_at(i + 1, s.limit);
            if (s.rise_s + s.fall_s > 0) {
                s.acceleration_mm_s2 = ramp.acceleration(peak);
                s.jerk_mm_s3 = piece.jerk;
            }
            if (!jerk_limited_) s.jerk_mm_s3 = std::numeric_limits<double>::quiet_NaN();
            (*speeds)[i] = s;
        }
        if (to > 0) continue;
        lengthen_rest_to_rest(speeds, first, i + 1, section);
        total += section + settle_s_;
        if (speeds) (*speeds)[i].settle_s = settle_s_;
        section = 0;
        first = i + 1;
    }
    return total;
}

double BlockPlanner::plan(const path::Run& run, const RunGeometry& geometry, const machine::Machine& machine,
                          const motion::Controller& controller, std::vector<SegmentSpeed>* speeds) {
    run_ = &run;
    geometry_ = &geometry;
    machine_ = &machine;
    read_settings(machine, controller);
    measure();
    gather_blocks();
    limit_by_cycle();
    limit_by_preparation();
    for (std::size_t i = 0; i < pieces_.size(); ++i) {
        const Block& block = blocks_[geometry.segments[i].block];
        if (block.speed_limit < pieces_[i].speed_limit) {
            pieces_[i].speed_limit = block.speed_limit;
            pieces_[i].limit = {block.limit};
        }
    }
    limit_joints();
    share_acceleration();
    limit_by_look_ahead();
    pass_forward();
    pass_backward();
    return time_of(speeds);
}

}  // namespace trunnion::controller
