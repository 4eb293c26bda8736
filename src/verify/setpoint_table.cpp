#include "trunnion/verify/setpoint_table.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include <fmt/format.h>

#include "trunnion/base/quantity.hpp"

#include "detail/csv_rows.hpp"
#include "detail/fault.hpp"

namespace trunnion::verify {

namespace {

using motion::Setpoint;

/// Where the fields of a setpoint are.
struct Columns {
    std::size_t time = 0;
    std::array<std::size_t, machine::max_axes> axis{};
    std::optional<std::size_t> line, way, feed;
};

Result<Columns> find_columns(const CsvRows& csv, const machine::Machine& machine) {
    Columns out;
    const auto time = csv.require("t_s");
    if (!time) return fail(time.error());
    out.time = *time;
    for (int i = 0; i < machine.axis_count; ++i) {
        const auto& axis = machine.axes[i];
        const auto column = csv.require(fmt::format("{}_{}", axis.letter, axis.rotary ? "deg" : "mm"));
        if (!column) return fail(column.error());
        out.axis[i] = *column;
    }
    out.line = csv.find("line");
    out.way = csv.find("s_mm");
    out.feed = csv.find("feed_mm_min");
    return out;
}

/// Reads one row; the first field that is no number is kept as the error.
class RowReader {
  public:
    explicit RowReader(const CsvRows& csv) : csv_(csv) {}
    double number(std::size_t column) {
        const auto value = csv_.number(column);
        if (!value && !error_) error_ = value.error();
        return value.value_or(0);
    }
    double number(std::optional<std::size_t> column) { return column ? number(*column) : 0.0; }
    const std::optional<Diagnostic>& error() const { return error_; }

  private:
    const CsvRows& csv_;
    std::optional<Diagnostic> error_;
};

Result<Setpoint> read_row(const CsvRows& csv, const Columns& columns, const machine::Machine& machine) {
    RowReader row(csv);
    Setpoint out;
    out.time_s = row.number(columns.time);
    for (int i = 0; i < machine.axis_count; ++i)
        out.position[i] = row.number(columns.axis[i]) * (machine.axes[i].rotary ? degree : 1.0);
    const double line = row.number(columns.line);
    out.path_length_mm = row.number(columns.way);
    out.feed_mm_s = row.number(columns.feed) / 60;
    if (row.error()) return fail(*row.error());
    if (!(line >= 0 && line <= 2e9 && line == std::floor(line)))
        return fail(csv.diagnose("VER0203", "column line has no line number", fmt::format("{}", line)));
    out.line = static_cast<std::int32_t>(line);
    return out;
}

}  // namespace

Result<SetpointTable> setpoint_table(std::vector<Setpoint> rows, const std::string& file) {
    if (rows.empty()) return fail(fault_at(0, "VER0201", "the table has no setpoints", file));
    SetpointTable table{.rows = std::move(rows), .period_s = 0};
    const auto& r = table.rows;
    if (r.size() == 1) return table;
    table.period_s = (r.back().time_s - r.front().time_s) / static_cast<double>(r.size() - 1);
    const auto off = std::adjacent_find(r.begin(), r.end(), [&](const Setpoint& a, const Setpoint& b) {
        return !(std::abs(b.time_s - a.time_s - table.period_s) <= period_jitter_share * table.period_s);
    });
    if (off == r.end() && table.period_s > 0) return table;
    const auto first = off == r.end() ? r.begin() : off;
    const int line = static_cast<int>(first - r.begin()) + 3;
    auto fault = fault_at(line, "VER0206", "the setpoints are not one period apart", file);
    fault.value = fmt::format("{} s", (first + 1)->time_s - first->time_s);
    fault.limit = fmt::format("{} s", table.period_s);
    fault.hint = "every row is one period after the row before, as `plan` writes them";
    return fail(std::move(fault));
}

Result<SetpointTable> read_setpoint_csv(std::string_view text, const machine::Machine& machine,
                                        const std::string& file) {
    auto csv = CsvRows::open(text, file);
    if (!csv) return fail(csv.error());
    const auto columns = find_columns(*csv, machine);
    if (!columns) return fail(columns.error());
    std::vector<Setpoint> rows;
    for (;;) {
        const auto more = csv->next();
        if (!more) return fail(more.error());
        if (!*more) break;
        const auto row = read_row(*csv, *columns, machine);
        if (!row) return fail(row.error());
        rows.push_back(*row);
    }
    return setpoint_table(std::move(rows), file);
}

}  // namespace trunnion::verify
