#include "trunnion/files/surface_file.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "detail/toml_reading.hpp"

namespace trunnion::files {

using detail::TomlReading;
using Eigen::Vector3d;
using geometry::BsplineSurface;
using geometry::SurfaceDirection;

namespace {

constexpr int usual_degree = 3;

/// Rows of equal length, one after the other.
template <class Value>
struct Net {
    std::vector<Value> values;
    std::size_t rows = 0, columns = 0;
};

const toml::array* list_of(TomlReading& reading, const toml::node& node, std::string_view what) {
    const auto* array = node.as_array();
    if (array && !array->empty()) return array;
    reading.refuse("FILE0105", fmt::format("{} is not a list with something in it", what), node);
    return nullptr;
}

double number_of(TomlReading& reading, const toml::node& node, std::string_view what) {
    const auto number = node.is_number() ? node.value<double>() : std::nullopt;
    if (!number || !std::isfinite(*number))
        reading.refuse("FILE0105", fmt::format("{} holds something else than finite numbers", what), node,
                       "plain numbers without a unit: the key says it");
    return number.value_or(0);
}

std::vector<double> numbers_of(TomlReading& reading, const toml::node& node, std::string_view what) {
    std::vector<double> out;
    if (const auto* array = list_of(reading, node, what))
        for (const auto& element : *array) out.push_back(number_of(reading, element, what));
    return out;
}

Vector3d point_of(TomlReading& reading, const toml::node& node, std::string_view what) {
    const auto numbers = numbers_of(reading, node, what);
    if (numbers.size() == 3) return {numbers[0], numbers[1], numbers[2]};
    reading.refuse("FILE0105", fmt::format("{}: a point has three coordinates", what), node);
    return Vector3d::Zero();
}

/// Each row's values by `read`.
template <class Value, class Read>
Net<Value> net_of(TomlReading& reading, const toml::node& node, std::string_view what, Read read) {
    Net<Value> out;
    const auto* rows = list_of(reading, node, what);
    for (std::size_t i = 0; rows && i < rows->size(); ++i) {
        const auto* row = list_of(reading, (*rows)[i], fmt::format("row {} of {}", i + 1, what));
        if (!row) return out;
        if (i == 0) out.columns = row->size();
        if (row->size() != out.columns)
            reading.refuse(
                "FILE0105",
                fmt::format("row {} of {} has {} places, the first has {}", i + 1, what, row->size(), out.columns),
                (*rows)[i]);
        for (const auto& element : *row) out.values.push_back(read(reading, element, what));
        ++out.rows;
    }
    return out;
}

std::vector<double> uniform_knots(std::size_t points, int degree) {
    const std::size_t order = static_cast<std::size_t>(degree) + 1, pieces = points - order + 1;
    std::vector<double> out(order, 0.0);
    for (std::size_t k = 1; k < pieces; ++k) out.push_back(static_cast<double>(k) / static_cast<double>(pieces));
    out.insert(out.end(), order, 1.0);
    return out;
}

/// One direction of a net; `index`: 0 of u, 1 of v.
SurfaceDirection direction_of(TomlReading& reading, const toml::table& table, std::size_t points, std::size_t index) {
    SurfaceDirection out{.degree = static_cast<int>(std::min<std::size_t>(usual_degree, points - 1)), .knots = {}};
    if (const auto* degrees = table.get("degree")) {
        const auto* both = degrees->as_array();
        const auto given = both && both->size() == 2 ? (*both)[index].value_exact<std::int64_t>() : std::nullopt;
        if (!given) reading.refuse("FILE0105", "degree is not two whole numbers", *degrees, "write it like [3, 3]");
        out.degree = static_cast<int>(std::clamp<std::int64_t>(given.value_or(0), -1, 99));
    }
    if (const auto* knots = table.get(index == 0 ? "knots_u" : "knots_v"))
        out.knots = numbers_of(reading, *knots, index == 0 ? "knots_u" : "knots_v");
    else if (out.degree >= 1 && points > static_cast<std::size_t>(out.degree))
        out.knots = uniform_knots(points, out.degree);
    return out;
}

Result<BsplineSurface> net_surface(TomlReading& reading, const toml::table& table, const toml::node& points) {
    auto net = net_of<Vector3d>(reading, points, "control_points_mm", point_of);
    Net<double> weights;
    if (const auto* given = table.get("weights")) weights = net_of<double>(reading, *given, "weights", number_of);
    if (!reading.ok()) return fail(reading.error());
    auto u = direction_of(reading, table, net.rows, 0), v = direction_of(reading, table, net.columns, 1);
    return BsplineSurface::make(std::move(u), std::move(v), std::move(net.values), std::move(weights.values));
}

Result<BsplineSurface> coefficient_surface(TomlReading& reading, const toml::table& table,
                                           const toml::node& coefficients) {
    reading.allow_only(table, "a surface by coefficients", {"side", "coefficients_mm"});
    const auto net = net_of<Vector3d>(reading, coefficients, "coefficients_mm", point_of);
    if (!reading.ok()) return fail(reading.error());
    return geometry::polynomial_surface(static_cast<int>(net.rows) - 1, static_cast<int>(net.columns) - 1, net.values);
}

std::optional<DescribedSurface> read_surface(TomlReading& reading, const toml::node& node) {
    const toml::table& table = reading.table(node, "surface");
    reading.allow_only(table, "a surface",
                       {"side", "coefficients_mm", "control_points_mm", "degree", "knots_u", "knots_v", "weights"});
    geometry::Side side = geometry::Side::along;
    if (const auto* given = table.get("side"))
        side = static_cast<geometry::Side>(reading.choice(*given, "side of a surface", {"along", "against"}));
    const auto *coefficients = table.get("coefficients_mm"), *points = table.get("control_points_mm");
    if (!coefficients == !points)
        reading.refuse("FILE0103", "a surface has either coefficients_mm or control_points_mm", table);
    if (!reading.ok()) return std::nullopt;
    auto surface =
        coefficients ? coefficient_surface(reading, table, *coefficients) : net_surface(reading, table, *points);
    if (!surface) {
        reading.refuse(surface.error(), table.source());
        return std::nullopt;
    }
    return DescribedSurface{std::move(*surface), side};
}

Diagnostic without_surface(std::string_view file_name) {
    return {.code = "FILE0119",
            .text = "no surface is in the file",
            .place = {.file = std::string(file_name)},
            .hint = "each begins with a line [[surface]]"};
}

}  // namespace

Result<std::vector<DescribedSurface>> read_surfaces(std::string_view toml_text, std::string_view file_name) {
    const auto root = detail::parse_toml(toml_text, file_name);
    if (!root) return fail(root.error());
    TomlReading reading(file_name);
    reading.allow_only(*root, "a surface file", {"surface"});
    std::vector<DescribedSurface> out;
    if (const auto* node = root->get("surface")) {
        const auto* tables = list_of(reading, *node, "surface");
        for (std::size_t i = 0; tables && i < tables->size(); ++i)
            if (auto surface = read_surface(reading, (*tables)[i])) out.push_back(std::move(*surface));
    }
    if (!reading.ok()) return fail(reading.error());
    if (out.empty()) return fail(without_surface(file_name));
    return out;
}

Result<std::vector<DescribedSurface>> read_surface_file(const std::filesystem::path& path) {
    const auto text = detail::read_text(path);
    if (!text) return fail(text.error());
    return read_surfaces(*text, path.string());
}

}  // namespace trunnion::files
