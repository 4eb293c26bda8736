#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <memory>
#include <vector>

#include <benchmark/benchmark.h>
#include <sys/resource.h>

#include "trunnion/feed/plan_stretch.hpp"
#include "trunnion/interpolation/surface_fit.hpp"
#include "trunnion/interpolation/surface_interpolator.hpp"

namespace {

using namespace trunnion;
using namespace trunnion::interpolation;

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
    machine::RotaryPosition begin() const {
        const machine::AxisPosition at = axes.begin_position();
        return {at[3], at[4]};
    }
};

long involuntary_switches() {
    rusage usage{};
    getrusage(RUSAGE_THREAD, &usage);
    return usage.ru_nivcsw;
}

/// Times of single periods, by nanoseconds up to 100 µs.
class Distribution {
  public:
    void add(std::int64_t ns) {
        ++counts_[static_cast<std::size_t>(std::clamp<std::int64_t>(ns, 0, most))];
        ++all_;
        sum_ns_ += static_cast<double>(ns);
        longest_ns_ = std::max(longest_ns_, ns);
    }
    double mean_us() const { return sum_ns_ / static_cast<double>(all_) / 1000; }
    double longest_us() const { return static_cast<double>(longest_ns_) / 1000; }
    double below_us(double share) const {
        std::size_t sum = 0;
        for (std::size_t ns = 0; ns < counts_.size(); ++ns) {
            sum += counts_[ns];
            if (static_cast<double>(sum) >= share * static_cast<double>(all_)) return static_cast<double>(ns) / 1000;
        }
        return static_cast<double>(most) / 1000;
    }
    double share_above(double us) const {
        std::size_t sum = 0;
        for (auto ns = static_cast<std::size_t>(us * 1000) + 1; ns < counts_.size(); ++ns) sum += counts_[ns];
        return static_cast<double>(sum) / static_cast<double>(all_);
    }

  private:
    static constexpr std::int64_t most = 100'000;
    std::vector<std::size_t> counts_ = std::vector<std::size_t>(most + 1);
    std::size_t all_ = 0;
    double sum_ns_ = 0;
    std::int64_t longest_ns_ = 0;
};

/// Times `work` alone, once an iteration. Iterations during which the system took the processor away are counted by
/// themselves.
template <class Work>
void time_each(benchmark::State& state, const Work& work) {
    using clock = std::chrono::steady_clock;
    Distribution undisturbed;
    std::size_t disturbed = 0;
    long switches = involuntary_switches();
    for (auto _ : state) {
        const auto start = clock::now();
        work();
        const auto end = clock::now();
        state.SetIterationTime(std::chrono::duration<double>(end - start).count());
        const long after = involuntary_switches();
        if (after == switches)
            undisturbed.add(std::chrono::duration_cast<std::chrono::nanoseconds>(end - start).count());
        else
            ++disturbed;
        switches = after;
    }
    state.counters["mean_us"] = undisturbed.mean_us();
    state.counters["p99.99_us"] = undisturbed.below_us(0.9999);
    state.counters["above_10us"] = undisturbed.share_above(10);
    state.counters["longest_us"] = undisturbed.longest_us();
    state.counters["switched"] = static_cast<double>(disturbed);
}

/// 10⁷ periods of 1 ms one by one, along the pass again and again.
void periods(benchmark::State& state) {
    const auto order = static_cast<StepOrder>(state.range(0));
    const Pass pass(state.range(1) ? SurfaceTool{6, 2, 0.1, 0.05} : SurfaceTool{6, 0, 0, 0});
    SurfaceInterpolator interpolator(pass.curve, pass.path, pass.profile, pass.begin(), order);
    std::size_t period = 0;
    time_each(state, [&] {
        const SurfaceInstant now = interpolator.at(1e-3 * static_cast<double>(period++));
        benchmark::DoNotOptimize(now);
        if (now.status != SurfaceStatus::finished) return;
        period = 0;
        interpolator = SurfaceInterpolator(pass.curve, pass.path, pass.profile, pass.begin(), order);
    });
}
BENCHMARK(periods)
    ->ArgNames({"order", "leaning"})
    ->Args({0, 0})
    ->Args({1, 0})
    ->Args({2, 0})
    ->Args({2, 1})
    ->Iterations(10'000'000)
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
BENCHMARK(machine_itself)->Iterations(10'000'000)->UseManualTime()->Unit(benchmark::kMicrosecond);

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
