// One list of laws that every shipped machine obeys.

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "trunnion/files/machine_file.hpp"
#include "trunnion/files/shipped_machines.hpp"
#include "trunnion/machine/kinematics.hpp"

#include "random_numbers.hpp"
#include "shipped_machine.hpp"
#include "sweep.hpp"

namespace {

using namespace trunnion;
using namespace trunnion::machine;
using Eigen::Vector3d;

constexpr int trials = 2000;
constexpr double pi = std::numbers::pi;

/// Those with two rotary axes: all of them reach their pole.
std::vector<std::string> files_with_a_pole() {
    auto out = machine_files();
    std::erase_if(out, [](const std::string& file) {
        const auto read = files::read_machine_file(file);
        return read && read->rotary_count < 2;
    });
    return out;
}

double wrapped(double angle) {
    return std::remainder(angle, 2 * pi);
}

/// The chain as a product of rigid motions, read from the workpiece to the tool: written without looking at the room.
Pose product_of_chain(const Machine& machine, const Frame& workpiece, double length_mm, const AxisPosition& q) {
    Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
    for (int i = 0; i < machine.axis_count; ++i) {
        const int at = machine.chain[i];
        const Axis& axis = machine.axes[at];
        const double value = axis.reversed ? -q[at] : q[at];
        if (!axis.rotary) {
            motion = motion * Eigen::Translation3d(value * axis.direction);
            continue;
        }
        motion = motion * Eigen::Translation3d(axis.point_mm) * Eigen::AngleAxisd(value, axis.direction) *
                 Eigen::Translation3d(-axis.point_mm);
    }
    Eigen::Isometry3d frame = Eigen::Isometry3d::Identity();
    frame.linear() = workpiece.rotation;
    frame.translation() = workpiece.origin_mm;
    const Eigen::Isometry3d seen = frame.inverse() * motion;
    return {seen * Vector3d(0, 0, -length_mm), seen.linear() * Vector3d::UnitZ()};
}

class Laws : public OnShippedMachine {
  protected:
    bool right_angles() const {
        return std::ranges::all_of(machine.axes,
                                   [](const Axis& axis) { return axis.direction.cwiseAbs().maxCoeff() == 1; });
    }

    AxisPosition random_position() {
        AxisPosition q;
        for (int i = 0; i < machine.axis_count; ++i) {
            const Axis& axis = machine.axes[i];
            const bool endless = std::isinf(axis.range_min);
            q[i] = random.between(endless ? -20.0 : axis.range_min, endless ? 20.0 : axis.range_max);
        }
        return q;
    }
    static double rounding_of(const AxisPosition& q) { return 1e-15 * (std::abs(q[3]) + std::abs(q[4])); }
    static RotaryPosition rotary_of(const AxisPosition& q) { return {q[3], q[4]}; }

    /// Area that the tool axis sweeps on its sphere per rad² of both axes: 0 at the pole and at the rim. With both axes
    /// at right angles it is the lever. 1 with fewer axes.
    double sweep(const RotaryPosition& rotary) const { return sweep_of(k(), rotary); }

