#include <benchmark/benchmark.h>

#include "trunnion/feed/plan_stretch.hpp"

#include "../tests/unit/feed/synthetic_paths.hpp"

namespace {

using namespace trunnion;

/// The whole stream, gridding and path evaluation included: random corners on a 5-axis machine.
void plan_corners(benchmark::State& state) {
    const test::Stretch path = test::random_corners(3, 100);
    std::size_t intervals = 0;
    for (auto _ : state) {
        const auto plan = feed::plan_stretch(*path.axis_path, {.window = static_cast<std::size_t>(state.range(0))});
        intervals += plan->intervals;
    }
    state.counters["us_per_interval"] = benchmark::Counter(1e-6 * static_cast<double>(intervals),
                                                           benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}
BENCHMARK(plan_corners)->Arg(200)->Arg(300)->Arg(600)->Arg(2000)->Unit(benchmark::kMillisecond);

void plan_straight(benchmark::State& state) {
    const test::Stretch path = test::straight({100, 0, 0, 0, 0}, 100, test::trunnion_limits());
    for (auto _ : state) benchmark::DoNotOptimize(feed::plan_stretch(*path.axis_path, {}));
}
BENCHMARK(plan_straight)->Unit(benchmark::kMicrosecond);

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
