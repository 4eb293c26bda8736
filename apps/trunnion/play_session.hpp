#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include <plan_buffer.h>

#include "trunnion/files/output_file.hpp"

#include "commands.hpp"
#include "job.hpp"
#include "play_process.hpp"
#include "play_sink.hpp"

namespace trunnion::app {

enum class PlayCommandKind : std::uint8_t { start, hold, resume, stop, single, override_feed, override_rapid };

/// A line of the operator: `start`, `hold`, `resume`, `stop`, `single on|off`, `override PERCENT`, `rapid PERCENT`.
struct PlayCommand {
    PlayCommandKind kind = PlayCommandKind::start;
    double value = 0;  ///< factor; single: 1 on
};
/// Errors: RT0010 no such command, PIPE0141 an override outside its range.
Result<PlayCommand> parse_play_command(std::string_view line);

/// What both sides of `play` know: the planner's process and the one that hands out rows.
struct PlaySession {
    JobOptions job;
    Workplace workplace;
    trunnion_plans* plans = nullptr;
    std::uint64_t lead_rows = 0;
    std::uint64_t kept_rows = 0;  ///< in the plans, of those that were given: more than wait in LinuxCNC
    std::string record;           ///< a file for the rows, or empty
    bool waits_for_start = false;
};

/// The planner's process: to the end of the program. `commands`, `news`: pipes of lines. Exit status.
int run_planning_side(const PlaySession& session, int commands, int news);

/// The rows as they are handed out, as CSV that `trunnion check` reads.
class RowRecord {
  public:
    /// An empty name: none is kept. Errors: those of files::OutputFile.
    static Result<RowRecord> create(const std::string& name, const machine::Machine& machine, double period_s);
    void add(const trunnion_row& row);
    Result<void> commit();

  private:
    std::optional<files::OutputFile> file_;
    int axes_ = 0;
    double period_s_ = 0;
    std::uint64_t rows_ = 0;
    std::string line_;
};

/// The other side: takes rows from the plans to the sink, and the operator's lines from stdin to the planner.
class PlayingSide {
  public:
    PlayingSide(const PlaySession& session, Process planner, RowSink& sink, RowRecord& record);
    /// To the end of the motion; the exit status.
    int run();

  private:
    void wait() const;
    void take_commands();
    void obey(const std::string& line);
    void take_news();
    void show(const std::string& line);
    void answer_alone(bool waits);
    void get_ready();
    void start();
    void move_on();
    void break_off(const Diagnostic& error);
    void look_at_machine();
    bool is_over() const;
    int report(int planner_status);

    const PlaySession& session_;
    Process planner_;
    LineReader news_, operator_;
    RowSink& sink_;
    RowRecord& record_;
    trunnion_reader reader_{};
    bool planned_ = false, ready_ = false, start_wanted_ = false, started_ = false, stands_ = true, broken_ = false;
    bool ended_well_ = false, failed_ = false, stop_sent_ = false;
    std::chrono::steady_clock::time_point begin_, command_;
    std::optional<double> begun_after_s_;
    std::uint64_t rows_ = 0;
    double planner_s_ = 0;
    std::uint64_t missed_ = 0;
};

}  // namespace trunnion::app
