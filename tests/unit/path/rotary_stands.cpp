#include "trunnion/path/rotary_stands.hpp"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "trunnion/geometry/great_circle.hpp"
#include "trunnion/path/path_builder.hpp"

#include "trunnion_table.hpp"

namespace trunnion::path {
namespace {

using program::Move;
using program::MoveKind;
using program::Program;
using program::RotaryStand;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
enum : int { A = 0, C = 1 };  // order of the machine's rotary axes

/// The tool axis of C on A.
Eigen::Vector3d axis_at(double a_deg, double c_deg) {
    const double a = a_deg * degree, c = c_deg * degree;
    return {std::sin(c) * std::sin(a), -std::cos(c) * std::sin(a), std::cos(a)};
}

Move vector_to(double x, double y, double z, const Eigen::Vector3d& axis) {
    Move move;
    move.position_mm = {x, y, z};
    move.axis = axis;
    move.feed = {FeedRule::tip_speed, 10};
    return move;
}
Move rapid(Move move) {
    move.kind = MoveKind::rapid;
    return move;
}
Move words(Move move, double c_deg, double a_deg) {
    move.law = OrientationLaw::rotary;
    move.rotary_rad = {c_deg * degree, a_deg * degree, 0};
    return move;
}

Program program_of(std::vector<Move> moves) {
    Program program;
    program.source = "test";
    program.rotary_letters = {'C', 'A'};
    program.moves = std::move(moves);
    for (std::size_t k = 0; k < program.moves.size(); ++k) program.moves[k].line = static_cast<int>(k) + 1;
    return program;
}

std::vector<RotaryStand> stands_of(const Program& program, const machine::Machine& machine,
                                   const machine::Setup& setup = {}) {
    const auto stands = choose_rotary_stands(program, machine, setup);
    EXPECT_TRUE(stands) << to_string(stands.error());
    return stands.value_or(std::vector<RotaryStand>(program.moves.size()));
}

void expect_at(const RotaryStand& stand, double a_deg, double c_deg) {
    EXPECT_NEAR(stand.rotary_rad[A] / degree, a_deg, 1e-7);
    EXPECT_NEAR(stand.rotary_rad[C] / degree, c_deg, 1e-7);
}

TEST(RotaryStands, words_are_literal_and_axes_without_words_stay) {
    const auto machine = trunnion_table();
    Program program = program_of({words({}, 0, 0), words({}, 111511, 10), words({}, nan, -20), words({}, -0.5, nan)});
    auto stands = stands_of(program, machine);
    expect_at(stands[1], 10, 111511);
    expect_at(stands[2], -20, 111511);
    expect_at(stands[3], -20, -0.5);
    program = program_of({words({}, nan, 5), words({}, nan, 6)});
    machine::Setup setup;
    setup.start['C'] = 33 * degree;
    stands = stands_of(program, machine, setup);
    expect_at(stands[1], 6, 33);
    program.rotary_letters = {'A'};
    program.moves[1].rotary_rad = {7 * degree};
    program.moves[0].rotary_rad = {0};
    expect_at(stands_of(program, machine, setup)[1], 7, 33);
}

TEST(RotaryStands, the_first_pose_takes_the_least_way_from_where_the_axes_stand) {
    const auto machine = trunnion_table();
    const Program program = program_of({vector_to(0, 0, 0, axis_at(20, 100)), vector_to(1, 0, 0, axis_at(20, 101))});
    expect_at(stands_of(program, machine)[0], -20, -80);
    machine::Setup setup;
    setup.start['C'] = 830 * degree;
    expect_at(stands_of(program, machine, setup)[0], 20, 820);
}

TEST(RotaryStands, takes_the_branch_inside_the_ranges) {
    auto machine = trunnion_table();
    const Program program = program_of({vector_to(0, 0, 0, axis_at(20, 30)), vector_to(1, 0, 0, axis_at(25, 30))});
    expect_at(stands_of(program, machine)[1], 25, 30);
    machine.axes[3].range_max = 22 * degree;
    expect_at(stands_of(program, machine)[0], -20, -150);
    expect_at(stands_of(program, machine)[1], -25, -150);
}

TEST(RotaryStands, takes_the_branch_on_which_the_linear_axes_stay_inside) {
    auto machine = trunnion_table();
    const Program program = program_of({vector_to(100, 0, 0, axis_at(20, 30)), vector_to(101, 0, 0, axis_at(20, 30))});
    const auto kinematics = machine::Kinematics::make(machine, {}, 0);
    const double near =
        kinematics->linear_for(Eigen::Vector3d{101, 0, 0}, machine::RotaryPosition{20 * degree, 30 * degree})[0];
    machine.axes[0].range_max = near - 1;
    expect_at(stands_of(program, machine)[1], -20, -150);
}

/// A cut in which C goes from c to c + by at A 30.
void add_cut(Program& program, double c_deg, double by_deg, int steps) {
    Move first = vector_to(0, 0, 0, axis_at(30, c_deg));
    if (!program.moves.empty()) first.kind = MoveKind::rapid;
    first.position_mm.y() = static_cast<double>(program.moves.size());
    program.moves.push_back(first);
    for (int k = 1; k <= steps; ++k)
        program.moves.push_back(vector_to(k, first.position_mm.y(), 0, axis_at(30, c_deg + by_deg * k / steps)));
    for (std::size_t k = 0; k < program.moves.size(); ++k) program.moves[k].line = static_cast<int>(k) + 1;
}

machine::Machine with_ranges(double a_min_deg, double a_max_deg, double c_deg) {
    auto machine = trunnion_table();
    machine.axes[3].range_min = a_min_deg * degree;
    machine.axes[3].range_max = a_max_deg * degree;
    machine.axes[4].range_min = -c_deg * degree;
    machine.axes[4].range_max = c_deg * degree;
    return machine;
}

TEST(RotaryStands, winds_back_on_the_rapid_before_a_cut_that_needs_the_room) {
    const auto machine = with_ranges(-5, 120, 200);
    Program program = program_of({});
    add_cut(program, 100, 60, 6);
    add_cut(program, 170, 150, 15);  // up to 320: only from −190 on it fits
    const auto stands = stands_of(program, machine);
    expect_at(stands[6], 30, 160);
    EXPECT_FALSE(stands[6].rebranched);
    expect_at(stands[7], 30, -190);
    EXPECT_TRUE(stands[7].rebranched);
    expect_at(stands.back(), 30, -40);

    Program fits = program_of({});
    add_cut(fits, 100, 60, 6);
    add_cut(fits, 170, 20, 5);  // up to 190: goes on as it stands
    const auto straight = stands_of(fits, machine);
    expect_at(straight.back(), 30, 190);
    for (const RotaryStand& stand : straight) EXPECT_FALSE(stand.rebranched);
}

TEST(RotaryStands, looks_ahead_over_retracts_for_the_least_motion) {
    // At the first pose −80° on the other branch is nearer (100° against 120°), but the next cuts want A above 0.
    const auto machine = with_ranges(-22, 120, 1e4);
    Program program = program_of({vector_to(0, 0, 0, axis_at(20, 100)), vector_to(1, 0, 0, axis_at(20, 101))});
    expect_at(stands_of(program, machine)[0], -20, -80);
    Program longer = program;
    add_cut(longer, 105, 30, 10);
    const auto stands = stands_of(longer, machine);
    expect_at(stands[0], 20, 100);
    for (const RotaryStand& stand : stands) EXPECT_FALSE(stand.rebranched);
}

TEST(RotaryStands, says_which_retract_and_turn_would_do) {
    const auto machine = with_ranges(-5, 120, 360);
    Program program = program_of({});
    add_cut(program, -170, 1000, 100);  // 10° a step; the range has 720°
    const auto stands = choose_rotary_stands(program, machine, {});
    ASSERT_FALSE(stands);
    EXPECT_EQ(stands.error().code, "PATH0102");
    // The best start is C −170: it lasts up to 360 = 53 steps, the 54th is line 55.
    EXPECT_EQ(stands.error().place.line, 55) << to_string(stands.error());
    EXPECT_NE(stands.error().text.find("axis C"), std::string::npos);
    EXPECT_NE(stands.error().hint.find("retract before line 55 (C at 360 deg), turn C by -720 deg to -360 deg"),
              std::string::npos)
        << stands.error().hint;
    EXPECT_NE(stands.error().hint.find("up to line 101"), std::string::npos) << stands.error().hint;

    // and it would: the same cut with that retract
    Program remedied = program;
    remedied.moves.insert(remedied.moves.begin() + 54, rapid(remedied.moves[53]));
    const auto good = stands_of(remedied, machine);
    expect_at(good[54], 30, -360);
    EXPECT_TRUE(good[54].rebranched);
}

TEST(RotaryStands, says_when_no_retract_would_do) {
    auto machine = with_ranges(-5, 40, 1e4);
    const Program program = program_of({vector_to(0, 0, 0, axis_at(30, 0)), vector_to(1, 0, 0, axis_at(45, 0))});
    const auto stands = choose_rotary_stands(program, machine, {});
    ASSERT_FALSE(stands);
    EXPECT_EQ(stands.error().code, "PATH0102");
    EXPECT_EQ(stands.error().place.line, 2);
    EXPECT_NE(stands.error().text.find("axis A"), std::string::npos);
    EXPECT_NE(stands.error().hint.find("no retract"), std::string::npos);
}

TEST(RotaryStands, the_free_axis_stands_as_the_next_tilted_pose_wants_it) {
    const auto machine = trunnion_table();
    const auto pole = axis_at(0, 0);
    const Program program =
        program_of({vector_to(0, 0, 9, pole), vector_to(0, 0, 0, pole), vector_to(5, 0, 0, axis_at(10, 40)),
                    rapid(vector_to(5, 0, 9, pole)), vector_to(5, 0, 0, pole), vector_to(9, 0, 0, axis_at(10, 70)),
                    rapid(vector_to(9, 0, 9, pole))});
    const auto stands = stands_of(program, machine);
    expect_at(stands[0], 0, 40);
    expect_at(stands[1], 0, 40);
    expect_at(stands[2], 10, 40);
    expect_at(stands[3], 0, 70);
    EXPECT_TRUE(stands[3].rebranched);
    expect_at(stands[4], 0, 70);
    expect_at(stands[5], 10, 70);
    expect_at(stands[6], 0, 70);  // nothing follows: it stays
    EXPECT_FALSE(stands[6].rebranched);
}

TEST(RotaryStands, the_free_axis_turns_along_a_move_at_the_pole_in_a_cut) {
    const auto machine = trunnion_table();
    const auto pole = axis_at(0, 0);
    const Program program = program_of({vector_to(0, 0, 0, axis_at(10, 40)), vector_to(5, 0, 0, pole),
                                        vector_to(10, 0, 0, pole), vector_to(15, 0, 0, axis_at(10, 70))});
    const auto stands = stands_of(program, machine);
    expect_at(stands[1], 0, 40);
    expect_at(stands[2], 0, 70);
    EXPECT_TRUE(stands[2].rebranched);
    expect_at(stands[3], 10, 70);
    const machine::Setup setup;
    auto builder = PathBuilder::make(program, machine, setup, stands);
    std::vector<OrientationLaw> laws;
    for (path::Run run; builder->next(run).value();) laws.push_back(run.law);
    EXPECT_EQ(laws, (std::vector{OrientationLaw::vector, OrientationLaw::rotary, OrientationLaw::vector}));
}

TEST(RotaryStands, straight_through_the_pole_changes_the_branch_and_a_corner_there_does_not) {
    const auto machine = trunnion_table();
    const auto pole = axis_at(0, 0);
    Program program = program_of(
        {vector_to(0, 0, 0, axis_at(10, 40)), vector_to(5, 0, 0, pole), vector_to(10, 0, 0, axis_at(-10, 40))});
    expect_at(stands_of(program, machine)[2], -10, 40);
    program.moves[1].axis = axis_at(-3, 40);  // the pole within a block
    expect_at(stands_of(program, machine)[2], -10, 40);
    program.moves[1].axis = pole;
    program.moves[2].axis = axis_at(-10, 50);
    expect_at(stands_of(program, machine)[2], 10, -130);
}

TEST(RotaryStands, laws_may_change_inside_a_program) {
    const auto machine = trunnion_table();
    Move home = rapid({});
    home.space = Space::machine;
    home.position_mm = {nan, nan, 500};
    const Program program =
        program_of({words({}, 400, -30), words(vector_to(5, 0, 0, axis_at(0, 0)), 405, -30),
                    vector_to(10, 0, 0, axis_at(-35, 410)), home, rapid(vector_to(0, 0, 50, axis_at(-35, 50))),
                    vector_to(0, 0, 0, axis_at(-35, 60)), words(vector_to(1, 0, 0, axis_at(0, 0)), 430, -40)});
    const auto stands = stands_of(program, machine);
    expect_at(stands[1], -30, 405);
    expect_at(stands[2], -35, 410);  // on the branch and winding where the words left the axes
    expect_at(stands[3], -35, 410);  // no word: they stay
    expect_at(stands[5], -35, 420);
    expect_at(stands[6], -40, 430);
}

TEST(RotaryStands, rapids_with_opposite_tool_axes_turn_the_axes_themselves) {
    const auto machine = trunnion_table();
    Program program = program_of({vector_to(0, 0, 0, axis_at(90, 0)), rapid(vector_to(0, 0, 9, axis_at(-90, 0)))});
    const auto stands = stands_of(program, machine);
    EXPECT_TRUE(stands[1].rebranched);
    program.moves[1].kind = MoveKind::feed;
    const auto refused = choose_rotary_stands(program, machine, {});
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, "PATH0005");
    EXPECT_EQ(refused.error().place.line, 2);
}

TEST(RotaryStands, refuses_what_cannot_be_reached_or_named) {
    auto machine = trunnion_table();
    EXPECT_EQ(choose_rotary_stands(Program{}, machine, {}).error().code, "PATH0001");
    Program surfaces = program_of({words({}, 0, 0)});
    surfaces.surface_jobs.emplace_back();
    EXPECT_EQ(choose_rotary_stands(surfaces, machine, {}).error().code, "PATH0011");
    Program program = program_of({words({}, 0, 0)});
    program.rotary_letters = {'B'};
    EXPECT_EQ(choose_rotary_stands(program, machine, {}).error().code, "PATH0006");
    machine.axis_count = 4;  // C is gone
    machine.rotary_count = 1;
    machine.chain = {3, 0, 1, 2};
    program = program_of({vector_to(0, 0, 0, axis_at(10, 0)), vector_to(1, 0, 0, axis_at(10, 30))});
    program.rotary_letters = {};
    const auto refused = choose_rotary_stands(program, machine, {});
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, "PATH0101");
    EXPECT_EQ(refused.error().place.line, 2);
}

