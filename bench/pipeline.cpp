// The whole way, program text to setpoints, on one core: blocks per second of dense 5-axis blocks.
#include <cmath>
#include <string>

#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include "trunnion/files/machine_file.hpp"
#include "trunnion/nc/read.hpp"
#include "trunnion/pipeline/plan.hpp"

namespace trunnion {
namespace {

/// Rows over a wavy surface, tool leaning; C and A of the shipped UCP 710.
std::string wavy_rows(int blocks, double step_mm) {
    std::string text = "G21 G90 G94 G54\n";
    double x = -40, y = -40, way = 1;
    for (int k = 0; k <= blocks; ++k) {
        const double z = 3 * std::sin(x / 15) * std::cos(y / 15), zx = 0.2 * std::cos(x / 15) * std::cos(y / 15);
        const double zy = -0.2 * std::sin(x / 15) * std::sin(y / 15);
        const double i = -zx, j = -zy + 0.466, length = std::sqrt(i * i + j * j + 1);
        const double a = std::acos(1 / length) * 180 / M_PI, c = std::atan2(i, -j) * 180 / M_PI;
        text += fmt::format("{} X{:.6f} Y{:.6f} Z{:.6f} A{:.6f} C{:.6f}{}\n", k == 0 ? "G0" : "G1", x, y, z, a,
                            c < 0 ? c + 360 : c, k == 1 ? " F10000" : "");
        const double next = x + way * step_mm / std::sqrt(1 + zx * zx);
        if (std::abs(next) > 40) {
            y += step_mm;
            way = -way;
        } else {
            x = next;
        }
    }
    return text + "M2\n";
}

void whole_way(benchmark::State& state) {
    const double step_mm = static_cast<double>(state.range(0)) * 1e-3;
    const int blocks = 5000;
    const std::string text = wavy_rows(blocks, step_mm);
    const auto machine = files::read_machine_file(TRUNNION_SOURCE_DIR "/data/machines/ucp710.toml");
    nc::ReadOptions reading;
    reading.machine = &*machine;
    machine::Setup setup;
    setup.workpiece.origin_mm = {0, 0, 50};
    pipeline::PlanOptions options;
    options.smoothing.tip_tolerance_mm = 0.01;
    pipeline::PlanObserver nobody;
    for (auto _ : state) {
        const auto program = nc::read_program(text, "rows.ngc", reading);
        if (!program) return state.SkipWithError(to_string(program.error()).c_str());
        auto summary = pipeline::plan(*program, *machine, setup, options, nobody);
        if (!summary) return state.SkipWithError(to_string(summary.error()).c_str());
        benchmark::DoNotOptimize(summary->cycle_time_s);
    }
    state.SetItemsProcessed(state.iterations() * blocks);
}
BENCHMARK(whole_way)->ArgName("block_um")->Arg(50)->Arg(200)->Arg(1000)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace trunnion
