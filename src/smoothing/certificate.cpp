#include "detail/certificate.hpp"

#include <algorithm>
#include <cmath>

#include "detail/deviation_hull.hpp"

namespace trunnion::smoothing {

namespace {

constexpr double least_speed = 0.05;  // |c′|
constexpr int most_speed_halvings = 5;
constexpr double least_lever_of_length = 0.1;  // as in the definition of p

/// A piece ∩ block: the shipped polynomial there and the straight block beneath it.
struct Cell {
    Bernstein curve;
    Coordinates from, to;
    std::size_t block;
    double middle_mm, half_mm;  // on the block
};

class Prover {
  public:
    Prover(const path::Run& run, const Curve& curve, Certificate& out)
        : curve_(curve), measure_(curve.measure), hull_(run, curve.measure, curve.line), out_(out) {}

    /// Bounds the deviation there; notes where it is too much.
    void cell(const Cell& c) {
        const Extent extent = hull_.over(c.curve, c.from, c.to);
        auto& bound = out_.bound;
        bound.tip_mm = std::max(bound.tip_mm, extent.tip);
        bound.orientation_rad = std::max(bound.orientation_rad, extent.turn);
        bound.height_mm = std::max(bound.height_mm, extent.height);
        const double use = measure_.use_of(extent.tip, extent.turn, extent.height);
        if (use <= 1) return;
        const double of_curve =
            measure_.use(curve_.bumps.deviation({c.block, c.middle_mm}).curve, hull_.lever_bound(c.from, c.to));
        out_.excess.push_back({{c.block, c.middle_mm}, c.half_mm, {std::min(of_curve, use), use}});
    }

    /// Use of the tolerances there, from the nearest places too; notes where it is too much.
    void vertex(const Coordinates& deviation, std::size_t vertex) {
        const double use = curve_.use_nearby(deviation, {vertex, 0});
        out_.use_at_vertex.push_back(use);
        if (use <= 1) return;
        // Seen from the nearest places, curve and corners have the shares that they have at equal p.
        const double lever = curve_.lever(vertex), all = measure_.use(deviation, lever);
        const double of_curve = measure_.use(curve_.bumps.deviation({vertex, 0}).curve, lever);
        out_.excess.push_back({{vertex, 0}, 0, {of_curve < all ? use * of_curve / all : use, use}});
    }

  private:
    const Curve& curve_;
    const Measure& measure_;
    DeviationHull hull_;
    Certificate& out_;
};

/// Whether a hodograph stays away from 0: all of it on the far side of a plane across its middle.
bool is_regular(const std::array<Coordinates, 7>& hodograph, int depth) {
    const Coordinates middle = (hodograph[0] + hodograph[6]) * 0.5 + hodograph[3];
    const Coordinates along = middle.normalized();
    bool ahead = true;
    for (const Coordinates& b : hodograph) ahead = ahead && along.dot(b) > least_speed;
    if (ahead || depth == most_speed_halvings) return ahead;
    std::array<Coordinates, 7> after = hodograph, before;
    for (int level = 0; level < 7; ++level) {
        before[level] = after[0];
        for (int i = 0; i + level < 6; ++i) after[i] = 0.5 * (after[i] + after[i + 1]);
    }
    return is_regular(before, depth + 1) && is_regular(after, depth + 1);
}

bool is_regular(const Bernstein& curve, double length_mm, int lever_axis, double lever) {
    std::array<Coordinates, 7> hodograph;
    for (int k = 0; k < 7; ++k) {
        hodograph[k] = (7 / length_mm) * (curve[k + 1] - curve[k]);
        hodograph[k].tail<3>() *= path::reference_height_mm;
        if (lever_axis >= 0) hodograph[k][lever_axis] *= std::max(lever, least_lever_of_length);
    }
    return is_regular(hodograph, 0);
}

}  // namespace

Certificate certify(const path::Run& run, const Curve& curve, const Section& section) {
    const Bumps& bumps = curve.bumps;
    const int lever_index = lever_axis(run);
    const auto programmed = [&](std::size_t block, double offset_mm) -> Coordinates {
        return curve.line.vertex[block - bumps.first()] + bumps.slope[block] * offset_mm;
    };
    Certificate out;
    Prover prover(run, curve, out);
    std::size_t block = section.first;
    double block_begin = 0, begin = 0;
    bool at_vertex = true;
    for (std::size_t i = 0; i < section.pieces.size(); ++i) {
        const path::PathPiece& piece = section.pieces[i];
        const double piece_end = i + 1 < section.pieces.size() ? section.pieces[i + 1].begin_mm : section.length_mm;
        Bernstein rest = bernstein(piece);
        const bool regular = is_regular(rest, piece.length_mm, lever_index, curve.lever(block));
        for (bool piece_ends = false; !piece_ends;) {
            if (!regular) out.irregular.push_back(block);
            const double block_end = block_begin + bumps.gap[block];
            const double end = std::min(piece_end, block_end);
            piece_ends = end == piece_end;
            const bool block_ends = end == block_end;
            const Coordinates from = programmed(block, begin - block_begin);
            const Coordinates to = block_ends ? programmed(block + 1, 0) : programmed(block, end - block_begin);
            if (at_vertex) prover.vertex(rest[0] - from, block);
            const Bernstein part = split(rest, piece_ends ? 1.0 : (end - begin) / (piece_end - begin));
            prover.cell({part, from, to, block, 0.5 * (begin + end) - block_begin, 0.5 * (end - begin)});
            begin = end;
            at_vertex = block_ends;
            if (!block_ends) continue;
            block_begin = block_end;
            ++block;
        }
    }
    return out;
}

}  // namespace trunnion::smoothing
