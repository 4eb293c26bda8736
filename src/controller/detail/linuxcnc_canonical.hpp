#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "trunnion/controller/linuxcnc.hpp"
#include "trunnion/program/program.hpp"

#include "detail/linuxcnc_segment.hpp"

namespace trunnion::controller::linuxcnc {

/// What goes to the motion side, one a servo period.
struct Command {
    enum class Kind : std::uint8_t {
        segment,
        mode,     ///< another mode of path control: only its period counts
        wait,     ///< until the motion has ended, then `dwell_s` and `answer_s`
        geometry  ///< after the motion has ended the machine is counted in another way: `position`, `geometry`
    } kind = Kind::segment;
    Segment segment;
    double dwell_s = 0, answer_s = 0;
    LinuxcncWait word = LinuxcncWait::other;  ///< that is answered
    Coordinates position;
    std::size_t geometry = 0;
};

/// A move in the planner's coordinates.
struct Way {
    Coordinates end;
    std::optional<Circle> circle;
    int normal_axis = 2;  ///< of X Y Z, of the circle
    bool rapid = false;
    program::Feed feed;
    std::int32_t line = 0;
};

/// Speed and acceleration of every segment by the limits of the axes, and merging of short straight ones. What is ready
/// is in `commands`, in order.
class Canonical {
  public:
    Canonical(const Limits& limits, double start_tolerance_mm) : limits_(limits) {
        mode_.tolerance_mm = start_tolerance_mm;
    }

    void stand_at(const Coordinates& position) { programmed_ = sent_ = position; }
    void move(const Way& way);
    void path_control(const program::PathControl& mode);
    /// Waits at one place have their dwells one after the other, but one answer.
    void wait(LinuxcncWait word, double answer_s, double dwell_s = 0);
    /// The machine stands still as it is; from now on it is counted otherwise.
    void recount(const Coordinates& position, std::size_t geometry);
    void finish() { flush(); }

    std::deque<Command> commands;
    double length_over_feed_s = 0;
    std::size_t segments = 0;

  private:
    struct Point {
        Coordinates at;
        std::int32_t line = 0;
    };
    double feed_of(const Way& way, double linear_mm, double rotary_deg) const;
    void take_feed(double feed);
    void straight(const Way& way);
    void arc(const Way& way);
    bool merges() const { return mode_.kind == program::PathControlKind::blend && mode_.merge_tolerance_mm > 0; }
    void collect(const Point& point);
    bool fits(const Point& point) const;
    void flush();
    void send_line(const Point& point, bool rapid);
    void send_arc(const Way& way);
    void send(Segment segment, std::int32_t line);
    Ending ending() const;

    const Limits& limits_;
    program::PathControl mode_;
    Coordinates programmed_;  ///< end of the last move
    Coordinates sent_;        ///< end of the last segment sent
    double feed_ = 0;         ///< mm/s or deg/s
    std::vector<Point> chain_;
};

}  // namespace trunnion::controller::linuxcnc
