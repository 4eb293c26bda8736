#include "detail/heidenhain_drilling.hpp"

#include <algorithm>
#include <cmath>

namespace trunnion::nc::heidenhain {

using Eigen::Vector3d;
using program::EventKind;

namespace {

constexpr double same_depth_mm = 1e-9;
constexpr int most_strokes = 10'000;

/// How far before the depth reached the tool turns from rapid to feed in cycle 1.
double advance_stop_mm(double depth_mm) {
    constexpr double shallow_mm = 30, least_mm = 0.6, most_mm = 7;
    return depth_mm <= shallow_mm ? least_mm : std::min(depth_mm / 50, most_mm);
}

}  // namespace

bool DrillingCycle::number(int parameter, double& value) {
    value = optional(parameter, unknown);
    if (!std::isnan(value)) return true;
    return refuse("a parameter of the cycle is missing", fmt::format("Q{}", parameter));
}

bool DrillingCycle::length(int parameter, double& value_mm) {
    if (!number(parameter, value_mm)) return false;
    value_mm *= unit_mm_;
    return std::abs(value_mm) < 1e9 || refuse("a length of the cycle is too large", fmt::format("Q{}", parameter));
}

double DrillingCycle::optional(int parameter, double otherwise) const {
    const double value = reader_.values().parameters().get({ParameterName::Kind::shared, parameter});
    return std::isnan(value) ? otherwise : value;
}

/// A feed of the cycle; empty: rapid.
bool DrillingCycle::speed(int parameter, std::optional<double>& speed_mm_s) {
    double value = 0;
    if (!number(parameter, value)) return false;
    speed_mm_s.reset();
    if (value == rapid_feed) return true;
    speed_mm_s = value * reader_.feed_unit_mm() / 60;
    return (*speed_mm_s > 0 && std::isfinite(*speed_mm_s)) ||
           refuse("a feed must be positive", fmt::format("Q{}", parameter));
}

bool DrillingCycle::to(double level, bool rapid, std::optional<double> speed_mm_s) {
    Vector3d place = reader_.programmed_mm_;
    place.z() = level;
    return reader_.go(place, {.rapid = rapid || !speed_mm_s, .speed_mm_s = speed_mm_s});
}

bool DrillingCycle::dwell(double time_s) {
    if (time_s == 0) return true;
    if (!(time_s > 0 && time_s < 1e6)) return refuse("a dwell of the cycle is not negative");
    return reader_.event(EventKind::dwell, true, fmt::format("cycle {} dwell", reader_.cycle_), time_s);
}

/// To the set-up clearance, then to the second one.
bool DrillingCycle::back(const std::optional<double>& speed_mm_s) {
    if (speed_mm_s && !to(start_, false, speed_mm_s)) return false;
    return rapid(retract_);
}

bool DrillingCycle::levels() {
    double depth = 0, second = 0;
    if (!length(200, clearance_) || !length(201, depth) || !length(203, surface_) || !length(204, second)) return false;
    if (!(depth < 0)) return refuse("the depth Q201 must be negative");
    if (!(clearance_ >= 0)) return refuse("the set-up clearance Q200 is not negative");
    if (optional(395, 0) != 0) return refuse("a depth of the whole diameter (Q395) is not supported");
    surface_ += raised_mm_;
    start_ = surface_ + clearance_;
    bottom_ = surface_ + depth;
    retract_ = surface_ + std::max(clearance_, second);
    return true;
}

bool DrillingCycle::run() {
    if (reader_.cycle_ == 1) return peck_once();
    if (!levels()) return false;
    switch (reader_.cycle_) {
        case 200:
            return drill();
        case 201:
            return ream();
        case 203:
            return universal_drilling();
        case 205:
            return universal_pecking();
        case 206:
            return tap(false);
        case 207:
            return tap(true);
        default:
            return centre_drill();
    }
}

/// Cycle 1: strokes from where the tool is, each begun a little before the depth reached.
bool DrillingCycle::peck_once() {
    enum : std::size_t { set_up = 1, whole = 2, stroke = 3, time = 4, plunging = 5 };
    const auto& of = reader_.pecking_;
    for (std::size_t i = set_up; i <= plunging; ++i)
        if (!std::isfinite(of[i])) return refuse("a part of cycle 1 is missing", fmt::format("1.{}", i));
    start_ = retract_ = reader_.programmed_mm_.z();
    if (std::isnan(start_)) return refuse("cycle 1 starts from a height that is not known");
    const double depth = std::abs(of[whole]) * unit_mm_, step = std::abs(of[stroke]) * unit_mm_;
    surface_ = start_ - std::abs(of[set_up]) * unit_mm_;
    speed_ = of[plunging] * reader_.feed_unit_mm() / 60;
    if (!(*speed_ > 0) || !std::isfinite(*speed_) || !(step > 0) || !(depth > 0) || depth > 1e9)
        return refuse("depth, stroke and feed of cycle 1 must not be 0");
    std::vector<double> depths;
    bottom_ = surface_ - depth;
    if (!strokes(step, 0, 0, depths)) return false;
    for (std::size_t i = 0; i < depths.size(); ++i) {
        const bool last = i + 1 == depths.size();
        if (!feed(surface_ - depths[i]) || (last && !dwell(of[time])) || !rapid(start_)) return false;
        if (!last && !rapid(surface_ - depths[i] + advance_stop_mm(depth))) return false;
    }
    return true;
}

/// Depths below the surface at which strokes end; each is less by `decrease`, but not below `least`.
bool DrillingCycle::strokes(double first, double decrease, double least, std::vector<double>& depths) {
    const double whole = surface_ - bottom_;
    if (!(first > 0)) first = whole;
    double stroke = first, reached = 0;
    while (whole - reached > same_depth_mm) {
        if (depths.size() >= most_strokes) return refuse("the strokes are too small");
        reached = std::min(reached + stroke, whole);
        if (whole - reached <= same_depth_mm) reached = whole;
        depths.push_back(reached);
        stroke = std::max(stroke - decrease, least);
        if (!(stroke > 0)) return refuse("the strokes end before the depth is reached");
    }
    return true;
}

/// Cycle 200: between strokes out to the set-up clearance, and back to that clearance above the depth reached.
bool DrillingCycle::drill() {
    double stroke = 0;
    if (!length(202, stroke) || !speed(206, speed_)) return false;
    std::vector<double> depths;
    if (!strokes(stroke, 0, stroke, depths) || !rapid(start_)) return false;
    for (std::size_t i = 0; i < depths.size(); ++i) {
        if (!feed(surface_ - depths[i])) return false;
        if (i + 1 == depths.size()) break;
        if (!rapid(start_) || !dwell(optional(210, 0)) || !rapid(surface_ - depths[i] + clearance_)) return false;
    }
    return dwell(optional(211, 0)) && back({});
}

/// Cycle 201.
bool DrillingCycle::ream() {
    std::optional<double> out;
    if (!speed(206, speed_)) return false;
    if (optional(208, 0) == 0)
        out = speed_;
    else if (!speed(208, out))
        return false;
    return rapid(start_) && feed(bottom_) && dwell(optional(211, 0)) && back(out);
}

/// Cycle 203: Q213 chip breaks before the tool is brought out.
bool DrillingCycle::universal_drilling() {
    double stroke = 0;
    std::optional<double> out;
    if (!length(202, stroke) || !speed(206, speed_)) return false;
    if (optional(208, 0) != 0 && !speed(208, out)) return false;
    const double decrease = optional(212, 0) * unit_mm_, least = optional(205, 0) * unit_mm_;
    const double draw_back = optional(256, 0.2 / unit_mm_) * unit_mm_;
    if (!(decrease >= 0) || !(least >= 0) || !(draw_back >= 0) || !std::isfinite(draw_back))
        return refuse("Q205, Q212 and Q256 are not negative");
    const double breaks = optional(213, 0);
    std::vector<double> depths;
    if (!strokes(stroke, decrease, decrease > 0 ? least : stroke, depths) || !rapid(start_)) return false;
    double broken = 0;
    for (std::size_t i = 0; i < depths.size(); ++i) {
        const double level = surface_ - depths[i];
        if (!feed(level)) return false;
        if (i + 1 == depths.size()) break;
        if (broken < breaks) {
            ++broken;
            if (!dwell(optional(211, 0)) || !to(level + draw_back, false, out ? out : speed_)) return false;
            continue;
        }
        broken = 0;
        if ((out && !to(start_, false, out)) || !rapid(start_) || !dwell(optional(210, 0)) ||
            !rapid(level + clearance_))
            return false;
    }
    return dwell(optional(211, 0)) && back(out);
}

/// Cycle 205 with one advanced stop distance and without chip breaking.
bool DrillingCycle::universal_pecking() {
    double stroke = 0, above = 0;
    if (!length(202, stroke) || !speed(206, speed_) || !length(258, above)) return false;
    const double decrease = optional(212, 0) * unit_mm_, least = optional(205, 0) * unit_mm_;
    const double whole = surface_ - bottom_, breaking = optional(257, 0) * unit_mm_;
    if (optional(259, optional(258, 0)) != optional(258, 0))
        return refuse("an advanced stop that changes (Q258, Q259) is not supported");
    if (breaking != 0 && breaking < whole) return refuse("chip breaking (Q257) is not supported");
    if (optional(379, 0) != 0) return refuse("a deepened start (Q379) is not supported");
    if (!(above >= 0) || !(decrease >= 0) || !(least >= 0)) return refuse("Q205, Q212 and Q258 are not negative");
    std::vector<double> depths;
    if (!strokes(stroke, decrease, decrease > 0 ? least : stroke, depths) || !rapid(start_)) return false;
    for (std::size_t i = 0; i < depths.size(); ++i) {
        const double level = surface_ - depths[i];
        if (!feed(level)) return false;
        if (i + 1 < depths.size() && (!rapid(start_) || !rapid(level + above))) return false;
    }
    return dwell(optional(211, 0)) && back({});
}

/// Cycle 206 with F and a dwell; 207 with the spindle's speed and the pitch. In and out alike, then up.
bool DrillingCycle::tap(bool rigid) {
    double pitch = 0;
    if (rigid) {
        if (!length(239, pitch)) return false;
        if (!(reader_.modes_.spindle_rpm > 0)) return refuse("the spindle's speed is not known");
        speed_ = std::abs(pitch) * reader_.modes_.spindle_rpm / 60;
        if (!(*speed_ > 0) || !std::isfinite(*speed_)) return refuse("the pitch Q239 must not be 0");
    } else if (!speed(206, speed_)) {
        return false;
    }
    if (!speed_) return refuse("a thread at rapid");
    return rapid(start_) && feed(bottom_) && dwell(rigid ? 0 : optional(211, 0)) && back(speed_);
}

/// Cycle 240 by its depth.
bool DrillingCycle::centre_drill() {
    if (optional(343, 0) != 0)
        return refuse("centring by its diameter (Q343) is not supported: the tool's angle is unknown");
    return speed(206, speed_) && rapid(start_) && feed(bottom_) && dwell(optional(211, 0)) && back({});
}

}  // namespace trunnion::nc::heidenhain
