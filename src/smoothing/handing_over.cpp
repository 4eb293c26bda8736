#include "detail/handing_over.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <ranges>
#include <utility>

#include "detail/rounded_corner.hpp"
#include "detail/widths.hpp"

namespace trunnion::smoothing {

namespace {

constexpr double mostly = 0.5;  // of a kink, and of a block
constexpr double no_bend = 1e-11;
constexpr double same_slope = 1e-10;
constexpr double sliver = 1e-9;  // of a piece

Coordinates coefficient(const path::PathPiece& piece, int power) {
    Coordinates c;
    for (int k = 0; k < 6; ++k) c[k] = piece.coefficient[k][power];
    return c;
}

Coordinates slope_of(const path::PathPiece& piece) {
    return coefficient(piece, 1) / piece.length_mm;
}

bool is_straight(const path::PathPiece& piece) {
    for (int power = 2; power < 8; ++power)
        if (size_mm(coefficient(piece, power)) > no_bend * std::max(1.0, piece.length_mm)) return false;
    return true;
}

Coordinates begin_of(const path::PathPiece& piece) {
    return coefficient(piece, 0);
}

/// The straight part at an end of a path: seen from the corner there.
struct Leg {
    double length_mm = 0;
    Coordinates away = Coordinates::Zero();  ///< to its far end
};

template <class Pieces>
Leg leg_of(const Pieces& pieces_from_corner, double sign) {
    Leg leg;
    const Coordinates slope = slope_of(*pieces_from_corner.begin());
    for (const path::PathPiece& piece : pieces_from_corner) {
        if (!is_straight(piece) || size_mm(slope_of(piece) - slope) > same_slope) break;
        leg.length_mm += piece.length_mm;
    }
    leg.away = sign * leg.length_mm * slope;
    return leg;
}

/// The part of a straight piece between two shares of it.
path::PathPiece part_of(path::PathPiece piece, double from, double to) {
    for (auto& c : piece.coefficient) c = {c[0] + from * c[1], (to - from) * c[1], 0, 0, 0, 0, 0, 0};
    piece.begin_mm += from * piece.length_mm;
    piece.length_mm *= to - from;
    return piece;
}

/// Takes `length_mm` of straight pieces off the end. No sliver is left or taken.
void shorten_end(std::vector<path::PathPiece>& pieces, double length_mm) {
    while (!pieces.empty() && length_mm >= pieces.back().length_mm * (1 - sliver)) {
        length_mm -= pieces.back().length_mm;
        pieces.pop_back();
    }
    if (pieces.empty() || length_mm <= sliver * pieces.back().length_mm) return;
    pieces.back() = part_of(pieces.back(), 0, 1 - length_mm / pieces.back().length_mm);
}

void shorten_begin(std::vector<path::PathPiece>& pieces, double length_mm) {
    auto first = pieces.begin();
    for (; first != pieces.end() && length_mm >= first->length_mm * (1 - sliver); ++first)
        length_mm -= first->length_mm;
    pieces.erase(pieces.begin(), first);
    if (pieces.empty() || length_mm <= sliver * pieces.front().length_mm) return;
    pieces.front() = part_of(pieces.front(), length_mm / pieces.front().length_mm, 1);
}

/// Rounds the corner between two stretches and makes one of them; not if it cannot be.
class Joiner {
  public:
    Joiner(const path::Run& run, VertexRange range, const Measure& measure, Link link)
        : run_(run), measure_(measure), line_(chords(run, range, measure)), hull_(run, measure, line_), link_(link) {}

    bool join(path::ToolPath& before, path::ToolPath&& after) {
        const std::size_t vertex = after.blocks.front().run_block;
        const Leg back = leg_of(before.pieces | std::views::reverse, -1), ahead = leg_of(after.pieces, 1);
        if (!(back.length_mm > 0 && ahead.length_mm > 0)) return false;
        const Coordinates at = begin_of(after.pieces.front());
        const CornerLegs legs{{back.away, ahead.away},
                              {back.length_mm, ahead.length_mm},
                              {share(vertex - 1, back), share(vertex, ahead)},
                              std::max(lever_at(run_, at), least_lever)};
        const auto corner = round_corner(at, legs, link_, measure_, hull_);
        if (!corner || !corner->joins_smoothly) return false;
        put_together(before, std::move(after), *corner);
        return true;
    }

