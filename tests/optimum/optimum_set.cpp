// The planner against the optimum on one set of paths: with one window and as a stream, calm or not, and with so much
// jerk that only velocity and acceleration limit. What takes long is named Nightly.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "trunnion/files/machine_file.hpp"

#include "../unit/feed/flank_path.hpp"
#include "../unit/feed/synthetic_paths.hpp"
#include "measured.hpp"
#include "smoothed_path.hpp"

namespace trunnion::test {
namespace {

void measure_and_expect(std::string name, const path::AxisPath& path, int nodes) {
    const Measured measured = measure(std::move(name), path, nodes);
    print_heading();
    print(measured);
    expect_at_the_optimum(measured);
}

/// On a current trunnion table, as a program of cutter locations.
void smooth_and_measure(std::string name, const std::string& text, const smoothing::SmoothingOptions& options,
                        int nodes) {
    machine::Setup setup;
    setup.workpiece.origin_mm = {0, 0, 50};
    const SmoothedPath path(five_axis_machine(trunnion_limits()), setup, text, options);
    measure_and_expect(std::move(name), path.axis_path(), nodes);
}

TEST(Optimum, of_the_flank_path) {
    const auto flank = flank_path();
    if (!flank) GTEST_SKIP() << "no shared data";
    measure_and_expect("flank", *flank->axis_path, 6400);
}

TEST(Optimum, of_the_flank_path_on_a_shipped_machine) {
    const auto flank = flank_path();
    if (!flank) GTEST_SKIP() << "no shared data";
    const auto shipped = files::read_machine_file(TRUNNION_SOURCE_DIR "/data/machines/ucp710.toml");
    ASSERT_TRUE(shipped) << to_string(shipped.error());
    for (int a = 0; a < 5; ++a) flank->machine.axes[a].feed = shipped->axes[a].feed;
    flank->close();
    measure_and_expect("flank, ucp710", *flank->axis_path, 6400);
}

class PyramidOptimum : public testing::TestWithParam<int> {};

TEST_P(PyramidOptimum, at_a_tolerance) {
    smoothing::SmoothingOptions options;
    options.tip_tolerance_mm = options.flank_tolerance_mm = 1e-3 * GetParam();
    smooth_and_measure(fmt::format("pyramid {} um", GetParam()), pyramid(), options, 3200);
}

class SpiralOptimum : public testing::TestWithParam<int> {};

TEST_P(SpiralOptimum, of_a_length) {
    const int length_mm = GetParam();
    const double step_mm = length_mm > 2000 ? 0.2 : 0.1;
    smoothing::SmoothingOptions options;
    options.tip_tolerance_mm = 0.01;
    smooth_and_measure(fmt::format("spiral {} mm", length_mm), spiral(length_mm, step_mm), options,
                       std::clamp(10 * length_mm, 4000, 25000));
}

const auto name_by_number = [](const auto& which) { return std::to_string(which.param); };
INSTANTIATE_TEST_SUITE_P(Um, PyramidOptimum, testing::Values(20), name_by_number);
INSTANTIATE_TEST_SUITE_P(NightlyUm, PyramidOptimum, testing::Values(10, 50, 100), name_by_number);
INSTANTIATE_TEST_SUITE_P(Mm, SpiralOptimum, testing::Values(200), name_by_number);
INSTANTIATE_TEST_SUITE_P(NightlyMm, SpiralOptimum, testing::Values(2000, 20000), name_by_number);

std::uint64_t environment(const char* name, std::uint64_t otherwise) {
    const char* text = std::getenv(name);
    return text ? std::strtoull(text, nullptr, 10) : otherwise;
}

/// Corner-rich paths of 4 to 12 moves. TRUNNION_SEED replays one, TRUNNION_PATHS sets how many.
void measure_random_corners(std::uint64_t count) {
    const std::uint64_t first = environment("TRUNNION_SEED", 1);
    count = environment("TRUNNION_PATHS", count);
    std::vector<Measured> all;
    for (std::uint64_t seed = first; seed < first + count; ++seed) {
        const int moves = 4 + static_cast<int>(seed % 9);
        const Stretch path = random_corners(seed, moves);
        all.push_back(measure(fmt::format("random {}", seed), *path.axis_path, 400 * moves));
        expect_at_the_optimum(all.back());
    }
    std::sort(all.begin(), all.end(),
              [](const Measured& a, const Measured& b) { return a.of_reference() < b.of_reference(); });
    fmt::print("seeds {} to {}; by the ratio, the least, the median and the worst five:\n", first, first + count - 1);
    print_heading();
    print(all.front());
    print(all[all.size() / 2]);
    for (std::size_t k = all.size() - std::min<std::size_t>(5, all.size()); k < all.size(); ++k) print(all[k]);
}

TEST(Optimum, of_random_corners) {
    measure_random_corners(8);
}

TEST(NightlyOptimum, of_random_corners) {
    measure_random_corners(500);
}

/// √∫ jerk² dt over time / limit, of a path along one axis.
double rms_jerk(const motion::FeedProfile& profile, double limit) {
    constexpr int steps = 200;
    double sum = 0;
    for (const motion::ProfilePiece& piece : profile.pieces)
        for (int k = 0; k < steps; ++k) {
            const double delta = motion::distance_at(piece, piece.duration_s * (k + 0.5) / steps);
            const double jerk = motion::state_at(piece, delta).jerk_mm_s3 / limit;
            sum += jerk * jerk * piece.duration_s / steps;
        }
    return std::sqrt(sum / profile.duration_s());
}

/// At one percent more time no motion over this line has less than 0.76 of the fastest one's (docs/theory).
TEST(Calm, costs_a_line_less_than_one_percent_for_nearly_all_of_the_jerk_that_it_can_save) {
    const machine::AxisLimits limits{100, 1000, 20000};
    const Stretch line = straight({100, 0, 0, 0, 0}, 100, {{limits, limits, limits, limits, limits}});
    const auto fastest = feed::plan_stretch(*line.axis_path, {.calm = 0}),
               calm = feed::plan_stretch(*line.axis_path, {.calm = 0.3});
    ASSERT_TRUE(fastest && calm);
    const double time = calm->profile.duration_s() / fastest->profile.duration_s(),
                 jerk = rms_jerk(calm->profile, limits.jerk) / rms_jerk(fastest->profile, limits.jerk);
    fmt::print("calm 0.3 on a line: time {:.5f}, RMS jerk {:.4f}\n", time, jerk);
    EXPECT_LE(time, 1.01);
    EXPECT_LE(jerk, 0.82);
    EXPECT_GE(jerk, 0.76);
}

}  // namespace
}  // namespace trunnion::test
