#include "detail/length_over_feed.hpp"

#include <cmath>
#include <limits>

#include "detail/block_geometry.hpp"
#include "detail/prediction_account.hpp"
#include "detail/run_source.hpp"

namespace trunnion::controller {

using program::FeedRule;

namespace {

double time_of_cut(const path::Block& block, const Segment& segment) {
    switch (block.feed.rule) {
        case FeedRule::tip_speed:
            return segment.way_mm / block.feed.value;
        case FeedRule::rotary_rate:
            return segment.rotary_rad / block.feed.value;
        case FeedRule::block_time:
            return segment.share * block.feed.value;
        case FeedRule::none:
            break;
    }
    return 0;
}

motion::Limit slowest_axis(const machine::Machine& machine, const Station& from, const Station& to, double& time) {
    motion::Limit out;
    time = 0;
    for (int a = 0; a < machine.axis_count; ++a) {
        const auto k = static_cast<std::size_t>(a);
        const double needed = std::abs(to.axes[k] - from.axes[k]) / machine.axes[k].rapid.velocity;
        if (!(needed > time)) continue;
        time = needed;
        out = {motion::LimitKind::velocity, static_cast<std::int8_t>(a)};
    }
    return out;
}

/// Adds up the blocks of a program.
class Sum {
  public:
    Sum(const program::Program& program, const machine::Machine& machine, const RowTaker& take_row)
        : program_(program), machine_(machine), take_row_(take_row), account_(machine) {}

    void add(const path::Run& run) {
        constexpr double ends_only = std::numeric_limits<double>::infinity();
        trace(run, machine_, ends_only, geometry_);
        for (std::size_t i = 0; i < geometry_.segments.size(); ++i) {
            pass_events(run.first_move + geometry_.segments[i].block);
            add_segment(run, i);
        }
    }

    motion::Prediction finish() {
        pass_events(program_.moves.size());
        motion::Prediction out;
        account_.finish(out);
        out.dwell_time_s = dwell_s_;
        out.cycle_time_s = out.cut_time_s + out.rapid_time_s + dwell_s_;
        out.uncertainty_s = 0;
        return out;
    }

  private:
    void pass_events(std::size_t move) {
        for (; event_ < program_.events.size() && program_.events[event_].before_move <= move; ++event_)
            dwell_s_ += program_.events[event_].dwell_s;
    }

    void add_segment(const path::Run& run, std::size_t i) {
        const Segment& segment = geometry_.segments[i];
        const Station &from = geometry_.stations[i], &to = geometry_.stations[i + 1];
        const path::Block& block = run.blocks[segment.block];
        MotionPiece piece{.line = block.line, .rapid = run.rapid};
        if (run.rapid)
            piece.limit = slowest_axis(machine_, from, to, piece.duration_s);
        else
            piece.duration_s = time_of_cut(block, segment);
        piece.way_mm = run.space == path::Space::workpiece ? segment.way_mm : (to.tip_mm - from.tip_mm).norm();
        if (!(piece.duration_s > 0)) return;
        const double feed = piece.way_mm / piece.duration_s;
        piece.feed_from_mm_s = piece.feed_to_mm_s = piece.programmed_feed_mm_s = feed;
        machine::AxisVelocity velocity;
        for (std::size_t a = 0; a < static_cast<std::size_t>(machine_.axis_count); ++a) {
            velocity[a] = (to.axes[a] - from.axes[a]) / piece.duration_s;
            const machine::Axis& axis = machine_.axes[a];
            account_.note_load(a, std::abs(velocity[a]) / (run.rapid ? axis.rapid : axis.feed).velocity, 0, NAN);
        }
        give_row(from, velocity, piece);
        account_.add(piece);
        give_row(to, velocity, piece);
    }

    void give_row(const Station& at, const machine::AxisVelocity& velocity, const MotionPiece& piece) const {
        if (!take_row_) return;
        take_row_({.time_s = account_.time_s() + dwell_s_,
                   .position = at.axes,
                   .velocity = velocity,
                   .line = piece.line,
                   .path_length_mm = account_.path_length_mm(),
                   .tip_feed_mm_s = piece.feed_to_mm_s,
                   .contact_feed_mm_s = NAN,
                   .limit = piece.limit,
                   .rapid = piece.rapid});
    }

    const program::Program& program_;
    const machine::Machine& machine_;
    const RowTaker& take_row_;
    PredictionAccount account_;
    RunGeometry geometry_;
    double dwell_s_ = 0;
    std::size_t event_ = 0;
};

}  // namespace

Result<motion::Prediction> length_over_feed(const program::Program& program, const machine::Machine& machine,
                                            const machine::Setup& setup, const PredictOptions& options,
                                            const RowTaker& take_row) {
    auto source = RunSource::make(program, machine, setup, motion::BranchRule::least_turning, options);
    if (!source) return fail(source.error());
    Sum sum(program, machine, take_row);
    path::Run run;
    for (;;) {
        const auto more = source->next(run);
        if (!more) return fail(more.error());
        if (!*more) break;
        sum.add(run);
    }
    motion::Prediction out = sum.finish();
    out.blocks = source->blocks();
    out.diagnostics = source->diagnostics();
    return out;
}

}  // namespace trunnion::controller
