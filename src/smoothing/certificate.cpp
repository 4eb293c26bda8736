#include "detail/certificate.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "detail/septic.hpp"

namespace trunnion::smoothing {

namespace {

constexpr int most_halvings = 6;
constexpr double worth_halving = 1.01;  // a hull that exceeds the largest deviation seen by more than this
constexpr double least_speed = 0.05;    // |c′|
constexpr int most_speed_halvings = 5;
constexpr double least_lever_of_length = 0.1;  // as in the definition of p

/// A piece ∩ block: the shipped polynomial there and the straight block beneath it.
struct Cell {
    Bernstein curve;
    Coordinates from, to;
    double lever;  // upper bound of the lever on P
    std::size_t block;
    double middle_mm, half_mm;  // on the block
};

class Prover {
  public:
    Prover(const path::Run& run, const Curve& curve, Certificate& out)
        : run_(run), curve_(curve), measure_(curve.measure), out_(out), lever_axis_(lever_axis(run)) {
        const double turn = curve.line.largest_turn_rad;
        sideways_ = 0.017 * turn * turn * turn;              // θ³/6·max t(1−t)(1−2t)
        chord_error_mm_ = 1.01 * curve.line.chord_error_mm;  // and what it is off along the chord
    }

    void cell(const Cell& c) { prove(c.curve, c.from, c.to, c, 0); }

    /// Use of the tolerances there, from the nearest places too; notes where it is too much.
    void vertex(const Coordinates& deviation, std::size_t vertex) {
        const double use = curve_.use_nearby(deviation, {vertex, 0});
        out_.use_at_vertex.push_back(use);
        if (use <= 1) return;
        const double of_curve = measure_.use(curve_.bumps.deviation({vertex, 0}).curve, curve_.lever(vertex));
        out_.excess.push_back({{vertex, 0}, 0, {std::min(of_curve, use), use}});
    }

    double lever_bound(const Coordinates& from, const Coordinates& to) const {
        if (lever_axis_ < 0) return 1;
        const int other = lever_axis_ == 3 ? 4 : 3;
        return std::min(1.0, lever_at(run_, 0.5 * (from + to)) + 0.5 * std::abs(to[other] - from[other]));
    }

  private:
    struct Extent {
        double tip = 0, turn = 0, height = 0;
    };

    Extent measured(const Coordinates& d, double lever) const {
        return {measure_.point(d, lever, measure_.controlled_height_mm()), measure_.turn(d, lever),
                measure_.point(d, lever, measure_.flank_height_mm())};
    }

    static void widen(Extent& a, const Extent& b) {
        a.tip = std::max(a.tip, b.tip);
        a.turn = std::max(a.turn, b.turn);
        a.height = std::max(a.height, b.height);
    }

    /// Only the part of a vector's deviation across the tool axis turns it. Takes the part along the axis at the cell's
    /// middle out of `d` and adds to `slack` what that and the linear measures leave out, as an angle.
    double take_across(Bernstein& d, const Bernstein& curve, const Coordinates& from, const Coordinates& to) const {
        const Eigen::Vector3d along = (from + to).tail<3>().normalized();
        const double half_turn =
            (to - from).tail<3>().norm();  // twice the half: the chord's ends lie inside the sphere
        double all = 0, across = 0, radial = 0;
        for (int k = 0; k < 8; ++k) {
            const Eigen::Vector3d n = d[k].tail<3>();
            const double length = along.dot(n);
            d[k].tail<3>() -= length * along;
            all = std::max(all, n.norm());
            across = std::max(across, d[k].tail<3>().norm());
            radial = std::max({radial, curve[k].tail<3>().norm() - 1, 1 - along.dot(curve[k].tail<3>())});
        }
        if (radial > 0.5) return std::numbers::pi;
        const double sine = (across + all * half_turn) / (1 - radial);
        return all * half_turn + sine * radial + sine * sine + sideways_;
    }

    /// The lever on the deviated path too.
    double lever_beside(const Bernstein& d, double lever) const {
        if (lever_axis_ < 0) return 1;
        const int other = lever_axis_ == 3 ? 4 : 3;
        double largest = 0;
        for (const Coordinates& x : d) largest = std::max(largest, std::abs(x[other]));
        return std::min(1.0, lever + largest);
    }

    void prove(const Bernstein& curve, const Coordinates& from, const Coordinates& to, const Cell& cell, int depth) {
        Bernstein d;
        for (int k = 0; k < 8; ++k) d[k] = curve[k] - (from + (to - from) * (k / 7.0));
        const double beyond = measure_.vectors() ? take_across(d, curve, from, to) : 0;
        const double lever = lever_beside(d, cell.lever);
        Extent ends = measured(d[0], lever);
        widen(ends, measured(d[7], lever));
        widen(seen_, ends);
        Extent hull = ends;
        for (int k = 1; k < 7; ++k) widen(hull, measured(d[k], lever));
        hull.tip += measure_.controlled_height_mm() * beyond + chord_error_mm_;
        hull.turn += beyond;
        hull.height += measure_.flank_height_mm() * beyond + chord_error_mm_;
        if (depth == most_halvings || !slack(hull)) return conclude(hull, cell);
        const Coordinates middle = 0.5 * (from + to);
        Bernstein after = curve;
        const Bernstein before = split(after, 0.5);
        prove(before, from, middle, cell, depth + 1);
        prove(after, middle, to, cell, depth + 1);
    }

    bool slack(const Extent& hull) const {
        const double near_mm = chord_error_mm_ + 1e-9;
        return hull.tip > worth_halving * seen_.tip + near_mm || hull.turn > worth_halving * seen_.turn + 1e-11 ||
               hull.height > worth_halving * seen_.height + near_mm;
    }

    void conclude(const Extent& hull, const Cell& cell) {
        auto& bound = out_.bound;
        bound.tip_mm = std::max(bound.tip_mm, hull.tip);
        bound.orientation_rad = std::max(bound.orientation_rad, hull.turn);
        bound.height_mm = std::max(bound.height_mm, hull.height);
        const double use = measure_.use_of(hull.tip, hull.turn, hull.height);
        if (use <= 1) return;
        const double of_curve = measure_.use(curve_.bumps.deviation({cell.block, cell.middle_mm}).curve, cell.lever);
        out_.excess.push_back({{cell.block, cell.middle_mm}, cell.half_mm, {std::min(of_curve, use), use}});
    }

    const path::Run& run_;
    const Curve& curve_;
    const Measure& measure_;
    Certificate& out_;
    int lever_axis_;
    double sideways_ = 0;  // a slerp from its chord, as an angle
    double chord_error_mm_ = 0;
    Extent seen_;  // deviations that do occur in this section
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
        if (!is_regular(rest, piece.length_mm, lever_index, curve.lever(block))) out.irregular.push_back(block);
        for (bool piece_ends = false; !piece_ends;) {
            const double block_end = block_begin + bumps.gap[block];
            const double end = std::min(piece_end, block_end);
            piece_ends = end == piece_end;
            const bool block_ends = end == block_end;
            const Coordinates from = programmed(block, begin - block_begin);
            const Coordinates to = block_ends ? programmed(block + 1, 0) : programmed(block, end - block_begin);
            if (at_vertex) prover.vertex(rest[0] - from, block);
            const Bernstein part = split(rest, piece_ends ? 1.0 : (end - begin) / (piece_end - begin));
            prover.cell({part, from, to, prover.lever_bound(from, to), block, 0.5 * (begin + end) - block_begin,
                         0.5 * (end - begin)});
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
