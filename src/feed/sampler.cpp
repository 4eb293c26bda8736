#include "detail/sampler.hpp"

#include <cmath>
#include <span>

#include <Eigen/Geometry>

namespace trunnion::feed {
namespace {

struct Derivatives {
    double q1 = 0, q2 = 0, q3 = 0;
    void into(int coordinate, PathSample& out, double scale = 1) const {
        out.q1[coordinate] = scale * q1;
        out.q2[coordinate] = scale * q2;
        out.q3[coordinate] = scale * q3;
    }
};

/// s′ = |r′| and its derivatives. Where r′ is nothing beside r″ the way has a cusp or there is none: s′ alone.
Derivatives way_of(std::span<const Taylor3> r) {
    double square = 0, slope = 0, bend = 0, twist = 0;
    for (const Taylor3& c : r) {
        square += c.d1() * c.d1();
        slope += c.d1() * c.d2();
        bend += c.d2() * c.d2();
        twist += c.d1() * c.d3();
    }
    const double s1 = std::sqrt(square), s2 = slope / s1, s3 = (bend + twist - s2 * s2) / s1;
    return std::isfinite(s2) && std::isfinite(s3) ? Derivatives{s1, s2, s3} : Derivatives{s1, 0, 0};
}

/// κ s′², the curvature of the tip's way times the square of its rate.
double sweep_of(const machine::VectorSeries& r) {
    const Eigen::Vector3d r1(r[0].d1(), r[1].d1(), r[2].d1()), r2(r[0].d2(), r[1].d2(), r[2].d2());
    const double rate = r1.norm();
    return rate > 0 ? r1.cross(r2).norm() / rate : 0;
}

bool limits_any(const machine::AxisLimits& limit) {
    return limit.velocity < LimitSet::unbounded || limit.acceleration < LimitSet::unbounded ||
           limit.jerk < LimitSet::unbounded;
}

}  // namespace

LimitSet limits_of(const path::AxisPath& path, const FeedOptions& options) {
    LimitSet out;
    for (int a = 0; a < path.axis_count(); ++a) {
        const machine::Axis& axis = path.machine().axes[a];
        out.of[a] = path.tool_path().rapid ? axis.rapid : axis.feed;
        out.of[a].velocity *= options.factors[a].velocity;
        out.of[a].acceleration *= options.factors[a].acceleration;
        out.of[a].jerk *= options.factors[a].jerk * (1 - options.jerk_margin);
    }
    out.of[tip_way].acceleration = options.tip_acceleration_mm_s2;
    out.of[tip_way].jerk = options.tip_jerk_mm_s3;
    out.of[tool_turn].velocity = options.turn_velocity_rad_s;
    return out;
}

Sampler::Place Sampler::at(path::PathPlace place, std::size_t block) const {
    path::AxisSample at;
    path_->evaluate(place, at);
    const path::ToolPath& tool = path_->tool_path();
    const int axes = path_->axis_count(), linear = axes - path_->machine().rotary_count;
    const bool in_workpiece = tool.space == path::Space::workpiece;
    Place out;
    for (int a = 0; a < axes; ++a) {
        Derivatives{at.axes[a].d1(), at.axes[a].d2(), at.axes[a].d3()}.into(a, out.sample);
        out.position[a] = at.axes[a].value();
    }
    const auto tip = [&] {
        return way_of(in_workpiece ? std::span<const Taylor3>(at.tip)
                                   : std::span<const Taylor3>(at.axes).first(linear));
    };
    const auto turn = [&] {
        const bool vector = in_workpiece && tool.law == path::OrientationLaw::vector;
        return way_of(vector ? std::span<const Taylor3>(at.tool_axis)
                             : std::span<const Taylor3>(at.axes).subspan(linear, axes - linear));
    };
    if (limits_any(limits_.of[tip_way])) tip().into(tip_way, out.sample);
    if (limits_any(limits_.of[tool_turn])) turn().into(tool_turn, out.sample);
    if (!tool.blocks.empty()) {
        const path::BlockSpan& span = tool.blocks[block];
        if (span.feed.rule == path::FeedRule::tip_speed) tip().into(programmed_feed, out.sample, 1 / span.feed.value);
        if (span.feed.rule == path::FeedRule::rotary_rate)
            turn().into(programmed_feed, out.sample, 1 / span.feed.value);
        if (span.feed.rule == path::FeedRule::block_time)
            out.sample.q1[programmed_feed] = span.feed.value / span.time_scale_mm;
    }
    if (has_chord_error()) out.chord_rate = period_s_ * std::sqrt(sweep_of(at.tip) / (8 * chord_));
    return out;
}

bool is_finite(const PathSample& s) {
    double sum = 0;
    for (int c = 0; c < coordinates; ++c) sum += s.q1[c] + s.q2[c] + s.q3[c];
    return std::isfinite(sum);
}

}  // namespace trunnion::feed
