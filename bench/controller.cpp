// Predictions: blocks a second of one core, the choice of branch and the kinematics included.
#include <cmath>

#include <benchmark/benchmark.h>

#include "trunnion/base/quantity.hpp"
#include "trunnion/controller/predict.hpp"
#include "trunnion/files/controller_file.hpp"
#include "trunnion/files/machine_file.hpp"

namespace {

using namespace trunnion;

/// A wave of the tip with the tool swaying, in blocks of 0.2 mm.
program::Program waves(int blocks) {
    constexpr double step_mm = 0.2;
    program::Program out;
    program::Move move;
    move.feed = {program::FeedRule::tip_speed, 5000.0 / 60};
    for (int k = 0; k <= blocks; ++k) {
        const double way = step_mm * k, place = std::fmod(way, 200);
        const double along = static_cast<int>(way / 200) % 2 == 0 ? place : 200 - place;
        const double lean = 0.5 + 0.2 * std::sin(way / 15), side = 0.4 * std::sin(way / 23);
        move.position_mm = {along, 5 * std::sin(way / 10), std::cos(way / 7)};
        move.axis = Eigen::Vector3d(std::sin(side), std::sin(lean), std::cos(lean)).normalized();
        move.line = k + 1;
        out.moves.push_back(move);
    }
    return out;
}

void predict(benchmark::State& state, const char* controller_file, bool uncertainty) {
    const std::string data = TRUNNION_SOURCE_DIR "/data/";
    const auto machine = files::read_machine_file(data + "machines/ucp710.toml").value();
    const auto controller = files::read_controller_file(data + controller_file).value();
    const auto program = waves(static_cast<int>(state.range(0)));
    controller::PredictOptions options;
    options.uncertainty = uncertainty;
    double time_s = 0;
    for (auto _ : state) time_s = controller::predict(program, machine, {}, controller, options).value().cycle_time_s;
    state.counters["cycle_time_s"] = time_s;
    state.counters["blocks/s"] =
        benchmark::Counter(static_cast<double>(state.range(0)), benchmark::Counter::kIsIterationInvariantRate);
}

void lavernhe(benchmark::State& state) {
    predict(state, "controllers/lavernhe-2006.toml", false);
}
void lavernhe_with_uncertainty(benchmark::State& state) {
    predict(state, "controllers/lavernhe-2006.toml", true);
}
void length_over_feed(benchmark::State& state) {
    predict(state, "controllers/length-over-feed.toml", false);
}

BENCHMARK(lavernhe)->Arg(100'000)->Unit(benchmark::kMillisecond);
BENCHMARK(lavernhe_with_uncertainty)->Arg(100'000)->Unit(benchmark::kMillisecond);
BENCHMARK(length_over_feed)->Arg(100'000)->Unit(benchmark::kMillisecond);

}  // namespace
