#include "trunnion/verify/programmed_csv.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <optional>

#include <fmt/format.h>

#include "trunnion/base/quantity.hpp"

#include "detail/csv_rows.hpp"

namespace trunnion::verify {

namespace {

constexpr std::size_t piece_size = 1U << 16U;

std::string_view name_of(PoseKind kind) {
    switch (kind) {
        case PoseKind::rotary:
            return "rotary";
        case PoseKind::rapid:
            return "rapid";
        case PoseKind::vector:
            break;
    }
    return "vector";
}

std::optional<PoseKind> kind_named(std::string_view name) {
    for (const PoseKind kind : {PoseKind::vector, PoseKind::rotary, PoseKind::rapid})
        if (name == name_of(kind)) return kind;
    return {};
}

std::string column_of(const machine::Machine& machine, int rotary) {
    return fmt::format("{}_deg", machine.axes[machine.linear_count() + rotary].letter);
}

/// The rotary axes that have a word somewhere.
std::vector<int> axes_with_words(const std::vector<ProgrammedPose>& poses, const machine::Machine& machine) {
    std::vector<int> out;
    for (int r = 0; r < machine.rotary_count; ++r)
        if (std::any_of(poses.begin(), poses.end(), [r](const auto& pose) { return !std::isnan(pose.rotary_rad[r]); }))
            out.push_back(r);
    return out;
}

void append_pose(std::string& text, const ProgrammedPose& pose, const std::vector<int>& rotary) {
    auto out = std::back_inserter(text);
    const auto& t = pose.tip_mm;
    const auto& n = pose.axis;
    fmt::format_to(out, "{},{},{},{},{},{},{},{}", t.x(), t.y(), t.z(), n.x(), n.y(), n.z(), name_of(pose.kind),
                   pose.line);
    for (const int r : rotary)
        if (std::isnan(pose.rotary_rad[r]))
            text += ',';
        else
            fmt::format_to(out, ",{}", pose.rotary_rad[r] / degree);
    text += '\n';
}

/// Columns of a programmed pose in a table.
struct Columns {
    std::array<std::size_t, 6> pose{};
    std::optional<std::size_t> kind, line;
    std::array<std::optional<std::size_t>, machine::max_rotary_axes> rotary{};
};

Result<void> refuse_foreign_axes(const CsvRows& csv, const machine::Machine& machine) {
    for (const std::string_view name : csv.header()) {
        if (!name.ends_with("_deg")) continue;
        const int index = name.size() == 5 ? machine.index_of(name.front()) : -1;
        if (index < 0 || !machine.axes[index].rotary)
            return fail(csv.diagnose("VER0102", fmt::format("column {}: the machine has no such rotary axis", name)));
    }
    return {};
}

Result<Columns> find_columns(const CsvRows& csv, const machine::Machine& machine) {
    Columns out;
    constexpr std::array<std::string_view, 6> names{"x_mm", "y_mm", "z_mm", "i", "j", "k"};
    for (std::size_t n = 0; n < names.size(); ++n) {
        const auto column = csv.require(names[n]);
        if (!column) return fail(column.error());
        out.pose[n] = *column;
    }
    if (auto known = refuse_foreign_axes(csv, machine); !known) return fail(known.error());
    out.kind = csv.find("kind");
    out.line = csv.find("line");
    for (int r = 0; r < machine.rotary_count; ++r) out.rotary[r] = csv.find(column_of(machine, r));
    return out;
}

Result<void> read_geometry(const CsvRows& csv, const Columns& columns, ProgrammedPose& pose) {
    std::array<double, 6> value{};
    for (std::size_t n = 0; n < value.size(); ++n) {
        const auto number = csv.number(columns.pose[n]);
        if (!number) return fail(number.error());
        value[n] = *number;
    }
    pose.tip_mm = {value[0], value[1], value[2]};
    pose.axis = {value[3], value[4], value[5]};
    const double length = pose.axis.norm();
    if (!(length > 1e-9)) return fail(csv.diagnose("VER0108", "the tool axis has no direction"));
    pose.axis /= length;
    return {};
}

Result<ProgrammedPose> read_pose(const CsvRows& csv, const Columns& columns) {
    ProgrammedPose pose;
    pose.line = csv.line();
    if (auto read = read_geometry(csv, columns, pose); !read) return fail(read.error());
    if (columns.kind) {
        const auto kind = kind_named(csv.field(*columns.kind));
        if (!kind) return fail(csv.diagnose("VER0207", "unknown kind of pose", std::string(csv.field(*columns.kind))));
        pose.kind = *kind;
        pose.at_rapid = *kind == PoseKind::rapid;
    }
    if (columns.line) {
        const auto line = csv.number(*columns.line);
        if (!line) return fail(line.error());
        if (!(*line >= 0 && *line <= 2e9))
            return fail(
                csv.diagnose("VER0203", "column line has no line number", std::string(csv.field(*columns.line))));
        pose.line = static_cast<std::int32_t>(*line);
    }
    for (std::size_t r = 0; r < columns.rotary.size(); ++r) {
        if (!columns.rotary[r] || csv.field(*columns.rotary[r]).empty()) continue;
        const auto word = csv.number(*columns.rotary[r]);
        if (!word) return fail(word.error());
        pose.rotary_rad[r] = *word * degree;
        pose.literal = pose.kind == PoseKind::rotary;
    }
    return pose;
}

}  // namespace

void write_programmed_csv(const std::vector<ProgrammedPose>& poses, const machine::Machine& machine,
                          const std::function<void(std::string_view)>& write) {
    const auto rotary = axes_with_words(poses, machine);
    std::string text = "x_mm,y_mm,z_mm,i,j,k,kind,line";
    for (const int r : rotary) text += fmt::format(",{}", column_of(machine, r));
    text += '\n';
    for (const ProgrammedPose& pose : poses) {
        append_pose(text, pose, rotary);
        if (text.size() < piece_size) continue;
        write(text);
        text.clear();
    }
    write(text);
}

std::string programmed_csv(const std::vector<ProgrammedPose>& poses, const machine::Machine& machine) {
    std::string out;
    write_programmed_csv(poses, machine, [&out](std::string_view piece) { out += piece; });
    return out;
}

Result<std::vector<ProgrammedPose>> read_programmed_csv(std::string_view text, const machine::Machine& machine,
                                                        const std::string& file) {
    auto csv = CsvRows::open(text, file);
    if (!csv) return fail(csv.error());
    const auto columns = find_columns(*csv, machine);
    if (!columns) return fail(columns.error());
    std::vector<ProgrammedPose> poses;
    for (;;) {
        const auto more = csv->next();
        if (!more) return fail(more.error());
        if (!*more) break;
        const auto pose = read_pose(*csv, *columns);
        if (!pose) return fail(pose.error());
        poses.push_back(*pose);
    }
    if (poses.empty()) return fail(csv->diagnose("VER0201", "the table has no poses"));
    poses.front().stands = poses.back().stands = true;
    return poses;
}

}  // namespace trunnion::verify