/// 40 mm along X while the tool tilts from −tilt to tilt and passes the pole so far aside.
std::vector<Move> past_pole(double tilt_deg, double aside_deg, int blocks = 40) {
    std::vector<Move> moves;
    for (int k = 0; k <= blocks; ++k) {
        const double tilt = tilt_deg * degree * (2.0 * k / blocks - 1), aside = aside_deg * degree;
        moves.push_back(
            vector_to(40.0 * k / blocks, 0, 0,
                      {std::sin(tilt) * std::cos(aside), std::sin(aside), std::cos(tilt) * std::cos(aside)}));
    }
    return moves;
}

double turn_of_c(const std::vector<RotaryStand>& stands) {
    double out = 0;
    for (std::size_t k = 1; k < stands.size(); ++k)
        out += std::abs(stands[k].rotary_rad[C] - stands[k - 1].rotary_rad[C]);
    return out / degree;
}

std::vector<RotaryStand> stands_with_tolerance(const Program& program, const machine::Machine& machine,
                                               double tolerance_deg) {
    const auto stands = choose_rotary_stands(program, machine, {}, tolerance_deg * degree);
    EXPECT_TRUE(stands) << to_string(stands.error());
    return stands.value_or(std::vector<RotaryStand>(program.moves.size()));
}

