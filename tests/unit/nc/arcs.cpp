#include "detail/arcs.hpp"

#include <cmath>
#include <cstdint>
#include <numbers>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

namespace trunnion::nc {
namespace {

using Eigen::Vector3d;
using program::Arc;

constexpr double pi = std::numbers::pi;
const Vector3d x = Vector3d::UnitX(), y = Vector3d::UnitY(), z = Vector3d::UnitZ();

/// Where the arc has brought the start when it has turned by a share of its angle: a circle about its line.
Vector3d turned(const Arc& arc, const Vector3d& start, double share) {
    return arc.centre_mm + Eigen::AngleAxisd(share * arc.angle_rad, arc.normal) * (start - arc.centre_mm);
}

double distance_from_line(const Arc& arc, const Vector3d& point) {
    return (point - arc.centre_mm).cross(arc.normal).norm();
}

std::string code_of(const Result<Arc>& arc) {
    return arc ? "" : arc.error().code;
}

/// Numbers in [-1, 1), the same on every machine.
class Draws {
  public:
    explicit Draws(std::uint64_t seed) : state_(seed) {}
    double next() {
        state_ += 0x9e3779b97f4a7c15u;
        std::uint64_t mixed = state_;
        mixed = (mixed ^ (mixed >> 30)) * 0xbf58476d1ce4e5b9u;
        mixed = (mixed ^ (mixed >> 27)) * 0x94d049bb133111ebu;
        return static_cast<double>((mixed ^ (mixed >> 31)) >> 11) * 0x1p-52 - 1;
    }
    Vector3d point() {
        const double a = next(), b = next(), c = next();
        return {a, b, c};
    }

