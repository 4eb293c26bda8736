#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>

#include "trunnion/base/result.hpp"
#include "trunnion/feed/plan_stretch.hpp"

namespace trunnion::feed {

enum class LiveStatus : std::uint8_t {
    moving,
    holding,  ///< stands still, not at the end of the stretch
    finished
};

/// Where the machine is at one period of the control.
struct LiveState {
    LiveStatus status = LiveStatus::holding;
    path::PathPlace place;
    double speed_mm_s = 0, acceleration_mm_s2 = 0, jerk_mm_s3 = 0;  ///< ṗ, p̈, p⃛
    std::size_t block = 0;                                          ///< index in ToolPath::blocks
};

/// How a path that leads farther belongs to the present one: its piece k is piece k + pieces_behind, its block k is
/// block k + blocks_behind, and its first `same_pieces` pieces are the same.
struct SamePath {
    std::size_t pieces_behind = 0, blocks_behind = 0, same_pieces = 0;
};

/// Moves along one stretch under the operator's commands, one call a control period, planning ahead by windows.
///
/// The plan in hand is always a complete, checked motion to standstill. A command changes it from the state two periods
/// ahead of the present one on, never before; path place, ṗ and p̈ are continuous there, p⃛ may jump. A new plan is
/// taken only when it passed the same check as the plans of FeedPlanner: all axis limits and feed × override to 1.0004.
/// Where no new plan is found the old one is kept, and the next tick tries again.
///
/// An override or a largest speed that is lowered holds from the nearest place on from which it can be held, found to a
/// few percent of the way; up to there the old one counts. A hold stands still within two periods and 1.2 × the time of
/// the shortest stop along the path: where the axes run straight within 1.03 × of it. The place is found by shooting
/// along the path, is planned like any other motion, and in corners is brought nearer in the ticks that follow.
///
/// Works on one stretch; memory is a window of intervals, and 50 bytes for every interval of the stretch. Planning is
/// done inside tick(), which is therefore not real-time safe: a control keeps setpoints ready for as long as planning
/// takes. Same commands at the same ticks, same motion to the bit.
class LivePlanner {
  public:
    /// Stands at the begin of the stretch with overrides 1, no hold, no single block: the first tick() begins to move.
    /// `longest_plan_s`: a plan that lasts longer is made anew to a standstill on its way, so that it does not; where
    /// no such plan is found, which a time far above that of a stop prevents, it stays as long as it is. The path must
    /// outlive it. Errors: those of IntervalStream, FEED0011 the period is not positive.
    static Result<LivePlanner> make(const path::AxisPath& path, const FeedOptions& options, double period_s,
                                    double longest_plan_s = std::numeric_limits<double>::infinity());
    ~LivePlanner();
    LivePlanner(LivePlanner&&) noexcept;
    LivePlanner& operator=(LivePlanner&&) noexcept;

    /// Factor of the programmed feeds, 0…2; rapids do not follow it. 0: holds until it is raised.
    /// Errors: FEED0010 outside its range.
    Result<void> set_feed_override(double factor);
    /// Factor of the velocity limits of a stretch that is a rapid, 0…1; others do not follow it. 0: holds until it is
    /// raised. Errors: FEED0010 outside its range.
    Result<void> set_rapid_override(double factor);
    /// Largest speed of the tip, whatever is programmed and whatever the override, on rapids too; infinite at first.
    /// Moves that only turn do not follow it. 0: holds until it is raised. Errors: FEED0010 below 0.
    Result<void> set_largest_speed(double mm_s);
    /// Stops as soon as the limits allow, and stands until resume().
    void hold();
    /// Ends a hold, also one that still brakes, and goes on behind a single block.
    void resume();
    /// While on, every block's end is a stop: the machine stands at the path parameter BlockSpan::end_mm until
    /// resume(). That is the programmed pose to within the smoothing's tolerance, and exactly where nothing was
    /// rounded. Switched on so late that the end of the present block cannot be met any more, the next one that can be
    /// met is taken.
    void set_single_block(bool on);

    /// One control period on. Cost: below 1 µs without planning; a window, when half of the one before is used or a
    /// command came, 30-60 µs an interval; a hold 1-2 ms where the axes run straight, in corners mostly below 15 ms, at
    /// the worst 80 ms. Allocates when it plans. Errors, the machine then stands: FEED0002 derivatives of the path are
    /// not finite, FEED0004 no plan even from standstill.
    /// `may_plan` false: a plan in hand that moves is not changed, as by a control that is behind.
    Result<LiveState> tick(bool may_plan = true);

    /// How often the plan in hand was changed.
    std::size_t plans() const;
    /// Periods until the plan in hand stands still; 0: it stands.
    std::size_t periods_left() const;
    /// The state so many periods on, if nothing is planned from now on: what the ticks give, to the bit, as long as
    /// plans() stays. Behind its end the plan in hand stands. Allocates nothing.
    LiveState ahead(std::size_t periods) const;
    /// The motion leads only as far as this place and stands there (`holding`) until it may go on; none: to the end of
    /// the stretch. A plan in hand that leads farther stays.
    void set_end(std::optional<path::PathPlace> place);

    /// The control goes by the plan in hand from now on. `lead`: how many periods ahead changes of its kind should
    /// count at the least, by the time that this one took; at most 1600 are.
    void keep(std::size_t lead = 0);
    /// The control came to know the plan in hand too late: it is the one again that was kept last. What the plan was
    /// changed for is tried anew, and counts farther ahead: by `lead`, at least 100 periods, twice as many each time
    /// this happens (up to 1600), and a little fewer each time a plan is kept. Commands and longer ways have leads of
    /// their own. Precondition: keep() was called.
    void take_back(std::size_t lead = 0);

    /// This motion, gone on along another path: one that is the same around the present place and leads farther, as
    /// where blocks were added to the end of a queue while the first ones are being run. Where the plan in hand stands
    /// within the same pieces it is taken over as it is, and the ticks to come make it longer; else it is left before
    /// them, at least two periods ahead, for one towards `end` (see set_end()). None where that cannot be: this one
    /// goes on as it would; so while a single block is under way. `other` must outlive what comes back. Cost: as
    /// make(), and in the second case a window or two. Errors: as make().
    Result<std::optional<LivePlanner>> gone_on_along(const path::AxisPath& other, const FeedOptions& options,
                                                     const SamePath& same,
                                                     std::optional<path::PathPlace> end = {}) const;

  private:
    class State;
    explicit LivePlanner(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

}  // namespace trunnion::feed
