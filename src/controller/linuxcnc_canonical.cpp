#include "detail/linuxcnc_canonical.hpp"

#include <algorithm>
#include <cmath>

#include "trunnion/base/quantity.hpp"

namespace trunnion::controller::linuxcnc {

using motion::LimitKind;
using program::FeedRule;
using program::PathControlKind;

namespace {

constexpr double turns_only_mm = 1e-7;  ///< linear motion that does not count for inverse time
constexpr double least_inverse_time_feed = 0.1 / 60;
constexpr std::size_t longest_chain = 100;

/// The times that the slowest axis needs at its velocity, and the acceleration that goes with it; which axes they are.
struct SlowestAxis {
    double at_velocity = 0, at_acceleration = 0;
    int in_velocity = -1, in_acceleration = -1;
};

void raise(double& most, int& which, double value, int slot) {
    if (value <= most) return;
    most = value;
    which = slot;
}

SlowestAxis slowest_axis(const Coordinates& way, const Limits& limits) {
    SlowestAxis out;
    for (int i = 0; i < 6; ++i) {
        const double distance = std::abs(i < 3 ? way.linear_mm[i] : way.rotary_deg[i - 3]);
        if (distance < still) continue;
        const auto axis = static_cast<std::size_t>(i);
        raise(out.at_velocity, out.in_velocity, distance / limits.velocity[axis], i);
        raise(out.at_acceleration, out.in_acceleration, distance / limits.acceleration[axis], i);
    }
    return out;
}

/// Components that stand still are exactly 0.
Coordinates moved(const Coordinates& from, const Coordinates& to) {
    Coordinates way = to - from;
    for (int i = 0; i < 3; ++i) {
        if (std::abs(way.linear_mm[i]) < still) way.linear_mm[i] = 0;
        if (std::abs(way.rotary_deg[i]) < still) way.rotary_deg[i] = 0;
    }
    return way;
}

double distance_to_segment(const Vector3d& point, const Vector3d& from, const Vector3d& to) {
    const Vector3d way = to - from;
    const double square = way.squaredNorm();
    const double share = square > 0 ? std::clamp((point - from).dot(way) / square, 0.0, 1.0) : 0;
    return (point - from - share * way).norm();
}

}  // namespace

/// F as the control counts it: mm/s, and of pure rotations deg/s.
double Canonical::feed_of(const Way& way, double linear_mm, double rotary_deg) const {
    switch (way.feed.rule) {
        case FeedRule::block_time:
            return std::max(least_inverse_time_feed, (linear_mm > 0 ? linear_mm : rotary_deg) / way.feed.value);
        case FeedRule::rotary_rate:
            return way.feed.value / degree;
        default:
            return way.feed.value;
    }
}

/// Another feed ends a chain of short blocks.
void Canonical::take_feed(double feed) {
    if (std::abs(feed - feed_) <= 1e-12 * feed) return;
    flush();
    feed_ = feed;
}

void Canonical::move(const Way& way) {
    if (way.circle)
        arc(way);
    else
        straight(way);
    programmed_ = way.end;
}

void Canonical::straight(const Way& way) {
    const Coordinates distance = way.end - programmed_;
    const bool linear = (distance.linear_mm.array().abs() > turns_only_mm).any();
    const double linear_mm = linear ? distance.linear_mm.norm() : 0;
    if (way.rapid) {
        flush();
        length_over_feed_s += slowest_axis(distance, limits_).at_velocity;
        send_line({way.end, way.line}, true);
        return;
    }
    const double feed = feed_of(way, linear_mm, distance.rotary_deg.norm());
    take_feed(feed);
    length_over_feed_s += (linear ? linear_mm : distance.rotary_deg.norm()) / feed;
    const bool turns = way.end.rotary_deg != programmed_.rotary_deg;
    if (!merges() || turns) {
        flush();
        send_line({way.end, way.line}, false);
        return;
    }
    collect({way.end, way.line});
}

void Canonical::arc(const Way& way) {
    const Circle& circle = *way.circle;
    const double feed = feed_of(way, circle.length(), 0);
    take_feed(feed);
    length_over_feed_s += circle.length() / feed;
    const double sagitta = circle.start_radius() * (1 - std::cos(circle.angle() / 2));
    if (merges() && way.normal_axis == 2 && sagitta < mode_.merge_tolerance_mm) {
        Coordinates middle = (programmed_ + way.end) * 0.5;
        middle.linear_mm = circle.at_angle(circle.angle() / 2);
        collect({middle, way.line});
        collect({way.end, way.line});
        return;
    }
    flush();
    send_arc(way);
}

void Canonical::path_control(const program::PathControl& mode) {
    flush();
    mode_ = mode;
    commands.push_back({.kind = Command::Kind::mode});
}

void Canonical::wait(LinuxcncWait word, double answer_s, double dwell_s) {
    flush();
    if (commands.empty() || commands.back().kind != Command::Kind::wait)
        commands.push_back({.kind = Command::Kind::wait});
    Command& command = commands.back();
    command.dwell_s += dwell_s;
    if (answer_s < command.answer_s) return;
    command.answer_s = answer_s;
    command.word = word;
}

void Canonical::recount(const Coordinates& position, std::size_t geometry) {
    flush();
    commands.push_back({.kind = Command::Kind::geometry, .position = position, .geometry = geometry});
    stand_at(position);
}

// ---- merging

/// A point that the chain cannot reach straight from its start begins another chain.
void Canonical::collect(const Point& point) {
    if (!chain_.empty() && !fits(point)) flush();
    chain_.push_back(point);
}

bool Canonical::fits(const Point& point) const {
    if (chain_.size() > longest_chain || point.at.rotary_deg != chain_.back().at.rotary_deg) return false;
    const Vector3d &from = sent_.linear_mm, &to = point.at.linear_mm;
    return to != from && std::ranges::all_of(chain_, [&](const Point& between) {
               return distance_to_segment(between.at.linear_mm, from, to) <= mode_.merge_tolerance_mm;
           });
}

void Canonical::flush() {
    if (chain_.empty()) return;
    const Point last = chain_.back();
    chain_.clear();
    send_line(last, false);
}

// ---- segments

Ending Canonical::ending() const {
    switch (mode_.kind) {
        case PathControlKind::stop:
            return Ending::stop;
        case PathControlKind::exact:
            return Ending::exact;
        default:
            return Ending::parabolic;
    }
}

void Canonical::send_line(const Point& point, bool rapid) {
    const Coordinates way = moved(sent_, point.at);
    Segment segment = line_segment(sent_, sent_ + way);
    const SlowestAxis slowest = slowest_axis(way, limits_);
    if (slowest.at_velocity == 0) return;
    segment.top_speed = segment.length / slowest.at_velocity;
    segment.acceleration = segment.length / slowest.at_acceleration;
    segment.requested = rapid ? segment.top_speed : std::min(segment.top_speed, feed_);
    segment.top_hold = segment.requested_hold = {LimitKind::velocity, slowest.in_velocity};
    segment.acceleration_hold = {LimitKind::acceleration, slowest.in_acceleration};
    if (!rapid && feed_ < segment.top_speed) segment.requested_hold = {LimitKind::feed};
    segment.rapid = rapid;
    send(std::move(segment), point.line);
}

void Canonical::send_arc(const Way& way) {
    const Circle& circle = *way.circle;
    const int in_plane_axes[] = {(way.normal_axis + 1) % 3, (way.normal_axis + 2) % 3};
    const auto weaker = [&](const std::array<double, 6>& limits) {
        return *std::ranges::min_element(in_plane_axes, {},
                                         [&](int slot) { return limits[static_cast<std::size_t>(slot)]; });
    };
    const int slow_axis = weaker(limits_.velocity), weak_axis = weaker(limits_.acceleration);
    const double velocity = limits_.velocity[static_cast<std::size_t>(slow_axis)];
    const double acceleration = limits_.acceleration[static_cast<std::size_t>(weak_axis)];
    const double smaller = std::min(circle.start_radius(), circle.start_radius() + circle.spiral());
    const double per_angle = circle.spiral() / circle.angle();
    const double round =
        std::min(std::sqrt(acceleration * 0.8660254037844386 * std::hypot(per_angle, smaller)), velocity);
    const double in_plane = std::hypot(smaller * circle.angle(), circle.spiral());
    const double length = std::hypot(in_plane, circle.rise());
    const SlowestAxis slowest = slowest_axis(moved(sent_, way.end), limits_);

    Segment segment = arc_segment(sent_, way.end, circle);
    segment.top_speed = length / std::max(slowest.at_velocity, in_plane / round);
    segment.acceleration = length / std::max(slowest.at_acceleration, in_plane / acceleration);
    segment.requested = std::min(segment.top_speed, feed_);
    const bool by_ends = slowest.at_velocity >= in_plane / round;
    segment.top_hold = by_ends            ? Hold{LimitKind::velocity, slowest.in_velocity}
                       : round < velocity ? Hold{LimitKind::curvature, weak_axis}
                                          : Hold{LimitKind::velocity, slow_axis};
    segment.requested_hold = feed_ < segment.top_speed ? Hold{LimitKind::feed} : segment.top_hold;
    segment.acceleration_hold = {LimitKind::acceleration, slowest.at_acceleration > in_plane / acceleration
                                                              ? slowest.in_acceleration
                                                              : weak_axis};
    send(std::move(segment), way.line);
}

void Canonical::send(Segment segment, std::int32_t line) {
    segment.line = line;
    segment.ending = ending();
    if (mode_.kind == PathControlKind::blend) segment.tolerance_mm = mode_.tolerance_mm;
    sent_ = segment.end;
    ++segments;
    commands.push_back({.kind = Command::Kind::segment, .segment = std::move(segment)});
}

}  // namespace trunnion::controller::linuxcnc
