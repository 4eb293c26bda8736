#include <cmath>

#include <benchmark/benchmark.h>

#include "trunnion/surfacing/machined_surface.hpp"

namespace {

using namespace trunnion;
using namespace trunnion::surfacing;

/// A bicubic of 100 × 100 mm with hills and hollows.
Face free_form() {
    const geometry::SurfaceDirection cubic{3, {0, 0, 0, 0, 1, 1, 1, 1}};
    std::vector<Eigen::Vector3d> points;
    for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j) {
            const double x = i / 3.0, y = j / 3.0;
            points.emplace_back(100 * x, 100 * y, 20 * std::sin(3 * x) * std::cos(2.5 * y) + 7.5 * x * y);
        }
    return whole_face(geometry::BsplineSurface::make(cubic, cubic, points).value());
}

Cutter ball(double diameter_mm) {
    return Cutter::make({.kind = machine::ToolKind::ball, .diameter_mm = diameter_mm}).value();
}

void evaluate(benchmark::State& state) {
    const Face face = free_form();
    double u = 0;
    for (auto _ : state) {
        benchmark::DoNotOptimize(shape_at(face.surface, {u, 0.4}, face.side));
        u = u > 0.99 ? 0 : u + 1e-3;
    }
}
BENCHMARK(evaluate);

void plan(benchmark::State& state) {
    const Face face = free_form();
    const Cutter cutter = ball(static_cast<double>(state.range(0)));
    for (auto _ : state) benchmark::DoNotOptimize(plan_surface(face, cutter, {}));
}
BENCHMARK(plan)->ArgName("ball_mm")->Arg(10)->Arg(20)->Unit(benchmark::kMillisecond);

void check(benchmark::State& state) {
    const Face face = free_form();
    const Cutter cutter = ball(static_cast<double>(state.range(0)));
    const auto planned = plan_surface(face, cutter, {}).value();
    for (auto _ : state) benchmark::DoNotOptimize(check_surface(face, cutter, planned.passes, {.ridge_spacing_mm = 5}));
}
BENCHMARK(check)->ArgName("ball_mm")->Arg(10)->Arg(20)->Unit(benchmark::kMillisecond);

}  // namespace
