#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "sinumerik_reading.hpp"

namespace trunnion::nc {
namespace {

namespace fs = std::filesystem;

const fs::path programs = fs::path(TRUNNION_SHARED_DIR) / "data/nc";

class SinumerikFiles : public testing::Test {
  protected:
    void SetUp() override {
        if (!fs::exists(programs)) GTEST_SKIP() << programs << " is absent";
    }
    static std::string text_of(const fs::path& name) {
        std::ifstream in(programs / name, std::ios::binary);
        return {std::istreambuf_iterator<char>(in), {}};
    }
    static std::string without(std::string_view text, std::string_view part, std::string_view instead = "") {
        std::string rest;
        for (std::size_t at = text.find(part); at != text.npos; at = text.find(part)) {
            rest.append(text.substr(0, at)).append(instead);
            text.remove_prefix(at + part.size());
        }
        return rest.append(text);
    }
};

std::size_t arcs_of(const program::Program& p) {
    return static_cast<std::size_t>(
        std::ranges::count_if(p.moves, [](const program::Move& m) { return m.arc != program::no_arc; }));
}

TEST_F(SinumerikFiles, AllAreRecognisedAndNoOthers) {
    int sinumerik = 0, others = 0;
    for (const auto& entry : fs::recursive_directory_iterator(programs)) {
        if (!entry.is_regular_file()) continue;
        const bool is = entry.path().parent_path().filename() == "siemens";
        const auto dialect = recognise(text_of(fs::relative(entry.path(), programs)));
        EXPECT_EQ(dialect && *dialect == Dialect::sinumerik, is) << entry.path();
        ++(is ? sinumerik : others);
    }
    EXPECT_EQ(sinumerik, 5);
    EXPECT_GT(others, 40);
}

TEST_F(SinumerikFiles, AxisCrossOnFiveSides) {
    const auto p = read_bc(text_of("siemens/achskreuz_spinner_u5620.mpf"));
    ASSERT_TRUE(p) << said(p);
    EXPECT_EQ(p->rotary_letters, (std::vector<char>{'B', 'C'}));
    EXPECT_EQ(p->offsets, (std::vector<std::string>{"", "G54"}));
    EXPECT_EQ(arcs_of(*p), 696u);
    EXPECT_TRUE(p->moves.front().position_mm.isApprox(Eigen::Vector3d(-365, 224, 610)));
    const auto first_of = [&](int line) {
        return std::ranges::find_if(p->moves, [&](const program::Move& m) { return m.line == line; });
    };
    EXPECT_EQ(transcript(*p, *first_of(1034)), "R w 165.236 -15.001 -31 B90 C0") << "X31 Z165.236 under AROT Y90";
    EXPECT_EQ(transcript(*p, *first_of(1069)), "F w -6.7 52.657 -53.001 B90 C0 arc -38.0042 (-6.7 12 -39) (1 0 0)");
    EXPECT_FALSE(told(*p, "NC0654"));
    EXPECT_EQ(told(*p, "NC0659")->count, 50);
}

TEST_F(SinumerikFiles, KeyFob) {
    const auto p = read_bc(text_of("siemens/schluesselanhaenger_spinner_u5620.mpf"));
    ASSERT_TRUE(p) << said(p);
    EXPECT_EQ(p->moves.size(), 570u);
    EXPECT_NE(std::ranges::find(p->tools, "BOHRER_D3.3_VHM"), p->tools.end());
    const auto drill =
        std::ranges::find_if(p->moves, [](const program::Move& m) { return m.position_mm.z() == -6.1835; });
    ASSERT_NE(drill, p->moves.end());
    EXPECT_EQ(transcript(*p, drill[-1]) + '\n' + transcript(*p, drill[0]) + '\n' + transcript(*p, drill[1]),
              "R u -12.5 -58 3 B0 C0\nF u -12.5 -58 -6.1835 B0 C0\nR u -12.5 -58 10 B0 C0");
}

TEST_F(SinumerikFiles, MillInInchesUpToItsImpossibleCycles) {
    const std::string text = text_of("siemens/dmu70evo_840d_in.mpf");
    const auto whole = read_bc(text);
    ASSERT_FALSE(whole);
    EXPECT_EQ(whole.error().code, "NC0605") << said(whole);
    EXPECT_EQ(whole.error().place.line, 903) << "the first hole whose retraction plane lies below its surface";
    const auto p = read_bc(text.substr(0, text.find("N883 ")));
    ASSERT_TRUE(p) << said(p);
    EXPECT_EQ(p->moves.size(), 802u);
    EXPECT_TRUE(p->moves.front().position_mm.isApprox(Eigen::Vector3d(2.54, -2.54, -2.54)));
    const auto turning = std::ranges::count_if(p->moves, [](const program::Move& m) {
        return m.space == program::Space::workpiece && m.rotary_rad[1] > 1700 * degree;
    });
    EXPECT_GT(turning, 50) << "C beyond four turns is literal";
}

TEST_F(SinumerikFiles, TrainingPartButForCompensation) {
    const std::string text = text_of("siemens/huron_kx20_training.mpf");
    const auto whole = read_bc(text);
    ASSERT_FALSE(whole);
    EXPECT_EQ(whole.error().code, "NC0603") << said(whole);
    EXPECT_EQ(whole.error().place.line, 118);
    std::string rest = without(without(without(text, "G41"), "G42"), "TURN=.5");
    rest = without(rest, "CYCLE90 (", ";");
    const auto p = read_bc(rest);
    ASSERT_TRUE(p) << said(p);
    EXPECT_EQ(p->moves.size(), 329u);
    EXPECT_EQ(std::ranges::count_if(p->moves, [](const program::Move& m) { return m.position_mm.z() == -33.004; }), 4);
    EXPECT_EQ(read_bc(without(without(text, "G41"), "G42")).error().code, "NC0212") << "TURN=.5 is no whole number";
    EXPECT_EQ(read_bc(without(without(without(text, "G41"), "G42"), "TURN=.5")).error().code, "NC0604") << "CYCLE90";
}

TEST_F(SinumerikFiles, SubprogramsThatAreNotThereAreNamed) {
    const auto p = read_bc(text_of("siemens/edytornc_sinumerik840d.nc"));
    ASSERT_FALSE(p);
    EXPECT_EQ(p.error().code, "NC0531") << said(p);
    EXPECT_EQ(p.error().place.line, 24);
}

}  // namespace
}  // namespace trunnion::nc
