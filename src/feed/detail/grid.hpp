#pragma once

#include <deque>
#include <optional>
#include <vector>

#include "trunnion/base/result.hpp"

#include "detail/sampler.hpp"

/// Where the intervals of a stretch lie, and their samples.
namespace trunnion::feed {

/// An interval without its samples.
struct Cell {
    path::PathPlace begin;
    double length_mm = 0;
    std::size_t block = 0;  ///< of the tool path, whose feed holds
    bool from_rest = false, to_rest = false;
};

/// A part of one path piece under one feed.
struct Segment {
    std::size_t piece = 0;
    double begin_mm = 0, end_mm = 0;
    std::size_t block = 0;
    bool first = false, last = false;
};

/// Cuts a path where a piece begins, where a station is, and where the feed changes.
class SegmentCutter {
  public:
    explicit SegmentCutter(const path::AxisPath& path) : path_(&path) {}
    std::optional<Segment> next();

  private:
    void pass_blocks(double begin, double reached);
    void pass_stations(double reached);
    double next_cut(double begin, double length) const;

    const path::AxisPath* path_;
    std::size_t piece_ = 0, block_ = 0, station_ = 0;
    double at_ = 0;
};

/// Cells from begin to end of the path; the first and the last one are the arcs at rest. Sizes follow the path, grow by
/// 1.15 from the arcs and about as much elsewhere. Looks ahead only as far as a size that grows can reach.
class Grid {
  public:
    explicit Grid(const Sampler& sampler) : sampler_(sampler), cutter_(sampler.path()), next_(cutter_.next()) {}
    /// The next cell; nothing behind the last one.
    std::optional<Cell> next();

  private:
    /// The wished interval size at a place.
    struct Node {
        double offset_mm = 0, size_mm = 0;
    };
    struct Graded {
        Segment segment;
        std::vector<Node> nodes;
    };

    void look_ahead();
    void take(Segment segment);
    void settle();
    void lay(const Graded& graded);
    double take_arc(Segment& segment, bool at_start, Cell& arc) const;
    double arc_length(const Segment& within, bool at_start) const;
    PathSample sample(const Segment& s, double offset) const;
    void refine(Graded& to, double begin, double end, const PathSample& at_begin, const PathSample& at_end, int depth);
    bool bends(const PathSample& a, const PathSample& m, const PathSample& b, double length, double tolerance) const;
    double transition_size(const PathSample& before, const PathSample& after) const;

    const Sampler& sampler_;
    SegmentCutter cutter_;
    std::optional<Segment> next_;
    std::deque<Graded> pending_;
    std::deque<Cell> cells_;
    double pending_mm_ = 0;
    Node settled_{0, std::numeric_limits<double>::infinity()};  // the last node that was laid
    double from_rest_mm_ = 0;                                   // of it
    PathSample previous_end_;
    Cell start_arc_, stop_arc_;
};

/// A cell and its samples.
struct SampledCell {
    Cell cell;
    Interval interval;
};

/// Evaluates the path in a cell. Errors: FEED0002.
Result<Interval> sample_cell(const Sampler& sampler, const Cell& cell);

/// The same for cells in order; halves those that three samples do not tell enough of: in which a quintic through the
/// ends is farther from the middle than a bound of the loads may err.
class CellSampler {
  public:
    explicit CellSampler(const Sampler& sampler) : sampler_(sampler) {}
    /// Appends what a cell became. Errors: FEED0002, FEED0009 the path jumps in position before it.
    Result<void> sample(const Cell& cell, std::deque<SampledCell>& out);

  private:
    Result<void> sample(const Cell& cell, const Sampler::Place& begin, const Sampler::Place& end, int halvings,
                        std::deque<SampledCell>& out);
    Result<void> check_joint(const Cell& cell, const Sampler::Place& begin) const;

    const Sampler& sampler_;
    Sampler::Place last_;  // the end of the last cell
    path::PathPlace last_place_;
    std::size_t last_block_ = 0;
    bool any_ = false;
};

}  // namespace trunnion::feed
