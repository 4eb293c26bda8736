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

/// What several parts say in the same words is said once.
std::vector<Diagnostic> StretchSource::diagnostics() const {
    std::vector<Diagnostic> out = diagnostics_;
    if (!part_) return out;
    for (const Diagnostic& met : part_->builder->diagnostics()) {
        const auto is_same = [&](const Diagnostic& said) { return said.code == met.code && said.text == met.text; };
        if (std::ranges::none_of(diagnostics_, is_same)) out.push_back(met);
    }
    return out;
}

/// Part by part, each begins where the one before ended: there the machine stands still.
Result<void> StretchSource::take_next_part() {
    auto next = parts_->next();
    if (!next) return fail(next.error());
    at_end_ = !*next;
    if (at_end_) return {};
    diagnostics_ = diagnostics();
    part_ = std::move(*next);
    return {};
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

/// The next run, or, behind the last one of a part, the events that are left.
NextElement StretchSource::begin_run() {
    if (!part_)
        if (auto taken = take_next_part(); !taken) return fail(taken.error());
    if (!part_) return std::nullopt;
    auto more = part_->builder->next(run_);
    if (!more) return fail(more.error());
    smoothed_.clear();
    next_smoothed_ = 0;
    if (*more) {
        apply_feed_options();
        smooth();
    } else if (!run_.events.empty()) {
        run_.first_move = program().moves.size();
        run_.blocks.clear();
    } else {
        if (auto taken = take_next_part(); !taken) return fail(taken.error());
        return at_end_ ? NextElement(std::nullopt) : begin_run();
    }
    in_run_ = true;
    return Element{RunBegin{part_->program, run_.events, run_.blocks.size()}, share(0)};
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
    auto stretch = Stretch::make(std::move(tool_path), *machine_, near, part_);
    if (!stretch) return fail(located(stretch.error(), program(), line));
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
    const double of_part = std::min(done / static_cast<double>(program().moves.size()), 1.0);
    return part_->share_begin + of_part * (part_->share_end - part_->share_begin);
}

/// Where the rotary axes are before a stretch: where the last one left them, but at the pole as the moves to come want
/// the axis that is free there. (Behind a rounded corner a stretch begins beside its vertex.)
RotaryPosition StretchSource::standing_before(const path::ToolPath& tool_path) const {
    RotaryPosition out{};
    for (int a = 0; a < machine_->rotary_count; ++a) out[a] = at_[machine_->linear_count() + a];
    if (run_.stands.empty()) return out;
    const auto begin = path::evaluate(tool_path.pieces.front(), 0);
    const Eigen::Vector3d axis(begin[3].value(), begin[4].value(), begin[5].value());
    const bool free = tool_path.kinematics->rotary_for(axis.normalized()).degenerate;
    return moved_ && !free ? out : run_.stands[tool_path.blocks.front().run_block];
}

/// A stretch that does not begin where the axes stand. Rounding may lead the tool past the pole on the other side than
/// the program does; then the axes arrive a whole turn away from where rotary words count from.
Diagnostic StretchSource::joint_error(const path::AxisPath& next, double jump) const {
    const AxisPosition begin = next.begin_position();
    const Place place{.file = program().source, .line = next.tool_path().blocks.front().line};
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
    auto stretch = Stretch::make(std::move(turns.front()), *machine_, {}, part_);
    if (!stretch) return fail(located(stretch.error(), program(), tool_path.blocks.front().line));
    hand_out(std::move(*stretch));
    return {};
}

}  // namespace trunnion::pipeline
