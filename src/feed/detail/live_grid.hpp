#pragma once

#include <algorithm>
#include <limits>
#include <optional>
#include <vector>

#include "trunnion/feed/interval.hpp"

#include "detail/grid.hpp"

/// The grid of a stretch, cut anew for motions that begin or end anywhere on it.
namespace trunnion::feed {

/// The size that cells may have at a distance from one end of a course.
struct Grading {
    double size_mm = std::numeric_limits<double>::infinity(), flat_mm = 0, growth = 0;
    double at(double distance_mm) const { return size_mm + growth * std::max(distance_mm - flat_mm, 0.0); }
};

/// A place inside a course where a cell shall end and cells are small: so long there, growing by 0.25 of the distance.
struct Focus {
    path::PathPlace place;
    double size_mm = 0;
};

/// From where to where, and how fine. An end at rest gets an arc in front of the graded cells, of at most so much.
struct Course {
    path::PathPlace from, to;
    bool from_rest = false, exact_stop = false;
    std::vector<Grading> begin, end;  ///< all hold
    std::optional<Focus> focus;
    double largest_arc_mm = std::numeric_limits<double>::infinity();
};

class LiveGrid {
  public:
    explicit LiveGrid(const Sampler& sampler) : sampler_(sampler) {}
    /// Lays the cells of the whole stretch. Errors: FEED0002, FEED0009.
    Result<void> lay();

    std::size_t size() const { return cells_.size(); }
    const Cell& operator[](std::size_t k) const { return cells_[k]; }
    path::PathPlace end_of(std::size_t k) const;
    path::PathPlace end() const { return end_of(cells_.size() - 1); }

    double distance_mm(path::PathPlace place) const;  ///< p
    path::PathPlace place_at(double p_mm) const;
    /// The cell of the stretch's grid in which a place lies, or which begins there.
    std::size_t index_of(path::PathPlace place) const;

    /// Cells that abut, at least three. Without an exact stop the last one, which becomes the arc, ends where a cell of
    /// the grid ends and is as long as that. Neighbours differ by a factor of 2.5 at most.
    std::vector<Cell> cells(const Course& course) const;

    /// Cells of at most that size.
    std::vector<Cell> even_cells(path::PathPlace from, path::PathPlace to, double size_mm) const;

  private:
    bool is_begin(path::PathPlace place) const;
    bool is_end(path::PathPlace place) const;
    std::vector<Cell> clipped(const Course& course) const;
    double arc_length(const Cell& cell, bool start, double largest_mm) const;

    const Sampler& sampler_;
    std::vector<Cell> cells_;
};

}  // namespace trunnion::feed
