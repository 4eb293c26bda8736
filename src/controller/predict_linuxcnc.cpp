#include "detail/predict_linuxcnc.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "trunnion/controller/linuxcnc.hpp"

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
        if (rows_++ == 0) {
            last_ = row;
            return;
        }
        const auto found = asked_.find(row.line);
        const Asked asked = found == asked_.end() ? Asked{} : found->second;
        MotionPiece piece{.line = row.line, .rapid = asked.rapid, .duration_s = row.time_s - last_.time_s};
        const double feed = (row.tip_mm - last_.tip_mm).norm() / piece.duration_s;
        piece.way_mm = feed * piece.duration_s;
        piece.feed_from_mm_s = piece.feed_to_mm_s = feed;
        piece.programmed_feed_mm_s = asked.rapid ? 0 : asked.tip_feed_mm_s * override_;
        piece.limit = {motion::LimitKind::planner};
        account_.add(piece);
        give_row(row, piece);
        last_ = row;
    }

    PredictionAccount& account() { return account_; }

  private:
    void give_row(const LinuxcncRow& row, const MotionPiece& piece) {
        motion::PredictedRow out{.time_s = row.time_s,
                                 .position = row.axes,
                                 .line = row.line,
                                 .path_length_mm = account_.path_length_mm(),
                                 .tip_feed_mm_s = piece.feed_to_mm_s,
                                 .contact_feed_mm_s = NAN,
                                 .limit = piece.limit,
                                 .rapid = piece.rapid};
        machine::AxisVelocity velocity;
        for (int a = 0; a < machine_.axis_count; ++a) {
            const auto k = static_cast<std::size_t>(a);
            velocity[k] = (row.axes[k] - last_.axes[k]) / piece.duration_s;
            const auto& limits = piece.rapid ? machine_.axes[k].rapid : machine_.axes[k].feed;
            const double acceleration = rows_ > 2 ? (velocity[k] - velocity_[k]) / piece.duration_s : 0;
            account_.note_load(k, std::abs(velocity[k]) / limits.velocity,
                               std::abs(acceleration) / limits.acceleration);
        }
        velocity_ = velocity;
        out.velocity = velocity;
        if (take_row_) take_row_(out);
    }

    const machine::Machine& machine_;
    std::map<std::int32_t, Asked> asked_;
    double override_;
    const RowTaker& take_row_;
    PredictionAccount account_;
    LinuxcncRow last_;
    machine::AxisVelocity velocity_;
    std::size_t rows_ = 0;
};

/// The program with another feed on every cutting move.
program::Program with_feed(program::Program program, double feed_mm_s) {
    for (program::Move& move : program.moves)
        if (move.kind == program::MoveKind::feed) move.feed = {program::FeedRule::tip_speed, feed_mm_s};
    return program;
}

}  // namespace

Result<motion::Prediction> predict_linuxcnc(const program::Program& program, const machine::Machine& machine,
                                            const machine::Setup& setup, const PredictOptions& options,
                                            const RowTaker& take_row) {
    if (options.feed_mm_s) {
        PredictOptions rest = options;
        rest.feed_mm_s.reset();
        return predict_linuxcnc(with_feed(program, *options.feed_mm_s), machine, setup, rest, take_row);
    }
    LinuxcncSettings settings;
    settings.feed_override = options.feed_override;
    settings.max_feed_override = std::max(1.0, options.feed_override);
    RowReader reader(program, machine, settings, take_row);
    const auto run =
        run_as_linuxcnc(program, machine, setup, settings, [&](const LinuxcncRow& row) { reader.take(row); });
    if (!run) return fail(run.error());
    motion::Prediction out;
    reader.account().finish(out);
    out.cycle_time_s = run->cycle_time_s;
    out.dwell_time_s = run->wait_s;
    out.cut_time_s = run->cycle_time_s - run->wait_s - out.rapid_time_s;
    out.blocks = run->blocks.size();
    return out;
}

}  // namespace trunnion::controller