void expect_same(const std::vector<RotaryStand>& a, const std::vector<RotaryStand>& b) {
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t k = 0; k < a.size(); ++k)
        for (int axis = 0; axis < 2; ++axis) EXPECT_NEAR(a[k].rotary_rad[axis], b[k].rotary_rad[axis], 1e-9) << k;
}

TEST(RotaryStands, go_through_the_pole_where_it_is_passed_within_the_tolerance) {
    const auto machine = trunnion_table();
    for (const int blocks : {1, 2, 40, 400}) {
        const Program program = program_of(past_pole(10, 0.05, blocks));
        const auto around = stands_with_tolerance(program, machine, 0),
                   through = stands_with_tolerance(program, machine, 0.08);
        EXPECT_NEAR(turn_of_c(around), 180, 1) << blocks;
        EXPECT_NEAR(std::abs(through.back().rotary_rad[C] - through.front().rotary_rad[C]) / degree, 0.57, 0.05)
            << blocks;
        EXPECT_NEAR(through.back().rotary_rad[A], -through.front().rotary_rad[A], 1e-3) << blocks;
        expect_same(stands_with_tolerance(program, machine, 0.049), around);
        const auto kinematics = machine::Kinematics::make(machine, {}, 0);
        for (std::size_t k = 0; k < program.moves.size(); ++k)  // at the programmed poses
            EXPECT_NEAR((kinematics->tool_axis(through[k].rotary_rad) - program.moves[k].axis).norm(), 0, 1e-12);
    }
}

