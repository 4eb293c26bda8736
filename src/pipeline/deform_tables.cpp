#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <string_view>

#include <fmt/format.h>

#include "trunnion/base/number.hpp"
#include "trunnion/files/output_file.hpp"
#include "trunnion/pipeline/deform.hpp"

namespace trunnion::pipeline {

namespace {

constexpr std::size_t columns = 4;
using Row = std::array<double, columns>;

Diagnostic not_a_table(const std::filesystem::path& file, int line, std::string_view header) {
    return {.code = "PIPE0023",
            .text = "not a table of numbers as it is wanted here",
            .place = {.file = file.string(), .line = line},
            .hint = fmt::format("first line: {}; then four numbers a line", header)};
}

std::optional<Row> row_of(std::string_view line) {
    Row out{};
    for (std::size_t k = 0; k < columns; ++k) {
        const auto value = take_number(line, Exponent::allowed);
        if (!value) return {};
        out[k] = *value;
        if (k + 1 == columns) break;
        if (!line.starts_with(',')) return {};
        line.remove_prefix(1);
    }
    return line.empty() ? std::optional(out) : std::nullopt;
}

Result<std::vector<Row>> read_rows(const std::filesystem::path& file, std::string_view header) {
    const auto text = files::read_whole_file(file);
    if (!text) return fail(text.error());
    std::vector<Row> out;
    std::string_view rest = *text;
    for (int line = 1; !rest.empty(); ++line) {
        std::string_view here = rest.substr(0, rest.find('\n'));
        rest.remove_prefix(std::min(rest.size(), here.size() + 1));
        if (here.ends_with('\r')) here.remove_suffix(1);
        if (line == 1 && here != header) return fail(not_a_table(file, line, header));
        if (line == 1 || here.empty()) continue;
        const auto row = row_of(here);
        if (!row) return fail(not_a_table(file, line, header));
        out.push_back(*row);
    }
    if (out.empty()) return fail(not_a_table(file, 1, header));
    return out;
}

}  // namespace

Result<std::vector<std::vector<Eigen::Vector3d>>> read_guide_curves(const std::filesystem::path& file) {
    constexpr std::string_view header = "row,x_mm,y_mm,z_mm";
    const auto rows = read_rows(file, header);
    if (!rows) return fail(rows.error());
    std::vector<std::vector<Eigen::Vector3d>> out;
    int line = 1;
    for (const auto& [row, x, y, z] : *rows) {
        ++line;
        if (row == static_cast<double>(out.size())) out.emplace_back();
        if (out.empty() || row != static_cast<double>(out.size() - 1)) return fail(not_a_table(file, line, header));
        out.back().emplace_back(x, y, z);
    }
    return out;
}

Result<std::vector<deformation::DeflectionSample>> read_deflections(const std::filesystem::path& file) {
    const auto rows = read_rows(file, "s_mm,x_mm,y_mm,z_mm");
    if (!rows) return fail(rows.error());
    std::vector<deformation::DeflectionSample> out;
    for (const auto& [s, x, y, z] : *rows) out.push_back({s, {x, y, z}});
    return out;
}

}  // namespace trunnion::pipeline
