#include "detail/live_grid.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include "detail/rest_arc.hpp"

namespace trunnion::feed {
namespace {

using path::PathPlace;

constexpr double nothing_mm = 1e-10;  // a cell that is shorter is rounding
constexpr double crumb = 0.3;         // of its neighbour: joined with it where nothing stands between
constexpr double cut_margin = 1e-6;   // of a cell
constexpr double focus_growth = 0.25;
constexpr double neighbour_ratio = 2.5;
constexpr double arc_share_of_cell = 0.1;
constexpr int most_arc_steps = 60;

bool before(PathPlace a, PathPlace b) {
    return a.piece != b.piece ? a.piece < b.piece : a.offset_mm < b.offset_mm;
}

double end_mm(const Cell& cell) {
    return cell.begin.offset_mm + cell.length_mm;
}

/// Joins a cell with the next one where one of both is a crumb beside the other: what cutting the grid anywhere leaves.
void join_crumb_at(std::vector<Cell>& cells, std::size_t k) {
    if (k + 1 >= cells.size()) return;
    Cell &a = cells[k], &b = cells[k + 1];
    const bool can_join = a.begin.piece == b.begin.piece && a.block == b.block;
    if (!can_join || std::min(a.length_mm, b.length_mm) > crumb * std::max(a.length_mm, b.length_mm)) return;
    a.length_mm += b.length_mm;
    cells.erase(cells.begin() + static_cast<std::ptrdiff_t>(k) + 1);
}

/// Cuts the last cell where the place lies well inside it.
void cut_last(std::vector<Cell>& cells, PathPlace place) {
    if (cells.empty() || cells.back().begin.piece != place.piece) return;
    const double first = place.offset_mm - cells.back().begin.offset_mm, length = cells.back().length_mm;
    if (!(first > cut_margin * length && length - first > cut_margin * length)) return;
    Cell second = cells.back();
    cells.back().length_mm = first;
    second.begin = place;
    second.length_mm -= first;
    cells.push_back(second);
}

/// Lays cells over `cell`, from its begin (or, `backward`, from its end): none longer than allowed, none a crumb.
class Walk {
  public:
    Walk(std::span<const Grading> gradings, double before_mm, bool backward)
        : gradings_(gradings), way_(before_mm), backward_(backward) {}

    void keep_small_at(double way_mm, double size_mm) {
        focus_way_ = way_mm;
        focus_size_ = size_mm;
    }

    void over(const Cell& cell, std::vector<Cell>& out) {
        Cell rest = cell;
        while (rest.length_mm > 0) {
            double allowed = neighbour_ratio * neighbour_;
            for (const Grading& grading : gradings_) allowed = std::min(allowed, grading.at(way_));
            allowed = std::min(allowed, focus_size_ + focus_growth * std::abs(focus_way_ - way_));
            double step = rest.length_mm;
            if (step > 2.3 * allowed)
                step = allowed;
            else if (step > 1.3 * allowed)
                step /= 2;
            out.push_back(take(rest, step));
            way_ += step;
            neighbour_ = step;
        }
    }

  private:
    Cell take(Cell& rest, double step) const {
        Cell part = rest;
        if (step >= rest.length_mm) {
            rest.length_mm = 0;
            return part;
        }
        part.length_mm = step;
        rest.length_mm -= step;
        (backward_ ? part : rest).begin.offset_mm += backward_ ? rest.length_mm : step;
        return part;
    }

