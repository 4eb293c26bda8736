#include <cmath>

#include <benchmark/benchmark.h>

#include "trunnion/base/quantity.hpp"
#include "trunnion/deformation/flank_milling.hpp"

namespace {

using namespace trunnion;
using namespace trunnion::deformation;

/// A blade of 100 mm that leans from −15° to 15° along its way, with a belly where it is not ruled.
SplineSurface blade(double belly_mm) {
    std::vector<std::vector<Eigen::Vector3d>> rows(belly_mm == 0 ? 2 : 3);
    for (int i = 0; i <= 20; ++i) {
        const double w = i / 20.0, lean = 30 * degree * (w - 0.5);
        const Eigen::Vector3d bottom(100 * w, 12 * w * (1 - w), 0), up(0.05, std::sin(lean), std::cos(lean));
        for (std::size_t r = 0; r < rows.size(); ++r) {
            const double v = static_cast<double>(r) / static_cast<double>(rows.size() - 1);
            rows[r].push_back(bottom + 30 * v * up + 4 * v * (1 - v) * belly_mm * Eigen::Vector3d::UnitY());
        }
    }
    return guided_surface(rows, Side::against).value();
}

/// Flank milling by a cylinder of 10 mm, 200 control points of both curves together; argument: belly, µm.
void deform(benchmark::State& state) {
    const auto surface = blade(1e-3 * static_cast<double>(state.range(0)));
    const FlankTool tool{.radius_mm = 5};
    const auto start = fit_dual_path(two_point_poses(surface, tool, 100, 2).value()).value().path;
    const FlankDeformation options{.range = {.from_height_mm = 2, .to_height_mm = 32}};
    for (auto _ : state) benchmark::DoNotOptimize(deform_flank(start, tool, surface, options));
    state.counters["control_points"] = static_cast<double>(2 * start.spline.bottom().control_points_mm().size());
}
BENCHMARK(deform)->ArgName("belly_um")->Arg(0)->Arg(300)->Unit(benchmark::kMillisecond);

}  // namespace
