#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <fstream>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>
#include <linux/perf_event.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

namespace trunnion::bench {

inline long involuntary_switches() {
    rusage usage{};
    getrusage(RUSAGE_THREAD, &usage);
    return usage.ru_nivcsw;
}

/// Interrupts that came while this thread ran: the timer's tick, and calls from other processors. Counted by
/// tracepoints, which takes rights; 0 where there are none.
class Interrupts {
  public:
    Interrupts() {
        for (const char* name : {"local_timer_entry", "reschedule_entry", "call_function_single_entry"}) open(name);
    }
    ~Interrupts() {
        for (const int file : files_) close(file);
    }
    Interrupts(const Interrupts&) = delete;
    Interrupts& operator=(const Interrupts&) = delete;

    bool counted() const { return !files_.empty(); }
    std::uint64_t count() const {
        std::array<std::uint64_t, 4> values{};  // their number, then each
        if (files_.empty() || read(files_.front(), values.data(), sizeof(values)) < 0) return 0;
        return values[1] + values[2] + values[3];
    }

  private:
    void open(const std::string& name) {
        std::ifstream id("/sys/kernel/tracing/events/irq_vectors/" + name + "/id");
        perf_event_attr wanted{};
        wanted.type = PERF_TYPE_TRACEPOINT;
        wanted.size = sizeof(wanted);
        wanted.read_format = PERF_FORMAT_GROUP;
        if (!(id >> wanted.config)) return;
        const int leader = files_.empty() ? -1 : files_.front();
        const long file = syscall(SYS_perf_event_open, &wanted, 0, -1, leader, 0);
        if (file >= 0) files_.push_back(static_cast<int>(file));
    }

    std::vector<int> files_;
};

/// Seconds that the machine below took away from all processors.
inline double stolen_s() {
    std::ifstream file("/proc/stat");
    std::string cpu;
    std::array<double, 8> ticks{};
    file >> cpu;
    for (double& value : ticks) file >> value;
    return ticks[7] / static_cast<double>(sysconf(_SC_CLK_TCK));
}

/// In which parts of the kernel's tick of 4 ms (250 Hz) interrupts come: those in which a second of looking at the
/// clock had three times as many gaps above 10 µs as the median part, and the parts before and behind them. A control
/// whose period divides the tick's begins its periods between them.
class TickPhase {
  public:
    TickPhase() {
        using clock = std::chrono::steady_clock;
        std::array<int, parts> gaps{};
        const auto begin = clock::now();
        for (auto last = begin; last - begin < std::chrono::seconds(1);) {
            const auto now = clock::now();
            if (now - last > std::chrono::microseconds(10)) ++gaps[part_of(last)];
            last = now;
        }
        auto sorted = gaps;
        std::ranges::nth_element(sorted, sorted.begin() + parts / 2);
        const int many = 3 * std::max(sorted[parts / 2], 1);
        for (std::size_t k = 0; k < parts; ++k)
            if (gaps[k] > many) busy_[k] = busy_[(k + 1) % parts] = busy_[(k + parts - 1) % parts] = true;
    }
    /// Whether a period that begins at this time is between the tick's interrupts.
    bool is_quiet(std::chrono::steady_clock::time_point at) const { return !busy_[part_of(at)]; }

  private:
    static constexpr std::size_t parts = 40;
    static std::size_t part_of(std::chrono::steady_clock::time_point at) {
        const auto ns = std::chrono::duration_cast<std::chrono::nanoseconds>(at.time_since_epoch()).count();
        return static_cast<std::size_t>(ns % 4'000'000) / (4'000'000 / parts);
    }
    std::array<bool, parts> busy_{};
};

/// Times of single periods, by nanoseconds up to 100 µs.
class Distribution {
  public:
    void add(std::int64_t ns) {
        ++counts_[static_cast<std::size_t>(std::clamp<std::int64_t>(ns, 0, most))];
        ++all_;
        sum_ns_ += static_cast<double>(ns);
        longest_ns_ = std::max(longest_ns_, ns);
    }
    std::size_t count() const { return all_; }
    double mean_us() const { return sum_ns_ / static_cast<double>(all_) / 1000; }
    double longest_us() const { return static_cast<double>(longest_ns_) / 1000; }
    double below_us(double share) const {
        std::size_t sum = 0;
        for (std::size_t ns = 0; ns < counts_.size(); ++ns) {
            sum += counts_[ns];
            if (static_cast<double>(sum) >= share * static_cast<double>(all_)) return static_cast<double>(ns) / 1000;
        }
        return static_cast<double>(most) / 1000;
    }
    double share_above(double us) const {
        std::size_t sum = 0;
        for (auto ns = static_cast<std::size_t>(us * 1000) + 1; ns < counts_.size(); ++ns) sum += counts_[ns];
        return static_cast<double>(sum) / static_cast<double>(all_);
    }

  private:
    static constexpr std::int64_t most = 100'000;
    std::vector<std::size_t> counts_ = std::vector<std::size_t>(most + 1);
    std::size_t all_ = 0;
    double sum_ns_ = 0;
    std::int64_t longest_ns_ = 0;
};

/// Times `work` alone, once an iteration. Iterations during which the system took the processor away are counted by
/// themselves; of the others also those that no interrupt came into, and those that began between the tick's
/// interrupts. For a quiet measure: chrt -f 80 taskset -c 0.
template <class Work>
void time_each(benchmark::State& state, const Work& work) {
    using clock = std::chrono::steady_clock;
    mlockall(MCL_CURRENT | MCL_FUTURE);
    Distribution undisturbed, uninterrupted, off_tick;
    const TickPhase tick;
    std::size_t disturbed = 0;
    const Interrupts interrupts;
    const double stolen_before_s = stolen_s();
    long switches = involuntary_switches();
    std::uint64_t interrupted = interrupts.count();
    for (auto _ : state) {
        const auto start = clock::now();
        work();
        const auto end = clock::now();
        const std::uint64_t interrupted_after = interrupts.count();
        const long after = involuntary_switches();
        state.SetIterationTime(std::chrono::duration<double>(end - start).count());
        const auto ns = std::chrono::duration_cast<std::chrono::nanoseconds>(end - start).count();
        if (after == switches) {
            undisturbed.add(ns);
            if (interrupted_after == interrupted) uninterrupted.add(ns);
            if (tick.is_quiet(start)) off_tick.add(ns);
        } else {
            ++disturbed;
        }
        switches = involuntary_switches();
        interrupted = interrupts.count();
    }
    munlockall();
    state.counters["mean_us"] = undisturbed.mean_us();
    state.counters["p99.99_us"] = undisturbed.below_us(0.9999);
    state.counters["above_10us"] = undisturbed.share_above(10);
    state.counters["longest_us"] = undisturbed.longest_us();
    state.counters["switched"] = static_cast<double>(disturbed);
    state.counters["off_tick"] = static_cast<double>(off_tick.count());
    state.counters["off_p99.99_us"] = off_tick.below_us(0.9999);
    state.counters["off_above_10us"] = off_tick.share_above(10);
    if (interrupts.counted()) {
        state.counters["quiet_p99.99_us"] = uninterrupted.below_us(0.9999);
        state.counters["quiet_above_10us"] = uninterrupted.share_above(10);
        state.counters["interrupted"] = static_cast<double>(undisturbed.count() - uninterrupted.count());
    }
    state.counters["stolen_s"] = stolen_s() - stolen_before_s;
    state.counters["fifo"] = sched_getscheduler(0) == SCHED_FIFO;
}

}  // namespace trunnion::bench
