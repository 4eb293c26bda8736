#include "detail/straight.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "detail/polyline.hpp"
#include "detail/programmed_block.hpp"

namespace trunnion::smoothing {

namespace {

constexpr double largest_turn_rad =
    20 * std::numbers::pi / 180;               // of one septic piece: 3e-11 of the radius off a circle
constexpr double least_lever_of_length = 0.1;  // as in the definition of p

Coordinates tangent(const path::Run& run, std::size_t block, double part) {
    const HermiteEnd end = ProgrammedBlock(run, block).at(part);
    Coordinates t = end.first;
    t.tail<3>() *= path::reference_height_mm;
    if (const int axis = lever_axis(run); axis >= 0)
        t[axis] *= std::max(lever_at(run, end.value), least_lever_of_length);
    return t;
}

/// Remainder of septic Hermite interpolation of a unit circle over an angle, (h/2)⁸/8!, both components.
double off_unit_circle(double angle_rad) {
    return 1.5 * std::pow(0.5 * angle_rad, 8) / 40320;
}

void append_block(const ProgrammedBlock& block, path::ToolPath& path) {
    const double arc_rad = block.arc() ? std::abs(block.arc()->angle_rad()) : 0;
    const int parts = std::max(1, static_cast<int>(std::ceil(std::max(block.turn_rad(), arc_rad) / largest_turn_rad)));
    const double length = block.length_mm() / parts, begin = path.length_mm();
    for (int k = 0; k < parts; ++k) {
        const HermiteEnd start = block.at(static_cast<double>(k) / parts);
        HermiteEnd end = block.at(static_cast<double>(k + 1) / parts);
        end.value -= start.value;
        path.pieces.push_back(hermite_piece(begin + k * length, length, start, end));
    }
    path.bound.orientation_rad = std::max(path.bound.orientation_rad, off_unit_circle(block.turn_rad() / parts));
    if (!block.arc()) return;
    const double radius = std::max(block.arc()->radius_at_start(), block.arc()->radius_at_end());
    path.bound.tip_mm = std::max(path.bound.tip_mm, radius * off_unit_circle(arc_rad / parts));
}

}  // namespace

Coordinates tangent_at_begin(const path::Run& run, std::size_t block) {
    return tangent(run, block, 0);
}
Coordinates tangent_at_end(const path::Run& run, std::size_t block) {
    return tangent(run, block, 1);
}

path::ToolPath stretch(const path::Run& run, VertexRange range, path::StopCause stop) {
    path::ToolPath path;
    path.space = run.space;
    path.law = run.law;
    path.rapid = run.rapid;
    path.kinematics = run.kinematics;
    path.stop = stop;
    double begin = 0;
    for (std::size_t i = range.first; i < range.last; ++i) {
        const path::Block& block = run.blocks[i];
        path.blocks.push_back({begin, begin + block.length_mm, block.feed, block.line, block.length_mm, i});
        begin += block.length_mm;
    }
    return path;
}

void append_straight(const path::Run& run, VertexRange range, path::StopCause stop, const SmoothingOptions& options,
                     std::vector<path::ToolPath>& out) {
    path::ToolPath path = stretch(run, range, stop);
    for (std::size_t i = range.first; i < range.last; ++i) append_block(ProgrammedBlock(run, i), path);
    path.bound.height_mm = path.bound.tip_mm + options.flank_height_mm * path.bound.orientation_rad;
    path.bound.tip_mm += options.controlled_height_mm * path.bound.orientation_rad;
    path.transition_use.assign(range.last - range.first - 1, 0.0F);
    path.blocks.back().end_mm = path.length_mm();
    out.push_back(std::move(path));
}

}  // namespace trunnion::smoothing
