#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <thread>
#include <vector>

#include <benchmark/benchmark.h>

#include "trunnion/feed/plan_stretch.hpp"
#include "trunnion/interpolation/surface_fit.hpp"
#include "trunnion/interpolation/surface_interpolator.hpp"
#include "trunnion/pipeline/surface_motion.hpp"

#include "period_times.hpp"

namespace {

using namespace trunnion;
using namespace trunnion::interpolation;
using bench::time_each;

machine::Machine trunnion_table() {
    machine::Machine out;
    out.axis_count = 5;
    out.rotary_count = 2;
    out.chain = {4, 3, 0, 1, 2};
    for (int i = 0; i < 5; ++i) {
        machine::Axis& axis = out.axes[i];
        axis.letter = "XYZAC"[i];
        axis.rotary = i > 2;
        axis.direction = Eigen::Vector3d::Unit(i == 3 ? 0 : i == 4 ? 2 : i);
        axis.feed = i > 2 ? machine::AxisLimits{2, 5, 31} : machine::AxisLimits{500, 2500, 5000};
        axis.rapid = axis.feed;
    }
    return out;
}

/// A bicubic of 100 × 100 mm; steep enough that the axis stays away from the pole.
geometry::BsplineSurface slope() {
    const geometry::SurfaceDirection cubic{3, {0, 0, 0, 0, 1, 1, 1, 1}};
    std::vector<Eigen::Vector3d> points;
    for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j) {
            const double x = i / 3.0, y = j / 3.0;
            points.emplace_back(100 * x, 100 * y, 20 * std::sin(3 * x) * std::cos(2.5 * y) + 40 * y + 7.5 * x * y);
        }
    return geometry::BsplineSurface::make(cubic, cubic, points).value();
}

/// Second points some 50 mm over it, patches of 10 mm, that lean more and less as passes freed of gouges do.
const geometry::BsplineSurface& orientation() {
    static const geometry::BsplineSurface made = [] {
        geometry::SurfaceDirection along{3, {0, 0, 0, 0}};
        constexpr int spans = 10, points_along = spans + 3;
        for (int k = 1; k < spans; ++k) along.knots.push_back(static_cast<double>(k) / spans);
        along.knots.insert(along.knots.end(), 4, 1.0);
        const geometry::BsplineSurface surface = slope();
        std::vector<Eigen::Vector3d> points;
        for (int i = 0; i < points_along; ++i)
            for (int j = 0; j < points_along; ++j) {
                const double x = i / (points_along - 1.0), y = j / (points_along - 1.0);
                const auto at = geometry::shape_at(surface, {x, y}, geometry::Side::along).value();
                points.emplace_back(at.point + 50 * at.normal + Eigen::Vector3d(7 + 2 * std::sin(6 * x + y), 2, 0));
            }
        return geometry::BsplineSurface::make(along, along, points).value();
    }();
    return made;
}

/// Upright flat end, leaning torus, torus on an orientation surface.
SurfaceTool tool_of(std::int64_t leaning) {
    if (leaning == 0) return {6, 0, 0, 0};
    if (leaning == 1) return {6, 2, 0.1, 0.05};
    return {.radius_mm = 6, .corner_mm = 2, .orientation = &orientation()};
}

/// A pass over it, planned for a table.
struct Pass {
    machine::Machine machine = trunnion_table();
    machine::Kinematics kinematics = machine::Kinematics::make(machine, {}, 100).value();
    geometry::BsplineSurface surface = slope();
    SurfaceCurve curve;
    SurfacePath path;
    path::AxisPath axes;
    SurfaceProfile profile;

    explicit Pass(const SurfaceTool& tool)
        : curve(SurfaceCurve::make(surface, geometry::Side::along, places(), tool).value()),
          path(surface_path(curve, kinematics, {.feed_mm_s = 50}).value()),
          axes(path::AxisPath::make(path.tool_path, machine, {}).value()),
          profile(feed::plan_stretch(axes, {}).value().profile) {}

    geometry::BsplineCurve places() const {
        std::vector<geometry::SurfacePlace> out;
        for (int k = 0; k <= 100; ++k) out.push_back({0.02 + 0.0096 * k, 0.4 + 0.1 * std::sin(0.03 * k)});
        return fit_places(surface, out, 1e-3).value();
    }
};