  private:
    std::uint64_t state_;
};

TEST(Arcs, ClockwiseIsSeenAgainstTheNormal) {
    struct Case {
        Vector3d right, up, normal;
    };
    for (const Case& plane : {Case{x, y, z}, Case{z, x, y}, Case{y, z, x}}) {
        const Vector3d start = 5 * plane.right, end = 5 * plane.up;
        const auto shorter = arc_by_centre(start, end, Vector3d::Zero(), plane.normal, false, 0, linuxcnc_arcs);
        ASSERT_TRUE(shorter);
        EXPECT_DOUBLE_EQ(shorter->angle_rad, pi / 2);
        const auto longer = arc_by_centre(start, end, Vector3d::Zero(), plane.normal, true, 0, linuxcnc_arcs);
        ASSERT_TRUE(longer);
        EXPECT_DOUBLE_EQ(longer->angle_rad, -1.5 * pi);
        const auto up = arc_by_radius(start, end, 5, plane.normal, false, 0, linuxcnc_arcs);
        ASSERT_TRUE(up);
        EXPECT_NEAR(up->centre_mm.norm(), 0, 1e-14);
        EXPECT_NEAR(up->angle_rad, pi / 2, 1e-14);
    }
}

TEST(Arcs, ByCentreTurnsTheStartOntoTheEndInTheSenseWanted) {
    Draws draws(7);
    for (int i = 0; i < 20000; ++i) {
        const Vector3d normal = (draws.point() + Vector3d(0, 0, 1.5)).normalized(), centre = 100 * draws.point();
        const Vector3d start = centre + 50 * draws.point();
        const double angle = (draws.next() + 1.001) * pi * 0.999, climb = draws.next();
        const bool clockwise = draws.next() > 0;
        const double further = std::floor(2 + 2 * draws.next());
        const double sense = clockwise ? -1 : 1;
        const Vector3d end = centre + Eigen::AngleAxisd(sense * angle, normal) * (start - centre) + climb * normal;
        if ((start - centre).cross(normal).norm() < 0.1) continue;
        const auto arc = arc_by_centre(start, end, centre, normal, clockwise, further, linuxcnc_arcs);
        ASSERT_TRUE(arc) << i;
        ASSERT_NEAR(arc->angle_rad, sense * (angle + 2 * pi * further), 1e-9) << i;
        ASSERT_LT((turned(*arc, start, 1) + climb * normal - end).norm(), 1e-9) << i;
    }
}

TEST(Arcs, ByRadiusTheSignSaysWhichWayRound) {
    Draws draws(11);
    for (int i = 0; i < 20000; ++i) {
        const Vector3d normal = (draws.point() + Vector3d(0, 0, 1.5)).normalized(), start = 100 * draws.point();
        const Vector3d end = start + 20 * draws.point();
        const Vector3d chord = (end - start) - (end - start).dot(normal) * normal;
        const double radius = chord.norm() * (0.5001 + std::abs(draws.next()));
        if (chord.norm() < 0.01) continue;
        for (const bool clockwise : {false, true}) {
            for (const double sign : {1.0, -1.0}) {
                const auto arc = arc_by_radius(start, end, sign * radius, normal, clockwise, 0, linuxcnc_arcs);
                ASSERT_TRUE(arc) << i;
                ASSERT_EQ(arc->angle_rad < 0, clockwise);
                ASSERT_EQ(std::abs(arc->angle_rad) > pi, sign < 0);
                ASSERT_NEAR(distance_from_line(*arc, start), radius, 1e-9 * radius + 1e-12);
                const Vector3d climb = (end - start).dot(normal) * normal;
                ASSERT_LT((turned(*arc, start, 1) + climb - end).norm(), 1e-8) << i;
            }
        }
    }
}

TEST(Arcs, ThroughThreePointsInTheirOrder) {
    Draws draws(13);
    for (int i = 0; i < 20000; ++i) {
        const Vector3d start = 50 * draws.point(), via = 50 * draws.point(), end = 50 * draws.point();
        const double area = (via - start).cross(end - start).norm();
        if (area < 0.01 * (via - start).norm() * (end - start).norm()) continue;
        const auto arc = arc_through(start, via, end);
        ASSERT_TRUE(arc) << i;
        ASSERT_GT(arc->angle_rad, 0);
        ASSERT_LT(arc->angle_rad, 2 * pi);
        const double radius = distance_from_line(*arc, start);
        ASSERT_LT((turned(*arc, start, 1) - end).norm(), 1e-10 * radius * radius + 1e-9) << i;
        const auto first = arc_by_centre(start, via, arc->centre_mm, arc->normal, false, 0, linuxcnc_arcs);
        ASSERT_TRUE(first);
        ASSERT_LT(first->angle_rad, arc->angle_rad) << "the via point is met before the end";
    }
}

TEST(Arcs, EndsThatCoincideAreAWholeTurn) {
    const Vector3d start(10, 0, 3);
    for (const Vector3d& end : {start, Vector3d(10, 1e-12, 3), Vector3d(10, -1e-12, 3), Vector3d(10, 0, 8)}) {
        EXPECT_NEAR(arc_by_centre(start, end, Vector3d::Zero(), z, false, 0, linuxcnc_arcs)->angle_rad, 2 * pi, 1e-9);
        EXPECT_NEAR(arc_by_centre(start, end, Vector3d::Zero(), z, true, 2, linuxcnc_arcs)->angle_rad, -6 * pi, 1e-9);
    }
    const Vector3d beside = Eigen::AngleAxisd(1e-5, z) * start;
    EXPECT_NEAR(arc_by_centre(1e6 * x, 1e6 * x + 0.1 * y, Vector3d::Zero(), z, false, 0, linuxcnc_arcs)->angle_rad,
                1e-7, 1e-12)
        << "a short piece of a large circle is no whole turn";
    EXPECT_NEAR(arc_by_centre(start, beside, Vector3d::Zero(), z, false, 0, linuxcnc_arcs)->angle_rad, 1e-5, 1e-12);
}

TEST(Arcs, RadiiMayDifferByTheToleranceAndNoMore) {
    const auto code = [](double radius, double difference, const ArcTolerance& tolerance) {
        return code_of(arc_by_centre(radius * x, (radius + difference) * y, Vector3d::Zero(), z, false, 0, tolerance));
    };
    EXPECT_EQ(code(1, 0.0049, linuxcnc_arcs), "");
    EXPECT_EQ(code(1, 0.0051, linuxcnc_arcs), "NC0207");
    EXPECT_EQ(code(100, 0.0999, linuxcnc_arcs), "");
    EXPECT_EQ(code(100, -0.0999, linuxcnc_arcs), "");
    EXPECT_EQ(code(100, 0.1002, linuxcnc_arcs), "NC0207");
    EXPECT_EQ(code(10000, 0.49, linuxcnc_arcs), "");
    EXPECT_EQ(code(10000, 0.51, linuxcnc_arcs), "NC0207");
    EXPECT_EQ(code(1, 0.0126, linuxcnc_inch_arcs), "");
    EXPECT_EQ(code(1, 0.0128, linuxcnc_inch_arcs), "NC0207");
    EXPECT_EQ(code(1, 0.0099, sinumerik_arcs), "");
    EXPECT_EQ(code(1, 0.0101, sinumerik_arcs), "NC0207");
    EXPECT_EQ(code(10000, 9, sinumerik_arcs), "");
    const auto refused = arc_by_centre(5 * x, 6 * y, Vector3d::Zero(), z, false, 0, linuxcnc_arcs);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().value, "5 mm at the start, 6 mm at the end");
    EXPECT_EQ(refused.error().limit, "0.006 mm of difference");
}

TEST(Arcs, ARadiusALittleTooSmallIsHalfATurn) {
    const auto half = arc_by_radius(Vector3d::Zero(), 10 * x, 4.999, z, true, 0, linuxcnc_arcs);
    ASSERT_TRUE(half);
    EXPECT_DOUBLE_EQ(half->angle_rad, -pi);
    EXPECT_EQ(half->centre_mm, Vector3d(5, 0, 0));
    EXPECT_EQ(code_of(arc_by_radius(Vector3d::Zero(), 10 * x, 4.998, z, true, 0, linuxcnc_arcs)), "NC0208");
    EXPECT_EQ(code_of(arc_by_radius(Vector3d::Zero(), 10 * x, 4.998, z, true, 0, sinumerik_arcs)), "");
}

TEST(Arcs, Refusals) {
    const Vector3d o = Vector3d::Zero();
    EXPECT_EQ(code_of(arc_by_centre(o, x, o, z, false, 0, linuxcnc_arcs)), "NC0209");
    EXPECT_EQ(code_of(arc_by_centre(x, 5 * z, o, z, false, 0, linuxcnc_arcs)), "NC0209");
    EXPECT_EQ(code_of(arc_by_radius(o, x, 0, z, false, 0, linuxcnc_arcs)), "NC0209");
    EXPECT_EQ(code_of(arc_by_radius(x, x, 5, z, false, 0, linuxcnc_arcs)), "NC0210");
    EXPECT_EQ(code_of(arc_by_radius(x, x + z, 5, z, false, 0, linuxcnc_arcs)), "NC0210");
    EXPECT_EQ(code_of(arc_through(o, x, 2 * x)), "NC0211");
    EXPECT_EQ(code_of(arc_through(o, o, 2 * x)), "NC0211");
    EXPECT_EQ(code_of(arc_through(o, x, o)), "NC0211");
    EXPECT_EQ(code_of(arc_through(o, x, x)), "NC0211");
    for (const double turns : {-1.0, 0.5, 1001.0, std::nan("")})
        EXPECT_EQ(code_of(arc_by_centre(x, y, o, z, false, turns, linuxcnc_arcs)), "NC0212");
    EXPECT_EQ(code_of(arc_by_radius(x, y, 5, z, false, -1, linuxcnc_arcs)), "NC0212");
    EXPECT_EQ(code_of(arc_by_radius(x, y, 5, z, false, 1000, linuxcnc_arcs)), "");
    for (const double radius : {1.1e7, 1e200, 1e308}) {
        EXPECT_EQ(code_of(arc_by_radius(x, y, radius, z, false, 0, linuxcnc_arcs)), "NC0213");
        EXPECT_EQ(code_of(arc_by_centre(x, y, radius * x, z, false, 0, linuxcnc_arcs)), "NC0213");
    }
    EXPECT_EQ(code_of(arc_by_radius(x, y, 0.9e7, z, false, 0, linuxcnc_arcs)), "");
    EXPECT_EQ(code_of(arc_through(o, 1000 * x, Vector3d(2000, 0.01, 0))), "NC0213");
    EXPECT_EQ(code_of(arc_through(o, 1000 * x, Vector3d(2000, 1, 0))), "");
}

TEST(Arcs, the_way_along_a_helix) {
    const Arc arc{{1, 2, 3}, z, -2 * pi};
    EXPECT_NEAR(square_of_way(arc, {1, 6, 0}, {0, 0, 5}), std::pow(8 * pi, 2) + 25, 1e-9);
    EXPECT_NEAR(square_of_way(arc, {4, 2, 9}, {0, 0, 0}), std::pow(6 * pi, 2), 1e-9);
}

}  // namespace
}  // namespace trunnion::nc
