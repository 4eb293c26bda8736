#include "written_program.hpp"

#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "trunnion/base/quantity.hpp"

#include "job.hpp"

namespace trunnion::app {

namespace {

constexpr std::array form_names{"dialect", "bspline", "poly", "nurbs", "points"};  ///< order of nc::CurveForm

}  // namespace

void WrittenProgram::add_to(CLI::App& command, bool dialect_needed) {
    command.add_option("-o,--output", file, "the program that is written; .gz: compressed")->required();
    CLI::Option* to = command.add_option("--to", dialect, "dialect to write")->check(CLI::IsMember(dialect_names));
    if (dialect_needed) to->required();
    command.add_option("--output-units", units, "of lengths and feeds written")
        ->check(CLI::IsMember({"mm", "inch"}))
        ->capture_default_str();
    command.add_option("--precision", precision, "largest error of a coordinate that is written")
        ->capture_default_str();
    command.add_option("--angle-precision", angle_precision, "largest error of a rotary word or tool axis")
        ->capture_default_str();
    command.add_option("--curves", curves, "as what curves are written; dialect: what it has and they fit into")
        ->check(CLI::IsMember(form_names))
        ->capture_default_str();
    command.add_flag("--block-numbers", block_numbers, "N10, N20 …");
    command.add_flag("--inverse-time", inverse_time, "feeds as G93 where the dialect has it");
}

Result<nc::WriteOptions> WrittenProgram::options() const {
    nc::WriteOptions out;
    const auto length = parse_quantity(precision, dimension::length);
    const auto angle = parse_quantity(angle_precision, dimension::angle);
    for (const auto& [value, name] : {std::pair{&length, "--precision"}, {&angle, "--angle-precision"}})
        if (!*value) {
            auto error = value->error();
            error.text = fmt::format("{}: {}", name, error.text);
            return fail(error);
        }
    if (!dialect.empty()) out.dialect = *nc::dialect_named(dialect);
    out.units = units == "inch" ? nc::Units::inch : nc::Units::mm;
    out.precision_mm = *length;
    out.precision_deg = *angle / degree;
    out.vector_precision = 0.5 * *angle;  // of three components together
    const auto form = std::ranges::find(form_names, curves) - form_names.begin();
    out.curves = static_cast<nc::CurveForm>(form);
    out.block_numbers = block_numbers;
    out.inverse_time = inverse_time;
    return out;
}

std::string WrittenProgram::precision_text() const {
    return fmt::format("written within {} and {}", precision, angle_precision);
}

}  // namespace trunnion::app
