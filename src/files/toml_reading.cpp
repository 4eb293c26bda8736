#include "detail/toml_reading.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace trunnion::files::detail {

Result<std::string> read_text(const std::filesystem::path& path) {
    Diagnostic unreadable{.code = "FILE0101", .text = "the file cannot be read", .place = {.file = path.string()}};
    std::error_code error;
    if (!std::filesystem::exists(path, error)) unreadable.text = "there is no such file";
    if (!std::filesystem::is_regular_file(path, error)) return fail(std::move(unreadable));
    std::ifstream stream(path, std::ios::binary);
    std::string text{std::istreambuf_iterator<char>(stream), {}};
    if (!stream.is_open() || stream.bad()) return fail(std::move(unreadable));
    return text;
}

Result<toml::table> parse_toml(std::string_view text, std::string_view file_name) try {
    return toml::parse(text);
} catch (const toml::parse_error& error) {
    Diagnostic refusal{.code = "FILE0102", .text = std::string(error.description())};
    refusal.place.file = file_name;
    refusal.place.line = static_cast<int>(error.source().begin.line);
    refusal.place.column = static_cast<int>(error.source().begin.column);
    refusal.hint = "from here on the file is not TOML";
    return fail(std::move(refusal));
}

void TomlReading::refuse(Diagnostic diagnostic, const toml::source_region& where) {
    if (error_) return;
    diagnostic.place.file = file_name_;
    diagnostic.place.line = static_cast<int>(where.begin.line);
    diagnostic.place.column = static_cast<int>(where.begin.column);
    error_ = std::move(diagnostic);
}

void TomlReading::refuse(std::string code, std::string text, const toml::node& where, std::string hint) {
    Diagnostic diagnostic{.code = std::move(code), .text = std::move(text)};
    diagnostic.hint = std::move(hint);
    refuse(std::move(diagnostic), where.source());
}

void TomlReading::allow_only(const toml::table& table, std::string_view what,
                             std::initializer_list<std::string_view> keys) {
    for (const auto& [key, value] : table) {
        if (std::ranges::find(keys, key.str()) != keys.end()) continue;
        Diagnostic unknown{.code = "FILE0104", .text = fmt::format("{} has no key '{}'", what, key.str())};
        unknown.hint = fmt::format("possible here: {}", fmt::join(keys, ", "));
        return refuse(std::move(unknown), key.source());
    }
}

const toml::node* TomlReading::required(const toml::table& table, std::string_view key, std::string_view what) {
    const toml::node* node = table.get(key);
    if (!node) refuse("FILE0103", fmt::format("{} has no {}", what, key), table, fmt::format("add {} = …", key));
    return node;
}

const toml::table& TomlReading::table(const toml::node& node, std::string_view what) {
    static const toml::table empty;
    if (const auto* found = node.as_table()) return *found;
    refuse("FILE0105", fmt::format("{} is not a table", what), node);
    return empty;
}

std::string TomlReading::text(const toml::node& node, std::string_view what) {
    if (const auto* found = node.as_string()) return found->get();
    refuse("FILE0105", fmt::format("{} is not a text", what), node, "write it in quotes");
    return {};
}

bool TomlReading::flag(const toml::node& node, std::string_view what) {
    if (const auto* found = node.as_boolean()) return found->get();
    refuse("FILE0105", fmt::format("{} is neither true nor false", what), node);
    return false;
}

std::vector<std::string> TomlReading::texts(const toml::node& node, std::string_view what) {
    std::vector<std::string> out;
    if (const auto* array = node.as_array())
        for (const auto& element : *array) out.push_back(text(element, what));
    else
        refuse("FILE0105", fmt::format("{} is not a list", what), node, "write it like [\"M64\", \"M65\"]");
    return out;
}

int TomlReading::choice(const toml::node& node, std::string_view what, std::initializer_list<std::string_view> words) {
    const std::string word = text(node, what);
    const auto found = std::ranges::find(words, word);
    if (found != words.end()) return static_cast<int>(found - words.begin());
    refuse("FILE0113", fmt::format("{} cannot be '{}'", what, word), node,
           fmt::format("possible: {}", fmt::join(words, ", ")));
    return 0;
}

double TomlReading::quantity(const toml::node& node, Dimension wanted, std::string_view what) {
    if (!node.is_string() && !node.is_number()) {
        refuse("FILE0105", fmt::format("{} is not a number with a unit", what), node);
        return 0;
    }
    const std::string written =
        node.is_string() ? node.as_string()->get() : fmt::format("{}", node.value<double>().value_or(0));
    auto read = parse_quantity(written, wanted);
    if (read) return *read;
    Diagnostic refusal = std::move(read.error());
    refusal.text = fmt::format("{}: {}", what, refusal.text);
    refuse(std::move(refusal), node.source());
    return 0;
}

const toml::array* TomlReading::array_of(const toml::node& node, std::size_t count, std::string_view what) {
    const auto* array = node.as_array();
    if (array && array->size() == count) return array;
    refuse("FILE0105", fmt::format("{} is not a list of {}", what, count), node);
    return nullptr;
}

std::vector<double> TomlReading::quantities(const toml::node& node, std::size_t count, Dimension wanted,
                                            std::string_view what) {
    std::vector<double> out(count, 0.0);
    if (const auto* array = array_of(node, count, what))
        for (std::size_t i = 0; i < count; ++i) out[i] = quantity((*array)[i], wanted, what);
    return out;
}

Eigen::Vector3d TomlReading::lengths_mm(const toml::node& node, std::string_view what) {
    const auto values = quantities(node, 3, dimension::length, what);
    return {values[0], values[1], values[2]};
}

Eigen::Vector3d TomlReading::direction(const toml::node& node, std::string_view what) {
    Eigen::Vector3d out = Eigen::Vector3d::Zero();
    if (const auto* array = array_of(node, 3, what))
        for (std::size_t i = 0; i < 3; ++i) {
            const auto number = (*array)[i].value<double>();
            if (!number || !std::isfinite(*number))
                refuse("FILE0105", fmt::format("{} holds something else than numbers", what), node);
            out[static_cast<Eigen::Index>(i)] = number.value_or(0);
        }
    const double length = out.stableNorm();
    if (ok() && !(length > 0)) refuse("FILE0109", fmt::format("{} has length 0", what), node);
    return ok() ? Eigen::Vector3d(out / length) : Eigen::Vector3d::UnitX();
}

}  // namespace trunnion::files::detail
