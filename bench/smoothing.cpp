#include "trunnion/smoothing/smoothing.hpp"

#include <cmath>

#include <benchmark/benchmark.h>

namespace {

using namespace trunnion;

path::Run finished(path::Run run) {
    for (std::size_t i = 0; i + 1 < run.vertices.size(); ++i) {
        path::Block block;
        block.length_mm = path::block_length_mm(run, run.vertices[i], run.vertices[i + 1]);
        run.blocks.push_back(block);
    }
    return run;
}

/// Rows along X over z = 3 sin(x/12) cos(y/15), tool normal to it, 0.5 mm between rows; 3 decimals as posts write them.
path::Run sine_surface(double step_mm, int blocks) {
    path::Run run;
    const auto decimals = [](double x) { return std::round(x * 1e3) / 1e3; };
    const int per_row = static_cast<int>(80 / step_mm);
    for (int i = 0; i <= blocks; ++i) {
        const int row = i / per_row, along = i % per_row;
        const double x = (row % 2 == 0 ? along : per_row - along) * step_mm - 40, y = 0.5 * row;
        const double dx = 0.25 * std::cos(x / 12) * std::cos(y / 15), dy = -0.2 * std::sin(x / 12) * std::sin(y / 15);
        const double n = std::sqrt(1 + dx * dx + dy * dy);
        run.vertices.push_back(
            {{decimals(x), decimals(y), decimals(3 * std::sin(x / 12) * std::cos(y / 15))}, {-dx / n, -dy / n, 1 / n}});
    }
    return finished(std::move(run));
}

void smooth_blocks(benchmark::State& state, const path::Run& run) {
    smoothing::SmoothingOptions options;
    options.tip_tolerance_mm = 0.01;
    std::size_t pieces = 0;
    for (auto _ : state) {
        std::vector<path::ToolPath> out;
        smoothing::smooth(run, options, out);
        pieces = 0;
        for (const auto& path : out) pieces += path.pieces.size();
        benchmark::DoNotOptimize(out);
    }
    const auto blocks = static_cast<double>(run.blocks.size());
    state.counters["µs_per_block"] =
        benchmark::Counter(blocks, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
    state.counters["pieces_per_block"] = static_cast<double>(pieces) / blocks;
}

void dense_rows(benchmark::State& state) {
    smooth_blocks(state, sine_surface(1e-3 * static_cast<double>(state.range(0)), 10000));
}
BENCHMARK(dense_rows)->ArgName("step_um")->Arg(20)->Arg(50)->Arg(200)->Arg(1000)->Unit(benchmark::kMillisecond);

void lone_corners(benchmark::State& state) {
    path::Run run;
    for (int i = 0; i <= 1000; ++i) run.vertices.push_back({{10.0 * i, i % 2 == 0 ? 0.0 : 5.0, 0}, {0, 0, 1}});
    smooth_blocks(state, finished(std::move(run)));
}
BENCHMARK(lone_corners)->Unit(benchmark::kMillisecond);

}  // namespace
