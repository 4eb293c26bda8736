#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "trunnion/base/result.hpp"
#include "trunnion/machine/machine.hpp"
#include "trunnion/program/program.hpp"

namespace trunnion::pipeline {

enum class LiveMotionStatus : std::uint8_t {
    moving,    ///< gave a row; a dwell counts as motion
    standing,  ///< hold, override 0 or the end of a single block: until a command
    event,     ///< stands at an event that stops the motion, until it is answered
    waiting,   ///< stands until the path of what comes next is made
    stopped,   ///< stands for good behind stop()
    finished   ///< stands at the end of the program
};

/// What the axes are given in one period.
struct LiveRow {
    machine::AxisPosition position;
    std::int32_t line = 0;  ///< of the program
    bool operator==(const LiveRow&) const = default;
};

/// One tick.
struct LiveMotionState {
    LiveMotionStatus status = LiveMotionStatus::standing;
    LiveRow row;                         ///< where the axes are; a new one only under `moving`
    std::vector<program::Event> events;  ///< that happen with this row; under `event` those that wait for an answer
};

/// A motion that is decided period by period, under way: through a program (LiveMotion) or a control's queue
/// (QueueMotion). At each tick there is a plan in hand, rows to a standstill inside all limits.
class LiveRows {
  public:
    virtual ~LiveRows() = default;

    /// Where the axes must stand before the first tick.
    virtual LiveRow begin() const = 0;
    /// One period on. `may_plan` false: a plan in hand that moves is followed and not changed. Errors: of path building
    /// and planning; nothing moves any more then, and what was planned before them is through.
    virtual Result<LiveMotionState> tick(bool may_plan) = 0;
    Result<LiveMotionState> tick() { return tick(true); }

    /// How often the plan in hand was changed.
    virtual std::size_t plan() const = 0;
    /// The rows of the plan in hand behind the last tick's, to its standstill; replaces what is in `rows`. Cost: 0.5 µs
    /// a row.
    virtual void rows_ahead(std::vector<LiveRow>& rows) const = 0;
    /// Whoever moves the axes goes by the plan in hand from now on. `lead`: how many periods ahead changes should count
    /// at the least, by the time that the last one took.
    virtual void keep_plan(std::size_t lead) = 0;
    /// The plan in hand came too late: that which was kept last is it again, at the same period, and what it was
    /// changed for is tried again, farther ahead (feed::LivePlanner::take_back()). Precondition: the last tick changed
    /// the plan, and before it the kept one was in hand.
    virtual void take_back_plan(std::size_t lead) = 0;

  protected:
    LiveRows() = default;
    LiveRows(LiveRows&&) = default;
    LiveRows& operator=(LiveRows&&) = default;
};

}  // namespace trunnion::pipeline
