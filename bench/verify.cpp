#include <cmath>

#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include "trunnion/base/quantity.hpp"
#include "trunnion/verify/check.hpp"
#include "trunnion/verify/programmed_csv.hpp"

/// The checker on a long finishing program: 35 000 blocks of 0.2 mm with turning tool, 350 000 rows.
namespace {

using namespace trunnion;

machine::Machine trunnion_machine() {
    machine::Machine out;
    out.axis_count = 5;
    out.rotary_count = 2;
    const char letters[] = "XYZAC";
    for (int i = 0; i < 5; ++i) {
        out.axes[i].letter = letters[i];
        out.axes[i].rotary = i > 2;
        out.axes[i].direction = Eigen::Vector3d::Unit(i < 3 ? i : (i == 3 ? 0 : 2));
        out.axes[i].feed = out.axes[i].rapid = {1e9, 1e9, 1e12};
    }
    out.chain = {4, 3, 0, 1, 2};
    return out;
}

/// A helix of blocks of 0.2 mm; the tip straight and the rotary words linear inside of a block.
struct Sample {
    Eigen::Vector3d tip;
    double a, c;
};

Sample vertex(double n) {
    return {{50 * std::cos(0.004 * n), 50 * std::sin(0.004 * n), 0.001 * n},
            0.3 + 0.1 * std::sin(0.01 * n),
            0.2 * std::sin(0.007 * n)};
}

machine::AxisPosition axes_at(double n) {
    const double from = std::floor(n), w = n - from;
    const Sample u = vertex(from), v = vertex(from + 1);
    const double a = u.a + w * (v.a - u.a), c = u.c + w * (v.c - u.c);
    const Eigen::Vector3d tip = u.tip + w * (v.tip - u.tip);
    const double x = std::cos(c) * tip.x() + std::sin(c) * tip.y(), y = -std::sin(c) * tip.x() + std::cos(c) * tip.y();
    return {{x, std::cos(a) * y + std::sin(a) * tip.z(), -std::sin(a) * y + std::cos(a) * tip.z(), a, c}};
}

std::vector<verify::ProgrammedPose> programmed(int blocks) {
    program::Program program;
    program.rotary_letters = {'A', 'C'};
    for (int n = 0; n <= blocks; ++n) {
        program::Move move;
        const Sample at = vertex(n);
        move.position_mm = at.tip;
        move.rotary_rad = {at.a, at.c, 0};
        move.law = program::OrientationLaw::rotary;
        move.line = n + 1;
        program.moves.push_back(move);
    }
    return *verify::programmed_poses(program, trunnion_machine(), {});
}

verify::SetpointTable motion_of(int blocks, int rows_a_block) {
    std::vector<motion::Setpoint> rows;
    for (int n = 0; n <= blocks * rows_a_block; ++n) {
        motion::Setpoint row;
        row.time_s = n * 0.001;
        row.position = axes_at(std::min<double>(blocks - 1e-9, static_cast<double>(n) / rows_a_block));
        rows.push_back(row);
    }
    return *verify::setpoint_table(std::move(rows));
}

void check_long_motion(benchmark::State& state) {
    const int blocks = static_cast<int>(state.range(0)), rows = static_cast<int>(state.range(1));
    const auto poses = programmed(blocks);
    const auto motion = motion_of(blocks, rows);
    for (auto _ : state) {
        const auto verdict = verify::check(motion, poses, trunnion_machine(), {}, {});
        if (!verdict || verdict->path_covered != 1 || verdict->tip_deviation_mm > 1e-6)
            state.SkipWithError("wrong verdict");
    }
    state.counters["rows/s"] =
        benchmark::Counter(static_cast<double>(motion.rows.size()), benchmark::Counter::kIsIterationInvariantRate);
}
BENCHMARK(check_long_motion)->Args({35000, 10})->Args({35000, 1})->Unit(benchmark::kMillisecond);

void read_setpoints(benchmark::State& state) {
    const auto motion = motion_of(1000, 10);
    std::string text = "t_s,X_mm,Y_mm,Z_mm,A_deg,C_deg,line,s_mm,feed_mm_min\n";
    for (const auto& r : motion.rows)
        text += fmt::format("{},{},{},{},{},{},1,0.1,600\n", r.time_s, r.position[0], r.position[1], r.position[2],
                            r.position[3] / degree, r.position[4] / degree);
    for (auto _ : state) benchmark::DoNotOptimize(verify::read_setpoint_csv(text, trunnion_machine()));
    state.counters["rows/s"] =
        benchmark::Counter(static_cast<double>(motion.rows.size()), benchmark::Counter::kIsIterationInvariantRate);
}
BENCHMARK(read_setpoints)->Unit(benchmark::kMillisecond);

void expand_program(benchmark::State& state) {
    for (auto _ : state) benchmark::DoNotOptimize(programmed(35000));
    state.counters["poses/s"] = benchmark::Counter(35001, benchmark::Counter::kIsIterationInvariantRate);
}
BENCHMARK(expand_program)->Unit(benchmark::kMillisecond);

}  // namespace
