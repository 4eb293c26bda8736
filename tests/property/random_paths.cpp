// Random stretches planned by the feed planner alone and walked densely, by the exact state along the path and the
// path's exact derivatives. TRUNNION_SEED replays one, TRUNNION_PATHS sets how many.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <numeric>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "trunnion/feed/plan_stretch.hpp"

#include "../unit/feed/synthetic_paths.hpp"

namespace trunnion::test {
namespace {

constexpr double allowed = 1.0005;
constexpr double step_s = 1e-4;  // between two looks

double log_between(Random& random, double low, double high) {
    return std::exp(random.between(std::log(low), std::log(high)));
}

bool chance(Random& random, double share) {
    return random.unit() < share;
}

machine::AxisLimits random_limits(Random& random, bool rotary) {
    const double size = rotary ? 0.01 : 1;
    const double velocity = size * log_between(random, 10, 1000);
    const double acceleration = size * log_between(random, 100, 20000);
    const double jerk = size * log_between(random, 2e3, 1e6);
    return {velocity, acceleration, jerk};
}

machine::Machine random_machine(Random& random) {
    machine::Machine out = five_axis_machine(trunnion_limits());
    const bool any = chance(random, 0.6);
    for (int a = 0; a < out.axis_count; ++a) {
        if (any) out.axes[a].feed = random_limits(random, a > 2);
        out.axes[a].rapid = any ? random_limits(random, a > 2) : out.axes[a].feed;
    }
    return out;
}

using Direction = CornerPath::Vector;

/// Of length 1 over the linear axes, and some turn per mm.
Direction random_direction(Random& random, double turn_per_mm) {
    Direction out{};
    double square = 0.01;
    for (int i = 0; i < 3; ++i) {
        out[i] = random.between(-1, 1);
        square += out[i] * out[i];
    }
    for (int i = 0; i < 3; ++i) out[i] /= std::sqrt(square);
    for (int i = 3; i < 5; ++i) out[i] = turn_per_mm * random.between(-1, 1);
    return out;
}

/// Sharp turns every few millimetres.
path::ToolPath corners(Random& random) {
    CornerPath out;
    const int moves = 2 + static_cast<int>(random.between(0, 14));
    for (int k = 0; k < moves; ++k) {
        const Direction direction = random_direction(random, 0.05);
        out.straight_to(direction, log_between(random, 0.3, 25));
    }
    return out.make(log_between(random, 0.002, 0.2));
}

/// Short blocks that wander about one direction.
path::ToolPath dense(Random& random) {
    CornerPath out;
    const int moves = 20 + static_cast<int>(random.between(0, 60));
    const double size = log_between(random, 0.05, 1);
    Direction way = random_direction(random, 0.02);
    for (int k = 0; k < moves; ++k) {
        const Direction other = random_direction(random, 0.02);
        for (std::size_t i = 0; i < way.size(); ++i) way[i] += 0.1 * (other[i] - way[i]);
        out.straight_to(way, size * random.between(0.7, 1.3));
    }
    return out.make(log_between(random, 1e-4, 1e-2));
}

/// A few straights of any length with a corner between.
path::ToolPath straights(Random& random) {
    CornerPath out;
    const int moves = 1 + static_cast<int>(random.between(0, 3));
    const double size = log_between(random, 1e-2, 1000);
    for (int k = 0; k < moves; ++k) {
        const Direction direction = random_direction(random, 0.01);
        out.straight_to(direction, size * random.between(0.2, 1));
    }
    return out.make(1e-3 * size);
}

/// Only the rotary axes move.
path::ToolPath turns(Random& random) {
    CornerPath out;
    const int moves = 1 + static_cast<int>(random.between(0, 5));
    for (int k = 0; k < moves; ++k) {
        Direction direction{};
        for (int i = 3; i < 5; ++i) direction[i] = random.between(-1, 1) / 30;
        out.straight_to(direction, log_between(random, 1, 100));
    }
    return out.make(log_between(random, 1e-4, 1e-2));
}

/// A straight of the tip on which the tool passes the pole at some distance.
path::ToolPath past_the_pole(Random& random) {
    path::ToolPath out;
    path::PathPiece piece;
    piece.length_mm = log_between(random, 5, 100);
    piece.coefficient[0][1] = piece.length_mm;
    const double passed_at = random.between(0.2, 0.8), tilt = random.between(0.2, 1);
    piece.coefficient[3] = {-passed_at * tilt, tilt, 0, 0, 0, 0, 0, 0};
    piece.coefficient[4][0] = log_between(random, 1e-5, 0.1);
    piece.coefficient[5][0] = 1;
    out.pieces.push_back(piece);
    return out;
}

path::Feed random_feed(Random& random, path::Space space) {
    const double which = random.unit(), value = log_between(random, 0.5, 400);
    if (which < 0.15) return {};
    if (which < 0.25 && space == path::Space::workpiece) return {path::FeedRule::block_time, 0.1 * value};
    return {path::FeedRule::tip_speed, value};
}

/// Blocks whose feeds change anywhere, or one without a feed.
void add_blocks(Random& random, bool pure_turn, path::ToolPath& path) {
    const double length = path.length_mm();
    const int count = chance(random, 0.4) ? 1 : 1 + static_cast<int>(random.between(0, 8));
    std::vector<double> ends;
    for (int k = 1; k < count; ++k) ends.push_back(length * random.between(0.02, 0.98));
    ends.push_back(length);
    std::sort(ends.begin(), ends.end());
    path.blocks.clear();
    double begin = 0;
    for (const double end : ends) {
        if (end - begin < 1e-4 * length) continue;
        path::Feed feed = random_feed(random, path.space);
        if (pure_turn && feed.rule == path::FeedRule::tip_speed) feed = {path::FeedRule::rotary_rate, feed.value / 30};
        path.blocks.push_back({begin, end, feed, 1, end - begin});
        begin = end;
    }
    path.blocks.back().end_mm = length;
}

struct Kind {
    const char* name;
    path::ToolPath (*make)(Random&);
    path::Space space;
};
constexpr std::array<Kind, 5> kinds{{{"corners", corners, path::Space::machine},
                                     {"dense", dense, path::Space::machine},
                                     {"straights", straights, path::Space::machine},
                                     {"turns", turns, path::Space::machine},
                                     {"past the pole", past_the_pole, path::Space::workpiece}}};

Stretch random_stretch(Random& random, const Kind& kind) {
    Stretch out;
    out.machine = random_machine(random);
    out.tool_path = kind.make(random);
    out.tool_path.space = kind.space;
    out.tool_path.rapid = chance(random, 0.1);
    add_blocks(random, kind.make == turns, out.tool_path);
    out.close();
    return out;
}

/// What the programmed feed of a block is used at some speed; a block_time bounds ṗ itself.
double feed_use(const path::BlockSpan& block, const path::AxisSample& at, double speed) {
    switch (block.feed.rule) {
        case path::FeedRule::tip_speed:
            return speed * at.feed_rate / block.feed.value;
        case path::FeedRule::rotary_rate:
            return speed * at.turn_rate / block.feed.value;
        case path::FeedRule::block_time:
            return speed * block.feed.value / block.time_scale_mm;
        case path::FeedRule::none:
            break;
    }
    return 0;
}

/// One walk over a plan: what was worst, and where.
class Walk {
  public:
    Walk(const path::AxisPath& path, const motion::FeedProfile& profile) : path_(path), profile_(profile) {}

