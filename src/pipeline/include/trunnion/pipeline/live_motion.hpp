#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "trunnion/base/result.hpp"
#include "trunnion/machine/machine.hpp"
#include "trunnion/pipeline/live_rows.hpp"
#include "trunnion/pipeline/plan_options.hpp"
#include "trunnion/program/program_parts.hpp"

namespace trunnion::pipeline {

/// Moves through a whole program under the operator's hand, period by period: its stretches one after another (cutting,
/// rapids, turns at the pole), each by a feed::LivePlanner, with dwells as rows of standstill and events that stop the
/// motion as standstills that the caller answers. The stretches to come are made on a second thread, a bounded number
/// of them ahead.
///
/// Rows begin behind begin(): the first one that moves is one period after it. Without commands they take the time of
/// plan() and up to a period for each stretch more; they are not its rows to the bit, as LivePlanner's windows differ.
/// Same commands at the same ticks, same rows to the bit.
///
/// At each tick there is a plan in hand: the rows of rows_ahead(), which end at a standstill inside all limits. Whoever
/// has them can go on without this object, and it is what the rows of the next ticks are until plan() changes.
class LiveMotion : public LiveRows {
  public:
    /// Reads the first part and makes the path of the first stretch. The period is that of the options, their feed
    /// override is the unit of the operator's. `longest_plan_s`: of the plan in hand, see feed::LivePlanner. All
    /// arguments but the options must outlive it. Errors: those of the parts and of path building, PIPE0001, PIPE0140
    /// nothing moves.
    static Result<LiveMotion> make(program::ProgramParts& parts, const machine::Machine& machine,
                                   const machine::Setup& setup, const PlanOptions& options, double longest_plan_s);
    ~LiveMotion() override;
    LiveMotion(LiveMotion&&) noexcept;
    LiveMotion& operator=(LiveMotion&&) noexcept;

    /// Where the axes must stand before the first tick.
    LiveRow begin() const override;

    /// Factor of the programmed feeds, 0…2; of the rapids' limits, 0…1. Errors: PIPE0141 outside its range.
    Result<void> set_feed_override(double factor);
    Result<void> set_rapid_override(double factor);
    /// Stops as soon as the limits allow, and stands until resume().
    void hold();
    /// Ends a hold, goes on behind a single block, and answers events.
    void resume();
    /// While on, every block's end is a stop, and so is every stretch's.
    void set_single_block(bool on);
    /// Stops as soon as the limits allow, for good.
    void stop();

    /// One period on. Cost: that of feed::LivePlanner::tick(). Errors, nothing moves any more then: those of making the
    /// path and of LivePlanner, with the program's line; what was planned before them is through.
    using LiveRows::tick;
    Result<LiveMotionState> tick(bool may_plan) override;

    std::size_t plan() const override;
    void rows_ahead(std::vector<LiveRow>& rows) const override;
    void keep_plan(std::size_t lead) override;
    void take_back_plan(std::size_t lead) override;

    /// Warnings met so far.
    std::vector<Diagnostic> diagnostics() const;

  private:
    class State;
    explicit LiveMotion(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

/// Makes the path of the whole program, one part at a time, and drops it: what path building and ranges refuse is told
/// before anything moves. `go_on` is called with the share done; false cancels. Errors: those of LiveMotion::make;
/// PIPE0002 cancelled. Cost: some 15 µs a block.
Result<void> check_way(program::ProgramParts& parts, const machine::Machine& machine, const machine::Setup& setup,
                       const PlanOptions& options, const std::function<bool(double)>& go_on);

}  // namespace trunnion::pipeline
