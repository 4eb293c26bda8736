#include <cmath>
#include <iterator>
#include <sstream>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <toml++/toml.h>

#include "trunnion/base/quantity.hpp"
#include "trunnion/files/machine_file.hpp"

#include "detail/exact_number.hpp"

namespace trunnion::files {

using machine::Axis;
using machine::AxisLimits;
using machine::Machine;

namespace {

std::string quoted(const std::string& text) {
    std::ostringstream out;
    out << toml::value<std::string>{text};
    return out.str();
}

/// With a unit, in quotes: in degrees where they give the same value again.
std::string quantity(double value, const Axis& axis, const char* per) {
    if (!axis.rotary) return fmt::format("\"{} mm{}\"", detail::number_in_unit(value, 1), per);
    if (const auto degrees = detail::exact_number(value, degree)) return fmt::format("\"{} deg{}\"", *degrees, per);
    return fmt::format("\"{} rad{}\"", detail::number_in_unit(value, 1), per);
}

std::string range_text(const Axis& axis) {
    if (!std::isfinite(axis.range_min)) return "\"endless\"";
    return fmt::format("[{}, {}]", quantity(axis.range_min, axis, ""), quantity(axis.range_max, axis, ""));
}

std::string vector_text(const Eigen::Vector3d& v, const char* format) {
    return fmt::format(fmt::runtime(fmt::format("[{0}, {0}, {0}]", format)), detail::number_in_unit(v.x(), 1),
                       detail::number_in_unit(v.y(), 1), detail::number_in_unit(v.z(), 1));
}

std::string rapid_text(const Axis& axis) {
    const AxisLimits &feed = axis.feed, &rapid = axis.rapid;
    std::vector<std::string> parts;
    const auto add = [&](double value, double usual, const char* key, const char* per) {
        if (value != usual) parts.push_back(fmt::format("{} = {}", key, quantity(value, axis, per)));
    };
    add(rapid.velocity, feed.velocity, "max_velocity", "/s");
    add(rapid.acceleration, feed.acceleration, "max_acceleration", "/s^2");
    add(rapid.jerk, feed.jerk, "max_jerk", "/s^3");
    return parts.empty() ? "" : fmt::format("rapid = {{ {} }}\n", fmt::join(parts, ", "));
}

std::string axis_text(const Axis& axis) {
    const bool linear_by_letter = std::string_view("XYZUVW").find(axis.letter) != std::string_view::npos;
    std::string out =
        fmt::format("\n[axes.{}]\nrange = {}\nmax_velocity = {}\nmax_acceleration = {}\nmax_jerk = {}\n", axis.letter,
                    range_text(axis), quantity(axis.feed.velocity, axis, "/s"),
                    quantity(axis.feed.acceleration, axis, "/s^2"), quantity(axis.feed.jerk, axis, "/s^3"));
    out += rapid_text(axis);
    if (axis.rotary == linear_by_letter) out += fmt::format("type = \"{}\"\n", axis.rotary ? "rotary" : "linear");
    const auto usual = std::string_view("XAUYBVZCW").find(axis.letter);
    if (usual == std::string_view::npos || axis.direction != Eigen::Vector3d::Unit(static_cast<int>(usual / 3)))
        out += fmt::format("direction = {}\n", vector_text(axis.direction, "{}"));
    if (axis.rotary) out += fmt::format("point = {}\n", vector_text(axis.point_mm, "\"{} mm\""));
    if (axis.reversed) out += "reversed = true\n";
    return out;
}

std::string words_text(const machine::ControlWords& words) {
    std::string out;
    const auto list = [&](const char* key, const std::vector<std::string>& texts) {
        std::vector<std::string> all;
        for (const std::string& text : texts) all.push_back(quoted(text));
        if (!all.empty()) out += fmt::format("{} = [{}]\n", key, fmt::join(all, ", "));
    };
    list("tcp_on", words.tcp_on);
    list("tcp_off", words.tcp_off);
    list("ignore", words.ignore);
    list("following", words.following);
    return out.empty() ? out : "\n[words]\n" + out;
}

}  // namespace

std::string machine_text(const Machine& machine) {
    std::string chain, axes;
    for (int i = 0; i < machine.axis_count; ++i) {
        const auto place = static_cast<std::size_t>(machine.chain[static_cast<std::size_t>(i)]);
        chain += fmt::format("{}{}", i == 0 ? "" : " ", machine.axes[place].letter);
        axes += axis_text(machine.axes[static_cast<std::size_t>(i)]);
    }
    return fmt::format("name = {}\nchain = \"{}\"  # workpiece → tool\n{}{}", quoted(machine.name), chain, axes,
                       words_text(machine.words));
}

}  // namespace trunnion::files
