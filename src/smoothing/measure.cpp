#include "detail/measure.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "detail/polyline.hpp"

namespace trunnion::smoothing {

namespace {

constexpr double largest_turn_rad = 0.2;  // beyond, angle and chord are no longer alike

machine::AxisPosition axes_at(const path::Run& run, std::size_t vertex) {
    const auto& at = run.vertices[vertex];
    const int linear = run.kinematics->axis_count() - run.kinematics->rotary_count();
    machine::AxisPosition axes;
    for (int a = 0; a < linear; ++a) axes[a] = at.position_mm[a];
    for (int a = linear; a < run.kinematics->axis_count(); ++a) axes[a] = at.orientation[a - linear];
    return axes;
}

/// Distance of the tip from rotary axis `axis`: half a turn moves it by twice that.
double distance_from_axis(const machine::Kinematics& kinematics, machine::AxisPosition axes, int axis) {
    const auto here = kinematics.forward(axes).tip_in_workpiece_mm;
    axes[axis] += std::numbers::pi;
    return 0.5 * (kinematics.forward(axes).tip_in_workpiece_mm - here).norm();
}

/// Largest distance of the tip from a rotary axis along the run. Between two vertices it changes by at most the way
/// from the nearer one: linear axes directly, the other rotary axis by at most the distance times its turn.
double largest_arm(const path::Run& run, VertexRange range) {
    const auto& kinematics = *run.kinematics;
    const int linear = kinematics.axis_count() - kinematics.rotary_count();
    double arm = 0, way = 0, turn = 0;
    for (std::size_t i = range.first; i <= range.last; ++i) {
        const auto axes = axes_at(run, i);
        for (int a = linear; a < kinematics.axis_count(); ++a)
            arm = std::max(arm, distance_from_axis(kinematics, axes, a));
        if (i == range.last) break;
        const Coordinates step = joined(run.vertices[i + 1]) - joined(run.vertices[i]);
        const path::Block& block = run.blocks[i];
        const bool straight = block.arc == program::no_arc && block.curve == path::no_curve;
        way = std::max(way, straight ? step.head<3>().norm() : block.length_mm);
        turn = std::max(turn, step.tail<3>().cwiseAbs().maxCoeff());
        if (block.curve != path::no_curve && run.curves[block.curve].orientation)
            turn = std::max(turn, run.curves[block.curve].orientation->polygon_length());
    }
    return (arm + 0.5 * way) * std::exp(0.5 * turn);
}

/// What the two rotary axes' turns of the tool axis n have to do with each other: |∂n/∂θ₂|, which is the same
/// everywhere, and the largest |∂n/∂θ₁ · ∂n/∂θ₂|. The latter is A + B cos(θ₂ − φ), known from three places.
struct TurnsOfTwo {
    double second = 1, product = 0;
};

constexpr double right_angle = 1e-12;  // below, two directions are perpendicular

TurnsOfTwo turns_of_two(const machine::Kinematics& kinematics) {
    const int first = kinematics.rotary_nearest_workpiece();
    std::array<double, 3> products;
    TurnsOfTwo out;
    for (int k = 0; k < 3; ++k) {
        std::array<Eigen::Vector3d, 2> rate;
        for (int moved = 0; moved < 2; ++moved) {
            machine::RotarySeries rotary;
            for (int i = 0; i < 2; ++i)
                rotary[i] = Taylor3(i == first ? 0 : k * std::numbers::pi / 1.5, i == moved ? 1 : 0, 0, 0);
            const machine::VectorSeries axis = kinematics.tool_axis(rotary);
            rate[moved] = {axis[0].d1(), axis[1].d1(), axis[2].d1()};
        }
        products[k] = rate[0].dot(rate[1]);
        out.second = rate[1 - first].norm();
    }
    const double mean = (products[0] + products[1] + products[2]) / 3;
    double square = 0;
    for (const double product : products) square += (product - mean) * (product - mean);
    out.product = std::abs(mean) + std::sqrt(square / 1.5);
    if (out.product < right_angle) out.product = 0;
    if (std::abs(out.second - 1) < right_angle) out.second = 1;
    return out;
}

}  // namespace

Measure::Measure(const path::Run& run, VertexRange range, const SmoothingOptions& options)
    : options_(options), vectors_(has_vectors(run)), lever_axis_(smoothing::lever_axis(run)) {
    if (run.space == path::Space::machine && run.kinematics && run.kinematics->rotary_count() > 0)
        arm_mm_ = largest_arm(run, range);
    if (lever_axis_ < 0) return;
    const TurnsOfTwo turns = turns_of_two(*run.kinematics);
    other_lever_ = turns.second;
    product_ = turns.product;
}

double Measure::turn(const Coordinates& d, double lever) const {
    if (lever_axis_ < 0) return d.tail<3>().norm();
    const double nearest = lever * d[lever_axis_], other = other_lever_ * d[lever_axis_ == 3 ? 4 : 3];
    const double product = std::min(product_, lever * other_lever_) * std::abs(d[3] * d[4]);
    return std::sqrt(nearest * nearest + other * other + 2 * product);
}

double Measure::point(const Coordinates& d, double lever, double height_mm) const {
    if (vectors_) return (d.head<3>() + height_mm * d.tail<3>()).norm();
    double way = d.head<3>().norm();
    if (height_mm > 0) way += height_mm * turn(d, lever);
    if (arm_mm_ > 0) way += arm_mm_ * (std::abs(d[3]) + std::abs(d[4]));
    return way;
}

double Measure::use(const Coordinates& d, double lever) const {
    const bool flank = options_.flank_tolerance_mm > 0;
    return use_of(point(d, lever, options_.controlled_height_mm), turn(d, lever),
                  flank ? point(d, lever, options_.flank_height_mm) : 0);
}

Coordinates Measure::metric(double lever) const {
    const double height = options_.flank_height_mm;
    Coordinates weight;
    weight << 1, 1, 1, Eigen::Vector3d::Constant(height * height);
    if (lever_axis_ >= 0) weight[lever_axis_] *= lever * lever;
    return weight;
}

double Measure::nearness_square() const {
    const double of_turn = options_.flank_height_mm * turn_tolerance_rad();
    double nearness = std::min(options_.tip_tolerance_mm, of_turn);
    // The point up the tool moves by tip and turn together: at most by √2 of their length.
    if (options_.flank_tolerance_mm > 0)
        nearness = std::min(nearness, options_.flank_tolerance_mm / std::numbers::sqrt2);
    if (options_.controlled_height_mm > 0)
        nearness *= options_.flank_height_mm / std::hypot(options_.flank_height_mm, options_.controlled_height_mm);
    return nearness * nearness;
}

double Measure::use_of(double tip_mm, double turn_rad, double height_mm) const {
    const double tip = tip_mm / options_.tip_tolerance_mm;
    if (options_.flank_tolerance_mm <= 0) return std::max(tip, turn_rad / turn_tolerance_rad());
    return std::max({tip, height_mm / options_.flank_tolerance_mm, turn_rad / largest_turn_rad});
}

double Measure::turn_tolerance_rad() const {
    if (options_.flank_tolerance_mm <= 0) return std::min(options_.orientation_tolerance_rad, largest_turn_rad);
    return std::min(options_.flank_tolerance_mm / std::max(options_.flank_height_mm, 1e-3), largest_turn_rad);
}

}  // namespace trunnion::smoothing
