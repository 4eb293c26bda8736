#include "detail/section.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "detail/septic.hpp"

namespace trunnion::smoothing {

namespace {

constexpr double caps_per_section = 8;
constexpr double piece_per_width = 1.0 / 3;
constexpr double agreement_mm = 1e-4;
constexpr double negligible_mm = 1e-7;  // a bump so low needs no pieces of its own
constexpr int most_halvings = 40;

/// Where a bump lies in the section.
struct Support {
    double begin_mm, end_mm, width_mm;
};

struct Station {
    Place place;
    double at_mm;  // from the section's start
    Jet jet;
};

class Representation {
  public:
    Representation(const Curve& curve, Section& section) : bumps_(curve.bumps), line_(curve.line), section_(section) {
        block_begin_.push_back(0);
        for (std::size_t b = section.first; b < section.last; ++b)
            block_begin_.push_back(block_begin_.back() + bumps_.gap[b]);
    }

    void make() {
        section_.pieces.clear();
        section_.length_mm = block_begin_.back();
        collect_supports();
        const Station begin = vertex_station(section_.first), end = vertex_station(section_.last);
        refine(begin, end, 0, 0);
    }

  private:
    /// At a vertex, the block before it stands for the end of the section: both sides give the same jet.
    Station vertex_station(std::size_t vertex) const {
        Station s{{vertex, 0}, block_begin_[vertex - section_.first], bumps_.jet({vertex, 0})};
        if (vertex == section_.last) s.place = {vertex - 1, bumps_.gap[vertex - 1]};
        if (vertex == bumps_.first() || vertex == bumps_.last()) s.jet[0].setZero(), s.jet[2].setZero();
        return s;
    }

    Place place(double at_mm) const {
        const auto next = std::upper_bound(block_begin_.begin() + 1, block_begin_.end() - 1, at_mm);
        const std::size_t index = static_cast<std::size_t>(next - block_begin_.begin()) - 1;
        const std::size_t block = section_.first + index;
        return {block, std::clamp(at_mm - block_begin_[index], 0.0, bumps_.gap[block])};
    }

    Station station(double at_mm) const {
        const Place where = place(at_mm);
        return {where, at_mm, bumps_.jet(where)};
    }

    /// P(to) − P(from), summed along the way.
    Coordinates way(Place from, Place to) const {
        if (from.block == to.block) return bumps_.slope[from.block] * (to.offset_mm - from.offset_mm);
        Coordinates sum = bumps_.slope[from.block] * (bumps_.gap[from.block] - from.offset_mm);
        for (std::size_t b = from.block + 1; b < to.block; ++b) sum += bumps_.slope[b] * bumps_.gap[b];
        return sum + bumps_.slope[to.block] * to.offset_mm;
    }

    void collect_supports() {
        supports_.clear();
        const auto add = [&](std::size_t j, double at, double share, double width) {
            if (size_mm(bumps_.jump[j]) * share * width < negligible_mm) return;
            const Support s{at - width, at + width, width};
            if (s.end_mm > 0 && s.begin_mm < section_.length_mm) supports_.push_back(s);
        };
        const double middle = 0.5 * section_.length_mm;
        const Place where = place(middle);
        bumps_.touching(where, middle, [&](std::size_t j, double d) {
            add(j, middle - d, 1 - bumps_.corner_share[j], bumps_.curve_width[j]);
            add(j, middle - d, bumps_.corner_share[j], bumps_.corner_width[j]);
        });
    }

    /// Appends those of supports_[from …] that touch the interval; returns the narrowest width.
    double narrow_down(std::size_t from, std::size_t to, double begin_mm, double end_mm) {
        double narrowest = std::numeric_limits<double>::infinity();
        for (std::size_t i = from; i < to; ++i) {
            const Support s = supports_[i];
            if (s.end_mm <= begin_mm || s.begin_mm >= end_mm) continue;
            supports_.push_back(s);
            narrowest = std::min(narrowest, s.width_mm);
        }
        return narrowest;
    }

    void refine(const Station& a, const Station& b, std::size_t supports_from, int depth) {
        const std::size_t mine = supports_.size();
        const double length = b.at_mm - a.at_mm;
        const double narrowest = narrow_down(supports_from, mine, a.at_mm, b.at_mm);
        const bool last = depth == most_halvings || !(length > 1e-9 * narrowest);
        if (last || length <= piece_per_width * narrowest) {
            const path::PathPiece piece = between(a, b);
            if (last || agrees(piece, a)) {
                section_.pieces.push_back(piece);
                supports_.resize(mine);
                return;
            }
        }
        const Station middle = station(0.5 * (a.at_mm + b.at_mm));
        refine(a, middle, mine, depth + 1);
        refine(middle, b, mine, depth + 1);
        supports_.resize(mine);
    }

    path::PathPiece between(const Station& a, const Station& b) const {
        const Coordinates begin =
            line_.vertex[a.place.block - bumps_.first()] + bumps_.slope[a.place.block] * a.place.offset_mm;
        return hermite_piece(a.at_mm, b.at_mm - a.at_mm, {begin + a.jet[0], a.jet[1], a.jet[2], a.jet[3]},
                             {way(a.place, b.place) + b.jet[0] - a.jet[0], b.jet[1], b.jet[2], b.jet[3]});
    }

    bool agrees(const path::PathPiece& piece, const Station& a) const {
        for (const double u : {0.25, 0.75}) {
            const Place where = place(a.at_mm + u * piece.length_mm);
            const Deviation d = bumps_.deviation(where);
            const Coordinates exact = way(a.place, where) + d.curve + d.corner - a.jet[0];
            if (size_mm(progress(piece, u) - exact) > agreement_mm) return false;
        }
        return true;
    }

    const Bumps& bumps_;
    const Polyline& line_;
    Section& section_;
    std::vector<double> block_begin_;
    std::vector<Support> supports_;  // a stack: each interval puts its own on top
};

}  // namespace

std::vector<Section> make_sections(const Curve& curve) {
    const Bumps& bumps = curve.bumps;
    std::vector<Section> sections;
    Section open{bumps.first(), bumps.first(), 0, {}};
    for (std::size_t b = bumps.first(); b < bumps.last(); ++b) {
        open.length_mm += bumps.gap[b];
        open.last = b + 1;
        if (open.length_mm < caps_per_section * bumps.cap_mm() && open.last != bumps.last()) continue;
        sections.push_back(open);
        open = {b + 1, b + 1, 0, {}};
    }
    return sections;
}

void represent(const Curve& curve, Section& section) {
    Representation(curve, section).make();
}

}  // namespace trunnion::smoothing
