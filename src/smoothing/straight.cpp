#include "detail/straight.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "detail/polyline.hpp"
#include "detail/programmed_block.hpp"

namespace trunnion::smoothing {

namespace {

constexpr double largest_turn_rad =
    20 * std::numbers::pi / 180;                      // of one septic piece: 3e-11 of the radius off a circle
constexpr double least_lever_of_length = 0.1;         // as in the definition of p
constexpr double exact_mm = 1e-8, exact_rad = 1e-10;  // so near a septic piece follows a curve
constexpr double beyond_middle = 2;                   // times what it is off in the middle it may be anywhere
constexpr int most_halvings = 12;

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

/// The septic piece along a part of a curve, from p = 0.
path::PathPiece piece_along(const ProgrammedBlock& block, double from, double to) {
    const HermiteEnd start = block.at(from);
    HermiteEnd end = block.at(to);
    end.value -= start.value;
    return hermite_piece(0, block.curve()->length_mm(from, to), start, end);
}

/// Distance of such a piece from the curve in the middle of it, where septic interpolation is worst: of two halves,
/// which are as good as the curve. At equal p.
Coordinates off_middle(const path::PathPiece& whole, const path::PathPiece& first_half) {
    return progress(whole, first_half.length_mm / whole.length_mm) - progress(first_half, 1);
}

void append_curve(const ProgrammedBlock& block, double from, double to, int depth, path::ToolPath& path) {
    const path::PathPiece whole = piece_along(block, from, to);
    const double middle = 0.5 * (from + to);
    const Coordinates off = off_middle(whole, piece_along(block, from, middle));
    const double off_mm = off.head<3>().norm(), off_rad = off.tail<3>().norm();
    if (depth < most_halvings && (off_mm > exact_mm || off_rad > exact_rad)) {
        append_curve(block, from, middle, depth + 1, path);
        return append_curve(block, middle, to, depth + 1, path);
    }
    const double begin = path.length_mm();
    path.pieces.push_back(whole);
    path.pieces.back().begin_mm = begin;
    path.bound.tip_mm = std::max(path.bound.tip_mm, beyond_middle * off_mm);
    path.bound.orientation_rad = std::max(path.bound.orientation_rad, beyond_middle * off_rad);
}

void append_block(const ProgrammedBlock& block, path::ToolPath& path) {
    if (block.curve()) return append_curve(block, 0, 1, 0, path);
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
