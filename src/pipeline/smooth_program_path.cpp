#include "detail/smooth_program_path.hpp"

#include <algorithm>
#include <cmath>

#include "trunnion/geometry/great_circle.hpp"

namespace trunnion::pipeline {

using Eigen::Vector3d;

namespace {

constexpr double shortest_chord_mm = 1e-4;
constexpr double growth = 1.2;  ///< of a chord, from try to try

StretchCurve::Pose chord_at(const StretchCurve& curve, const StretchCurve::Pose& from, const StretchCurve::Pose& to,
                            double share) {
    return {from.tip_mm + share * (to.tip_mm - from.tip_mm),
            curve.by_vectors() ? geometry::slerp(from.orientation, to.orientation, share)
                               : Vector3d(from.orientation + share * (to.orientation - from.orientation))};
}

FitDeviation deviation_of_chord(const StretchCurve& curve, double from, double to, const FitTolerance& tolerance) {
    constexpr int places = 8;
    const auto begin = curve.at(from), end = curve.at(to);
    FitDeviation worst;
    for (int i = 1; i < places; ++i) {
        const double share = static_cast<double>(i) / places;
        worst.add(curve.deviation(chord_at(curve, begin, end, share), from + share * (to - from), tolerance));
    }
    return worst;
}

/// How far a chord reaches, within `growth`; at least the shortest one, at most to the next break. Begins to look at a
/// guess.
double longest_step(const StretchCurve& curve, double from, double room, double guess, const FitTolerance& tolerance,
                    FitDeviation& deviation) {
    const auto found = [&](double step) { return deviation_of_chord(curve, from, from + step, tolerance); };
    double step = std::min(guess, room);
    FitDeviation kept = found(step);
    while (!kept.within(tolerance) && step > shortest_chord_mm) kept = found(step /= growth);
    while (step < room) {
        const double longer = std::min(growth * step, room);
        const FitDeviation next = found(longer);
        if (!next.within(tolerance)) break;
        step = longer;
        kept = next;
    }
    deviation.add(kept);
    return step;
}

}  // namespace

void FitDeviation::add(const FitDeviation& other) {
    tip_mm = std::max(tip_mm, other.tip_mm);
    orientation_rad = std::max(orientation_rad, other.orientation_rad);
    height_mm = std::max(height_mm, other.height_mm);
}

bool FitDeviation::within(const FitTolerance& tolerance) const {
    const bool turned =
        tolerance.flank_mm > 0 ? height_mm <= tolerance.flank_mm : orientation_rad <= tolerance.orientation_rad;
    return tip_mm <= tolerance.tip_mm && turned;
}

std::array<Taylor3, 6> StretchCurve::series(double p_mm) const {
    const auto& pieces = path_->pieces;
    auto above = std::upper_bound(pieces.begin(), pieces.end(), p_mm,
                                  [](double p, const path::PathPiece& piece) { return p < piece.begin_mm; });
    if (above != pieces.begin()) --above;
    return path::evaluate(*above, p_mm - above->begin_mm);
}

StretchCurve::Pose StretchCurve::at(double p_mm) const {
    const auto value = series(p_mm);
    Pose out{{value[0].value(), value[1].value(), value[2].value()},
             {value[3].value(), value[4].value(), value[5].value()}};
    if (by_vectors()) out.orientation.normalize();
    return out;
}

StretchCurve::Pose StretchCurve::slope(double p_mm) const {
    const auto value = series(p_mm);
    Pose out{{value[0].d1(), value[1].d1(), value[2].d1()}, {value[3].d1(), value[4].d1(), value[5].d1()}};
    if (!by_vectors()) return out;
    const Vector3d vector(value[3].value(), value[4].value(), value[5].value());
    const Vector3d unit = vector.normalized();
    out.orientation = (out.orientation - out.orientation.dot(unit) * unit) / vector.norm();
    return out;
}

Vector3d StretchCurve::tool_axis(const Pose& pose) const {
    if (by_vectors()) return pose.orientation;
    return run_->kinematics->tool_axis(machine::RotaryPosition{pose.orientation[0], pose.orientation[1]});
}

FitDeviation StretchCurve::deviation(const Pose& fit, double p_mm, const FitTolerance& tolerance) const {
    const Pose here = at(p_mm);
    const Vector3d off = fit.tip_mm - here.tip_mm;
    const Vector3d fit_axis = tool_axis(fit), axis = tool_axis(here), turned = fit_axis - axis;
    FitDeviation out;
    out.tip_mm = (off + tolerance.controlled_height_mm * turned).norm();
    out.height_mm = (off + tolerance.flank_height_mm * turned).norm();
    out.orientation_rad = geometry::angle_between(fit_axis, axis);
    if (by_vectors()) return out;
    // Rotary words count where they leave the tool as it is, too.
    const double least_lever = 0.1;
    out.orientation_rad = std::max(out.orientation_rad, least_lever * (fit.orientation - here.orientation).norm());
    return out;
}

std::vector<double> chord_ends(const StretchCurve& curve, const std::vector<double>& breaks,
                               const FitTolerance& tolerance, FitDeviation& deviation) {
    std::vector<double> out{0};
    double step = 1;
    for (const double end : breaks)
        while (out.back() < end) {
            const double from = out.back();
            step = longest_step(curve, from, end - from, step, tolerance, deviation);
            const double to = from + step;
            out.push_back(end - to < 1e-9 * curve.length_mm() ? end : to);
        }
    return out;
}

}  // namespace trunnion::pipeline