    void operator()() {
        for (const motion::ProfilePiece& piece : profile_.pieces) walk(piece);
        for (std::size_t k = 0; k + 1 < profile_.pieces.size(); ++k) join(profile_.pieces[k], profile_.pieces[k + 1]);
        const motion::ProfilePiece &first = profile_.pieces.front(), &last = profile_.pieces.back();
        starts_ = first.kind == motion::ProfilePiece::Kind::rest_start && first.begin_s == 0 && begin_of(first) == 0;
        ends_ = last.kind == motion::ProfilePiece::Kind::rest_stop &&
                std::abs(begin_of(last) + last.length_mm - path_.length_mm()) <= 1e-9 * path_.length_mm();
    }

    double worst() const { return worst_; }
    const std::string& where() const { return where_; }
    bool moves_throughout() const { return moves_; }
    bool from_end_to_end() const { return starts_ && ends_; }
    double worst_joint() const { return joint_; }

  private:
    double begin_of(const motion::ProfilePiece& piece) const {
        return path_.tool_path().pieces[piece.path_piece].begin_mm + piece.path_offset_mm;
    }
    void walk(const motion::ProfilePiece& piece);
    void look(const motion::ProfilePiece& piece, double delta);
    void join(const motion::ProfilePiece& before, const motion::ProfilePiece& behind);
    void note(double ratio, const char* what, int axis, double p);

