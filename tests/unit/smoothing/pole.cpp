// Runs that are led through the pole: C on A, the tool passes the axis of C closely.
#include <gtest/gtest.h>

#include "trunnion/path/pole_passage.hpp"
#include "trunnion/smoothing/pole_tolerance.hpp"
#include "trunnion/smoothing/smoothing.hpp"

#include "walk.hpp"

namespace trunnion::smoothing::test {
namespace {

constexpr double tolerance_rad = 0.1 * degree;

/// Evenly spread in [−1, 1]: xorshift64*, the same numbers on every machine.
class Noise {
  public:
    explicit Noise(std::uint64_t seed) : state_(seed * 0x9E3779B97F4A7C15u + 1) {}
    double operator()() {
        state_ ^= state_ >> 12;
        state_ ^= state_ << 25;
        state_ ^= state_ >> 27;
        return static_cast<double>((state_ * 0x2545F4914F6CDD1Du) >> 11) * 0x1p-52 - 1;
    }

  private:
    std::uint64_t state_;
};

struct Case {
    double length_mm = 40, block_mm = 1, tilt_deg = 10, aside_deg = 0.05, noise_rad = 0;
    int passes = 1;
    double bend = 0;  ///< of the way past the pole: a corner there
    std::uint64_t seed = 1;
};

/// Passes beside the pole, to and fro, and where the run is to go through it.
path::Run past_pole(const Case& c) {
    std::vector<Pose> poses;
    Noise noise(c.seed);
    const int blocks = static_cast<int>(std::lround(c.length_mm / c.block_mm));
    for (int pass = 0; pass < c.passes; ++pass)
        for (int k = pass > 0 && c.passes == 1 ? 1 : 0; k <= blocks; ++k) {
            const double share = 2.0 * k / blocks - 1, forth = pass % 2 ? -1 : 1;
            const double tilt = c.tilt_deg * degree * share * forth;
            const double nx = std::sin(tilt) + c.noise_rad * noise(),
                         ny = c.aside_deg * degree + c.bend * std::abs(tilt) + c.noise_rad * noise();
            const Eigen::Vector3d n = Eigen::Vector3d(nx, ny, std::cos(tilt)).normalized();
            poses.push_back({0.5 * c.length_mm * share * forth, 2.0 * pass, 0, n.x(), n.y(), n.z()});
        }
    path::Run run = run_through(poses, path::OrientationLaw::vector);
    for (int pass = 0; pass < c.passes; ++pass) {
        path::PolePassage passage;
        double least = 2;
        const std::size_t first = static_cast<std::size_t>(pass) * (static_cast<std::size_t>(blocks) + 1);
        for (std::size_t b = first; b < first + static_cast<std::size_t>(blocks); ++b) {
            const auto nearest = path::nearest_to_pole(Eigen::Vector3d(run.vertices[b].orientation.data()),
                                                       Eigen::Vector3d(run.vertices[b + 1].orientation.data()),
                                                       Eigen::Vector3d::UnitZ());
            if (nearest.distance() >= least) continue;
            least = nearest.distance();
            passage = {b, nearest.share, Eigen::Vector3d::UnitZ()};
        }
        run.passages.push_back(passage);
    }
    return run;
}

/// How often a border of two pieces lies at the pole, to rounding.
int borders_at_pole(const std::vector<path::ToolPath>& paths) {
    int out = 0;
    for (const auto& path : paths)
        for (std::size_t i = 1; i < path.pieces.size(); ++i) {
            const auto& c = path.pieces[i].coefficient;
            const auto end = path::evaluate(path.pieces[i - 1], path.pieces[i - 1].length_mm);
            if (std::hypot(c[3][0], c[4][0]) > 1e-15) continue;
            EXPECT_LT(std::hypot(end[3].value(), end[4].value()), 2e-15);
            ++out;
        }
    return out;
}

SmoothingOptions options() {
    SmoothingOptions out;
    out.tip_tolerance_mm = 0.01;
    out.orientation_tolerance_rad = tolerance_rad;
    return out;
}

void expect_through(const path::Run& run, const SmoothingOptions& used, const std::string& what) {
    std::vector<path::ToolPath> paths;
    smooth(run, used, paths);
    EXPECT_EQ(borders_at_pole(paths), static_cast<int>(run.passages.size())) << what;
    const Walk w = walk(run, paths, used.flank_height_mm, used.controlled_height_mm);
    EXPECT_EQ(w.stretches, 1U) << what;
    EXPECT_LE(w.bound_turn_rad, tolerance_rad) << what;
    EXPECT_LE(w.bound_tip_mm, used.tip_tolerance_mm) << what;
    EXPECT_LE(w.over_turn, 1e-10) << what;
    EXPECT_LE(w.over_tip, 1e-9) << what;
    EXPECT_LE(w.over_height, 1e-9) << what;
    EXPECT_LE(w.jump, 1e-7) << what;
    EXPECT_LE(w.end_miss, 1e-12) << what;
    if (run.blocks.size() > 1) {
        EXPECT_LE(w.end_second, 1e-9) << what;
    }
    EXPECT_GT(w.least_speed, 0.05) << what;
}

TEST(PoleShift, leads_runs_through_the_pole_within_the_tolerances) {
    expect_through(past_pole({}), options(), "blocks of 1 mm");
    expect_through(past_pole({.block_mm = 40}), options(), "one block");
    expect_through(past_pole({.block_mm = 20}), options(), "two blocks that meet beside the pole");
    expect_through(past_pole({.block_mm = 0.1}), options(), "dense");
    expect_through(past_pole({.block_mm = 0.1, .tilt_deg = 1}), options(), "slowly");
    expect_through(past_pole({.aside_deg = 0.079}), options(), "far aside");
    expect_through(past_pole({.aside_deg = 1e-6}), options(), "hardly aside");
    expect_through(past_pole({.aside_deg = 0}), options(), "not aside");
    expect_through(past_pole({.length_mm = 20, .passes = 5}), options(), "to and fro");
    expect_through(past_pole({.bend = 0.5}), options(), "a corner, which rounding would lead away from the pole");
}

TEST(PoleShift, leads_noisy_runs_through_the_pole) {
    for (std::uint64_t seed = 1; seed <= 20; ++seed)
        for (const double noise_rad : {3e-5, 1e-4, 3e-4})
            expect_through(past_pole({.block_mm = 0.1, .aside_deg = 0.04, .noise_rad = noise_rad, .seed = seed}),
                           options(), "seed " + std::to_string(seed) + ", noise " + std::to_string(noise_rad));
}

TEST(PoleShift, leaves_the_controlled_point_where_it_is) {
    auto used = options();
    used.tip_tolerance_mm = 0.001;
    used.controlled_height_mm = 5;  // turned about the tip it would move by 0.0044 mm
    expect_through(past_pole({}), used, "blocks of 1 mm");
    expect_through(past_pole({.block_mm = 40}), used, "one block");
}

TEST(PoleShift, keeps_the_flank_tolerance) {
    auto used = options();
    used.flank_tolerance_mm = 0.03;
    const path::Run run = past_pole({});
    expect_through(run, used, "flank");
    std::vector<path::ToolPath> paths;
    smooth(run, used, paths);
    for (const auto& path : paths) EXPECT_LE(path.bound.height_mm, 0.03);
}

TEST(PoleShift, reaches_far_but_not_to_the_ends) {
    const path::Run run = past_pole({.length_mm = 100, .tilt_deg = 20});
    std::vector<path::ToolPath> paths;
    smooth(run, options(), paths);
    ASSERT_EQ(paths.size(), 1U);
    double first = 1e9, last = 0;
    for (const auto& piece : paths[0].pieces)
        for (double u = 0; u < 1; u += 0.1) {
            const double p = piece.begin_mm + u * piece.length_mm;
            const auto at = path::evaluate(piece, u * piece.length_mm);
            if (std::abs(at[4].value() - 0.05 * degree) < 2e-5) continue;
            first = std::min(first, p);
            last = std::max(last, p);
        }
    const double middle = 0.5 * paths[0].length_mm();
    EXPECT_LT(first, middle - 0.5 * path::longest_shift_mm);
    EXPECT_GT(last, middle + 0.5 * path::longest_shift_mm);
    EXPECT_GT(first, middle - 1.3 * path::longest_shift_mm);
    EXPECT_LT(last, middle + 1.3 * path::longest_shift_mm);
}

TEST(PoleShift, leaves_runs_alone_that_pass_too_far_away_or_are_not_to_be_rounded) {
    const path::Run far = past_pole({.aside_deg = 0.15});
    path::Run plain = far;
    plain.passages.clear();
    std::vector<path::ToolPath> a, b;
    smooth(far, options(), a);
    smooth(plain, options(), b);
    ASSERT_EQ(a.size(), b.size());
    ASSERT_EQ(a[0].pieces.size(), b[0].pieces.size());
    for (std::size_t i = 0; i < a[0].pieces.size(); ++i)
        EXPECT_EQ(a[0].pieces[i].coefficient, b[0].pieces[i].coefficient);
    auto none = options();
    none.rounding = Rounding::none;
    a.clear();
    smooth(past_pole({}), none, a);
    EXPECT_EQ(borders_at_pole(a), 0);
}

TEST(PoleShift, tolerance_is_a_part_of_that_of_the_orientation) {
    EXPECT_NEAR(pole_tolerance_rad(options()), 0.8 * tolerance_rad, 1e-15);
    auto used = options();
    used.flank_tolerance_mm = 0.03;
    used.flank_height_mm = 60;
    EXPECT_NEAR(pole_tolerance_rad(used), 0.8 * 0.03 / 60, 1e-15);
    used.rounding = Rounding::none;
    EXPECT_EQ(pole_tolerance_rad(used), 0);
    used = options();
    used.orientation_tolerance_rad = 0;
    EXPECT_EQ(pole_tolerance_rad(used), 0);
    used = options();
    used.tip_tolerance_mm = 0;
    EXPECT_EQ(pole_tolerance_rad(used), 0);
}

}  // namespace
}  // namespace trunnion::smoothing::test
