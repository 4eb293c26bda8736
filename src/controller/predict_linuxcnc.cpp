#include "detail/predict_linuxcnc.hpp"

#include <cmath>
#include <map>
#include <utility>

#include "trunnion/controller/linuxcnc.hpp"

#include "detail/linuxcnc_doubts.hpp"
#include "detail/prediction_account.hpp"

namespace trunnion::controller {

namespace {

/// What a line of the program asks for.
struct Asked {
    bool rapid = false;
    double tip_feed_mm_s = 0;
};

std::map<std::int32_t, Asked> asked_by_line(const program::Program& program) {
    std::map<std::int32_t, Asked> out;
    for (const program::Move& move : program.moves) {
        Asked asked{.rapid = move.kind == program::MoveKind::rapid};
        if (move.feed.rule == program::FeedRule::tip_speed) asked.tip_feed_mm_s = move.feed.value;
        out[move.line] = asked;
    }
    return out;
}

/// Turns rows into pieces of motion between them.
class RowReader {
  public:
    RowReader(const program::Program& program, const machine::Machine& machine, const LinuxcncSettings& settings,
              const RowTaker& take_row)
        : machine_(machine),
          asked_(asked_by_line(program)),
          override_(settings.feed_override),
          take_row_(take_row),
          account_(machine) {}

    void take(const LinuxcncRow& row) {
        const LinuxcncRow before = std::exchange(last_, row);
        if (rows_++ == 0) return;
        const auto found = asked_.find(row.line);
        const Asked asked = found == asked_.end() ? Asked{} : found->second;
        MotionPiece piece{.line = row.line, .rapid = asked.rapid, .duration_s = row.time_s - before.time_s};
        piece.way_mm = (row.tip_mm - before.tip_mm).norm();
        piece.feed_from_mm_s = feed_mm_s_;
        piece.feed_to_mm_s = feed_mm_s_ = piece.way_mm / piece.duration_s;
        piece.programmed_feed_mm_s = asked.rapid ? 0 : asked.tip_feed_mm_s * override_;
        piece.limit = row.limit;
        piece.limit_from = piece.limit_to = row.slower_end;
        if (row.moves) {
            account_.add(piece);
            ends_rapid_ = piece.rapid;
        }
        note_motion(before, row, piece);
    }

    /// Cut and rapid time last until the joints stand, some periods longer than the planner moves: these are the last
    /// segment's.
    void finish(const LinuxcncRun& run, motion::Prediction& out) {
        account_.finish(out);
        const double motion_s = run.cycle_time_s - run.wait_s();
        if (ends_rapid_)
            out.rapid_time_s = motion_s - out.cut_time_s;
        else
            out.cut_time_s = motion_s - out.rapid_time_s;
    }

  private:
    void note_motion(const LinuxcncRow& before, const LinuxcncRow& row, const MotionPiece& piece) {
        motion::PredictedRow out{.time_s = row.time_s,
                                 .position = row.axes,
                                 .line = row.line,
                                 .path_length_mm = account_.path_length_mm(),
                                 .tip_feed_mm_s = piece.feed_to_mm_s,
                                 .contact_feed_mm_s = NAN,
                                 .limit = piece.limit,
                                 .rapid = piece.rapid};
        for (std::size_t k = 0; k < static_cast<std::size_t>(machine_.axis_count); ++k) {
            out.velocity[k] = (row.axes[k] - before.axes[k]) / piece.duration_s;
            const auto& limits = piece.rapid ? machine_.axes[k].rapid : machine_.axes[k].feed;
            const double acceleration = (out.velocity[k] - velocity_[k]) / piece.duration_s;
            const double jerk = (acceleration - acceleration_[k]) / piece.duration_s;
            account_.note_load(k, std::abs(out.velocity[k]) / limits.velocity,
                               std::abs(acceleration) / limits.acceleration, std::abs(jerk) / limits.jerk);
            acceleration_[k] = acceleration;
        }
        velocity_ = out.velocity;
        if (take_row_) take_row_(out);
    }

    const machine::Machine& machine_;
    std::map<std::int32_t, Asked> asked_;
    double override_;
    const RowTaker& take_row_;
    PredictionAccount account_;
    LinuxcncRow last_;
    double feed_mm_s_ = 0;
    machine::AxisVelocity velocity_;
    machine::AxisAcceleration acceleration_;
    std::size_t rows_ = 0;
    bool ends_rapid_ = false;
};

/// The program with another feed on every cutting move.
program::Program with_feed(program::Program program, double feed_mm_s) {
    for (program::Move& move : program.moves)
        if (move.kind == program::MoveKind::feed) move.feed = {program::FeedRule::tip_speed, feed_mm_s};
    return program;
}

}  // namespace

Result<motion::Prediction> predict_linuxcnc(const program::Program& program, const machine::Machine& machine,
                                            const machine::Setup& setup, const motion::Controller& controller,
                                            const PredictOptions& options, const RowTaker& take_row) {
    if (options.feed_mm_s) {
        PredictOptions rest = options;
        rest.feed_mm_s.reset();
        return predict_linuxcnc(with_feed(program, *options.feed_mm_s), machine, setup, controller, rest, take_row);
    }
    auto settings = linuxcnc_settings(controller);
    if (!settings) return fail(settings.error());
    settings->feed_override = options.feed_override;
    RowReader reader(program, machine, *settings, take_row);
    const auto run =
        run_as_linuxcnc(program, machine, setup, *settings, [&](const LinuxcncRow& row) { reader.take(row); });
    if (!run) return fail(run.error());
    motion::Prediction out;
    reader.finish(*run, out);
    out.cycle_time_s = run->cycle_time_s;
    out.dwell_time_s = run->dwell_s;
    out.tool_change_time_s = run->tool_change_s;
    out.other_stop_time_s = run->other_stop_s;
    out.blocks = run->blocks.size();
    out.standstills = run->standstills;
    if (options.uncertainty) LinuxcncDoubts(program, machine, setup, controller, *settings, *run).find(out);
    return out;
}

}  // namespace trunnion::controller