    const path::AxisPath& path_;
    const motion::FeedProfile& profile_;
    double worst_ = 0, joint_ = 0;
    std::string where_;
    bool moves_ = true, starts_ = false, ends_ = false;
};

void Walk::note(double ratio, const char* what, int axis, double p) {
    if (ratio <= worst_) return;
    worst_ = std::isnan(ratio) ? std::numeric_limits<double>::infinity() : ratio;
    where_ = fmt::format("{} of axis {} at p = {:.6g} mm of {:.6g}", what, axis, p, path_.length_mm());
}

void Walk::walk(const motion::ProfilePiece& piece) {
    const int points = std::clamp(static_cast<int>(piece.duration_s / step_s), 12, 2000);
    for (int k = 0; k < points; ++k) look(piece, piece.length_mm * k / points);
    look(piece, piece.length_mm);
    // An arc at rest lasts longest where it is shortest.
    constexpr double nearer = 1.3;
    if (piece.kind != motion::ProfilePiece::Kind::cubic)
        for (double u = piece.length_mm / points; u > 1e-5 * piece.length_mm; u /= nearer)
            look(piece, piece.kind == motion::ProfilePiece::Kind::rest_start ? u : piece.length_mm - u);
}

void Walk::look(const motion::ProfilePiece& piece, double delta) {
    path::AxisSample at;
    path_.evaluate({piece.path_piece, piece.path_offset_mm + delta}, at);
    const motion::PathState s = motion::state_at(piece, delta);
    const double v = s.speed_mm_s, a = s.acceleration_mm_s2, p = begin_of(piece) + delta;
    const bool at_rest = (piece.kind == motion::ProfilePiece::Kind::rest_start && delta == 0) ||
                         (piece.kind == motion::ProfilePiece::Kind::rest_stop && delta == piece.length_mm);
    moves_ = moves_ && (v > 0 || at_rest);
    for (int i = 0; i < path_.axis_count(); ++i) {
        const machine::Axis& axis = path_.machine().axes[i];
        const machine::AxisLimits& limit = path_.tool_path().rapid ? axis.rapid : axis.feed;
        const Taylor3& q = at.axes[i];
        note(std::abs(q.d1() * v) / limit.velocity, "velocity", i, p);
        note(std::abs(q.d2() * v * v + q.d1() * a) / limit.acceleration, "acceleration", i, p);
        note(std::abs(q.d3() * v * v * v + 3 * q.d2() * v * a + q.d1() * s.jerk_mm_s3) / limit.jerk, "jerk", i, p);
    }
    // At an end of the piece the feed of its inside holds.
    const double inside = begin_of(piece) + std::clamp(delta, 1e-3 * piece.length_mm, 0.999 * piece.length_mm);
    const auto& blocks = path_.tool_path().blocks;
    const auto block = std::lower_bound(blocks.begin(), blocks.end() - 1, inside,
                                        [](const path::BlockSpan& b, double where) { return b.end_mm < where; });
    note(feed_use(*block, at, v), "feed", -1, p);
}

/// Jumps of place, time, speed and acceleration, of what they are.
void Walk::join(const motion::ProfilePiece& before, const motion::ProfilePiece& behind) {
    const motion::PathState s0 = motion::state_at(before, before.length_mm), s1 = motion::state_at(behind, 0);
    const double speed = std::max(s0.speed_mm_s, s1.speed_mm_s),
                 scale = std::max({std::abs(s0.acceleration_mm_s2), std::abs(s1.acceleration_mm_s2),
                                   speed * speed / std::max(before.length_mm, behind.length_mm)});
    joint_ = std::max({joint_, std::abs(s0.speed_mm_s - s1.speed_mm_s) / speed,
                       std::abs(s0.acceleration_mm_s2 - s1.acceleration_mm_s2) / scale,
                       std::abs(begin_of(before) + before.length_mm - begin_of(behind)) / path_.length_mm(),
                       std::abs(before.begin_s + before.duration_s - behind.begin_s) / profile_.duration_s()});
}

feed::FeedOptions random_options(Random& random) {
    feed::FeedOptions out;
    const double which = random.unit();
    out.window = which < 0.2 ? 1000000 : static_cast<std::size_t>(log_between(random, 16, 400));
    const double calm = log_between(random, 1e-4, 1);
    out.calm = random.unit() < 0.3 ? 0 : random.unit() < 0.6 ? 0.001 : calm;
    return out;
}

struct Count {
    std::uint64_t planned = 0, unreachable = 0;
    int windows = 0, fallbacks = 0;
    double worst = 0;
};

void plan_and_walk(std::uint64_t seed, Count& count) {
    Random random(seed);
    const Kind& kind = kinds[seed % kinds.size()];
    const Stretch stretch = random_stretch(random, kind);
    const feed::FeedOptions options = random_options(random);
    const std::string who =
        fmt::format("seed {} ({}, window {}, calm {:.4g})", seed, kind.name, options.window, options.calm);
    if (!stretch.axis_path) {
        EXPECT_TRUE(kind.make == past_the_pole) << who;
        ++count.unreachable;
        return;
    }
    const auto plan = feed::plan_stretch(*stretch.axis_path, options);
    ASSERT_TRUE(plan) << who << ": " << to_string(plan.error());
    Walk walk(*stretch.axis_path, plan->profile);
    walk();
    EXPECT_LE(walk.worst(), allowed) << who << ": " << walk.where();
    EXPECT_TRUE(walk.moves_throughout()) << who;
    EXPECT_TRUE(walk.from_end_to_end()) << who;
    EXPECT_LE(walk.worst_joint(), 1e-6) << who;
    EXPECT_GE(plan->profile.duration_s(), plan->jerk_free_bound_s * (1 - 5e-4)) << who;
    ++count.planned;
    count.windows += plan->windows;
    count.fallbacks += plan->fallbacks;
    count.worst = std::max(count.worst, walk.worst());
}

std::uint64_t environment(const char* name, std::uint64_t otherwise) {
    const char* text = std::getenv(name);
    return text ? std::strtoull(text, nullptr, 10) : otherwise;
}

void plan_and_walk_all(std::uint64_t paths) {
    const std::uint64_t first = environment("TRUNNION_SEED", 1);
    paths = environment("TRUNNION_PATHS", paths);
    Count count;
    for (std::uint64_t seed = first; seed < first + paths; ++seed) plan_and_walk(seed, count);
    fmt::print(
        "seeds {} to {}: {} planned, {} pass the pole too closely to follow, {} windows, {} fallbacks, worst {:.5f}\n",
        first, first + paths - 1, count.planned, count.unreachable, count.windows, count.fallbacks, count.worst);
    // Windows of 16 intervals and more: the shortest ones see less than a stop, and begin anew a little later.
    EXPECT_LE(50 * count.fallbacks, count.windows);
    EXPECT_GE(10 * count.planned, 9 * paths) << "too few are planned for the test to mean anything";
}

TEST(RandomPaths, hold_every_limit_between_the_samples_too) {
    plan_and_walk_all(300);
}

TEST(NightlyRandomPaths, hold_every_limit_between_the_samples_too) {
    plan_and_walk_all(10000);
}

}  // namespace
}  // namespace trunnion::test
