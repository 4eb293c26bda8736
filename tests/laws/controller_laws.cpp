// What has to hold of every control that is predicted: what allows less is never faster. Random programs; TRUNNION_SEED
// replays one.
#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "trunnion/base/quantity.hpp"
#include "trunnion/controller/predict.hpp"
#include "trunnion/files/controller_file.hpp"
#include "trunnion/geometry/great_circle.hpp"
#include "trunnion/pipeline/predict.hpp"

#include "shipped_machine.hpp"

namespace {

using namespace trunnion;
using motion::Controller;
using motion::ParameterId;
using program::Program;

constexpr int programs = 40;
constexpr double rounding_slack = 1e-9;      // where the axes go straight from block to block
constexpr double resampling_slack = 1.5e-3;  // where blocks are resampled until the time changes by less than 5e-4

enum class Kind { straight, turning, vectors };

/// A walk with corners, dense stretches, pure turns, rapids and dwells.
Program walk(RandomNumbers& random, Kind kind) {
    Program out;
    if (kind != Kind::vectors) out.rotary_letters = {'A', 'C'};
    program::Move move;
    move.law = kind == Kind::vectors ? program::OrientationLaw::vector : program::OrientationLaw::rotary;
    move.axis = Eigen::Vector3d(0, 0.4, 1).normalized();
    move.rotary_rad = {20 * degree, 0, 0};
    move.feed = {program::FeedRule::tip_speed, random.between(5, 200)};
    move.line = 1;
    out.moves.push_back(move);
    const int count = 3 + static_cast<int>(random.between(0, 80));
    const double scale = std::exp(random.between(std::log(0.05), std::log(10)));
    Eigen::Vector3d way = Eigen::Vector3d::UnitX();
    for (int k = 1; k <= count; ++k) {
        if (random.between(0, 1) < 0.15) {
            const double x = random.between(-1, 1), y = random.between(-1, 1), z = random.between(-0.5, 0.5);
            way = Eigen::Vector3d(x, y, z).normalized();
        }
        const double wiggle = random.between(-0.05, 0.05);
        move.position_mm += scale * random.between(0.3, 2) * (way + wiggle * Eigen::Vector3d::UnitZ());
        const double tilt = random.between(-0.02, 0.02), turned = random.between(-0.05, 0.05);
        if (kind == Kind::turning) {
            move.rotary_rad[0] = std::clamp(move.rotary_rad[0] + tilt, 0.1, 1.0);
            move.rotary_rad[1] += turned;
        }
        if (kind == Kind::vectors) {
            move.axis += Eigen::Vector3d(tilt, turned, 0);
            move.axis = Eigen::Vector3d(std::clamp(move.axis.x(), -0.5, 0.5), std::clamp(move.axis.y(), 0.2, 0.8), 1)
                            .normalized();
        }
        move.kind = random.between(0, 1) < 0.05 ? program::MoveKind::rapid : program::MoveKind::feed;
        move.exact_stop = random.between(0, 1) < 0.03;
        move.line = k + 1;
        out.moves.push_back(move);
    }
    out.events.push_back({program::EventKind::dwell, true, 0.1, "G4", out.moves.size() / 2, 0});
    return out;
}

/// The same motion in so many times as many blocks.
Program finer(const Program& program, int parts) {
    Program out = program;
    out.moves = {program.moves.front()};
    out.events.clear();
    for (program::Event event : program.events) {
        event.before_move = event.before_move == 0 ? 0 : (event.before_move - 1) * static_cast<std::size_t>(parts) + 1;
        out.events.push_back(event);
    }
    for (std::size_t i = 1; i < program.moves.size(); ++i)
        for (int k = 1; k <= parts; ++k) {
            const program::Move &from = program.moves[i - 1], &to = program.moves[i];
            const double w = static_cast<double>(k) / parts;
            program::Move move = to;
            move.position_mm = (1 - w) * from.position_mm + w * to.position_mm;
            move.axis = geometry::slerp(from.axis, to.axis, w);
            for (std::size_t a = 0; a < 2; ++a) move.rotary_rad[a] = std::lerp(from.rotary_rad[a], to.rotary_rad[a], w);
            move.exact_stop = to.exact_stop && k == parts;
            out.moves.push_back(move);
        }
    return out;
}

std::vector<std::string> block_controllers() {
    std::vector<std::string> out;
    for (const auto& entry : std::filesystem::directory_iterator(TRUNNION_SOURCE_DIR "/data/controllers")) {
        const auto read = files::read_controller_file(entry.path());
        if (!read || read->kind == motion::ControllerKind::blocks) out.push_back(entry.path().string());
    }
    out.emplace_back(TRUNNION_SOURCE_DIR "/examples/04_prediction/old_control.toml");
    std::ranges::sort(out);
    return out;
}

struct Variant {
    const char* name;
    motion::Profile profile;
    motion::Transition transition;
    motion::AxisSetChange axis_set;
};
constexpr Variant variants[] = {
    {"as it is", motion::Profile::jerk_limited, motion::Transition::rounding_arc, motion::AxisSetChange::none},
    {"trapezoidal", motion::Profile::trapezoidal, motion::Transition::rounding_arc, motion::AxisSetChange::none},
    {"velocity step", motion::Profile::jerk_limited, motion::Transition::velocity_step, motion::AxisSetChange::none},
    {"axis set", motion::Profile::jerk_limited, motion::Transition::rounding_arc, motion::AxisSetChange::stop}};

class ControllerLaws : public testing::TestWithParam<std::string> {
  protected:
    void SetUp() override {
        auto read = files::read_controller_file(GetParam());
        ASSERT_TRUE(read) << to_string(read.error());
        shipped = *read;
        machine = files::read_machine_file(machines_folder() / "ucp710.toml").value();
        for (int a = 0; a < 3; ++a) machine.axes[a].range_min = -1e5, machine.axes[a].range_max = 1e5;
    }

