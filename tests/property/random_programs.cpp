// Random programs through the whole way, judged by the independent checker. TRUNNION_SEED replays one,
// TRUNNION_PROGRAMS sets how many.
#include <cmath>
#include <cstdlib>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "trunnion/base/quantity.hpp"
#include "trunnion/files/machine_file.hpp"
#include "trunnion/pipeline/plan.hpp"
#include "trunnion/verify/check.hpp"

namespace trunnion {
namespace {

using program::Event;
using program::EventKind;
using program::FeedRule;
using program::Move;
using program::MoveKind;
using program::OrientationLaw;
using program::Program;

/// xorshift64*: the same numbers on every machine.
class Random {
  public:
    explicit Random(std::uint64_t seed) : state_(seed * 0x9E3779B97F4A7C15u + 1) {}
    double unit() {
        state_ ^= state_ >> 12;
        state_ ^= state_ << 25;
        state_ ^= state_ >> 27;
        return static_cast<double>((state_ * 0x2545F4914F6CDD1Du) >> 11) * 0x1p-53;
    }
    double between(double low, double high) { return low + (high - low) * unit(); }
    double log_between(double low, double high) { return std::exp(between(std::log(low), std::log(high))); }
    bool chance(double p) { return unit() < p; }

  private:
    std::uint64_t state_;
};

Eigen::Vector3d direction(Random& random) {
    const double x = random.between(-1, 1), y = random.between(-1, 1), z = random.between(-1, 1);
    const Eigen::Vector3d v(x, y, z);
    return v.norm() > 0.05 ? Eigen::Vector3d(v.normalized()) : Eigen::Vector3d::UnitX();
}

/// A walk: mostly going on in about the same direction, with corners, dense stretches, pure turns, doubled points,
/// rapids and dwells. With `returns` it also comes back over its own way.
Program random_program(Random& random, bool vectors, bool returns) {
    Program program;
    if (!vectors) program.rotary_letters = {'A', 'C'};
    Move at;
    at.law = vectors ? OrientationLaw::vector : OrientationLaw::rotary;
    at.feed = {FeedRule::tip_speed, random.log_between(1, 300)};
    double a = random.between(-60, 60) * degree, c = random.between(-180, 180) * degree;
    const double scale = random.log_between(0.02, 20);
    Eigen::Vector3d way = direction(random);
    double da = random.between(-1, 1), dc = random.between(-1, 1);
    const auto place = [&] {
        at.rotary_rad = {a, c, 0};
        at.axis = {std::sin(c) * std::sin(a), -std::cos(c) * std::sin(a), std::cos(a)};
        at.line = static_cast<std::int32_t>(program.moves.size()) + 1;
        program.moves.push_back(at);
    };
    place();
    const int count = 3 + static_cast<int>(random.between(0, 60));
    for (int k = 0; k < count; ++k) {
        if (random.chance(0.2)) {
            const Eigen::Vector3d turned = direction(random);
            if (returns || turned.dot(way) > -0.5) way = turned;
        }
        if (returns && random.chance(0.1)) way = -way;
        if (random.chance(0.2)) da = random.between(-1, 1), dc = random.between(-1, 1);
        const double length = scale * random.log_between(0.1, 3);
        at.kind = random.chance(0.06) ? MoveKind::rapid : MoveKind::feed;
        if (!random.chance(0.08)) at.position_mm += length * (way + 0.05 * direction(random)).normalized();
        if (random.chance(0.8)) {
            const double turn = std::min(0.02 * length, 0.4) * random.between(0.2, 3);
            a = std::clamp(a + da * turn, -80 * degree, 80 * degree);
            c += dc * turn;
        }
        if (at.position_mm.cwiseAbs().maxCoeff() > 250) way = -at.position_mm.normalized();
        if (random.chance(0.1)) at.feed.value = random.log_between(1, 300);
        if (random.chance(0.03))
            program.events.push_back(
                {EventKind::dwell, true, random.between(0.001, 0.1), "G4", program.moves.size(), 0});
        at.exact_stop = random.chance(0.03);
        if (at.kind == MoveKind::rapid) at.position_mm += 5 * direction(random);
        place();
    }
    return program;
}

/// Whether tip and turn together (one radian counts 30 mm) change direction by more than a right angle anywhere: near
/// such a corner the nearest place of the path, by which the checker matches, is not the corresponding one.
bool turns_back(const Program& program) {
    using Step = Eigen::Matrix<double, 6, 1>;
    Step before = Step::Zero();
    for (std::size_t k = 1; k < program.moves.size(); ++k) {
        Step step;
        step << program.moves[k].position_mm - program.moves[k - 1].position_mm,
            30 * (program.moves[k].axis - program.moves[k - 1].axis);
        if (step.norm() < 1e-6) continue;
        if (step.dot(before) < 0) return true;
        before = step;
    }
    return false;
}

struct Rows : pipeline::PlanObserver {
    std::vector<motion::Setpoint> rows;
    void setpoint(const motion::Setpoint& row) override { rows.push_back(row); }
};

std::uint64_t environment(const char* name, std::uint64_t otherwise) {
    const char* text = std::getenv(name);
    return text ? std::strtoull(text, nullptr, 10) : otherwise;
}

void plan_and_check(std::uint64_t seed, const machine::Machine& machine) {
    Random random(seed);
    const bool vectors = random.chance(0.5);
    const Program program = random_program(random, vectors, random.chance(0.2));
    const bool matching_fails = turns_back(program);
    machine::Setup setup;
    setup.workpiece.origin_mm = {random.between(-50, 50), random.between(-50, 50), random.between(-20, 80)};
    setup.tool.length_mm = random.between(0, 120);
    pipeline::PlanOptions options;
    options.smoothing.tip_tolerance_mm = random.log_between(0.002, 0.1);
    options.smoothing.orientation_tolerance_rad = random.log_between(0.02, 0.5) * degree;
    if (random.chance(0.2)) options.smoothing.flank_tolerance_mm = random.log_between(0.005, 0.2);
    if (random.chance(0.1)) options.smoothing.rounding = smoothing::Rounding::none;
    Rows recorded;
    const auto summary = pipeline::plan(program, machine, setup, options, recorded);
    if (!summary) {
        // Beside the pole and outside the ranges a vector program may be refused, with its code.
        EXPECT_TRUE(vectors && (summary.error().code == "PATH0102" || summary.error().code == "PATH0103"))
            << "seed " << seed << ": " << to_string(summary.error());
        return;
    }
    EXPECT_TRUE(summary->usable()) << "seed " << seed << "\n" << summary->report();
    EXPECT_GE(summary->cycle_time_s, summary->jerk_free_bound_s * (1 - 1e-3)) << "seed " << seed;
    const auto table = verify::setpoint_table(std::move(recorded.rows));
    const auto poses = verify::programmed_poses(program, machine, setup);
    if (!summary->setpoints) return;
    ASSERT_TRUE(table && poses);
    verify::CheckOptions checking;
    // The bound is at equal p and strict (usable() above). The checker matches by nearest place, tip and turn together;
    // at sharp corners of both that can leave one of them a little more.
    constexpr double other_matching = 1.03;
    checking.tip_tolerance_mm = options.smoothing.tip_tolerance_mm * other_matching;
    checking.orientation_tolerance_rad = options.smoothing.orientation_tolerance_rad * other_matching;
    checking.flank_tolerance_mm = options.smoothing.flank_tolerance_mm * other_matching;
    const auto verdict = verify::check(*table, *poses, machine, setup, checking);
    ASSERT_TRUE(verdict) << "seed " << seed << ": " << to_string(verdict.error());
    std::string broken;
    for (const auto& b : verdict->broken) {
        const bool of_path = b.what.find("deviation") != b.what.npos || b.what.find("poses") != b.what.npos;
        if (matching_fails && of_path) continue;
        broken +=
            fmt::format("{} {:.6g}, limit {:.6g} at {:.4f} s, line {}\n", b.what, b.value, b.limit, b.time_s, b.line);
    }
    EXPECT_TRUE(broken.empty()) << "seed " << seed << (vectors ? " vectors\n" : " rotary\n") << broken
                                << summary->report();
}

TEST(RandomPrograms, hold_every_limit_and_tolerance) {
    const auto machine = files::read_machine_file(TRUNNION_SOURCE_DIR "/data/machines/ucp710.toml");
    ASSERT_TRUE(machine);
    auto table = *machine;  // its kinematics and limits; ranges wide enough for a random walk
    for (int i = 0; i < table.axis_count; ++i) {
        table.axes[i].range_min *= i < 3 ? 10 : 4;
        table.axes[i].range_max *= i < 3 ? 10 : 4;
    }
    const std::uint64_t first = environment("TRUNNION_SEED", 1), count = environment("TRUNNION_PROGRAMS", 60);
    fmt::print("seeds {} … {}\n", first, first + count - 1);
    for (std::uint64_t seed = first; seed < first + count; ++seed) plan_and_check(seed, table);
}

}  // namespace
}  // namespace trunnion
