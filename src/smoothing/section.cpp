#include "detail/section.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
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

/// Supports that overlap or nearly do, in order; away from islands the curve is the programmed line.
struct Island {
    double begin_mm, end_mm;
    std::size_t first, behind;
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
        Station here = vertex_station(section_.first);
        const Station end = vertex_station(section_.last);
        for (const Island& island : islands()) {
            if (island.begin_mm > here.at_mm) here = refined(here, station_at_sea(island.begin_mm), 0, 0);
            const Station behind = island.end_mm < section_.length_mm ? station_at_sea(island.end_mm) : end;
            here = refined(here, behind, island.first, island.behind);
        }
        if (here.at_mm < section_.length_mm) refined(here, end, 0, 0);
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

    /// Where no bump is: at its very end a bump's rounding would be felt along the long piece that begins there.
    Station station_at_sea(double at_mm) const {
        const Place where = place(at_mm);
        return {where, at_mm,
                Jet{Coordinates::Zero(), bumps_.slope[where.block], Coordinates::Zero(), Coordinates::Zero()}};
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
        std::sort(supports_.begin(), supports_.end(),
                  [](const Support& a, const Support& b) { return a.begin_mm < b.begin_mm; });
    }

    /// Islands at least a piece's length apart from each other and from the section's ends, or right there.
    std::vector<Island> islands() const {
        std::vector<Island> islands;
        double margin = 0;  // of the island's bump that reaches farthest
        for (std::size_t i = 0; i < supports_.size(); ++i) {
            const Support& s = supports_[i];
            const double own = piece_per_width * s.width_mm;
            const double sea_from = islands.empty() ? 0 : islands.back().end_mm;
            if (islands.empty() || s.begin_mm > sea_from + std::max(margin, own)) {
                islands.push_back({islands.empty() && s.begin_mm <= own ? 0 : s.begin_mm, s.end_mm, i, i + 1});
                margin = own;
                continue;
            }
            islands.back().behind = i + 1;
            if (s.end_mm <= sea_from) continue;
            islands.back().end_mm = s.end_mm;
            margin = own;
        }
        if (!islands.empty() && islands.back().end_mm + margin >= section_.length_mm)
            islands.back().end_mm = section_.length_mm;
        return islands;
    }

    /// Appends those of supports_[from …] that touch the interval; returns the narrowest width.
    double narrow_down(std::size_t from, std::size_t to, double begin_mm, double end_mm) {
        double narrowest = std::numeric_limits<double>::infinity();
        for (std::size_t i = from; i < to; ++i) {
            const Support s = supports_[i];
            const double touch = 1e-9 * s.width_mm;
            if (s.end_mm <= begin_mm + touch || s.begin_mm >= end_mm - touch) continue;
            supports_.push_back(s);
            narrowest = std::min(narrowest, s.width_mm);
        }
        return narrowest;
    }

    /// Appends the pieces between two stations, on which supports_[first … behind) lie; returns the second.
    Station refined(const Station& a, const Station& b, std::size_t first, std::size_t behind) {
        refine(a, b, first, behind, 0);
        return b;
    }

    void refine(const Station& a, const Station& b, std::size_t first, std::size_t behind, int depth) {
        const std::size_t mine = supports_.size();
        const double length = b.at_mm - a.at_mm;
        const double narrowest = narrow_down(first, behind, a.at_mm, b.at_mm);
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
        const std::size_t mine_end = supports_.size();
        refine(a, middle, mine, mine_end, depth + 1);
        refine(middle, b, mine, mine_end, depth + 1);
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

/// A number in [0, 1), evenly spread, that is drawn from a vertex's coordinates alone (mixing by SplitMix64).
double lot(const Coordinates& vertex) {
    std::uint64_t mixed = 0;
    for (const double x : vertex) {
        std::uint64_t z = mixed ^ std::bit_cast<std::uint64_t>(x + 0.0);  // −0 as 0
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
        z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
        mixed = (z ^ (z >> 31)) + 0x9e3779b97f4a7c15ULL;
    }
    return static_cast<double>(mixed >> 11) * 0x1p-53;
}

}  // namespace

std::vector<Section> make_sections(const Curve& curve) {
    const Bumps& bumps = curve.bumps;
    const double usual_mm = caps_per_section * bumps.cap_mm();
    std::vector<Section> sections;
    Section open{bumps.first(), bumps.first(), 0, {}};
    for (std::size_t k = bumps.first() + 1; k <= bumps.last(); ++k) {
        open.length_mm += bumps.gap[k - 1];
        open.last = k;
        const std::size_t vertex = k - bumps.first();
        const bool cut = curve.line.programmed[vertex] >= 0 &&
                         lot(curve.line.vertex[vertex]) * usual_mm < 0.5 * (bumps.gap[k - 1] + bumps.gap[k]);
        if (!cut && k != bumps.last()) continue;
        sections.push_back(open);
        open = {k, k, 0, {}};
    }
    return sections;
}

void represent(const Curve& curve, Section& section) {
    Representation(curve, section).make();
}

}  // namespace trunnion::smoothing
