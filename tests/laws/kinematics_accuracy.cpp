// How exact the inverse is: over many poses of every shipped machine, and on machines drawn at random.

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include "trunnion/files/machine_file.hpp"
#include "trunnion/machine/kinematics.hpp"

#include "random_numbers.hpp"
#include "shipped_machine.hpp"
#include "sweep.hpp"

namespace {

using namespace trunnion;
using namespace trunnion::machine;
using Eigen::Vector3d;

constexpr double pi = std::numbers::pi;
constexpr double tip_limit_mm = 1e-9, axis_limit_rad = 1e-12, derivative_limit = 1e-6;

double apart(double a, double b) {
    return std::abs(std::remainder(a - b, 2 * pi));
}

Vector3d random_direction(RandomNumbers& random) {
    const double z = random.between(-1, 1), turn = random.between(-pi, pi), r = std::sqrt(1 - z * z);
    return {r * std::cos(turn), r * std::sin(turn), z};
}

/// What a step of the tip costs the linear axes, mm per mm: without bound where those on both sides of a rotary axis
/// come to lie in a plane.
double stretch_of(const Kinematics& k, const RotaryPosition& rotary) {
    const auto zero = k.linear_for(Vector3d::Zero(), rotary);
    double sum = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const auto there = k.linear_for(Vector3d::Unit(axis), rotary);
        for (int i = 0; i < 3; ++i) sum += (there[i] - zero[i]) * (there[i] - zero[i]);
    }
    return std::sqrt(sum);
}

/// The largest misses of inverse and forward, one after the other.
struct Misses {
    bool linear_on_both_sides =
        false;  ///< of a rotary axis: poses whose linear axes lie nearly in a plane are left out
    double tip_mm = 0, axis_rad = 0;
    double angles_rad =
        0;  ///< of the angles that made the pose, times the sweep: what rounding of the pose does to them
    long poses = 0, unreached = 0, branches = 0, poles = 0, singular = 0;

    void take(const Kinematics& k, const AxisPosition& q) {
        const Pose pose = k.forward(q);
        const auto solutions = k.rotary_for(pose.axis_in_workpiece);
        ++poses;
        unreached += solutions.count == 0;
        branches += solutions.count;
        poles += solutions.degenerate;
        if (solutions.degenerate) return;  // to 1e-8 rad: the laws of the pole are elsewhere
        double nearest = 10;
        for (int branch = 0; branch < solutions.count; ++branch) {
            const auto& angles = solutions.rotary_rad[branch];
            axis_rad = std::max(axis_rad, (k.tool_axis(angles) - pose.axis_in_workpiece).norm());
            nearest = std::min(nearest, apart(angles[0], q[3]) + apart(angles[1], q[4]));
            const auto linear = k.linear_for(pose.tip_in_workpiece_mm, angles);
            if (linear_on_both_sides && !(stretch_of(k, angles) < 10)) {
                ++singular;
                continue;
            }
            const Pose again = k.forward({{linear[0], linear[1], linear[2], angles[0], angles[1]}});
            tip_mm = std::max(tip_mm, (again.tip_in_workpiece_mm - pose.tip_in_workpiece_mm).norm());
        }
        if (nearest <= angles_rad) return;  // the sweep is at most 1
        const double sweep = sweep_of(k, {q[3], q[4]});
        if (sweep > 1e-4) angles_rad = std::max(angles_rad, nearest * sweep);
    }
};

class Accuracy : public OnShippedMachine {
  protected:
    AxisPosition random_position() {
        AxisPosition q;
        for (int i = 0; i < machine.axis_count; ++i) {
            const Axis& axis = machine.axes[i];
            const double turn = axis.rotary ? pi : 1000;  // windings are the task of other tests
            q[i] = random.between(std::max(axis.range_min, -turn), std::min(axis.range_max, turn));
        }
        return q;
    }
};

TEST_P(Accuracy, OfAMillionPoses) {
    constexpr int poses = 1'000'000;
    Misses misses;
    for (int i = 0; i < poses; ++i) misses.take(k(), random_position());
    EXPECT_EQ(misses.unreached, 0);
    EXPECT_EQ(misses.branches + misses.poles, k().rotary_count() == 2 ? 2 * poses : poses);
    EXPECT_LT(misses.poles, 10);
    EXPECT_LE(misses.tip_mm, tip_limit_mm);
    EXPECT_LE(misses.axis_rad, axis_limit_rad);
    EXPECT_LE(misses.angles_rad, axis_limit_rad);
    std::cout << "tip " << misses.tip_mm << " mm, axis " << misses.axis_rad << " rad, angles " << misses.angles_rad
              << " rad\n";
}