TEST(RotaryStands, go_around_the_pole_where_ranges_words_or_a_stop_want_it) {
    auto machine = trunnion_table();
    Program program = program_of(past_pole(10, 0.05));
    program.moves[20].exact_stop = true;  // the tool stands still beside the pole, at the programmed pose
    expect_same(stands_with_tolerance(program, machine, 0.08), stands_with_tolerance(program, machine, 0));
    program.moves[20].exact_stop = false;
    const auto around = stands_with_tolerance(program, machine, 0);
    const auto at = [&](const RotaryStand& stand, double x) {
        return words(vector_to(x, 0, 0, Eigen::Vector3d::UnitZ()), stand.rotary_rad[C] / degree,
                     stand.rotary_rad[A] / degree);
    };
    Program between_words = program;  // which say how the axes stand on both sides
    between_words.moves.front() = at(around.front(), 0);
    between_words.moves.push_back(at(around.back(), 50));
    expect_same(stands_with_tolerance(between_words, machine, 0.08), stands_with_tolerance(between_words, machine, 0));
    between_words.moves.pop_back();
    const auto after_words = stands_with_tolerance(between_words, machine, 0.08);
    EXPECT_NEAR(after_words.front().rotary_rad[C], after_words.back().rotary_rad[C], 2 * degree);
    machine.axes[3].range_min = -9 * degree;  // room for A on one side only
    expect_same(stands_with_tolerance(program, machine, 0.08), stands_with_tolerance(program, machine, 0));
}

