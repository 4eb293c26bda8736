#include "detail/stretch_source.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "trunnion/base/quantity.hpp"

#include "detail/stopwatch.hpp"

namespace trunnion::pipeline {

using machine::AxisPosition;
using machine::RotaryPosition;
using program::FeedRule;

namespace {

constexpr double joint_slack = 1e-6;     // mm or rad between the end of a stretch and the start of the next
constexpr double turn_slack_rad = 2e-9;  // of an axis that is free to turn: third differences feel more than that

}  // namespace

Result<StretchSource> StretchSource::make(const program::Program& program, const machine::Machine& machine,
                                          const machine::Setup& setup, const PlanOptions& options,
                                          std::span<const program::RotaryStand> stands) {
    auto builder = path::PathBuilder::make(program, machine, setup, stands);
    if (!builder) return fail(builder.error());
    return StretchSource(program, machine, options, std::move(*builder));
}

NextElement StretchSource::next() {
    if (!in_run_) return at_end_ ? NextElement(std::nullopt) : begin_run();
    if (ready_.empty() && next_smoothed_ < smoothed_.size())
        if (auto made = make_ready(smoothed_[next_smoothed_++]); !made) return fail(made.error());
    if (!ready_.empty()) {
        Element out = std::move(ready_.front());
        ready_.pop_front();
        return out;
    }
    in_run_ = false;
    return Element{RunEnd{}, share(run_.blocks.size())};
}

NextElement StretchSource::begin_run() {
    auto more = builder_.next(run_);
    if (!more) return fail(more.error());
    smoothed_.clear();
    next_smoothed_ = 0;
    if (!*more) {
        at_end_ = true;
        if (run_.events.empty()) return std::nullopt;
        run_.first_move = program_->moves.size();
        run_.blocks.clear();
    } else {
        apply_feed_options();
        smooth();
    }
    in_run_ = true;
    return Element{RunBegin{run_.events, run_.blocks.size()}, share(0)};
}

void StretchSource::apply_feed_options() {
    if (run_.rapid) return;
    for (path::Block& block : run_.blocks) {
        if (options_->feed_mm_s) block.feed = {FeedRule::tip_speed, *options_->feed_mm_s};
        if (block.feed.rule == FeedRule::block_time)
            block.feed.value /= options_->feed_override;
        else
            block.feed.value *= options_->feed_override;
    }
}

void StretchSource::smooth() {
    const Stopwatch watch(smooth_s_);
    auto options = options_->smoothing;
    options.controlled_height_mm = run_.controlled_height_mm;
    smoothing::smooth(run_, options, smoothed_);
    if (!smoothed_.empty()) smoothed_.back().stop = run_.stop;
}

Result<void> StretchSource::make_ready(path::ToolPath& tool_path) {
    const RotaryPosition near = standing_before(tool_path);
    const std::int32_t line = tool_path.blocks.front().line;
    auto stretch = Stretch::make(std::move(tool_path), *machine_, near);
    if (!stretch) return fail(located(stretch.error(), *program_, line));
    if (auto turned = turn_in_place(*(*stretch)->axis_path); !turned) return turned;
    hand_out(std::move(*stretch));
    return {};
}

void StretchSource::hand_out(std::shared_ptr<const Stretch> stretch) {
    at_ = stretch->axis_path->end_position();
    moved_ = true;
    const auto& blocks = stretch->tool_path.blocks;
    const std::size_t first = blocks.front().run_block, behind = blocks.back().run_block + 1;
    ready_.push_back({StretchBegin{std::move(stretch), first, share(behind)}, share(first)});
}

double StretchSource::share(std::size_t block) const {
    const double done = static_cast<double>(run_.first_move + block);
    return std::min(done / static_cast<double>(program_->moves.size()), 1.0);
}

/// Where the rotary axes are before a stretch: where the last one left them, but at the pole as the moves to come want
/// the axis that is free there.
RotaryPosition StretchSource::standing_before(const path::ToolPath& tool_path) const {
    RotaryPosition out{};
    for (int a = 0; a < machine_->rotary_count; ++a) out[a] = at_[machine_->linear_count() + a];
    if (run_.stands.empty()) return out;
    const std::size_t vertex = tool_path.blocks.front().run_block;
    const auto& axis = run_.vertices[vertex].orientation;
    const bool free = tool_path.kinematics->rotary_for({axis[0], axis[1], axis[2]}).degenerate;
    return moved_ && !free ? out : run_.stands[vertex];
}

/// A stretch that does not begin where the axes stand. Rounding may lead the tool past the pole on the other side than
/// the program does; then the axes arrive a whole turn away from where rotary words count from.
Diagnostic StretchSource::joint_error(const path::AxisPath& next, double jump) const {
    const AxisPosition begin = next.begin_position();
    const Place place{.file = program_->source, .line = next.tool_path().blocks.front().line};
    for (int i = machine_->linear_count(); i < machine_->axis_count; ++i) {
        if (std::abs(std::remainder(begin[i] - at_[i], 2 * std::numbers::pi)) > joint_slack) break;
        if (std::abs(begin[i] - at_[i]) <= joint_slack) continue;
        return {.code = "PIPE0005",
                .text = fmt::format("the rounded path passes the pole on the other side than the programmed one: axis "
                                    "{} stands a whole turn away from where this move begins",
                                    machine_->axes[i].letter),
                .place = place,
                .value = fmt::format("{:.4f} deg", at_[i] / degree),
                .limit = fmt::format("{:.4f} deg", begin[i] / degree),
                .hint = "lead the tool past the pole farther away, or give a smaller orientation tolerance"};
    }
    return {.code = "PIPE0003",
            .text = "the axes would have to jump between two moves",
            .place = place,
            .value = fmt::format("{:.6g}", jump)};
}

/// Where the next stretch begins at the pole with another position of the axis that is free there, that axis turns
/// first, the tool standing still. Any other jump is refused.
Result<void> StretchSource::turn_in_place(const path::AxisPath& next) {
    const AxisPosition begin = next.begin_position();
    const int linear = machine_->linear_count();
    double jump = 0, turn = 0;
    for (int i = 0; moved_ && i < machine_->axis_count; ++i) {
        jump = std::max(jump, std::abs(begin[i] - at_[i]));
        if (i >= linear) turn = std::max(turn, std::abs(begin[i] - at_[i]));
    }
    if (jump <= joint_slack && turn <= turn_slack_rad) return {};
    const path::ToolPath& tool_path = next.tool_path();
    const auto here = tool_path.kinematics->forward(at_), there = tool_path.kinematics->forward(begin);
    const bool at_pole = tool_path.kinematics->rotary_for(here.axis_in_workpiece).degenerate;
    if (!(at_pole && (here.tip_in_workpiece_mm - there.tip_in_workpiece_mm).norm() <= joint_slack &&
          (here.axis_in_workpiece - there.axis_in_workpiece).norm() <= joint_slack))
        return jump <= joint_slack ? Result<void>() : fail(joint_error(next, jump));
    path::Run run{.law = path::OrientationLaw::rotary, .rapid = true, .kinematics = tool_path.kinematics};
    run.vertices.resize(2);
    for (int k = 0; k < 3; ++k)
        run.vertices[0].position_mm[k] = run.vertices[1].position_mm[k] = here.tip_in_workpiece_mm[k];
    for (int a = 0; a < machine_->rotary_count; ++a) {
        run.vertices[0].orientation[a] = at_[linear + a];
        run.vertices[1].orientation[a] = begin[linear + a];
    }
    // Smoothing drops blocks of next to no length, but this turn has to be made however small it is.
    const double length_mm =
        std::max(path::block_length_mm(run, run.vertices[0], run.vertices[1]), shortest_stretch_mm);
    run.blocks = {{length_mm, {}, tool_path.blocks.front().line}};
    std::vector<path::ToolPath> turns;
    smoothing::smooth(run, options_->smoothing, turns);
    turns.front().stop = path::StopCause::turn;
    turns.front().blocks.front().run_block = tool_path.blocks.front().run_block;
    auto stretch = Stretch::make(std::move(turns.front()), *machine_, {});
    if (!stretch) return fail(located(stretch.error(), *program_, tool_path.blocks.front().line));
    hand_out(std::move(*stretch));
    return {};
}

}  // namespace trunnion::pipeline
