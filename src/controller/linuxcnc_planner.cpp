#include "detail/linuxcnc_planner.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "detail/linuxcnc_arc_blend.hpp"

namespace trunnion::controller::linuxcnc {

using motion::LimitKind;

namespace {

constexpr double reversal = 2 * std::numbers::pi / 180;  ///< of the sum of two unit tangents
constexpr double at_end = 1e-12;                         ///< mm, s
constexpr double pole_of_tolerance = 0.001;              ///< rad from straight on: no tolerance there
constexpr int enough_peaks = 4;                          ///< places at top speed behind which nothing is looked at

double clamped(double value, double most) {
    return std::clamp(value, -most, most);
}

}  // namespace

// ---- speeds

double Planner::highest_target(const Segment& segment) const {
    const double asked = std::min(segment.requested * settings_.max_feed_override, segment.top_speed);
    return segment.purely_rotary ? asked : std::min(asked, settings_.max_linear_velocity_mm_s);
}

/// The override of feeds or of rapids counts by what moved in the period before; a segment that another one blends into
/// is never faster than programmed.
double Planner::override_of(const Segment& segment) const {
    const double scale = rapid_reported_ ? settings_.rapid_override : settings_.feed_override;
    const bool blended_into = queue_.size() > 1 && &segment == &queue_[1] && queue_.front().blending;
    return blended_into ? std::min(scale, 1.0) : std::min(scale, settings_.max_feed_override);
}

double Planner::target(const Segment& segment) const {
    const double asked = std::min(segment.requested * override_of(segment), segment.top_speed);
    return segment.purely_rotary ? asked : std::min(asked, settings_.max_linear_velocity_mm_s);
}

Planner::Overlap Planner::overlap(const Segment& own, double own_target, const Segment& next,
                                  double next_target) const {
    const double own_acceleration = own.acceleration_along(), next_acceleration = next.acceleration_along();
    const auto reach = [](const Segment& segment, double acceleration, double target) {
        const double way = segment.finalised ? segment.length : segment.length / 2;
        return std::min(std::sqrt(acceleration * way), target);
    };
    const double own_reach = reach(own, own_acceleration, own_target);
    const double next_reach = reach(next, next_acceleration, next_target);
    const double time = std::min(std::min(own.length / own_reach, next.length / next_reach),
                                 std::max(own_reach / own_acceleration, next_reach / next_acceleration));
    Overlap out{std::min(own_reach, time * own_acceleration), std::min(next_reach, time * next_acceleration), 0};

    Vector3d arriving = own.end_direction(), leaving = next.start_direction();
    if (own.shape == Shape::arc) arriving = own.circle.tangent_in_plane(own.circle.angle());
    if (next.shape == Shape::arc)
        leaving = (next.overall_acceleration() * next.circle.tangent_in_plane(0) -
                   0.25 * next.requested * next.requested / next.circle.start_radius() * next.circle.outward(0))
                      .normalized();
    // The control reads a direction here that a blend does not have: any would do, a right angle is a fair one.
    const double cosine = next.shape == Shape::blend ? settings_.unset_direction_cosine : -arriving.dot(leaving);
    const double half = 0.5 * std::acos(std::clamp(cosine, -1.0, 1.0));
    if (own.tolerance_mm > 0 && std::cos(half) > std::cos(0.5 * std::numbers::pi - pole_of_tolerance)) {
        const double most = 2 * std::sqrt(own_acceleration * own.tolerance_mm / std::cos(half));
        out.own = std::min(out.own, most);
        out.next = std::min(out.next, most);
    }
    out.net = std::sin(half) * (out.own + out.next) / 2;
    return out;
}

// ---- adding a segment

void Planner::add(Segment segment) {
    segment.limit_top_speed(segment.length / settings_.servo_period_s, {LimitKind::block_time});
    segment.number = segment.horizon = ++added_;
    segment.end_hold = {LimitKind::look_ahead};
    nothing_follows_ = false;
    if (!queue_.empty()) {
        join(queue_.back(), segment);
        if (!queue_.empty()) finalise(queue_.back());
    }
    queue_.push_back(std::move(segment));
    look_back();
}

/// Decides how the last segment of the queue ends, now that the next one is known.
void Planner::join(Segment& last, Segment& added) {
    if (last.rapid != added.rapid) last.ending = Ending::stop;
    if (last.progress > 0.5 * last.length) {
        last.end_hold = {LimitKind::command_rate};
        last.horizon = 0;
        return;
    }
    last.horizon = 0;
    if (last.rotary || added.rotary || settings_.optimization_depth < 2 || last.ending == Ending::stop) return;
    if ((last.end_direction() + added.start_direction()).squaredNorm() < reversal * reversal) {
        last.ending = Ending::stop;
        return;
    }
    if (note_kink(last, added)) choose_joint(last, added);
}

/// Whether the joint has a kink to speak of; notes what speed and acceleration are left if it is passed.
bool Planner::note_kink(Segment& last, Segment& added) const {
    const double speed = std::min(std::min(last.requested * settings_.max_feed_override, last.top_speed),
                                  std::min(added.requested * settings_.max_feed_override, added.top_speed));
    const double change_rate = speed / settings_.servo_period_s + added.acceleration;
    const Vector3d turn = (added.start_direction() - last.end_direction()).cwiseAbs();
    double kink = turn.cwiseQuotient(limits_.linear_acceleration()).maxCoeff() * change_rate;
    if (last.shape == Shape::arc || added.shape == Shape::arc) kink *= 2;
    const double ratio = std::clamp(settings_.kink_ratio, 0.001, 0.7071);
    const double reduction = std::min(kink, ratio);
    last.kink_reduction = std::max(last.kink_reduction, reduction);
    added.kink_reduction_before = std::max(added.kink_reduction_before, reduction);
    last.kink_speed = kink < ratio ? speed : speed * ratio / kink;
    if (kink < ratio) last.ending = Ending::tangent;
    return kink >= ratio;
}

void Planner::choose_joint(Segment& last, Segment& added) {
    if (last.ending != Ending::parabolic) return;
    if (settings_.arc_blends && !last.finalised && !added.finalised && blend_by_arc(last, added)) return;
    take_best(last, added);
}

/// The faster of overlapping and passing the kink.
void Planner::take_best(Segment& last, Segment& added) const {
    const double parabolic = 0.5 * overlap(last, highest_target(last), added, highest_target(added)).net;
    if (parabolic >= last.kink_speed) {
        last.kink_speed = -1;
        last.kink_reduction = added.kink_reduction_before = 0;
        last.ending = Ending::parabolic;
        last.end_hold = {LimitKind::transition};
        added.joined_parabolically = true;
    } else {
        last.ending = Ending::tangent;
    }
}

/// Puts an arc between both where that is the fastest way. Where it is not, what was chosen instead is in force when
/// the choice is made again without it.
bool Planner::blend_by_arc(Segment& last, Segment& added) {
    auto made = arc_blend_between(last, added, limits_, settings_);
    if (!made) return false;
    const double parabolic = 0.5 * overlap(last, highest_target(last), added, highest_target(added)).net;
    if (made->blend.top_speed <= std::max(parabolic, last.kink_speed)) {
        take_best(last, added);
        return false;
    }
    ++arc_blends_;
    added = made->after;
    added.kink_reduction_before = 0;
    made->blend.begin_s = last.begin_s;
    if (made->swallows_before) {
        queue_.pop_back();
    } else {
        last = made->before;
        last.kink_speed = -1;
        last.kink_reduction = 0;
        last.ending = Ending::tangent;
        finalise(last);
    }
    queue_.push_back(std::move(made->blend));
    return true;
}

/// From now on the length is fixed.
void Planner::finalise(Segment& segment) const {
    if (segment.finalised) return;
    segment.finalised = true;
    segment.limit_top_speed(segment.length / settings_.servo_period_s, {LimitKind::block_time});
    if (segment.shape != Shape::arc) return;
    segment.acceleration_ratio = 1;
    const double whole = segment.overall_acceleration();
    const double radius = segment.circle.curvature_radius();
    const double normal = segment.top_speed * segment.top_speed / radius;
    constexpr double share = 0.8660254037844386;
    if (normal > share * whole) {
        segment.limit_top_speed(std::sqrt(share * whole * radius),
                                {LimitKind::curvature, segment.acceleration_hold.slot});
        segment.acceleration_ratio = 0.5;
    } else {
        segment.acceleration_ratio = std::sqrt(1 - (normal / whole) * (normal / whole));
    }
}

/// How fast a segment may end so that what is known behind it can still stop, and why no faster.
void Planner::bound_end(Segment& earlier, Segment& later) const {
    const bool kinked = earlier.kink_speed >= 0 && earlier.kink_speed < earlier.top_speed;
    const double joint = kinked ? earlier.kink_speed : earlier.top_speed;
    const Hold at_joint = kinked ? Hold{LimitKind::transition} : earlier.top_hold;
    earlier.horizon = 0;
    if (!later.finalised) {
        const double stopping = std::sqrt(later.acceleration_along() * later.length);
        const double target = highest_target(later);
        earlier.end_speed = std::min({joint, stopping, target});
        later.end_speed = 0;
        earlier.end_hold = earlier.end_speed == joint    ? at_joint
                           : earlier.end_speed == target ? hold_of_target(later)
                                                         : Hold{LimitKind::look_ahead};
        if (earlier.end_speed < std::min(joint, target)) earlier.horizon = later.number;
    } else {
        const double most = std::min(joint, later.top_speed);
        earlier.end_speed =
            std::sqrt(later.end_speed * later.end_speed + 2 * later.acceleration_along() * later.length);
        earlier.end_hold = later.stands() ? Hold{LimitKind::stop} : later.end_hold;
        earlier.horizon = later.stands() ? 0 : later.horizon;
        if (earlier.end_speed >= most) {
            earlier.end_speed = most;
            earlier.at_top = true;
            earlier.end_hold = joint <= later.top_speed ? at_joint : later.top_hold;
            earlier.horizon = 0;
        }
        later.limit_top_speed(later.length / (1.02 * settings_.servo_period_s), {LimitKind::block_time});
    }
}

/// From the newest pair backwards: the speed at which each segment may end so that all behind it can still stop.
void Planner::look_back() {
    int peaks = 0;
    bool met_end = false;
    const std::size_t count = queue_.size();
    for (std::size_t i = 1; i < count && i <= static_cast<std::size_t>(settings_.optimization_depth) + 1; ++i) {
        Segment &earlier = queue_[count - 1 - i], &later = queue_[count - i];
        if (earlier.ending != Ending::tangent) {
            if (met_end) return;
            met_end = true;
            continue;
        }
        if (earlier.progress / earlier.length >= 0.25 || earlier.split || earlier.blending) return;
        bound_end(earlier, later);
        if (later.at_top && ++peaks > enough_peaks) return;
    }
}

// ---- one period

void Planner::begin(Segment& segment, double now_s) const {
    if (!segment.begun) segment.begin_s = now_s - settings_.servo_period_s;
    segment.begun = true;
}

/// Short segments that end at speed are passed with one acceleration instead of a trapezoid.
void Planner::activate(Segment& segment) const {
    if (segment.active) return;
    segment.active = true;
    const double rest = segment.length - segment.progress;
    const double both = segment.speed + std::min(segment.end_speed, target(segment));
    segment.ramp =
        2 * rest / both < 1 / settings_.ramp_frequency_hz && !segment.rapid && segment.ending == Ending::tangent;
}

Planner::Step Planner::advance(Segment& segment, const Segment* next, double duration_s) {
    const double target_speed = target(segment), most = segment.acceleration_along();
    double end_speed = 0;
    if (segment.ending == Ending::tangent)
        end_speed = std::min({segment.end_speed, target_speed, next ? target(*next) : 0.0});
    const double rest = segment.length - segment.progress, speed = segment.speed;
    double wanted = 0, acceleration = 0;
    if (segment.ramp && end_speed > 1e-8) {
        acceleration = clamped((end_speed - speed) / (rest / ((speed + end_speed) / 2)), most);
        wanted = end_speed;
    } else {
        const double half = most * duration_s / 2;
        const double root = end_speed * end_speed + most * (2 * rest - speed * duration_s) + half * half;
        wanted = -half + (root > half * half ? std::sqrt(root) : 0);
        acceleration = clamped((clamped(wanted, target_speed) - speed) / duration_s, most);
    }
    double reached = speed + acceleration * duration_s;
    if (reached < 0) {
        reached = 0;
        if (rest < speed * duration_s) segment.progress = segment.length;
    } else {
        segment.progress = std::clamp(segment.progress + (speed + reached) / 2 * duration_s, 0.0, segment.length);
    }
    segment.speed = reached;
    segment.on_final_deceleration = acceleration < 0 && std::abs(wanted - reached) < 1e-8;
    check_end(segment, end_speed, most);
    return {target_speed, end_speed, acceleration, most};
}

/// What the speed that a segment is to have comes from.
Hold Planner::hold_of_target(const Segment& segment) const {
    const double asked = segment.requested * override_of(segment);
    if (!segment.purely_rotary && settings_.max_linear_velocity_mm_s < std::min(asked, segment.top_speed))
        return {LimitKind::linear_velocity};
    return asked <= segment.top_speed ? segment.requested_hold : segment.top_hold;
}

/// Why a segment ends slowly. Where it has to be able to stop behind the newest one: either nothing follows, or that is
/// all that has come until now, or the look-ahead did not look again.
Hold Planner::hold_of_end(const Segment& segment) const {
    if (segment.stands()) return {LimitKind::stop};
    if (segment.horizon == 0 || segment.horizon != added_) return segment.end_hold;
    return {nothing_follows_ ? LimitKind::stop : LimitKind::command_rate};
}

void Planner::note_hold(const Segment& segment, const Segment* next, const Step& step) {
    constexpr double nearly = 1 - 1e-9;
    const bool at_target = segment.speed >= nearly * step.target;
    const bool next_is_slower = segment.ending == Ending::tangent && next && step.end_speed < segment.end_speed;
    const Hold end = next_is_slower ? hold_of_target(*next) : hold_of_end(segment);
    const Hold lower = at_target ? hold_of_target(segment) : end;
    const bool all_acceleration = std::abs(step.acceleration) >= nearly * step.most;
    hold_ = all_acceleration && !(at_target && step.acceleration >= 0) ? segment.acceleration_hold : lower;
    if (step.acceleration <= 0 || !all_acceleration) slower_end_ = lower;
}

/// Whether the segment ends within the next period, and when.
void Planner::check_end(Segment& segment, double end_speed, double most) const {
    const double rest = segment.length - segment.progress, speed = segment.speed;
    const auto split_after = [&](double time_s, double exit_speed) {
        segment.split = true;
        segment.split_s = time_s;
        segment.exit_speed = exit_speed;
    };
    if (rest <= at_end) {
        if (segment.stands()) segment.finished = true;
        split_after(0, speed);
        return;
    }
    if (segment.stands() || speed + end_speed <= 0) return;
    double time = rest / ((speed + end_speed) / 2);
    if (std::abs(end_speed - speed) / time > most) {
        const double sign = end_speed < speed ? -1 : 1;
        const double root = speed * speed + 2 * sign * most * rest;
        if (root < 0) return;
        time = sign * (std::sqrt(root) - speed) / most;
        end_speed = speed + sign * most * time;
    }
    if (time < at_end) {
        split_after(0, end_speed);
    } else if (time < settings_.servo_period_s) {
        split_after(time, end_speed);
    }
}

void Planner::run_period(double now_s, std::vector<LinuxcncBlock>& done) {
    if (queue_.empty()) {
        speed_ = 0;
        hold_ = slower_end_ = {LimitKind::stop};
        return;
    }
    if (queue_.front().split)
        split_period(now_s, done);
    else
        regular_period(now_s, done);
}

void Planner::regular_period(double now_s, std::vector<LinuxcncBlock>& done) {
    Segment& segment = queue_.front();
    Segment* next = queue_.size() > 1 ? &queue_[1] : nullptr;
    begin(segment, now_s);
    activate(segment);
    const Coordinates from = segment.at(segment.progress);
    note_hold(segment, next, advance(segment, next, settings_.servo_period_s));
    position_ = position_ + (segment.at(segment.progress) - from);
    speed_ = segment.speed;
    if (next && segment.ending == Ending::parabolic) {
        if (!segment.blending && segment.on_final_deceleration)
            segment.blending = segment.speed < overlap(segment, target(segment), *next, target(*next)).own;
        if (segment.blending) {
            if (!next->begun && next->shape == Shape::blend) ++unset_directions_;
            begin(*next, now_s);
            const Coordinates next_from = next->at(next->progress);
            advance(*next, nullptr, settings_.servo_period_s);
            position_ = position_ + (next->at(next->progress) - next_from);
            speed_ += next->speed;
        }
    }
    report(segment);
    if (segment.finished) leave(now_s, done);
}

/// The first segment ends within this period, and the next one goes on.
void Planner::split_period(double now_s, std::vector<LinuxcncBlock>& done) {
    const Segment& segment = queue_.front();
    position_ = position_ + (segment.at(segment.length) - segment.at(segment.progress));
    speed_ = 0;
    if (queue_.size() > 1) {
        Segment& next = queue_[1];
        begin(next, now_s);
        double duration_s = settings_.servo_period_s;
        if (segment.ending == Ending::tangent) {
            next.speed = segment.exit_speed;
            duration_s -= segment.split_s;
        }
        const Coordinates from = next.at(next.progress);
        const Segment* behind = queue_.size() > 2 ? &queue_[2] : nullptr;
        note_hold(next, behind, advance(next, behind, duration_s));
        position_ = position_ + (next.at(next.progress) - from);
        speed_ = next.speed;
        report(next);
    }
    leave(now_s, done);
}

void Planner::report(const Segment& moving) {
    line_ = moving.line;
    rapid_reported_ = moving.rapid;
    turns_only_ = moving.purely_rotary;
}

void Planner::leave(double now_s, std::vector<LinuxcncBlock>& done) {
    const Segment& segment = queue_.front();
    done.push_back({segment.line, segment.begin_s, now_s});
    if (segment.stands() || queue_.size() == 1) ++standstills_;
    queue_.pop_front();
}

}  // namespace trunnion::controller::linuxcnc
