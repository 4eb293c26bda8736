// What holds the speed down at each segment and joint, before speeding up and braking are looked at.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "trunnion/base/quantity.hpp"

#include "detail/block_profile.hpp"

namespace trunnion::controller {

using motion::Limit;
using motion::LimitKind;
using motion::ParameterId;
using program::FeedRule;

namespace {

constexpr double no_limit = 1e12;       // mm/s: nothing that moves is as fast
constexpr double shortest_mm = 1e-12;   // of a segment in the axes' space
constexpr double axis_moves_mm = 1e-7;  // less is rounding
constexpr double straight_sine = 1e-9;  // half the turn of a joint that counts as none

void lower(double& limit, Limit& cause, double value, Limit why) {
    if (!(value < limit)) return;
    limit = value;
    cause = why;
}

Limit of_axis(LimitKind kind, int axis) {
    return {kind, static_cast<std::int8_t>(axis)};
}

}  // namespace

void BlockPlanner::read_settings(const machine::Machine& machine, const motion::Controller& controller) {
    const auto value = [&](ParameterId id) { return controller[id].value; };
    axes_ = machine.axis_count;
    reference_radius_ = value(ParameterId::reference_radius);
    jerk_limited_ = controller.profile.way == motion::Profile::jerk_limited;
    for (int a = 0; a < axes_; ++a) {
        const machine::Axis& axis = machine.axes[a];
        const machine::AxisLimits& limits = run_->rapid ? axis.rapid : axis.feed;
        weight_[a] = axis.rotary ? reference_radius_ : 1;
        velocity_[a] = weight_[a] * limits.velocity * value(ParameterId::velocity_share) *
                       (run_->rapid ? value(ParameterId::rapid_share) : 1);
        acceleration_[a] = weight_[a] * limits.acceleration * value(ParameterId::acceleration_share);
        jerk_[a] = weight_[a] * limits.jerk * value(ParameterId::jerk_share);
        step_[a] = weight_[a] * value(axis.rotary ? ParameterId::rotary_velocity_step : ParameterId::velocity_step);
    }
    transition_ = controller.transition.way;
    stops_at_axis_set_ = controller.axis_set_change.way == motion::AxisSetChange::stop;
    rotary_in_feed_ = controller.feed_counts.way == motion::FeedCounts::tip_and_rotary;
    cycle_s_ = value(ParameterId::interpolator_cycle);
    preparation_s_ = value(ParameterId::block_preparation);
    buffer_ = static_cast<std::size_t>(std::max(1.0, value(ParameterId::block_buffer)));
    rounding_ = value(ParameterId::rounding_tolerance);
    centripetal_ = value(ParameterId::centripetal_share);
    jump_share_ = value(ParameterId::curvature_jump_share);
    settle_s_ = value(ParameterId::setpoint_filter) + value(ParameterId::in_position_time);
    look_ahead_blocks_ = value(ParameterId::look_ahead_blocks);
    look_ahead_mm_ = value(ParameterId::look_ahead_distance);
}

/// Eq. 5-8 of Lavernhe 2006, with |ΔP|: the segment's share of each axis decides what it allows along the path.
void BlockPlanner::limit_by_axes(Piece& piece) const {
    piece.acceleration = piece.jerk = no_limit;
    for (int a = 0; a < axes_; ++a) {
        const double share = std::abs(piece.direction[a]);
        if (share < straight_sine) continue;
        lower(piece.speed_limit, piece.limit, velocity_[a] / share, of_axis(LimitKind::velocity, a));
        lower(piece.acceleration, piece.acceleration_limit, acceleration_[a] / share,
              of_axis(LimitKind::acceleration, a));
        lower(piece.jerk, piece.jerk_limit, jerk_[a] / share, of_axis(LimitKind::jerk, a));
    }
}

/// Eq. 4. A pure rotation has no way of the tip: F counts as deg/min.
void BlockPlanner::limit_by_feed(const Segment& segment, Piece& piece) const {
    piece.speed_limit = no_limit;
    if (run_->rapid) return;
    const path::Feed& feed = run_->blocks[segment.block].feed;
    double time = 0;
    switch (feed.rule) {
        case FeedRule::none:
            return;
        case FeedRule::tip_speed: {
            const double rotary = segment.rotary_rad * reference_radius_;
            if (rotary_in_feed_)
                time = std::hypot(segment.way_mm, rotary) / feed.value;
            else if (segment.way_mm > axis_moves_mm * segment.share)
                time = segment.way_mm / feed.value;
            else
                time = segment.rotary_rad / degree / feed.value;
            break;
        }
        case FeedRule::rotary_rate:
            time = segment.rotary_rad / feed.value;
            break;
        case FeedRule::block_time:
            time = segment.share * feed.value;
            break;
    }
    if (time > 0) piece.speed_limit = std::min(no_limit, piece.length / time);
}

void BlockPlanner::measure() {
    const auto& stations = geometry_->stations;
    pieces_.resize(geometry_->segments.size());
    for (std::size_t i = 0; i < pieces_.size(); ++i) {
        Piece piece;
        double sum = 0;
        for (int a = 0; a < axes_; ++a) {
            piece.direction[a] = weight_[a] * (stations[i + 1].axes[a] - stations[i].axes[a]);
            sum += piece.direction[a] * piece.direction[a];
        }
        piece.length = std::max(std::sqrt(sum), shortest_mm);
        for (int a = 0; a < axes_; ++a) piece.direction[a] /= piece.length;
        limit_by_feed(geometry_->segments[i], piece);
        limit_by_axes(piece);
        pieces_[i] = piece;
    }
}

void BlockPlanner::gather_blocks() {
    blocks_.assign(run_->blocks.size(), {});
    for (std::uint32_t i = 0; i < pieces_.size(); ++i) {
        Block& block = blocks_[geometry_->segments[i].block];
        if (block.behind == 0) block.first = i;
        block.behind = i + 1;
        block.length += pieces_[i].length;
        for (int a = 0; a < axes_; ++a) {
            const double way = pieces_[i].direction[a] * pieces_[i].length;
            block.chord[a] += way;
            if (std::abs(way) > axis_moves_mm) block.moving |= 1u << a;
        }
    }
}

/// Eq. 11: no block is shorter than the interpolator's cycle.
void BlockPlanner::limit_by_cycle() {
    for (Block& block : blocks_) {
        block.speed_limit = cycle_s_ > 0 ? block.length / cycle_s_ : no_limit;
        block.limit = LimitKind::block_time;
    }
}

/// Blocks in the buffer make up for each other: any of them in a row, together, take as long as their preparation.
void BlockPlanner::limit_by_preparation() {
    if (!(preparation_s_ > 0) || blocks_.size() <= buffer_) return;
    const std::size_t windows = blocks_.size() - buffer_ + 1;
    window_.assign(windows, 0);
    double sum = 0;
    for (std::size_t b = 0; b < blocks_.size(); ++b) {
        sum += blocks_[b].length;
        if (b + 1 < buffer_) continue;
        window_[b + 1 - buffer_] = sum / (static_cast<double>(buffer_) * preparation_s_);
        sum -= blocks_[b + 1 - buffer_].length;
    }
    // The least window that a block lies in, by a queue of windows whose values ascend.
    window_queue_.clear();
    std::size_t head = 0;
    for (std::size_t b = 0; b < blocks_.size(); ++b) {
        if (b < windows) {
            while (window_queue_.size() > head && window_[window_queue_.back()] >= window_[b]) window_queue_.pop_back();
            window_queue_.push_back(b);
        }
        while (window_queue_[head] + buffer_ <= b) ++head;
        const double least = window_[window_queue_[head]];
        if (least >= blocks_[b].speed_limit) continue;
        blocks_[b].speed_limit = least;
        blocks_[b].limit = LimitKind::preparation;
    }
}

/// The arc that joins two straight ways, Eq. 10, with its ends on the nearer halves of both: the radius times the
/// cotangent of half the corner's angle is at most half the shorter one. Every axis stays within its centripetal share
/// wherever on the arc it is highest. `tolerance` infinite: as round as the lengths allow. Inside a block, where chords
/// stand for a curve, its radius is that of the mean of both lengths.
void BlockPlanner::limit_curve(double length, const Piece& before, const Piece& after, double tolerance, LimitKind kind,
                               Joint& joint) const {
    std::array<double, machine::max_axes> change{};
    double difference = 0, sum = 0;
    for (int a = 0; a < axes_; ++a) {
        change[a] = after.direction[a] - before.direction[a];
        difference += change[a] * change[a];
        sum += (after.direction[a] + before.direction[a]) * (after.direction[a] + before.direction[a]);
    }
    const double sine = 0.5 * std::sqrt(difference), cosine = 0.5 * std::sqrt(sum);  // of half the turn
    if (sine < straight_sine) return;
    joint.bends = true;
    double radius = 0.5 * length * cosine / sine;
    if (std::isfinite(tolerance)) radius = std::min(radius, tolerance * cosine * (1 + cosine) / (sine * sine));
    const double whole_cosine = 1 - 2 * sine * sine, whole_sine = 2 * sine * std::max(cosine, straight_sine);
    for (int a = 0; a < axes_; ++a) {
        const double at_begin = (after.direction[a] - whole_cosine * before.direction[a]) / whole_sine;
        const double at_end = (whole_cosine * after.direction[a] - before.direction[a]) / whole_sine;
        const double across = std::max({std::abs(change[a]) / (2 * sine), std::abs(at_begin), std::abs(at_end)});
        if (across < straight_sine) continue;
        const double allowed = acceleration_[a] * (centripetal_ > 0 ? centripetal_ : 1);
        const Limit cause = kind == LimitKind::curvature ? of_axis(kind, a) : Limit{kind};
        lower(joint.speed_limit, joint.limit, std::sqrt(radius * allowed / across), cause);
    }
}

void BlockPlanner::limit_step(const Piece& before, const Piece& after, Joint& joint) const {
    for (int a = 0; a < axes_; ++a) {
        const double change = std::abs(after.direction[a] - before.direction[a]);
        if (change > straight_sine) lower(joint.speed_limit, joint.limit, step_[a] / change, {LimitKind::transition});
    }
}

void BlockPlanner::limit_transition(std::size_t joint) {
    const Piece &before = pieces_[joint - 1], &after = pieces_[joint];
    const Block& left = blocks_[geometry_->segments[joint - 1].block];
    const Block& right = blocks_[geometry_->segments[joint].block];
    Joint& at = joints_[joint];
    const auto stop = [&](LimitKind kind) {
        at.speed_limit = 0;
        at.limit = {kind};
        at.stop = true;
    };
    const double shorter = std::min(left.length, right.length);
    const bool arc = transition_ == motion::Transition::rounding_arc;
    limit_curve(shorter, before, after, arc ? rounding_ : std::numeric_limits<double>::infinity(),
                LimitKind::transition, at);
    if (transition_ == motion::Transition::velocity_step) limit_step(before, after, at);
    if (transition_ == motion::Transition::exact_stop) stop(LimitKind::stop);
    if (stops_at_axis_set_ && left.moving != right.moving) stop(LimitKind::axis_set);
}

void BlockPlanner::limit_joints() {
    joints_.assign(pieces_.size() + 1, {.speed_limit = no_limit});
    for (Joint* end : {&joints_.front(), &joints_.back()}) *end = {.limit = {LimitKind::stop}, .stop = true};
    for (std::size_t i = 1; i < pieces_.size(); ++i) {
        if (geometry_->segments[i - 1].block != geometry_->segments[i].block)
            limit_transition(i);
        else
            limit_curve(0.5 * (pieces_[i - 1].length + pieces_[i].length), pieces_[i - 1], pieces_[i],
                        std::numeric_limits<double>::infinity(), LimitKind::curvature, joints_[i]);
    }
    if (std::isfinite(jump_share_)) limit_curvature_jumps();
}

/// Where curvature jumps so does the acceleration across the path. Blocks count as their chords: curvature is that of
/// the polygon, whatever lies between its corners.
void BlockPlanner::limit_curvature_jumps() {
    std::array<double, machine::max_axes> last{};
    const auto limit_at = [&](const Block& block, double jump, int axis) {
        if (block.first == 0 || jump < straight_sine) return;
        Joint& joint = joints_[block.first];
        lower(joint.speed_limit, joint.limit, std::sqrt(jump_share_ * acceleration_[axis] / jump),
              of_axis(LimitKind::curvature_jump, axis));
    };
    for (std::size_t b = 1; b < blocks_.size(); ++b) {
        const double length = 0.5 * (blocks_[b - 1].length + blocks_[b].length);
        for (int a = 0; a < axes_; ++a) {
            const double curvature =
                (blocks_[b].chord[a] / blocks_[b].length - blocks_[b - 1].chord[a] / blocks_[b - 1].length) / length;
            const double jump = std::abs(curvature - last[a]);
            last[a] = curvature;
            limit_at(blocks_[b], jump, a);
            limit_at(blocks_[b - 1], jump, a);
        }
    }
}

/// Eq. 9, its meaning explicit: the share is the centripetal one; next to a curve or corner the rest is left for the
/// speed, whether or not the control stops there.
void BlockPlanner::share_acceleration() {
    ramps_.clear();
    for (std::size_t i = 0; i < pieces_.size(); ++i) {
        Piece& piece = pieces_[i];
        if (centripetal_ > 0 && (joints_[i].bends || joints_[i + 1].bends)) piece.acceleration *= 1 - centripetal_;
        ramps_.emplace_back(piece.acceleration, jerk_limited_ ? piece.jerk : std::numeric_limits<double>::infinity());
    }
}

/// At the start of a block the control has planned with what lies up to `look_ahead_blocks` behind the block before it
/// and comes to rest within that, should nothing more be told.
void BlockPlanner::limit_by_look_ahead() {
    if (!std::isfinite(look_ahead_blocks_) && !std::isfinite(look_ahead_mm_)) return;
    const std::size_t count = pieces_.size();
    sums_a_.assign(count + 1, 0);
    sums_j_.assign(count + 1, 0);
    sums_s_.assign(count + 1, 0);
    for (std::size_t i = 0; i < count; ++i) {
        sums_a_[i + 1] = sums_a_[i] + 2 * pieces_[i].acceleration * pieces_[i].length;
        sums_j_[i + 1] = sums_j_[i] + std::sqrt(pieces_[i].jerk) * pieces_[i].length;
        sums_s_[i + 1] = sums_s_[i] + pieces_[i].length;
    }
    std::size_t horizon = 0;
    for (std::size_t i = 1; i < count; ++i) {
        const std::size_t block = geometry_->segments[i - 1].block;
        if (geometry_->segments[i].block == block) continue;
        const double last = static_cast<double>(block) + look_ahead_blocks_;
        const std::size_t by_blocks =
            last < static_cast<double>(blocks_.size() - 1) ? blocks_[static_cast<std::size_t>(last)].behind : count;
        const double end = sums_s_[i] + look_ahead_mm_;
        while (horizon < count && sums_s_[horizon + 1] <= end) ++horizon;
        double accelerations = sums_a_[by_blocks], root_jerks = sums_j_[by_blocks];
        if (horizon < by_blocks) {
            const double part = end - sums_s_[horizon];
            accelerations = sums_a_[horizon] + 2 * pieces_[horizon].acceleration * part;
            root_jerks = sums_j_[horizon] + std::sqrt(pieces_[horizon].jerk) * part;
        } else if (by_blocks == count) {
            continue;
        }
        const double speed =
            stopping_speed(accelerations - sums_a_[i],
                           jerk_limited_ ? root_jerks - sums_j_[i] : std::numeric_limits<double>::infinity());
        lower(joints_[i].speed_limit, joints_[i].limit, speed, {LimitKind::look_ahead});
    }
}

}  // namespace trunnion::controller
