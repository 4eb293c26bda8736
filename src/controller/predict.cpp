#include "trunnion/controller/predict.hpp"

#include <cmath>

#include <fmt/format.h>

#include "trunnion/base/quantity.hpp"
#include "trunnion/controller/contact_feed.hpp"

#include "detail/block_profile.hpp"
#include "detail/doubts.hpp"
#include "detail/length_over_feed.hpp"
#include "detail/predict_linuxcnc.hpp"
#include "detail/prediction_account.hpp"
#include "detail/run_source.hpp"
#include "detail/stops.hpp"

namespace trunnion::controller {

using motion::Controller;
using motion::PredictedRow;
using motion::Prediction;

namespace {

/// Goes through a program run by run with the block model.
class BlockPrediction {
  public:
    BlockPrediction(const program::Program& program, const machine::Machine& machine, const machine::Setup& setup,
                    const Controller& controller, const PredictOptions& options, const RowTaker& take_row)
        : program_(program),
          machine_(machine),
          setup_(setup),
          controller_(controller),
          options_(options),
          take_row_(take_row),
          account_(machine),
          doubts_(controller, program) {}

    Result<Prediction> operator()() {
        auto source = RunSource::make(program_, machine_, setup_, controller_.branch.way, options_);
        if (!source) return fail(source.error());
        for (;;) {
            auto more = source->next(run_);
            if (!more) return fail(more.error());
            if (!*more) break;
            if (auto done = predict_run(); !done) return fail(done.error());
        }
        pass_events(program_.moves.size());
        Prediction out;
        out.blocks = source->blocks();
        out.diagnostics = source->diagnostics();
        finish(out);
        return out;
    }

  private:
    Result<void> predict_run() {
        resample();
        if (auto inside = check_ranges(); !inside) return inside;
        if (options_.uncertainty) doubts_.add(run_, geometry_, machine_);
        tool_ = &tool_of(run_, program_, setup_);
        double way_of_block = 0;
        for (std::size_t i = 0; i < speeds_.size(); ++i) {
            const std::size_t block = geometry_.segments[i].block;
            if (i == 0 || block != geometry_.segments[i - 1].block) {
                pass_events(run_.first_move + block);
                way_of_block = way_of(block, i);
            }
            add_segment(i, way_of_block);
        }
        return {};
    }

    /// The tip's way along a block whose first segment is given.
    double way_of(std::size_t block, std::size_t i) const {
        double sum = 0;
        for (; i < geometry_.segments.size() && geometry_.segments[i].block == block; ++i) sum += tip_way(i);
        return sum;
    }

    /// Traces the run ever more finely until the time that it takes does not change any more.
    void resample() {
        constexpr int most_rounds = 5;
        double chord = options_.first_chord_mm;
        trace(run_, machine_, chord, geometry_);
        double time = planner_.plan(run_, geometry_, machine_, controller_, &speeds_);
        for (int round = 0; round < most_rounds && geometry_.refined; ++round) {
            chord /= 4;
            trace(run_, machine_, chord, geometry_);
            const double finer = planner_.plan(run_, geometry_, machine_, controller_, &speeds_);
            const bool converged = std::abs(finer - time) <= options_.convergence * finer;
            time = finer;
            if (converged) return;
        }
    }

    Result<void> check_ranges() const {
        constexpr double slack = 1e-9;
        for (std::size_t i = 0; i < geometry_.stations.size(); ++i)
            for (int a = 0; a < machine_.axis_count; ++a) {
                const auto k = static_cast<std::size_t>(a);
                const machine::Axis& axis = machine_.axes[k];
                const double at = geometry_.stations[i].axes[k];
                if (at >= axis.range_min - slack && at <= axis.range_max + slack) continue;
                const std::size_t block = geometry_.segments[i > 0 ? i - 1 : 0].block;
                const double unit = axis.rotary ? degree : 1;
                return fail(
                    {.code = "CTRL0203",
                     .text = fmt::format("this control leads axis {} out of its range", axis.letter),
                     .place = {.file = program_.source, .line = run_.blocks[block].line},
                     .value = fmt::format("{:.4f} {}", at / unit, axis.rotary ? "deg" : "mm"),
                     .limit = fmt::format("{:g} … {:g}", axis.range_min / unit, axis.range_max / unit),
                     .hint = "turn the part on the table, or begin on the other branch ([start] in the setup)"});
            }
        return {};
    }

