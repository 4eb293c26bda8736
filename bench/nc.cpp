#include <fstream>
#include <iterator>
#include <string>

#include <benchmark/benchmark.h>

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

void reading(benchmark::State& state, const char* name) {
    std::ifstream in(std::string(TRUNNION_SHARED_DIR) + "/data/" + name, std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(in), {}};
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

BENCHMARK_CAPTURE(reading, sine_10k, "cases/sine-10k.ngc");
BENCHMARK_CAPTURE(reading, impeller, "nc/linuxcnc/impeller-7bl-xyzac.ngc");
BENCHMARK_CAPTURE(reading, finition_creo, "nc/apt/finition_creo.ncl");

}  // namespace
