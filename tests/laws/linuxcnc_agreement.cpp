// Our kinematics against positions that LinuxCNC's own modules gave.

#include <cmath>
#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include "trunnion/base/quantity.hpp"
#include "trunnion/files/machine_file.hpp"
#include "trunnion/machine/kinematics.hpp"

#include "linuxcnc_vectors.hpp"

namespace {

using namespace trunnion;
using namespace trunnion::machine;
using Eigen::Vector3d;

Axis linear(char letter, const Vector3d& direction) {
    Axis out;
    out.letter = letter;
    out.direction = direction;
    return out;
}

Axis rotary(char letter, const Vector3d& direction, const Vector3d& point_mm, bool reversed) {
    Axis out = linear(letter, direction);
    out.rotary = true;
    out.point_mm = point_mm;
    out.reversed = reversed;
    return out;
}

Machine five_axes(const Axis& first, const Axis& second, std::array<std::int8_t, max_axes> chain) {
    Machine out;
    out.axes = {linear('X', Vector3d::UnitX()), linear('Y', Vector3d::UnitY()), linear('Z', Vector3d::UnitZ()), first,
                second};
    out.axis_count = 5;
    out.rotary_count = 2;
    out.chain = chain;
    return out;
}

/// LinuxCNC's world is the joints with the rotary axes at 0, tool length included: its zero is the tip at joints 0.
Frame world_of(double tool_mm) {
    Frame out;
    out.origin_mm = {0, 0, -tool_mm};
    return out;
}

AxisPosition position_of(const std::array<double, 5>& joints) {
    return {{joints[0], joints[1], joints[2], joints[3] * degree, joints[4] * degree}};
}

void expect_both_ways(const Kinematics& kinematics, const AxisPosition& q, const std::array<double, 3>& world_mm) {
    const Vector3d world(world_mm[0], world_mm[1], world_mm[2]);
    EXPECT_LT((kinematics.forward(q).tip_in_workpiece_mm - world).norm(), 1e-11);
    const auto back = kinematics.linear_for(world, {q[3], q[4]});
    for (std::size_t a = 0; a < 3; ++a) EXPECT_NEAR(back[a], q[a], 1e-11);
}

Vector3d point(const std::array<double, 3>& p) {
    return {p[0], p[1], p[2]};
}

TEST(LinuxcncAgreement, TrunnionWithA) {
    for (const auto& v : linuxcnc::xyzac_trt) {
        const Vector3d centre = point(v.rot_point_mm), tilt = centre + Vector3d(0, v.side_offset_mm, v.z_offset_mm);
        const Machine machine = five_axes(rotary('A', Vector3d::UnitX(), tilt, true),
                                          rotary('C', Vector3d::UnitZ(), centre, true), {4, 3, 0, 1, 2});
        expect_both_ways(Kinematics::make(machine, world_of(v.tool_offset_mm), v.tool_offset_mm).value(),
                         position_of(v.joints), v.world_mm);
    }
}

TEST(LinuxcncAgreement, TrunnionWithB) {
    for (const auto& v : linuxcnc::xyzbc_trt) {
        const Vector3d centre = point(v.rot_point_mm), tilt = centre + Vector3d(v.side_offset_mm, 0, v.z_offset_mm);
        const Machine machine = five_axes(rotary('B', Vector3d::UnitY(), tilt, true),
                                          rotary('C', Vector3d::UnitZ(), centre, true), {4, 3, 0, 1, 2});
        expect_both_ways(Kinematics::make(machine, world_of(v.tool_offset_mm), v.tool_offset_mm).value(),
                         position_of(v.joints), v.world_mm);
    }
}

TEST(LinuxcncAgreement, HeadThatSwivelsAndTurns) {
    for (const auto& v : linuxcnc::head_bc) {
        const Machine machine = five_axes(rotary('B', Vector3d::UnitY(), {0, 0, 0}, true),
                                          rotary('C', Vector3d::UnitZ(), {0, 0, 0}, false), {0, 1, 2, 4, 3});
        expect_both_ways(Kinematics::make(machine, world_of(v.pivot_mm), v.pivot_mm).value(), position_of(v.joints),
                         v.world_mm);
    }
}

TEST(LinuxcncAgreement, TableOfAOnB) {
    for (const auto& v : linuxcnc::xyzab_tdr) {
        const Vector3d centre = point(v.rot_point_mm), chuck = centre + Vector3d(0, 0, v.z_offset_mm);
        const Machine machine = five_axes(rotary('A', Vector3d::UnitX(), chuck, false),
                                          rotary('B', Vector3d::UnitY(), centre, false), {3, 4, 0, 1, 2});
        expect_both_ways(Kinematics::make(machine, world_of(v.tool_offset_mm), v.tool_offset_mm).value(),
                         position_of(v.joints), v.world_mm);
    }
}

TEST(LinuxcncAgreement, NutatingHead) {
    for (const auto& v : linuxcnc::xyzacb_trsrn) {
        const double nutation = v.nut_deg * degree;
        const Vector3d swivel(0, v.pivot_mm[0], v.pivot_mm[1]);
        const Machine machine =
            five_axes(rotary('B', {0, std::sin(nutation), std::cos(nutation)}, swivel, false),
                      rotary('C', Vector3d::UnitZ(), swivel + Vector3d(v.offset_mm[0], v.offset_mm[1], 0), false),
                      {0, 1, 2, 4, 3});
        expect_both_ways(Kinematics::make(machine, world_of(v.tool_offset_mm), v.tool_offset_mm).value(),
                         position_of(v.joints), v.world_mm);
    }
}

Machine shipped(const char* name) {
    const auto machine = files::read_machine_file(std::filesystem::path(TRUNNION_SOURCE_DIR) / "data/machines" /
                                                  (std::string(name) + ".toml"));
    EXPECT_TRUE(machine) << to_string(machine.error());
    return machine.value();
}

/// Our file against those of the module's positions that were made with its offsets.
void expect_file_agrees(const char* name, const auto& vectors, int wanted, const auto& with_offsets_of_file) {
    const Machine machine = shipped(name);
    int met = 0;
    for (const auto& v : vectors) {
        if (!with_offsets_of_file(v)) continue;
        expect_both_ways(Kinematics::make(machine, world_of(v.tool_offset_mm), v.tool_offset_mm).value(),
                         position_of(v.joints), v.world_mm);
        ++met;
    }
    EXPECT_EQ(met, wanted) << name;
}

TEST(LinuxcncAgreement, ShippedFiles) {
    const auto trunnion = [](double side_mm, double z_mm) {
        return [side_mm, z_mm](const linuxcnc::TrunnionVector& v) {
            return v.rot_point_mm == std::array<double, 3>{} && v.side_offset_mm == side_mm && v.z_offset_mm == z_mm;
        };
    };
    expect_file_agrees("xyzac-trt", linuxcnc::xyzac_trt, 12, trunnion(20, 10));
    expect_file_agrees("xyzab-tdr", linuxcnc::xyzab_tdr, 6, trunnion(0, -10));
    expect_file_agrees("xyzacb-trsrn", linuxcnc::xyzacb_trsrn, 6, [](const linuxcnc::NutatingVector& v) {
        return v.pivot_mm == std::array<double, 2>{30, 120} && v.offset_mm == std::array<double, 2>{};
    });
}

/// With other offsets than the module's positions were made with: geometry and counting are those of the test above.
TEST(LinuxcncAgreement, ShippedTrunnionWithB) {
    const Machine file = shipped("xyzbc-trt");
    const Machine same = five_axes(rotary('B', Vector3d::UnitY(), {-20, 0, -15}, true),
                                   rotary('C', Vector3d::UnitZ(), {0, 0, 0}, true), {4, 3, 0, 1, 2});
    const auto ours = Kinematics::make(file, world_of(30), 30).value(),
               module = Kinematics::make(same, world_of(30), 30).value();
    const AxisPosition q{{12, -34, 56, 0.7, -2.1}};
    EXPECT_LT((ours.forward(q).tip_in_workpiece_mm - module.forward(q).tip_in_workpiece_mm).norm(), 1e-12);
    EXPECT_LT((ours.forward(q).axis_in_workpiece - module.forward(q).axis_in_workpiece).norm(), 1e-15);
}

/// What a longer tool changes in LinuxCNC's world tells its tool axis; it is ours.
TEST(LinuxcncAgreement, ToolAxis) {
    constexpr std::size_t cases = 6;
    for (std::size_t i = 0; i < cases; ++i) {
        const auto &bare = linuxcnc::xyzac_trt[i], &with_tool = linuxcnc::xyzac_trt[i + cases];
        ASSERT_EQ(bare.joints, with_tool.joints);
        const double length = with_tool.tool_offset_mm;
        ASSERT_GT(length, 0);
        const Vector3d theirs = (point(bare.world_mm) - point(with_tool.world_mm)) / length + Vector3d::UnitZ();
        const Machine machine = five_axes(rotary('A', Vector3d::UnitX(), {0, 0, 0}, true),
                                          rotary('C', Vector3d::UnitZ(), {0, 0, 0}, true), {4, 3, 0, 1, 2});
        const auto kinematics = Kinematics::make(machine, {}, 0).value();
        EXPECT_LT((kinematics.forward(position_of(bare.joints)).axis_in_workpiece - theirs).norm(), 1e-13);
    }
}

}  // namespace
