#include "trunnion/smoothing/splice.hpp"

#include <algorithm>
#include <cmath>

#include "detail/septic.hpp"

namespace trunnion::smoothing {

namespace {

using path::PathPiece;
using path::ToolPath;

constexpr double least_share = 0.5;  // of a piece that is left behind the joint: else it ends with the next one

Coordinates coefficients_at(const std::array<Taylor3, 6>& at, int order) {
    constexpr std::array<double, 4> factorial{1, 1, 2, 6};
    Coordinates out;
    for (int c = 0; c < 6; ++c) out[c] = factorial[order] * at[c].c[order];
    return out;
}

HermiteEnd state_at(const PathPiece& piece, double offset_mm) {
    const auto at = path::evaluate(piece, offset_mm);
    return {coefficients_at(at, 0), coefficients_at(at, 1), coefficients_at(at, 2), coefficients_at(at, 3)};
}

double end_mm(const PathPiece& piece) {
    return piece.begin_mm + piece.length_mm;
}

std::size_t piece_at(const ToolPath& path, double p_mm) {
    const auto next = std::upper_bound(path.pieces.begin() + 1, path.pieces.end(), p_mm,
                                       [](double p, const PathPiece& piece) { return p < piece.begin_mm; });
    return static_cast<std::size_t>(next - path.pieces.begin()) - 1;
}

/// What `bridge` is at most off the pieces beneath it, at a few places: it has their values and derivatives at an end.
Coordinates farthest_off(const PathPiece& bridge, const ToolPath& path, double behind_mm) {
    constexpr int looks = 8;
    Coordinates out = Coordinates::Zero();
    for (int k = 1; k < looks; ++k) {
        const double offset = bridge.length_mm * k / looks, p = bridge.begin_mm + offset - behind_mm;
        const PathPiece& beneath = path.pieces[piece_at(path, p)];
        const auto is = path::evaluate(bridge, offset), was = path::evaluate(beneath, p - beneath.begin_mm);
        for (int c = 0; c < 6; ++c) out[c] = std::max(out[c], std::abs(is[c].value() - was[c].value()));
    }
    return out;
}

/// Blocks of the first path that begin before the joint, then those of the second that end behind it.
void take_blocks(const ToolPath& first, const ToolPath& second, double from_mm, double at_mm, double behind_mm,
                 ToolPath& out) {
    for (const path::BlockSpan& block : first.blocks)
        if (block.end_mm > from_mm && block.begin_mm < at_mm) out.blocks.push_back(block);
    const std::size_t from_first = out.blocks.size();
    for (const path::BlockSpan& block : second.blocks) {
        if (block.end_mm + behind_mm <= at_mm) continue;
        const bool is_the_same =
            from_first > 0 && out.blocks.size() == from_first && block.line == out.blocks.back().line;
        if (!is_the_same) out.blocks.push_back(block);
        if (!is_the_same)
            out.blocks.back().begin_mm = out.blocks.size() > 1 ? out.blocks[out.blocks.size() - 2].end_mm : from_mm;
        out.blocks.back().end_mm = block.end_mm + behind_mm;
    }
    for (path::BlockSpan& block : out.blocks) {
        block.begin_mm = std::max(block.begin_mm - from_mm, 0.0);
        block.end_mm -= from_mm;
    }
}

}  // namespace

std::optional<ToolPath> spliced(const ToolPath& first, const ToolPath& second, const Splice& where,
                                double largest_gap) {
    const double from_mm = first.pieces[where.from_piece].begin_mm, at_mm = first.pieces[where.at_piece].begin_mm;
    const double p = at_mm - where.behind_mm;
    if (where.at_piece <= where.from_piece || p < 0 || p >= second.length_mm()) return std::nullopt;
    std::size_t next = piece_at(second, p);
    const HermiteEnd begin = state_at(first.pieces[where.at_piece - 1], first.pieces[where.at_piece - 1].length_mm);
    const HermiteEnd there = state_at(second.pieces[next], p - second.pieces[next].begin_mm);
    if (size_mm(begin.value - there.value) > largest_gap) return std::nullopt;
    if (end_mm(second.pieces[next]) - p < least_share * second.pieces[next].length_mm) ++next;
    if (next >= second.pieces.size()) return std::nullopt;

    ToolPath out = first;
    out.kinematics = second.kinematics;
    out.pieces.assign(first.pieces.begin() + static_cast<std::ptrdiff_t>(where.from_piece),
                      first.pieces.begin() + static_cast<std::ptrdiff_t>(where.at_piece));
    HermiteEnd end = state_at(second.pieces[next], second.pieces[next].length_mm);
    end.value -= begin.value;
    out.pieces.push_back(hermite_piece(at_mm, end_mm(second.pieces[next]) - p, begin, end));
    const Coordinates off = farthest_off(out.pieces.back(), second, where.behind_mm);
    for (++next; next < second.pieces.size(); ++next) {
        out.pieces.push_back(second.pieces[next]);
        out.pieces.back().begin_mm += where.behind_mm;
    }
    for (PathPiece& piece : out.pieces) piece.begin_mm -= from_mm;
    out.blocks.clear();
    take_blocks(first, second, from_mm, at_mm, where.behind_mm, out);
    out.transition_use.clear();
    out.bound.tip_mm = std::max(first.bound.tip_mm, second.bound.tip_mm + off.head<3>().norm());
    out.bound.orientation_rad =
        std::max(first.bound.orientation_rad, second.bound.orientation_rad + off.tail<3>().norm());
    out.bound.height_mm = std::max(first.bound.height_mm, second.bound.height_mm + size_mm(off));
    out.stop = second.stop;
    return out;
}

}  // namespace trunnion::smoothing
