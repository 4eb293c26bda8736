#include <gtest/gtest.h>

#include "made_programs.hpp"

/// Arcs against circles, helices and spirals written down by hand.
namespace trunnion::verify::test {
namespace {

/// Where the tip of an arc should be after an angle: radius · (cos u + sin v) + climb · w, about `centre`.
struct Round {
    Eigen::Vector3d centre, u, v;  // unit, at right angles; turning goes from u to v
    double radius = 10, growth = 0, angle = 0;
    Eigen::Vector3d climb = Eigen::Vector3d::Zero();
    Eigen::Vector3d at(double w) const {
        return centre + (radius + w * growth) * (std::cos(w * angle) * u + std::sin(w * angle) * v) + w * climb;
    }
    program::Arc arc() const { return {.centre_mm = centre, .normal = u.cross(v), .angle_rad = angle}; }
};

Round round(Eigen::Vector3d u, Eigen::Vector3d v, double angle) {
    return {.centre = {3, -4, 5}, .u = u, .v = v, .angle = angle};
}

Program arc_by_words(const Round& round, std::array<double, 2> from, std::array<double, 2> to) {
    auto program = program_of({by_words(round.at(0), from[0], from[1], 1), by_words(round.at(1), to[0], to[1], 2)});
    program.arcs = {round.arc()};
    program.moves[1].arc = 0;
    return program;
}

/// Every pose lies on the arc at the share that its words say, and chords are as long as they may be.
void expect_on_arc(const std::vector<ProgrammedPose>& poses, const Round& round, std::array<double, 2> from,
                   std::array<double, 2> to, double finest_mm) {
    double worst = 0, before = 0;
    ASSERT_GT(poses.size(), 10u);
    for (std::size_t n = 1; n < poses.size(); ++n) {
        const auto& pose = poses[n];
        EXPECT_EQ(pose.kind, PoseKind::rotary);
        EXPECT_EQ(pose.line, 2);
        const double w = (pose.rotary_rad[1] - from[1]) / (to[1] - from[1]);
        EXPECT_GT(w, before);
        EXPECT_LT((pose.tip_mm - round.at(w)).norm(), 1e-9) << n;
        EXPECT_NEAR(pose.rotary_rad[0], from[0] + w * (to[0] - from[0]), 1e-12);
        EXPECT_LT((pose.axis - axis_of(pose.rotary_rad[0], pose.rotary_rad[1])).norm(), 1e-12);
        const Eigen::Vector3d middle = 0.5 * (pose.tip_mm + poses[n - 1].tip_mm);
        worst = std::max(worst, (middle - round.at(0.5 * (w + before))).norm());
        before = w;
    }
    EXPECT_EQ(before, 1);
    EXPECT_LT((poses.back().tip_mm - round.at(1)).norm(), 1e-12);
    EXPECT_LT(worst, chord_tolerance_mm);
    EXPECT_GT(worst, finest_mm);
}

constexpr std::array<double, 2> flat{5 * degree, -30 * degree}, leaning{25 * degree, 40 * degree};

TEST(ProgrammedArcs, EveryPlaneAndSense) {
    const Eigen::Vector3d x(1, 0, 0), y(0, 1, 0), z(0, 0, 1);
    const Eigen::Vector3d a = Eigen::Vector3d(1, 2, 3).normalized(), b = a.cross(x).normalized();
    for (const auto& [u, v] : {std::pair(x, y), std::pair(z, x), std::pair(y, z), std::pair(a, b)})
        for (const double angle : {90 * degree, -90 * degree, 210 * degree, 360 * degree}) {
            const auto one = round(u, v, angle);
            expect_on_arc(poses_of(arc_by_words(one, flat, leaning)), one, flat, leaning, 8e-5);
        }
}

TEST(ProgrammedArcs, ChordsAreAsFewAsTheToleranceAllows) {
    const auto poses = poses_of(arc_by_words(round({1, 0, 0}, {0, 1, 0}, 90 * degree), flat, leaning));
    const double chord = 2 * std::acos(1 - chord_tolerance_mm / 10);
    EXPECT_LT(static_cast<double>(poses.size() - 1), 1.05 * 90 * degree / chord + 4);
}

TEST(ProgrammedArcs, HelixOfSeveralTurnsAndSpiral) {
    auto helix = round({0, 1, 0}, {0, 0, 1}, -3.25 * 360 * degree);
    helix.climb = {7, 0, 0};
    expect_on_arc(poses_of(arc_by_words(helix, flat, leaning)), helix, flat, leaning, 8e-5);
    auto spiral = round({1, 0, 0}, {0, 1, 0}, 2.5 * 360 * degree);
    spiral.growth = 4;
    expect_on_arc(poses_of(arc_by_words(spiral, flat, leaning)), spiral, flat, leaning, 5e-5);
}

TEST(ProgrammedArcs, RoundingOfTheAngleIsSpreadOverTheWay) {
    auto program = arc_by_words(round({1, 0, 0}, {0, 1, 0}, 90 * degree), flat, leaning);
    program.moves[1].position_mm += Eigen::Vector3d(5e-4, 0, 0);
    const auto poses = poses_of(program);
    EXPECT_LT((poses.back().tip_mm - program.moves[1].position_mm).norm(), 1e-12);
    program.moves[1].position_mm += Eigen::Vector3d(5e-3, 0, 0);
    EXPECT_EQ(code_of(program), "VER0111");
}

TEST(ProgrammedArcs, VectorsTurnInProportionToTheArc) {
    const auto one = round({1, 0, 0}, {0, 1, 0}, 200 * degree);
    const Eigen::Vector3d u = Eigen::Vector3d(0, 1, 3).normalized(), v = Eigen::Vector3d(2, 0, 1).normalized();
    auto program = program_of({by_vector(one.at(0), u, 1), by_vector(one.at(1), v, 2)});
    program.arcs = {one.arc()};
    program.moves[1].arc = 0;
    const double angle = std::acos(u.dot(v));
    const auto poses = poses_of(program);
    ASSERT_GT(poses.size(), 300u);
    for (std::size_t n = 0; n < poses.size(); ++n) {
        const double w = static_cast<double>(n) / static_cast<double>(poses.size() - 1);
        EXPECT_EQ(poses[n].kind, PoseKind::vector);
        EXPECT_TRUE(std::isnan(poses[n].rotary_rad[0]));
        EXPECT_LT((poses[n].tip_mm - one.at(w)).norm(), 1e-9);
        const Eigen::Vector3d axis = (std::sin((1 - w) * angle) * u + std::sin(w * angle) * v) / std::sin(angle);
        EXPECT_LT((poses[n].axis - axis).norm(), 1e-12);
    }
    program.moves[1].axis = -u;
    EXPECT_EQ(code_of(program), "VER0105");
}

TEST(ProgrammedArcs, InTheFrameOfTheWorkOffset) {
    const auto one = round({1, 0, 0}, {0, 1, 0}, 120 * degree);
    auto program = arc_by_words(one, flat, leaning);
    program.offsets = {"", "G55"};
    program.moves[0].offset = program.moves[1].offset = 1;
    auto setup = peer_setup();
    const auto turn = Eigen::AngleAxisd(50 * degree, Eigen::Vector3d(1, 1, 0).normalized()).toRotationMatrix();
    setup.offsets["G55"] = {.origin_mm = {10, 20, 30}, .rotation = turn};
    Round moved = one;
    moved.centre = turn * one.centre + Eigen::Vector3d(10, 20, 30);
    moved.u = turn * one.u, moved.v = turn * one.v;
    expect_on_arc(poses_of(program, setup), moved, flat, leaning, 8e-5);
}

/// With the linear axes on an arc and the table turning the tip goes a way that is neither.
TEST(ProgrammedArcs, InMachineAxesWithTheTableTurning) {
    const auto one = round({1, 0, 0}, {0, 1, 0}, 150 * degree);
    auto program = arc_by_words(one, flat, leaning);
    for (auto& move : program.moves) move.space = Space::machine;
    auto setup = peer_setup();
    setup.tool.length_mm = 60;
    const auto poses = poses_of(program, setup);
    ASSERT_GT(poses.size(), 300u);
    double worst = 0;
    const auto seen = [&](double w) {
        const auto turn = table_to_machine(flat[0] + w * (leaning[0] - flat[0]), flat[1] + w * (leaning[1] - flat[1]));
        const Eigen::Vector3d axis = turn.col(2);
        return std::pair<Eigen::Vector3d, Eigen::Vector3d>(turn * one.at(w) - 60 * axis - Eigen::Vector3d(0, 0, 50),
                                                           axis);
    };
    for (std::size_t n = 1; n < poses.size(); ++n) {
        const auto& a = poses[n - 1];
        const auto& b = poses[n];
        const auto share = [](const ProgrammedPose& p) { return (p.rotary_rad[1] - flat[1]) / (leaning[1] - flat[1]); };
        EXPECT_LT((b.tip_mm - seen(share(b)).first).norm(), 1e-9);
        const auto [tip, axis] = seen(0.5 * (share(a) + share(b)));
        const Eigen::Vector3d tip_off = tip - 0.5 * (a.tip_mm + b.tip_mm);
        worst = std::max({worst, tip_off.norm(), (tip_off + 30 * (axis - (a.axis + b.axis).normalized())).norm()});
    }
    EXPECT_LT(worst, 1.01e-4);
    EXPECT_GT(worst, 3e-5);
}

TEST(ProgrammedArcs, BadArcsAreRefused) {
    const auto good = arc_by_words(round({1, 0, 0}, {0, 1, 0}, 90 * degree), flat, leaning);
    EXPECT_EQ(code_of(good), "none");
    const auto code = [&good](auto&& change) {
        auto program = good;
        change(program);
        return code_of(program);
    };
    EXPECT_EQ(code([](Program& p) { p.arcs[0].centre_mm = p.moves[0].position_mm; }), "VER0111");
    EXPECT_EQ(code([](Program& p) { p.arcs[0].normal *= 1.1; }), "VER0111");
    EXPECT_EQ(code([](Program& p) { p.arcs[0].normal.setZero(); }), "VER0111");
    EXPECT_EQ(code([](Program& p) { p.arcs[0].angle_rad = NAN; }), "VER0111");
    EXPECT_EQ(code([](Program& p) { p.arcs[0].angle_rad *= -1; }), "VER0111");
    EXPECT_EQ(code([](Program& p) { p.moves[1].arc = 1; }), "VER0111");
    EXPECT_EQ(code([](Program& p) { p.moves[1].arc = -2; }), "VER0111");
    EXPECT_EQ(code([](Program& p) { p.arcs[0].angle_rad = 4e6 * 360 * degree + 90 * degree; }), "VER0109");
}

}  // namespace
}  // namespace trunnion::verify::test
