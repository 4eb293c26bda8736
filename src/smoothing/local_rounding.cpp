#include "detail/local_rounding.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "detail/rounded_corner.hpp"
#include "detail/straight.hpp"

namespace trunnion::smoothing {

namespace {

constexpr double dividing_share = 0.2;  // of the tolerances, for straight blocks in place of turning ones and arcs
constexpr double half_block = 0.5;
constexpr double shortest_straight = 1e-9;  // of a block: what less is left between two corners is rounding

/// So far a vector may turn within a block, and an arc bulge.
Division division(const Measure& measure, const SmoothingOptions& options) {
    const double point_mm = options.flank_tolerance_mm > 0
                                ? std::min(options.tip_tolerance_mm, options.flank_tolerance_mm)
                                : options.tip_tolerance_mm;
    return {std::cbrt(dividing_share * measure.turn_tolerance_rad() / chord_sideways), dividing_share * point_mm,
            dividing_share * measure.turn_tolerance_rad()};
}

class LocalRounding {
  public:
    LocalRounding(const path::Run& run, VertexRange range, const SmoothingOptions& options,
                  std::vector<path::ToolPath>& out)
        : run_(run),
          options_(options),
          measure_(run, range, options),
          line_(make_polyline(run, range, division(measure_, options))),
          hull_(run, measure_, line_),
          out_(out),
          run_block_(range.first) {}

    void work(path::StopCause stop) {
        open();
        double taken = 0;  // of the block, by the corner at its begin
        for (std::size_t b = 0; b < line_.blocks(); ++b) {
            const bool last = b + 1 == line_.blocks();
            const std::optional<RoundedCorner> corner = last || is_straight(b + 1) ? std::nullopt : rounded(b + 1);
            straight(b, taken, line_.gap_mm[b] - (corner ? corner->reach_mm[0] : 0));
            taken = corner ? corner->reach_mm[1] : 0;
            if (corner)
                append(*corner, b + 1);
            else if (!last)
                pass(b + 1);
        }
        close(stop);
    }

  private:
    Coordinates kink(std::size_t vertex) const { return line_.slope[vertex] - line_.slope[vertex - 1]; }

    bool is_straight(std::size_t vertex) const {
        Coordinates d = kink(vertex);
        d.tail<3>() *= path::reference_height_mm;
        return d.norm() <= no_kink;
    }

    bool is_reversal(std::size_t vertex) const {
        Coordinates before = line_.slope[vertex - 1], after = line_.slope[vertex];
        before.tail<3>() *= path::reference_height_mm;
        after.tail<3>() *= path::reference_height_mm;
        return before.normalized().dot(after.normalized()) < reversal_cosine;
    }

    std::optional<RoundedCorner> rounded(std::size_t vertex) {
        if (is_reversal(vertex)) return std::nullopt;
        const CornerLegs legs{
            {line_.vertex[vertex - 1] - line_.vertex[vertex], line_.vertex[vertex + 1] - line_.vertex[vertex]},
            {line_.gap_mm[vertex - 1], line_.gap_mm[vertex]},
            {half_block, half_block},
            std::max(line_.lever[vertex], least_lever)};
        return round_corner(line_.vertex[vertex], legs, options_.link, measure_, hull_);
    }

    void straight(std::size_t block, double from_mm, double to_mm) {
        if (to_mm - from_mm <= shortest_straight * line_.gap_mm[block]) return;
        const Coordinates& slope = line_.slope[block];
        const Coordinates begin = line_.vertex[block] + slope * from_mm, way = slope * (to_mm - from_mm);
        const Coordinates zero = Coordinates::Zero();
        append(hermite_piece(0, to_mm - from_mm, {begin, slope, zero, zero}, {way, slope, zero, zero}));
        add(hull_.over(bernstein(path_.pieces.back()), begin, begin + way));
    }

    /// A vertex without rounding: straight on, or a standstill.
    void pass(std::size_t vertex) {
        const bool goes_on = is_straight(vertex);
        const path::StopCause cause = is_reversal(vertex) ? path::StopCause::reversal : path::StopCause::corner;
        end_block(vertex, goes_on ? std::optional(0.0) : std::nullopt);
        if (!goes_on) stand_still(cause);
    }

    void append(const RoundedCorner& corner, std::size_t vertex) {
        if (!corner.joins_smoothly) stand_still(path::StopCause::corner);
        bool behind = false;
        for (const path::PathPiece& piece : corner.pieces) {
            if (!behind && piece.begin_mm >= corner.reach_mm[0]) {
                end_block(vertex, measure_.use(corner.at_vertex, std::max(line_.lever[vertex], least_lever)));
                behind = true;
            }
            append(piece);
        }
        add(corner.extent);
        if (!corner.joins_smoothly) stand_still(path::StopCause::corner);
    }

    void append(path::PathPiece piece) {
        piece.begin_mm = path_.length_mm();
        path_.pieces.push_back(piece);
    }

    void add(const Extent& extent) {
        path_.bound.tip_mm = std::max(path_.bound.tip_mm, extent.tip);
        path_.bound.orientation_rad = std::max(path_.bound.orientation_rad, extent.turn);
        path_.bound.height_mm = std::max(path_.bound.height_mm, extent.height);
    }

    /// At a programmed vertex the next block begins; `use`: of the tolerances, where motion goes on.
    void end_block(std::size_t vertex, std::optional<double> use) {
        if (line_.programmed[vertex] < 0) return;
        end_span();
        run_block_ = static_cast<std::size_t>(line_.programmed[vertex]);
        if (use) path_.transition_use.push_back(static_cast<float>(*use));
    }

    void end_span() {
        const double begin = path_.blocks.empty() ? 0 : path_.blocks.back().end_mm, end = path_.length_mm();
        const path::Block& block = run_.blocks[run_block_];
        if (end > begin) path_.blocks.push_back({begin, end, block.feed, block.line, block.length_mm, run_block_});
    }

    void open() { path_ = stretch(run_, {0, 0}, run_.stop); }

    void close(path::StopCause stop) {
        end_span();
        path_.stop = stop;
        if (!path_.pieces.empty()) out_.push_back(std::move(path_));
    }

    void stand_still(path::StopCause cause) {
        if (path_.pieces.empty()) return;
        close(cause);
        open();
    }

    const path::Run& run_;
    const SmoothingOptions& options_;
    Measure measure_;
    Polyline line_;
    DeviationHull hull_;
    std::vector<path::ToolPath>& out_;
    path::ToolPath path_;
    std::size_t run_block_;
};

}  // namespace

void round_locally(const path::Run& run, VertexRange range, path::StopCause stop, const SmoothingOptions& options,
                   std::vector<path::ToolPath>& out) {
    LocalRounding(run, range, options, out).work(stop);
}

}  // namespace trunnion::smoothing
