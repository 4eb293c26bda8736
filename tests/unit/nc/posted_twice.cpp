// One part posted for two controls, read by both readers: where the two programs say the same, the tip paths are equal.
//
// The Siemens program (TRAORI) says the tip in the part. The Fanuc one (G43.4) says it along the machine's axes: its
// control takes the workpiece coordinate system for programming (parameter 19696, bit 5), not the table's, and nothing
// in the text tells which. Turned back with the tables it is the tip in the part.
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "fanuc_reading.hpp"

namespace trunnion::nc {
namespace {

using Eigen::AngleAxisd;
using Eigen::Vector3d;
using program::Move;
using program::Program;

const auto posted = std::filesystem::path(TRUNNION_SHARED_DIR) / "data" / "nc";
const double same_tip_mm = std::sqrt(3) * 1e-4 * inch_mm;  ///< half a last decimal in each coordinate, of both programs
constexpr double same_axis_rad = 1.5e-3 * degree;

/// The lines of an operation, behind the one that names it.
std::string operation(const char* file, const std::string& name, const std::string& heading) {
    std::ifstream in(posted / file);
    std::string out;
    bool inside = false;
    for (std::string line; std::getline(in, line);) {
        if (line.find(heading) != line.npos)
            inside = line.find(name + ")") != line.npos;
        else if (inside && line.find("G28") == line.npos && line.find("SUPA") == line.npos)
            out += line + "\n";
    }
    return out;
}

Program siemens(const std::string& name) {
    const auto read = read_with(fanuc_machine(), "G70 G90 G17 G64\nT5 M6\nTRAORI\n" +
                                                     operation("siemens/dmu70evo_840d_in.mpf", name, ";(") + "M30\n");
    EXPECT_TRUE(read) << said(read);
    return read ? *read : Program{};
}

/// As it is read: in the table's axes.
Program fanuc_as_read(const std::string& name) {
    const auto read = read_fanuc_text("%\nO1\nG20 G90 G94 G17\nT5 M6\nG0 B0. C0.\nG43.4 H5\n" +
                                      operation("fanuc/nmv5000_g434_in.nc", name, "(Operation Name") + "M30\n%\n");
    EXPECT_TRUE(read) << said(read);
    return read ? *read : Program{};
}

/// How the part is turned to the tool: C on B about Y for one machine, on B inclined by 45° for the other.
Eigen::Matrix3d turn_of(const Program& program, const Move& move) {
    const bool inclined = program.dialect == "sinumerik";
    const Vector3d about = inclined ? Vector3d(0, -1, 1).normalized() : Vector3d(0, 1, 0);
    return (AngleAxisd(move.rotary_rad[1], Vector3d::UnitZ()) * AngleAxisd(move.rotary_rad[0], about))
        .toRotationMatrix();
}

Vector3d axis_of(const Program& program, const Move& move) {
    return turn_of(program, move) * Vector3d::UnitZ();
}

/// The tip in the part where it is said along the machine's axes.
Program fanuc(const std::string& name) {
    Program out = fanuc_as_read(name);
    for (Move& move : out.moves) move.position_mm = turn_of(out, move) * move.position_mm;
    return out;
}

struct Alike {
    int moves = 0, tips = 0, axes = 0;
    double tip_mm = 0;
};

/// How many ends of the Fanuc program are, in order, places of the Siemens one, once its work offset stands where
/// the first of them is; one program may have blocks that the other has not.
Alike compare(const Program& theirs, const Program& ours, std::size_t first_of_ours) {
    Alike out{.moves = static_cast<int>(theirs.moves.size())};
    if (theirs.moves.empty() || first_of_ours >= ours.moves.size()) return out;
    const Vector3d offset = ours.moves.at(first_of_ours).position_mm - theirs.moves.at(0).position_mm;
    std::size_t next = first_of_ours;
    for (const Move& move : theirs.moves)
        for (std::size_t i = next; i < std::min(next + 6, ours.moves.size()); ++i) {
            const double miss = (move.position_mm + offset - ours.moves[i].position_mm).norm();
            if (!(miss <= 2 * same_tip_mm)) continue;  // the offset has an error of its own
            ++out.tips;
            out.tip_mm = std::max(out.tip_mm, miss);
            out.axes += (axis_of(theirs, move) - axis_of(ours, ours.moves[i])).norm() <= same_axis_rad ? 1 : 0;
            next = i + 1;
            break;
        }
    return out;
}

class PostedTwice : public testing::Test {
  protected:
    void SetUp() override {
        if (!std::filesystem::exists(posted / "siemens/dmu70evo_840d_in.mpf")) GTEST_SKIP() << posted << " is absent";
    }
};

/// Every tip of the spiral; every tool axis as long as the Siemens program says B and C, to a tilt of 67°.
TEST_F(PostedTwice, the_spiral_over_the_part) {
    const Program ours = siemens("VARIABLE_CONTOUR_MCS9"), theirs = fanuc("VARIABLE_CONTOUR_MCS9");
    const Alike alike = compare(theirs, ours, 0);
    EXPECT_EQ(alike.moves, 347);
    EXPECT_EQ(alike.tips, 347);
    EXPECT_GE(alike.axes, 309);
    EXPECT_GT(alike.tip_mm, 0);
}

/// In planes across the tool, each in a work offset of its own.
TEST_F(PostedTwice, passes_in_tilted_planes) {
    struct Plane {
        const char* name;
        int moves, tips;
    };
    // Two blocks of the second one, where it dives under the surface, differ by 30 µm in the programs themselves:
    // line 309 X.4935 Y.0065 and N369 X1.7632 Z1.3864.
    for (const Plane& plane : {Plane{"VARIABLE_CONTOUR_MCS1", 18, 18},
                               {"VARIABLE_CONTOUR_MCS2", 24, 22},
                               {"VARIABLE_CONTOUR_MCS3", 22, 22}}) {
        SCOPED_TRACE(plane.name);
        const Program ours = siemens(plane.name), theirs = fanuc(plane.name);
        Alike best;
        for (std::size_t first = 0; first < 4; ++first)
            if (const Alike found = compare(theirs, ours, first); found.tips > best.tips) best = found;
        EXPECT_EQ(best.moves, plane.moves);
        EXPECT_EQ(best.tips, plane.tips);
        EXPECT_EQ(best.axes, plane.tips);
    }
}

/// In the table's axes, as a control with the parameter at 0 takes G43.4, the spiral is another path.
TEST_F(PostedTwice, along_the_table_it_is_another_path) {
    const Program ours = siemens("VARIABLE_CONTOUR_MCS9"), theirs = fanuc_as_read("VARIABLE_CONTOUR_MCS9");
    EXPECT_LT(compare(theirs, ours, 0).tips, 20);
}

}  // namespace
}  // namespace trunnion::nc