    double time(const Program& program, const Controller& controller, double feed_override = 1) const {
        return time(program, controller, machine, feed_override);
    }
    static double time(const Program& program, const Controller& controller, const machine::Machine& on,
                       double feed_override = 1) {
        controller::PredictOptions options;
        options.uncertainty = false;
        options.feed_override = feed_override;
        const auto prediction = controller::predict(program, on, {}, controller, options);
        EXPECT_TRUE(prediction) << to_string(prediction.error());
        return prediction ? prediction->cycle_time_s : 0;
    }

    /// The controller of the file with every part of the model at work.
    Controller with(const Variant& variant) const {
        Controller out = shipped;
        out.profile.way = variant.profile;
        out.transition.way = variant.transition;
        out.axis_set_change.way = variant.axis_set;
        if (!out[ParameterId::jerk_share].given) out[ParameterId::jerk_share].value = 1;
        out[ParameterId::velocity_step].value = 5;
        out[ParameterId::rotary_velocity_step].value = 5 * degree;
        out[ParameterId::rounding_tolerance].value = 0.02;
        out[ParameterId::curvature_jump_share].value = 0.5;
        out[ParameterId::look_ahead_blocks].value = 10;
        out[ParameterId::look_ahead_distance].value = 80;
        out[ParameterId::block_preparation].value = 2e-3;
        out[ParameterId::block_buffer].value = 5;
        out[ParameterId::setpoint_filter].value = 8e-3;
        out[ParameterId::in_position_time].value = 5e-3;
        return out;
    }

    template <class Law>
    void on_random_programs(const Law& law) const {
        RandomNumbers random(random_seed());
        for (int i = 0; i < programs; ++i) {
            const auto kind = static_cast<Kind>(i % 3);
            const Program program = walk(random, kind);
            const Variant& variant = variants[static_cast<std::size_t>(i / 3) % std::size(variants)];
            SCOPED_TRACE(testing::Message() << "program " << i << ", " << variant.name);
            law(program, with(variant), 1 - (kind == Kind::straight ? rounding_slack : resampling_slack));
        }
    }

