#include "trunnion/verify/setpoint_table.hpp"

#include <gtest/gtest.h>

#include "made_motions.hpp"

namespace trunnion::verify::test {
namespace {

const std::string head = "t_s,X_mm,Y_mm,Z_mm,A_deg,C_deg,line,s_mm,feed_mm_min\n";

TEST(SetpointTable, ReadsColumnsByName) {
    const auto table = read_setpoint_csv(
        "line, C_deg,Z_mm,t_s,Y_mm,X_mm,A_deg,noise,feed_mm_min,s_mm\r\n"
        "7,180,3,0,2,1,-90,x,600,0.5\r\n"
        "8,1e1,3,0.002,2,+1,0,,0,1.5\r\n\r\n",
        peer_trunnion());
    ASSERT_TRUE(table) << to_string(table.error());
    ASSERT_EQ(table->rows.size(), 2u);
    EXPECT_EQ(table->period_s, 0.002);
    const auto& first = table->rows[0];
    EXPECT_EQ(first.position[0], 1);
    EXPECT_EQ(first.position[1], 2);
    EXPECT_EQ(first.position[2], 3);
    EXPECT_NEAR(first.position[3], -90 * degree, 1e-15);
    EXPECT_NEAR(first.position[4], 180 * degree, 1e-15);
    EXPECT_EQ(first.line, 7);
    EXPECT_EQ(first.feed_mm_s, 10);
    EXPECT_EQ(table->rows[1].path_length_mm, 1.5);
}

TEST(SetpointTable, BadTablesAreRefused) {
    const auto code = [](const std::string& text, int line) {
        const auto table = read_setpoint_csv(text, peer_trunnion(), "s.csv");
        if (table) return std::string("none");
        EXPECT_EQ(table.error().place.line, line) << table.error().code;
        return table.error().code;
    };
    const std::string row = ",0,0,0,0,0,1,0,0\n";
    EXPECT_EQ(code(head + "0" + row, 0), "none");
    EXPECT_EQ(code(head + "0" + row + "0.001" + row + "0.002" + row, 0), "none");
    EXPECT_EQ(code("", 0), "VER0201");
    EXPECT_EQ(code(head, 0), "VER0201");
    EXPECT_EQ(code("t_s,X_mm,Y_mm,Z_mm,A_deg\n0,0,0,0,0\n", 1), "VER0202");
    EXPECT_EQ(code("X_mm,Y_mm,Z_mm,A_deg,C_deg\n0,0,0,0,0\n", 1), "VER0202");
    EXPECT_EQ(code(head + "0" + row + "zero" + row, 3), "VER0203");
    EXPECT_EQ(code(head + "0,0,0,inf,0,0,1,0,0\n", 2), "VER0203");
    EXPECT_EQ(code(head + "0,0,0,1e999,0,0,1,0,0\n", 2), "VER0203");
    EXPECT_EQ(code(head + "0,0,0,,0,0,1,0,0\n", 2), "VER0203");
    EXPECT_EQ(code(head + "0,0,0,0,0,0,1.5,0,0\n", 2), "VER0203");
    EXPECT_EQ(code(head + "0,0,0,0\n", 2), "VER0204");
    EXPECT_EQ(code(head + "0,0,0,0,0,0,1,0,0,\n", 2), "VER0204");
    EXPECT_EQ(code("t_s,X_mm,X_mm\n", 1), "VER0205");
    EXPECT_EQ(code(head + "0" + row + "0.001" + row + "0.003" + row, 3), "VER0206");
    EXPECT_EQ(code(head + "0" + row + "0" + row, 3), "VER0206");
    EXPECT_EQ(code(head + "1" + row + "0" + row, 3), "VER0206");
}

TEST(SetpointTable, BinaryIsRefused) {
    std::string junk;
    for (int n = 0; n < 4096; ++n) junk += static_cast<char>((n * 37) % 256);
    EXPECT_FALSE(read_setpoint_csv(junk, peer_trunnion()));
}

}  // namespace
}  // namespace trunnion::verify::test
