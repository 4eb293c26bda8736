// Planning alone: intervals are made beforehand, and what is counted is what the planner does with them.
#include <algorithm>
#include <ctime>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>
#include <fmt/format.h>
#include <sys/resource.h>

#include "trunnion/feed/feed_planner.hpp"
#include "trunnion/feed/plan_stretch.hpp"
#include "trunnion/files/machine_file.hpp"

#include "../src/feed/detail/jerk_free.hpp"
#include "../tests/optimum/smoothed_path.hpp"
#include "../tests/unit/feed/flank_path.hpp"
#include "../tests/unit/feed/synthetic_paths.hpp"

namespace {

using namespace trunnion;
/// Of this thread: what else the computer does matters less.
double processor_s() {
    timespec now{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

std::vector<feed::Interval> intervals_of(const path::AxisPath& path) {
    std::vector<feed::Interval> out;
    auto stream = test::value_of(feed::IntervalStream::make(path, {}));
    for (feed::Interval interval; test::value_of(stream.next(interval));) out.push_back(interval);
    return out;
}

feed::LimitSet limits_of(const machine::Machine& machine) {
    feed::LimitSet out;
    for (int a = 0; a < machine.axis_count; ++a) out.of[a] = machine.axes[a].feed;
    return out;
}

double peak_memory_mb() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return static_cast<double>(usage.ru_maxrss) / 1024;
}

constexpr double straight_mm = 250;

/// A zigzag of so many straights.
test::Stretch zigzag(int straights) {
    test::CornerPath corners;
    for (int k = 0; k < straights; ++k) {
        const double side = k % 2 == 0 ? 0.3 : -0.3;
        corners.straight_to({0.9, side, 0, 0.01 * side, 0.01}, straight_mm);
    }
    test::Stretch out;
    out.machine = test::five_axis_machine(test::trunnion_limits());
    out.tool_path = corners.make(0.02);
    out.close();
    return out;
}

/// A kilometre into a planner that keeps nothing of it: a zigzag's intervals from the middle of one straight to that of
/// one alike, over and over. First in this file, for what it reports is how much the peak of the process grows.
void memory_of_a_kilometre(benchmark::State& state) {
    constexpr double kilometre = 1e6;
    const test::Stretch path = zigzag(13);
    const std::vector<feed::Interval> all = intervals_of(*path.axis_path);
    const double before_mb = peak_memory_mb();
    std::size_t pieces = 0;
    for (auto _ : state) {
        feed::FeedPlanner planner(limits_of(path.machine), {},
                                  [&pieces](const feed::Interval&, const motion::ProfilePiece&) { ++pieces; });
        const auto place = [&](const feed::Interval& i) {
            return path.tool_path.pieces[i.begin.piece].begin_mm + i.begin.offset_mm;
        };
        const auto before = [&](double p) {
            return std::partition_point(all.begin(), all.end(), [&](const feed::Interval& i) { return place(i) < p; });
        };
        const auto begin = before(1.5 * straight_mm), end = before(path.axis_path->length_mm() - 1.5 * straight_mm);
        const auto push = [&](auto from, auto to) { std::for_each(from, to, [&](const auto& i) { planner.push(i); }); };
        push(all.begin(), begin);
        for (double way = 0; way < kilometre; way += place(*end) - place(*begin)) push(begin, end);
        push(end, all.end());
        if (!planner.finish()) return state.SkipWithError("not planned");
    }
    state.counters["peak_growth_mb"] = peak_memory_mb() - before_mb;
    state.counters["intervals"] = static_cast<double>(pieces);
}
BENCHMARK(memory_of_a_kilometre)->Iterations(1)->Unit(benchmark::kSecond);

/// A path of the set on which the planner is judged, kept with what it is made of.
struct Subject {
    std::string name;
    std::shared_ptr<const void> made_of;
    const path::AxisPath* path = nullptr;
    std::vector<feed::Interval> intervals;
};

Subject of_stretch(std::string name, std::shared_ptr<const test::Stretch> stretch) {
    return {std::move(name), stretch, stretch->axis_path.get(), intervals_of(*stretch->axis_path)};
}

Subject of_program(std::string name, const std::string& text, const smoothing::SmoothingOptions& options) {
    machine::Setup setup;
    setup.workpiece.origin_mm = {0, 0, 50};
    const auto path = std::make_shared<const test::SmoothedPath>(test::five_axis_machine(test::trunnion_limits()),
                                                                 setup, text, options);
    return {std::move(name), path, &path->axis_path(), intervals_of(path->axis_path())};
}

Subject pyramid(double tolerance_mm) {
    smoothing::SmoothingOptions options;
    options.tip_tolerance_mm = options.flank_tolerance_mm = tolerance_mm;
    return of_program(fmt::format("pyramid {} mm", tolerance_mm), test::pyramid(), options);
}

Subject spiral(double length_mm, double step_mm) {
    smoothing::SmoothingOptions options;
    options.tip_tolerance_mm = 0.01;
    return of_program(fmt::format("spiral {} mm", length_mm), test::spiral(length_mm, step_mm), options);
}

Subject random_corners(std::uint64_t seed) {
    // Made in its place: a stretch does not move.
    const std::shared_ptr<const test::Stretch> stretch(new test::Stretch(test::random_corners(seed, 12)));
    return of_stretch(fmt::format("random {}", seed), stretch);
}

/// All but the longest spiral.
const std::vector<Subject>& subjects() {
    static const std::vector<Subject> all = [] {
        std::vector<Subject> out;
        if (std::shared_ptr<test::Stretch> flank = test::flank_path()) {
            out.push_back(of_stretch("flank", flank));
            std::shared_ptr<test::Stretch> shipped = test::flank_path();
            const auto machine =
                test::value_of(files::read_machine_file(TRUNNION_SOURCE_DIR "/data/machines/ucp710.toml"));
            for (int a = 0; a < 5; ++a) shipped->machine.axes[a].feed = machine.axes[a].feed;
            shipped->close();
            out.push_back(of_stretch("flank, ucp710", shipped));
        }
        for (const double tolerance_mm : {0.01, 0.02, 0.05, 0.1}) out.push_back(pyramid(tolerance_mm));
        for (const double length_mm : {200.0, 2000.0}) out.push_back(spiral(length_mm, 0.1));
        for (std::uint64_t seed = 1; seed <= 20; ++seed) out.push_back(random_corners(seed));
        return out;
    }();
    return all;
}

template <class Push>
void plan(const Subject& subject, const feed::FeedOptions& options, const Push& timed) {
    feed::StretchPlanner planner(*subject.path, options);
    for (const feed::Interval& interval : subject.intervals) timed([&] { planner.push(interval); });
    timed([&] { test::value_of(planner.finish()); });
}

double cost_s(const Subject& subject, const feed::FeedOptions& options) {
    const double begin = processor_s();
    plan(subject, options, [](const auto& work) { work(); });
    return processor_s() - begin;
}

/// The longest that a push or the end keeps its caller waiting: one window, with everything that is done again in it.
double longest_window_s(const Subject& subject, const feed::FeedOptions& options) {
    double longest = 0;
    plan(subject, options, [&longest](const auto& work) {
        const double begin = processor_s();
        work();
        longest = std::max(longest, processor_s() - begin);
    });
    return longest;
}

/// Median over the paths of the cost of an interval, and the longest window of all.
void stream_over_the_set(benchmark::State& state) {
    subjects();
    feed::FeedOptions options;
    options.window = static_cast<std::size_t>(state.range(0));
    std::vector<double> cost_us;
    for (auto _ : state)
        for (const Subject& subject : subjects())
            cost_us.push_back(1e6 * cost_s(subject, options) / static_cast<double>(subject.intervals.size()));
    double longest_s = 0;
    for (const Subject& subject : subjects()) longest_s = std::max(longest_s, longest_window_s(subject, options));
    std::sort(cost_us.begin(), cost_us.end());
    state.counters["median_us_per_interval"] = cost_us[cost_us.size() / 2];
    state.counters["least"] = cost_us.front();
    state.counters["most"] = cost_us.back();
    state.counters["longest_window_ms"] = 1e3 * longest_s;
}
BENCHMARK(stream_over_the_set)->ArgName("window")->Arg(200)->Arg(300)->Arg(600)->Unit(benchmark::kMillisecond);

void stream_one(benchmark::State& state, const std::function<Subject()>& make) {
    const Subject subject = make();
    std::size_t intervals = 0;
    for (auto _ : state) {
        cost_s(subject, {});
        intervals += subject.intervals.size();
    }
    state.counters["us_per_interval"] = benchmark::Counter(1e-6 * static_cast<double>(intervals),
                                                           benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
    state.counters["intervals"] = static_cast<double>(subject.intervals.size());
    state.counters["longest_window_ms"] = 1e3 * longest_window_s(subject, {});
}
BENCHMARK_CAPTURE(stream_one, pyramid_20um, [] { return pyramid(0.02); })->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(stream_one, random_corners, [] { return random_corners(3); })->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(stream_one, spiral_2m, [] { return spiral(2000, 0.1); })->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(stream_one, spiral_20m, [] { return spiral(20000, 0.2); })->Unit(benchmark::kMillisecond);

constexpr std::size_t bound_window = 500;

/// The bound without jerk alone, in windows, over so many thousand places of the spiral again and again.
void jerk_free_bound(benchmark::State& state) {
    const Subject once = spiral(2000, 0.1);
    const std::size_t wanted = 1000 * static_cast<std::size_t>(state.range(0)) / feed::JerkFreeScan::steps_per_interval;
    std::vector<feed::Interval> intervals;
    while (intervals.size() < wanted)
        intervals.insert(intervals.end(), once.intervals.begin() + 1,
                         once.intervals.begin() + static_cast<std::ptrdiff_t>(std::min(once.intervals.size() - 1,
                                                                                       wanted + 1 - intervals.size())));
    const feed::LimitSet limits = limits_of(once.path->machine());
    double time_s = 0;
    for (auto _ : state) {
        feed::JerkFreeScan scan(limits);
        time_s = 0;
        for (std::size_t begin = 0; begin < intervals.size();) {
            const std::size_t left = intervals.size() - begin, window = std::min(left, bound_window);
            const std::size_t commit = window == left ? left : window * 9 / 10;
            time_s += scan.advance(std::span(intervals).subspan(begin, window), commit, window == left);
            begin += commit;
        }
    }
    if (!(time_s > 0)) return state.SkipWithError("no bound");
    const double points = static_cast<double>(intervals.size() * feed::JerkFreeScan::steps_per_interval);
    state.counters["us_per_point"] =
        benchmark::Counter(1e-6 * points, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}
BENCHMARK(jerk_free_bound)->ArgName("thousand_points")->Arg(10)->Arg(1000)->Unit(benchmark::kMillisecond);

/// The whole stream, gridding and path evaluation included: random corners on a 5-axis machine.
void grid_and_plan_corners(benchmark::State& state) {
    const test::Stretch path = test::random_corners(3, 100);
    std::size_t intervals = 0;
    for (auto _ : state) {
        const auto plan = feed::plan_stretch(*path.axis_path, {.window = static_cast<std::size_t>(state.range(0))});
        intervals += plan->intervals;
    }
    state.counters["us_per_interval"] = benchmark::Counter(1e-6 * static_cast<double>(intervals),
                                                           benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}
BENCHMARK(grid_and_plan_corners)->Arg(200)->Arg(300)->Arg(600)->Arg(2000)->Unit(benchmark::kMillisecond);

void grid_and_plan_straight(benchmark::State& state) {
    const test::Stretch path = test::straight({100, 0, 0, 0, 0}, 100, test::trunnion_limits());
    for (auto _ : state) benchmark::DoNotOptimize(feed::plan_stretch(*path.axis_path, {}));
}
BENCHMARK(grid_and_plan_straight)->Unit(benchmark::kMicrosecond);

void distance_at(benchmark::State& state) {
    motion::ProfilePiece piece;
    piece.length_mm = 2;
    piece.x0 = 100;
    piece.d0 = 30;
    piece.e0 = -20;
    piece.e1 = 15;
    const double total = motion::time_to(piece, 2);
    double t = 0;
    for (auto _ : state) {
        t = t + 0.137 * total;
        if (t > total) t -= total;
        benchmark::DoNotOptimize(motion::distance_at(piece, t));
    }
}
BENCHMARK(distance_at);

}  // namespace