/// The tool axis on the line n + p·v + p²·w, the tip on another, and the machine axes that follow.
struct Motion {
    std::array<Vector3d, 3> axis, tip_mm;

    static VectorSeries at(const std::array<Vector3d, 3>& c, double p) {
        const Vector3d value = c[0] + p * (c[1] + p * c[2]), slope = c[1] + 2 * p * c[2];
        VectorSeries out;
        for (int i = 0; i < 3; ++i) out[i] = Taylor3(value[i], slope[i], c[2][i], 0);
        return out;
    }
    std::array<Taylor3, 5> machine_axes(const Kinematics& k, double p, const RotaryPosition& near) const {
        const RotarySeries rotary = k.rotary_series(at(axis, p), near);
        const VectorSeries linear = k.linear_for(at(tip_mm, p), rotary);
        return {linear[0], linear[1], linear[2], rotary[0], rotary[1]};
    }
};

/// Each derivative against five-point differences, h apart, of the one before it: the largest miss, relative to the
/// derivative itself or, where that is more, to what turning at a rate amounts to in that order.
double derivative_miss(const Kinematics& k, const Motion& motion, const RotaryPosition& near, double h, double rate) {
    std::array<std::array<Taylor3, 5>, 5> at;
    for (int i = 0; i < 5; ++i) at[i] = motion.machine_axes(k, (i - 2) * h, near);
    double worst = 0;
    for (int axis = 0; axis < 5; ++axis) {
        const auto derivative = [&](int i, int order) {
            const Taylor3& s = at[i][axis];
            return order == 0 ? s.value() : order == 1 ? s.d1() : order == 2 ? s.d2() : s.d3();
        };
        for (int order = 1; order <= 3; ++order) {
            const double inner = derivative(3, order - 1) - derivative(1, order - 1);
            const double outer = derivative(4, order - 1) - derivative(0, order - 1);
            const double usual = (axis < 3 ? 100 : 1) * std::pow(rate, order);
            const double scale = std::max(std::abs(derivative(2, order)), usual);
            worst = std::max(worst, std::abs(derivative(2, order) - (8 * inner - outer) / (12 * h)) / scale);
        }
    }
    return worst;
}

/// A motion in any direction from the pose of `q`.
double derivative_miss_from(const Kinematics& k, const AxisPosition& q, RandomNumbers& random) {
    const Pose pose = k.forward(q);
    const Vector3d v = random_direction(random), w = random_direction(random), tip_v = random_direction(random),
                   tip_w = random_direction(random);
    const Motion motion{{pose.axis_in_workpiece, v, 0.3 * w}, {pose.tip_in_workpiece_mm, 30 * tip_v, 20 * tip_w}};
    const double sweep = sweep_of(k, {q[3], q[4]});
    return derivative_miss(k, motion, {q[3], q[4]}, 1e-3 * sweep * sweep, 1);
}

