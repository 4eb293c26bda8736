#include "trunnion/pipeline/plan.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <numbers>

#include <fmt/format.h>
#include <sys/resource.h>

#include "trunnion/base/quantity.hpp"
#include "trunnion/interpolation/interpolator.hpp"
#include "trunnion/path/path_builder.hpp"
#include "trunnion/path/rotary_stands.hpp"

#include "detail/feed_drops.hpp"
#include "detail/stretch_table.hpp"

namespace trunnion::pipeline {

using machine::AxisPosition;
using machine::RotaryPosition;
using program::FeedRule;

namespace {

constexpr std::size_t most_feed_drops = 200;
constexpr double far_slower = 20;        // than without jerk limits, after a fallback of the planner
constexpr double joint_slack = 1e-6;     // mm or rad between the end of a stretch and the start of the next
constexpr double turn_slack_rad = 2e-9;  // of an axis that is free to turn: third differences feel more than that

/// Adds the time of a scope to a counter.
class Stopwatch {
  public:
    explicit Stopwatch(double& total) : total_(total) {}
    ~Stopwatch() { total_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count(); }
    Stopwatch(const Stopwatch&) = delete;

  private:
    double& total_;
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

double peak_memory_mb() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return static_cast<double>(usage.ru_maxrss) / 1024.0;
}

/// One `plan` from start to end: chains the rooms over one stretch at a time.
class PlanRun {
  public:
    PlanRun(const program::Program& program, const machine::Machine& machine, const machine::Setup& setup,
            const PlanOptions& options, PlanObserver& observer)
        : program_(program), machine_(machine), setup_(setup), options_(options), observer_(observer) {
        summary_.axes.resize(static_cast<std::size_t>(machine.axis_count));
        for (int i = 0; i < machine.axis_count; ++i) summary_.axes[i].letter = machine.axes[i].letter;
    }

    Result<Summary> operator()();

  private:
    Result<void> run_over(path::PathBuilder& builder);
    void apply_feed_options(path::Run& run) const;
    Result<void> motion_of(path::Run& run);
    Result<void> motion_of(const path::ToolPath& stretch);
    RotaryPosition standing_before(const path::ToolPath& stretch) const;
    Result<void> turn_in_place(const path::AxisPath& next);
    Result<void> joint_error(const path::AxisPath& next, double jump) const;
    Result<void> perform(const path::AxisPath& path);
    void events_before_block(const path::Run& run, std::size_t block, double time_s, double s_mm);
    void events_of_stretch(const path::AxisPath& path, const motion::FeedProfile& profile, const StretchTable& table);
    void account(const path::AxisPath& path, const feed::StretchPlan& plan, const StretchTable& table);
    void count_stop(const path::ToolPath& stretch);
    void tell_of_slowness(const path::ToolPath& stretch, double time_s, double bound_s);
    void sample(const path::AxisPath& path, const motion::FeedProfile& profile, const StretchTable& table);
    void path_samples(const path::AxisPath& path, const motion::FeedProfile& profile, const StretchTable& table);
    void hold_until(double time_s);
    void emit(const motion::Setpoint& row);
    void finish();

    const program::Program& program_;
    const machine::Machine& machine_;
    const machine::Setup& setup_;
    const PlanOptions& options_;
    PlanObserver& observer_;