TEST(RotaryStands, are_not_led_to_the_pole_where_the_tool_turns_back_beside_it) {
    const auto machine = trunnion_table();
    const auto tilted = [](double x, double tilt_deg, double beside_deg) {
        const Eigen::Vector3d axis(std::sin(tilt_deg * degree), std::sin(beside_deg * degree), 1);
        return vector_to(x, 0, 0, axis.normalized());
    };
    for (const double least : {-0.01, 0.0, 0.01}) {
        std::vector<Move> moves;
        for (int k = 0; k <= 40; ++k) moves.push_back(tilted(k, least + 0.5 * std::abs(k - 20), 0.03));
        const auto around = stands_with_tolerance(program_of(moves), machine, 0);
        expect_same(stands_with_tolerance(program_of(moves), machine, 0.08), around);
        EXPECT_GT(std::abs(around.back().rotary_rad[A]), 5 * degree);
        EXPECT_NEAR(around.front().rotary_rad[A], around.back().rotary_rad[A], 1e-9) << "no change of the branch";
    }
}

TEST(RotaryStands, choose_at_every_passage_by_itself) {
    const auto machine = trunnion_table();
    Program program = program_of(past_pole(10, 0.05));
    auto back = past_pole(-10, 0.2), again = past_pole(10, -0.03);  // the second passage is out of tolerance
    for (std::size_t k = 1; k < back.size(); ++k) program.moves.push_back(back[k]);
    for (std::size_t k = 1; k < again.size(); ++k) program.moves.push_back(again[k]);
    const auto stands = stands_with_tolerance(program, machine, 0.08);
    const auto turn = [&](std::size_t from, std::size_t to) {
        return std::abs(stands[to].rotary_rad[C] - stands[from].rotary_rad[C]) / degree;
    };
    EXPECT_LT(turn(0, 40), 2);
    EXPECT_GT(turn(41, 79), 170);
    EXPECT_LT(turn(81, 120), 3);
}

