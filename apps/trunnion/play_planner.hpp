#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <plan_buffer.h>

#include "trunnion/pipeline/live_rows.hpp"

namespace trunnion::app {

/// What the axes are given as their control counts it: mm and degrees.
trunnion_row row_of(const pipeline::LiveRow& row, const machine::Machine& machine);

/// Carries a motion into a plan buffer: keeps its ticks a lead ahead of the row that the reader is at, and publishes
/// the rows up to the standstill whenever the plan in hand has changed. Where the reader refuses a plan as it came too
/// late, the one before goes on, and the motion tries again, farther ahead.
class PlanPublisher {
  public:
    using RowOf = std::function<trunnion_row(const pipeline::LiveRow&)>;

    /// `row_of`: what the reader is given of a row. `kept_rows`: so many rows that were given stay in the plans, for
    /// whoever has to find where the axes are. Motion and buffer must outlive it; the buffer is begun.
    PlanPublisher(pipeline::LiveRows& motion, RowOf row_of, trunnion_plans& plans, std::uint64_t lead_rows,
                  std::uint64_t kept_rows = 0)
        : motion_(motion), row_of_(std::move(row_of)), plans_(plans), lead_rows_(lead_rows), kept_rows_(kept_rows) {}

    /// The standstill at the begin, as row 0. Errors: RT0005.
    Result<void> publish_begin();
    /// The reader stands where the motion begins: the first row is the next one that it takes.
    void begin_at_reader() { first_ = next_ = reader_next(); }

    /// What came of the last ticks.
    struct Advance {
        pipeline::LiveMotionStatus status = pipeline::LiveMotionStatus::standing;
        std::vector<program::Event> events;
    };
    /// Ticks up to the lead, a new plan or a standstill: plans once at most, so that commands are seen in between. As
    /// long as the reader has not looked at a new plan nothing is ticked; it waits some milliseconds for that at the
    /// most. Errors: those of the motion; RT0005 the reader has not looked for 5 s; RT0006 a plan is longer than the
    /// buffer.
    Result<Advance> advance();
    /// Whether the reader has looked at the newest plan.
    bool is_settled() const { return !handed_over_; }

    /// Whether the reader has given all rows that there are.
    bool reader_stands() const { return reader_next() >= first_ + rows_.size(); }
    std::uint64_t rows() const { return next_; }
    /// Plans that the reader refused.
    std::uint64_t missed() const { return missed_; }

  private:
    std::uint64_t reader_next() const { return __atomic_load_n(&plans_.next, __ATOMIC_ACQUIRE); }
    Result<void> take_row(const pipeline::LiveRow& row);
    /// A plan that the reader has to look at.
    struct HandOver {
        std::uint64_t branch = 0,
                      begun = 0;   // row where it leaves the one before; where the reader was when it was begun
        std::uint64_t number = 0;  // 0: there was no room to fill it in yet
        bool is_begin = false;     // not a change of the motion's plan
        std::vector<pipeline::LiveRow> before;
        std::chrono::steady_clock::time_point until;
    };
    Result<void> publish(std::uint64_t begun);
    Result<void> hand_over(HandOver plan);
    Result<bool> see_through();
    bool is_looked_at();
    void settle();
    std::uint64_t branch_from(const std::vector<pipeline::LiveRow>& before) const;
    void drop_given_rows();

    pipeline::LiveRows& motion_;
    RowOf row_of_;
    trunnion_plans& plans_;
    std::uint64_t lead_rows_, kept_rows_;
    std::uint64_t next_ = 0;               // row of the next tick
    std::uint64_t first_ = 0;              // of rows_
    std::vector<pipeline::LiveRow> rows_;  // those the reader may still need, to the standstill of the newest plan
    std::vector<pipeline::LiveRow> ahead_;
    std::size_t plan_ = 0;  // of the motion
    std::uint64_t missed_ = 0;
    std::optional<HandOver> handed_over_;
};

}  // namespace trunnion::app
