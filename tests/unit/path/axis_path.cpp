#include "trunnion/path/axis_path.hpp"

#include <gtest/gtest.h>

#include "trunnion_table.hpp"

namespace trunnion::path {
namespace {

using machine::Frame;
using machine::Kinematics;

/// A tip path and tool axis with third-degree terms, law vector, in two pieces of 10 mm that continue each other.
ToolPath curved(const Kinematics& kinematics) {
    ToolPath path;
    path.kinematics = &kinematics;
    for (int k = 0; k < 2; ++k) {
        PathPiece piece{10.0 * k, 10.0, {}};
        const auto polynomial = [&](double c0, double c1, double c2, double c3) {  // in p, shifted to the piece
            const double a = piece.begin_mm, h = piece.length_mm;
            return std::array<double, 8>{c0 + c1 * a + c2 * a * a + c3 * a * a * a,
                                         (c1 + 2 * c2 * a + 3 * c3 * a * a) * h, (c2 + 3 * c3 * a) * h * h,
                                         c3 * h * h * h};
        };
        piece.coefficient = {polynomial(1, 0.9, 0.01, -0.002),   polynomial(-3, 0.2, 0.03, 0.001),
                             polynomial(40, -0.1, 0.02, 0.0005), polynomial(0.2, 0.01, 0.002, 0),
                             polynomial(-0.3, 0.02, 0, -0.0001), polynomial(0.9, 0, 0.001, 0)};
        path.pieces.push_back(piece);
    }
    path.blocks.push_back({0, 20, {FeedRule::tip_speed, 50}, 1, 20});
    return path;
}

TEST(AxisPath, holds_the_pose_and_is_differentiated_exactly) {
    for (const bool reversed : {false, true}) {
        const auto machine = trunnion_table(reversed);
        const auto kinematics = Kinematics::make(machine, Frame{{5, -7, 50}, Eigen::Matrix3d::Identity()}, 80);
        ASSERT_TRUE(kinematics);
        const ToolPath tool_path = curved(*kinematics);
        const auto path = AxisPath::make(tool_path, machine, {});
        ASSERT_TRUE(path);
        for (const PathPlace place : {PathPlace{0, 0.3}, PathPlace{0, 7.7}, PathPlace{1, 4.0}}) {
            AxisSample at;
            path->evaluate(place, at);
            const auto pose = kinematics->forward(path->position(place));
            for (int k = 0; k < 3; ++k) {
                EXPECT_NEAR(pose.tip_in_workpiece_mm[k], at.tip[k].value(), 1e-11);
                EXPECT_NEAR(pose.axis_in_workpiece[k], at.tool_axis[k].value(), 1e-14);
            }
            constexpr double h = 0.02;
            const auto q = [&](double d) { return path->position({place.piece, place.offset_mm + d}); };
            const auto a = q(-2 * h), b = q(-h), m = q(0), c = q(h), d = q(2 * h);
            for (int i = 0; i < 5; ++i) {
                EXPECT_NEAR((a[i] - 8 * b[i] + 8 * c[i] - d[i]) / (12 * h), at.axes[i].d1(), 1e-7);
                EXPECT_NEAR((-a[i] + 16 * b[i] - 30 * m[i] + 16 * c[i] - d[i]) / (12 * h * h), at.axes[i].d2(), 1e-6);
                EXPECT_NEAR((-a[i] + 2 * b[i] - 2 * c[i] + d[i]) / (2 * h * h * h), at.axes[i].d3(),
                            1e-3 * (1 + std::abs(at.axes[i].d3())));
            }
        }
    }
}

/// The tool axis goes from 10° on one side to 10° on the other and passes the pole at `beside_rad`.
ToolPath past_the_pole(const Kinematics& kinematics, double beside_rad) {
    ToolPath path;
    path.kinematics = &kinematics;
    PathPiece piece{0, 40, {}};
    piece.coefficient[0] = {-20, 40};
    piece.coefficient[3] = {-0.18, 0.36};
    piece.coefficient[4] = {std::tan(beside_rad)};
    piece.coefficient[5] = {1};
    path.pieces.push_back(piece);
    path.blocks.push_back({0, 40, {FeedRule::tip_speed, 50}, 1, 40});
    return path;
}

TEST(AxisPath, follows_one_branch_beside_the_pole) {
    const auto machine = trunnion_table();
    const auto kinematics = Kinematics::make(machine, {}, 0);
    for (const double beside : {1e-2, 1e-4, 1e-6}) {
        const ToolPath tool_path = past_the_pole(*kinematics, beside);
        const auto path = AxisPath::make(tool_path, machine, {});
        ASSERT_TRUE(path) << to_string(path.error());
        const auto begin = path->begin_position(), end = path->end_position();
        EXPECT_NEAR(std::abs(end[4] - begin[4]), 180 * degree, 4 * beside / 0.18 + 1e-6);
        EXPECT_NEAR(begin[3], end[3], 1e-9);
        for (std::size_t k = 1; k < path->stations().size(); ++k) {
            const auto a = path->position(path->stations()[k - 1]), b = path->position(path->stations()[k]);
            EXPECT_LT(std::abs(a[4] - b[4]), 21 * degree);
        }
    }
}

TEST(AxisPath, sees_a_passage_of_the_pole_between_two_places_that_look_alike) {
    const auto machine = trunnion_table();
    const auto kinematics = Kinematics::make(machine, {}, 0);
    for (const double shift : {0.05, -0.031, 0.077}) {  // the pole is not where an interval is halved
        ToolPath tool_path = past_the_pole(*kinematics, 1e-4);
        tool_path.pieces[0].coefficient[3][0] += shift;
        const auto path = AxisPath::make(tool_path, machine, {});
        ASSERT_TRUE(path) << to_string(path.error());
        EXPECT_NEAR(std::abs(path->end_position()[4] - path->begin_position()[4]), 180 * degree, 0.01);
        const double nearest_mm = 40 * (0.18 - shift) / 0.36;
        double last = path->position({0, nearest_mm - 1}).v[4];
        for (int k = -20000; k <= 20000; ++k) {  // no jump anywhere beside the pole: 0.1 µm steps near it
            const double c = path->position({0, nearest_mm + 1e-4 * k}).v[4];
            ASSERT_LT(std::abs(c - last), 40 * degree) << shift << " at " << k;
            last = c;
        }
    }
}

TEST(AxisPath, straight_through_the_pole_keeps_c) {
    const auto machine = trunnion_table();
    const auto kinematics = Kinematics::make(machine, {}, 0);
    const ToolPath tool_path = past_the_pole(*kinematics, 0);
    const auto path = AxisPath::make(tool_path, machine, {});
    ASSERT_TRUE(path) << to_string(path.error());
    EXPECT_NEAR(path->begin_position()[4], path->end_position()[4], 1e-9);
    EXPECT_NEAR(path->begin_position()[3], -path->end_position()[3], 1e-9);
}

TEST(AxisPath, continues_the_winding_it_is_given) {
    const auto machine = trunnion_table();
    const auto kinematics = Kinematics::make(machine, {}, 0);
    const ToolPath tool_path = curved(*kinematics);
    const auto first = AxisPath::make(tool_path, machine, {});
    auto wound = first->begin_position();
    wound[4] += 4 * std::numbers::pi;
    const auto second = AxisPath::make(tool_path, machine, {wound[3], wound[4]});
    ASSERT_TRUE(second);
    EXPECT_NEAR(second->end_position()[4] - first->end_position()[4], 4 * std::numbers::pi, 1e-12);
}

TEST(AxisPath, says_which_axis_leaves_its_range) {
    auto machine = trunnion_table();
    machine.axes[2].range_max = 30;
    const auto kinematics = Kinematics::make(machine, {}, 0);
    const ToolPath tool_path = curved(*kinematics);
    const auto path = AxisPath::make(tool_path, machine, {});
    ASSERT_FALSE(path);
    EXPECT_EQ(path.error().code, "PATH0102");
    EXPECT_NE(path.error().text.find("axis Z"), std::string::npos);
    EXPECT_EQ(path.error().place.line, 1);
}

TEST(AxisPath, sees_a_linear_axis_leave_its_range_between_the_ends_of_a_piece) {
    auto machine = trunnion_table();
    const auto kinematics = Kinematics::make(machine, {}, 0);
    ToolPath tool_path;  // the tip stands 100 mm off C, which turns from −40° to 45°: X is largest, 100, at 0
    tool_path.kinematics = &*kinematics;
    tool_path.law = OrientationLaw::rotary;
    PathPiece piece{0, 40, {}};
    piece.coefficient[0] = {100};
    piece.coefficient[4] = {-40 * degree, 85 * degree};
    tool_path.pieces.push_back(piece);
    tool_path.blocks.push_back({0, 40, {FeedRule::tip_speed, 50}, 3, 40});
    const double at_ends = kinematics->linear_for(Eigen::Vector3d{100, 0, 0}, {0, -40 * degree})[0];
    ASSERT_LT(at_ends, 90);
    for (const double limit : {99.9, 99.9999}) {
        machine.axes[0].range_max = limit;
        const auto path = AxisPath::make(tool_path, machine, {});
        ASSERT_FALSE(path) << limit;
        EXPECT_EQ(path.error().code, "PATH0102");
        EXPECT_NE(path.error().text.find("axis X"), std::string::npos);
    }
    for (const double limit : {100.0, 100.1}) {
        machine.axes[0].range_max = limit;
        EXPECT_TRUE(AxisPath::make(tool_path, machine, {})) << limit;
    }
}

TEST(AxisPath, sees_a_rotary_axis_leave_its_range_between_stations) {
    auto machine = trunnion_table();
    const auto kinematics = Kinematics::make(machine, {}, 0);
    ToolPath tool_path;  // from A 80° C −8° to A 80° C 9° by the shortest way: between A dips to atan(tan 80° cos 8.5°)
    tool_path.kinematics = &*kinematics;
    PathPiece piece{0, 40, {}};
    const auto axis = [](double c_deg) {
        const double c = c_deg * degree;
        return Eigen::Vector3d(std::sin(c) * std::sin(80 * degree), -std::cos(c) * std::sin(80 * degree),
                               std::cos(80 * degree));
    };
    for (int k = 0; k < 3; ++k) piece.coefficient[3 + k] = {axis(-8)[k], axis(9)[k] - axis(-8)[k]};
    tool_path.pieces.push_back(piece);
    tool_path.blocks.push_back({0, 40, {FeedRule::tip_speed, 50}, 3, 40});
    const double dip = std::atan(std::tan(80 * degree) * std::cos(8.5 * degree));
    machine.axes[3].range_min = dip + 1e-6;
    const auto path = AxisPath::make(tool_path, machine, {80 * degree, 0});
    ASSERT_FALSE(path);
    EXPECT_EQ(path.error().code, "PATH0102");
    EXPECT_NE(path.error().text.find("axis A"), std::string::npos);
    machine.axes[3].range_min = dip - 1e-6;
    EXPECT_TRUE(AxisPath::make(tool_path, machine, {80 * degree, 0}));
}

TEST(AxisPath, begins_at_the_pole_where_it_leaves_it) {
    const auto machine = trunnion_table();
    const auto kinematics = Kinematics::make(machine, {}, 0);
    ToolPath tool_path;
    tool_path.kinematics = &*kinematics;
    PathPiece piece{0, 40, {}};  // leaves towards C 30° and bends away
    piece.coefficient[3] = {0, 0.2 * std::sin(30 * degree), 0.1};
    piece.coefficient[4] = {0, -0.2 * std::cos(30 * degree), 0.05};
    piece.coefficient[5] = {1};
    tool_path.pieces.push_back(piece);
    tool_path.blocks.push_back({0, 40, {FeedRule::tip_speed, 50}, 1, 40});
    for (const double near_deg : {35.0, 390.0 - 5, -155.0}) {
        const auto path = AxisPath::make(tool_path, machine, {0, near_deg * degree});
        ASSERT_TRUE(path);
        const double begin = path->begin_position()[4];
        EXPECT_NEAR(begin / degree, near_deg + (near_deg < 0 ? 5 : near_deg > 100 ? 5 : -5), 1e-4);
        const double next = path->position({0, 1e-3})[4];
        EXPECT_NEAR(next, begin, 1e-3);
    }
}

TEST(AxisPath, refuses_an_orientation_out_of_reach) {
    auto machine = trunnion_table();
    machine.axis_count = 3;
    machine.rotary_count = 0;
    machine.chain = {0, 1, 2};
    const auto kinematics = Kinematics::make(machine, {}, 0);
    ASSERT_TRUE(kinematics);
    const ToolPath tool_path = curved(*kinematics);
    const auto path = AxisPath::make(tool_path, machine, {});
    ASSERT_FALSE(path);
    EXPECT_EQ(path.error().code, "PATH0101");
}

/// The tool axis (0.01 p, 0.002 p², 1) in two pieces, the pole between them: its direction about the pole is atan(0.2
/// p).
ToolPath bent_at_pole(const Kinematics& kinematics) {
    ToolPath path;
    path.kinematics = &kinematics;
    for (const double begin : {-2.0, 0.0}) {
        PathPiece piece{begin + 2, 2, {}};
        piece.coefficient[3] = {0.01 * begin, 0.02};
        piece.coefficient[4] = {0.002 * begin * begin, 0.008 * begin, 0.008};
        piece.coefficient[5] = {1};
        path.pieces.push_back(piece);
    }
    path.blocks.push_back({0, 4, {FeedRule::tip_speed, 50}, 1, 4});
    return path;
}

/// (0.002 p (p + 0.0001), 2e-9 p, 1): 0.1 µm before the pole the tool has gone past it already, as near as 2e-13 rad,
/// and turns back. Within some nanometres of path its direction goes half round; at the ends of the piece nothing is
/// seen of it, for what is left is a change of the branch.
TEST(AxisPath, sees_a_turn_in_a_narrow_bend_beside_the_pole) {
    const auto machine = trunnion_table();
    const auto kinematics = Kinematics::make(machine, {}, 0);
    ToolPath tool_path = bent_at_pole(*kinematics);
    for (PathPiece& piece : tool_path.pieces) {
        const double begin = piece.begin_mm - 2;
        piece.coefficient[3] = {0.002 * begin * (begin + 1e-4), 0.004 * (2 * begin + 1e-4), 0.008};
        piece.coefficient[4] = {2e-9 * begin, 4e-9};
    }
    const auto path = AxisPath::make(tool_path, machine, {});
    ASSERT_TRUE(path) << to_string(path.error());
    double last = path->position({0, 2 - 3e-4}).v[4];
    const double first = last;
    for (int k = -3000; k <= 3000; ++k) {
        const double p = 1e-7 * k, c = path->position(p < 0 ? PathPlace{0, 2 + p} : PathPlace{1, p}).v[4];
        ASSERT_LT(std::abs(c - last), 20 * degree) << p;
        last = c;
    }
    EXPECT_GT(std::abs(last - first), 175 * degree);
}

TEST(AxisPath, turns_on_evenly_at_the_pole_itself) {
    auto inclined = trunnion_table();
    inclined.axes[3].direction = Eigen::Vector3d(1, 0, 1).normalized();
    for (const auto& machine : {trunnion_table(), trunnion_table(true), inclined}) {
        const auto kinematics = Kinematics::make(machine, Frame{{5, -7, 50}, Eigen::Matrix3d::Identity()}, 80);
        ASSERT_TRUE(kinematics);
        const ToolPath tool_path = bent_at_pole(*kinematics);
        const auto path = AxisPath::make(tool_path, machine, {});
        ASSERT_TRUE(path) << to_string(path.error());
        const auto at = [&](double p) {
            AxisSample sample;
            path->evaluate(p < 0 ? PathPlace{0, 2 + p} : PathPlace{1, p}, sample);
            return sample;
        };
        AxisSample before, after;
        path->evaluate({0, 2}, before);
        path->evaluate({1, 0}, after);
        for (const int i : {3, 4}) {
            for (int k = 0; k < 4; ++k) EXPECT_NEAR(before.axes[i].c[k], after.axes[i].c[k], 1e-13);
            constexpr double h = 0.02;
            const auto q = [&](double p) { return at(p).axes[i].value(); };
            EXPECT_NEAR((q(-2 * h) - 8 * q(-h) + 8 * q(h) - q(2 * h)) / (12 * h), after.axes[i].d1(), 1e-7);
            EXPECT_NEAR((-q(-2 * h) + 2 * q(-h) - 2 * q(h) + q(2 * h)) / (2 * h * h * h), after.axes[i].d3(), 1e-4);
            for (const double p : {1e-9, 1e-7, 1e-6, 1e-4})
                for (const double sign : {-1, 1}) {
                    const Taylor3 is = at(sign * p).axes[i], from_pole = after.axes[i];
                    const double x = sign * p;
                    EXPECT_NEAR(is.c[0],
                                from_pole.c[0] + x * (from_pole.c[1] + x * (from_pole.c[2] + x * from_pole.c[3])),
                                1e-15 + 1e-2 * x * x * x * x);
                    EXPECT_NEAR(is.c[1], from_pole.c[1] + x * (2 * from_pole.c[2] + 3 * x * from_pole.c[3]),
                                1e-13 + x * x * x * sign);
                    EXPECT_NEAR(is.c[3], from_pole.c[3], 1e-12 + p);
                }
        }
        if (machine.axes[3].direction == trunnion_table().axes[3].direction) {
            EXPECT_NEAR(std::abs(after.axes[4].d1()), 0.2, 1e-14);
            EXPECT_NEAR(std::abs(after.axes[4].d3()), 2 * 0.2 * 0.2 * 0.2, 1e-13);
        }
        for (const double p : {-1.7, -1e-5, -1e-9, 1e-9, 1e-5, 1.7}) {
            const AxisSample sample = at(p);
            const Eigen::Vector3d axis =
                kinematics->tool_axis(machine::RotaryPosition{sample.axes[3].value(), sample.axes[4].value()});
            EXPECT_NEAR((axis - Eigen::Vector3d(0.01 * p, 0.002 * p * p, 1).normalized()).norm(), 0, 1e-14);
        }
    }
}

}  // namespace
}  // namespace trunnion::path
