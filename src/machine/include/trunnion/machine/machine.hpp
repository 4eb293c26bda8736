#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

namespace trunnion::machine {

inline constexpr int max_axes = 5;
inline constexpr int max_rotary_axes = 2;

/// A vector over the machine axes, linear axes (mm) in alphabetical order, then rotary axes (rad) in alphabetical
/// order: the order of the setpoint columns. Axes the machine has not are 0. `Quantity` keeps position, velocity,
/// acceleration and jerk apart.
template <class Quantity>
struct AxisVector {
    std::array<double, max_axes> v{};
    constexpr double& operator[](std::size_t axis) { return v[axis]; }
    constexpr double operator[](std::size_t axis) const { return v[axis]; }
    bool operator==(const AxisVector&) const = default;
};
using AxisPosition = AxisVector<struct PositionTag>;          ///< mm, rad, in the control's count
using AxisVelocity = AxisVector<struct VelocityTag>;          ///< mm/s, rad/s
using AxisAcceleration = AxisVector<struct AccelerationTag>;  ///< mm/s², rad/s²
using AxisJerk = AxisVector<struct JerkTag>;                  ///< mm/s³, rad/s³

/// mm/s, mm/s², mm/s³ of a linear axis; rad/s, rad/s², rad/s³ of a rotary one. All > 0.
struct AxisLimits {
    double velocity = 0, acceleration = 0, jerk = 0;
};

struct Axis {
    char letter = 'X';
    bool rotary = false;
    bool reversed = false;                                 ///< the control counts against ISO 841
    Eigen::Vector3d direction = Eigen::Vector3d::UnitX();  ///< unit, machine frame, all axes at 0
    Eigen::Vector3d point_mm = Eigen::Vector3d::Zero();  ///< rotary: a point on the axis, machine frame, all axes at 0
    double range_min = -std::numeric_limits<double>::infinity();  ///< in the control's count; infinite = endless
    double range_max = std::numeric_limits<double>::infinity();
    AxisLimits feed;   ///< limits
    AxisLimits rapid;  ///< limits of rapids; the same as `feed` unless the file says otherwise
};

/// Words of this control that the dialect's reader does not know by itself.
struct ControlWords {
    std::vector<std::string> tcp_on, tcp_off, ignore, following;
};

/// A machine as its file says. Plain values; `Kinematics` does the geometry.
struct Machine {
    std::string name;
    std::string file;
    std::array<Axis, max_axes> axes;  ///< order of AxisVector; the first `axis_count` count
    int axis_count = 0;
    int rotary_count = 0;                       ///< the last ones of axes
    std::array<std::int8_t, max_axes> chain{};  ///< indices into axes, workpiece → tool; the first `axis_count` count
    ControlWords words;

    int linear_count() const { return axis_count - rotary_count; }
    /// Index into axes, −1 if the machine has no such axis.
    int index_of(char letter) const {
        for (int i = 0; i < axis_count; ++i)
            if (axes[i].letter == letter) return i;
        return -1;
    }
};

/// A frame: x_outer = rotation · x_inner + origin_mm.
struct Frame {
    Eigen::Vector3d origin_mm = Eigen::Vector3d::Zero();
    Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
};

enum class ToolKind : std::uint8_t { flat, ball, torus, taper };

struct Tool {
    ToolKind kind = ToolKind::flat;
    double diameter_mm = 0;
    double corner_radius_mm = 0;
    double length_mm = 0;          ///< gauge line → tip
    bool controls_centre = false;  ///< the tolerance is of the ball's or torus' centre, not of the tip
    /// Distance of the controlled point from the tip, up the tool axis.
    double controlled_height_mm() const {
        if (!controls_centre) return 0;
        return kind == ToolKind::ball ? diameter_mm / 2 : corner_radius_mm;
    }
};

/// How the part and the tool sit in the machine.
struct Setup {
    std::string file;                      ///< empty: none was given
    Frame workpiece;                       ///< program zero in the machine frame, all axes at 0
    Tool tool;                             ///< of a program that names none
    std::map<std::string, Tool> tools;     ///< by number or name, as T words say; a further edge as `8 D2`
    std::map<std::string, Frame> offsets;  ///< by word (`G54`), relative to `workpiece`
    std::map<char, double> start, home;    ///< axis letter → mm or rad

    /// The tool of a name that a program calls: that of `tools`; a name that ends in ` D0` (tool offset off) is a tool
    /// of length 0. Null: not in the table.
    const Tool* tool_named(std::string_view name) const;
};

}  // namespace trunnion::machine
