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

/// Rows along X over z = 3 sin(x/12) cos(y/15), tool normal to it, 0.5 mm between rows; coordinates rounded to
/// `digit_mm`.
path::Run sine_surface(double step_mm, int blocks, double digit_mm) {
    path::Run run;
    const auto decimals = [digit_mm](double x) { return std::round(x / digit_mm) * digit_mm; };
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
    smooth_blocks(state, sine_surface(1e-3 * static_cast<double>(state.range(0)), 10000, 1e-3));
}
BENCHMARK(dense_rows)->ArgName("step_um")->Arg(20)->Arg(50)->Arg(200)->Arg(1000)->Unit(benchmark::kMillisecond);

/// Far more vertices than digits that posts write: what a neighbour costs shows.
void tiny_blocks(benchmark::State& state) {
    smooth_blocks(state, sine_surface(1e-3 * static_cast<double>(state.range(0)), 30000, 1e-7));
}
BENCHMARK(tiny_blocks)->ArgName("step_um")->Arg(1)->Arg(3)->Arg(10)->Arg(30)->Unit(benchmark::kMillisecond);

/// A ruled surface as CAM systems write it: blocks of 0.3 to 1.2 mm, the tool turning 0.5° in each, every twentieth
/// vertex an edge of 20°.
void edges_in_rows(benchmark::State& state) {
    path::Run run;
    double heading = 0, x = 0, y = 0;
    for (int i = 0; i <= 5000; ++i) {
        const double lean = 0.3 * std::sin(0.0087 * i / 0.3), length = 0.75 + 0.45 * std::sin(1.7 * i);
        run.vertices.push_back({{x, y, 0}, {std::sin(lean), 0, std::cos(lean)}});
        heading += i % 20 == 10 ? (i % 40 == 10 ? 0.35 : -0.35) : 0.01 * std::sin(0.1 * i);
        x += length * std::cos(heading);
        y += length * std::sin(heading);
    }
    smooth_blocks(state, finished(std::move(run)));
}
BENCHMARK(edges_in_rows)->Unit(benchmark::kMillisecond);

void lone_corners(benchmark::State& state) {
    path::Run run;
    for (int i = 0; i <= 1000; ++i) run.vertices.push_back({{10.0 * i, i % 2 == 0 ? 0.0 : 5.0, 0}, {0, 0, 1}});
    smooth_blocks(state, finished(std::move(run)));
}
BENCHMARK(lone_corners)->Unit(benchmark::kMillisecond);

}  // namespace