/// 1.4 · 10⁷ periods of 1 ms one by one, of which 10⁷ are off the tick, along the pass again and again.
void periods(benchmark::State& state) {
    const auto order = static_cast<StepOrder>(state.range(0));
    const Pass pass(tool_of(state.range(1)));
    SurfaceInterpolator interpolator(pass.curve, pass.path, pass.axes, pass.profile, order);
    state.counters["bridged"] = pass.path.bridged_mm / pass.path.tool_path.length_mm();
    std::size_t period = 0;
    time_each(state, [&] {
        const SurfaceInstant now = interpolator.at(1e-3 * static_cast<double>(period++));
        benchmark::DoNotOptimize(now);
        if (now.status != SurfaceStatus::finished) return;
        period = 0;
        interpolator = SurfaceInterpolator(pass.curve, pass.path, pass.axes, pass.profile, order);
    });
}
BENCHMARK(periods)
    ->ArgNames({"order", "leaning"})
    ->Args({0, 0})
    ->Args({1, 0})
    ->Args({2, 0})
    ->Args({2, 1})
    ->Args({2, 2})
    ->Iterations(14'000'000)
    ->UseManualTime()
    ->Unit(benchmark::kMicrosecond);

/// What the machine itself adds: arithmetic of always the same length in place of a period.
void machine_itself(benchmark::State& state) {
    time_each(state, [] {
        double x = 1.5;
        for (int k = 0; k < 150; ++k) x = std::sqrt(x + 0.5);
        benchmark::DoNotOptimize(x);
    });
}
BENCHMARK(machine_itself)->Iterations(14'000'000)->UseManualTime()->Unit(benchmark::kMicrosecond);

/// Takes every setpoint when it is due.
struct Control : pipeline::PlanObserver {
    std::chrono::steady_clock::time_point begin;
    double latest_s = 0;
    bool running = false;

    void setpoint(const motion::Setpoint& row) override {
        using namespace std::chrono;
        if (!running) begin = steady_clock::now();
        running = true;
        const auto due = begin + duration_cast<steady_clock::duration>(duration<double>(row.time_s));
        latest_s = std::max(latest_s, duration<double>(steady_clock::now() - due).count());
        std::this_thread::sleep_until(due);
    }
};

/// Lin & Koren's system while a clock takes the setpoints: how long before its time every stretch was planned, and how
/// late any setpoint was asked for. The whole surface of 100 × 100 mm; takes as long as the motion.
void ahead_of_a_clock(benchmark::State& state) {
    machine::Setup setup;
    setup.tool = {.kind = machine::ToolKind::ball, .diameter_mm = 10, .corner_radius_mm = 5, .length_mm = 100};
    const auto cutter = surfacing::Cutter::make(setup.tool).value();
    const surfacing::SurfaceOptions surface{
        .strategy = surfacing::Strategy::lin_koren, .scallop_mm = 0.5, .gouge_tolerance_mm = 0.01};
    for (auto _ : state) {
        Control control;
        const auto moved = pipeline::move_surface_ahead(surfacing::whole_face(slope()), cutter, surface,
                                                        trunnion_table(), setup, {}, control);
        if (!moved) return state.SkipWithError(to_string(moved.error()).c_str());
        state.counters["first_ready_s"] = moved->first_ready_s;
        state.counters["least_ahead_s"] = moved->least_ahead_s;
        state.counters["latest_setpoint_s"] = control.latest_s;
        state.counters["passes"] = static_cast<double>(moved->passes);
    }
}
BENCHMARK(ahead_of_a_clock)->Iterations(1)->UseRealTime()->Unit(benchmark::kSecond);

void contact(benchmark::State& state) {
    const Pass pass({6, 2, 0.1, 0.05});
    double w = 0;
    for (auto _ : state) {
        benchmark::DoNotOptimize(pass.curve.contact(w));
        w = w > 90 ? 0 : w + 0.05;
    }
}
BENCHMARK(contact);

/// Place, path and feed of a pass of 100 mm, as it is done ahead of the motion.
void fit(benchmark::State& state) {
    const Pass pass({6, 2, 0.1, 0.05});
    for (auto _ : state) benchmark::DoNotOptimize(pass.places());
}
BENCHMARK(fit)->Unit(benchmark::kMicrosecond);

void lay_path(benchmark::State& state) {
    const Pass pass({6, 2, 0.1, 0.05});
    for (auto _ : state) benchmark::DoNotOptimize(surface_path(pass.curve, pass.kinematics, {.feed_mm_s = 50}));
}
BENCHMARK(lay_path)->Unit(benchmark::kMicrosecond);

void plan_feed(benchmark::State& state) {
    const Pass pass({6, 2, 0.1, 0.05});
    for (auto _ : state) benchmark::DoNotOptimize(feed::plan_stretch(pass.axes, {}));
}
BENCHMARK(plan_feed)->Unit(benchmark::kMicrosecond);

}  // namespace
