// The inner loops are compiled for several processors: all of them compute the same bits.
#include <vector>

#include <gtest/gtest.h>

#include "trunnion/feed/plan_stretch.hpp"

#include "detail/check.hpp"
#include "detail/interior_point.hpp"
#include "detail/rest_arc.hpp"
#include "detail/sampler.hpp"
#include "detail/start_profile.hpp"
#include "synthetic_paths.hpp"

namespace trunnion::feed {
namespace {

#ifdef TRUNNION_WITH_AVX2

std::vector<Interval> intervals_of(const path::AxisPath& path) {
    std::vector<Interval> out;
    auto stream = IntervalStream::make(path, {});
    Interval interval;
    while (*stream->next(interval)) out.push_back(interval);
    return out;
}

TEST(Variants, OfTheSolverComputeTheSameBits) {
    if (!__builtin_cpu_supports("avx2")) GTEST_SKIP() << "a processor without AVX2";
    for (const std::uint64_t seed : {1, 2, 3, 4, 5}) {
        SCOPED_TRACE(seed);
        const test::Stretch path = test::random_corners(seed, 6);
        const LimitSet limits = limits_of(*path.axis_path, {});
        const std::vector<Interval> intervals = intervals_of(*path.axis_path);
        std::vector<Tightening> tightening(intervals.size());
        for (std::size_t k = 0; k < intervals.size(); ++k) {
            tightening[k].needed.emplace();
            for (int i = 0; i < samples_per_interval; ++i)
                (*tightening[k].needed)[i] = needed_rows(intervals[k].samples[i], limits);
        }
        WindowProblem window{.intervals = intervals, .tightening = tightening, .limits = &limits};
        CoreProblem core{.intervals = window.intervals.subspan(1, window.core_count()),
                         .tightening = window.tightening.subspan(1, window.core_count()),
                         .limits = &limits,
                         .calm = 0.001,
                         .from_rest = true,
                         .start = arc_joint(intervals.front(), RestSide::start, limits),
                         .stop = arc_joint(intervals.back(), RestSide::stop, limits)};
        Trajectory start;
        make_start_profile(window, core, start);
        const auto solve = [&](InteriorPoint& solver) {
            solver.begin(core, start);
            EXPECT_TRUE(solver.run(1e-4, 60).converged);
            return solver.trajectory();
        };
        const Trajectory narrow = solve(*baseline::make_interior_point()), wide = solve(*avx2::make_interior_point());
        EXPECT_EQ(narrow.x, wide.x);
        EXPECT_EQ(narrow.d, wide.d);
        EXPECT_EQ(narrow.e0, wide.e0);
        EXPECT_EQ(narrow.e1, wide.e1);

        const Speed speed{{4, 5, 6, 5.5}, {3, 1, -2}, {-4, -6}};
        const Bernstein<double, 6> to_room{2, 2.1, 2.2, 2.3, 2.35, 2.4, 2.3};
        GroupLoads inverse;
        for (int i = 0; i < group_size; ++i) inverse.velocity[i] = inverse.acceleration[i] = inverse.jerk[i] = 0.1 + i;
        for (const Interval& interval : intervals) {
            const Half half{interval.samples[0], interval.samples[1], interval.length_mm / 2, speed, to_room};
            for (int group = 0; group < coordinate_groups; ++group) {
                GroupPolynomials a, b;
                GroupLoads bound_a, bound_b;
                baseline::bound_loads(half, group, inverse, a, bound_a);
                avx2::bound_loads(half, group, inverse, b, bound_b);
                ASSERT_EQ(a.jerk, b.jerk);
                ASSERT_EQ(a.acceleration, b.acceleration);
                ASSERT_EQ(bound_a.jerk, bound_b.jerk);
                ASSERT_EQ(bound_a.velocity, bound_b.velocity);
                ASSERT_EQ(bound_a.acceleration, bound_b.acceleration);
            }
        }
    }
}

#endif

}  // namespace
}  // namespace trunnion::feed
