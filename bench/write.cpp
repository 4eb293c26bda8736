#include "trunnion/nc/write.hpp"

#include <cmath>
#include <cstddef>
#include <string_view>

#include <benchmark/benchmark.h>

#include "trunnion/base/diagnostic.hpp"

// Items per second are blocks (moves) per second, from Program to text that nobody keeps.

namespace {

using namespace trunnion;

/// Plain five-axis blocks on a spiral.
program::Program spiral(bool vectors) {
    constexpr int blocks = 100'000;
    program::Program out;
    if (!vectors) out.rotary_letters = {'A', 'C'};
    for (int i = 0; i < blocks; ++i) {
        const double t = 1e-3 * i, a = 0.2 * std::sin(0.1 * t);
        program::Move move;
        move.position_mm = {t * std::cos(t), t * std::sin(t), -0.1 * t};
        move.law = vectors ? program::OrientationLaw::vector : program::OrientationLaw::rotary;
        move.axis = {std::sin(a), 0, std::cos(a)};
        move.rotary_rad = {a, 0.2 * t, 0};
        move.feed = {program::FeedRule::tip_speed, 50};
        out.moves.push_back(move);
    }
    return out;
}

void writing(benchmark::State& state, nc::Dialect dialect, bool vectors, bool inverse_time) {
    const program::Program program = spiral(vectors);
    nc::WriteOptions options;
    options.dialect = dialect;
    options.inverse_time = inverse_time;
    std::size_t bytes = 0;
    for (auto _ : state) {
        const auto written =
            nc::write_program(program, nullptr, options, [&](std::string_view text) { bytes += text.size(); });
        if (!written) {
            state.SkipWithError(to_string(written.error()).c_str());
            break;
        }
    }
    state.SetItemsProcessed(static_cast<std::int64_t>(state.iterations() * program.moves.size()));
    state.SetBytesProcessed(static_cast<std::int64_t>(bytes));
}

BENCHMARK_CAPTURE(writing, rs274, nc::Dialect::rs274, false, false);
BENCHMARK_CAPTURE(writing, rs274_inverse_time, nc::Dialect::rs274, false, true);
BENCHMARK_CAPTURE(writing, sinumerik_words, nc::Dialect::sinumerik, false, false);
BENCHMARK_CAPTURE(writing, sinumerik_vectors, nc::Dialect::sinumerik, true, false);
BENCHMARK_CAPTURE(writing, heidenhain_vectors, nc::Dialect::heidenhain, true, false);
BENCHMARK_CAPTURE(writing, fanuc_vectors, nc::Dialect::fanuc, true, false);
BENCHMARK_CAPTURE(writing, apt, nc::Dialect::apt, true, false);

}  // namespace
