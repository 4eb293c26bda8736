#include "trunnion/pipeline/plan_files.hpp"

#include <iterator>

#include <fmt/format.h>

#include "trunnion/base/quantity.hpp"

namespace trunnion::pipeline {

namespace {

std::string path_header(const machine::Machine& machine) {
    std::string out = "p_mm,s_mm,tip_x_mm,tip_y_mm,tip_z_mm,i,j,k,speed_limit_mm_s,speed_mm_s,feed_top_mm_min";
    for (int i = 0; i < machine.axis_count; ++i) {
        const char letter = machine.axes[i].letter;
        fmt::format_to(std::back_inserter(out), ",{0},{0}_p,{0}_pp,{0}_ppp", letter);
    }
    return out + "\n";
}

/// The words of an event as one CSV field.
std::string csv_text(std::string_view text) {
    std::string out = "\"";
    for (const char c : text) out += c == '"' ? std::string("\"\"") : std::string(1, c);
    return out + "\"";
}

std::string_view kind_name(program::EventKind kind) {
    using program::EventKind;
    switch (kind) {
        case EventKind::dwell:
            return "dwell";
        case EventKind::tool:
            return "tool";
        case EventKind::spindle:
            return "spindle";
        case EventKind::coolant:
            return "coolant";
        case EventKind::stop:
            return "stop";
        case EventKind::other:
            break;
    }
    return "other";
}

}  // namespace

Result<std::unique_ptr<PlanFiles>> PlanFiles::create(const PlanFileNames& names, const machine::Machine& machine,
                                                     std::function<bool(double)> progress) {
    std::unique_ptr<PlanFiles> out(new PlanFiles(machine));
    out->progress_ = std::move(progress);
    if (!names.setpoints.empty()) {
        auto file = files::SetpointFile::create(names.setpoints, machine);
        if (!file) return fail(file.error());
        out->setpoints_ = std::move(*file);
    }
    if (!names.path_samples.empty()) {
        auto file = files::OutputFile::create(names.path_samples);
        if (!file) return fail(file.error());
        out->path_ = std::move(*file);
        out->path_->write(path_header(machine));
    }
    if (!names.events.empty()) {
        auto file = files::OutputFile::create(names.events);
        if (!file) return fail(file.error());
        out->events_ = std::move(*file);
        out->events_->write("t_s,s_mm,line,kind,word\n");
    }
    return out;
}

void PlanFiles::setpoint(const motion::Setpoint& row) {
    if (setpoints_) setpoints_->write(row);
}

void PlanFiles::path_sample(const PathSample& sample) {
    if (!path_) return;
    std::string row =
        fmt::format("{},{},{},{},{},{},{},{},{},{},{}", sample.p_mm, sample.s_mm, sample.tip_mm.x(), sample.tip_mm.y(),
                    sample.tip_mm.z(), sample.axis.x(), sample.axis.y(), sample.axis.z(), sample.speed_limit_mm_s,
                    sample.speed_mm_s, sample.feed_top_mm_s * 60);
    for (int i = 0; i < machine_->axis_count; ++i) {
        const double unit = machine_->axes[i].rotary ? degree : 1.0;
        const Taylor3& q = sample.axes[i];
        fmt::format_to(std::back_inserter(row), ",{},{},{},{}", q.value() / unit, q.d1() / unit, q.d2() / unit,
                       q.d3() / unit);
    }
    path_->write(row + "\n");
}

void PlanFiles::event(const EventRow& row) {
    if (!events_) return;
    events_->write(fmt::format("{},{},{},{},{}\n", row.time_s, row.s_mm, row.event->line, kind_name(row.event->kind),
                               csv_text(row.event->word)));
}

Result<void> PlanFiles::commit() {
    if (setpoints_)
        if (auto done = setpoints_->commit(); !done) return done;
    if (path_)
        if (auto done = path_->commit(); !done) return done;
    if (events_)
        if (auto done = events_->commit(); !done) return done;
    return {};
}

Result<void> write_text_file(const std::filesystem::path& path, std::string_view text) {
    auto file = files::OutputFile::create(path);
    if (!file) return fail(file.error());
    file->write(text);
    return file->commit();
}

}  // namespace trunnion::pipeline
