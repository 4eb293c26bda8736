#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "trunnion/base/result.hpp"
#include "trunnion/machine/machine.hpp"
#include "trunnion/motion/setpoint.hpp"

namespace trunnion::verify {

/// Setpoints exactly one period apart. At least one row; period_s > 0 with two or more, else 0.
struct SetpointTable {
    std::vector<motion::Setpoint> rows;
    double period_s = 0;
};

/// Rows are one period apart to this share of the period.
inline constexpr double period_jitter_share = 1e-5;

/// Takes rows as they are, after a look at their times. `file` is only for diagnostics.
/// Errors: VER0201 no rows, VER0206 times not rising in equal steps (place: the first row that is off; as text row i is
/// line i + 2).
Result<SetpointTable> setpoint_table(std::vector<motion::Setpoint> rows, const std::string& file = {});

/// Reads the setpoint CSV of the whole text in memory. Columns are found by name: `t_s`, one for every axis of the
/// machine (`X_mm`, `A_deg`), and where they are present `line`, `s_mm`, `feed_mm_min`; others are passed over.
/// Errors, with the line: VER0201 no rows, VER0202 missing column, VER0203 not a number, VER0204 ragged row, VER0205 a
/// column twice, VER0206 not equidistant.
/// Cost: about 0.5 µs a row of nine columns.
Result<SetpointTable> read_setpoint_csv(std::string_view text, const machine::Machine& machine,
                                        const std::string& file = {});

}  // namespace trunnion::verify