    Controller shipped;
    machine::Machine machine;
};

TEST_P(ControllerLaws, LessAllowedIsNeverFaster) {
    struct Less {
        ParameterId id;
        double factor;
    };
    const Less all[] = {{ParameterId::velocity_share, 0.03},      {ParameterId::acceleration_share, 0.7},
                        {ParameterId::jerk_share, 0.5},           {ParameterId::rapid_share, 0.03},
                        {ParameterId::rounding_tolerance, 0.3},   {ParameterId::velocity_step, 0.4},
                        {ParameterId::rotary_velocity_step, 0.4}, {ParameterId::curvature_jump_share, 0.2},
                        {ParameterId::look_ahead_blocks, 0.5},    {ParameterId::look_ahead_distance, 0.1},
                        {ParameterId::interpolator_cycle, 3},     {ParameterId::block_preparation, 4},
                        {ParameterId::setpoint_filter, 2},        {ParameterId::in_position_time, 2}};
    std::vector<int> told(motion::parameter_count, 0);
    on_random_programs([&](const Program& program, const Controller& controller, double slack) {
        const double before = time(program, controller);
        for (const Less& less : all) {
            Controller lower = controller;
            lower[less.id].value = std::floor(less.factor * 1e9 * lower[less.id].value) / 1e9;
            if (less.id == ParameterId::look_ahead_blocks) lower[less.id].value = std::floor(lower[less.id].value);
            const double after = time(program, lower);
            EXPECT_GE(after, slack * before) << motion::facts_of(less.id).key;
            if (after > 1.001 * before) ++told[static_cast<std::size_t>(less.id)];
        }
        EXPECT_GE(time(program, controller, 0.7), slack * before);
    });
    for (const Less& less : all) EXPECT_GT(told[static_cast<std::size_t>(less.id)], 0) << motion::facts_of(less.id).key;
}

TEST_P(ControllerLaws, LowerLimitsOfOneAxisAreNeverFaster) {
    on_random_programs([&](const Program& program, const Controller& controller, double slack) {
        const double before = time(program, controller);
        for (int axis = 0; axis < machine.axis_count; ++axis)
            for (double machine::AxisLimits::* limit :
                 {&machine::AxisLimits::velocity, &machine::AxisLimits::acceleration, &machine::AxisLimits::jerk}) {
                auto weaker = machine;
                weaker.axes[axis].feed.*limit *= 0.5;
                weaker.axes[axis].rapid.*limit *= 0.5;
                EXPECT_GE(time(program, controller, weaker), slack * before) << machine.axes[axis].letter;
            }
    });
}

TEST_P(ControllerLaws, ExactStopIsSlowest) {
    on_random_programs([&](const Program& program, const Controller& controller, double slack) {
        Controller stopping = controller;
        stopping.transition.way = motion::Transition::exact_stop;
        const double slowest = time(program, stopping);
        EXPECT_GE(slowest, slack * time(program, controller));
        for (const Variant& variant : variants) {
            if (variant.profile != controller.profile.way) continue;
            EXPECT_GE(slowest, slack * time(program, with(variant))) << variant.name;
        }
    });
}

/// But for jumps of curvature, which finer blocks make smaller.
TEST_P(ControllerLaws, FinerBlocksAreNeverFaster) {
    on_random_programs([&](const Program& program, Controller controller, double slack) {
        controller[ParameterId::curvature_jump_share].value = std::numeric_limits<double>::infinity();
        const double before = time(program, controller);
        for (const int parts : {2, 7}) EXPECT_GE(time(finer(program, parts), controller), slack * before) << parts;
    });
}

TEST_P(ControllerLaws, LongerLookAheadIsNeverSlower) {
    int helped = 0;
    on_random_programs([&](const Program& program, Controller controller, double slack) {
        const double inf = std::numeric_limits<double>::infinity();
        double last = inf;
        for (const double blocks : {0.0, 1.0, 2.0, 5.0, 20.0, 100.0, inf}) {
            controller[ParameterId::look_ahead_blocks].value = blocks;
            const double now = time(program, controller);
            EXPECT_LE(slack * now, last) << blocks;
            if (now < 0.999 * last && last < inf) ++helped;
            last = now;
        }
    });
    EXPECT_GT(helped, programs / 2);
}

TEST_P(ControllerLaws, NeverFasterThanLengthOverFeed) {
    Controller cam{.kind = motion::ControllerKind::length_over_feed};
    on_random_programs([&](const Program& program, const Controller& controller, double slack) {
        EXPECT_GE(time(program, controller), slack * time(program, cam));
    });
}

INSTANTIATE_TEST_SUITE_P(Shipped, ControllerLaws, testing::ValuesIn(block_controllers()), stem);

/// Where nothing limits but feed and rapid velocity all is in proportion.
TEST(LengthOverFeed, IsInProportion) {
    const Controller cam{.kind = motion::ControllerKind::length_over_feed};
    const auto machine = files::read_machine_file(machines_folder() / "generic-5axis.toml").value();
    RandomNumbers random(random_seed());
    controller::PredictOptions half;
    half.feed_override = 0.5;
    const auto told = [&](const Program& program, const machine::Machine& on,
                          const controller::PredictOptions& options) {
        return controller::predict(program, on, {}, cam, options).value();
    };
    for (int i = 0; i < programs; ++i) {
        const Program program = walk(random, static_cast<Kind>(i % 3));
        SCOPED_TRACE(i);
        const auto whole = told(program, machine, {});
        EXPECT_NEAR(told(program, machine, half).cut_time_s, 2 * whole.cut_time_s, 1e-9 * whole.cut_time_s);
        EXPECT_NEAR(told(finer(program, 3), machine, {}).cut_time_s, whole.cut_time_s, 1e-9 * whole.cut_time_s);
        auto slower = machine;
        for (int a = 0; a < machine.axis_count; ++a) slower.axes[a].rapid.velocity *= 0.5;
        EXPECT_NEAR(told(program, slower, {}).rapid_time_s, 2 * whole.rapid_time_s, 1e-9);
    }
}

/// Our own planner finds its times by optimising: within 0.3 %.
TEST(IdealController, LessAllowedIsNeverFaster) {
    constexpr double slack = 0.997;
    const Controller ideal{.kind = motion::ControllerKind::ideal};
    auto machine = files::read_machine_file(machines_folder() / "generic-5axis.toml").value();
    RandomNumbers random(random_seed());
    const auto time = [&](const Program& program, const machine::Machine& on,
                          const pipeline::PredictionOptions& options) {
        const auto prediction = pipeline::predict(program, on, {}, ideal, options);
        EXPECT_TRUE(prediction) << to_string(prediction.error());
        return prediction ? prediction->cycle_time_s : 0;
    };
    for (int i = 0; i < 6; ++i) {
        const Program program = walk(random, static_cast<Kind>(i % 3));
        SCOPED_TRACE(i);
        const double before = time(program, machine, {});
        auto weaker = machine;
        for (int a = 0; a < machine.axis_count; ++a) weaker.axes[a].feed.jerk *= 0.5, weaker.axes[a].rapid.jerk *= 0.5;
        EXPECT_GE(time(program, weaker, {}), slack * before);
        pipeline::PredictionOptions tighter;
        tighter.plan.smoothing.tip_tolerance_mm = 0.005;
        EXPECT_GE(time(program, machine, tighter), slack * before);
        pipeline::PredictionOptions stopping;
        stopping.plan.smoothing.rounding = smoothing::Rounding::none;
        EXPECT_GE(time(program, machine, stopping), slack * before);
    }
}

}  // namespace
