#include "detail/surface_motion_mover.hpp"

#include <algorithm>
#include <cmath>
#include <exception>
#include <limits>
#include <thread>
#include <utility>

#include <fmt/format.h>

#include "detail/bounded_queue.hpp"

namespace trunnion::pipeline {

namespace {

constexpr double constant_feed = 1e-3;
constexpr std::size_t parts_ahead = 64;

double tip_speed(const path::AxisPath& path, const motion::FeedProfile& profile,
                 const interpolation::SurfaceInstant& now) {
    const motion::ProfilePiece& piece = profile.pieces[now.profile_piece];
    path::AxisSample sample;
    path.evaluate({piece.path_piece, now.way_mm - path.tool_path().pieces[piece.path_piece].begin_mm}, sample);
    return now.contact_feed_mm_s * sample.feed_rate;
}

}  // namespace

Result<void> check_motion_options(const SurfaceMotionOptions& options) {
    if (options.plan.threads != 1 && options.plan.threads != 2)
        return fail({.code = "PIPE0001",
                     .text = fmt::format("planning runs on 1 or 2 threads, not on {}", options.plan.threads)});
    for (const auto& [what, value] : {std::pair{"the period", options.plan.period_s},
                                      {"the tolerance of places", options.place_tolerance_mm},
                                      {"the tip tolerance", options.plan.smoothing.tip_tolerance_mm}})
        if (!(value > 0 && std::isfinite(value)))
            return fail({.code = "PIPE0001",
                         .text = fmt::format("{} must be more than 0", what),
                         .value = fmt::format("{}", value)});
    return {};
}

void SurfaceMover::take(const PlannedSurfacePart& part) {
    note_when_ready(part);
    if (part.begins) begin(part);
    Following& now = *following_;
    for (const motion::ProfilePiece& piece : part.pieces) {
        now.profile.pieces.push_back(piece);
        now.table.add(part.axes(), piece, way_mm_);
        if (now.pass) now.on_surface.add(piece);
    }
    if (now.pass)
        sample_pass();
    else
        sample_link();
    if (part.plan) end(*part.plan);
}

void SurfaceMover::begin(const PlannedSurfacePart& part) {
    const path::AxisPath& axes = part.axes();
    if (!moved_) at_ = axes.begin_position();
    moved_ = true;
    stand_until(time_s_);
    following_ = std::make_unique<Following>();
    Following& now = *following_;
    now.begin.pass = part.pass;
    now.begin.link = part.link;
    if (part.pass)
        now.pass.emplace(part.pass->curve, part.pass->way, axes, now.on_surface, options_.order);
    else
        now.link.emplace(axes, now.profile);
}

void SurfaceMover::end(const feed::StretchPlan& plan) {
    const Following& now = *following_;
    const path::AxisPath& axes = now.begin.axes();
    const double duration_s = plan.profile.duration_s();
    if (now.begin.pass) add(*now.begin.pass, duration_s);
    account_.add(axes, plan, now.table, {});
    account_.add_blocks(axes.tool_path().blocks.size());
    at_ = axes.end_position();
    line_ = axes.tool_path().blocks.back().line;
    time_s_ += duration_s;
    way_mm_ = now.table.s_mm.back();
    following_.reset();
}

void SurfaceMover::note_when_ready(const PlannedSurfacePart& part) {
    const double ready_s = std::chrono::duration<double>(part.ready - start_).count();
    if (!moved_) {
        out_.first_ready_s = ready_s;
        out_.least_ahead_s = std::numeric_limits<double>::infinity();
    } else if (!part.pieces.empty()) {
        const double due_s = time_s_ + part.pieces.front().begin_s;
        out_.least_ahead_s = std::min(out_.least_ahead_s, out_.first_ready_s + due_s - ready_s);
    }
}

void SurfaceMover::add(const SurfacePass& pass, double time_s) {
    const interpolation::SurfacePath& way = pass.way;
    ++out_.passes;
    out_.pass_time_s += time_s;
    out_.pass_way_mm += way.tool_path.length_mm();
    out_.bridged_mm += way.bridged_mm;
    out_.fit_tip_mm = std::max(out_.fit_tip_mm, way.fit_tip_mm);
    out_.fit_axis_rad = std::max(out_.fit_axis_rad, way.fit_axis_rad);
    out_.bridge_tip_mm = std::max(out_.bridge_tip_mm, way.tool_path.bound.tip_mm);
    out_.bridge_axis_rad = std::max(out_.bridge_axis_rad, way.tool_path.bound.orientation_rad);
}

void SurfaceMover::emit(const motion::Setpoint& row) {
    observer_.setpoint(row);
    ++row_;
}

void SurfaceMover::stand_until(double time_s) {
    while (next_row_s() < time_s) emit({next_row_s(), at_, line_, way_mm_, 0});
}

void SurfaceMover::sample_link() {
    Following& now = *following_;
    const double end_s = time_s_ + now.profile.duration_s();
    const auto& blocks = now.begin.axes().tool_path().blocks;
    for (double t = next_row_s(); t < end_s; t = next_row_s()) {
        const interpolation::Instant at = now.link->at(t - time_s_);
        const std::size_t piece = at.path_state.profile_piece;
        const double s = now.table.s_mm[piece] + (at.tip_in_workpiece_mm - now.table.tip_mm[piece]).norm();
        emit({t, at.position, blocks[at.block].line, s, at.tip_speed_mm_s});
    }
}

void SurfaceMover::sample_pass() {
    Following& now = *following_;
    const SurfacePass& pass = *now.begin.pass;
    const double end_s = time_s_ + now.profile.duration_s();
    const std::int32_t line = pass.way.tool_path.blocks.front().line;
    for (double t = next_row_s(); t < end_s; t = next_row_s()) {
        const interpolation::SurfaceInstant at = now.pass->at(t - time_s_);
        const std::size_t piece = at.profile_piece;
        const double s = now.table.s_mm[piece] + (at.pose.tip_in_workpiece_mm - now.table.tip_mm[piece]).norm();
        const double tip = tip_speed(*pass.axes, now.profile, at);
        const double counted = options_.feed_point == interpolation::FeedPoint::tip ? tip : at.contact_feed_mm_s;
        if (std::abs(counted - pass.feed_mm_s) <= constant_feed * pass.feed_mm_s) constant_s_ += options_.plan.period_s;
        emit({t, at.position, line, s, tip});
    }
}

SurfaceMotionSummary SurfaceMover::finish() {
    if (moved_) {
        stand_until(time_s_);
        emit({next_row_s(), at_, line_, way_mm_, 0});
    }
    out_.motion = account_.take();
    out_.motion.cycle_time_s = time_s_;
    out_.motion.path_length_mm = way_mm_;
    out_.motion.setpoints = row_;
    out_.motion.machine = machine_.name;
    out_.motion.setup = setup_.file;
    out_.motion.work.elapsed_s = std::chrono::duration<double>(Clock::now() - start_).count();
    out_.constant_feed_share = out_.pass_time_s > 0 ? std::min(constant_s_ / out_.pass_time_s, 1.0) : 0;
    return std::move(out_);
}

namespace {

/// A plan on a thread of its own. What it throws is thrown by result().
class PlanningThread {
  public:
    explicit PlanningThread(const PlanSurfaceMotion& plan) : plan_(plan), thread_([this] { work(); }) {}
    ~PlanningThread() { stop(); }
    PlanningThread(const PlanningThread&) = delete;
    PlanningThread& operator=(const PlanningThread&) = delete;

