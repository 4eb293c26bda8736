#include "measured.hpp"

#include <limits>
#include <utility>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "reference_optimum.hpp"

namespace trunnion::test {
namespace {

constexpr std::size_t one_window = std::numeric_limits<std::size_t>::max() / 4;
const std::size_t streaming = feed::FeedOptions{}.window;

/// Plans, and adds what it took.
double planned_s(const path::AxisPath& path, const feed::FeedOptions& options, Measured& out) {
    const auto plan = feed::plan_stretch(path, options);
    if (!plan) {
        ADD_FAILURE() << out.name << ": " << to_string(plan.error());
        return std::numeric_limits<double>::infinity();
    }
    out.intervals = plan->intervals;
    out.fallbacks += plan->fallbacks;
    out.windows += plan->windows;
    out.jerk_free_s = plan->jerk_free_bound_s;
    return plan->profile.duration_s();
}

}  // namespace

Measured measure(std::string name, const path::AxisPath& path, int reference_nodes) {
    Measured out;
    out.name = std::move(name);
    const auto optimum = reference::reference_optimum(path, {.nodes = reference_nodes});
    EXPECT_TRUE(optimum.converged) << out.name;
    EXPECT_LE(optimum.worst_use, 1.0001) << out.name << ": the reference breaks a limit";
    out.reference_s = optimum.time_s;
    out.reference_coarse_s = optimum.coarse_time_s;
    feed::FeedOptions hurried{.calm = 0, .window = one_window};
    for (auto& factors : hurried.factors) factors.jerk = 1000;
    out.hurried_s = planned_s(path, hurried, out);
    out.hurried_fallbacks = std::exchange(out.fallbacks, 0);
    out.windows = 0;
    out.stream_s = planned_s(path, {.calm = 0, .window = streaming}, out);
    out.stream_calm_s = planned_s(path, {.calm = 0.001, .window = streaming}, out);
    out.whole_calm_s = planned_s(path, {.calm = 0.001, .window = one_window}, out);
    out.whole_s = planned_s(path, {.calm = 0, .window = one_window}, out);
    return out;
}

void print_heading() {
    fmt::print("{:<18} {:>9} {:>10} {:>10} {:>9} | {:>9} {:>9} {:>9} | {:>9} {:>9} {:>9}\n", "path", "intervals",
               "optimum s", "planned s", "ratio", "stream", "calm .001", "its strm", "jerk*1000", "   fallbacks",
               "ref. fine");
}

void print(const Measured& m) {
    fmt::print(
        "{:<18} {:>9} {:>10.5f} {:>10.5f} {:>9.5f} | {:>9.5f} {:>9.5f} {:>9.5f} | {:>9.5f} {:>2} {:>4}/{:<4} "
        "{:>9.5f}\n",
        m.name, m.intervals, m.reference_s, m.whole_s, m.of_reference(), m.of_whole(), m.of_calm(), m.of_calm_whole(),
        m.of_jerk_free(), m.hurried_fallbacks, m.fallbacks, m.windows, m.reference_s / m.reference_coarse_s);
}

void expect_at_the_optimum(const Measured& m) {
    EXPECT_NEAR(m.reference_s / m.reference_coarse_s, 1, 5e-4) << m.name << ": the reference has not converged";
    EXPECT_LE(m.of_reference(), 1.002) << m.name;
    EXPECT_GE(m.of_reference(), 0.9990) << m.name << ": faster than the optimum";
    EXPECT_LE(m.of_whole(), 1.003) << m.name;
    EXPECT_LE(m.of_calm_whole(), 1.003) << m.name;
    EXPECT_LE(m.of_calm(), 1.0002) << m.name;
    EXPECT_LE(m.of_jerk_free(), 1.001) << m.name;
    EXPECT_GE(m.of_jerk_free(), 0.9995) << m.name;
    EXPECT_EQ(m.fallbacks, 0) << m.name;
    EXPECT_EQ(m.hurried_fallbacks, 0) << m.name << " with much jerk";
}

}  // namespace trunnion::test