/// xorshift64*: the same numbers on every machine.
class Random {
  public:
    explicit Random(std::uint64_t seed) : state_(seed * 0x9E3779B97F4A7C15u + 1) {}
    double between(double low, double high) {
        state_ ^= state_ >> 12;
        state_ ^= state_ << 25;
        state_ ^= state_ >> 27;
        return low + (high - low) * static_cast<double>((state_ * 0x2545F4914F6CDD1Du) >> 11) * 0x1p-53;
    }

  private:
    std::uint64_t state_;
};

TEST(RotaryStands, random_programs_go_on_without_a_jump_inside_the_ranges) {
    const auto machine = with_ranges(-100, 100, 400);
    const auto kinematics = machine::Kinematics::make(machine, {}, 0);
    int chosen = 0;
    for (std::uint64_t seed = 1; seed <= 60; ++seed) {
        Random random(seed);
        Program program = program_of({});
        double a = random.between(-90, 90), c = random.between(-180, 180);
        for (int k = 0; k < 40; ++k) {
            Move move = vector_to(k, 0, 0, axis_at(a, c));
            if (random.between(0, 1) < 0.2) move.kind = MoveKind::rapid;
            program.moves.push_back(move);
            a = std::clamp(a + random.between(-30, 30), -95.0, 95.0);
            c += random.between(-40, 40);
        }
        const auto stands = choose_rotary_stands(program, machine, {});
        if (!stands) {
            EXPECT_EQ(stands.error().code, "PATH0102") << seed;
            continue;
        }
        ++chosen;
        for (std::size_t k = 0; k < program.moves.size(); ++k) {
            const auto& stand = (*stands)[k];
            EXPECT_LT((kinematics->tool_axis(stand.rotary_rad) - program.moves[k].axis).norm(), 1e-12) << seed;
            for (int axis = 0; axis < 2; ++axis) {
                EXPECT_GE(stand.rotary_rad[axis], machine.axes[3 + axis].range_min - 1e-9) << seed;
                EXPECT_LE(stand.rotary_rad[axis], machine.axes[3 + axis].range_max + 1e-9) << seed;
            }
            if (k == 0 || stand.rebranched) continue;
            constexpr int steps = 2000;
            machine::RotaryPosition at = (*stands)[k - 1].rotary_rad;
            double largest = 0;
            for (int s = 1; s <= steps; ++s) {
                const auto n = geometry::slerp(program.moves[k - 1].axis, program.moves[k].axis, 1.0 * s / steps);
                const auto next = kinematics->rotary_series({n.x(), n.y(), n.z()}, at);
                for (int axis = 0; axis < 2; ++axis)
                    largest = std::max(largest, std::abs(next[axis].value() - at[axis]));
                at = {next[0].value(), next[1].value()};
            }
            if (largest > 45 * degree) continue;  // too close to the pole for this reference
            for (int axis = 0; axis < 2; ++axis)
                EXPECT_NEAR(at[axis], stand.rotary_rad[axis], 1e-9) << seed << " " << k;
        }
    }
    EXPECT_GT(chosen, 30);
}

}  // namespace
}  // namespace trunnion::path
