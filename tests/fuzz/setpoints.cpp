#include <cmath>
#include <string>
#include <vector>

#include "trunnion/files/machine_file.hpp"
#include "trunnion/verify/check.hpp"
#include "trunnion/verify/programmed_csv.hpp"
#include "trunnion/verify/setpoint_table.hpp"

#include "entries.hpp"

namespace trunnion::fuzz {

namespace {

const machine::Machine& checked_machine() {
    static const machine::Machine machine = [] {
        std::string text = "chain = \"C A X Y Z\"\n";
        for (const char letter : std::string_view("XYZ"))
            text += std::string("[axes.") + letter +
                    "]\nrange = [\"-500 mm\", \"500 mm\"]\nmax_velocity = \"500 mm/s\"\n"
                    "max_acceleration = \"2500 mm/s^2\"\nmax_jerk = \"5000 mm/s^3\"\n";
        for (const char letter : std::string_view("AC"))
            text += std::string("[axes.") + letter +
                    "]\nrange = \"endless\"\nmax_velocity = \"15 rpm\"\n"
                    "max_acceleration = \"300 deg/s^2\"\nmax_jerk = \"1800 deg/s^3\"\n";
        const auto read = files::read_machine(text, "checked machine");
        expect(read.has_value(), "the machine of this test is good");
        return *read;
    }();
    return machine;
}

void take_setpoint_csv(std::string_view bytes) {
    const auto table = verify::read_setpoint_csv(bytes, checked_machine(), "fuzz");
    if (!table) return expect_sound(table.error(), bytes);
    expect(!table->rows.empty(), "a table that is read has rows");
    expect(table->rows.size() == 1 || table->period_s > 0, "the period is above 0");
    for (const motion::Setpoint& row : table->rows)
        for (const double place : row.position.v) expect(std::isfinite(place), "setpoints are finite");
    std::vector<verify::ProgrammedPose> line(2);
    line[1].tip_mm.x() = 10;
    const auto verdict = verify::check(*table, line, checked_machine(), {}, {});
    if (!verdict) return expect_sound(verdict.error(), bytes);
    expect(verdict->rows == table->rows.size(), "a verdict is about all rows");
    expect(verdict->ok == verdict->broken.empty(), "a motion is ok where nothing is broken");
}

/// What was read is written and read again: the same poses, bit for bit but for the axis, which is normalised twice.
void take_programmed_csv(std::string_view bytes) {
    const auto poses = verify::read_programmed_csv(bytes, checked_machine(), "fuzz");
    if (!poses) return expect_sound(poses.error(), bytes);
    const auto again =
        verify::read_programmed_csv(verify::programmed_csv(*poses, checked_machine()), checked_machine());
    expect(again.has_value() && again->size() == poses->size(), "what is written can be read");
    for (std::size_t i = 0; i < poses->size(); ++i) {
        const auto &before = (*poses)[i], &after = (*again)[i];
        expect(before.tip_mm.allFinite() && std::abs(before.axis.norm() - 1) < 1e-9, "poses are sound");
        expect(before.tip_mm == after.tip_mm && before.kind == after.kind && before.line == after.line,
               "what is written reads back the same");
        expect((before.axis - after.axis).norm() < 1e-12, "axes read back the same");
    }
}

}  // namespace

void take_setpoints(std::string_view bytes) {
    take_setpoint_csv(bytes);
    take_programmed_csv(bytes);
}

}  // namespace trunnion::fuzz
