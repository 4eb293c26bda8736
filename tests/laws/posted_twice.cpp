// One part posted for two controls: a table on a 45° swivel (Siemens, TRAORI) and a trunnion table (Fanuc, G43.4).
// Block for block the tool stands in the same pose of the part, so each machine file explains the other's program.
//
// The Siemens program gives the tip in the part, its corner at 0; the Fanuc one gives it in axes that stay parallel to
// the machine's, from the middle of the part's top, which its table turns about: those are the axis positions of a
// machine whose rotary axes cross there.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "trunnion/base/quantity.hpp"
#include "trunnion/files/machine_file.hpp"
#include "trunnion/machine/kinematics.hpp"
#include "trunnion/nc/read.hpp"

namespace {

using namespace trunnion;
using namespace trunnion::machine;
using Eigen::Vector3d;

constexpr double inch_mm = 25.4;
constexpr double part_size_mm = 50;  // a cube; the finishing operation is about the middle of its top
constexpr double posted_length_mm = 1e-4 * inch_mm, posted_angle_rad = 1e-3 * degree;  // last decimals
const double same_tip_mm = std::sqrt(3) * posted_length_mm;  // half a decimal in each coordinate, of both programs
constexpr double same_axis_rad = 1.5 * posted_angle_rad;     // half a decimal of both angles, of both programs

/// A block that moves both rotary axes together with others.
struct Block {
    Vector3d xyz_mm;
    RotaryPosition bc_rad;
};

/// The blocks with B and C between the line that names the operation and the next such line.
std::vector<Block> simultaneous_blocks(const std::filesystem::path& file, const std::string& operation,
                                       const std::string& heading) {
    std::vector<Block> out;
    std::array<double, 256> word{};
    bool inside = false;
    std::ifstream in(file);
    for (std::string line; std::getline(in, line);) {
        if (line.find(heading) != std::string::npos) inside = line.find(operation + ")") != std::string::npos;
        if (!inside || line.find('(') != std::string::npos) continue;
        std::string letters;
        for (const char* at = line.c_str(); *at != 0;) {
            const char letter = *at++;
            if (letter < 'A' || letter > 'Z') continue;
            char* end = nullptr;
            const double value = std::strtod(at, &end);
            if (end == at) continue;
            word[static_cast<unsigned char>(letter)] = value;
            letters += letter;
            at = end;
        }
        if (letters.find('B') == std::string::npos || letters.find('C') == std::string::npos) continue;
        out.push_back({inch_mm * Vector3d(word['X'], word['Y'], word['Z']), {word['B'] * degree, word['C'] * degree}});
    }
    return out;
}

class PostedTwice : public testing::Test {
  protected:
    void SetUp() override {
        const auto nc = std::filesystem::path(TRUNNION_SHARED_DIR) / "data" / "nc";
        const auto siemens_file = nc / "siemens/dmu70evo_840d_in.mpf", fanuc_file = nc / "fanuc/nmv5000_g434_in.nc";
        if (!std::filesystem::exists(siemens_file)) GTEST_SKIP() << siemens_file << " is not here";
        siemens = simultaneous_blocks(siemens_file, "VARIABLE_CONTOUR_MCS9", ";(");
        fanuc = simultaneous_blocks(fanuc_file, "VARIABLE_CONTOUR_MCS9", "(Operation Name");
        fanuc.erase(fanuc.begin());  // the approach; the Siemens program gives its words one by one
    }
    static Machine shipped(const char* name) {
        return files::read_machine_file(std::filesystem::path(TRUNNION_SOURCE_DIR) / "data/machines" /
                                        (std::string(name) + ".toml"))
            .value();
    }
    static Pose pose_of_siemens(const Kinematics& dmu, const Block& block) {
        return {block.xyz_mm - Vector3d(part_size_mm / 2, part_size_mm / 2, part_size_mm), dmu.tool_axis(block.bc_rad)};
    }
    static Pose pose_of_fanuc(const Kinematics& nmv, const Block& block) {
        return nmv.forward({{block.xyz_mm.x(), block.xyz_mm.y(), block.xyz_mm.z(), block.bc_rad[0], block.bc_rad[1]}});
    }
    /// Pairs of blocks at the same tip, in order; one program may have a block that the other has not.
    std::vector<std::pair<Block, Block>> pairs(const Kinematics& nmv) const {
        std::vector<std::pair<Block, Block>> out;
        std::size_t next = 0;
        for (const Block& block : siemens) {
            const Vector3d tip = pose_of_siemens(nmv, block).tip_in_workpiece_mm;
            for (std::size_t i = next; i < std::min(next + 3, fanuc.size()); ++i) {
                if ((pose_of_fanuc(nmv, fanuc[i]).tip_in_workpiece_mm - tip).norm() > same_tip_mm) continue;
                out.emplace_back(block, fanuc[i]);
                next = i + 1;
                break;
            }
        }
        return out;
    }
    std::vector<Block> siemens, fanuc;
};

TEST_F(PostedTwice, BlockForBlockTheSamePose) {
    const auto dmu = Kinematics::make(shipped("dmu70evo"), {}, 0).value(),
               nmv = Kinematics::make(shipped("nmv5000"), {}, 0).value();
    ASSERT_EQ(siemens.size(), 310u);  // all that have B and C: beyond a tilt of 67° that program holds them back
    const auto both = pairs(nmv);
    EXPECT_EQ(both.size(), 309u);  // and one that the other program has not
    double tip_mm = 0, axis_rad = 0;
    for (const auto& [s, f] : both) {
        const Pose ours = pose_of_siemens(dmu, s), theirs = pose_of_fanuc(nmv, f);
        tip_mm = std::max(tip_mm, (ours.tip_in_workpiece_mm - theirs.tip_in_workpiece_mm).norm());
        axis_rad = std::max(axis_rad, (ours.axis_in_workpiece - theirs.axis_in_workpiece).norm());
    }
    EXPECT_LE(tip_mm, same_tip_mm);
    EXPECT_LE(axis_rad, same_axis_rad);
    EXPECT_GT(axis_rad, 0);
    std::cout << both.size() << " blocks, tip " << tip_mm << " mm, axis " << axis_rad / degree << " deg\n";
}

/// What is read of the Siemens program are these blocks: tip in the part, rotary words, in mm and rad.
TEST_F(PostedTwice, TheReaderGivesTheSameBlocks) {
    std::ifstream in(std::filesystem::path(TRUNNION_SHARED_DIR) / "data/nc/siemens/dmu70evo_840d_in.mpf");
    std::string text{std::istreambuf_iterator<char>(in), {}};
    text.resize(text.find("MCALL CYCLE"));  // what follows drills
    const Machine dmu = shipped("dmu70evo");
    nc::ReadOptions options;
    options.machine = &dmu;
    const auto program = nc::read_program(text, "dmu70evo_840d_in.mpf", options);
    ASSERT_TRUE(program) << to_string(program.error());
    ASSERT_EQ(program->dialect, "sinumerik");
    ASSERT_EQ(program->rotary_letters, (std::vector<char>{'B', 'C'}));
    std::size_t next = 0;
    for (const program::Move& move : program->moves) {
        if (next == siemens.size() || move.space != program::Space::workpiece) continue;
        const Block& block = siemens[next];
        const bool same = (move.position_mm - block.xyz_mm).norm() < 1e-9 &&
                          std::abs(move.rotary_rad[0] - block.bc_rad[0]) < 1e-12 &&
                          std::abs(move.rotary_rad[1] - block.bc_rad[1]) < 1e-12;
        next += same ? 1 : 0;
    }
    EXPECT_EQ(next, siemens.size());
}

/// Each program's angles come out of the other's by the inverse, on one of the two branches.
TEST_F(PostedTwice, EachProgramGivesTheAnglesOfTheOther) {
    const auto dmu = Kinematics::make(shipped("dmu70evo"), {}, 0).value(),
               nmv = Kinematics::make(shipped("nmv5000"), {}, 0).value();
    const auto expect_among = [](const Kinematics& k, const Vector3d& axis, const RotaryPosition& wanted) {
        const RotarySeries found = k.rotary_series({Taylor3(axis.x()), Taylor3(axis.y()), Taylor3(axis.z())}, wanted);
        const double slack = 2 * posted_angle_rad / k.lever(wanted);
        EXPECT_NEAR(found[0].value(), wanted[0], 2 * posted_angle_rad);
        EXPECT_NEAR(found[1].value(), wanted[1], slack);
    };
    const auto both = pairs(nmv);
    EXPECT_GT(both.size(), 300u);
    for (const auto& [s, f] : both) {
        expect_among(nmv, dmu.tool_axis(s.bc_rad), f.bc_rad);
        expect_among(dmu, nmv.tool_axis(f.bc_rad), s.bc_rad);
    }
}

/// Nothing but the directions and the counting of the shipped files does.
TEST_F(PostedTwice, WithAnotherCountingOrInclinationTheyDisagree) {
    const auto nmv = Kinematics::make(shipped("nmv5000"), {}, 0).value();
    const auto both = pairs(nmv);
    ASSERT_FALSE(both.empty());
    const auto miss_of = [&](const Machine& machine) {
        const auto k = Kinematics::make(machine, {}, 0).value();
        double out = 0;
        for (const auto& [s, f] : both) out = std::max(out, (k.tool_axis(s.bc_rad) - nmv.tool_axis(f.bc_rad)).norm());
        return out;
    };
    const Machine right = shipped("dmu70evo");
    const auto b = static_cast<std::size_t>(right.index_of('B')), c = static_cast<std::size_t>(right.index_of('C'));
    EXPECT_LE(miss_of(right), same_axis_rad);
    Machine other = right;
    other.axes[b].reversed = true;
    EXPECT_GT(miss_of(other), 0.1);
    other = right;
    other.axes[c].reversed = true;
    EXPECT_GT(miss_of(other), 0.1);
    other = right;
    other.axes[b].direction = Vector3d(0, -1, 1.001).normalized();
    EXPECT_GT(miss_of(other), 2 * same_axis_rad);
}

}  // namespace
