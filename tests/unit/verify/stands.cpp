#include <gtest/gtest.h>

#include "trunnion/verify/programmed_csv.hpp"

#include "made_programs.hpp"

/// Moves whose start or end depends on where the machine stands.
namespace trunnion::verify::test {
namespace {

constexpr double not_said = std::numeric_limits<double>::quiet_NaN();

Move untransformed(Eigen::Vector3d position, double a, double c, std::int32_t line) {
    Move out = by_words(position, a, c, line);
    out.space = Space::untransformed;
    return out;
}

Move in_machine(Eigen::Vector3d position, double a, double c, std::int32_t line) {
    Move out = by_words(position, a, c, line);
    out.space = Space::machine;
    return out;
}

program::RotaryStand stand(double a, double c, bool rebranched = false) {
    return {.rotary_rad = {a, c}, .rebranched = rebranched};
}

/// The machine counts X and Z the other way; the workpiece is turned and moved, the tool 60 mm long, G55 elsewhere.
machine::Machine mirrored() {
    auto out = peer_trunnion();
    out.axes[0].reversed = out.axes[2].reversed = true;
    return out;
}

machine::Setup turned_setup() {
    machine::Setup out;
    out.workpiece.origin_mm = {11, -7, 50};
    out.workpiece.rotation = Eigen::AngleAxisd(30 * degree, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    out.tool.length_mm = 60;
    out.offsets["G55"] = {.origin_mm = {5, 6, 7},
                          .rotation = Eigen::AngleAxisd(90 * degree, Eigen::Vector3d::UnitX()).toRotationMatrix()};
    return out;
}

Program at_g55(std::vector<Move> moves) {
    auto out = program_of(std::move(moves));
    out.offsets = {"", "G55"};
    for (Move& move : out.moves) move.offset = 1;
    return out;
}

/// Tip in the workpiece of linear axes (ISO 841 count) and table angles, by hand.
Eigen::Vector3d tip_of(const Eigen::Vector3d& linear, double a, double c, const machine::Setup& setup) {
    const Eigen::Vector3d tip = linear - Eigen::Vector3d(0, 0, setup.tool.length_mm);
    return setup.workpiece.rotation.transpose() * (table_to_machine(a, c) * tip - setup.workpiece.origin_mm);
}

/// Linear axes (ISO 841 count) at which the tip is at a place of G55 with all rotary axes at 0.
Eigen::Vector3d linear_of(const Eigen::Vector3d& in_offset, const machine::Setup& setup) {
    const auto& g55 = setup.offsets.at("G55");
    const Eigen::Vector3d in_workpiece = g55.rotation * in_offset + g55.origin_mm;
    return setup.workpiece.rotation * in_workpiece + setup.workpiece.origin_mm +
           Eigen::Vector3d(0, 0, setup.tool.length_mm);
}

TEST(UntransformedMoves, AreTheTipInTheWorkOffsetWhereTheRotaryAxesAreAtZero) {
    const auto setup = turned_setup();
    const auto poses =
        poses_of(at_g55({untransformed({1, 2, 3}, 0, 0, 1), untransformed({4, -5, 6}, 0, 0, 2)}), setup, mirrored());
    ASSERT_EQ(poses.size(), 2u);
    EXPECT_LT((poses[1].tip_mm - Eigen::Vector3d(5 + 4, 6 - 6, 7 - 5)).norm(), 1e-12);
    EXPECT_EQ(poses[1].kind, PoseKind::vector);
}

TEST(UntransformedMoves, AreMachineAxesWhereTheRotaryAxesAreTurned) {
    const auto setup = turned_setup();
    const double a = 35 * degree, c = -50 * degree;
    const auto poses =
        poses_of(at_g55({untransformed({1, 2, 3}, 0, 0, 1), untransformed({4, -5, 6}, a, c, 2)}), setup, mirrored());
    EXPECT_LT((poses.back().tip_mm - tip_of(linear_of({4, -5, 6}, setup), a, c, setup)).norm(), 1e-12);
    EXPECT_LT((poses.back().axis - setup.workpiece.rotation.transpose() * axis_of(a, c)).norm(), 1e-12);
    ASSERT_GT(poses.size(), 50u);
    for (std::size_t n = 1; n < poses.size(); ++n) {
        const double w = poses[n].rotary_rad[0] / a;
        const Eigen::Vector3d linear = linear_of({1 + 3 * w, 2 - 7 * w, 3 + 3 * w}, setup);
        EXPECT_LT((poses[n].tip_mm - tip_of(linear, w * a, w * c, setup)).norm(), 1e-9);
    }
}

TEST(UntransformedMoves, GoRoundInTheirOwnFrame) {
    const auto setup = turned_setup();
    const double a = 35 * degree, c = -50 * degree;
    auto program = at_g55({untransformed({10, 0, 3}, a, c, 1), untransformed({0, 10, 3}, a, c, 2)});
    program.arcs = {{.centre_mm = {0, 0, 0}, .normal = {0, 0, 1}, .angle_rad = 90 * degree}};
    program.moves[1].arc = 0;
    const auto poses = poses_of(program, setup, mirrored());
    ASSERT_GT(poses.size(), 100u);
    for (std::size_t n = 0; n < poses.size(); ++n) {
        const double w = 90 * degree * static_cast<double>(n) / static_cast<double>(poses.size() - 1);
        const Eigen::Vector3d linear = linear_of({10 * std::cos(w), 10 * std::sin(w), 3}, setup);
        EXPECT_LT((poses[n].tip_mm - tip_of(linear, a, c, setup)).norm(), 1e-9);
    }
}

/// The same place in every space; a coordinate that is not said keeps the value it has there.
TEST(OpenCoordinates, StayInTheSpaceOfTheMove) {
    const auto setup = turned_setup();
    const double a = 35 * degree, c = -50 * degree;
    const Eigen::Vector3d linear = linear_of({4, -5, 6}, setup);
    const auto& g55 = setup.offsets.at("G55");
    const Eigen::Vector3d in_g55 =
        g55.rotation.transpose() * (tip_of(linear, a, c, setup) - g55.origin_mm);  // of the tip, axes turned
    auto one = untransformed({not_said, not_said, 8}, a, c, 2);
    auto poses = poses_of(at_g55({untransformed({4, -5, 6}, a, c, 1), one}), setup, mirrored());
    EXPECT_LT((poses.back().tip_mm - tip_of(linear_of({4, -5, 8}, setup), a, c, setup)).norm(), 1e-11);

    one = in_machine({not_said, 123, not_said}, a, c, 2);
    poses = poses_of(at_g55({untransformed({4, -5, 6}, a, c, 1), one}), setup, mirrored());
    EXPECT_LT((poses.back().tip_mm - tip_of({linear.x(), 123, linear.z()}, a, c, setup)).norm(), 1e-11);

    one = by_words({1, not_said, not_said}, a, c, 2);
    poses = poses_of(at_g55({untransformed({4, -5, 6}, a, c, 1), one}), setup, mirrored());
    const Eigen::Vector3d expected = g55.rotation * Eigen::Vector3d(1, in_g55.y(), in_g55.z()) + g55.origin_mm;
    EXPECT_LT((poses.back().tip_mm - expected).norm(), 1e-11);

    EXPECT_EQ(code_of(at_g55({one}), setup, mirrored()), "VER0108");  // nothing to stay at
    one.position_mm.y() = HUGE_VAL;
    EXPECT_EQ(code_of(at_g55({untransformed({4, -5, 6}, a, c, 1), one}), setup, mirrored()), "VER0108");
}

TEST(OpenCoordinates, AreTakenWithTheNewTool) {
    auto program = program_of({by_words({1, 2, 3}, 30 * degree, 0, 1), by_words({5, not_said, 3}, 30 * degree, 0, 2)});
    program.tools = {"", "8", "9"};
    program.moves[0].tool = 1, program.moves[1].tool = 2;
    auto setup = peer_setup();
    setup.tools["8"].length_mm = 100, setup.tools["9"].length_mm = 120;
    const auto poses = poses_of(program, setup);
    EXPECT_NEAR(poses.back().tip_mm.y(), 2 - 20 * axis_of(30 * degree, 0).y(), 1e-12);
}

TEST(ToolNames, EdgesAndNoEdge) {
    auto program =
        program_of({by_words({0, 0, 0}, 0, 0, 1), by_words({0, 0, 0}, 0, 0, 2), by_words({0, 0, 0}, 0, 0, 3)});
    program.tools = {"", "8", "8 D2", "8 D0"};
    for (std::uint16_t n = 0; n < 3; ++n) program.moves[n].tool = n + 1;
    auto setup = peer_setup();
    setup.tools["8"] = {.kind = machine::ToolKind::ball, .diameter_mm = 6, .length_mm = 100, .controls_centre = true};
    EXPECT_EQ(code_of(program, setup), "VER0103");
    setup.tools["8 D2"].length_mm = 90;
    const auto poses = poses_of(program, setup);
    ASSERT_EQ(poses.size(), 5u);
    EXPECT_EQ(poses[0].tool_length_mm, 100);
    EXPECT_EQ(poses[0].controlled_height_mm, 3);
    EXPECT_EQ(poses[1].tool_length_mm, 90);
    EXPECT_EQ(poses[1].controlled_height_mm, 0);
    EXPECT_EQ(poses[3].tool_length_mm, 0);
    EXPECT_NEAR(poses[3].tip_mm.z(), 90, 1e-12);
    // without any table [tool] is the first tool called, D0 none at all
    setup.tools.clear();
    setup.tool.length_mm = 70;
    program.tools = {"", "8 D0", "8", "8 D0"};
    const auto bare = poses_of(program, setup);
    EXPECT_EQ(bare[0].tool_length_mm, 0);
    EXPECT_EQ(bare[2].tool_length_mm, 70);
}

TEST(ToolNames, EveryToolHasItsOwnControlledPoint) {
    const double lean = 0.05 * degree, radius = 30;
    auto program = program_of({by_words({0, 0, 0}, 0, 0, 1), by_words({10, 0, 0}, 0, 0, 2),
                               by_words({10, 0, 0}, 0, 0, 3), by_words({20, 0, 0}, 0, 0, 4)});
    program.tools = {"", "flat", "ball"};
    auto setup = peer_setup();
    setup.tools["flat"] = {};
    setup.tools["ball"] = {.kind = machine::ToolKind::ball, .diameter_mm = 2 * radius, .controls_centre = true};
    // the tool leans from the middle on, its ball's centre where it should be
    const Eigen::Vector3d off = radius * (Eigen::Vector3d::UnitZ() - axis_of(lean, 0));
    auto rows = along({{0, 0, 0}, {10, 0, 0}}, 0.05).rows;
    for (const auto& leaning :
         along({Eigen::Vector3d(10, 0, 0) + off, Eigen::Vector3d(20, 0, 0) + off}, 0.05, lean).rows)
        rows.push_back(row(rows.size(), leaning.position));
    const auto verdict = [&](std::uint16_t first, std::uint16_t second) {
        for (std::uint16_t n = 0; n < 4; ++n) program.moves[n].tool = n < 2 ? first : second;
        auto poses = poses_of(program, setup);
        for (auto& pose : poses) pose.literal = false;
        return *check(*setpoint_table(rows), poses, boundless(), setup, {});
    };
    EXPECT_LT(verdict(1, 2).tip_deviation_mm, 1e-9);
    EXPECT_NEAR(verdict(1, 1).tip_deviation_mm, off.norm(), 1e-5);
    EXPECT_LT(verdict(2, 2).tip_deviation_mm, 1e-9);
    EXPECT_NEAR(verdict(2, 1).tip_deviation_mm, off.norm(), 1e-5);
}

struct LawChange : testing::Test {
    const double a = 30 * degree, c = 70 * degree;
    /// Vectors, then words.
    Program program = program_of({by_vector({0, 0, 0}, {0, 0, 1}, 1), by_vector({10, 0, 0}, axis_of(a, c), 2),
                                  by_words({20, 0, 0}, 40 * degree, 20 * degree, 3)});
    Stands stands{stand(0, c), stand(a, c), stand(40 * degree, 20 * degree)};
    std::string code(const Stands& s) const { return code_of(program, peer_setup(), peer_trunnion(), s); }
};

TEST_F(LawChange, WordsBeginWhereTheAxesStand) {
    const auto poses = poses_of(program, peer_setup(), peer_trunnion(), stands);
    ASSERT_EQ(poses.size(), 3u);
    EXPECT_TRUE(std::isnan(poses[0].rotary_rad[0]));
    EXPECT_EQ(poses[1].kind, PoseKind::vector);
    EXPECT_FALSE(poses[1].literal);
    EXPECT_EQ(poses[1].rotary_rad[1], c);
    EXPECT_EQ(poses[2].kind, PoseKind::rotary);
    EXPECT_TRUE(poses[2].literal);
    const auto text = programmed_csv(poses, peer_trunnion());
    EXPECT_NE(text.find("vector,1,,\n"), std::string::npos) << text;
    const auto back = read_programmed_csv(text, peer_trunnion());
    ASSERT_TRUE(back);
    EXPECT_TRUE(std::isnan((*back)[0].rotary_rad[0]));
    EXPECT_NEAR((*back)[1].rotary_rad[1], c, 1e-15);
    EXPECT_FALSE((*back)[1].literal);
    EXPECT_TRUE((*back)[2].literal);
}

TEST_F(LawChange, AxesWithoutAWordStayWhereTheyStand) {
    program.moves[2].rotary_rad[0] = not_said;
    EXPECT_EQ(code(stands), "VER0110");  // they say that A moves
    stands[2].rotary_rad[0] = a;
    const auto poses = poses_of(program, peer_setup(), peer_trunnion(), stands);
    EXPECT_LT((poses[2].axis - axis_of(a, 20 * degree)).norm(), 1e-12);
    program.rotary_letters = {'C'};
    program.moves[2].rotary_rad = {20 * degree, 0, 0};
    EXPECT_EQ(code(stands), "none");
    EXPECT_EQ(code({}), "VER0106");
}

TEST_F(LawChange, StandsAreNotTakenOnTrust) {
    EXPECT_EQ(code(stands), "none");
    EXPECT_EQ(code({}), "VER0106");
    EXPECT_EQ(code({stands[0], stands[1]}), "VER0110");
    const auto changed = [&](std::size_t move, std::size_t axis, double by) {
        auto out = stands;
        out[move].rotary_rad[axis] += by;
        return code(out);
    };
    EXPECT_EQ(changed(0, 1, 1), "none");  // C is free at the pole
    EXPECT_EQ(changed(1, 1, 360 * degree), "none");
    EXPECT_EQ(changed(1, 1, 1e-5), "VER0110");
    EXPECT_EQ(changed(1, 0, 3e-6), "VER0110");
    EXPECT_EQ(changed(1, 0, 1e-6), "none");
    EXPECT_EQ(changed(2, 1, 360 * degree), "VER0110");
    EXPECT_EQ(changed(2, 1, 1e-8), "VER0110");
    EXPECT_EQ(changed(1, 0, NAN), "VER0108");
    stands[1].rotary_rad = {-a, c + 180 * degree};  // the other branch
    EXPECT_EQ(code(stands), "none");
}

TEST_F(LawChange, OnlyRapidsByVectorsGoToAnotherBranch) {
    stands[1] = stand(-a, c + 180 * degree, true);
    EXPECT_EQ(code(stands), "VER0110");
    program.moves[1].kind = program::MoveKind::rapid;
    const auto poses = poses_of(program, peer_setup(), peer_trunnion(), stands);
    EXPECT_EQ(poses[1].kind, PoseKind::rotary);
    EXPECT_TRUE(poses[1].at_rapid);
    EXPECT_FALSE(poses[1].literal);
    EXPECT_EQ(poses[0].rotary_rad[1], c);
    EXPECT_EQ(poses[1].rotary_rad[1], c + 180 * degree);
    stands[1].rebranched = false;
    stands[2].rebranched = true;
    EXPECT_EQ(code(stands), "VER0110");
}

TEST_F(LawChange, MovesInMachineAxesBeginWhereTheAxesStand) {
    program.moves[2] = in_machine({40, 50, 60}, 40 * degree, 20 * degree, 3);
    const auto poses = poses_of(program, peer_setup(), peer_trunnion(), stands);
    ASSERT_GT(poses.size(), 50u);
    const auto from = axes_for({10, 0, 0}, a, c);
    for (std::size_t n = 2; n < poses.size(); ++n) {
        const double w = (poses[n].rotary_rad[1] - c) / (20 * degree - c);
        Eigen::Vector3d linear;
        for (int i = 0; i < 3; ++i) linear[i] = from[i] + w * (Eigen::Vector3d(40, 50, 60)[i] - from[i]);
        const auto turn = table_to_machine(a + w * (40 * degree - a), c + w * (20 * degree - c));
        EXPECT_LT((poses[n].tip_mm - (turn * linear - Eigen::Vector3d(0, 0, 50))).norm(), 1e-9);
    }
    EXPECT_EQ(code({}), "VER0106");
    // without a word the axes stay, and so does the tool axis
    program.moves[2].rotary_rad = {not_said, not_said, 0};
    stands[2].rotary_rad = {a, c};
    EXPECT_LT((poses_of(program, peer_setup(), peer_trunnion(), stands).back().axis - axis_of(a, c)).norm(), 1e-12);
}

TEST_F(LawChange, VectorsAfterWordsNeedNoStands) {
    program.moves = {by_words({0, 0, 0}, a, c, 1), by_vector({10, 0, 0}, {0, 0, 1}, 2)};
    EXPECT_EQ(code({}), "none");
}

TEST(Standstills, AreWhereTheProgramAsksForThem) {
    auto program = program_of({by_words({0, 0, 0}, 0, 0, 1), by_words({1, 0, 0}, 0, 0, 2), by_words({2, 0, 0}, 0, 0, 3),
                               by_words({3, 0, 0}, 0, 0, 4), by_words({4, 0, 0}, 0, 0, 5), by_words({5, 0, 0}, 0, 0, 6),
                               by_words({6, 0, 0}, 0, 0, 7)});
    program.moves[2].exact_stop = true;
    program.moves[5].kind = program::MoveKind::rapid;
    program::Event event;
    event.before_move = 4;
    program.events = {event};
    std::string stops;
    const auto seen = [&] {
        stops.clear();
        for (const auto& pose : poses_of(program)) stops += pose.stands ? '|' : '.';
        return stops;
    };
    EXPECT_EQ(seen(), "|.|.|||");
    program.events[0].stops_motion = true;
    EXPECT_EQ(seen(), "|.|||||");
}

}  // namespace
}  // namespace trunnion::verify::test
