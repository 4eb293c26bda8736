#include <cmath>

#include <benchmark/benchmark.h>

#include "trunnion/surfacing/gouge.hpp"

namespace {

using namespace trunnion;
using namespace trunnion::surfacing;

/// A bicubic of 100 × 100 mm with hills and hollows.
const Face& free_form() {
    static const Face face = [] {
        const geometry::SurfaceDirection cubic{3, {0, 0, 0, 0, 1, 1, 1, 1}};
        std::vector<Eigen::Vector3d> points;
        for (int i = 0; i < 4; ++i)
            for (int j = 0; j < 4; ++j) {
                const double x = i / 3.0, y = j / 3.0;
                points.emplace_back(100 * x, 100 * y, 20 * std::sin(3 * x) * std::cos(2.5 * y) + 7.5 * x * y);
            }
        return whole_face(geometry::BsplineSurface::make(cubic, cubic, points).value());
    }();
    return face;
}

const Cutter& torus() {
    static const Cutter cutter =
        Cutter::make({.kind = machine::ToolKind::torus, .diameter_mm = 12, .corner_radius_mm = 3}, 40).value();
    return cutter;
}

OrientationLimits limits() {
    return {.least_lead_rad = 0.02, .most_lead_rad = 0.7, .most_tilt_rad = 0.7};
}

GuidingSurface guiding() {
    return GuidingSurface::make(free_form(), torus(), {}).value();
}

void guide(benchmark::State& state) {
    for (auto _ : state) benchmark::DoNotOptimize(GuidingSurface::make(free_form(), torus(), {}));
    state.counters["patches"] = static_cast<double>(guiding().patches());
}
BENCHMARK(guide)->Unit(benchmark::kMillisecond);

void orient(benchmark::State& state) {
    const GuidingSurface below = guiding();
    for (auto _ : state) benchmark::DoNotOptimize(OrientationSurface::make(free_form(), below, Lean{0.1, 0}, limits()));
}
BENCHMARK(orient)->Unit(benchmark::kMillisecond);

void part_body(benchmark::State& state) {
    const double tolerance = 0.001 * static_cast<double>(state.range(0));
    const std::vector<Face> faces{free_form()};
    std::size_t triangles = 0;
    for (auto _ : state) triangles = PartBody::make(faces, tolerance)->triangles();
    state.counters["triangles"] = static_cast<double>(triangles);
}
BENCHMARK(part_body)->ArgName("tolerance_um")->Arg(1)->Arg(5)->Unit(benchmark::kMillisecond);

/// Rows over the whole face, 10 000 poses a pass of the check and more.
std::vector<Pass> rows(const GuidedTool& tool) {
    std::vector<Pass> out;
    constexpr int count = 500;
    for (int k = 0; k < count; ++k) {
        const double v = (k + 0.5) / count;
        out.push_back(pass_on(tool, std::vector<geometry::SurfacePlace>{{0.01, v}, {0.99, v}}, k).value());
    }
    return out;
}

void check_gouges(benchmark::State& state) {
    const OrientationSurface orientation =
        OrientationSurface::make(free_form(), guiding(), Lean{0.2, 0}, limits()).value();
    const std::vector<Face> faces{free_form()};
    const PartBody part = PartBody::make(faces, 0.002).value();
    const auto passes = rows({free_form(), torus(), orientation});
    GougeReport report;
    for (auto _ : state) report = find_gouges(free_form(), 0, torus(), part, passes).value();
    state.counters["poses"] = static_cast<double>(report.poses);
    state.counters["gouges"] = static_cast<double>(report.gouges.size());
}
BENCHMARK(check_gouges)->Unit(benchmark::kMillisecond);

void free_gouges(benchmark::State& state) {
    const OrientationSurface orientation =
        OrientationSurface::make(free_form(), guiding(), Lean{0.02, 0}, limits()).value();
    const std::vector<Face> faces{free_form()};
    const PartBody part = PartBody::make(faces, 0.002).value();
    const GuidedTool tool{free_form(), torus(), orientation};
    std::vector<Pass> passes = rows(tool);
    double deepest = 0, step = 0, turn = 0, rounds = 0, free = 1;
    for (auto _ : state) {
        const auto removed = remove_gouges(tool, 0, part, passes);
        free = removed ? 1 : 0;
        if (!removed) continue;
        deepest = removed->before.deepest_mm;
        step = removed->largest_step_rad;
        turn = removed->largest_turn_rad;
        rounds = removed->rounds;
    }
    state.counters["free"] = free;
    state.counters["before_mm"] = deepest;
    state.counters["step_rad"] = step;
    state.counters["turn_rad"] = turn;
    state.counters["rounds"] = rounds;
}
BENCHMARK(free_gouges)->Unit(benchmark::kMillisecond)->Iterations(1);

}  // namespace
