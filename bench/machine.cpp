// Cost of the kinematics: what every sample of every stage pays.

#include <cmath>
#include <filesystem>

#include <benchmark/benchmark.h>

#include "trunnion/files/machine_file.hpp"
#include "trunnion/machine/kinematics.hpp"

namespace {

using namespace trunnion;
using namespace trunnion::machine;

Kinematics kinematics_of(const char* name) {
    const auto file = std::filesystem::path(TRUNNION_SOURCE_DIR) / "data/machines" / name;
    return Kinematics::make(files::read_machine_file(file).value(), {}, 100).value();
}

/// Tool axis and tip to all five machine axes with three derivatives.
void inverse_with_derivatives(benchmark::State& state, const char* name) {
    const auto kinematics = kinematics_of(name);
    const VectorSeries tip{Taylor3(1, 2, 3, 4), Taylor3(4, 3, 2, 1), Taylor3(1, 1, 1, 1)};
    VectorSeries axis{Taylor3(0.1, 0.2, 0.3, 0.4), Taylor3(0.4, 0.3, 0.2, 0.1), Taylor3(1, 1, 1, 1)};
    for (auto _ : state) {
        axis[0].c[0] = std::fmod(axis[0].c[0] + 0.001, 0.5);
        const auto rotary = kinematics.rotary_series(axis, {0.3, 0.3});
        benchmark::DoNotOptimize(kinematics.linear_for(tip, rotary));
    }
}
BENCHMARK_CAPTURE(inverse_with_derivatives, trunnion, "ucp710.toml");
BENCHMARK_CAPTURE(inverse_with_derivatives, head_table, "head-table.toml");
BENCHMARK_CAPTURE(inverse_with_derivatives, head_head, "head-head.toml");

void forward(benchmark::State& state) {
    const auto kinematics = kinematics_of("ucp710.toml");
    AxisPosition position{{1, 2, 3, 0.4, 0.5}};
    for (auto _ : state) {
        position[3] = std::fmod(position[3] + 0.001, 1.0);
        benchmark::DoNotOptimize(kinematics.forward(position));
    }
}
BENCHMARK(forward);

void rotary_for(benchmark::State& state) {
    const auto kinematics = kinematics_of("ucp710.toml");
    Eigen::Vector3d axis(0.1, 0.2, 0.97);
    for (auto _ : state) {
        axis.x() = std::fmod(axis.x() + 0.001, 0.2);
        benchmark::DoNotOptimize(kinematics.rotary_for(axis));
    }
}
BENCHMARK(rotary_for);

}  // namespace
