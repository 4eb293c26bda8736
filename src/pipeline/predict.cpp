#include "trunnion/pipeline/predict.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <unordered_map>
#include <utility>

#include <fmt/format.h>

#include "trunnion/base/quantity.hpp"
#include "trunnion/controller/contact_feed.hpp"
#include "trunnion/machine/kinematics.hpp"
#include "trunnion/pipeline/expand_surfaces.hpp"
#include "trunnion/pipeline/plan.hpp"

namespace trunnion::pipeline {

using motion::PredictedRow;
using motion::Prediction;

namespace {

/// How fast the tool in use goes against the part where it touches, from one setpoint to the next.
class ContactFeed {
  public:
    ContactFeed(const program::Program& program, const machine::Machine& machine, const machine::Setup& setup,
                double lead_rad)
        : program_(program), machine_(machine), setup_(setup), lead_rad_(lead_rad) {
        if (program.tools.size() > 1)
            for (const program::Move& move : program.moves) tool_by_line_.emplace(move.line, move.tool);
        if (!program.moves.empty()) tool_ = program.moves.front().tool;
    }

    /// NaN where the tool is not known.
    double operator()(const motion::Setpoint& last, const motion::Setpoint& now,
                      const machine::AxisVelocity& velocity) {
        const auto found = tool_by_line_.find(now.line);
        if (found != tool_by_line_.end()) tool_ = found->second;
        const machine::Tool& tool = in_use();
        const machine::Kinematics* kinematics = kinematics_of(tool);
        if (!(tool.diameter_mm > 0) || !kinematics) return NAN;
        const machine::Pose pose = kinematics->forward(now.position);
        const Eigen::Vector3d way = pose.tip_in_workpiece_mm - kinematics->forward(last.position).tip_in_workpiece_mm;
        if (way.norm() > 0) travel_ = way;
        return controller::contact_velocity(
                   way / (now.time_s - last.time_s),
                   controller::tool_turning_rad_s(machine_, setup_.workpiece, now.position, velocity),
                   controller::contact_from_tip_mm(tool, pose.axis_in_workpiece, travel_, lead_rad_))
            .norm();
    }

  private:
    const machine::Tool& in_use() const {
        const std::string& name = program_.tools[tool_];
        const machine::Tool* named = name.empty() ? nullptr : setup_.tool_named(name);
        return named ? *named : setup_.tool;
    }
    const machine::Kinematics* kinematics_of(const machine::Tool& tool) {
        auto known = kinematics_.find(tool_);
        if (known == kinematics_.end()) {
            auto made = machine::Kinematics::make(machine_, setup_.workpiece, tool.length_mm);
            known = kinematics_.emplace(tool_, made ? std::optional(std::move(*made)) : std::nullopt).first;
        }
        return known->second ? &*known->second : nullptr;
    }

    const program::Program& program_;
    const machine::Machine& machine_;
    const machine::Setup& setup_;
    double lead_rad_;
    std::unordered_map<std::int32_t, std::uint16_t> tool_by_line_;  // empty: one tool throughout
    std::uint16_t tool_ = 0;                                        // of the line before, where a line has no move
    std::map<std::uint16_t, std::optional<machine::Kinematics>> kinematics_;
    Eigen::Vector3d travel_ = Eigen::Vector3d::Zero();  // goes on where only the axes turn
};

/// Setpoints of our own planner as rows of a prediction.
class SetpointRows : public PlanObserver {
  public:
    SetpointRows(ContactFeed contact_feed, const controller::RowTaker& take_row)
        : contact_feed_(std::move(contact_feed)), take_row_(take_row) {}

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
                         .limit = {motion::LimitKind::planner}};
        for (std::size_t a = 0; a < machine::max_axes; ++a)
            row.velocity[a] = (now.position[a] - last_.position[a]) / period;
        row.contact_feed_mm_s = contact_feed_(last_, now, row.velocity);
        take_row_(row);
    }

    ContactFeed contact_feed_;
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

/// As controller::predict refuses it.
Result<void> check_lead(double lead_rad) {
    if (std::abs(lead_rad) < 90 * degree) return {};
    return fail({.code = "CTRL0204",
                 .text = "the tool cannot lean so far along the feed",
                 .value = fmt::format("{:g} deg", lead_rad / degree),
                 .limit = "less than 90 deg"});
}

Result<Prediction> predict_ideal(const program::Program& program, const machine::Machine& machine,
                                 const machine::Setup& setup, const motion::Controller& controller,
                                 const PredictionOptions& options, const controller::RowTaker& take_row) {
    if (auto good = check_lead(options.contact_lead_rad); !good) return fail(good.error());
    if (!program.surface_jobs.empty()) {  // the lines of their passes tell the tool too
        const auto expanded = expand_surfaces(program, setup);
        if (!expanded) return fail(expanded.error());
        return predict_ideal(*expanded, machine, setup, controller, options, take_row);
    }
    SetpointRows rows({program, machine, setup, options.contact_lead_rad}, take_row);
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
