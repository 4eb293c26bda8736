#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include <benchmark/benchmark.h>
#include <fmt/format.h>
#include <unistd.h>

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

/// GOTO/x,y,z,i,j,k on the same spiral.
void reading_apt(benchmark::State& state) {
    constexpr int blocks = 100'000;
    std::string text = "UNITS/MM\nMULTAX/ON\nFEDRAT/3000,MMPM\n";
    for (int i = 0; i < blocks; ++i) {
        const double t = 1e-3 * i, a = 0.2 * std::sin(0.1 * t);
        text += fmt::format("GOTO/{:.4f},{:.4f},{:.4f},{:.7f},0.0000000,{:.7f}\n", t * std::cos(t), t * std::sin(t),
                            -0.1 * t, std::sin(a), std::cos(a));
    }
    reading(state, text, "spiral.cls");
}

/// One long curve of BSPLINE with a second one.
void reading_bspline(benchmark::State& state) {
    constexpr int blocks = 100'000;
    std::string text = "TRAORI\nG54 G64 G90 G71 F3000\nORICURVE\nG0 X0 Y0 Z0 XH=0 YH=0 ZH=50\nBSPLINE SD=3\n";
    for (int i = 1; i <= blocks; ++i) {
        const double t = 1e-3 * i, x = t * std::cos(t), y = t * std::sin(t), z = -0.1 * t;
        text += fmt::format("X{:.4f} Y{:.4f} Z{:.4f} XH={:.4f} YH={:.4f} ZH={:.4f} PL={}\n", x, y, z, x + t / 10, y,
                            z + 50, i == 1 || i == blocks ? 0 : 1);
    }
    reading(state, text + "M30\n", "spline.mpf");
}

/// A Klartext program of plain blocks on a spiral, with rotary words or with tool vectors.
void reading_klartext(benchmark::State& state, bool vectors) {
    constexpr int blocks = 100'000;
    std::string text = "0 BEGIN PGM SPIRAL MM\n1 L X+0 Y+0 Z+0 A+0 C+0 R0 FMAX M128\n2 L F3000\n";
    for (int i = 0; i < blocks; ++i) {
        const double t = 1e-3 * i;
        const double a = 0.2 * std::sin(0.1 * t);
        text += fmt::format("{} {} X{:+.4f} Y{:+.4f} Z{:+.4f} ", i + 3, vectors ? "LN" : "L", t * std::cos(t),
                            t * std::sin(t), -0.1 * t);
        text += vectors ? fmt::format("TX{:+.6f} TY+0 TZ{:+.6f}\n", std::sin(a), std::cos(a))
                        : fmt::format("A{:+.4f} C{:+.4f}\n", 57.3 * a, 10 * t);
    }
    text += "END PGM SPIRAL MM\n";
    reading(state, text, "spiral.h");
}

/// An ISO program of plain blocks on a spiral, with rotary words under G43.4 or with tool vectors under G43.5.
void reading_fanuc(benchmark::State& state, bool vectors) {
    constexpr int blocks = 100'000;
    std::string text = "%\nO1234 (SPIRAL)\nG21 G17 G90 G94 G54\nG43 H1\nG0 X0. Y0. Z0. A0. C0.\n";
    text += vectors ? "G43.5 H1\nG1 F3000.\n" : "G43.4 H1\nG1 F3000.\n";
    for (int i = 0; i < blocks; ++i) {
        const double t = 1e-3 * i;
        const double a = 0.2 * std::sin(0.1 * t);
        text += fmt::format("N{} G1 X{:.4f} Y{:.4f} Z{:.4f} ", i + 1, t * std::cos(t), t * std::sin(t), -0.1 * t);
        text += vectors ? fmt::format("I{:.6f} J0. K{:.6f}\n", std::sin(a), std::cos(a))
                        : fmt::format("A{:.4f} C{:.4f}\n", 57.3 * a, 10 * t);
    }
    reading(state, text + "M30\n%\n", "spiral.nc");
}

/// The same text of G-code from a file, part by part.
void reading_parts(benchmark::State& state) {
    constexpr int blocks = 1'000'000;
    const machine::Machine machine = xyzac();
    const auto file = std::filesystem::temp_directory_path() / fmt::format("trunnion_bench_{}.ngc", ::getpid());
    {
        std::ofstream out(file);
        out << "G21 G90 G64\nG0 X0 Y0 Z0 A0 C0\nF3000\n";
        for (int i = 0; i < blocks; ++i) {
            const double t = 1e-3 * (i % 100'000);
            if (i % 10'000 == 0) out << "G0 Z5\n";
            out << fmt::format("G1 X{:.4f} Y{:.4f} Z{:.4f} A{:.4f} C{:.4f}\n", t * std::cos(t), t * std::sin(t),
                               -0.1 * t, 10 * std::sin(0.1 * t), 10 * t);
        }
    }
    nc::ReadOptions options;
    options.machine = &machine;
    std::size_t moves = 0;
    for (auto _ : state) {
        program::Program part;
        const auto parts = nc::open_program_file(file, options);
        while (*(*parts)->next(part)) moves += part.moves.size() - 1;
    }
    std::filesystem::remove(file);
    state.SetItemsProcessed(static_cast<std::int64_t>(moves));
}

BENCHMARK(reading_parts);
BENCHMARK_CAPTURE(reading_fanuc, rotary_words, false);
BENCHMARK_CAPTURE(reading_fanuc, vectors, true);
BENCHMARK_CAPTURE(reading_klartext, rotary_words, false);
BENCHMARK_CAPTURE(reading_klartext, vectors, true);
BENCHMARK_CAPTURE(reading_sinumerik, rotary_words, false);
BENCHMARK_CAPTURE(reading_sinumerik, vectors, true);
BENCHMARK(reading_bspline);
BENCHMARK(reading_apt);
BENCHMARK_CAPTURE(reading_file, sine_10k, "cases/sine-10k.ngc");
BENCHMARK_CAPTURE(reading_file, impeller, "nc/linuxcnc/impeller-7bl-xyzac.ngc");
BENCHMARK_CAPTURE(reading_file, finition_creo, "nc/apt/finition_creo.ncl");

}  // namespace