    /// A smooth motion of all axes through `q`, its value at p and its series at p = 0.
    struct Motion {
        AxisPosition at, amplitude, phase;
        double value(std::size_t i, double p) const {
            return at[i] + amplitude[i] * (std::sin(p + phase[i]) - std::sin(phase[i]));
        }
        Taylor3 series(std::size_t i) const {
            return Taylor3(at[i] - amplitude[i] * std::sin(phase[i])) + amplitude[i] * sin(Taylor3(phase[i], 1, 0, 0));
        }
        VectorSeries linear() const { return {series(0), series(1), series(2)}; }
        RotarySeries rotary() const { return {series(3), series(4)}; }
        AxisPosition position(double p) const {
            AxisPosition out;
            for (std::size_t i = 0; i < max_axes; ++i) out[i] = value(i, p);
            return out;
        }
    };
    Motion random_motion() {
        Motion out{.at = random_position(), .amplitude = {}, .phase = {}};
        for (int i = 0; i < machine.axis_count; ++i) {
            out.amplitude[i] = random.between(0.2, 1) * (machine.axes[i].rotary ? 0.3 : 30);
            out.phase[i] = random.between(-pi, pi);
        }
        return out;
    }
};

TEST_P(Laws, ForwardIsTheProductOfTheChain) {
    for (int i = 0; i < trials; ++i) {
        const auto q = random_position();
        const Pose ours = k().forward(q), truth = product_of_chain(machine, workpiece, tool_length_mm, q);
        EXPECT_LT((ours.tip_in_workpiece_mm - truth.tip_in_workpiece_mm).norm(), 1e-10);
        EXPECT_LT((ours.axis_in_workpiece - truth.axis_in_workpiece).norm(), 1e-14);
    }
}

TEST_P(Laws, InverseUndoesForward) {
    for (int i = 0; i < trials; ++i) {
        const auto q = random_position();
        const Pose pose = k().forward(q);
        const auto solutions = k().rotary_for(pose.axis_in_workpiece);
        ASSERT_GT(solutions.count, 0);
        double nearest = 10;
        for (int branch = 0; branch < solutions.count; ++branch) {
            const auto& rotary = solutions.rotary_rad[branch];
            nearest =
                std::min(nearest, std::max(std::abs(wrapped(rotary[0] - q[3])), std::abs(wrapped(rotary[1] - q[4]))));
        }
        const double noise = 1e-14 / std::max(sweep(rotary_of(q)), 1e-6) + rounding_of(q);
        EXPECT_LT(nearest, noise) << "q = " << q[3] << " " << q[4];
        const auto linear = k().linear_for(pose.tip_in_workpiece_mm, rotary_of(q));
        for (std::size_t a = 0; a < 3; ++a) EXPECT_NEAR(linear[a], q[a], 1e-9);
    }
}

TEST_P(Laws, EveryBranchGivesThePoseAndLiesWithinOneTurn) {
    for (int i = 0; i < trials; ++i) {
        const Pose pose = k().forward(random_position());
        const auto solutions = k().rotary_for(pose.axis_in_workpiece);
        ASSERT_EQ(solutions.count, k().rotary_count() == 2 ? 2 : 1);
        EXPECT_FALSE(solutions.degenerate);
        for (int branch = 0; branch < solutions.count; ++branch) {
            const auto& rotary = solutions.rotary_rad[branch];
            const auto linear = k().linear_for(pose.tip_in_workpiece_mm, rotary);
            const Pose again = k().forward({{linear[0], linear[1], linear[2], rotary[0], rotary[1]}});
            EXPECT_LT((again.axis_in_workpiece - pose.axis_in_workpiece).norm(), 1e-14);
            EXPECT_LT((again.tip_in_workpiece_mm - pose.tip_in_workpiece_mm).norm(), 1e-9);
            for (const double angle : rotary) EXPECT_TRUE(angle > -pi && angle <= pi) << angle;
        }
        if (solutions.count == 2) {
            const int first = k().rotary_nearest_workpiece();
            const double apart = std::abs(wrapped(solutions.rotary_rad[0][first] - solutions.rotary_rad[1][first]));
            if (right_angles()) {
                EXPECT_NEAR(apart, pi, 1e-9);
            }
            EXPECT_GT(
                apart + std::abs(wrapped(solutions.rotary_rad[0][1 - first] - solutions.rotary_rad[1][1 - first])),
                1e-9);
        }
    }
}

/// Central differences of fourth order with seven places.
std::array<double, 4> differences(const auto& f) {
    constexpr double h = 0.02;
    const double a = f(h) - f(-h), b = f(2 * h) - f(-2 * h), c = f(3 * h) - f(-3 * h);
    const double d = f(h) + f(-h), e = f(2 * h) + f(-2 * h), g = f(3 * h) + f(-3 * h), m = f(0.0);
    return {m, (45 * a - 9 * b + c) / (60 * h), (270 * d - 27 * e + 2 * g - 490 * m) / (180 * h * h),
            (-13 * a + 8 * b - c) / (8 * h * h * h)};
}

void expect_series(const Taylor3& series, const std::array<double, 4>& truth, double scale) {
    EXPECT_NEAR(series.value(), truth[0], 1e-10 * scale);
    EXPECT_NEAR(series.d1(), truth[1], 1e-7 * scale);
    EXPECT_NEAR(series.d2(), truth[2], 1e-6 * scale);
    EXPECT_NEAR(series.d3(), truth[3], 1e-4 * scale);
}

TEST_P(Laws, SeriesOfForwardAreItsDerivatives) {
    for (int i = 0; i < trials / 20; ++i) {
        const Motion motion = random_motion();
        const VectorSeries tip = k().tip_for(motion.linear(), motion.rotary()), axis = k().tool_axis(motion.rotary());
        for (int c = 0; c < 3; ++c) {
            expect_series(tip[c],
                          differences([&](double p) { return k().forward(motion.position(p)).tip_in_workpiece_mm[c]; }),
                          300);
            expect_series(axis[c],
                          differences([&](double p) { return k().forward(motion.position(p)).axis_in_workpiece[c]; }),
                          1);
        }
    }
}

TEST_P(Laws, SeriesOfTheInverseUndoThoseOfForward) {
    for (int i = 0; i < trials; ++i) {
        const Motion motion = random_motion();
        const RotarySeries rotary = motion.rotary();
        const double area = sweep(rotary_of(motion.at));
        if (area < (right_angles() ? 0.05 : 0.2)) continue;
        VectorSeries axis = k().tool_axis(rotary);
        const Taylor3 any_length{2.5, 0.3, -0.2, 0.1};
        for (auto& component : axis) component = any_length * component;
        const RotarySeries found = k().rotary_series(axis, rotary_of(motion.at));
        const VectorSeries linear = k().linear_for(k().tip_for(motion.linear(), rotary), rotary);
        const double steepness = right_angles() ? 3 : 6;  // beside the rim the turn is a square root
        const double noise = 1e-13 / std::pow(area, steepness) + rounding_of(motion.at);
        for (int order = 0; order < 4; ++order) {
            for (int a = 0; a < k().rotary_count(); ++a)
                EXPECT_NEAR(found[a].c[order], rotary[a].c[order], noise) << area;
            for (int a = 0; a < 3; ++a) EXPECT_NEAR(linear[a].c[order], motion.linear()[a].c[order], 1e-9);
        }
    }
}

TEST_P(Laws, SeriesKeepTheBranchAndWindingOfTheReference) {
    for (int i = 0; i < trials; ++i) {
        auto q = random_position();
        for (int a = 0; a < k().rotary_count(); ++a) q[3 + a] += 2 * pi * std::round(random.between(-300, 300));
        const Vector3d axis = k().forward(q).axis_in_workpiece;
        const auto found = k().rotary_series({Taylor3(axis.x()), Taylor3(axis.y()), Taylor3(axis.z())}, rotary_of(q));
        const double noise = 1e-12 / std::max(sweep(rotary_of(q)), 1e-6);
        for (int a = 0; a < k().rotary_count(); ++a) EXPECT_NEAR(found[a].value(), q[3 + a], noise);
    }
}

TEST_P(Laws, ReversedAxesCountTheOtherWay) {
    for (int flipped = 0; flipped < machine.axis_count; ++flipped) {
        Machine other = machine;
        other.axes[flipped].reversed = !other.axes[flipped].reversed;
        const auto opposite = Kinematics::make(other, workpiece, tool_length_mm);
        ASSERT_TRUE(opposite);
        for (int i = 0; i < trials / 20; ++i) {
            const auto q = random_position();
            auto counted = q;
            counted[flipped] = -counted[flipped];
            const Pose pose = k().forward(q), same = opposite->forward(counted);
            EXPECT_LT((pose.tip_in_workpiece_mm - same.tip_in_workpiece_mm).norm(), 1e-10);
            EXPECT_LT((pose.axis_in_workpiece - same.axis_in_workpiece).norm(), 1e-14);
            const auto linear = opposite->linear_for(pose.tip_in_workpiece_mm, rotary_of(counted));
            for (std::size_t a = 0; a < 3; ++a) EXPECT_NEAR(linear[a], counted[a], 1e-9);
        }
    }
}

/// ISO 841: the axis nearest to the workpiece turns what stands behind it right-handed about its direction.
TEST_P(Laws, PositiveIsTheToolRelativeToTheWorkpiece) {
    const Pose zero = k().forward({});
    for (std::size_t a = 0; a < 3; ++a) {
        AxisPosition q;
        q[a] = 7;
        const Vector3d expected = (machine.axes[a].reversed ? -7 : 7) * machine.axes[a].direction;
        EXPECT_LT(
            (workpiece.rotation * (k().forward(q).tip_in_workpiece_mm - zero.tip_in_workpiece_mm) - expected).norm(),
            1e-12);
    }
    for (int a = 3; a < machine.axis_count; ++a) {
        AxisPosition q;
        q[a] = 0.3;
        const double turn = machine.axes[a].reversed ? -0.3 : 0.3;
        const Vector3d expected = Eigen::AngleAxisd(turn, machine.axes[a].direction) * Vector3d::UnitZ();
        EXPECT_LT((workpiece.rotation * k().forward(q).axis_in_workpiece - expected).norm(), 1e-14);
    }
}

TEST_P(Laws, LeverIsHowFarTheNearestAxisSwingsTheTool) {
    for (int i = 0; i < trials; ++i) {
        const auto q = random_position();
        if (k().rotary_count() < 2) {
            EXPECT_EQ(k().lever(rotary_of(q)), 1);
            continue;
        }
        const std::size_t nearest = static_cast<std::size_t>(k().rotary_nearest_workpiece());
        RotarySeries rotary{Taylor3(q[3]), Taylor3(q[4])};
        rotary[nearest].c[1] = 1;
        const VectorSeries axis = k().tool_axis(rotary);
        EXPECT_NEAR(k().lever(rotary_of(q)), std::hypot(axis[0].d1(), axis[1].d1(), axis[2].d1()), 1e-14);
    }
}

class PoleLaws : public Laws {
  protected:
    void SetUp() override {
        Laws::SetUp();
        nearest = static_cast<std::size_t>(k().rotary_nearest_workpiece());
        other = 1 - nearest;
        const Axis& axis = machine.axes[3 + nearest];
        pole = workpiece.rotation.transpose() * axis.direction;
        if (k().rotary_for(pole).count == 0) pole = -pole;
        sideways = pole.unitOrthogonal();
        RotarySeries turning{Taylor3(0), Taylor3(0)};
        turning[other].c[1] = 1;
        const VectorSeries swung = k().tool_axis(turning);
        tilt = std::hypot(swung[0].d1(), swung[1].d1(), swung[2].d1());
    }
    VectorSeries series(const Vector3d& value, const Vector3d& slope) const {
        return {Taylor3(value.x(), slope.x(), 0, 0), Taylor3(value.y(), slope.y(), 0, 0),
                Taylor3(value.z(), slope.z(), 0, 0)};
    }
    std::size_t nearest = 0, other = 1;
    Vector3d pole, sideways;
    double tilt = 1;  ///< how far the other axis swings the tool, rad per rad
};

TEST_P(PoleLaws, SolutionsBesideThePoleAreAsGoodAsElsewhere) {
    for (const double distance : {1e-2, 1e-4, 1e-6}) {
        for (int i = 0; i < 50; ++i) {
            const Vector3d side = Eigen::AngleAxisd(random.between(-pi, pi), pole) * sideways;
            const Vector3d axis = (std::cos(distance) * pole + std::sin(distance) * side).normalized();
            const auto solutions = k().rotary_for(axis);
            ASSERT_EQ(solutions.count, 2);
            EXPECT_FALSE(solutions.degenerate);
            for (const auto& rotary : solutions.rotary_rad) {
                EXPECT_LT((k().tool_axis(rotary) - axis).norm(), 1e-15 * 3);
                EXPECT_NEAR(k().lever(rotary) / distance, 1, 1e-9 + distance);
            }
        }
    }
}

TEST_P(PoleLaws, AtThePoleTheNearestAxisStaysWhereItIs) {
    const auto solutions = k().rotary_for(pole);
    EXPECT_TRUE(solutions.degenerate);
    ASSERT_EQ(solutions.count, 1);
    EXPECT_EQ(solutions.rotary_rad[0][nearest], 0);
    EXPECT_LT((k().tool_axis(solutions.rotary_rad[0]) - pole).norm(), 1e-15 * 3);
    RotaryPosition near{};
    near[nearest] = 17.25;
    near[other] = solutions.rotary_rad[0][other];
    const auto found = k().rotary_series(series(pole, {0, 0, 0}), near);
    EXPECT_EQ(found[nearest].c, (std::array<double, 4>{17.25, 0, 0, 0}));
    EXPECT_NEAR(found[other].value(), near[other], 1e-15);
}

/// A tool axis that swings through the pole in the plane of the second axis: that axis alone moves, evenly, and the
/// nearest one does not take notice however near to the pole the place is.
TEST_P(PoleLaws, StraightThroughThePoleOnlyTheOtherAxisTurns) {
    RotaryPosition start{};
    start[nearest] = 0.7;
    const double at_pole = k().rotary_for(pole).rotary_rad[0][other];
    for (const double distance : {-1e-2, -1e-4, -1e-6, 0.0, 1e-6, 1e-4, 1e-2}) {
        RotarySeries rotary;
        rotary[nearest] = start[nearest];
        rotary[other] = Taylor3(at_pole + distance, 0.01, 0, 0);  // rad per mm of path
        RotaryPosition near{};
        near[nearest] = 0.7;
        near[other] = at_pole + distance;
        const auto found = k().rotary_series(k().tool_axis(rotary), near);
        for (int order = 0; order < 4; ++order) {
            EXPECT_NEAR(found[other].c[order], rotary[other].c[order], 1e-13) << distance << " " << order;
            EXPECT_NEAR(found[nearest].c[order], rotary[nearest].c[order], 1e-9) << distance << " " << order;
        }
        EXPECT_NEAR(found[nearest].value(), 0.7, distance == 0 ? 0 : 1e-9);
    }
}

/// A tool axis that passes the pole at a distance, sideways: θ = atan2(v p, d) has the derivatives v/d, 0, −2(v/d)³.
TEST_P(PoleLaws, SeriesOfANearMissAreExact) {
    const Vector3d across = pole.cross(sideways);
    for (const double distance : {1e-2, 1e-4, 1e-6}) {
        const double swing = 0.01;  // rad per mm of path
        const auto solutions = k().rotary_for((pole + distance * sideways).normalized());
        const auto found =
            k().rotary_series(series(pole + distance * sideways, swing * across), solutions.rotary_rad[0]);
        const double rate = swing / distance;
        const double bend = right_angles() ? 0 : distance;  // the circle on which the other axis passes the pole
        EXPECT_NEAR(std::abs(found[nearest].d1()) / rate, 1, 1e-9 + bend);
        EXPECT_NEAR(found[nearest].d2() / (rate * rate), 0, 1e-9 + bend);
        EXPECT_NEAR(found[nearest].d3() / (found[nearest].d1() * rate * rate), -2, 1e-8 + 4 * bend);
        EXPECT_NEAR(std::abs(found[other].d2()) * tilt / (swing * rate), 1, 1e-3);
    }
}

INSTANTIATE_TEST_SUITE_P(Shipped, Laws, testing::ValuesIn(machine_files()), stem);
INSTANTIATE_TEST_SUITE_P(Shipped, PoleLaws, testing::ValuesIn(files_with_a_pole()), stem);

/// Lin & Koren's example: an error of A of 0.017° moves the part, which stands at (·, 96, 120) mm, by 45.596 µm.
TEST(ShippedMachines, LinAndKorensPutsTheTableWhereTheirExampleHasIt) {
    const auto machine = files::read_machine_file(machines_folder() / "lin-koren.toml");
    ASSERT_TRUE(machine) << to_string(machine.error());
    const Vector3d table = machine->axes[4].point_mm, on_table(8, 0, 0);
    EXPECT_EQ(table, Vector3d(0, 96, 120));
    const Frame part{.origin_mm = table + on_table};
    const auto k = Kinematics::make(*machine, part, 0).value();
    const double error_rad = 0.017 * pi / 180;
    const auto before = k.linear_for(Vector3d::Zero(), {0, 0}), after = k.linear_for(Vector3d::Zero(), {error_rad, 0});
    const Vector3d moved(after[0] - before[0], after[1] - before[1], after[2] - before[2]);
    EXPECT_NEAR(moved.norm(), 0.045596, 1e-6);
    EXPECT_EQ(moved.x(), 0);
    // Eq. 11 with P = 0, OT = 0: their angles turn the part right-handed
    const Vector3d turned =
        Eigen::AngleAxisd(0.3, Vector3d::UnitX()) * (Eigen::AngleAxisd(-1.1, Vector3d::UnitZ()) * on_table + table);
    const auto linear = k.linear_for(Vector3d::Zero(), {0.3, -1.1});
    EXPECT_LT((Vector3d(linear[0], linear[1], linear[2]) - turned).norm(), 1e-12);
}

TEST(ShippedMachines, AreTheOnesPromised) {
    const std::array folders{machines_folder()};
    std::vector<std::string> names;
    for (const auto& machine : files::shipped_machines(folders)) {
        names.push_back(machine.name);
        EXPECT_FALSE(machine.title.empty()) << machine.name;
    }
    EXPECT_EQ(names, (std::vector<std::string>{"dmu70evo", "generic-5axis", "head-head", "head-table", "lin-koren",
                                               "nmv5000", "nutating-head", "nutating-head-table", "nutating-table",
                                               "three-axis", "trunnion-bc", "ucp710", "xyzab-tdr", "xyzac-trt",
                                               "xyzacb-trsrn", "xyzbc-trt"}));
}

}  // namespace
