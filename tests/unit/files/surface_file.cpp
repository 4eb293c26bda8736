// Surfaces given by numbers.
#include "trunnion/files/surface_file.hpp"

#include <string>

#include <gtest/gtest.h>

namespace trunnion::files {
namespace {

using Eigen::Vector3d;

std::string code_of(std::string_view text) {
    const auto read = read_surfaces(text, "s.toml");
    return read ? "" : read.error().code;
}

TEST(SurfaceFile, Coefficients) {
    const auto read = read_surfaces(R"(
[[surface]]
coefficients_mm = [[[1, 2, 3], [0, 4, 0]], [[5, 0, 0], [0, 0, 0]], [[0, 0, 6], [0, 0, 7]]]
)",
                                    "s.toml");
    ASSERT_TRUE(read) << to_string(read.error());
    ASSERT_EQ(read->size(), 1u);
    const auto& surface = read->front().surface;
    EXPECT_EQ(surface.u().degree, 2);
    EXPECT_EQ(surface.v().degree, 1);
    const double u = 0.3, v = 0.8;
    const Vector3d expected(1 + 5 * u, 2 + 4 * v, 3 + 6 * u * u + 7 * u * u * v);
    EXPECT_LT((surface.at(u, v) - expected).norm(), 1e-13);
    EXPECT_EQ(read->front().side, geometry::Side::along);
}

TEST(SurfaceFile, NetWithKnotsAndWeights) {
    // A quarter of a cylinder of radius 10 about Y, exact with weights.
    const auto read = read_surfaces(R"(
[[surface]]
side = "against"
degree = [2, 1]
knots_u = [0, 0, 0, 2, 2, 2]
knots_v = [0.0, 0.0, 1.0, 1.0]
control_points_mm = [[[10, 0, 0], [10, 5, 0]], [[10, 0, 10], [10, 5, 10]], [[0, 0, 10], [0, 5, 10]]]
weights = [[1, 1], [0.7071067811865476, 0.7071067811865476], [1, 1]]
)",
                                    "s.toml");
    ASSERT_TRUE(read) << to_string(read.error());
    const auto& [surface, side] = read->front();
    EXPECT_EQ(side, geometry::Side::against);
    EXPECT_EQ(surface.u().end(), 2);
    for (const double u : {0.0, 0.4, 1.1, 2.0}) {
        const Vector3d p = surface.at(u, 0.5);
        EXPECT_NEAR(std::hypot(p.x(), p.z()), 10, 1e-12);
        EXPECT_NEAR(p.y(), 2.5, 1e-12);
    }
}

TEST(SurfaceFile, WithoutKnotsTheyAreUniformAndClamped) {
    std::string text;
    for (const int rows : {3, 6}) {  // quadratic, as three points have no cubic; cubic
        text += "[[surface]]\ncontrol_points_mm = [\n";
        for (int i = 0; i < rows; ++i) {
            text += "[";
            for (int j = 0; j < 4; ++j)
                text += "[" + std::to_string(i) + ", " + std::to_string(j) + ", " + std::to_string(i * j) + "], ";
            text += "],\n";
        }
        text += "]\n";
    }
    const auto read = read_surfaces(text, "s.toml");
    ASSERT_TRUE(read) << to_string(read.error());
    ASSERT_EQ(read->size(), 2u);
    EXPECT_EQ((*read)[0].surface.u().degree, 2);
    EXPECT_EQ((*read)[1].surface.u().knots, (std::vector<double>{0, 0, 0, 0, 1.0 / 3, 2.0 / 3, 1, 1, 1, 1}));
    EXPECT_LT(((*read)[1].surface.at(1, 1) - Vector3d(5, 3, 15)).norm(), 1e-12);
}

TEST(SurfaceFile, SaysWhatIsWrongAndWhere) {
    EXPECT_EQ(code_of("[[surface]"), "FILE0102");
    EXPECT_EQ(code_of(""), "FILE0119");
    EXPECT_EQ(code_of("[[surface]]\n"), "FILE0103");
    EXPECT_EQ(code_of("surface = 3\n"), "FILE0105");
    EXPECT_EQ(code_of("[[face]]\n"), "FILE0104");
    EXPECT_EQ(code_of("[[surface]]\ncontrol_points = []\n"), "FILE0104");
    const std::string net = "[[surface]]\ncontrol_points_mm = [[[0, 0, 0], [0, 1, 0]], [[1, 0, 0], [1, 1, 0]]]\n";
    EXPECT_EQ(code_of(net), "");
    EXPECT_EQ(code_of(net + "coefficients_mm = [[[0, 0, 0]]]\n"), "FILE0103");
    EXPECT_EQ(code_of(net + "side = \"left\"\n"), "FILE0113");
    EXPECT_EQ(code_of(net + "degree = 1\n"), "FILE0105");
    EXPECT_EQ(code_of(net + "degree = [1.0, 1]\n"), "FILE0105");
    EXPECT_EQ(code_of(net + "degree = [0, 1]\n"), "GEOM0101");
    EXPECT_EQ(code_of(net + "degree = [9000000000, 1]\n"), "GEOM0101");
    EXPECT_EQ(code_of(net + "degree = [2, 1]\n"), "GEOM0102");
    EXPECT_EQ(code_of(net + "knots_v = [0, 0, 1]\n"), "GEOM0102");
    EXPECT_EQ(code_of(net + "knots_v = [0, 1, 0, 1]\n"), "GEOM0103");
    EXPECT_EQ(code_of(net + "knots_v = [0, 0, nan, 1]\n"), "FILE0105");
    EXPECT_EQ(code_of(net + "weights = [[1, 1], [1, -1]]\n"), "GEOM0107");
    EXPECT_EQ(code_of(net + "weights = [[1, 1]]\n"), "GEOM0107");
    EXPECT_EQ(code_of("[[surface]]\ncontrol_points_mm = [[[0, 0, 0]]]\n"), "GEOM0101");
    EXPECT_EQ(code_of("[[surface]]\ncoefficients_mm = [[[0, 0, 0], [0, 1]]]\n"), "FILE0105");
    EXPECT_EQ(code_of("[[surface]]\ncoefficients_mm = [[[0, 0, 0], [0, 1, \"0 mm\"]]]\n"), "FILE0105");
    EXPECT_EQ(code_of("[[surface]]\ncoefficients_mm = [[[0, 0, 0], [0, 1, inf]]]\n"), "FILE0105");
    const auto ragged = read_surfaces(
        "# two rows\n[[surface]]\ncontrol_points_mm = [\n[[0, 0, 0], [0, 1, 0]],\n[[1, 0, 0]]]\n", "s.toml");
    ASSERT_FALSE(ragged);
    EXPECT_EQ(ragged.error().code, "FILE0105");
    EXPECT_EQ(ragged.error().place.line, 5);
    EXPECT_EQ(ragged.error().place.file, "s.toml");
    const auto degrees = read_surfaces("\n" + net + "degree = [4, 1]\n", "s.toml");
    ASSERT_FALSE(degrees);
    EXPECT_EQ(degrees.error().place.line, 2) << "the table that is no surface";
    EXPECT_EQ(read_surface_file("no such file").error().code, "FILE0101");
}

}  // namespace
}  // namespace trunnion::files
