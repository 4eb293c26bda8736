#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include <tpmod/tp_memory.h>

#include "job.hpp"
#include "play_planner.hpp"
#include "serve_orders.hpp"

namespace trunnion::app {

/// Says to the module that the planner lives, also while one plan takes long. Who has not said here() for ten seconds
/// is taken for dead.
class Heartbeat {
  public:
    explicit Heartbeat(volatile std::uint64_t& beat);
    void here() { last_s_ = now_s(); }

  private:
    static std::int64_t now_s();
    void run(const std::stop_token& stop);

    volatile std::uint64_t& beat_;
    std::atomic<std::int64_t> last_s_;
    std::mutex mutex_;
    std::condition_variable_any ended_;
    std::jthread thread_;
};

/// Plans what the module orders, from one `begin` to the next.
class OrderServer {
  public:
    /// Both must outlive it.
    OrderServer(trunnion_tp_memory& memory, const Workplace& workplace);

    ~OrderServer();
    OrderServer(const OrderServer&) = delete;
    OrderServer& operator=(const OrderServer&) = delete;

    /// Looks once at what there is to do, and makes one plan at most; some 5 times a period is enough.
    void work();
    bool module_is_gone() const { return memory_.orders.closed != 0; }

  private:
    struct Motion;

    void take_orders();
    void begin(const trunnion_order& order);
    void add(const trunnion_order& order);
    void pass_on_wishes();
    void run_through(std::uint64_t number);
    void advance();
    void refuse(const std::string& reason);

    trunnion_tp_memory& memory_;
    const Workplace& workplace_;
    std::unique_ptr<Motion> now_;
    std::uint32_t epoch_ = 0;
    double scale_ = 1, largest_speed_ = 0;
    std::uint64_t run_through_ = TRUNNION_RUN_ALL;
    bool closed_ = false;
    std::optional<std::string> failure_;  // of the motion under way; told if no other one is begun
    Heartbeat heartbeat_;
};

}  // namespace trunnion::app
