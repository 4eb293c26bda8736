#include "trunnion/verify/programmed_path.hpp"

#include <gtest/gtest.h>

#include "trunnion/verify/programmed_csv.hpp"

#include "made_programs.hpp"

namespace trunnion::verify::test {
namespace {

TEST(ProgrammedPath, RotaryWordsBecomeAxes) {
    const auto poses = poses_of(
        program_of({by_words({0, 0, 0}, -20 * degree, 0, 4), by_words({50, 0, 0}, -25 * degree, 10 * degree, 5)}));
    ASSERT_EQ(poses.size(), 2u);
    // figures of ISO 841 for chain C A, both counted the other way: i = sin C sin A, j = cos C sin A, k = cos A
    EXPECT_NEAR(poses[0].axis.y(), std::sin(-20 * degree), 1e-15);
    EXPECT_NEAR(poses[1].axis.x(), std::sin(10 * degree) * std::sin(-25 * degree), 1e-15);
    EXPECT_NEAR(poses[1].axis.y(), std::cos(10 * degree) * std::sin(-25 * degree), 1e-15);
    EXPECT_NEAR(poses[1].axis.z(), std::cos(25 * degree), 1e-15);
    EXPECT_EQ(poses[1].kind, PoseKind::rotary);
    EXPECT_EQ(poses[1].line, 5);
    EXPECT_EQ(poses[1].rotary_rad[1], 10 * degree);
}

TEST(ProgrammedPath, KindsOfRapids) {
    auto words = by_words({0, 0, 0}, 0, 0, 1);
    words.kind = program::MoveKind::rapid;
    auto vector = by_vector({0, 0, 0}, {0, 0, 1}, 1);
    vector.kind = program::MoveKind::rapid;
    EXPECT_EQ(poses_of(program_of({words}))[0].kind, PoseKind::rotary);
    EXPECT_TRUE(poses_of(program_of({words}))[0].at_rapid);
    EXPECT_EQ(poses_of(program_of({vector}))[0].kind, PoseKind::rapid);
    EXPECT_TRUE(std::isnan(poses_of(program_of({vector}))[0].rotary_rad[0]));
}

TEST(ProgrammedPath, AxesThatAreNotNamedStandAtTheStart) {
    auto program = program_of({by_words({0, 0, 0}, 30 * degree, 0, 1)});
    program.rotary_letters = {'A'};
    auto setup = peer_setup();
    EXPECT_NEAR(poses_of(program, setup)[0].axis.y(), 0.5, 1e-15);
    setup.start['C'] = 90 * degree;
    EXPECT_NEAR(poses_of(program, setup)[0].axis.x(), 0.5, 1e-15);
    EXPECT_EQ(poses_of(program, setup)[0].rotary_rad[1], 90 * degree);
}

TEST(ProgrammedPath, WorkOffsets) {
    auto program = program_of({by_vector({1, 0, 0}, {1, 0, 1}, 1), by_vector({1, 0, 0}, {1, 0, 1}, 2)});
    program.offsets = {"", "G54", "G54.1 P3"};
    program.moves[0].offset = 1;
    program.moves[1].offset = 2;
    const auto lacking = programmed_poses(program, peer_trunnion(), peer_setup());
    ASSERT_FALSE(lacking);
    EXPECT_EQ(lacking.error().code, "VER0104");
    EXPECT_EQ(lacking.error().hint, "add [offsets.\"G54.1 P3\"] to the setup file");  // as TOML takes it
    program.offsets[2] = "G55";
    auto setup = peer_setup();
    machine::Frame quarter{.origin_mm = {10, 20, 30},
                           .rotation = Eigen::AngleAxisd(90 * degree, Eigen::Vector3d::UnitZ()).toRotationMatrix()};
    setup.offsets["G55"] = quarter;
    const auto poses = poses_of(program, setup);
    EXPECT_LT((poses[0].tip_mm - Eigen::Vector3d(1, 0, 0)).norm(), 1e-12);
    EXPECT_LT((poses[1].tip_mm - Eigen::Vector3d(10, 21, 30)).norm(), 1e-12);
    EXPECT_LT((poses[1].axis - Eigen::Vector3d(0, 1, 1).normalized()).norm(), 1e-12);
    setup.offsets["G54"] = quarter;
    EXPECT_LT((poses_of(program, setup)[0].tip_mm - Eigen::Vector3d(10, 21, 30)).norm(), 1e-12);
}

TEST(ProgrammedPath, ToolsOfTheSetup) {
    auto program = program_of({by_words({0, 0, 0}, 30 * degree, 0, 1), by_words({0, 0, 0}, 30 * degree, 0, 2)});
    program.tools = {"", "8", "9"};
    program.moves[0].tool = program.moves[1].tool = 1;
    auto setup = peer_setup();
    setup.tool.length_mm = 70;
    EXPECT_EQ(poses_of(program, setup).back().tool_length_mm, 70);  // the first one named
    program.moves[1].tool = 2;
    EXPECT_EQ(code_of(program, setup), "VER0103");
    setup.tools["8"].length_mm = 100;
    EXPECT_EQ(code_of(program, setup), "VER0103");
    setup.tools["9"].length_mm = 120;
    const auto poses = poses_of(program, setup);
    ASSERT_EQ(poses.size(), 3u);  // the place of the change seen by the new tool
    EXPECT_EQ(poses[1].tool_length_mm, 120);
    EXPECT_LT((poses[1].tip_mm + 20 * axis_of(30 * degree, 0)).norm(), 1e-12);
    program.moves[0].tool = 0;
    EXPECT_EQ(poses_of(program, setup)[0].tool_length_mm, 70);
}

/// A move linear in the machine axes, checked between the chords against the machine's own way.
TEST(ProgrammedPath, MovesInMachineSpaceBecomeChords) {
    auto program = program_of({by_words({40, 0, 0}, 0, 0, 1), by_words({80, -30, 10}, 50 * degree, 40 * degree, 2),
                               by_words({1, 2, 3}, 50 * degree, 40 * degree, 3)});
    program.moves[1].space = Space::machine;
    program.moves[1].kind = program::MoveKind::rapid;
    auto setup = peer_setup();
    setup.tool.length_mm = 60;
    const auto poses = poses_of(program, setup);
    ASSERT_GT(poses.size(), 100u);
    ASSERT_LT(poses.size(), 20000u);
    const auto from = axes_for({40, 0, 0}, 0, 0, setup);
    const machine::AxisPosition to{{80, -30, 10, 50 * degree, 40 * degree}};
    double worst = 0;
    const std::size_t chords = poses.size() - 2;
    for (std::size_t n = 1; n <= chords; ++n) {
        EXPECT_EQ(poses[n].kind, PoseKind::rapid);
        const auto& a = poses[n - 1];
        const auto& b = poses[n];
        const double w = 0.5 * (a.rotary_rad[0] + b.rotary_rad[0]) / (50 * degree);
        Eigen::Vector3d linear;
        for (int i = 0; i < 3; ++i) linear[i] = from[i] + w * (to[i] - from[i]);
        const auto turn = table_to_machine(w * 50 * degree, w * 40 * degree);
        const Eigen::Vector3d axis = turn.col(2);
        const Eigen::Vector3d tip = turn * linear - 60 * axis - Eigen::Vector3d(0, 0, 50);
        const Eigen::Vector3d tip_off = tip - 0.5 * (a.tip_mm + b.tip_mm);
        const Eigen::Vector3d top_off = tip_off + 30 * (axis - (a.axis + b.axis).normalized());
        worst = std::max({worst, tip_off.norm(), top_off.norm()});
    }
    EXPECT_LT(worst, 1.01e-4);
    EXPECT_GT(worst, 1e-5);  // no finer than needed
    EXPECT_LT((poses[chords].axis - axis_of(50 * degree, 40 * degree)).norm(), 1e-12);
    EXPECT_EQ(poses.back().kind, PoseKind::rotary);
}

TEST(ProgrammedPath, LinearMachineMovesAreOneChord) {
    auto program = program_of({by_words({0, 0, 0}, 30 * degree, 0, 1), by_words({7, 8, 9}, 30 * degree, 0, 2)});
    program.moves[1].space = Space::machine;
    const auto poses = poses_of(program);
    ASSERT_EQ(poses.size(), 2u);
    EXPECT_EQ(poses[1].kind, PoseKind::vector);
    EXPECT_LT(
        (poses[1].tip_mm - (table_to_machine(30 * degree, 0) * Eigen::Vector3d(7, 8, 9) - Eigen::Vector3d(0, 0, 50)))
            .norm(),
        1e-12);
}

TEST(ProgrammedPath, BadProgramsAreRefused) {
    EXPECT_EQ(code_of(program_of({})), "VER0101");
    auto foreign = program_of({by_words({0, 0, 0}, 0, 0, 1)});
    foreign.rotary_letters = {'B'};
    EXPECT_EQ(code_of(foreign), "VER0102");
    foreign.rotary_letters = {'X'};
    EXPECT_EQ(code_of(foreign), "VER0102");
    EXPECT_EQ(code_of(program_of({by_vector({0, 0, 0}, {0, 0, 1}, 1), by_vector({1, 0, 0}, {0, 0, -1}, 2)})),
              "VER0105");
    auto blind = program_of({by_vector({0, 0, 0}, {0, 0, 1}, 1), by_words({0, 0, 0}, 0, 0, 2)});
    blind.moves[1].space = Space::machine;
    EXPECT_EQ(code_of(blind), "VER0106");
    auto flat = peer_trunnion();
    flat.axes[2].direction = flat.axes[0].direction;
    auto machine_move = program_of({by_words({0, 0, 0}, 0, 0, 1), by_words({0, 0, 0}, 0, 0, 2)});
    machine_move.moves[1].space = Space::machine;
    EXPECT_EQ(code_of(machine_move, peer_setup(), flat), "VER0107");
    EXPECT_EQ(code_of(program_of({by_words({NAN, 0, 0}, 0, 0, 1)})), "VER0108");
    EXPECT_EQ(code_of(program_of({by_words({0, 0, 0}, INFINITY, 0, 1)})), "VER0108");
    auto none = by_vector({0, 0, 0}, {0, 0, 1}, 1);
    none.axis.setZero();
    EXPECT_EQ(code_of(program_of({none})), "VER0108");
}

TEST(ProgrammedCsv, ReadsBackWhatItWrites) {
    std::vector poses{pose_by_words({1.0 / 3, -2e-7, 1e5}, 0.1, 17 * degree, 3), pose({1, 2, 3}, 9, {1, 2, 3})};
    poses[1].kind = PoseKind::rapid;
    const auto text = programmed_csv(poses, peer_trunnion());
    EXPECT_EQ(text.substr(0, text.find('\n')), "x_mm,y_mm,z_mm,i,j,k,kind,line,A_deg,C_deg");
    const auto back = read_programmed_csv(text, peer_trunnion());
    ASSERT_TRUE(back);
    ASSERT_EQ(back->size(), 2u);
    EXPECT_EQ((*back)[0].tip_mm, poses[0].tip_mm);
    EXPECT_LT(((*back)[1].axis - poses[1].axis).norm(), 1e-15);
    EXPECT_NEAR((*back)[0].rotary_rad[1], 17 * degree, 1e-16);
    EXPECT_TRUE(std::isnan((*back)[1].rotary_rad[0]));
    EXPECT_EQ((*back)[0].kind, PoseKind::rotary);
    EXPECT_EQ((*back)[1].kind, PoseKind::rapid);
    EXPECT_TRUE((*back)[1].at_rapid);
    EXPECT_EQ((*back)[0].line, 3);
    const auto vectors = programmed_csv({poses[1]}, peer_trunnion());
    EXPECT_EQ(vectors.substr(0, vectors.find('\n')), "x_mm,y_mm,z_mm,i,j,k,kind,line");
}

TEST(ProgrammedCsv, BadTablesAreRefused) {
    const auto code = [](std::string_view text, int line) {
        const auto poses = read_programmed_csv(text, peer_trunnion(), "p.csv");
        if (poses) return std::string("none");
        EXPECT_EQ(poses.error().place.line, line) << poses.error().code;
        EXPECT_EQ(poses.error().place.file, "p.csv");
        return poses.error().code;
    };
    const std::string head = "x_mm,y_mm,z_mm,i,j,k,kind,line,A_deg\n";
    EXPECT_EQ(code(head + "0,0,0,0,0,1,rotary,1,5\n", 0), "none");
    EXPECT_EQ(code("", 0), "VER0201");
    EXPECT_EQ(code(head, 1), "VER0201");
    EXPECT_EQ(code("x_mm,y_mm,i,j,k\n", 1), "VER0202");
    EXPECT_EQ(code(head + "0,0,0,0,0,one,rotary,1,5\n", 2), "VER0203");
    EXPECT_EQ(code(head + "0,0,0,0,0,1,rotary,1,nan\n", 2), "VER0203");
    EXPECT_EQ(code(head + "0,0,0,0,0,1,rotary,1,5\n0,0,0\n", 3), "VER0204");
    EXPECT_EQ(code("x_mm,y_mm,z_mm,i,j,k,i\n", 1), "VER0205");
    EXPECT_EQ(code(head + "0,0,0,0,0,1,helix,1,5\n", 2), "VER0207");
    EXPECT_EQ(code(head + "0,0,0,0,0,0,rotary,1,5\n", 2), "VER0108");
    EXPECT_EQ(code("x_mm,y_mm,z_mm,i,j,k,B_deg\n", 1), "VER0102");
}

}  // namespace
}  // namespace trunnion::verify::test