  private:
    /// Of a leg, so that the corner takes at most half of its block.
    double share(std::size_t block, const Leg& leg) const {
        return std::min(1.0, mostly * run_.blocks[block].length_mm / leg.length_mm);
    }

    void put_together(path::ToolPath& before, path::ToolPath&& after, const RoundedCorner& corner) {
        const double length = before.length_mm();
        shorten_end(before.pieces, corner.reach_mm[0]);
        for (path::PathPiece piece : corner.pieces) {
            piece.begin_mm += length - corner.reach_mm[0];
            before.pieces.push_back(piece);
        }
        shorten_begin(after.pieces, corner.reach_mm[1]);
        for (path::PathPiece& piece : after.pieces) {
            piece.begin_mm += length;
            before.pieces.push_back(piece);
        }
        for (path::BlockSpan& span : after.blocks) {
            span.begin_mm += length;
            span.end_mm += length;
            before.blocks.push_back(span);
        }
        before.blocks.back().end_mm = before.length_mm();
        const double use =
            measure_.use(corner.at_vertex, std::max(lever_at(run_, begin_of(corner.pieces.back())), least_lever));
        before.transition_use.push_back(static_cast<float>(use));
        before.transition_use.insert(before.transition_use.end(), after.transition_use.begin(),
                                     after.transition_use.end());
        Extent bound = corner.extent;
        for (const auto& b : {before.bound, after.bound}) widen(bound, {b.tip_mm, b.orientation_rad, b.height_mm});
        before.bound = {bound.tip, bound.turn, bound.height};
        before.stop = after.stop;
    }

    const path::Run& run_;
    const Measure& measure_;
    Polyline line_;
    DeviationHull hull_;
    Link link_;
};

}  // namespace

std::vector<std::size_t> lone_corners(const path::Run& run, VertexRange range, const Measure& measure) {
    Curve curve(chords(run, range, measure), measure);
    find_widths(curve);
    const Bumps& bumps = curve.bumps;
    std::vector<std::size_t> out;
    for (std::size_t k = 1; k + 1 < curve.line.vertex.size(); ++k) {
        if (curve.line.programmed[k] < 0) continue;
        const auto vertex = static_cast<std::size_t>(curve.line.programmed[k]);
        const path::Block &before = run.blocks[vertex - 1], &after = run.blocks[vertex];
        if (is_round(before) || is_round(after)) continue;
        const std::size_t j = bumps.first() + k;
        const double shorter = std::min(before.length_mm, after.length_mm);
        if (bumps.corner_share[j] > mostly && bumps.corner_width[j] < mostly * shorter) out.push_back(vertex);
    }
    return out;
}

void smooth_with_handed_corners(const path::Run& run, VertexRange range, path::StopCause stop,
                                const SmoothingOptions& options, const SmoothRange& between,
                                std::vector<path::ToolPath>& out) {
    const Measure measure(run, range, options);
    Joiner joiner(run, range, measure, options.link);
    std::vector<std::size_t> ends = lone_corners(run, range, measure);
    ends.push_back(range.last);
    for (;;) {
        std::vector<path::ToolPath> made;
        std::vector<std::size_t> given_back;
        std::size_t first = range.first;
        for (const std::size_t last : ends) {
            std::vector<path::ToolPath> part;
            between({first, last}, last == range.last ? stop : path::StopCause::corner, part);
            const bool joined = !made.empty() && joiner.join(made.back(), std::move(part.front()));
            if (!made.empty() && !joined) given_back.push_back(first);
            made.insert(made.end(), std::make_move_iterator(part.begin() + (joined ? 1 : 0)),
                        std::make_move_iterator(part.end()));
            first = last;
        }
        if (given_back.empty()) {
            out.insert(out.end(), std::make_move_iterator(made.begin()), std::make_move_iterator(made.end()));
            return;
        }
        std::erase_if(ends, [&](std::size_t vertex) { return std::ranges::binary_search(given_back, vertex); });
    }
}

}  // namespace trunnion::smoothing
