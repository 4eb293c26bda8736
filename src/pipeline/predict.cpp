#include "trunnion/pipeline/predict.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>

#include "trunnion/base/quantity.hpp"
#include "trunnion/pipeline/plan.hpp"

namespace trunnion::pipeline {

using motion::PredictedRow;
using motion::Prediction;

namespace {

/// Setpoints of our own planner as rows of a prediction.
class SetpointRows : public PlanObserver {
  public:
    explicit SetpointRows(const controller::RowTaker& take_row) : take_row_(take_row) {}

    void setpoint(const motion::Setpoint& now) override {
        if (rows_++ > 0) add(now);
        last_ = now;
    }
    std::vector<motion::LineTime>& lines() { return lines_; }

  private:
    void add(const motion::Setpoint& now) {
        const double period = now.time_s - last_.time_s;
        if (lines_.empty() || lines_.back().line != now.line) lines_.push_back({now.line, last_.time_s, 0});
        lines_.back().duration_s += period;
        if (!take_row_) return;
        PredictedRow row{.time_s = now.time_s,
                         .position = now.position,
                         .line = now.line,
                         .path_length_mm = now.path_length_mm,
                         .tip_feed_mm_s = now.feed_mm_s,
                         .contact_feed_mm_s = NAN,
                         .limit = {motion::LimitKind::planner}};
        for (std::size_t a = 0; a < machine::max_axes; ++a)
            row.velocity[a] = (now.position[a] - last_.position[a]) / period;
        take_row_(row);
    }

    const controller::RowTaker& take_row_;
    motion::Setpoint last_;
    std::size_t rows_ = 0;
    std::vector<motion::LineTime> lines_;
};

/// The words of Summary say a cause as text: `A jerk`.
motion::Limit limit_named(const std::string& text, const machine::Machine& machine) {
    for (int axis = -1; axis < machine.axis_count; ++axis)
        for (int kind = 0; kind <= static_cast<int>(motion::LimitKind::planner); ++kind) {
            const motion::Limit limit{static_cast<motion::LimitKind>(kind), static_cast<std::int8_t>(axis)};
            if (to_string(limit, machine) == text) return limit;
        }
    return {motion::LimitKind::planner};
}

Result<Prediction> predict_ideal(const program::Program& program, const machine::Machine& machine,
                                 const machine::Setup& setup, const motion::Controller& controller,
                                 const PredictionOptions& options, const controller::RowTaker& take_row) {
    SetpointRows rows(take_row);
    const auto summary = plan(program, machine, setup, options.plan, rows);
    if (!summary) return fail(summary.error());
    Prediction out{.program = summary->program,
                   .dialect = summary->dialect,
                   .machine = summary->machine,
                   .setup = summary->setup,
                   .controller = controller.name};
    out.cycle_time_s = summary->cycle_time_s;
    out.cut_time_s = summary->cut_time_s;
    out.rapid_time_s = summary->rapid_time_s;
    out.dwell_time_s = summary->dwell_time_s;
    out.path_length_mm = summary->path_length_mm;
    out.blocks = summary->blocks;
    out.standstills = static_cast<std::size_t>(summary->exact_stops.total);
    out.uncertainty_s = 0;
    for (const AxisLoad& axis : summary->axes)
        out.axes.push_back(
            {axis.letter, axis.velocity_ratio, axis.acceleration_ratio, axis.jerk_ratio, axis.limiting_share});
    for (const FeedDrop& drop : summary->feed_drops)
        out.feed_drops.push_back({drop.line, drop.s_from_mm, drop.s_to_mm, drop.feed_min_mm_s,
                                  drop.programmed_feed_mm_s, drop.lost_s, limit_named(drop.cause, machine)});
    out.lines = std::move(rows.lines());
    out.diagnostics = summary->diagnostics;
    return out;
}

}  // namespace

Result<Prediction> predict(const program::Program& program, const machine::Machine& machine,
                           const machine::Setup& setup, const motion::Controller& controller,
                           const PredictionOptions& options, const controller::RowTaker& take_row) {
    if (controller.kind == motion::ControllerKind::ideal)
        return predict_ideal(program, machine, setup, controller, options, take_row);
    controller::PredictOptions how;
    how.feed_override = options.plan.feed_override;
    how.feed_mm_s = options.plan.feed_mm_s;
    how.contact_lead_rad = options.contact_lead_rad;
    how.uncertainty = options.uncertainty;
    return controller::predict(program, machine, setup, controller, how, take_row);
}

std::vector<LineDifference> differences(const Prediction& one, const Prediction& other, std::size_t most) {
    if (one.program != other.program) return {};
    std::map<int, LineDifference> by_line;
    for (const motion::LineTime& line : one.lines) by_line[line.line].time_s += line.duration_s;
    for (const motion::LineTime& line : other.lines) by_line[line.line].other_s += line.duration_s;
    std::vector<LineDifference> out;
    for (auto& [line, difference] : by_line) {
        difference.line = line;
        out.push_back(difference);
    }
    std::ranges::stable_sort(out, std::ranges::greater{},
                             [](const LineDifference& d) { return std::abs(d.time_s - d.other_s); });
    out.resize(std::min(out.size(), most));
    return out;
}

Result<PredictionFile> PredictionFile::create(const std::filesystem::path& path, const machine::Machine& machine) {
    auto file = files::OutputFile::create(path);
    if (!file) return fail(file.error());
    PredictionFile out(std::move(*file), machine);
    std::string header = "t_s", velocities;
    for (int a = 0; a < machine.axis_count; ++a) {
        const machine::Axis& axis = machine.axes[static_cast<std::size_t>(a)];
        header += fmt::format(",{}_{}", axis.letter, axis.rotary ? "deg" : "mm");
        velocities += fmt::format(",{}_{}_s", axis.letter, axis.rotary ? "deg" : "mm");
    }
    out.file_.write(header + ",line,s_mm,feed_mm_min,contact_feed_mm_min" + velocities + ",cause\n");
    return out;
}

void PredictionFile::write(const PredictedRow& row) {
    constexpr std::size_t flush_at = 1 << 16;
    const auto in_unit = [&](std::size_t a, double value) { return machine_->axes[a].rotary ? value / degree : value; };
    const auto axes = static_cast<std::size_t>(machine_->axis_count);
    fmt::format_to(std::back_inserter(buffer_), "{:.9g}", row.time_s);
    for (std::size_t a = 0; a < axes; ++a)
        fmt::format_to(std::back_inserter(buffer_), ",{:.9g}", in_unit(a, row.position[a]));
    fmt::format_to(std::back_inserter(buffer_), ",{},{:.9g},{:.9g},", row.line, row.path_length_mm,
                   row.tip_feed_mm_s * 60);
    if (std::isfinite(row.contact_feed_mm_s))
        fmt::format_to(std::back_inserter(buffer_), "{:.9g}", row.contact_feed_mm_s * 60);
    for (std::size_t a = 0; a < axes; ++a)
        fmt::format_to(std::back_inserter(buffer_), ",{:.9g}", in_unit(a, row.velocity[a]));
    fmt::format_to(std::back_inserter(buffer_), ",{}\n", to_string(row.limit, *machine_));
    if (buffer_.size() < flush_at) return;
    file_.write(buffer_);
    buffer_.clear();
}

Result<void> PredictionFile::commit() {
    file_.write(buffer_);
    buffer_.clear();
    return file_.commit();
}

}  // namespace trunnion::pipeline
