#include <cmath>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "fanuc_reading.hpp"

namespace trunnion::nc {
namespace {

namespace fs = std::filesystem;

const fs::path shared = TRUNNION_SHARED_DIR;

class FanucRealFiles : public testing::Test {
  protected:
    void SetUp() override {
        if (!fs::exists(shared / "data/nc")) GTEST_SKIP() << shared << " is absent";
    }
    static Result<program::Program> read_shared(const fs::path& file, const machine::Machine& machine) {
        ReadOptions options;
        options.machine = &machine;
        return read_program_file(shared / "data/nc" / file, options);
    }
};

TEST_F(FanucRealFiles, Nmv5000) {
    const auto p = read_shared("fanuc/nmv5000_g434_in.nc", fanuc_machine());
    ASSERT_TRUE(p) << said(p);
    EXPECT_EQ(p->dialect, "fanuc");
    EXPECT_EQ(p->name, "O0001");
    EXPECT_LT((p->moves[0].position_mm - Eigen::Vector3d(2.187, .488, 2.0685) * inch_mm).norm(), 1e-9);
    EXPECT_EQ(p->moves[0].space, program::Space::workpiece);
    EXPECT_EQ(p->tools.at(p->moves[0].tool), "8");
    EXPECT_GT(p->moves.size(), 850u);
    EXPECT_EQ(p->arcs.size(), 45u);
    EXPECT_EQ(told(*p, "NC0862")->count, 28);
    EXPECT_TRUE(told(*p, "NC0861"));
}

TEST_F(FanucRealFiles, HaasUmc750) {
    const auto p = read_shared("haas/umc750_final_toolpath_in.nc", fanuc_machine());
    ASSERT_TRUE(p) << said(p);
    EXPECT_EQ(p->name, "OFinal ToolPath");
    EXPECT_GT(p->moves.size(), 15500u);
    double most_turns = 0;
    for (const auto& move : p->moves)
        if (move.law == program::OrientationLaw::rotary && p->rotary_letters.size() == 2 &&
            !std::isnan(move.rotary_rad[1]))
            most_turns = std::max(most_turns, std::abs(move.rotary_rad[1]) / degree);
    EXPECT_GT(most_turns, 360);
}

/// Its M128 would be passed over as a machine function; only the machine file can say that it is not.
TEST_F(FanucRealFiles, AileronBracket) {
    machine::Machine machine = machine_with("AC");
    machine.words = {};
    const auto p = read_shared("iso/aileron_bracket_edgecam_ac.nc", machine);
    ASSERT_FALSE(p);
    EXPECT_EQ(p.error().code, "NC0851");
    machine.words = {.tcp_on = {"M128"}, .tcp_off = {"M126"}, .ignore = {}, .following = {}};
    const auto declared = read_shared("iso/aileron_bracket_edgecam_ac.nc", machine);
    ASSERT_TRUE(declared) << said(declared);
    EXPECT_GT(declared->moves.size(), 10000u);
    EXPECT_GT(declared->arcs.size(), 2500u);
}

TEST_F(FanucRealFiles, OthersAreNotTaken) {
    for (const char* folder : {"data/nc/linuxcnc", "data/nc/siemens", "data/nc/additive", "data/cases"})
        for (const auto& entry : fs::directory_iterator(shared / folder)) {
            if (entry.path().extension() == ".csv") continue;
            const auto p = read_shared(entry.path(), machine_with("BC"));
            EXPECT_TRUE(!p || p->dialect != "fanuc") << entry.path();
            EXPECT_TRUE(p || !p.error().code.starts_with("NC08")) << entry.path() << said(p);
        }
}

}  // namespace
}  // namespace trunnion::nc
