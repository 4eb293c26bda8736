#include "detail/pole.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "trunnion/smoothing/pole_tolerance.hpp"

#include "detail/septic.hpp"

namespace trunnion::smoothing {

namespace {

constexpr double part_of_tolerance = 0.8;  // so far the programmed path may pass from the pole
constexpr double longest_part = 0.9;       // of the tolerance: a shift
constexpr double least_excess = 1.05;      // that is worth narrowing for
constexpr double search_mm = 6;            // kernels move the nearest place by less
constexpr double same_place_mm = 1e-3;     // a piece of path should not be shorter
constexpr double little_of_piece = 0.25;   // a part as small is not cut off
constexpr double same_border_mm = 1e-9;
constexpr double shortest_reach_mm = 0.01;

using Polynomial = std::array<double, 8>;

/// c(from + (to − from)·t) by powers of t.
Polynomial part_of(Polynomial c, double from, double to) {
    for (int low = 0; low < 7; ++low)
        for (int i = 6; i >= low; --i) c[i] += from * c[i + 1];
    double power = 1;
    for (double& x : c) {
        x *= power;
        power *= to - from;
    }
    return c;
}

/// h of a shift along [begin, end], by powers of the share of that interval. Precondition: it has no border inside.
Polynomial share_of(const PoleShift& shift, double begin_mm, double end_mm) {
    const double middle = 0.5 * (begin_mm + end_mm);
    if (middle > shift.whole_from_mm && middle < shift.whole_to_mm) return {1};
    const bool before = middle < shift.at_mm;
    const double whole = before ? shift.whole_from_mm : shift.whole_to_mm,
                 none = before ? shift.begin_mm : shift.end_mm;
    return part_of({1, 0, 0, 0, -35, 84, -70, 20}, (begin_mm - whole) / (none - whole),
                   (end_mm - whole) / (none - whole));
}

path::PathPiece part_of(const path::PathPiece& piece, double begin_mm, double end_mm) {
    path::PathPiece out{begin_mm, end_mm - begin_mm, {}};
    const double from = (begin_mm - piece.begin_mm) / piece.length_mm, to = (end_mm - piece.begin_mm) / piece.length_mm;
    for (std::size_t k = 0; k < 6; ++k) out.coefficient[k] = part_of(piece.coefficient[k], from, to);
    return out;
}

double end_of(const path::PathPiece& piece) {
    return piece.begin_mm + piece.length_mm;
}

/// The piece in which a place lies, not at its borders; the end where there is none.
std::vector<path::PathPiece>::iterator piece_around(std::vector<path::PathPiece>& pieces, double at_mm) {
    return std::find_if(pieces.begin(), pieces.end(), [&](const path::PathPiece& piece) {
        return piece.begin_mm + same_border_mm < at_mm && at_mm < end_of(piece) - same_border_mm;
    });
}

void divide(std::vector<path::PathPiece>& pieces, double at_mm) {
    const auto piece = piece_around(pieces, at_mm);
    if (piece == pieces.end()) return;
    const path::PathPiece whole = *piece;
    *piece = part_of(whole, whole.begin_mm, at_mm);
    pieces.insert(piece + 1, part_of(whole, at_mm, end_of(whole)));
}

HermiteEnd jet_of(const path::PathPiece& piece, double offset_mm) {
    const auto series = path::evaluate(piece, offset_mm);
    HermiteEnd out;
    for (int k = 0; k < 6; ++k) {
        out.value[k] = series[k].value();
        out.first[k] = series[k].d1();
        out.second[k] = series[k].d2();
        out.third[k] = series[k].d3();
    }
    return out;
}

/// Two abutting pieces as one, with the values and derivatives at their outer ends.
path::PathPiece one_piece(const path::PathPiece& a, const path::PathPiece& b) {
    HermiteEnd end = jet_of(b, b.length_mm);
    end.value = progress(a, 1) + progress(b, 1);
    return hermite_piece(a.begin_mm, end_of(b) - a.begin_mm, jet_of(a, 0), end);
}

/// As divide; a small part is joined to the piece beside it, for next to the pole short pieces are hard to plan over.
void divide_at_pole(std::vector<path::PathPiece>& pieces, double at_mm) {
    const auto piece = piece_around(pieces, at_mm);
    if (piece == pieces.end()) return;
    const double share = (at_mm - piece->begin_mm) / piece->length_mm;
    const auto index = piece - pieces.begin();
    divide(pieces, at_mm);
    const auto join = [&](auto first) {
        *first = one_piece(*first, *(first + 1));
        pieces.erase(first + 1);
    };
    if (share < little_of_piece && index > 0)
        join(pieces.begin() + index - 1);
    else if (share > 1 - little_of_piece && index + 2 < static_cast<std::ptrdiff_t>(pieces.size()))
        join(pieces.begin() + index + 1);
}

void add(path::PathPiece& piece, const Polynomial& share, const Eigen::Vector3d& vector, double controlled_height_mm) {
    for (int k = 0; k < 3; ++k)
        for (std::size_t i = 0; i < 8; ++i) {
            piece.coefficient[k][i] -= controlled_height_mm * vector[k] * share[i];
            piece.coefficient[3 + k][i] += vector[k] * share[i];
        }
}

/// Rounding is taken out: at its begin the piece is at the pole.
void begin_at_pole(path::PathPiece& piece, const Eigen::Vector3d& pole) {
    auto& c = piece.coefficient;
    const double height = pole.dot(Eigen::Vector3d(c[3][0], c[4][0], c[5][0]));
    for (int k = 0; k < 3; ++k) c[3 + k][0] = height * pole[k];
}

/// Orientation on a path of pieces.
class Orientation {
  public:
    explicit Orientation(std::span<const PlainPiece> path) : path_(path) {}

