#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "detail/programmed_line.hpp"

namespace trunnion::verify {

/// How widely the follower looks about.
struct Reach {
    double window_mm = 1;  ///< pieces so far ahead of the best place, and twice the row's own way, are looked at
    double lost_mm = 0.1;  ///< farther from the path than this, look `far_mm` ahead, at most once a millimetre
    double far_mm = 100;
    double beam_mm2 = 0.25;  ///< a hypothesis worse than the best by more is given up
};

/// Finds for every row the piece of the programmed path it belongs to, in order.
///
/// Dynamic programming over (row, piece): the cost of a matching is the sum of the squared distances, and the piece of
/// a row is never before that of the row before; inside of a piece places are free, which is the slack in the order.
/// Hypotheses far behind the best are given up, so the work a row is that of the pieces nearby. What all living
/// hypotheses have in common is settled whenever the trail grows to its bound.
class Follower {
  public:
    Follower(const ProgrammedLine& line, Reach reach) : line_(line), reach_(reach) {}

    void step(const Gauge& row);
    /// The piece of every row. The follower is spent.
    std::vector<std::uint32_t> finish();

  private:
    struct State {
        double cost = 0;       // mm², above the best one
        double distance2 = 0;  // of the last row
    };
    struct Row {
        std::size_t trail = 0;  // where its first piece is
        std::uint32_t first = 0;
    };

    std::uint32_t last_to_look_at(const Gauge& row);
    double distance2(const Gauge& row, std::size_t piece);
    void advance(const Gauge& row, std::uint32_t last);
    void drop_hopeless();
    std::size_t best() const;
    std::uint32_t before(std::size_t row, std::uint32_t piece) const;
    void settle();
    void settle_rows(std::size_t count, std::uint32_t piece_of_last);

    const ProgrammedLine& line_;
    Reach reach_;
    std::uint32_t first_ = 0;  // piece of now_[0]
    std::vector<State> now_, before_;
    Gauge last_row_{};
    double moved_since_look_ = 1;
    std::vector<Row> rows_;             // not settled
    std::vector<std::uint32_t> trail_;  // for every piece looked at in those rows: the piece of the row before
    std::vector<std::uint32_t> settled_;
    ToolHeights joint_tool_;  // that joint_ is for
    Joint6 joint_ = Joint6::Zero();
};

/// The place of every row on the exact path: on its piece, or up to a piece's length before it.
std::vector<Place> places_in_order(const ProgrammedLine& line, const std::vector<Gauge>& rows, const Reach& reach);

}  // namespace trunnion::verify