    std::optional<PlannedSurfacePart> next() { return queue_.pop(); }
    Result<void> result() {
        stop();
        if (thrown_) std::rethrow_exception(thrown_);
        return std::move(done_);
    }

  private:
    void work() noexcept {
        try {
            done_ = plan_([this](PlannedSurfacePart part) { return queue_.push(std::move(part)); });
        } catch (...) {
            thrown_ = std::current_exception();
        }
        queue_.close();
    }
    void stop() {
        queue_.close();
        if (thread_.joinable()) thread_.join();
    }

    const PlanSurfaceMotion& plan_;
    BoundedQueue<PlannedSurfacePart> queue_{parts_ahead};
    Result<void> done_;
    std::exception_ptr thrown_;
    std::thread thread_;
};

}  // namespace

Result<void> move_as_planned(const PlanSurfaceMotion& plan, SurfaceMover& mover, PlanObserver& observer, int threads) {
    const auto move = [&](const PlannedSurfacePart& part) {
        mover.take(part);
        return observer.progress(part.share);
    };
    if (threads == 1) return plan(move);
    PlanningThread planning(plan);
    while (const auto part = planning.next())
        if (!move(*part)) return fail({.code = "PIPE0002", .text = "cancelled"});
    return planning.result();
}

}  // namespace trunnion::pipeline