    Summary summary_;
    FeedDropCollector drops_;
    std::vector<float> transition_use_;
    AxisPosition at_;
    bool moved_ = false;
    double time_s_ = 0;  // of the start of the next stretch
    double s_mm_ = 0, p_mm_ = 0;
    std::size_t row_ = 0;
    std::int32_t line_ = 0;
    bool pending_dwell_ = false;
    const path::Run* run_ = nullptr;
    std::size_t next_event_ = 0, block_of_stretch_ = 0;
    path::StopCause last_stop_ = path::StopCause::end;
};

Result<Summary> PlanRun::operator()() {
    const auto stands = path::choose_rotary_stands(program_, machine_, setup_);
    if (!stands) return fail(stands.error());
    auto builder = path::PathBuilder::make(program_, machine_, setup_, *stands);
    if (!builder) return fail(builder.error());
    if (auto done = run_over(*builder); !done) return fail(done.error());
    finish();
    summary_.diagnostics.insert(summary_.diagnostics.end(), builder->diagnostics().begin(),
                                builder->diagnostics().end());
    return std::move(summary_);
}

Result<void> PlanRun::run_over(path::PathBuilder& builder) {
    path::Run run;
    for (;;) {
        auto more = builder.next(run);
        if (!more) return fail(more.error());
        if (!*more && run.events.empty()) return {};
        if (!*more) {  // events behind the last motion
            run_ = &run;
            next_event_ = 0;
            events_before_block(run, std::numeric_limits<std::size_t>::max(), time_s_, s_mm_);
            return {};
        }
        apply_feed_options(run);
        if (auto moved = motion_of(run); !moved) return moved;
        const double share =
            static_cast<double>(run.first_move + run.blocks.size()) / static_cast<double>(program_.moves.size());
        if (!observer_.progress(std::min(share, 1.0))) return fail({.code = "PIPE0002", .text = "cancelled"});
    }
}

void PlanRun::apply_feed_options(path::Run& run) const {
    if (run.rapid) return;
    for (path::Block& block : run.blocks) {
        if (options_.feed_mm_s) block.feed = {FeedRule::tip_speed, *options_.feed_mm_s};
        if (block.feed.rule == FeedRule::block_time)
            block.feed.value /= options_.feed_override;
        else
            block.feed.value *= options_.feed_override;
    }
}

Result<void> PlanRun::motion_of(path::Run& run) {
    std::vector<path::ToolPath> stretches;
    {
        const Stopwatch watch(summary_.work.smooth_s);
        auto options = options_.smoothing;
        options.controlled_height_mm = run.controlled_height_mm;
        smoothing::smooth(run, options, stretches);
    }
    summary_.blocks += run.blocks.size();
    if (!stretches.empty()) stretches.back().stop = run.stop;
    run_ = &run;
    next_event_ = 0;
    block_of_stretch_ = 0;
    for (const path::ToolPath& stretch : stretches)
        if (auto moved = motion_of(stretch); !moved) return moved;
    events_before_block(run, std::numeric_limits<std::size_t>::max(), time_s_, s_mm_);
    return {};
}

Result<void> PlanRun::motion_of(const path::ToolPath& stretch) {
    events_before_block(*run_, block_of_stretch_, time_s_, s_mm_);
    auto path = path::AxisPath::make(stretch, machine_, standing_before(stretch));
    if (!path) {
        auto error = path.error();
        error.place.file = program_.source;
        return fail(error);
    }
    if (auto turned = turn_in_place(*path); !turned) return turned;
    if (auto moved = perform(*path); !moved) return moved;
    block_of_stretch_ += stretch.blocks.size();
    return {};
}

/// Where the rotary axes are before a stretch: where the last one left them, but at the pole as the moves to come want
/// the axis that is free there.
RotaryPosition PlanRun::standing_before(const path::ToolPath& stretch) const {
    RotaryPosition out{};
    for (int a = 0; a < machine_.rotary_count; ++a) out[a] = at_[machine_.linear_count() + a];
    if (run_->stands.empty()) return out;
    const auto& axis = run_->vertices[block_of_stretch_].orientation;
    const bool free = stretch.kinematics->rotary_for({axis[0], axis[1], axis[2]}).degenerate;
    return moved_ && !free ? out : run_->stands[block_of_stretch_];
}

/// A stretch that does not begin where the axes stand. Rounding may lead the tool past the pole on the other side than
/// the program does; then the axes arrive a whole turn away from where rotary words count from.
Result<void> PlanRun::joint_error(const path::AxisPath& next, double jump) const {
    const path::ToolPath& stretch = next.tool_path();
    const AxisPosition begin = next.begin_position();
    const Place place{.file = program_.source, .line = stretch.blocks.front().line};
    for (int i = machine_.linear_count(); i < machine_.axis_count; ++i) {
        if (std::abs(std::remainder(begin[i] - at_[i], 2 * std::numbers::pi)) > joint_slack) break;
        if (std::abs(begin[i] - at_[i]) <= joint_slack) continue;
        return fail(
            {.code = "PIPE0005",
             .text = fmt::format("the rounded path passes the pole on the other side than the programmed one: axis "
                                 "{} stands a whole turn away from where this move begins",
                                 machine_.axes[i].letter),
             .place = place,
             .value = fmt::format("{:.4f} deg", at_[i] / degree),
             .limit = fmt::format("{:.4f} deg", begin[i] / degree),
             .hint = "lead the tool past the pole farther away, or give a smaller orientation tolerance"});
    }
    return fail({.code = "PIPE0003",
                 .text = "the axes would have to jump between two moves",
                 .place = place,
                 .value = fmt::format("{:.6g}", jump)});
}

/// Where the next stretch begins at the pole with another position of the axis that is free there, that axis turns
/// first, the tool standing still. Any other jump is refused.
Result<void> PlanRun::turn_in_place(const path::AxisPath& next) {
    const AxisPosition begin = next.begin_position();
    const int linear = machine_.linear_count();
    double jump = 0, turn = 0;
    for (int i = 0; moved_ && i < machine_.axis_count; ++i) {
        jump = std::max(jump, std::abs(begin[i] - at_[i]));
        if (i >= linear) turn = std::max(turn, std::abs(begin[i] - at_[i]));
    }
    if (jump <= joint_slack && turn <= turn_slack_rad) return {};
    const path::ToolPath& stretch = next.tool_path();
    const auto here = stretch.kinematics->forward(at_), there = stretch.kinematics->forward(begin);
    const bool at_pole = stretch.kinematics->rotary_for(here.axis_in_workpiece).degenerate;
    if (!(at_pole && (here.tip_in_workpiece_mm - there.tip_in_workpiece_mm).norm() <= joint_slack &&
          (here.axis_in_workpiece - there.axis_in_workpiece).norm() <= joint_slack))
        return jump <= joint_slack ? Result<void>() : joint_error(next, jump);
    path::Run run{.law = path::OrientationLaw::rotary, .rapid = true, .kinematics = stretch.kinematics};
    run.vertices.resize(2);
    for (int k = 0; k < 3; ++k)
        run.vertices[0].position_mm[k] = run.vertices[1].position_mm[k] = here.tip_in_workpiece_mm[k];
    for (int a = 0; a < machine_.rotary_count; ++a) {
        run.vertices[0].orientation[a] = at_[linear + a];
        run.vertices[1].orientation[a] = begin[linear + a];
    }
    constexpr double shortest_mm = 1e-3;  // of p, which is as good a parameter as any for a turn however small
    const double length_mm = std::max(path::block_length_mm(run, run.vertices[0], run.vertices[1]), shortest_mm);
    run.blocks = {{length_mm, {}, stretch.blocks.front().line}};
    std::vector<path::ToolPath> turns;
    smoothing::smooth(run, options_.smoothing, turns);
    turns.front().stop = path::StopCause::turn;
    auto path = path::AxisPath::make(turns.front(), machine_, {});
    return path ? perform(*path) : Result<void>(fail(path.error()));
}

/// Plans one stretch, samples it and adds it to the summary.
Result<void> PlanRun::perform(const path::AxisPath& path) {
    const path::ToolPath& stretch = path.tool_path();
    Result<feed::StretchPlan> plan = [&] {
        const Stopwatch watch(summary_.work.plan_s);
        return feed::plan_stretch(path, options_.feed);
    }();
    if (!plan) {
        auto error = plan.error();
        error.place.file = program_.source;
        if (error.place.line == 0 && !stretch.blocks.empty()) error.place.line = stretch.blocks.front().line;
        return fail(error);
    }
    if (plan->fallbacks > 0 && plan->profile.duration_s() > far_slower * plan->jerk_free_bound_s)
        tell_of_slowness(stretch, plan->profile.duration_s(), plan->jerk_free_bound_s);
    const Stopwatch watch(summary_.work.sample_s);
    const StretchTable table = StretchTable::of(path, plan->profile, s_mm_);
    if (!moved_) at_ = path.begin_position();
    hold_until(time_s_);
    events_of_stretch(path, plan->profile, table);
    sample(path, plan->profile, table);
    if (options_.path_samples) path_samples(path, plan->profile, table);
    account(path, *plan, table);
    at_ = path.end_position();
    line_ = stretch.blocks.back().line;
    moved_ = true;
    time_s_ += plan->profile.duration_s();
    s_mm_ = table.s_mm.back();
    p_mm_ += stretch.length_mm();
    last_stop_ = stretch.stop;
    return {};
}

void PlanRun::tell_of_slowness(const path::ToolPath& stretch, double time_s, double bound_s) {
    summary_.diagnostics.push_back({.code = "PIPE0102",
                                    .severity = Severity::warning,
                                    .text = "the feed planner found no good plan here: far slower than it needs to be",
                                    .place = {.file = program_.source, .line = stretch.blocks.front().line},
                                    .value = fmt::format("{:.3g} s", time_s),
                                    .limit = fmt::format("{:.3g} s without jerk limits", bound_s),
                                    .hint = "lead the tool axis farther from the pole"});
}

/// Events that fall before a block while the axes stand; dwells pass time.
void PlanRun::events_before_block(const path::Run& run, std::size_t block, double time_s, double s_mm) {
    for (; next_event_ < run.events.size() && run.events[next_event_].block <= block; ++next_event_) {
        const program::Event& event = program_.events[run.events[next_event_].event];
        observer_.event({time_s, s_mm, &event});
        if (event.dwell_s <= 0) continue;
        pending_dwell_ = true;
        summary_.dwell_time_s += event.dwell_s;
        time_s_ += event.dwell_s;
        time_s = time_s_;
    }
}

/// Events inside a stretch: those that do not stop the motion.
void PlanRun::events_of_stretch(const path::AxisPath& path, const motion::FeedProfile& profile,
                                const StretchTable& table) {
    const auto& blocks = path.tool_path().blocks;
    for (; next_event_ < run_->events.size(); ++next_event_) {
        const std::size_t block = run_->events[next_event_].block - block_of_stretch_;
        if (block >= blocks.size()) return;
        const double p = blocks[block].begin_mm;
        observer_.event(
            {time_s_ + table.time_at(profile, p), table.way_at(p), &program_.events[run_->events[next_event_].event]});
    }
}

void PlanRun::count_stop(const path::ToolPath& next) {
    using path::StopCause;
    ExactStops& stops = summary_.exact_stops;
    if (last_stop_ == path::StopCause::turn) return;
    ++stops.total;
    if (pending_dwell_) {
        ++stops.dwells;
        return;
    }
    switch (last_stop_) {
        case StopCause::reversal:
            ++stops.reversals;
            break;
        case StopCause::rapid:
            ++stops.rapids;
            break;
        case StopCause::corner:
            ++stops.corners;
            break;
        case StopCause::exact_stop:
            ++stops.words;
            break;
        case StopCause::event:
        case StopCause::tool:
        case StopCause::space:
        case StopCause::law:
            ++stops.events;
            break;
        case StopCause::turn:
        case StopCause::end:
            break;
    }
    if (last_stop_ == StopCause::end && next.rapid) ++stops.rapids;
}

void PlanRun::account(const path::AxisPath& path, const feed::StretchPlan& plan, const StretchTable& table) {
    const path::ToolPath& stretch = path.tool_path();
    if (moved_) count_stop(stretch);
    pending_dwell_ = false;
    (stretch.rapid ? summary_.rapid_time_s : summary_.cut_time_s) += plan.profile.duration_s();
    summary_.jerk_free_bound_s += plan.jerk_free_bound_s;
    summary_.intervals += plan.profile.pieces.size();
    summary_.windows += static_cast<std::size_t>(plan.windows);
    summary_.fallbacks += static_cast<std::size_t>(plan.fallbacks);
    for (int i = 0; i < machine_.axis_count; ++i) {
        AxisLoad& load = summary_.axes[i];
        load.velocity_ratio = std::max(load.velocity_ratio, plan.peaks[i].velocity);
        load.acceleration_ratio = std::max(load.acceleration_ratio, plan.peaks[i].acceleration);
        load.jerk_ratio = std::max(load.jerk_ratio, plan.peaks[i].jerk);
    }
    summary_.tip_deviation_mm = std::max(summary_.tip_deviation_mm, stretch.bound.tip_mm);
    summary_.orientation_deviation_rad = std::max(summary_.orientation_deviation_rad, stretch.bound.orientation_rad);
    summary_.height_deviation_mm = std::max(summary_.height_deviation_mm, stretch.bound.height_mm);
    transition_use_.insert(transition_use_.end(), stretch.transition_use.begin(), stretch.transition_use.end());
    drops_.add(path, plan, table);
}

void PlanRun::emit(const motion::Setpoint& row) {
    observer_.setpoint(row);
    ++row_;
}

/// Rows of standstill up to a time.
void PlanRun::hold_until(double time_s) {
    for (double t = static_cast<double>(row_) * options_.period_s; t < time_s;
         t = static_cast<double>(row_) * options_.period_s)
        emit({t, at_, line_, s_mm_, 0});
}

void PlanRun::sample(const path::AxisPath& path, const motion::FeedProfile& profile, const StretchTable& table) {
    const double end_s = time_s_ + profile.duration_s();
    interpolation::Interpolator interpolator(path, profile);
    for (double t = static_cast<double>(row_) * options_.period_s; t < end_s;
         t = static_cast<double>(row_) * options_.period_s) {
        const interpolation::Instant now = interpolator.at(t - time_s_);
        const std::size_t piece = now.path_state.profile_piece;
        const double s = table.s_mm[piece] + (now.tip_in_workpiece_mm - table.tip_mm[piece]).norm();
        emit({t, now.position, path.tool_path().blocks[now.block].line, s, now.tip_speed_mm_s});
    }
}

/// ṗ that programmed feed and axis velocities allow at a place.
double speed_limit(const path::AxisSample& sample, const path::BlockSpan& block, const machine::Machine& machine,
                   bool rapid) {
    double limit = std::numeric_limits<double>::infinity();
    for (int i = 0; i < machine.axis_count; ++i) {
        const auto& limits = rapid ? machine.axes[i].rapid : machine.axes[i].feed;
        const double rate = std::abs(sample.axes[i].d1());
        if (rate > 0) limit = std::min(limit, limits.velocity / rate);
    }
    const double cap = feed::feed_speed_cap(block, sample);
    return std::min(limit, cap);
}

void PlanRun::path_samples(const path::AxisPath& path, const motion::FeedProfile& profile, const StretchTable& table) {
    const path::ToolPath& tool_path = path.tool_path();
    constexpr int parts = 4;
    std::size_t block = 0;
    for (std::size_t i = 0; i < profile.pieces.size(); ++i) {
        const auto& piece = profile.pieces[i];
        const bool last = i + 1 == profile.pieces.size();
        for (int k = 0; k < parts + (last ? 1 : 0); ++k) {
            const double delta = piece.length_mm * k / parts;
            path::AxisSample at;
            path.evaluate({piece.path_piece, piece.path_offset_mm + delta}, at);
            PathSample out;
            const double p = table.p_mm[i] + delta;
            while (block + 1 < tool_path.blocks.size() && p >= tool_path.blocks[block].end_mm) ++block;
            out.p_mm = p_mm_ + p;
            out.tip_mm = {at.tip[0].value(), at.tip[1].value(), at.tip[2].value()};
            out.axis = {at.tool_axis[0].value(), at.tool_axis[1].value(), at.tool_axis[2].value()};
            out.s_mm = table.s_mm[i] + (out.tip_mm - table.tip_mm[i]).norm();
            out.speed_mm_s = motion::state_at(piece, delta).speed_mm_s;
            out.speed_limit_mm_s = speed_limit(at, tool_path.blocks[block], machine_, tool_path.rapid);
            Eigen::Vector3d top;
            for (int c = 0; c < 3; ++c)
                top[c] = at.tip[c].d1() + options_.smoothing.flank_height_mm * at.tool_axis[c].d1();
            out.feed_top_mm_s = top.norm() * out.speed_mm_s;
            out.axes = at.axes;
            observer_.path_sample(out);
        }
    }
}

void PlanRun::finish() {
    if (moved_) {
        hold_until(time_s_);
        emit({static_cast<double>(row_) * options_.period_s, at_, line_, s_mm_, 0});
    }
    summary_.cycle_time_s = time_s_;
    summary_.path_length_mm = s_mm_;
    summary_.setpoints = row_;
    summary_.period_s = options_.period_s;
    summary_.jerk_free_bound_s += summary_.dwell_time_s;
    for (int i = 0; i < machine_.axis_count; ++i)
        summary_.axes[i].limiting_share = summary_.cut_time_s > 0 ? drops_.limiting_s(i) / summary_.cut_time_s : 0;
    summary_.feed_drops = drops_.take(most_feed_drops);
    if (!transition_use_.empty()) {
        const auto middle = transition_use_.begin() + static_cast<std::ptrdiff_t>(transition_use_.size() / 2);
        std::nth_element(transition_use_.begin(), middle, transition_use_.end());
        summary_.tolerance_used = *middle;
    }
    summary_.work.peak_memory_mb = peak_memory_mb();
}

Result<void> check_options(const PlanOptions& options) {
    const auto positive = [](double x) { return std::isfinite(x) && x > 0; };
    const auto bad = [](std::string what) -> Result<void> {
        return fail({.code = "PIPE0001", .text = std::move(what)});
    };
    if (!positive(options.period_s)) return bad("the period must be longer than 0");
    if (!positive(options.feed_override)) return bad("the feed override must be more than 0");
    if (options.feed_mm_s && !positive(*options.feed_mm_s)) return bad("the feed must be more than 0");
    if (!positive(options.smoothing.tip_tolerance_mm)) return bad("the tip tolerance must be more than 0");
    if (!positive(options.smoothing.orientation_tolerance_rad))
        return bad("the orientation tolerance must be more than 0");
    if (!(options.smoothing.flank_tolerance_mm >= 0)) return bad("the flank tolerance must be more than 0");
    if (!positive(options.smoothing.flank_height_mm)) return bad("the flank height must be more than 0");
    return {};
}

}  // namespace

Result<Summary> plan(const program::Program& program, const machine::Machine& machine, const machine::Setup& setup,
                     const PlanOptions& options, PlanObserver& observer) {
    if (auto good = check_options(options); !good) return fail(good.error());
    auto summary = PlanRun(program, machine, setup, options, observer)();
    if (!summary) return summary;
    summary->program = program.source;
    summary->dialect = program.dialect;
    summary->machine = machine.name;
    summary->setup = setup.file;
    summary->tip_tolerance_mm = options.smoothing.tip_tolerance_mm;
    summary->orientation_tolerance_rad = options.smoothing.orientation_tolerance_rad;
    summary->flank_tolerance_mm = options.smoothing.flank_tolerance_mm;
    summary->flank_height_mm = options.smoothing.flank_height_mm;
    summary->diagnostics.insert(summary->diagnostics.begin(), program.diagnostics.begin(), program.diagnostics.end());
    return summary;
}

}  // namespace trunnion::pipeline
