#include "sinumerik_reading.hpp"

namespace trunnion::nc {
namespace {

/// The levels of Z of the moves behind the start at X0 Y0 Z50, `r` in front of rapids, and dwells and stops between.
std::string levels(std::string_view blocks, std::string_view modes = "G71") {
    const auto p = read_bc(fmt::format("{} G64\nG0 X0 Y0 Z50\nS600 F120\n{}\n", modes, blocks));
    if (!p) return said(p);
    std::string out;
    std::size_t event = 0;
    for (std::size_t i = 1; i <= p->moves.size(); ++i) {
        for (; event < p->events.size() && p->events[event].before_move <= i; ++event) {
            const program::Event& e = p->events[event];
            if (e.before_move < i || e.word == "S600") continue;
            out += e.kind == program::EventKind::dwell ? fmt::format("({:.4g}s) ", e.dwell_s)
                                                       : fmt::format("({}) ", e.word);
        }
        if (i == p->moves.size()) break;
        const program::Move& move = p->moves[i];
        out += move.kind == program::MoveKind::rapid ? "r" : "";
        out += number(move.position_mm.z()) + ' ';
    }
    return out;
}

std::vector<double> speeds(std::string_view blocks) {
    const auto p = read_bc(fmt::format("G71 G64\nG0 X0 Y0 Z50\nS600 F120\n{}\n", blocks));
    EXPECT_TRUE(p) << said(p);
    std::vector<double> out;
    for (std::size_t i = 1; p && i < p->moves.size(); ++i)
        if (p->moves[i].kind == program::MoveKind::feed) out.push_back(p->moves[i].feed.value);
    return out;
}

TEST(SinumerikDrilling, PlanesAndDepth) {
    EXPECT_EQ(levels("CYCLE81(10,0,2,-20)"), "r2 -20 r10 ");
    EXPECT_EQ(levels("CYCLE81(10,1,2,,20,)"), "r3 -19 r10 ");
    EXPECT_EQ(levels("CYCLE81(10,1,2,-5,20)"), "r3 -19 r10 ") << "DPR before DP";
    EXPECT_EQ(levels("CYCLE81(3,3,,-1)"), "r3 -1 r3 ");
    EXPECT_EQ(levels("CYCLE81(-10,0,2,20)"), "r-2 20 r-10 ") << "drilled from below";
    EXPECT_EQ(levels("CYCLE82(10,0,2,-20,,0.6)"), "r2 -20 (0.6s) r10 ");
    EXPECT_EQ(levels("CYCLE82(10,0,2,-20,,-3)"), "r2 -20 (0.3s) r10 ") << "turns at 600 rpm";
    EXPECT_EQ(levels("CYCLE82(10,0,2,-20,,0.6,0,1,12)"), "r2 -20 (0.6s) r10 ");
    EXPECT_EQ(levels("CYCLE82(10,0,2,-5,20,0,0,1,11)"), "r2 -20 r10 ");
    EXPECT_EQ(levels("CYCLE82(10,0,2,-5,20,0,0,1,12)"), "r2 -5 r10 ");
    EXPECT_EQ(levels("CYCLE81(1,0,.1,-1)", "G70"), "r2.54 -25.4 r25.4 ");
}

TEST(SinumerikDrilling, ModalCalls) {
    const auto p = read_bc(
        "G71 G64 G0 X0 Y0 Z50 B0\nF120\n"
        "MCALL CYCLE81(10,0,2,-20)\n"
        "X5\nX5 F60\nG4 F1\nB90\nMCALL\nX9\n");
    EXPECT_EQ(moves_of(p),
              "R u 5 0 50 B0\nR u 5 0 2 B0\nF u 5 0 -20 B0\nR u 5 0 10 B0\n"
              "R u 5 0 2 B0\nF u 5 0 -20 B0\nR u 5 0 10 B0\n"
              "R u 5 0 10 B90\nR u 5 0 2 B90\nF u 5 0 -20 B90\nR u 5 0 10 B90\n"
              "R u 9 0 10 B90\n")
        << "every block with an axis word, even one that moves nothing";
    EXPECT_EQ(p->moves[3].feed.value, 2);
    EXPECT_EQ(p->moves[6].feed.value, 1);
}

TEST(SinumerikDrilling, Patterns) {
    EXPECT_EQ(moves_after_start("G0 MCALL CYCLE81(10,0,2,-20)\nHOLES2(10,0,5,0,90,2)\nMCALL"),
              "R u 15 0 0\nR u 15 0 2\nF u 15 0 -20\nR u 15 0 10\n"
              "R u 10 5 10\nR u 10 5 2\nF u 10 5 -20\nR u 10 5 10\n");
    EXPECT_EQ(moves_after_start("HOLES2(0,0,5,90,0,4)"), "R u 0 5 0\nR u -5 0 0\nR u 0 -5 0\nR u 5 0 0\n");
    EXPECT_EQ(moves_after_start("HOLES1(0,0,90,5,10,3)"), "R u 0 5 0\nR u 0 15 0\nR u 0 25 0\n");
    EXPECT_EQ(moves_after_start("Y99\nHOLES1(0,0,90,5,10,3)"), "F u 0 99 0\nR u 0 25 0\nR u 0 15 0\nR u 0 5 0\n")
        << "begun at the nearer end";
}

TEST(SinumerikDrilling, InFramesAndOtherPlanes) {
    EXPECT_EQ(moves_after_start("AROT Y90\nX1 Y2 Z3\nCYCLE81(10,0,2,-20)"),
              "F u 3 2 -1\nR u 2 2 -1\nF u -20 2 -1\nR u 10 2 -1\n");
    EXPECT_EQ(moves_after_start("G18 X1\nCYCLE81(10,0,2,-20)"), "F u 1 0 0\nR u 1 2 0\nF u 1 -20 0\nR u 1 10 0\n");
}

TEST(SinumerikDrilling, DeepHoles) {
    EXPECT_EQ(levels("CYCLE83(10,0,2,-20,,,8,0,,,1,0)"), "r2 -8 -7 -14 -13 -20 r10 ")
        << "chips broken by 1 mm; 12 mm left are less than two strokes and are halved";
    EXPECT_EQ(levels("CYCLE83(10,0,2,-24,,,8,0,,,1,0)"), "r2 -8 -7 -16 -15 -24 r10 ");
    EXPECT_EQ(levels("CYCLE83(10,0,2,-20,,,10,0,0.5,1,1,1)"), "r2 -10 (0.5s) r2 (1s) r-9.4 -20 (0.5s) r10 ");
    EXPECT_EQ(levels("CYCLE83(10,0,2,-100,,,50,0,,,1,1)"), "r2 -50 r2 r-48 -100 r10 ") << "a fiftieth of the depth";
    EXPECT_EQ(levels("CYCLE83(10,0,2,-20,,-10,,0,,,1,1,3,,,2,4)"), "r2 -10 r2 r-6 -20 (2s) r10 ");
    EXPECT_EQ(levels("CYCLE83(10,0,0,-22,,,10,4,,,1,0,,,0.5)"), "r0 -10 -9.5 -16 -15.5 -19 -18.5 -22 r10 ")
        << "10, then 6, and 6 are left: less than two strokes of 4";
    EXPECT_EQ(levels("CYCLE83(10,0,0,-20,,,10,-0.5,,,1,0,,4)"), "r0 -10 -9 -15 -14 -17.5 -16.5 -20 r10 ");
    EXPECT_EQ(speeds("CYCLE83(10,0,2,-20,,,10,0,,,0.5,1)"), (std::vector<double>{1, 2}));
}

TEST(SinumerikDrilling, Tapping) {
    EXPECT_EQ(levels("CYCLE84(10,0,2,-20,,,3,,1.25,90,600,1200)"), "(SPOS=90) r2 -20 2 r10 (M3) ");
    EXPECT_EQ(speeds("CYCLE84(10,0,2,-20,,,3,,1.25,90,600,1200)"), (std::vector<double>{12.5, 25}));
    EXPECT_EQ(speeds("CYCLE84(10,0,2,-20,,,3,-8,,0,600)"), (std::vector<double>{12.5, 12.5}));
    EXPECT_EQ(speeds("CYCLE84(10,0,2,-20,,,3,,25.4,0,60,60,3,2)"), (std::vector<double>{1, 1})) << "threads an inch";
    EXPECT_EQ(speeds("CYCLE840(10,0,2,-20,,,4,3,0,,1)"), (std::vector<double>{10, 10}));
    EXPECT_EQ(speeds("CYCLE840(10,0,2,-20,,,4,3,1)"), (std::vector<double>{2, 2}));
    EXPECT_EQ(levels("CYCLE840(10,0,2,-20,,,4,3,1)"), "r2 -20 (M4) 2 r10 (M3) ");
}

TEST(SinumerikDrilling, Boring) {
    EXPECT_EQ(levels("CYCLE85(10,0,2,-20,,1,60,120)"), "r2 -20 (1s) 2 r10 ");
    EXPECT_EQ(speeds("CYCLE85(10,0,2,-20,,1,60,120)"), (std::vector<double>{1, 2}));
    EXPECT_EQ(levels("CYCLE89(10,0,2,-20,,1)"), "r2 -20 (1s) 2 r10 ");
    EXPECT_EQ(levels("CYCLE87(10,0,2,-20,,3)"), "(M3) r2 -20 (M5) (M0) r10 ");
    EXPECT_EQ(levels("CYCLE88(10,0,2,-20,,1,4)"), "(M4) r2 -20 (1s) (M5) (M0) r10 ");
    EXPECT_EQ(moves_after_start("CYCLE86(10,0,2,-20,,0,3,-.2,.1,.3,45)"),
              "R u 0 0 2\nF u 0 0 -20\nR u -0.2 0.1 -19.7\nR u -0.2 0.1 2\nR u 0 0 10\n");
}

TEST(SinumerikDrilling, Refused) {
    for (const char* call : {"CYCLE81(10,0,2)",                               // no depth
                             "CYCLE81(10,0,-2,-20)",                          // clearance
                             "CYCLE81(10,0,2,0)",                             // no depth at all
                             "CYCLE81(-1,0,2,-20)",                           // retracts into the hole
                             "CYCLE81(5,5,2,,10)",                            // to which side?
                             "CYCLE81(10,0,2,-20,,1,1)",                      // _GMODE
                             "CYCLE81(10,0,2,-20,,1,0,2)",                    // _DMODE: G18
                             "CYCLE81(10,0,2,-20,,1,0,0,30)",                 // _AMODE
                             "CYCLE81(10,0,2,-20,,0,0,0,0,1)",                // further arguments
                             "CYCLE81(10,0,X,-20)",                           // no number
                             "CYCLE83(10,0,2,-20)",                           // no first depth
                             "CYCLE83(10,0,2,-20,,,25,0,,,1,1)",              // first depth below the last
                             "CYCLE83(10,0,2,-20,,,5,0,,,1,2)",               // VARI
                             "CYCLE83(10,0,2,-20,,,5,0,,,2,1)",               // FRF
                             "CYCLE83(10,0,2,-20,,,5,0,,,1,1,2)",             // _AXN
                             "CYCLE83(10,0,2,-20,,,5,-0.001,,,1,1)",          // too many strokes
                             "CYCLE84(10,0,2,-20,,,3,,,0,600,600)",           // no pitch
                             "CYCLE84(10,0,2,-20,,,3,8,1,0,600,600)",         // contradicting pitches
                             "CYCLE84(10,0,2,-20,,,3,8.5,,0,600,600)",        // no such thread
                             "CYCLE84(10,0,2,-20,,,3,8,,0,0,600)",            // no speed
                             "CYCLE84(10,0,2,-20,,,7,8,,0,600,600)",          // no such direction
                             "CYCLE84(10,0,2,-20,,,3,8,,0,600,600,3,,,1,5)",  // several strokes
                             "CYCLE840(10,0,2,-20,,,4,3,11,8)",               // ENC
                             "CYCLE85(10,0,2,-20,,1,60)",                     // RFF
                             "HOLES2(0,0,5,0,90,0)",
                             "HOLES2(0,0,5,0,90,1.5)",
                             "HOLES2(0,0,5,0,90,4,1000,1)"}) {
        const std::string answer = levels(call);
        EXPECT_TRUE(answer.contains("NC0605")) << call << ": " << answer;
    }
    EXPECT_TRUE(levels("G93 F2\nCYCLE81(10,0,2,-20)").contains("NC0605"));
    EXPECT_TRUE(levels("MCALL CYCLE81(10,0,2,-20)\nD0\nSUPA X5").contains("NC0605"));
    EXPECT_TRUE(levels("MCALL HOLES2(0,0,5,0,90,4)").contains("NC0628"));
    EXPECT_TRUE(levels("MCALL CYCLE800()").contains("NC0628"));
    EXPECT_TRUE(levels("MCALL MY_CYCLE(1)").contains("NC0531"));
    for (const char* call : {"POCKET3(1)", "CYCLE71(1)", "CYCLE90(1)", "SLOT1(1)", "LONGHOLE(1)", "CYCLE801(1)"})
        EXPECT_TRUE(levels(call).contains("NC0604")) << levels(call);
    EXPECT_TRUE(levels("MY_CYCLE(1)").contains("NC0531"));
}

}  // namespace
}  // namespace trunnion::nc