TEST_P(Accuracy, OfDerivatives) {
    if (k().rotary_count() < 2) GTEST_SKIP() << "the tool axis cannot go where it likes";
    double worst = 0;
    int met = 0;
    for (int i = 0; i < 20'000; ++i) {
        const AxisPosition q = random_position();
        if (sweep_of(k(), {q[3], q[4]}) < 0.1) continue;
        worst = std::max(worst, derivative_miss_from(k(), q, random));
        ++met;
    }
    EXPECT_GT(met, 10'000);
    EXPECT_LE(worst, derivative_limit);
    std::cout << "derivatives " << worst << "\n";
}

/// Past the pole at a distance, in any direction.
TEST_P(Accuracy, OfDerivativesBesideThePole) {
    if (k().rotary_count() < 2) GTEST_SKIP() << "no pole";
    const auto nearest = static_cast<std::size_t>(k().rotary_nearest_workpiece());
    Vector3d pole = workpiece.rotation.transpose() * machine.axes[3 + nearest].direction;
    if (k().rotary_for(pole).count == 0) pole = -pole;
    for (const double distance : {1e-2, 1e-4, 1e-6}) {
        double worst = 0;
        for (int i = 0; i < 2000; ++i) {
            const Vector3d side = pole.cross(random_direction(random)).normalized();
            const Vector3d v = random_direction(random), w = random_direction(random);
            const Motion motion{{(pole + distance * side).normalized(), v, 0.3 * w},
                                {Vector3d(10, -20, 30), 30 * v, 20 * w}};
            const auto solutions = k().rotary_for(motion.axis[0]);
            ASSERT_EQ(solutions.count, 2);
            for (const auto& near : solutions.rotary_rad)
                worst = std::max(worst, derivative_miss(k(), motion, near, 3e-3 * distance, 1 / distance));
        }
        EXPECT_LE(worst, derivative_limit) << distance;
        std::cout << "derivatives " << distance << " rad beside the pole " << worst << "\n";
    }
}

INSTANTIATE_TEST_SUITE_P(Shipped, Accuracy, testing::ValuesIn(machine_files()), stem);

/// Linear axes askew, rotary ones in any direction and place, in any order; every third with cones of equal angles (it
/// has a pole), every seventh at right angles.
Machine random_machine(RandomNumbers& random, int number) {
    Machine out;
    out.axis_count = 5;
    out.rotary_count = 2;
    Eigen::Matrix3d linear;
    do {
        for (int i = 0; i < 3; ++i) linear.col(i) = random_direction(random);
    } while (std::abs(linear.determinant()) < 0.3);
    std::array<Vector3d, 2> turning{random_direction(random), random_direction(random)};
    const double around = random.between(-pi, pi);
    if (number % 3 == 0) turning[0] = Eigen::AngleAxisd(around, turning[1]) * Vector3d::UnitZ();
    if (number % 7 == 0) {
        turning[1] = Vector3d(turning[1].x(), turning[1].y(), 0).normalized();
        turning[0] = Eigen::AngleAxisd(around, turning[1]) * Vector3d::UnitZ();
    }
    for (int i = 0; i < 5; ++i) {
        Axis& axis = out.axes[i];
        axis.letter = "XYZBC"[i];
        axis.rotary = i >= 3;
        axis.direction = axis.rotary ? turning[i - 3] : Vector3d(linear.col(i));
        const double x = random.between(-300, 300), y = random.between(-300, 300), z = random.between(-300, 300);
        if (axis.rotary) axis.point_mm = {x, y, z};
        axis.reversed = random.between(0, 1) < 0.5;
        out.chain[i] = static_cast<std::int8_t>(i);
    }
    // B stands before C, so that `turning[0]` is the one nearest to the workpiece; the rest of the order is drawn
    for (int i = 4; i > 0; --i) std::swap(out.chain[i], out.chain[static_cast<int>(random.between(0, i + 1))]);
    const auto b = std::ranges::find(out.chain, 3), c = std::ranges::find(out.chain, 4);
    if (c < b) std::iter_swap(b, c);
    return out;
}

TEST(RandomMachines, AreSolvedLikeAnyOther) {
    constexpr int machines = 10'000, poses = 20;
    RandomNumbers random(random_seed());
    Misses misses{.linear_on_both_sides = true};
    int refused = 0, moved = 0;
    double worst = 0;
    for (int number = 0; number < machines; ++number) {
        const Machine machine = random_machine(random, number);
        Frame workpiece;
        workpiece.origin_mm = 100 * random_direction(random);
        const double turn = random.between(-pi, pi);
        workpiece.rotation = Eigen::AngleAxisd(turn, random_direction(random)).toRotationMatrix();
        const auto made = Kinematics::make(machine, workpiece, random.between(0, 200));
        if (!made) {
            EXPECT_EQ(made.error().code, "MACH0103");
            ++refused;
            continue;
        }
        for (int i = 0; i < poses; ++i) {
            AxisPosition q;
            for (int a = 0; a < 5; ++a) q[a] = random.between(-1, 1) * (a < 3 ? 400 : pi);
            misses.take(*made, q);
            const RotaryPosition rotary{q[3], q[4]};
            if (sweep_of(*made, rotary) < 0.2 || !(stretch_of(*made, rotary) < 10)) continue;
            worst = std::max(worst, derivative_miss_from(*made, q, random));
            ++moved;
        }
    }
    EXPECT_LT(refused, machines / 100);
    EXPECT_EQ(misses.unreached, 0);
    EXPECT_GT(misses.branches, misses.poses * 199 / 100);
    EXPECT_LT(misses.singular, misses.branches / 4);
    EXPECT_GT(moved, machines * poses / 4);
    EXPECT_LE(misses.tip_mm, tip_limit_mm);
    EXPECT_LE(misses.axis_rad, axis_limit_rad);
    EXPECT_LE(misses.angles_rad, axis_limit_rad);
    EXPECT_LE(worst, derivative_limit);
    std::cout << "tip " << misses.tip_mm << " mm, axis " << misses.axis_rad << " rad, angles " << misses.angles_rad
              << " rad, derivatives " << worst << ", refused " << refused << ", singular " << misses.singular
              << ", derivatives of " << moved << "\n";
}

}  // namespace
