#include "trunnion/files/machine_file.hpp"

#include <algorithm>
#include <cctype>
#include <string>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "trunnion/machine/kinematics.hpp"

#include "detail/toml_reading.hpp"

namespace trunnion::files {

using detail::TomlReading;
using machine::Axis;
using machine::AxisLimits;
using machine::Machine;

namespace {

bool is_linear_letter(char letter) {
    return std::string_view("XYZUVW").find(letter) != std::string_view::npos;
}

/// Along which of X, Y, Z a letter goes, or about which it turns, unless the file says; −1: only the file can say.
int usual_direction(char letter) {
    const auto at = std::string_view("XAUYBVZCW").find(letter);
    return at == std::string_view::npos ? -1 : static_cast<int>(at / 3);
}

double positive_limit(TomlReading& reading, const toml::node& node, Dimension wanted, const std::string& what) {
    const double value = reading.quantity(node, wanted, what);
    if (reading.ok() && !(value > 0))
        reading.refuse("FILE0106", fmt::format("{} is not above 0", what), node, "limits are magnitudes, above 0");
    return value;
}

struct LimitKey {
    const char* key;
    double AxisLimits::* limit;
    Dimension linear, rotary;
};
constexpr std::array<LimitKey, 3> limit_keys{
    {{"max_velocity", &AxisLimits::velocity, dimension::velocity, dimension::angular_velocity},
     {"max_acceleration", &AxisLimits::acceleration, dimension::acceleration, dimension::angular_acceleration},
     {"max_jerk", &AxisLimits::jerk, dimension::jerk, dimension::angular_jerk}}};

void read_limits(TomlReading& reading, const toml::table& table, const std::string& what, Axis& axis) {
    for (const LimitKey& entry : limit_keys)
        if (const auto* node = reading.required(table, entry.key, what))
            axis.feed.*entry.limit = positive_limit(reading, *node, axis.rotary ? entry.rotary : entry.linear,
                                                    fmt::format("{} of {}", entry.key, what));
    axis.rapid = axis.feed;
    const auto* node = table.get("rapid");
    if (!node) return;
    const std::string rapid_of = "rapid of " + what;
    const toml::table& rapid = reading.table(*node, rapid_of);
    reading.allow_only(rapid, rapid_of, {"max_velocity", "max_acceleration", "max_jerk"});
    for (const LimitKey& entry : limit_keys)
        if (const auto* limit = rapid.get(entry.key))
            axis.rapid.*entry.limit = positive_limit(reading, *limit, axis.rotary ? entry.rotary : entry.linear,
                                                     fmt::format("{} in {}", entry.key, rapid_of));
}

void read_range(TomlReading& reading, const toml::table& table, const std::string& what, Axis& axis) {
    const auto* node = reading.required(table, "range", what);
    if (!node) return;
    const std::string range_of = "range of " + what;
    if (node->is_string()) {
        reading.choice(*node, range_of, {"endless"});
        return;
    }
    const auto ends = reading.quantities(*node, 2, axis.rotary ? dimension::angle : dimension::length, range_of);
    if (reading.ok() && !(ends[0] < ends[1]))
        reading.refuse("FILE0108", fmt::format("{} ends before it begins, or is empty", range_of), *node,
                       "write the lower end first");
    axis.range_min = ends[0];
    axis.range_max = ends[1];
}

void read_direction(TomlReading& reading, const toml::table& table, const std::string& what, Axis& axis) {
    if (const auto* node = table.get("direction")) {
        axis.direction = reading.direction(*node, "direction of " + what);
        return;
    }
    const int usual = usual_direction(axis.letter);
    if (usual < 0) reading.required(table, "direction", what);
    axis.direction = Eigen::Vector3d::Unit(std::max(usual, 0));
}

Axis read_axis(TomlReading& reading, char letter, const toml::node& node) {
    Axis axis;
    axis.letter = letter;
    const std::string what = fmt::format("axis {}", letter);
    const toml::table& table = reading.table(node, what);
    const auto* type = table.get("type");
    axis.rotary =
        type ? reading.choice(*type, "type of " + what, {"linear", "rotary"}) == 1 : !is_linear_letter(letter);
    if (axis.rotary)
        reading.allow_only(table, what,
                           {"range", "max_velocity", "max_acceleration", "max_jerk", "rapid", "type", "direction",
                            "reversed", "point"});
    else
        reading.allow_only(
            table, what,
            {"range", "max_velocity", "max_acceleration", "max_jerk", "rapid", "type", "direction", "reversed"});
    read_limits(reading, table, what, axis);
    read_range(reading, table, what, axis);
    read_direction(reading, table, what, axis);
    if (const auto* point = table.get("point")) axis.point_mm = reading.lengths_mm(*point, "point of " + what);
    if (const auto* reversed = table.get("reversed")) axis.reversed = reading.flag(*reversed, "reversed of " + what);
    return axis;
}

/// The letters of the chain, each a single capital and there once.
std::string read_chain(TomlReading& reading, const toml::node& node) {
    const std::string written = reading.text(node, "chain");
    std::string letters;
    for (std::size_t i = 0; i < written.size(); ++i) {
        const char c = written[i];
        if (c == ' ' || c == '\t') continue;
        const bool alone = i + 1 == written.size() || written[i + 1] == ' ' || written[i + 1] == '\t';
        if (c < 'A' || c > 'Z' || !alone)
            reading.refuse("FILE0107", fmt::format("the chain '{}' is not a list of capital letters", written), node,
                           "write it like \"C A X Y Z\"");
        if (letters.find(c) != std::string::npos)
            reading.refuse("FILE0107", fmt::format("axis {} stands in the chain twice", c), node);
        letters += c;
    }
    if (letters.empty()) reading.refuse("FILE0107", "the chain is empty", node, "write it like \"C A X Y Z\"");
    return letters;
}

/// Axes in the order of AxisVector.
std::vector<Axis> read_axes(TomlReading& reading, const std::string& chain, const toml::table& tables) {
    std::vector<Axis> axes;
    for (const auto& [key, node] : tables) {
        if (key.str().size() == 1 && chain.find(key.str()[0]) != std::string::npos) {
            axes.push_back(read_axis(reading, key.str()[0], node));
            continue;
        }
        Diagnostic stray{.code = "FILE0107", .text = fmt::format("axis {} is not in the chain", key.str())};
        stray.hint = fmt::format("the chain has {}", fmt::join(chain, " "));
        reading.refuse(std::move(stray), key.source());
    }
    for (const char letter : chain)
        if (std::ranges::find(axes, letter, &Axis::letter) == axes.end())
            reading.refuse("FILE0107", fmt::format("axis {} of the chain is not described", letter), tables,
                           fmt::format("add [axes.{}]", letter));
    std::ranges::sort(axes, {}, [](const Axis& axis) { return std::pair(axis.rotary, axis.letter); });
    return axes;
}

void place_axes(TomlReading& reading, const std::vector<Axis>& axes, const std::string& chain, const toml::node& where,
                Machine& machine) {
    const auto rotary = std::ranges::count(axes, true, &Axis::rotary);
    const auto linear = std::ssize(axes) - rotary;
    if (linear != 3)
        reading.refuse("FILE0110", fmt::format("the chain has {} linear axes, exactly three are needed", linear),
                       where);
    if (rotary > machine::max_rotary_axes)
        reading.refuse("FILE0111", fmt::format("the chain has {} rotary axes, at most two are possible", rotary),
                       where);
    if (!reading.ok()) return;
    std::ranges::copy(axes, machine.axes.begin());
    machine.axis_count = static_cast<int>(axes.size());
    machine.rotary_count = static_cast<int>(rotary);
    for (std::size_t i = 0; i < chain.size(); ++i)
        machine.chain[i] = static_cast<std::int8_t>(machine.index_of(chain[i]));
}

void read_words(TomlReading& reading, const toml::node& node, machine::ControlWords& words) {
    const toml::table& table = reading.table(node, "words");
    reading.allow_only(table, "words", {"tcp_on", "tcp_off", "ignore", "following"});
    const auto list = [&](const char* key) {
        const auto* found = table.get(key);
        return found ? reading.texts(*found, fmt::format("words.{}", key)) : std::vector<std::string>{};
    };
    words = {list("tcp_on"), list("tcp_off"), list("ignore"), list("following")};
}

void read_root(TomlReading& reading, const toml::table& root, Machine& machine) {
    reading.allow_only(root, "a machine file", {"name", "chain", "axes", "words"});
    if (const auto* name = root.get("name")) machine.name = reading.text(*name, "name");
    const auto* chain_node = reading.required(root, "chain", "the machine");
    const auto* axes_node = reading.required(root, "axes", "the machine");
    if (const auto* words = root.get("words")) read_words(reading, *words, machine.words);
    if (!reading.ok()) return;
    const std::string chain = read_chain(reading, *chain_node);
    const auto axes = read_axes(reading, chain, reading.table(*axes_node, "axes"));
    if (reading.ok()) place_axes(reading, axes, chain, *chain_node, machine);
}

}  // namespace

Result<Machine> read_machine(std::string_view toml_text, std::string_view file_name) {
    const auto root = detail::parse_toml(toml_text, file_name);
    if (!root) return fail(root.error());
    Machine out;
    out.file = file_name;
    out.name = std::filesystem::path(file_name).stem().string();
    TomlReading reading(file_name);
    read_root(reading, *root, out);
    if (!reading.ok()) return fail(reading.error());
    if (auto solved = machine::Kinematics::make(out, {}, 0); !solved) return fail(solved.error());
    return out;
}

Result<Machine> read_machine_file(const std::filesystem::path& path) {
    const auto text = detail::read_text(path);
    if (!text) return fail(text.error());
    return read_machine(*text, path.string());
}

}  // namespace trunnion::files
