// Lavernhe, Tournier, Lartigue 2006: figures of the paper, corrected where docs/theory/prediction.md says so.
#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "trunnion/base/quantity.hpp"
#include "trunnion/controller/contact_feed.hpp"
#include "trunnion/controller/predict.hpp"
#include "trunnion/files/controller_file.hpp"
#include "trunnion/files/machine_file.hpp"
#include "trunnion/machine/kinematics.hpp"

namespace {

using namespace trunnion;
using Eigen::Vector3d;

constexpr double blend_mm = 5, straight_mm = 60, feed_mm_s = 5000.0 / 60, lead_rad = 5 * degree;

machine::Machine machine_of_the_paper() {
    auto machine = files::read_machine_file(TRUNNION_SOURCE_DIR "/data/machines/ucp710.toml").value();
    machine.axes[machine.index_of('A')].feed.velocity = 25 * 2 * std::numbers::pi / 60;  // what its Fig. 11 asks for
    return machine;
}

motion::Controller control_of_the_paper() {
    return files::read_controller_file(TRUNNION_SOURCE_DIR "/data/controllers/lavernhe-2006.toml").value();
}

machine::Tool tool_of_the_paper() {
    return {.kind = machine::ToolKind::torus, .diameter_mm = 10, .corner_radius_mm = 1};
}

/// Where the tool touches a surface in the plane Y Z, and where its tip then is.
struct Touch {
    Vector3d contact, normal, feed;
    Vector3d axis() const { return std::cos(lead_rad) * normal + std::sin(lead_rad) * feed; }
    Vector3d tip() const {
        return contact - controller::contact_from_tip_mm(tool_of_the_paper(), axis(), feed, lead_rad);
    }
};

/// 60 mm, a quarter of a circle of radius 5 mm, 60 mm. side = +1: concave, up at its end; −1: convex.
Touch blend_at(double turned_rad, double side) {
    const double s = std::sin(turned_rad), c = std::cos(turned_rad);
    return {{0, blend_mm * s, side * blend_mm * (1 - c)}, {0, -side * s, c}, {0, c, side * s}};
}

program::Program blend_program(double side, int chords) {
    program::Program out;
    program::Move move;
    move.feed = {program::FeedRule::tip_speed, feed_mm_s};
    const auto add = [&](const Touch& touch, double along) {
        move.position_mm = touch.tip() + along * touch.feed;
        move.axis = touch.axis();
        move.line = static_cast<int>(out.moves.size());
        out.moves.push_back(move);
    };
    add(blend_at(0, side), -straight_mm);
    for (int k = 0; k <= chords; ++k) add(blend_at(90 * degree * k / chords, side), 0);
    add(blend_at(90 * degree, side), straight_mm);
    return out;
}

/// So many that the chords stay within 0.01 mm of the blend.
int chords_within_tolerance() {
    const double turn = 2 * std::acos(1 - 0.01 / blend_mm);
    return static_cast<int>(std::ceil(90 * degree / turn));
}

struct Followed {
    motion::Prediction prediction;
    std::vector<motion::PredictedRow> rows;
};

Followed follow(double side) {
    const auto program = blend_program(side, chords_within_tolerance());
    machine::Setup setup;
    setup.tool = tool_of_the_paper();
    controller::PredictOptions options;
    options.contact_lead_rad = lead_rad;
    Followed out;
    const auto take = [&](const motion::PredictedRow& row) { out.rows.push_back(row); };
    const auto prediction =
        controller::predict(program, machine_of_the_paper(), setup, control_of_the_paper(), options, take);
    EXPECT_TRUE(prediction) << to_string(prediction.error());
    if (prediction) out.prediction = *prediction;
    return out;
}

class Blend : public testing::TestWithParam<double> {};

TEST_P(Blend, OnlyYZAndAMove) {
    const Followed followed = follow(GetParam());
    for (const auto& row : followed.rows) {
        EXPECT_NEAR(row.position[0], 0, 1e-9);
        EXPECT_NEAR(row.velocity[4], 0, 1e-9);
    }
    EXPECT_GT(followed.rows.size(), 20u);
}

TEST_P(Blend, FullFeedOnTheStraightsAlmostStopsAtTheEndsOfTheBlendAboutOneMetreAMinuteOnIt) {
    const Followed followed = follow(GetParam());
    const int last = chords_within_tolerance() + 1;
    double first_top = 0, last_top = 0, blend_top = 0, blend_begin = 1e9, blend_end = 1e9, a_top = 0;
    for (const auto& row : followed.rows) {
        if (row.line == 1) first_top = std::max(first_top, row.tip_feed_mm_s);
        if (row.line == last + 1) last_top = std::max(last_top, row.tip_feed_mm_s);
        if (row.line == 2) blend_begin = std::min(blend_begin, row.tip_feed_mm_s);
        if (row.line == last) blend_end = std::min(blend_end, row.tip_feed_mm_s);
        if (row.line > 1 && row.line <= last) {
            blend_top = std::max(blend_top, row.tip_feed_mm_s);
            a_top = std::max(a_top, std::abs(row.velocity[3]));
        }
    }
    EXPECT_NEAR(first_top * 60, 5000, 1e-6);
    EXPECT_NEAR(last_top * 60, 5000, 1e-6);
    EXPECT_LT(blend_begin * 60, 100);
    EXPECT_LT(blend_end * 60, 100);
    EXPECT_NEAR(blend_top * 60, 1000, 60);
    EXPECT_NEAR(a_top * 60 / (2 * std::numbers::pi), 25, 1);
}

// Within a chord the tool turns while the tip goes straight, so that the ratio sways; the ways along the blend tell.
TEST_P(Blend, TheTipOverstatesTheFeedAtTheContact) {
    const Followed followed = follow(GetParam());
    const int last = chords_within_tolerance() + 1;
    double tip_way = 0, contact_way = 0;
    for (std::size_t i = 1; i < followed.rows.size(); ++i) {
        const auto &before = followed.rows[i - 1], &row = followed.rows[i];
        if (row.line == 1) {
            EXPECT_NEAR(row.contact_feed_mm_s, row.tip_feed_mm_s, 1e-6);
        }
        if (row.line < 2 || row.line > last) continue;
        const double duration = row.time_s - before.time_s;
        tip_way += 0.5 * duration * (before.tip_feed_mm_s + row.tip_feed_mm_s);
        contact_way += 0.5 * duration * (before.contact_feed_mm_s + row.contact_feed_mm_s);
    }
    EXPECT_NEAR(contact_way, blend_mm * 90 * degree, 0.05);
    EXPECT_NEAR(tip_way / contact_way, GetParam() > 0 ? 1.24 : 1.35, 0.01);
}

TEST_P(Blend, TheFeedDropsAreOnTheBlendAndSayWhy) {
    const Followed followed = follow(GetParam());
    ASSERT_FALSE(followed.prediction.feed_drops.empty());
    const auto worst = std::ranges::max(followed.prediction.feed_drops, {}, &motion::PredictedDrop::lost_s);
    EXPECT_EQ(worst.cause.axis, 3);  // A has its hands full; the slowest place is a transition
    EXPECT_LT(worst.s_from_mm, 60);
    EXPECT_GT(worst.s_to_mm, 66);
    EXPECT_GT(followed.prediction.uncertainty_s, 0.01);
    EXPECT_LT(followed.prediction.uncertainty_s, 0.3 * followed.prediction.cycle_time_s);
}

INSTANTIATE_TEST_SUITE_P(ConcaveAndConvex, Blend, testing::Values(1.0, -1.0));

TEST(ContactFeed, OfTheBlendAsGeometrySays) {
    // The tip goes on a circle whose radius is that of the blend lengthened by how high and far ahead it stands.
    for (const double side : {1.0, -1.0}) {
        const Touch at = blend_at(30 * degree, side);
        const double step = 1e-6;
        const Vector3d tip_velocity =
            (blend_at(30 * degree + step, side).tip() - blend_at(30 * degree - step, side).tip()) / (2 * step);
        const Vector3d turning(side, 0, 0);
        const auto contact = controller::contact_from_tip_mm(tool_of_the_paper(), at.axis(), tip_velocity, lead_rad);
        // The tip's own direction is not the contact's: the lead is told against the former, a few percent apart.
        EXPECT_NEAR(controller::contact_velocity(tip_velocity, turning, at.contact - at.tip()).norm(), blend_mm, 1e-6);
        EXPECT_NEAR(controller::contact_velocity(tip_velocity, turning, contact).norm(), blend_mm, 1e-6);
        EXPECT_NEAR(tip_velocity.norm() / blend_mm, side > 0 ? 1.24 : 1.35, 0.005);
    }
}

TEST(Blend, HasFourteenOrFifteenChords) {
    EXPECT_GE(chords_within_tolerance(), 13);
    EXPECT_LE(chords_within_tolerance(), 15);
}

// Tables 1 and 2, with atan(i/j) taken as what it has to mean: C so that Eq. 3 holds.
TEST(Table1, BothSolutionsGiveTheOrientation) {
    const auto machine = machine_of_the_paper();
    const auto kinematics = machine::Kinematics::make(machine, {}, 0).value();
    for (const double a : {10.0, 45.0, 100.0})
        for (int c = -180; c < 180; c += 15) {
            const double A = a * degree, C = c * degree;
            const Vector3d n(std::sin(C) * std::sin(A), -std::cos(C) * std::sin(A), std::cos(A));  // Eq. 3
            const auto solutions = kinematics.rotary_for(n);
            ASSERT_EQ(solutions.count, 2) << a << " " << c;
            for (const auto& solution : solutions.rotary_rad) {
                EXPECT_NEAR(std::abs(solution[0]), std::acos(n.z()), 1e-12);
                EXPECT_LT((kinematics.tool_axis(solution) - n).norm(), 1e-12);
            }
            EXPECT_NEAR(
                std::abs(std::remainder(solutions.rotary_rad[0][1] - solutions.rotary_rad[1][1], 2 * std::numbers::pi)),
                std::numbers::pi, 1e-12);
        }
}

TEST(Table2, HowManySolutionsTheRangeOfALeaves) {
    const auto machine = machine_of_the_paper();
    const auto kinematics = machine::Kinematics::make(machine, {}, 0).value();
    const auto& range = machine.axes[machine.index_of('A')];
    const auto within = [&](double tilt_rad) {
        const auto solutions = kinematics.rotary_for({0, -std::sin(tilt_rad), std::cos(tilt_rad)});
        int count = 0;
        for (int k = 0; k < solutions.count; ++k)
            count += solutions.rotary_rad[k][0] >= range.range_min - 1e-9 &&
                     solutions.rotary_rad[k][0] <= range.range_max + 1e-9;
        return count;
    };
    EXPECT_EQ(within(121 * degree), 0);  // k < −0.5
    EXPECT_EQ(within(119 * degree), 1);
    EXPECT_EQ(within(31 * degree), 1);  // k < 0.866: the positive one, A1, where the table prints A2
    EXPECT_EQ(within(29 * degree), 2);
    EXPECT_TRUE(kinematics.rotary_for({0, 0, 1}).degenerate);
}

TEST(InterpolatorCycle, TwentyMetresAMinuteAtThreeMillisecondsIsOneMillimetre) {
    auto machine = machine_of_the_paper();
    const auto control = control_of_the_paper();
    const auto top_feed = [&](double block_mm) {
        program::Program line;
        program::Move move;
        move.feed = {program::FeedRule::tip_speed, 25000.0 / 60};
        for (int k = 0; k <= static_cast<int>(300 / block_mm); ++k) {
            move.position_mm.x() = block_mm * k - 150;
            move.line = k + 1;
            line.moves.push_back(move);
        }
        auto far_sighted = control;
        far_sighted[motion::ParameterId::look_ahead_blocks].value = 1000;
        machine.axes[0].feed.jerk = 1e6;
        double top = 0;
        controller::PredictOptions options;
        options.uncertainty = false;
        EXPECT_TRUE(controller::predict(line, machine, {}, far_sighted, options, [&](const motion::PredictedRow& row) {
            top = std::max(top, row.tip_feed_mm_s);
        }));
        return top;
    };
    EXPECT_NEAR(top_feed(1), 20000.0 / 60, 1e-9);
    EXPECT_NEAR(top_feed(0.5), 10000.0 / 60, 1e-9);
    EXPECT_NEAR(top_feed(2), 25000.0 / 60, 1e-9);
}

}  // namespace
