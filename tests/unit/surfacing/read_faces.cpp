#include "trunnion/surfacing/read_faces.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <numbers>

#include <Eigen/LU>
#include <gtest/gtest.h>

namespace {

using namespace trunnion;
using namespace trunnion::surfacing;

const std::string kept = TRUNNION_SOURCE_DIR "/tests/unit/surfacing/faces/";
const std::string shared = TRUNNION_SHARED_DIR "/data/surfaces/";

class ReadFaces : public testing::Test {
  protected:
    void SetUp() override {
        const auto any = read_faces(kept + "sphere.step");
        if (!any && any.error().code == "SURF0101") GTEST_SKIP() << any.error().text;
    }
};

std::string code_of(const std::string& file) {
    const auto read = read_faces(file);
    return read ? "" : read.error().code;
}

int count_of(const FaceList& list, const std::string& code) {
    const auto found = std::ranges::find(list.diagnostics, code, &Diagnostic::code);
    return found == list.diagnostics.end() ? 0 : found->count;
}

std::string written(const std::string& name, const std::string& text) {
    const auto path = std::filesystem::temp_directory_path() / ("trunnion_" + name);
    std::ofstream(path) << text;
    return path.string();
}

double area_mm2(const Face& face, int grid = 200) {
    const ParameterBox box = parameter_box(face);
    const Eigen::Vector2d step = (box.high - box.low) / grid;
    double sum = 0;
    for (int i = 0; i < grid; ++i)
        for (int j = 0; j < grid; ++j) {
            const geometry::SurfacePlace at{box.low.x() + (i + 0.5) * step.x(), box.low.y() + (j + 0.5) * step.y()};
            const auto shape = shape_at(face.surface, at, face.side);
            if (shape && contains(face, at)) sum += std::sqrt(shape->first.determinant()) * step.x() * step.y();
        }
    return sum;
}

TEST_F(ReadFaces, TakesUnitsAndPolesOfASphereInInches) {
    const auto list = read_faces(kept + "sphere.step").value();
    ASSERT_EQ(list.faces.size(), 1u);
    EXPECT_NE(list.unit.find("INCH"), std::string::npos) << list.unit;
    EXPECT_GT(count_of(list, "SURF0106"), 0);  // both poles
    EXPECT_EQ(list.open_shells, 0);
    const Face& face = list.faces[0];
    const auto shape = shape_at(face.surface, {0.3, 0.4}, face.side).value();
    EXPECT_NEAR(shape.point.norm(), 10, 1e-6);
    EXPECT_NEAR(shape.normal.dot(shape.point.normalized()), 1, 1e-9);  // out of the material
    EXPECT_NEAR(geometry::principal_curvatures(shape.shape).smaller, 0.1, 1e-7);
    EXPECT_NEAR(area_mm2(face), 4 * std::numbers::pi * 100, 2);
}

TEST_F(ReadFaces, TakesBordersWithHoles) {
    const auto list = read_faces(kept + "plate_with_hole.step").value();
    ASSERT_EQ(list.faces.size(), 7u);
    EXPECT_EQ(list.shells, 1);
    EXPECT_TRUE(std::ranges::all_of(list.faces, &Face::solid));
    int holed = 0;
    for (const Face& face : list.faces) {
        if (face.loops.size() != 2) continue;
        ++holed;
        EXPECT_NEAR(area_mm2(face), 1200 - std::numbers::pi * 64, 3);
        for (const Eigen::Vector2d& p : face.loops[1]) {
            const Eigen::Vector3d at = face.surface.at(p.x(), p.y());
            EXPECT_NEAR(std::hypot(at.x() - 20, at.y() - 15), 8, 0.01);
        }
        // Up at the top, down at the bottom.
        const auto shape = shape_at(face.surface, {0.1, 0.1}, face.side).value();
        EXPECT_NEAR(shape.normal.z(), shape.point.z() > 2 ? 1 : -1, 1e-12);
    }
    EXPECT_EQ(holed, 2);
}

TEST_F(ReadFaces, SaysWhereAShellIsOpen) {
    const auto list = read_faces(kept + "open_shell.step").value();
    EXPECT_EQ(list.faces.size(), 2u);
    EXPECT_GT(list.open_shells, 0);
    EXPECT_TRUE(std::ranges::none_of(list.faces, &Face::solid));
    EXPECT_EQ(count_of(list, "SURF0108"), list.open_shells);
}

TEST_F(ReadFaces, ReadsIges) {
    const auto list = read_faces(kept + "two_faces.iges").value();
    ASSERT_EQ(list.faces.size(), 2u);
    for (const Face& face : list.faces) EXPECT_NEAR(area_mm2(face), 100, 1e-6);  // written in inches
}

/// The six faces of a block, each on its own, one of which looks into it.
TEST_F(ReadFaces, LooseFacesThatCloseABodyLookOutOfIt) {
    const auto list = read_faces(kept + "loose_box.iges").value();
    ASSERT_EQ(list.faces.size(), 6u);
    EXPECT_EQ(list.shells, 0);
    EXPECT_EQ(count_of(list, "SURF0110"), 1);
    for (const Face& face : list.faces) {
        EXPECT_TRUE(face.solid);
        const Eigen::Vector2d at = 0.5 * (parameter_box(face).low + parameter_box(face).high);
        const auto shape = shape_at(face.surface, {at.x(), at.y()}, face.side).value();
        EXPECT_GT(shape.normal.dot(shape.point - Eigen::Vector3d(10, 5, 3)), 1) << face.number;
    }
}

TEST_F(ReadFaces, RefusesWhatHoldsNoFaces) {
    EXPECT_EQ(code_of(kept + "missing.step"), "SURF0103");
    EXPECT_EQ(code_of(written("garbage.step", "no surface at all\n")), "SURF0103");
    EXPECT_EQ(code_of(written("garbage.igs", "no surface at all\n")), "SURF0104");  // taken for an empty one
    EXPECT_EQ(code_of(written("surface.3dm", "3D Geometry File")), "SURF0102");
    EXPECT_EQ(code_of(written("empty.stp",
                              "ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION((''),'2;1');\n"
                              "FILE_NAME('','',(''),(''),'','','');\nFILE_SCHEMA(('AUTOMOTIVE_DESIGN'));\n"
                              "ENDSEC;\nDATA;\nENDSEC;\nEND-ISO-10303-21;\n")),
              "SURF0104");
}

TEST_F(ReadFaces, HalfAFileIsBrokenOrHasFewerFaces) {
    std::ifstream whole(kept + "plate_with_hole.step");
    std::string text((std::istreambuf_iterator<char>(whole)), {});
    const auto read = read_faces(written("half.step", text.substr(0, text.size() / 2)));
    if (read) {
        EXPECT_LT(read->faces.size(), 7u);
    } else {
        EXPECT_TRUE(read.error().code == "SURF0103" || read.error().code == "SURF0104") << read.error().code;
    }
}

struct Known {
    const char* file;
    std::size_t faces;
    int open_shells, degenerate_edges;
    std::size_t solid;
};

class ReadFacesOfOthers : public testing::TestWithParam<Known> {};

TEST_P(ReadFacesOfOthers, FindsAllFaces) {
    const Known& known = GetParam();
    if (!std::filesystem::exists(shared + known.file)) GTEST_SKIP() << "without the shared folder";
    const auto list = read_faces(shared + known.file);
    if (!list && list.error().code == "SURF0101") GTEST_SKIP() << list.error().text;
    ASSERT_TRUE(list) << to_string(list.error());
    EXPECT_EQ(list->faces.size(), known.faces);
    EXPECT_EQ(list->faces_in_file, static_cast<int>(known.faces));
    EXPECT_EQ(list->open_shells, known.open_shells);
    EXPECT_EQ(count_of(*list, "SURF0106"), known.degenerate_edges);
    EXPECT_EQ(static_cast<std::size_t>(std::ranges::count_if(list->faces, &Face::solid)), known.solid);
    for (const Face& face : list->faces) {
        EXPECT_FALSE(face.loops.empty());
        const ParameterBox box = parameter_box(face);
        EXPECT_GT((box.high - box.low).minCoeff(), 0) << face.number;
    }
}

INSTANTIATE_TEST_SUITE_P(
    Files, ReadFacesOfOthers,
    testing::Values(Known{"bladex_blade_upper.iges", 1, 0, 0, 0},
                    Known{"bladex_propeller_and_shaft.iges", 22, 0, 11, 22}, Known{"occt_hammer.iges", 45, 0, 0, 45},
                    Known{"pygem_bent_pipe.step", 6, 6, 0, 0}, Known{"propeller_d.step", 51, 0, 2, 51},
                    Known{"pythonocc_splinecage.stp", 4, 4, 0, 0}, Known{"pythonocc_surf114.igs", 4, 0, 0, 0},
                    Known{"uav_wing.step", 3, 0, 0, 3}));

}  // namespace