    struct Jet {
        Eigen::Vector3d value, slope;
    };
    Jet at(double at_mm) const {
        const PlainPiece& piece = piece_at(at_mm);
        const auto series = path::evaluate(*piece.piece, at_mm - piece.begin_mm);
        Jet out;
        for (int k = 0; k < 3; ++k) out.value[k] = series[3 + k].value(), out.slope[k] = series[3 + k].d1();
        return out;
    }
    /// The place itself, or the nearest border of pieces where that is within a share of the piece or a length.
    double snapped(double at_mm, double share, double length_mm) const {
        const PlainPiece& piece = piece_at(at_mm);
        const double length = piece.piece->length_mm, reach = std::max(share * length, length_mm);
        if (at_mm - piece.begin_mm < std::min(reach, 0.5 * length)) return piece.begin_mm;
        return piece.begin_mm + length - at_mm < reach ? piece.begin_mm + length : at_mm;
    }

  private:
    const PlainPiece& piece_at(double at_mm) const {
        const auto after = std::upper_bound(path_.begin() + 1, path_.end(), at_mm,
                                            [](double at, const PlainPiece& piece) { return at < piece.begin_mm; });
        return *(after - 1);
    }
    std::span<const PlainPiece> path_;
};

/// Where the orientation comes nearest to the pole within some way of a place, by Gauss-Newton steps. Any place near by
/// would do: the shift is as long as it has to be.
double nearest_place(const Orientation& orientation, const Eigen::Vector3d& pole, double near_mm, double from_mm,
                     double to_mm) {
    constexpr int most_steps = 12;
    constexpr double negligible_step_mm = 1e-7;
    double best = near_mm, least = 2, at = near_mm;
    for (int step = 0; step < most_steps; ++step) {
        const auto jet = orientation.at(at);
        const Eigen::Vector3d beside = path::beside_pole(jet.value, pole), slope = path::beside_pole(jet.slope, pole);
        if (beside.norm() < least) {
            best = at;
            least = beside.norm();
        }
        const double by = slope.squaredNorm() > 0 ? beside.dot(slope) / slope.squaredNorm() : 0;
        if (std::abs(by) < negligible_step_mm) break;
        at = std::clamp(at - by, from_mm, to_mm);
    }
    return best;
}

/// How far the programmed vectors pass from the pole, rad.
double distance(const path::Run& run, const path::PolePassage& passage) {
    const Eigen::Vector3d from = joined(run.vertices[passage.block]).tail<3>(),
                          to = joined(run.vertices[passage.block + 1]).tail<3>();
    return path::nearest_to_pole(from, to, passage.pole).distance();
}

}  // namespace

double pole_tolerance_rad(const SmoothingOptions& options) {
    const bool flank = options.flank_tolerance_mm > 0;
    if (options.rounding != Rounding::smooth || !(options.tip_tolerance_mm > 0) ||
        !(flank || options.orientation_tolerance_rad > 0))
        return 0;
    return part_of_tolerance * Measure({}, {}, options).turn_tolerance_rad();
}

PoleShifts::PoleShifts(const path::Run& run, VertexRange range, const Measure& measure)
    : tolerance_rad_(measure.turn_tolerance_rad()), controlled_height_mm_(measure.controlled_height_mm()) {
    if (run.passages.empty()) return;
    auto passage = run.passages.begin();
    for (std::size_t b = range.first; b < range.last; ++b) {
        const double length = run.blocks[b].length_mm;
        while (passage != run.passages.end() && passage->block < b) ++passage;
        for (; passage != run.passages.end() && passage->block == b; ++passage)
            if (distance(run, *passage) <= longest_part * tolerance_rad_)
                passages_.push_back({length_mm_ + passage->share * length, passage->pole});
        length_mm_ += length;
    }
    shifts_.resize(passages_.size());
}

void PoleShifts::find(std::span<const PlainPiece> path) {
    const Orientation orientation(path);
    std::vector<double> places;
    for (std::size_t i = 0; i < passages_.size(); ++i) {
        const double near = passages_[i].near_mm;
        const double from = i > 0 ? 0.5 * (passages_[i - 1].near_mm + near) : 0;
        const double to = i + 1 < passages_.size() ? 0.5 * (near + passages_[i + 1].near_mm) : length_mm_;
        const double place = nearest_place(orientation, passages_[i].pole, near, std::max(from, near - search_mm),
                                           std::min(to, near + search_mm));
        places.push_back(orientation.snapped(place, 0, same_place_mm));
    }
    for (std::size_t i = 0; i < passages_.size(); ++i) {
        PoleShift shift{.at_mm = places[i], .pole = passages_[i].pole};
        const double from = i > 0 ? 0.5 * (places[i - 1] + places[i]) : 0;
        const double to = i + 1 < places.size() ? 0.5 * (places[i] + places[i + 1]) : length_mm_;
        const double before = std::min(shift.at_mm - from, path::longest_shift_mm);
        const double after = std::min(to - shift.at_mm, path::longest_shift_mm);
        const auto border = [&](double at) { return orientation.snapped(at, little_of_piece, same_place_mm); };
        shift.begin_mm = border(shift.at_mm - before);
        shift.whole_from_mm = border(shift.at_mm - path::level_share * before);
        shift.whole_to_mm = border(shift.at_mm + path::level_share * after);
        shift.end_mm = border(shift.at_mm + after);
        const Eigen::Vector3d to_pole = -path::beside_pole(orientation.at(shift.at_mm).value, shift.pole);
        const bool has_room = std::min(before, after) > shortest_reach_mm && shift.begin_mm < shift.whole_from_mm &&
                              shift.whole_from_mm <= shift.at_mm && shift.at_mm <= shift.whole_to_mm &&
                              shift.whole_to_mm < shift.end_mm;
        shift.used = has_room;
        if (has_room) shift.vector = to_pole;
        shifts_[i] = shift;
    }
}

PoleShift PoleShift::counted_from(double origin_mm) const {
    PoleShift out = *this;
    for (double* at : {&out.at_mm, &out.begin_mm, &out.whole_from_mm, &out.whole_to_mm, &out.end_mm}) *at -= origin_mm;
    return out;
}

void PoleShifts::apply(double origin_mm, std::vector<path::PathPiece>& pieces) const {
    const double length_mm = end_of(pieces.back());
    for (const PoleShift& shift : shifts_) {
        const PoleShift here = shift.counted_from(origin_mm);
        if (!here.touches(0, length_mm)) continue;
        divide_at_pole(pieces, here.at_mm);
        for (const double border : {here.begin_mm, here.whole_from_mm, here.whole_to_mm, here.end_mm})
            divide(pieces, border);
        for (path::PathPiece& piece : pieces) {
            const double end = end_of(piece), middle = 0.5 * (piece.begin_mm + end);
            if (!here.touches(middle, middle)) continue;
            add(piece, share_of(here, piece.begin_mm, end), here.vector, controlled_height_mm_);
            if (std::abs(piece.begin_mm - here.at_mm) < same_border_mm) begin_at_pole(piece, here.pole);
        }
    }
}

std::vector<Excess> PoleShifts::too_long(const Bumps& bumps) const {
    std::vector<Excess> places;
    std::size_t block = bumps.first();
    double begin = 0;
    for (const PoleShift& shift : shifts_) {
        const double use = shift.vector.norm() / (longest_part * tolerance_rad_);
        if (!shift.used || use <= 1) continue;
        for (; block + 1 < bumps.last() && begin + bumps.gap[block] < shift.at_mm; ++block) begin += bumps.gap[block];
        const double total = std::max(use, least_excess);
        places.push_back({{block, std::clamp(shift.at_mm - begin, 0.0, bumps.gap[block])}, 0, {total, total}});
    }
    return places;
}

void PoleShifts::blame_curve(const Bumps& bumps, std::vector<Excess>& places) const {
    if (empty()) return;
    if (auto shifts = too_long(bumps); !shifts.empty()) {
        places = std::move(shifts);
        return;
    }
    std::size_t block = bumps.first();
    double begin = 0;
    for (Excess& place : places) {
        for (; block < place.at.block; ++block) begin += bumps.gap[block];
        const double at = begin + place.at.offset_mm;
        for (const PoleShift& shift : shifts_)
            if (shift.touches(at - place.extent_mm, at + place.extent_mm)) place.use.curve = place.use.total;
    }
}

double PoleShifts::largest() const {
    double out = 0;
    for (const PoleShift& shift : shifts_) out = std::max(out, shift.vector.norm());
    return out;
}

void lead_through_poles(PoleShifts& shifts, const Curve& curve, std::vector<Section>& plain,
                        std::vector<Section>& sections, std::vector<char>& stale) {
    if (plain.empty()) plain = sections;
    std::vector<PlainPiece> path;
    std::vector<double> begin{0};
    for (std::size_t i = 0; i < sections.size(); ++i) {
        if (stale[i]) represent(curve, plain[i]);
        for (const path::PathPiece& piece : plain[i].pieces) path.push_back({begin[i] + piece.begin_mm, &piece});
        begin.push_back(begin[i] + plain[i].length_mm);
    }
    const std::vector<PoleShift> before = shifts.shifts();
    shifts.find(path);
    for (std::size_t k = 0; k < before.size(); ++k) {
        if (before[k] == shifts.shifts()[k]) continue;
        for (std::size_t i = 0; i < sections.size(); ++i)
            for (const PoleShift& shift : {before[k], shifts.shifts()[k]})
                if (shift.touches(begin[i], begin[i + 1])) stale[i] = 1;
    }
    for (std::size_t i = 0; i < sections.size(); ++i) {
        if (!stale[i]) continue;
        sections[i] = plain[i];
        shifts.apply(begin[i], sections[i].pieces);
    }
}

void lead_through_poles(const path::Run& run, VertexRange range, const SmoothingOptions& options,
                        path::ToolPath& path) {
    if (run.passages.empty() || !(pole_tolerance_rad(options) > 0)) return;
    PoleShifts shifts(run, range, Measure(run, range, options));
    if (shifts.empty()) return;
    std::vector<PlainPiece> plain;
    for (const path::PathPiece& piece : path.pieces) plain.push_back({piece.begin_mm, &piece});
    shifts.find(plain);
    shifts.apply(0, path.pieces);
    const double shift = shifts.largest(), turn = std::asin(std::min(1.0, shift));
    path.bound.orientation_rad += turn;
    path.bound.height_mm += std::abs(options.flank_height_mm - options.controlled_height_mm) * turn +
                            options.controlled_height_mm * shift * shift;
    path.bound.tip_mm += options.controlled_height_mm * shift * shift;
}

}  // namespace trunnion::smoothing
