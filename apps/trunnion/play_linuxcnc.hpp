#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "trunnion/machine/machine.hpp"

#include "play_process.hpp"
#include "play_sink.hpp"

namespace trunnion::app {

/// What linuxcnc/bridge.py says of a running LinuxCNC.
struct LinuxcncFacts {
    struct Joint {
        double position = 0, min = 0, max = 0, following_error = 0;  ///< mm or degrees
    };
    std::string letters;  ///< of the joints, in their order
    bool on = false, idle = false, homed = false;
    double period_s = 0, linear_units = 0, angular_units = 0;
    std::uint64_t room = 0;  ///< rows that the streamer holds
    std::vector<Joint> joints;

    /// Errors: RT0001 not a line of facts.
    static Result<LinuxcncFacts> parse(const std::string& line);
};

/// The joint of every axis. Errors: RT0002 not on, not homed or not idle; RT0003 other axes, period or units, or no
/// room for `rows`.
Result<std::vector<std::size_t>> match(const LinuxcncFacts& facts, const machine::Machine& machine, double period_s,
                                       std::uint64_t rows);
/// The machine with the ranges of both.
machine::Machine narrowed(machine::Machine machine, const LinuxcncFacts& facts, const std::vector<std::size_t>& joints);
/// Errors: RT0004 an axis is farther from where the program begins than its following-error limit.
Result<void> check_place(const LinuxcncFacts& facts, const std::vector<std::size_t>& joints,
                         const machine::Machine& machine, const trunnion_row& first);

/// Rows into the streamer of a running LinuxCNC, through linuxcnc/bridge.py.
class LinuxcncSink final : public RowSink {
  public:
    /// Starts the bridge and hears its facts. `plans`: descriptor of the plan buffer that the rows come from; should
    /// we be killed, the bridge plays the last plan to its standstill. Errors: RT0001 no LinuxCNC, RT0012.
    static Result<std::unique_ptr<LinuxcncSink>> connect(int plans);
    ~LinuxcncSink() override;

    const LinuxcncFacts& facts() const { return facts_; }
    /// Errors: those of match().
    Result<void> accept(const machine::Machine& machine, double period_s, std::uint64_t depth_rows);
    const std::vector<std::size_t>& joints() const { return joints_; }

    /// Errors: RT0004; RT0009 LinuxCNC does not come to the very place.
    Result<void> prepare(const trunnion_row& first) override;
    void start() override;
    std::size_t room() override;
    void give(const trunnion_row& row) override;
    void stand() override {}
    /// Errors: RT0009 LinuxCNC has ended the motion.
    Result<void> watch() override;
    std::uint64_t reached() const override { return written_ - waiting_; }
    /// LinuxCNC takes over where the axes stand. Errors: RT0009.
    Result<void> finish() override;
    int descriptor() const override { return news_.descriptor(); }

  private:
    explicit LinuxcncSink(Process bridge) : bridge_(bridge), news_(bridge.from) {}
    void order(char letter, const trunnion_row* row);
    Result<void> hear(const std::string& line);
    Result<std::string> next_line(double longest_s);
    Result<void> wait_until_done(double longest_s);

    Process bridge_;
    LineReader news_;
    std::vector<std::string> unheard_;
    LinuxcncFacts facts_;
    machine::Machine machine_;
    std::vector<std::size_t> joints_;
    std::uint64_t depth_rows_ = 0, given_ = 0, written_ = 0, waiting_ = 0;
    trunnion_row last_{};
};

}  // namespace trunnion::app