    /// The time of the words that stop the axes before a move.
    void pass_events(std::size_t move) {
        for (; event_ < program_.events.size() && program_.events[event_].before_move <= move; ++event_) {
            const StopTimes time = stop_time(program_.events[event_], controller_);
            stops_.dwell_s += time.dwell_s;
            stops_.tool_change_s += time.tool_change_s;
            stops_.other_s += time.other_s;
        }
    }

    double tip_way(std::size_t i) const {
        if (run_.space == path::Space::workpiece) return geometry_.segments[i].way_mm;
        return (geometry_.stations[i + 1].tip_mm - geometry_.stations[i].tip_mm).norm();
    }

    void add_segment(std::size_t i, double way_of_block) {
        const SegmentSpeed& s = speeds_[i];
        const path::Block& block = run_.blocks[geometry_.segments[i].block];
        note_loads(s);
        const double way = tip_way(i), per_mm = way / s.length_mm;
        MotionPiece piece{.line = block.line, .rapid = run_.rapid, .limit = s.limit};
        if (!run_.rapid) piece.programmed_feed_mm_s = programmed_tip_feed(block, way_of_block);
        const auto phase = [&](double from, double to, double duration, double length, motion::Limit at_from,
                               motion::Limit at_to) {
            piece.duration_s = duration;
            piece.way_mm = length * per_mm;
            piece.feed_from_mm_s = from * per_mm;
            piece.feed_to_mm_s = to * per_mm;
            piece.limit_from = at_from;
            piece.limit_to = at_to;
            account_.add(piece);
        };
        const double cruise_mm = std::max(0.0, s.length_mm - s.rise_mm - s.fall_mm);
        give_row(i, 0, s.from_mm_s, s.from_limit);
        phase(s.from_mm_s, s.peak_mm_s, s.rise_s, s.rise_mm, s.from_limit, s.limit);
        if (s.rise_s > 0 && s.cruise_s + s.fall_s > 0) give_row(i, s.rise_mm / s.length_mm, s.peak_mm_s, s.limit);
        phase(s.peak_mm_s, s.peak_mm_s, s.cruise_s, cruise_mm, s.limit, s.limit);
        if (s.cruise_s > 0 && s.fall_s > 0) give_row(i, 1 - s.fall_mm / s.length_mm, s.peak_mm_s, s.limit);
        phase(s.peak_mm_s, s.to_mm_s, s.fall_s, s.fall_mm, s.limit, s.to_limit);
        give_row(i, 1, s.to_mm_s, s.to_limit);
        account_.wait(block.line, run_.rapid, s.settle_s);
        if (!(s.to_mm_s > 0)) ++standstills_;
    }

    void note_loads(const SegmentSpeed& s) {
        for (int a = 0; a < machine_.axis_count; ++a) {
            const auto k = static_cast<std::size_t>(a);
            const auto& limits = run_.rapid ? machine_.axes[k].rapid : machine_.axes[k].feed;
            const double share = std::abs(s.direction[k]);
            account_.note_load(k, share * s.peak_mm_s / limits.velocity,
                               share * s.acceleration_mm_s2 / limits.acceleration, share * s.jerk_mm_s3 / limits.jerk);
        }
    }

    void give_row(std::size_t i, double share, double speed, motion::Limit limit) {
        if (!take_row_) return;
        const Station &from = geometry_.stations[i], &to = geometry_.stations[i + 1];
        const SegmentSpeed& s = speeds_[i];
        PredictedRow row;
        row.time_s = account_.time_s() + stops_.sum_s();
        for (int a = 0; a < machine_.axis_count; ++a) {
            const auto k = static_cast<std::size_t>(a);
            row.position[k] = std::lerp(from.axes[k], to.axes[k], share);
            row.velocity[k] = s.direction[k] * speed;
        }
        row.line = run_.blocks[geometry_.segments[i].block].line;
        row.path_length_mm = account_.path_length_mm();
        const Eigen::Vector3d tip_way = to.tip_mm - from.tip_mm;
        if (tip_way.norm() > 0) travel_ = tip_way;
        row.tip_feed_mm_s = this->tip_way(i) / s.length_mm * speed;
        row.contact_feed_mm_s = contact_feed(i, share, tip_way / s.length_mm * speed, row);
        row.limit = limit;
        row.rapid = run_.rapid;
        take_row_(row);
    }

