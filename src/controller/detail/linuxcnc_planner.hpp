#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <vector>

#include "trunnion/controller/linuxcnc.hpp"

#include "detail/linuxcnc_segment.hpp"

namespace trunnion::controller::linuxcnc {

/// The queue of segments and the motion along them. Adding a segment decides how the one before ends, looks back along
/// the queue once, and never looks again; a period moves the first segment, and where two meet also the next one.
class Planner {
  public:
    Planner(const LinuxcncSettings& settings, const Limits& limits) : settings_(settings), limits_(limits) {}

    bool idle() const { return queue_.empty(); }
    bool full() const { return queue_.size() >= settings_.queue_full; }
    void stand_at(const Coordinates& position) { position_ = position; }
    /// `segment`: geometry, speeds, acceleration, rapid, ending by the mode in force, line.
    void add(Segment segment);
    /// One servo period; `now_s` is the time at its end.
    void run_period(double now_s, std::vector<LinuxcncBlock>& done);

    const Coordinates& position() const { return position_; }
    double speed() const { return speed_; }  ///< mm/s, deg/s where only rotary axes move
    bool turns_only() const { return turns_only_; }
    std::int32_t line() const { return line_; }
    std::size_t arc_blends() const { return arc_blends_; }
    std::size_t standstills() const { return standstills_; }
    std::size_t unset_directions() const { return unset_directions_; }
    /// What holds the speed of the last period down, and what the slower end of speeding up or braking.
    Hold hold() const { return hold_; }
    Hold slower_end() const { return slower_end_; }
    /// Nothing comes behind the newest segment until the motion has ended.
    void nothing_follows() { nothing_follows_ = true; }

  private:
    /// Speeds at which a parabolic blend overlaps: of the first, of the second, and what they come to together.
    struct Overlap {
        double own = 0, next = 0, net = 0;
    };

    double highest_target(const Segment& segment) const;
    double target(const Segment& segment) const;
    double override_of(const Segment& segment) const;
    void join(Segment& last, Segment& added);
    bool note_kink(Segment& last, Segment& added) const;
    void choose_joint(Segment& last, Segment& added);
    void take_best(Segment& last, Segment& added) const;
    bool blend_by_arc(Segment& last, Segment& added);
    void finalise(Segment& segment) const;
    void bound_end(Segment& earlier, Segment& later) const;
    void look_back();
    Overlap overlap(const Segment& own, double own_target, const Segment& next, double next_target) const;

    /// How a segment was moved on for one period.
    struct Step {
        double target = 0, end_speed = 0, acceleration = 0, most = 0;
    };
    Step advance(Segment& segment, const Segment* next, double duration_s);
    Hold hold_of_target(const Segment& segment) const;
    Hold hold_of_end(const Segment& segment) const;
    void note_hold(const Segment& segment, const Segment* next, const Step& step);
    void check_end(Segment& segment, double end_speed, double most) const;
    void activate(Segment& segment) const;
    void regular_period(double now_s, std::vector<LinuxcncBlock>& done);
    void split_period(double now_s, std::vector<LinuxcncBlock>& done);
    void leave(double now_s, std::vector<LinuxcncBlock>& done);
    void begin(Segment& segment, double now_s) const;
    void report(const Segment& moving);

    const LinuxcncSettings& settings_;
    const Limits& limits_;
    std::deque<Segment> queue_;
    Coordinates position_;
    double speed_ = 0;
    std::int32_t line_ = 0;
    bool rapid_reported_ = false, turns_only_ = false;
    std::size_t arc_blends_ = 0, standstills_ = 0, unset_directions_ = 0;
    std::uint64_t added_ = 0;
    bool nothing_follows_ = false;
    Hold hold_{motion::LimitKind::stop}, slower_end_{motion::LimitKind::stop};
};

}  // namespace trunnion::controller::linuxcnc
