#include "trunnion/files/setup_file.hpp"

#include <string>

#include <fmt/format.h>

#include "trunnion/geometry/rotation.hpp"

#include "detail/toml_reading.hpp"

namespace trunnion::files {

using detail::TomlReading;
using machine::Frame;
using machine::Setup;
using machine::Tool;
using machine::ToolKind;

namespace {

Eigen::Matrix3d read_rotation(TomlReading& reading, const toml::node& node, const std::string& what) {
    const toml::table& table = reading.table(node, what);
    reading.allow_only(table, what, {"axis", "angle"});
    const auto* axis = reading.required(table, "axis", what);
    const auto* angle = reading.required(table, "angle", what);
    if (!axis || !angle) return Eigen::Matrix3d::Identity();
    const Eigen::Vector3d direction = reading.direction(*axis, "axis of " + what);
    return geometry::rotation_about(direction, reading.quantity(*angle, dimension::angle, "angle of " + what));
}

Frame read_frame(TomlReading& reading, const toml::node& node, const std::string& what) {
    const toml::table& table = reading.table(node, what);
    reading.allow_only(table, what, {"origin", "rotation"});
    Frame out;
    if (const auto* origin = table.get("origin")) out.origin_mm = reading.lengths_mm(*origin, "origin of " + what);
    if (const auto* rotation = table.get("rotation"))
        out.rotation = read_rotation(reading, *rotation, "rotation of " + what);
    return out;
}

/// A length that is not below 0; `otherwise` when the key is absent.
double read_size(TomlReading& reading, const toml::table& table, const char* key, const std::string& what,
                 double otherwise) {
    const auto* node = table.get(key);
    if (!node) return otherwise;
    const double size = reading.quantity(*node, dimension::length, fmt::format("{} of {}", key, what));
    if (reading.ok() && size < 0) reading.refuse("FILE0114", fmt::format("{} of {} is below 0", key, what), *node);
    return size;
}

void check_tool(TomlReading& reading, const Tool& tool, const std::string& what, const toml::node& where) {
    const double radius = tool.diameter_mm / 2, corner = tool.corner_radius_mm, equal = 1e-9;
    const auto contradict = [&](const char* text) {
        reading.refuse("FILE0114", fmt::format("{}: {}", what, text), where);
    };
    const bool round = tool.kind == ToolKind::ball || tool.kind == ToolKind::torus;
    if (round && !(tool.diameter_mm > 0)) contradict("a ball or torus needs a diameter above 0");
    if (tool.kind == ToolKind::flat && corner > 0) contradict("a flat tool has no corner radius; a torus has");
    if (tool.kind == ToolKind::ball && std::abs(corner - radius) > equal)
        contradict("the corner radius of a ball is half its diameter");
    if (tool.kind == ToolKind::torus && !(corner > 0 && corner <= radius + equal))
        contradict("the corner radius of a torus is above 0 and at most half its diameter");
    if (tool.controls_centre && !round) contradict("only a ball or torus has a centre to control");
}

Tool read_tool(TomlReading& reading, const toml::node& node, const std::string& what) {
    const toml::table& table = reading.table(node, what);
    reading.allow_only(table, what, {"kind", "diameter", "corner_radius", "length", "controlled_point"});
    Tool out;
    if (const auto* kind = table.get("kind"))
        out.kind = static_cast<ToolKind>(reading.choice(*kind, "kind of " + what, {"flat", "ball", "torus", "taper"}));
    out.diameter_mm = read_size(reading, table, "diameter", what, 0);
    out.corner_radius_mm =
        read_size(reading, table, "corner_radius", what, out.kind == ToolKind::ball ? out.diameter_mm / 2 : 0);
    out.length_mm = read_size(reading, table, "length", what, 0);
    if (const auto* point = table.get("controlled_point"))
        out.controls_centre = reading.choice(*point, "controlled_point of " + what, {"tip", "centre"}) == 1;
    check_tool(reading, out, what, table);
    return out;
}

/// Keys that no program can call would never be found: numbers with leading zeros (T08 calls 8), edge 1 (it is the tool
/// itself) and D0 (no tool: length 0).
void check_tool_name(TomlReading& reading, std::string_view name, const toml::node& where) {
    const bool number = name.find_first_not_of("0123456789") == name.npos;
    if (!name.empty() && name.front() != ' ' && name.back() != ' ' && !(number && name.size() > 1 && name[0] == '0') &&
        !name.ends_with(" D0") && !name.ends_with(" D1"))
        return;
    reading.refuse("FILE0115", fmt::format("no program calls a tool '{}'", name), where,
                   "write [tools.8] or [tools.NAME], further cutting edges as [tools.\"8 D2\"]");
}

/// mm or rad: a letter that may be either kind of axis takes what its unit says.
double read_coordinate(TomlReading& reading, char letter, const toml::node& node, const std::string& what) {
    const bool surely_rotary = std::string_view("ABC").find(letter) != std::string_view::npos;
    const bool surely_linear = std::string_view("XYZ").find(letter) != std::string_view::npos;
    const auto* written = node.as_string();
    const bool angle = surely_rotary || (!surely_linear && written && parse_quantity(written->get(), dimension::angle));
    return reading.quantity(node, angle ? dimension::angle : dimension::length, what);
}

std::map<char, double> read_position(TomlReading& reading, const toml::node& node, const std::string& what) {
    std::map<char, double> out;
    for (const auto& [key, value] : reading.table(node, what)) {
        const auto name = key.str();
        if (name.size() == 1 && name[0] >= 'A' && name[0] <= 'Z') {
            out[name[0]] = read_coordinate(reading, name[0], value, fmt::format("{} of {}", name, what));
            continue;
        }
        Diagnostic stray{.code = "FILE0104", .text = fmt::format("{} has no key '{}'", what, name)};
        stray.hint = "its keys are axis letters";
        reading.refuse(std::move(stray), key.source());
    }
    return out;
}

void read_root(TomlReading& reading, const toml::table& root, Setup& setup) {
    reading.allow_only(root, "a setup file", {"workpiece", "tool", "tools", "offsets", "start", "home"});
    if (const auto* node = root.get("workpiece")) setup.workpiece = read_frame(reading, *node, "workpiece");
    if (const auto* node = root.get("tool")) setup.tool = read_tool(reading, *node, "tool");
    if (const auto* node = root.get("tools"))
        for (const auto& [key, tool] : reading.table(*node, "tools")) {
            check_tool_name(reading, key.str(), tool);
            setup.tools[std::string(key.str())] = read_tool(reading, tool, fmt::format("tool {}", key.str()));
        }
    if (const auto* node = root.get("offsets"))
        for (const auto& [key, frame] : reading.table(*node, "offsets"))
            setup.offsets[std::string(key.str())] = read_frame(reading, frame, fmt::format("offset {}", key.str()));
    if (const auto* node = root.get("start")) setup.start = read_position(reading, *node, "start");
    if (const auto* node = root.get("home")) setup.home = read_position(reading, *node, "home");
}

}  // namespace

Result<Setup> read_setup(std::string_view toml_text, std::string_view file_name) {
    const auto root = detail::parse_toml(toml_text, file_name);
    if (!root) return fail(root.error());
    Setup out;
    out.file = file_name;
    TomlReading reading(file_name);
    read_root(reading, *root, out);
    if (!reading.ok()) return fail(reading.error());
    return out;
}

Result<Setup> read_setup_file(const std::filesystem::path& path) {
    const auto text = detail::read_text(path);
    if (!text) return fail(text.error());
    return read_setup(*text, path.string());
}

}  // namespace trunnion::files
