#include <fmt/format.h>
#include <gtest/gtest.h>

#include "trunnion/base/quantity.hpp"

#include "reading.hpp"

namespace trunnion::nc {
namespace {

using program::EventKind;
using program::MoveKind;

/// Where the moves behind `G21 G0 X1 Y2 Z10` go, with f for feed: "3,4,5 f3,4,1"; or the code.
std::string way_of(std::string_view text) {
    const auto p = read_ac("G21 F100 G0 X1 Y2 Z10\n" + std::string(text));
    if (!p) return p.error().code;
    std::string all;
    for (std::size_t i = 1; i < p->moves.size(); ++i) {
        const program::Move& move = p->moves[i];
        all += fmt::format("{}{}{:g},{:g},{:g}", i > 1 ? " " : "", move.kind == MoveKind::feed ? "f" : "",
                           move.position_mm.x(), move.position_mm.y(), move.position_mm.z());
    }
    return all;
}

TEST(Rs274Shifts, WordsCountFromTheShiftedOrigin) {
    EXPECT_EQ(way_of("G92 X0 Y0\nX1\nG92.1\nX5\n"), "2,2,10 5,2,10");
    EXPECT_EQ(way_of("G92 X0\nG92.2\nX3\nG92.3\nX3\n"), "3,2,10 4,2,10");
    EXPECT_EQ(way_of("G92 X0\nG92.1\nG92.3\nX3\n"), "3,2,10") << "G92.1 forgets the shift";
    EXPECT_EQ(way_of("G52 X5\nX1\nG52 X0\nX1.5\n"), "6,2,10 1.5,2,10");
    EXPECT_EQ(way_of("G10 L20 P0 X0\nX1\nG92 X0\nX1\n"), "2,2,10 3,2,10");
    EXPECT_EQ(way_of("G92 X0\nG10 L20 P1 X7\nX8\n"), "2,2,10") << "both together make the words";
    EXPECT_EQ(way_of("G10 L20 P1 X0\nG55 X1 Y1 Z1\nG54 X1\n"), "1,1,1 2,nan,nan") << "of its own offset alone";
    EXPECT_EQ(way_of("G92 X0\nG91 X1\n"), "2,2,10");
    EXPECT_EQ(way_of("G20 G92 X1\nX2\n"), "26.4,2,10");
    EXPECT_EQ(way_of("G92 X0\nX[#5420+3]\n"), "4,2,10");
    EXPECT_EQ(way_of("G92 X0\nG53 G0 X5\n"), "5,nan,nan") << "not in machine positions";
    const auto p = read_ac("G21 G0 X0 Y0 Z0 A10 C0\nG92 A0\nA5\n");
    ASSERT_TRUE(p) << said(p);
    EXPECT_DOUBLE_EQ(p->moves[1].rotary_rad[0], 15 * degree);
}

TEST(Rs274Shifts, OfFollowingLettersMoveNothing) {
    const auto p = read_ac("G21 G92 E0\nG0 X0 Y0 Z0\nG92 E5\nG1 X1 E3 F60\n");
    ASSERT_TRUE(p) << said(p);
    ASSERT_EQ(p->moves.size(), 2u);
    EXPECT_EQ(p->moves[1].position_mm.x(), 1);
}

TEST(Rs274Shifts, Refusals) {
    EXPECT_EQ(read_ac("G21 G92 X0\nG0 X0 Y0 Z0\n").error().code, "NC0342");
    EXPECT_EQ(way_of("G55\nG92 X0\n"), "NC0342");
    EXPECT_EQ(way_of("G92 A0\n"), "NC0342");
    EXPECT_EQ(way_of("G10 L20 P2 X0\n"), "NC0342");
    EXPECT_EQ(way_of("G10 L20 P12 X0\n"), "NC0314");
    EXPECT_EQ(way_of("G10 L2 P1 X0\n"), "NC0341");
    EXPECT_EQ(way_of("G10 L1 P1 Z5\n"), "NC0341");
    EXPECT_EQ(way_of("G10 P1 Z5\n"), "NC0341");
    EXPECT_EQ(way_of("G92 X5 G1\n"), "NC0343");
}

TEST(Rs274Shifts, TheWayHomeIsLeftOutAtTheEndsOnly) {
    const auto p = read_ac("G21 G28 X0 Y0\nG0 X0 Y0 Z0\nX1\nG91 G28 Z0\nM30\n");
    ASSERT_TRUE(p) << said(p);
    EXPECT_EQ(p->moves.size(), 2u);
    EXPECT_EQ(told(*p, "NC0347")->count, 2);
    EXPECT_EQ(way_of("G91 G28 Z0\nG90 G0 X5\n"), "NC0302");
    EXPECT_EQ(way_of("G30\nX5\n"), "NC0302");
}

TEST(Rs274Cycles, Drilling) {
    EXPECT_EQ(way_of("G98 G81 X3 Y4 Z1 R5\nX6\nG80\n"), "3,4,10 3,4,5 f3,4,1 3,4,10 6,4,10 6,4,5 f6,4,1 6,4,10");
    EXPECT_EQ(way_of("G99 G81 X3 Y4 Z1 R5\nX6\n"), "3,4,10 3,4,5 f3,4,1 3,4,5 6,4,5 f6,4,1 6,4,5");
    EXPECT_EQ(way_of("G99 G83 X3 Y4 Z1 R5 Q1.5\n"),
              "3,4,10 3,4,5 f3,4,3.5 3,4,5 3,4,3.754 f3,4,2 3,4,5 3,4,2.254 f3,4,1 3,4,5");
    EXPECT_EQ(way_of("G99 G73 Z1 R5 Q2\n"), "1,2,5 f1,2,3 1,2,3.254 f1,2,1 1,2,5");
    EXPECT_EQ(way_of("G98 G85 Z1 R5\n"), "1,2,5 f1,2,1 f1,2,5 1,2,10");
    EXPECT_EQ(way_of("G98 G89 Z1 R5 P1\n"), "1,2,5 f1,2,1 f1,2,10");
    EXPECT_EQ(way_of("G99 G91 G81 X1 Y1 Z-1 R-2 L3\n"),
              "2,3,10 2,3,8 f2,3,7 2,3,8 3,4,8 f3,4,7 3,4,8 4,5,8 f4,5,7 4,5,8");
    EXPECT_EQ(way_of("G98 G91 G81 X1 Z-1 R-2 L2\n"), "2,2,10 2,2,8 f2,2,7 2,2,10 3,2,10 3,2,8 f3,2,7 3,2,10");
    EXPECT_EQ(way_of("G98 G18 G81 X2 Z1 R5 Y-1\n"), "1,5,10 2,5,1 f2,-1,1 2,5,1");
    EXPECT_EQ(way_of("G98 G19 G81 X-2 R0\n"), "0,2,10 f-2,2,10 1,2,10");
    EXPECT_EQ(way_of("G92 Z0\nG98 G81 Z-9 R-5\n"), "1,2,5 f1,2,1 1,2,10") << "R and depth count as words do";
}

TEST(Rs274Cycles, DwellAndSpindle) {
    const auto p = read_ac("G21 G0 X1 Y2 Z10 F100 S100 M3\nG98 G82 Z1 R5 P2\nG84 Z1 R5\nG86 Z1 R5 P1\n");
    ASSERT_TRUE(p) << said(p);
    std::string all;
    for (const program::Event& event : p->events) all += fmt::format("{}@{} ", event.word, event.before_move);
    EXPECT_EQ(all, "S100@0 M3@0 P2@3 M4@6 M3@7 P1@9 M5@9 M3@10 ");
    EXPECT_TRUE(p->moves[2].exact_stop);
    EXPECT_EQ(p->path_controls.front().kind, program::PathControlKind::exact);
    EXPECT_EQ(p->path_controls.at(1).kind, program::PathControlKind::blend);
    EXPECT_EQ(p->path_controls.at(1).before_move, 4u);
    EXPECT_TRUE(told(*read_ac("G21 G0 X1 Y2 Z10 F100\nG81 Z1 R5\n"), "NC0352")) << "neither G98 nor G99";
}

TEST(Rs274Cycles, Refusals) {
    const std::pair<std::string_view, std::string_view> refusals[] = {
        {"G81 Z1\n", "NC0345"},
        {"G81 R5\n", "NC0345"},
        {"G81 X1 R5\n", "NC0345"},
        {"G83 Z1 R5\n", "NC0345"},
        {"G83 Z1 R5 Q0\n", "NC0345"},
        {"G82 Z1 R5\n", "NC0345"},
        {"G82 Z1 R5 P-1\n", "NC0312"},
        {"G81 Z1 R5 A5\n", "NC0345"},
        {"G93 G81 Z1 R5 F1\n", "NC0345"},
        {"G84 Z1 R5\n", "NC0345"},
        {"M4\nG84 Z1 R5\n", "NC0345"},
        {"G86 Z1 R5 P1\n", "NC0345"},
        {"G81 Z6 R5\n", "NC0346"},
        {"G83 Z1 R5 Q.00001\n", "NC0346"},
        {"G81 Z1 R5 L0\n", "NC0314"},
        {"G81 Z1 R5 Q1\n", "NC0313"},
        {"G55 G81 X1 Y1 Z1 R5\n", "NC0344"},
        {"G87 Z1 R5\n", "NC0302"},
        {"G88 Z1 R5\n", "NC0302"},
        {"G76 Z1 P1\n", "NC0302"},
    };
    for (const auto& [text, code] : refusals) EXPECT_EQ(way_of(text), code) << text;
}

TEST(Rs274Curves, CubicAndQuadratic) {
    const auto p = read_ac("G21 G0 X0 Y0 Z10\nG5 X1 Y1 I0 J3 P0 Q-3 F600\nX2 Y2 P-1 Q0\nG5.1 X4 Y2 I1 J1\n");
    ASSERT_TRUE(p) << said(p);
    ASSERT_EQ(p->curves.size(), 3u);
    ASSERT_EQ(p->moves.size(), 4u);
    const program::Curve& cubic = p->curves[0];
    EXPECT_EQ(cubic.degree, 3);
    EXPECT_EQ(cubic.knots, (std::vector<double>{0, 0, 0, 0, 1, 1, 1, 1}));
    EXPECT_EQ(cubic.position_mm[1], Eigen::Vector3d(0, 3, 10));
    EXPECT_EQ(cubic.position_mm[2], Eigen::Vector3d(1, -2, 10));
    EXPECT_EQ(cubic.position_mm[3], Eigen::Vector3d(1, 1, 10));
    EXPECT_EQ(p->curves[1].position_mm[1], Eigen::Vector3d(1, 4, 10)) << "goes on as the one before ended";
    EXPECT_EQ(p->curves[2].degree, 2);
    EXPECT_EQ(p->curves[2].position_mm[1], Eigen::Vector3d(3, 3, 10));
    EXPECT_EQ(p->moves[3].curve_part, 2);
    EXPECT_EQ(p->curve_parts[2].to_u, 1);
    EXPECT_EQ(p->moves[1].feed, (program::Feed{program::FeedRule::tip_speed, 10}));
}

TEST(Rs274Curves, Nurbs) {
    const auto p = read_ac("G21 G0 X0 Y0 Z0 F100\nG5.2 P2 L3\nX0 Y1 P1\nX2 Y2 P.5\nX2 Y0\nG5.3\nG1 X5\n");
    ASSERT_TRUE(p) << said(p);
    ASSERT_EQ(p->curves.size(), 1u);
    EXPECT_EQ(p->curves[0].degree, 2);
    EXPECT_EQ(p->curves[0].knots, (std::vector<double>{0, 0, 0, 1, 2, 2, 2}));
    EXPECT_EQ(p->curves[0].weights, (std::vector<double>{2, 1, .5, 1}));
    EXPECT_EQ(p->moves[1].position_mm, Eigen::Vector3d(2, 0, 0));
    EXPECT_EQ(p->curve_parts[0].to_u, 2);
    EXPECT_EQ(p->moves[2].position_mm, Eigen::Vector3d(5, 0, 0));
}

TEST(Rs274Curves, Refusals) {
    const std::pair<std::string_view, std::string_view> refusals[] = {
        {"G5 X5 Y5 P1 Q1\n", "NC0350"},
        {"G5 X5 Y5 I1 P1 Q1\n", "NC0350"},
        {"G5 X5 Y5 I1 J1 P1\n", "NC0350"},
        {"G5 X5 Y5 Z1 I1 J1 P1 Q1\n", "NC0350"},
        {"G5 X5 Y5 A1 I1 J1 P1 Q1\n", "NC0350"},
        {"G18 G5 X5 Y5 I1 J1 P1 Q1\n", "NC0350"},
        {"G5 X5 Y5 I1 J1 P1 Q1\nG1 X7\nG5 X8 Y8 P1 Q1\n", "NC0350"},
        {"G5 X5 Y5 I1 J1 P1 Q1 R5\n", "NC0313"},
        {"G5.1 X5 Y5 I1\n", "NC0350"},
        {"G5.1 X5 Y5 I0 J0\n", "NC0350"},
        {"G55 G5.1 X5 Y5 I1 J1\n", "NC0344"},
        {"G5.2 X1 Y1\nG1 X5\n", "NC0351"},
        {"G5.2 X1 Y1\nX5 Y6\n", "NC0351"},
        {"G5.2 X1 Y1\nG5.3\n", "NC0351"},
        {"G5.2 X1 Y1 P0\n", "NC0351"},
        {"G5.2 X1 Y1 L9\n", "NC0351"},
        {"G5.2 X1\n", "NC0351"},
        {"G5.3\n", "NC0351"},
    };
    for (const auto& [text, code] : refusals) EXPECT_EQ(way_of(text), code) << text;
}

TEST(Rs274Words, FeedPerTurn) {
    const auto p = read_ac("G21 G0 X0 Y0 Z0\nG95 S600 M3\nG1 X1 F.5\nS1200\nX2\nG94 X3 F60\n");
    ASSERT_TRUE(p) << said(p);
    EXPECT_DOUBLE_EQ(p->moves[1].feed.value, 5);
    EXPECT_DOUBLE_EQ(p->moves[2].feed.value, 10);
    EXPECT_DOUBLE_EQ(p->moves[3].feed.value, 1);
    EXPECT_EQ(way_of("G95 F1\nG1 X2\n"), "NC0348");
    EXPECT_EQ(way_of("G95 S600 F1\nG94\nG1 X2\n"), "NC0205") << "the feed of another mode does not count";
    EXPECT_EQ(way_of("G96 S100\n"), "NC0302");
}

TEST(Rs274Words, OutputsAndWordsOfTheUser) {
    const auto p = read_ac("G21 G0 X0 Y0 Z0\nM62 P1\nM67 E2 Q.5\nM66 P0 L3 Q2\nM123 P1 Q2\nM61 Q4\nG1 X1 F60\nM400\n");
    ASSERT_TRUE(p) << said(p);
    std::string all;
    for (const program::Event& event : p->events) all += event.word + (event.stops_motion ? "! " : " ");
    EXPECT_EQ(all, "M62 P1 M67 E2 Q0.5 M66 P0 L3 Q2! M123 P1 Q2! M61 Q4 M400! ");
    EXPECT_EQ(p->tools.at(p->moves[1].tool), "4");
    EXPECT_EQ(way_of("M61 Q-1\n"), "NC0314");
    EXPECT_EQ(way_of("M62 P1 X2\n"), "2,2,10") << "an axis word beside it still moves";
}

TEST(Rs274Words, OfPrinters) {
    const auto p = read_ac(
        "; a printer\nG21\nM82\nM104 S205 T1\nM109 S205\nG28\nG92 E0\nM204 S100\nM201 X500 Y500\nT0\nG0 X0 Y0 Z0\nG1 "
        "X1 E2 "
        "F60\nM221 S95\nM84\n");
    ASSERT_TRUE(p) << said(p);
    EXPECT_EQ(p->moves.size(), 2u);
    for (const char* const word : {"M204", "M201", "M221", "M84"}) EXPECT_TRUE(told(*p, "NC0012", word)) << word;
    EXPECT_EQ(read_ac("G0 X0 Y0 Z0\nM220 S50\nX1").error().code, "NC0204") << "it changes the feed";
    EXPECT_EQ(read_ac("G0 X0 Y0 Z0\nM204 S50 G1 X1").error().code, "NC0304");
}

}  // namespace
}  // namespace trunnion::nc
