#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "fanuc_reading.hpp"

namespace trunnion::nc {
namespace {

/// Heights of the moves behind the start, rapids with an r behind: `5r 2r -3`.
std::string heights(const Result<program::Program>& p) {
    if (!p) return said(p);
    std::string text;
    for (std::size_t i = 1; i < p->moves.size(); ++i)
        text += fmt::format("{}{:.6g}{}", i > 1 ? " " : "", p->moves[i].position_mm.z(),
                            p->moves[i].kind == program::MoveKind::rapid ? "r" : "");
    return text;
}

std::string events_behind_start(const program::Program& p) {
    std::string text;
    for (const auto& event : p.events)
        if (event.before_move > 1) text += event.word + " ";
    return text;
}

TEST(FanucCycles, Motion) {
    EXPECT_EQ(heights(read_fanuc_after_start("G98 G81 X5. R2. Z-3.\nX10.\nG80 X20.")),
              "50r 2r -3 50r 50r 2r -3 50r 50r");
    EXPECT_EQ(heights(read_fanuc_after_start("G99 G81 X5. R2. Z-3.\nX10.\nG80")), "50r 2r -3 2r 2r -3 2r");
    EXPECT_EQ(heights(read_fanuc_after_start("G99 G82 R2. Z-3. P500\nG80")), "2r -3 2r");
    EXPECT_EQ(heights(read_fanuc_after_start("G99 G83 R2. Z-10. Q5.\nG80")), "2r -3 2r -2r -8 2r -7r -10 2r");
    EXPECT_EQ(heights(read_fanuc_after_start("G99 G73 R2. Z-10. Q5.\nG80")), "2r -3 -2r -8 -7r -10 2r");
    EXPECT_EQ(heights(read_fanuc_after_start("G99 G83 R2. Z-10. Q0\nG80")), "2r -10 2r");
    EXPECT_EQ(heights(read_fanuc_after_start("G98 G84 R2. Z-3.\nG80")), "2r -3 2 50r");
    EXPECT_EQ(heights(read_fanuc_after_start("G99 G85 R2. Z-3.\nG80")), "2r -3 2");
    EXPECT_EQ(heights(read_fanuc_after_start("G98 G89 R2. Z-3. P100\nG80")), "2r -3 2 50r");
    EXPECT_EQ(heights(read_fanuc_after_start("G99 G86 R2. Z-3.\nG80")), "2r -3 2r");
    EXPECT_EQ(heights(read_fanuc_after_start("G99 G87 R-3. Z2.\nG80")), "-3r 2 50r");
    EXPECT_EQ(heights(read_fanuc_after_start("G91 G99 G81 X5. R-48. Z-5. K2\nG80")), "50r 2r -3 2r 2r -3 2r");
    EXPECT_EQ(heights(read_fanuc_after_start("G99 G81 X5. R2. Z-3. K0\nG80\nG0 X1.")), "50r");
    const auto p = read_fanuc_after_start("G53 G0 Z0\nG98 G81 X5. R2. Z-3.\nG80 Z9.");
    EXPECT_EQ(heights(p), "0r nanr 2r -3 2r 9r");
    EXPECT_TRUE(told(*p, "NC0872"));
    EXPECT_EQ(heights(read_fanuc_after_start("G99 G81 X5. R2. Z-3.\nM8\nG0 X1.")), "50r 2r -3 2r 2r");
}

TEST(FanucCycles, EventsAndShifts) {
    auto p = read_fanuc_after_start("G99 G84 R2. Z-3. P100\nG80");
    ASSERT_TRUE(p) << said(p);
    EXPECT_EQ(events_behind_start(*p), "G84 P M4 G84 P M3 M30 ");
    p = read_fanuc_after_start("G99 G88 R2. Z-3.\nG80");
    EXPECT_EQ(events_behind_start(*p), "M5 M0 M3 M30 ");
    p = read_fanuc_after_start("G99 G76 R2. Z-3. I.5\nG80");
    ASSERT_TRUE(p) << said(p);
    EXPECT_EQ(p->moves.at(3).position_mm, Eigen::Vector3d(.5, 0, -3));
    EXPECT_EQ(p->moves.at(5).position_mm, Eigen::Vector3d(0, 0, 2));
    EXPECT_TRUE(told(*read_fanuc_after_start("G99 G83 R2. Z-10. Q5.\nG80"), "NC0868"));
}

TEST(FanucCycles, AcrossOtherPlanes) {
    const auto p = read_fanuc_after_start("G19 G99 G81 Y5. Z6. R-2. X-8.\nG80");
    ASSERT_TRUE(p) << said(p);
    EXPECT_EQ(p->moves.at(1).position_mm, Eigen::Vector3d(0, 5, 6));
    EXPECT_EQ(p->moves.at(3).position_mm, Eigen::Vector3d(-8, 5, 6));
}

TEST(FanucCycles, Refusals) {
    const std::pair<const char*, const char*> cases[] = {
        {"G81 X5. Z-3.", "NC0849"},
        {"G81 X5. R2.", "NC0849"},
        {"G93 G81 R2. Z-3. F1.", "NC0849"},
        {"G76 R2. Z-3. Q.5", "NC0848"},
        {"G81 G1 X1. R2. Z-3.", "NC0823"},
        {"G83 R2. Z-3. Q.000001", "NC0849"},
        {"G81 R2. Z-3. K1.5", "NC0849"},
        {"G53 G0 Z0\nG98 G81 R2. Z-3.\nX5.", "NC0849"},
        {"G12.1", "NC0821"},
        {"G12 I5.", "NC0821"},
    };
    for (const auto& [text, code] : cases) {
        const auto p = read_fanuc_after_start(text);
        ASSERT_FALSE(p) << text;
        EXPECT_EQ(p.error().code, code) << text << "\n" << said(p);
    }
}

}  // namespace
}  // namespace trunnion::nc
