#include <cmath>
#include <fstream>
#include <iterator>
#include <string>

#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include "trunnion/nc/read.hpp"

// Items per second are blocks (moves) per second, from text in memory to Program.

namespace {

using namespace trunnion;

machine::Machine xyzac() {
    machine::Machine machine;
    for (const char letter : {'X', 'Y', 'Z', 'A', 'C'})
        machine.axes[static_cast<std::size_t>(machine.axis_count++)].letter = letter;
    machine.axes[3].rotary = machine.axes[4].rotary = true;
    machine.rotary_count = 2;
    machine.words = {.tcp_on = {"M428"}, .tcp_off = {"M429"}, .ignore = {}, .following = {}};
    return machine;
}

void reading(benchmark::State& state, const std::string& text, const char* name) {
    const machine::Machine machine = xyzac();
    nc::ReadOptions options;
    options.machine = &machine;
    std::size_t blocks = 0;
    for (auto _ : state) {
        auto program = nc::read_program(text, name, options);
        if (!program) {
            state.SkipWithError(to_string(program.error()).c_str());
            break;
        }
        blocks += program->moves.size();
        benchmark::DoNotOptimize(program->moves.data());
    }
    state.SetItemsProcessed(static_cast<std::int64_t>(blocks));
    state.SetBytesProcessed(static_cast<std::int64_t>(state.iterations() * text.size()));
}

void reading_file(benchmark::State& state, const char* name) {
    std::ifstream in(std::string(TRUNNION_SHARED_DIR) + "/data/" + name, std::ios::binary);
    reading(state, {std::istreambuf_iterator<char>(in), {}}, name);
}

/// A Sinumerik program of plain blocks on a spiral, with rotary words or with tool vectors.
void reading_sinumerik(benchmark::State& state, bool vectors) {
    constexpr int blocks = 100'000;
    std::string text = "%_N_SPIRAL_MPF\nTRAORI\nG54 G64 G90 G71 F3000\n";
    for (int i = 0; i < blocks; ++i) {
        const double t = 1e-3 * i;
        text += fmt::format("N{} G1 X{:.4f} Y{:.4f} Z{:.4f} ", 10 * i, t * std::cos(t), t * std::sin(t), -0.1 * t);
        const double a = 0.2 * std::sin(0.1 * t);
        text += vectors ? fmt::format("A3={:.6f} B3=0 C3={:.6f}\n", std::sin(a), std::cos(a))
                        : fmt::format("A{:.4f} C{:.4f}\n", 57.3 * a, 10 * t);
    }
    text += "M30\n";
    reading(state, text, "spiral.mpf");
}

BENCHMARK_CAPTURE(reading_sinumerik, rotary_words, false);
BENCHMARK_CAPTURE(reading_sinumerik, vectors, true);
BENCHMARK_CAPTURE(reading_file, sine_10k, "cases/sine-10k.ngc");
BENCHMARK_CAPTURE(reading_file, impeller, "nc/linuxcnc/impeller-7bl-xyzac.ngc");
BENCHMARK_CAPTURE(reading_file, finition_creo, "nc/apt/finition_creo.ncl");

}  // namespace
