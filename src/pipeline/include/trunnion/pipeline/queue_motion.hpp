#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "trunnion/base/result.hpp"
#include "trunnion/machine/machine.hpp"
#include "trunnion/pipeline/live_rows.hpp"
#include "trunnion/pipeline/plan_options.hpp"
#include "trunnion/program/program.hpp"

namespace trunnion::pipeline {

/// Where a control's motion is: the tip in the workpiece and the rotary axes, order of the machine's, control's count.
struct QueuedPose {
    Eigen::Vector3d tip_mm = Eigen::Vector3d::Zero();
    std::array<double, machine::max_rotary_axes> rotary_rad{};
};

/// One line or arc of a control's queue. Rotary axes turn in proportion to the way.
struct QueuedMove {
    std::int32_t number = 0;  ///< ascending; comes back as LiveRow::line
    QueuedPose end;
    std::optional<program::Arc> arc;  ///< none: straight
    program::Feed feed;
    bool rapid = false;
    bool exact_stop = false;      ///< the machine stands at its end
    bool stop_first = false;      ///< the machine stands where it begins
    double tip_tolerance_mm = 0;  ///< of the corners that it makes; 0: that of the options
};

struct QueueOptions {
    PlanOptions plan;           ///< tolerances, limits, period
    double longest_plan_s = 6;  ///< see feed::LivePlanner
    /// A motion begins when so many moves or so much way have come, or close() was called. Both at least 1.
    std::size_t moves_to_begin = 200;
    double way_to_begin_mm = 60;
    /// That are taken up at once while it is under way; at least a quarter of those that are known ahead.
    std::size_t moves_to_go_on = 25;
};

/// Moves along what a control queues, move by move, while it still comes in: as LiveMotion, but the end of the way is
/// not known. What has come is smoothed and planned to a standstill at its end; when more comes, the way is smoothed
/// anew from a little behind the present place, put together with the present one where both are the same curve
/// (smoothing::spliced), and the motion goes on along it (LivePlanner::gone_on_along). So it stands still only where
/// the moves ask for it, or where they come too late.
///
/// Cost: as LiveMotion, and 20 µs a move and some milliseconds whenever moves are taken up. Memory: the moves from some
/// 40 mm behind the present place on.
class QueueMotion : public LiveRows {
  public:
    /// Stands at `begin` with an empty queue. The machine must outlive it. Errors: PIPE0001.
    static Result<QueueMotion> make(const machine::Machine& machine, double tool_length_mm, const QueuedPose& begin,
                                    const QueueOptions& options);
    ~QueueMotion() override;
    QueueMotion(QueueMotion&&) noexcept;
    QueueMotion& operator=(QueueMotion&&) noexcept;

    /// Behind those that came before. Precondition: numbers ascend.
    void add(const QueuedMove& move);
    /// No more is expected for now: what is there may be moved to its end. Until the next add().
    void close();

    /// As LiveMotion; 0…2, for rapids up to 1.
    void set_override(double factor);
    /// Of the tip, as LivePlanner::set_largest_speed(). Precondition: not below 0.
    void set_largest_speed(double mm_s);
    void hold();
    void resume();
    /// Step by step: moves up to this one may be run, each to a standstill at its end (LivePlanner::set_single_block()
    /// says where that is), and none behind it is begun. One whose end cannot be met any more is run over. None: all
    /// moves as they come.
    void step_through(std::optional<std::int32_t> number);

    /// One period on; `waiting`: stands, and nothing to move is there (or not enough to begin). Errors, nothing moves
    /// any more then: those of path building and planning, with the number of the move as line.
    using LiveRows::tick;
    Result<LiveMotionState> tick(bool may_plan) override;
    /// Moves up to this one are behind the standstill that the plan in hand ends at.
    std::int32_t done_at_standstill() const;

    LiveRow begin() const override;
    std::size_t plan() const override;
    void rows_ahead(std::vector<LiveRow>& rows) const override;
    void keep_plan(std::size_t lead) override;
    void take_back_plan(std::size_t lead) override;

  private:
    class State;
    explicit QueueMotion(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

}  // namespace trunnion::pipeline
