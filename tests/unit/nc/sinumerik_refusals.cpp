#include "sinumerik_reading.hpp"

namespace trunnion::nc {
namespace {

struct Refusal {
    std::string_view blocks, code;
    int line, column;
};

/// Behind two lines that start at X0 Y0 Z0 with F600.
void expect_refused(const Refusal& r) {
    const auto result = read_bc(std::string("G71 G64 G0 X0 Y0 Z0\nG1 X1 F600\n").append(r.blocks));
    ASSERT_FALSE(result) << r.code << " wanted of:\n" << r.blocks;
    EXPECT_EQ(result.error().code, r.code) << r.blocks << "\n" << said(result);
    EXPECT_EQ(result.error().place.line, r.line) << r.blocks << "\n" << said(result);
    EXPECT_EQ(result.error().place.column, r.column) << r.blocks << "\n" << said(result);
    EXPECT_FALSE(result.error().text.empty());
}

TEST(SinumerikRefusals, ByCodeAndPlace) {
    const Refusal refusals[] = {
        {"G12 X1", "NC0204", 3, 1},
        {"G1.5 X1", "NC0204", 3, 1},
        {"U5", "NC0609", 3, 1},
        {"X1 A5", "NC0609", 3, 4},
        {"N10 G33 Z1 K2", "NC0601", 3, 5},
        {"G331 Z1", "NC0601", 3, 1},
        {"G96 S100", "NC0601", 3, 1},
        {"X5 RND=2", "NC0601", 3, 4},
        {"G111 X1 Y1", "NC0601", 3, 1},
        {"POS[X]=5", "NC0601", 3, 1},
        {"TRANSMIT", "NC0601", 3, 1},
        {"FLIN", "NC0601", 3, 1},
        {"ASPLINE", "NC0602", 3, 1},
        {"X5 TILT=3", "NC0638", 3, 4},
        {"G41 X5", "NC0603", 3, 1},
        {"G42", "NC0603", 3, 1},
        {"G90 G91 X1", "NC0606", 3, 5},
        {"G0 G1 X1", "NC0606", 3, 4},
        {"G1 CIP X1", "NC0606", 3, 4},
        {"X1 X2", "NC0607", 3, 4},
        {"T1 T2", "NC0607", 3, 4},
        {"MCALL MCALL", "NC0607", 3, 7},
        {"X5 I3", "NC0613", 3, 4},
        {"G4 F2 X5", "NC0613", 3, 7},
        {"G2 X5 I2 K1", "NC0613", 3, 10},
        {"X=DC(5)", "NC0614", 3, 1},
        {"S-5", "NC0614", 3, 1},
        {"M1.5", "NC0614", 3, 1},
        {"F0", "NC0206", 3, 1},
        {"F-5", "NC0206", 3, 1},
        {"G54\nG91 X5", "NC0611", 4, 5},
        {"G54\nG2 X5 I2.5", "NC0611", 4, 4},
        {"C=ACP(5)", "NC0611", 3, 1},
        {"G2 X5 Y5", "NC0621", 3, 4},
        {"G2 X5 CR=5 I2", "NC0621", 3, 4},
        {"G2 X5 I2 AR=5", "NC0621", 3, 10},
        {"G2 X5 AR=400", "NC0621", 3, 7},
        {"G2 X6 I2", "NC0207", 3, 4},
        {"G2 X5 CR=1", "NC0208", 3, 4},
        {"G2 X5 CR=5 TURN=.5", "NC0212", 3, 4},
        {"CIP X5 I1=3 J1=0 K1=0", "NC0211", 3, 5},
        {"G4", "NC0625", 3, 1},
        {"G4 F1 S1", "NC0625", 3, 1},
        {"G4 S3", "NC0625", 3, 4},
        {"G95 F1 X5", "NC0626", 3, 5},
        {"G93 X5", "NC0205", 3, 5},
        {"FGROUP(X,Y)", "NC0627", 3, 1},
        {"FGROUP(X,Y,Z,A)", "NC0627", 3, 1},
        {"FGREF[A]=5", "NC0627", 3, 1},
        {"FGREF[B]=0", "NC0627", 3, 1},
        {"FGREF[B]=10\nB5 C5", "NC0627", 4, 1},
        {"TRAFOF", "NC0531", 3, 1},
        {"X=1/0", "NC0507", 3, 4},
    };
    for (const Refusal& r : refusals) expect_refused(r);
}

TEST(SinumerikRefusals, BeforeAnythingMoves) {
    EXPECT_EQ(read_bc("X1 Y1 Z1\n").error().code, "NC0610");
    EXPECT_EQ(read_bc("G0 X0 Y0 Z0\nG1 X1\n").error().code, "NC0205");
    EXPECT_EQ(read_bc("M30\n").error().code, "NC0005");
    ReadOptions options;
    options.dialect = Dialect::sinumerik;
    EXPECT_EQ(read_program("G0 X0 Y0 Z0 B0\n", "test", options).error().code, "NC0608");
}

}  // namespace
}  // namespace trunnion::nc
