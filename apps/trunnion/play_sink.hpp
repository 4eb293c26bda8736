#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>

#include <plan_buffer.h>

#include "trunnion/base/result.hpp"

namespace trunnion::app {

/// Where the rows go to, one a period.
class RowSink {
  public:
    virtual ~RowSink() = default;
    /// Gets ready to move from the first row, which is where the axes must stand. Errors: they do not.
    virtual Result<void> prepare(const trunnion_row&) { return {}; }
    /// The motion begins, with the rows that were given before.
    virtual void start() = 0;
    /// Rows that it would take by now.
    virtual std::size_t room() = 0;
    virtual void give(const trunnion_row& row) = 0;
    /// There is no row for the periods that are due: the axes stand.
    virtual void stand() = 0;
    /// Looks at the machine. Errors: it has stopped the motion.
    virtual Result<void> watch() { return {}; }
    /// How many of the rows have reached the axes.
    virtual std::uint64_t reached() const = 0;
    /// The motion is over; the axes stand where the last row says.
    virtual Result<void> finish() { return {}; }
    /// Whether axes move: then nobody but the operator may answer what the program waits for.
    virtual bool moves_axes() const { return true; }
    /// Something that becomes readable when there is news, or −1.
    virtual int descriptor() const { return -1; }
};

/// Drops the rows, by the clock.
class ClockSink final : public RowSink {
  public:
    /// `speed`: so many times as fast as the clock.
    ClockSink(double period_s, double speed) : period_s_(period_s / speed) {}
    bool moves_axes() const override { return false; }
    void start() override { start_ = Clock::now(); }
    std::size_t room() override;
    void give(const trunnion_row&) override { ++periods_, ++rows_; }
    void stand() override { periods_ += room(); }
    std::uint64_t reached() const override { return rows_; }

  private:
    using Clock = std::chrono::steady_clock;
    double period_s_;
    std::optional<Clock::time_point> start_;
    std::uint64_t periods_ = 0, rows_ = 0;
};

}  // namespace trunnion::app
