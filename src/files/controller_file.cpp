#include "trunnion/files/controller_file.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "trunnion/base/quantity.hpp"

#include "detail/shipped_files.hpp"
#include "detail/toml_reading.hpp"

namespace trunnion::files {

using detail::TomlReading;
using motion::ChoiceFacts;
using motion::ChoiceId;
using motion::Controller;
using motion::ControllerKind;
using motion::Parameter;
using motion::ParameterFacts;
using motion::ParameterId;
using motion::Source;

namespace {

constexpr std::string_view unlimited = "unlimited";

Source read_source(TomlReading& reading, const toml::table& table, const std::string& what) {
    const auto* node = reading.required(table, "source", what);
    if (!node) return Source::guessed;
    return static_cast<Source>(reading.choice(*node, "source of " + what, {"identified", "documented", "guessed"}));
}

void refuse_word(TomlReading& reading, const toml::node& node, const std::string& what, const std::string& word,
                 std::span<const std::string_view> words) {
    reading.refuse("FILE0113", fmt::format("{} cannot be '{}'", what, word), node,
                   fmt::format("possible: {}", fmt::join(words, ", ")));
}

void read_choice(TomlReading& reading, const toml::node& node, ChoiceId id, Controller& out) {
    const ChoiceFacts& facts = motion::facts_of(id);
    const std::string what(facts.key);
    const toml::table& table = reading.table(node, what);
    reading.allow_only(table, what, {"value", "source"});
    const auto* value = reading.required(table, "value", what);
    const Source source = read_source(reading, table, what);
    if (!value) return;
    const std::string word = reading.text(*value, what);
    const auto found = std::ranges::find(facts.words, word);
    if (reading.ok() && found == facts.words.end()) return refuse_word(reading, *value, what, word, facts.words);
    if (reading.ok()) motion::set_choice(out, id, {static_cast<int>(found - facts.words.begin()), source});
}

/// So many Hz, which are read like so many seconds.
double read_frequency(TomlReading& reading, const toml::node& node, const std::string& what) {
    constexpr std::string_view unit = "Hz";
    const auto* text = node.as_string();
    if (!text || !text->get().ends_with(unit)) return reading.quantity(node, motion::frequency, what);
    auto value = parse_quantity(text->get().substr(0, text->get().size() - unit.size()) + "s", dimension::time);
    if (value) return *value;
    value.error().text = fmt::format("{}: {}", what, value.error().text);
    reading.refuse(std::move(value.error()), node.source());
    return 0;
}

/// A quantity with its unit; counts and shares also as bare numbers.
double read_quantity(TomlReading& reading, const toml::node& node, const ParameterFacts& facts,
                     const std::string& what) {
    if (facts.dimension == motion::frequency) return read_frequency(reading, node, what);
    if (facts.dimension != dimension::ratio || !node.is_number()) return reading.quantity(node, facts.dimension, what);
    const double value = node.value<double>().value_or(0);
    if (!std::isfinite(value)) reading.refuse("FILE0105", fmt::format("{} is not a finite number", what), node);
    return value;
}

double read_number(TomlReading& reading, const toml::node& node, const ParameterFacts& facts, const std::string& what) {
    const auto* word = node.as_string();
    if (word && word->get() == unlimited && facts.may_be_unlimited) return std::numeric_limits<double>::infinity();
    return read_quantity(reading, node, facts, what);
}

void check_number(TomlReading& reading, const toml::node& node, const ParameterFacts& facts, double value,
                  const std::string& what) {
    if (!reading.ok() || (std::isinf(value) && facts.may_be_unlimited)) return;
    if (value < facts.least || value > facts.most)
        reading.refuse(
            "FILE0117", fmt::format("{} is out of what it may be", what), node,
            fmt::format("{:g} … {:g} {}", facts.least / facts.unit_value, facts.most / facts.unit_value, facts.unit));
    else if (facts.whole && value != std::floor(value))
        reading.refuse("FILE0117", fmt::format("{} is a count, not a fraction", what), node);
}

void read_parameter(TomlReading& reading, const toml::node& node, const ParameterFacts& facts, const std::string& what,
                    Parameter& parameter) {
    const toml::table& table = reading.table(node, what);
    reading.allow_only(table, what, {"value", "source", "spread"});
    const auto* value = reading.required(table, "value", what);
    parameter.source = read_source(reading, table, what);
    parameter.given = true;
    if (!value) return;
    parameter.value = read_number(reading, *value, facts, what);
    check_number(reading, *value, facts, parameter.value, what);
    parameter.spread = std::isinf(parameter.value) ? 0 : parameter.value * motion::default_spread(parameter.source);
    const auto* spread = table.get("spread");
    if (!spread) return;
    parameter.spread = read_quantity(reading, *spread, facts, "spread of " + what);
    if (reading.ok() && (parameter.spread < 0 || std::isinf(parameter.value)))
        reading.refuse("FILE0116", fmt::format("{} cannot vary by that", what), *spread,
                       "a spread is not below 0, and what is unlimited has none");
}

/// All that the choices made use has to be there, and nothing else.
void check_complete(TomlReading& reading, const toml::table& table, const Controller& controller) {
    for (std::size_t i = 0; i < motion::parameter_count; ++i) {
        const auto id = static_cast<ParameterId>(i);
        const auto key = motion::facts_of(id).key;
        if (motion::is_used(controller, id))
            reading.required(table, key, "parameters");
        else if (const auto* node = table.get(key))
            reading.refuse("FILE0116", fmt::format("{} means nothing with the choices made", key), *node,
                           "leave it out, or choose another transition or profile");
    }
}

void read_parameters(TomlReading& reading, const toml::node& node, Controller& out) {
    const toml::table& table = reading.table(node, "parameters");
    std::vector<std::string_view> keys;
    for (std::size_t i = 0; i < motion::choice_count; ++i) {
        const auto id = static_cast<ChoiceId>(i);
        if (!motion::is_used(out, id)) continue;
        keys.push_back(motion::facts_of(id).key);
        if (const auto* choice = reading.required(table, keys.back(), "parameters"))
            read_choice(reading, *choice, id, out);
    }
    for (std::size_t i = 0; i < motion::parameter_count; ++i) {
        const auto id = static_cast<ParameterId>(i);
        if (!motion::belongs_to(out.kind, id)) continue;
        const ParameterFacts& facts = motion::facts_of(id);
        keys.push_back(facts.key);
        if (const auto* parameter = table.get(facts.key))
            read_parameter(reading, *parameter, facts, std::string(facts.key), out[id]);
    }
    for (const auto& [key, value] : table)
        if (std::ranges::find(keys, key.str()) == keys.end())
            reading.refuse("FILE0104", fmt::format("parameters has no key '{}'", key.str()), value,
                           fmt::format("possible here: {}", fmt::join(keys, ", ")));
    if (reading.ok()) check_complete(reading, table, out);
}

/// [axes.X] and so on: limits that the control's own file says.
void read_axes(TomlReading& reading, const toml::node& node, Controller& out) {
    for (const auto& [key, value] : reading.table(node, "axes")) {
        if (key.str().size() != 1 || !motion::limited_letters.contains(key.str().front())) {
            reading.refuse("FILE0104", fmt::format("axes has no key '{}'", key.str()), value,
                           "possible here: X, Y, Z, A, B, C");
            return;
        }
        const char letter = key.str().front();
        const std::string what = fmt::format("axes.{}", letter);
        const toml::table& table = reading.table(value, what);
        reading.allow_only(table, what, {"max_velocity", "max_acceleration"});
        for (std::size_t i = 0; i < motion::axis_limit_count; ++i) {
            const auto& facts = motion::facts_of(static_cast<motion::AxisLimitId>(i), motion::turns(letter));
            if (const auto* limit = table.get(facts.key))
                read_parameter(reading, *limit, facts, fmt::format("{} of {}", facts.key, letter),
                               out.axis_limits[letter][i]);
        }
    }
}

void read_root(TomlReading& reading, const toml::table& root, Controller& out) {
    reading.allow_only(root, "a controller file", {"name", "description", "kind", "parameters", "axes"});
    if (const auto* name = root.get("name")) out.name = reading.text(*name, "name");
    if (const auto* text = root.get("description")) out.description = reading.text(*text, "description");
    const auto* kind = reading.required(root, "kind", "the controller");
    if (!kind) return;
    out.kind =
        static_cast<ControllerKind>(reading.choice(*kind, "kind", {"blocks", "linuxcnc", "ideal", "length-over-feed"}));
    const bool has_parameters = out.kind == ControllerKind::blocks || out.kind == ControllerKind::linuxcnc;
    const auto* parameters = root.get("parameters");
    if (has_parameters) {
        parameters = reading.required(root, "parameters", fmt::format("a controller of kind {}", to_string(out.kind)));
        if (parameters) read_parameters(reading, *parameters, out);
    } else if (parameters) {
        reading.refuse("FILE0116", fmt::format("a controller of kind {} has no parameters", to_string(out.kind)),
                       *parameters, "parameters are those of kind = \"blocks\" and \"linuxcnc\"");
    }
    const auto* axes = root.get("axes");
    if (!axes) return;
    if (out.kind == ControllerKind::linuxcnc)
        read_axes(reading, *axes, out);
    else
        reading.refuse("FILE0116", fmt::format("a controller of kind {} has no axes of its own", to_string(out.kind)),
                       *axes, "their limits are those of the machine file");
}

}  // namespace

Result<Controller> read_controller(std::string_view toml_text, std::string_view file_name) {
    const auto root = detail::parse_toml(toml_text, file_name);
    if (!root) return fail(root.error());
    Controller out;
    out.file = file_name;
    out.name = std::filesystem::path(file_name).stem().string();
    TomlReading reading(file_name);
    read_root(reading, *root, out);
    if (!reading.ok()) return fail(reading.error());
    return out;
}

Result<Controller> read_controller_file(const std::filesystem::path& path) {
    const auto text = detail::read_text(path);
    if (!text) return fail(text.error());
    return read_controller(*text, path.string());
}

std::vector<ShippedController> shipped_controllers(std::span<const std::filesystem::path> data_folders) {
    std::vector<ShippedController> out;
    for (auto& found : detail::shipped_files(data_folders))
        out.push_back({std::move(found.name), std::move(found.title), std::move(found.file)});
    return out;
}

Result<Controller> find_controller(std::string_view name_or_file, std::span<const std::filesystem::path> data_folders) {
    const auto file = detail::file_named(name_or_file, data_folders);
    if (!file.empty()) return read_controller_file(file);
    Diagnostic unknown{.code = "FILE0118", .text = fmt::format("there is no controller '{}'", name_or_file)};
    unknown.hint = detail::list_of(detail::shipped_files(data_folders));
    return fail(std::move(unknown));
}

}  // namespace trunnion::files
