#include "serve_server.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include <fmt/format.h>

namespace trunnion::app {

namespace {

using pipeline::LiveMotionStatus;

// Without an order for so long: what came is all for now. At the least so many periods, as orders come one a period.
constexpr double quiet_s = 0.025;
constexpr std::uint64_t least_quiet = 25;
// What planning may take, if it did not take longer the last time (PlanPublisher).
constexpr double lead_s = 0.05;
constexpr std::uint64_t least_lead = 20;
constexpr double share_of_buffer = 0.7;  // that the way to a standstill may take

std::uint64_t periods_of(double time_s, double period_s, std::uint64_t least) {
    return std::max(least, static_cast<std::uint64_t>(std::ceil(time_s / period_s)));
}
constexpr auto between_beats = std::chrono::milliseconds(50);
constexpr std::int64_t dead_after_s = 10;

}  // namespace

Heartbeat::Heartbeat(volatile std::uint64_t& beat)
    : beat_(beat), last_s_(now_s()), thread_([this](const std::stop_token& stop) { run(stop); }) {}

std::int64_t Heartbeat::now_s() {
    return std::chrono::duration_cast<std::chrono::seconds>(std::chrono::steady_clock::now().time_since_epoch())
        .count();
}

void Heartbeat::run(const std::stop_token& stop) {
    for (std::unique_lock lock(mutex_); !stop.stop_requested();) {
        if (now_s() - last_s_ < dead_after_s) __atomic_store_n(&beat_, beat_ + 1, __ATOMIC_RELAXED);
        ended_.wait_for(lock, stop, between_beats, [] { return false; });
    }
}

struct OrderServer::Motion {
    WorldPoses poses;
    pipeline::QueuedPose end;  // of what was ordered
    pipeline::QueueMotion motion;
    PlanPublisher publisher;
    Motion(WorldPoses world, const pipeline::QueuedPose& begin, pipeline::QueueMotion queue, trunnion_plans& plans,
           double period_s)
        : poses(std::move(world)),
          end(begin),
          motion(std::move(queue)),
          publisher(
              motion, [this](const pipeline::LiveRow& row) { return poses.row_of(row); }, plans,
              periods_of(lead_s, period_s, least_lead)) {}
};

OrderServer::OrderServer(trunnion_tp_memory& memory, const Workplace& workplace)
    : memory_(memory), workplace_(workplace), heartbeat_(memory.orders.beat) {
    if (memory.orders.answered != 0) refuse("the planner was started anew: abort, and start the program again");
}
OrderServer::~OrderServer() = default;

void OrderServer::refuse(const std::string& reason) {
    std::strncpy(memory_.orders.reason, reason.c_str(), sizeof memory_.orders.reason - 1);
    __atomic_store_n(&memory_.orders.refused, memory_.orders.refused + 1, __ATOMIC_RELEASE);
    fmt::print(stderr, "{}\n", reason);
}

void OrderServer::work() {
    heartbeat_.here();
    take_orders();
    if (failure_) refuse(*std::exchange(failure_, std::nullopt));
    if (!now_) return;
    pass_on_wishes();
    advance();
}

void OrderServer::take_orders() {
    for (trunnion_order order; trunnion_order_read(&memory_.orders, &order);) {
        if (order.kind == trunnion_order_begin)
            begin(order);
        else if (now_ && order.epoch == epoch_)
            add(order);
    }
}

/// From here on nothing of before is published any more.
void OrderServer::begin(const trunnion_order& order) {
    now_.reset();
    failure_.reset();
    epoch_ = order.epoch;
    scale_ = 1;
    largest_speed_ = std::numeric_limits<double>::infinity();
    run_through_ = TRUNNION_RUN_ALL;
    closed_ = false;
    memory_.orders.done_through = order.number;
    auto poses = WorldPoses::make(workplace_.machine, order.tool_length);
    if (!poses) return refuse(to_string(poses.error()));
    pipeline::QueueOptions options;
    options.plan = workplace_.options;
    options.plan.period_s = memory_.orders.period_s;
    options.longest_plan_s =
        std::min(options.longest_plan_s, share_of_buffer * TRUNNION_PLAN_ROWS * memory_.orders.period_s);
    const pipeline::QueuedPose at = poses->pose_of(order.end);
    auto motion = pipeline::QueueMotion::make(workplace_.machine, order.tool_length, at, options);
    if (!motion) return refuse(to_string(motion.error()));
    now_ = std::make_unique<Motion>(std::move(*poses), at, std::move(*motion), memory_.plans, memory_.orders.period_s);
    now_->publisher.begin_at_reader();
    __atomic_store_n(&memory_.orders.answered, epoch_, __ATOMIC_RELEASE);
}

void OrderServer::add(const trunnion_order& order) {
    const pipeline::QueuedMove move = move_of(order, now_->end, now_->poses);
    now_->motion.add(move);
    now_->end = move.end;
    closed_ = false;
}

void OrderServer::run_through(std::uint64_t number) {
    if (number == 0) return now_->motion.hold();
    const bool all = number == TRUNNION_RUN_ALL;
    now_->motion.step_through(all ? std::nullopt : std::optional(static_cast<std::int32_t>(number)));
    now_->motion.resume();
}

void OrderServer::pass_on_wishes() {
    const trunnion_orders& orders = memory_.orders;
    if (orders.feed_scale != scale_) now_->motion.set_override(scale_ = orders.feed_scale);
    if (orders.largest_speed != largest_speed_) now_->motion.set_largest_speed(largest_speed_ = orders.largest_speed);
    const std::uint64_t through = __atomic_load_n(&orders.run_through, __ATOMIC_ACQUIRE);
    if (through != run_through_) run_through(run_through_ = through);
    if (!closed_ && orders.cycles - orders.last_order >= periods_of(quiet_s, orders.period_s, least_quiet)) {
        now_->motion.close();
        closed_ = true;
    }
}

void OrderServer::advance() {
    trunnion_orders& orders = memory_.orders;
    const auto advance = now_->publisher.advance();
    if (!advance) {
        const bool left = advance.error().code == "RT0005";  // LinuxCNC does something else, and begins anew
        if (!left) failure_ = to_string(advance.error());
        now_.reset();
        return;
    }
    if (!now_->publisher.is_settled()) return;
    orders.done_through = static_cast<std::uint64_t>(now_->motion.done_at_standstill());
    const bool stands = advance->status != LiveMotionStatus::moving;
    if (orders.aborted != epoch_ || !stands) return;
    orders.stopped = epoch_;
    now_.reset();  // it is over, also when the hold is taken back before the next `begin`
}

}  // namespace trunnion::app
