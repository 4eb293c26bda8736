#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <vector>

#include "trunnion/pipeline/queue_motion.hpp"

#include "detail/stretch.hpp"

namespace trunnion::pipeline {

/// A stretch of queued moves.
struct Leg {
    std::shared_ptr<const Stretch> stretch;
    std::int32_t first = 0, last = 0;  ///< numbers of its moves
    bool open = false;                 ///< it ends only because no more moves are there
};

/// The moves of a queue that may still matter, and the stretches they make.
class QueuedWay {
  public:
    QueuedWay(const machine::Machine& machine, double tool_length_mm, const QueuedPose& begin,
              const PlanOptions& options);

    void add(const QueuedMove& move);
    bool empty() const { return moves_.empty(); }
    std::int32_t last_number() const { return moves_.empty() ? 0 : moves_.back().number; }
    /// Moves behind this one, and their way (mm and, for turns, 30 mm · rad).
    std::size_t moves_behind(std::int32_t number) const;
    double way_behind_mm(std::int32_t number) const;
    /// The move so far before this one, at least `moves` of them: in number and in way.
    std::int32_t before(std::int32_t number, std::size_t moves, double way_mm) const;
    /// Moves before this one do not matter any more.
    void drop_before(std::int32_t number);

    /// The move so many behind this one, or the last one.
    std::int32_t behind(std::int32_t number, std::size_t moves) const;
    /// The stretches of the moves `first` … `last`. Errors: those of path building, with the move's number as line.
    Result<std::vector<Leg>> legs_of(std::int32_t first, std::int32_t last) const;

    const QueuedPose& end() const { return moves_.empty() ? begin_ : moves_.back().end; }

  private:
    std::size_t index_of(std::int32_t number) const;
    const QueuedPose& begin_of(std::size_t index) const { return index == 0 ? begin_ : moves_[index - 1].end; }
    double tolerance_of(const QueuedMove& move) const;
    bool stands_between(const QueuedMove& move, const QueuedMove& next) const;
    program::Program program_of(std::size_t first, std::size_t end) const;

    const machine::Machine* machine_;
    machine::Setup setup_;
    PlanOptions options_;
    QueuedPose begin_;
    std::deque<QueuedMove> moves_;
    std::deque<double> way_mm_;
};

}  // namespace trunnion::pipeline
