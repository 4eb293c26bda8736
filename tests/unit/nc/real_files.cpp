#include <charconv>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "trunnion/base/quantity.hpp"

#include "curves.hpp"
#include "reading.hpp"

namespace trunnion::nc {
namespace {

namespace fs = std::filesystem;

const fs::path shared = TRUNNION_SHARED_DIR;

Result<program::Program> read_shared(const fs::path& file, Units units = Units::none, bool feed_elsewhere = false) {
    static const machine::Machine machine = machine_with("AC");
    ReadOptions options;
    options.machine = &machine;
    options.units = units;
    options.feed_given_elsewhere = feed_elsewhere;
    return read_program_file(shared / "data" / file, options);
}

class RealFiles : public testing::Test {
  protected:
    void SetUp() override {
        if (!fs::exists(shared / "data/nc")) GTEST_SKIP() << shared << " is absent";
    }
};

/// Columns of a table by name; empty fields and words are left out.
std::vector<std::map<std::string, double>> table_of(const fs::path& file) {
    const auto fields = [](const std::string& line) {
        std::vector<std::string> out(1);
        for (const char c : line) c == ',' ? out.emplace_back() : out.back().append(1, c);
        return out;
    };
    std::ifstream in(file);
    std::string line;
    std::getline(in, line);
    const auto head = fields(line);
    std::vector<std::map<std::string, double>> rows;
    while (std::getline(in, line)) {
        auto& row = rows.emplace_back();
        const auto values = fields(line);
        for (std::size_t i = 0; i < values.size(); ++i) {
            double value = 0;
            const auto* const end = values[i].data() + values[i].size();
            if (std::from_chars(values[i].data(), end, value).ptr == end) row[head[i]] = value;
        }
    }
    return rows;
}

void expect_row(const program::Program& program, const program::Move& move, const std::map<std::string, double>& row) {
    EXPECT_NEAR(move.position_mm.x(), row.at("x_mm"), 1e-9);
    EXPECT_NEAR(move.position_mm.y(), row.at("y_mm"), 1e-9);
    EXPECT_NEAR(move.position_mm.z(), row.at("z_mm"), 1e-9);
    if (move.law == program::OrientationLaw::vector) {
        EXPECT_NEAR(move.axis.x(), row.at("i"), 1e-9);
        EXPECT_NEAR(move.axis.y(), row.at("j"), 1e-9);
        EXPECT_NEAR(move.axis.z(), row.at("k"), 1e-9);
    }
    for (std::size_t i = 0; i < program.rotary_letters.size(); ++i)
        EXPECT_NEAR(move.rotary_rad[i] / degree, row.at(std::string(1, program.rotary_letters[i]) + "_deg"), 1e-9);
}

TEST_F(RealFiles, CasesAreTheirTruth) {
    int cases = 0;
    for (const auto& entry : fs::directory_iterator(shared / "data/cases")) {
        const fs::path file = entry.path();
        if (file.extension() != ".ngc" && file.extension() != ".cls") continue;
        SCOPED_TRACE(file.filename());
        const auto program = read_shared(file);
        ASSERT_TRUE(program) << said(program);
        EXPECT_TRUE(program->diagnostics.empty());
        const auto truth = table_of(fs::path(file).replace_extension(".csv"));
        ASSERT_EQ(program->moves.size(), truth.size());
        for (std::size_t i = 0; i < truth.size(); ++i) expect_row(*program, program->moves[i], truth[i]);
        EXPECT_EQ(program->rotary_letters.size(), file.extension() == ".ngc" ? 2u : 0u);
        ++cases;
    }
    EXPECT_EQ(cases, 12);
}

TEST_F(RealFiles, CaseFeeds) {
    EXPECT_DOUBLE_EQ(read_shared("cases/sine-10k.ngc")->moves.at(7).feed.value, 10000. / 60);
    EXPECT_DOUBLE_EQ(read_shared("cases/pyramid.cls")->moves.at(2).feed.value, 500);
    const auto turn = read_shared("cases/turn.ngc");
    EXPECT_EQ(turn->moves.at(1).feed.rule, program::FeedRule::rotary_rate);
    EXPECT_DOUBLE_EQ(turn->moves.at(1).feed.value, 100 * degree);
}

TEST_F(RealFiles, LinuxcncImpeller) {
    const auto p = read_shared("nc/linuxcnc/impeller-7bl-xyzac.ngc");
    ASSERT_TRUE(p) << said(p);
    EXPECT_EQ(p->moves.size(), 4492u);
    EXPECT_EQ(p->rotary_letters, (std::vector<char>{'A', 'C'}));
    EXPECT_EQ(p->moves[2].feed.rule, program::FeedRule::block_time);
    EXPECT_DOUBLE_EQ(p->moves[2].feed.value, 60. / 318);
    EXPECT_EQ(std::ranges::count(p->moves, program::MoveKind::rapid, &program::Move::kind), 186);
    for (const auto& move : p->moves) ASSERT_EQ(move.space, program::Space::workpiece);
    EXPECT_EQ(p->diagnostics.size(), 1u);
    EXPECT_TRUE(told(*p, "NC0011"));
}

TEST_F(RealFiles, CreoFinishing) {
    for (const char* file : {"nc/apt/finition_creo.ncl", "nc/apt/finition2_creo.ncl"}) {
        const auto p = read_shared(file, Units::mm);
        ASSERT_TRUE(p) << said(p);
        EXPECT_EQ(p->moves.size(), 35418u);
        EXPECT_EQ(std::ranges::count(p->moves, program::MoveKind::rapid, &program::Move::kind), 19);
        EXPECT_DOUBLE_EQ(p->moves[2].feed.value, 1193.663081 * inch_mm / 60);
        EXPECT_EQ(p->tools.at(p->moves[2].tool), "2");
    }
    const auto p = read_shared("nc/apt/finition_creo.ncl", Units::mm);
    EXPECT_EQ(p->moves[0].position_mm, Eigen::Vector3d(245.1295775618, -22.7813938898, 43.5028538928));
    EXPECT_EQ(told(*p, "NC0012", "PPWORD")->count, 62);
    EXPECT_DOUBLE_EQ(read_shared("nc/apt/finition_creo.ncl")->moves[0].position_mm.x(), 245.1295775618 * inch_mm);
}

TEST_F(RealFiles, PosesWithoutFeeds) {
    EXPECT_EQ(read_shared("nc/apt/hust_pathpoints.cls").error().code, "NC0205");
    EXPECT_EQ(read_shared("nc/apt/hust_pathpoints.cls", Units::mm, true)->moves.size(), 39u);
    EXPECT_EQ(read_shared("nc/apt/hust_yelun_impeller.cls", Units::mm, true)->moves.size(), 52u);
    for (int layer = 2; layer <= 25; ++layer) {
        const auto p = read_shared("nc/apt/waypoints_freeform/" + std::to_string(layer) + ".txt", Units::mm, true);
        ASSERT_TRUE(p) << said(p);
        EXPECT_GT(p->moves.size(), 80u);
    }
}

/// 3-axis finishing by cubics: 70 curves between lines, as fast along the parameter as along the path.
TEST_F(RealFiles, NurbsOfNx) {
    const auto p = read_shared("nc/apt/nurbs_nx.clsf", Units::mm);
    ASSERT_TRUE(p) << said(p);
    expect_sound_curves(*p);
    ASSERT_EQ(p->curves.size(), 70u);
    EXPECT_EQ(std::ranges::count(p->moves, program::no_curve_part, &program::Move::curve_part), 78);
    EXPECT_EQ(p->moves.size(), 78u + 1413 - 2 * 70);
    for (const program::Curve& curve : p->curves) {
        const double end = curve.knots.back();
        constexpr int steps = 200;
        std::vector<double> length{0};
        Eigen::Vector3d last = curve.position_mm.front();
        for (int i = 1; i < steps; ++i) {
            const Eigen::Vector3d at = blended(curve, curve.position_mm, end * i / steps);
            length.push_back(length.back() + (at - last).norm());
            last = at;
        }
        const double whole = length.back() + (curve.position_mm.back() - last).norm();
        for (int i = 0; i < steps; ++i) ASSERT_NEAR(length[static_cast<std::size_t>(i)] / whole, 1.0 * i / steps, 0.06);
    }
}

TEST_F(RealFiles, TheRestIsRefusedWithAReason) {
    const std::map<std::string, std::string> expected = {
        {"apt/aptos_multest.apt", "NC0204"},
        {"apt/catia_demo3.aptsource", "NC0404"},
        {"linuxcnc/diffuser_fin2_finishing_4ax.ngc", "NC0006"},
        {"heidenhain/dmc100_tnc_in.h", "NC0708"},
        {"haas/umc750_final_toolpath_in.nc", "NC0827"},
        {"additive/ring_bc.gcode", "NC0306"},
    };
    for (const auto& [file, code] : expected) {
        const auto p = read_shared(fs::path("nc") / file, Units::mm, true);
        ASSERT_FALSE(p) << file;
        EXPECT_EQ(p.error().code, code) << said(p);
    }
    int files = 0;
    for (const auto& entry : fs::recursive_directory_iterator(shared / "data/nc")) {
        if (!entry.is_regular_file()) continue;
        const auto p = read_shared(entry.path());
        EXPECT_TRUE(p || p.error().code.starts_with("NC0")) << entry.path();
        ++files;
    }
    EXPECT_GT(files, 40);
}

}  // namespace
}  // namespace trunnion::nc