    std::span<const Grading> gradings_;
    double focus_way_ = 0, focus_size_ = std::numeric_limits<double>::infinity();
    double way_, neighbour_ = std::numeric_limits<double>::infinity();
    bool backward_;
};

}  // namespace

Result<void> LiveGrid::lay() {
    Grid grid(sampler_);
    CellSampler cells(sampler_);
    std::deque<SampledCell> sampled;
    while (std::optional<Cell> cell = grid.next()) {
        sampled.clear();
        if (auto done = cells.sample(*cell, sampled); !done) return done;
        for (const SampledCell& part : sampled) cells_.push_back(part.cell);
    }
    for (Cell& cell : cells_) cell.from_rest = cell.to_rest = false;
    return {};
}

PathPlace LiveGrid::end_of(std::size_t k) const {
    return {cells_[k].begin.piece, end_mm(cells_[k])};
}

bool LiveGrid::is_begin(PathPlace place) const {
    return !before(cells_.front().begin, place);
}

bool LiveGrid::is_end(PathPlace place) const {
    return !before(place, {end().piece, end().offset_mm - nothing_mm});
}

double LiveGrid::distance_mm(PathPlace place) const {
    return sampler_.path().tool_path().pieces[place.piece].begin_mm + place.offset_mm;
}

PathPlace LiveGrid::place_at(double p_mm) const {
    const auto& pieces = sampler_.path().tool_path().pieces;
    const auto next = std::upper_bound(pieces.begin() + 1, pieces.end(), p_mm,
                                       [](double p, const path::PathPiece& piece) { return p < piece.begin_mm; });
    const std::size_t piece = static_cast<std::size_t>(next - pieces.begin()) - 1;
    return {piece, std::clamp(p_mm - pieces[piece].begin_mm, 0.0, pieces[piece].length_mm)};
}

std::size_t LiveGrid::index_of(PathPlace place) const {
    const PathPlace beyond{place.piece, place.offset_mm + nothing_mm};
    const auto next = std::upper_bound(cells_.begin() + 1, cells_.end(), beyond,
                                       [](PathPlace p, const Cell& cell) { return before(p, cell.begin); });
    std::size_t k = static_cast<std::size_t>(next - cells_.begin()) - 1;
    if (k + 1 < cells_.size() && !before(place, {cells_[k].begin.piece, end_mm(cells_[k]) - nothing_mm})) ++k;
    return k;
}

std::vector<Cell> LiveGrid::clipped(const Course& course) const {
    std::vector<Cell> out;
    for (std::size_t k = index_of(course.from); k < cells_.size() && before(cells_[k].begin, course.to); ++k) {
        Cell cell = cells_[k];
        if (out.empty() && cell.begin.piece == course.from.piece) {
            cell.length_mm -= course.from.offset_mm - cell.begin.offset_mm;
            cell.begin = course.from;
        }
        if (cell.begin.piece == course.to.piece)
            cell.length_mm = std::min(cell.length_mm, course.to.offset_mm - cell.begin.offset_mm);
        if (cell.length_mm > (out.empty() ? 0 : nothing_mm)) out.push_back(cell);
        if (course.focus) cut_last(out, course.focus->place);
    }
    if (!is_begin(course.from)) join_crumb_at(out, 0);
    if (course.exact_stop && out.size() > 2 && !is_end(course.to)) join_crumb_at(out, out.size() - 2);
    return out;
}

/// As long as constant path jerk is nearly what the limits allow.
double LiveGrid::arc_length(const Cell& cell, bool start, double largest_mm) const {
    const RestSide side = start ? RestSide::start : RestSide::stop;
    const auto at = [&](double u) {
        const double offset = start ? cell.begin.offset_mm + u : end_mm(cell) - u;
        return sampler_.at({cell.begin.piece, offset}, cell.block).sample;
    };
    const double alpha = rest_alpha(at(0), sampler_.limits());
    double length = std::min(arc_share_of_cell * cell.length_mm, largest_mm);
    for (int k = 0; k < most_arc_steps && !is_jerk_phase(at(length), length, side, sampler_.limits(), alpha); ++k)
        length *= 0.7;
    return length;
}

std::vector<Cell> LiveGrid::cells(const Course& course) const {
    std::vector<Cell> coarse = clipped(course), forward, out;
    Cell start_arc, stop_arc;
    if (course.from_rest) {
        start_arc = coarse.front();
        start_arc.from_rest = true;
        // At the ends of the stretch the grid itself begins and ends with an arc.
        if (!is_begin(course.from) || coarse.size() < 3)
            start_arc.length_mm = arc_length(coarse.front(), true, course.largest_arc_mm);
        coarse.front().begin.offset_mm += start_arc.length_mm;
        coarse.front().length_mm -= start_arc.length_mm;
    }
    stop_arc = coarse.back();
    if (course.exact_stop) {
        if (!is_end(course.to) || coarse.size() < 3)
            stop_arc.length_mm = arc_length(coarse.back(), false, course.largest_arc_mm);
        stop_arc.begin.offset_mm = end_mm(coarse.back()) - stop_arc.length_mm;
        coarse.back().length_mm -= stop_arc.length_mm;
    } else {
        coarse.pop_back();
    }
    stop_arc.to_rest = true;

    std::erase_if(coarse, [](const Cell& cell) { return !(cell.length_mm > 0); });
    Walk walk(course.begin, course.from_rest ? start_arc.length_mm : 0, false);
    if (course.focus)
        walk.keep_small_at(distance_mm(course.focus->place) - distance_mm(course.from), course.focus->size_mm);
    for (const Cell& cell : coarse) walk.over(cell, forward);
    if (course.from_rest) out.push_back(start_arc);
    Walk back(course.end, course.exact_stop ? stop_arc.length_mm : 0, true);
    std::vector<Cell> reversed;
    for (std::size_t k = forward.size(); k-- > 0;) back.over(forward[k], reversed);
    out.insert(out.end(), reversed.rbegin(), reversed.rend());
    out.push_back(stop_arc);
    return out;
}

std::vector<Cell> LiveGrid::even_cells(PathPlace from, PathPlace to, double size_mm) const {
    const Grading even{size_mm, 0, 0};
    Walk walk({&even, 1}, 0, false);
    std::vector<Cell> out;
    for (const Cell& cell : clipped({.from = from, .to = to, .exact_stop = true})) walk.over(cell, out);
    return out;
}

}  // namespace trunnion::feed
