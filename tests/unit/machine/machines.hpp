#pragma once

#include <string_view>
#include <vector>

#include "trunnion/machine/kinematics.hpp"

/// Machines for tests, put together in code.
namespace trunnion::machine::examples {

inline Axis linear(char letter, const Eigen::Vector3d& direction) {
    Axis out;
    out.letter = letter;
    out.direction = direction;
    return out;
}

inline Axis rotary(char letter, const Eigen::Vector3d& direction,
                   const Eigen::Vector3d& point_mm = Eigen::Vector3d::Zero()) {
    Axis out = linear(letter, direction);
    out.rotary = true;
    out.point_mm = point_mm;
    return out;
}

inline Axis usual(char letter) {
    const auto at = std::string_view("XAUYBVZCW").find(letter);
    const Eigen::Vector3d direction = Eigen::Vector3d::Unit(static_cast<Eigen::Index>(at / 3));
    const bool turns = std::string_view("ABC").find(letter) != std::string_view::npos;
    return turns ? rotary(letter, direction, {10.0 + letter - 'A', -5, 20}) : linear(letter, direction);
}

/// Axes in the order of AxisVector as given; the chain by letters, workpiece → tool.
inline Machine machine_of(const std::vector<Axis>& axes, std::string_view chain) {
    Machine out;
    out.axis_count = static_cast<int>(axes.size());
    for (std::size_t i = 0; i < axes.size(); ++i) {
        out.axes[i] = axes[i];
        out.rotary_count += axes[i].rotary;
    }
    for (std::size_t i = 0; i < chain.size(); ++i) out.chain[i] = static_cast<std::int8_t>(out.index_of(chain[i]));
    return out;
}

/// Usual axes; the letters that turn are `turning`, alphabetical.
inline Machine machine_of(std::string_view chain, std::string_view turning) {
    std::vector<Axis> axes{usual('X'), usual('Y'), usual('Z')};
    for (const char letter : turning) axes.push_back(usual(letter));
    return machine_of(axes, chain);
}

}  // namespace trunnion::machine::examples