    double contact_feed(std::size_t i, double share, const Eigen::Vector3d& tip_velocity,
                        const PredictedRow& row) const {
        if (!(tool_->diameter_mm > 0)) return NAN;
        const Eigen::Vector3d axis =
            ((1 - share) * geometry_.stations[i].tool_axis + share * geometry_.stations[i + 1].tool_axis).normalized();
        const Eigen::Vector3d turning = tool_turning_rad_s(machine_, setup_.workpiece, row.position, row.velocity);
        const Eigen::Vector3d contact = contact_from_tip_mm(*tool_, axis, travel_, options_.contact_lead_rad);
        return contact_velocity(tip_velocity, turning, contact).norm();
    }

    void finish(Prediction& out) {
        account_.finish(out);
        out.dwell_time_s = stops_.dwell_s;
        out.tool_change_time_s = stops_.tool_change_s;
        out.other_stop_time_s = stops_.other_s;
        out.cycle_time_s = out.cut_time_s + out.rapid_time_s + stops_.sum_s();
        out.standstills = standstills_;
        if (options_.uncertainty) doubts_.finish(out);
    }

    const program::Program& program_;
    const machine::Machine& machine_;
    const machine::Setup& setup_;
    const Controller& controller_;
    const PredictOptions& options_;
    const RowTaker& take_row_;
    PredictionAccount account_;
    Doubts doubts_;
    BlockPlanner planner_;
    path::Run run_;
    RunGeometry geometry_;
    std::vector<SegmentSpeed> speeds_;
    const machine::Tool* tool_ = nullptr;
    Eigen::Vector3d travel_ = Eigen::Vector3d::Zero();
    StopTimes stops_;
    std::size_t event_ = 0, standstills_ = 0;
};

/// Moves before the first pose that is known whole are not in the program that was read; the control makes them.
void tell_of_moves_left_out(const program::Program& program, Prediction& out) {
    for (const Diagnostic& told : program.diagnostics)
        if (told.code == "NC0013")
            out.diagnostics.push_back({.code = "CTRL0207",
                                       .severity = Severity::warning,
                                       .text = "the control makes the moves before the first whole pose too: their "
                                               "time is not counted",
                                       .place = told.place,
                                       .hint = "say every axis in the first block",
                                       .count = told.count});
}

}  // namespace

Result<Prediction> predict(const program::Program& program, const machine::Machine& machine,
                           const machine::Setup& setup, const Controller& controller, const PredictOptions& options,
                           const RowTaker& take_row) {
    auto out = [&]() -> Result<Prediction> {
        if (controller.kind == motion::ControllerKind::blocks)
            return BlockPrediction(program, machine, setup, controller, options, take_row)();
        if (controller.kind == motion::ControllerKind::length_over_feed)
            return length_over_feed(program, machine, setup, options, take_row);
        if (controller.kind == motion::ControllerKind::linuxcnc)
            return predict_linuxcnc(program, machine, setup, controller, options, take_row);
        return fail(
            {.code = "CTRL0205",
             .text = fmt::format("a controller of kind {} is not predicted by blocks", to_string(controller.kind))});
    }();
    if (!out) return out;
    out->program = program.source;
    out->dialect = program.dialect;
    out->machine = machine.name;
    out->setup = setup.file;
    out->controller = controller.name;
    tell_of_moves_left_out(program, *out);
    out->diagnostics.insert(out->diagnostics.begin(), program.diagnostics.begin(), program.diagnostics.end());
    return out;
}

}  // namespace trunnion::controller
