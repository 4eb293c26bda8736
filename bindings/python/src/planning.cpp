#include "planning.hpp"

#include <fmt/format.h>

#include "trunnion/files/setpoint_file.hpp"

#include "machine.hpp"
#include "program_words.hpp"
#include "series.hpp"

namespace trunnion::python {

void take_tolerances(Keywords& keywords, smoothing::SmoothingOptions& options) {
    using smoothing::Corners, smoothing::Link, smoothing::Rounding;
    keywords.word("rounding", options.rounding,
                  {{"smooth", Rounding::smooth}, {"beudaert", Rounding::beudaert}, {"none", Rounding::none}});
    keywords.word("corners", options.corners, {{"smooth", Corners::smooth}, {"beudaert", Corners::beudaert}});
    keywords.word("link", options.link, {{"optimised", Link::optimised}, {"linear", Link::linear}});
    keywords.number("tip_tolerance_mm", options.tip_tolerance_mm);
    keywords.number("orientation_tolerance_deg", options.orientation_tolerance_rad, degree);
    keywords.number("flank_tolerance_mm", options.flank_tolerance_mm);
    keywords.number("flank_height_mm", options.flank_height_mm);
}

void take_feed_options(Keywords& keywords, feed::FeedOptions& options) {
    keywords.number("calm", options.calm);
    keywords.number("jerk_margin", options.jerk_margin);
    keywords.number("chord_error_mm", options.chord_error_mm);
    keywords.number("tip_acceleration_mm_s2", options.tip_acceleration_mm_s2);
    keywords.number("tip_jerk_mm_s3", options.tip_jerk_mm_s3);
    keywords.number("tool_turn_deg_s", options.turn_velocity_rad_s, degree);
}

pipeline::PlanOptions take_plan_options(Keywords& keywords) {
    pipeline::PlanOptions out;
    take_tolerances(keywords, out.smoothing);
    take_feed_options(keywords, out.feed);
    keywords.number("period_s", out.period_s);
    keywords.number("feed_override", out.feed_override);
    keywords.number("feed_mm_min", out.feed_mm_s, 1.0 / 60);
    keywords.count("threads", out.threads);
    keywords.flag("worth", out.worth);
    return out;
}

bool Watch::goes_on(double share) {
    constexpr std::chrono::milliseconds pause(20);
    const auto now = std::chrono::steady_clock::now();
    if (now - asked_ < pause) return true;
    asked_ = now;
    const py::gil_scoped_acquire acquired;
    try {
        if (PyErr_CheckSignals() != 0) throw py::error_already_set();
        if (!progress_.is_none()) progress_(share);
    } catch (py::error_already_set&) {
        thrown_ = std::current_exception();
    }
    return thrown_ == nullptr;
}

py::object from_json(const std::string& json) {
    return py::module_::import("json").attr("loads")(json);
}

void Recorder::setpoint(const motion::Setpoint& row) {
    setpoints_.push_back(row.time_s);
    for (int i = 0; i < machine_->axis_count; ++i)
        setpoints_.push_back(row.position[static_cast<std::size_t>(i)] / unit_of(machine_->axes[i]));
    setpoints_.insert(setpoints_.end(), {static_cast<double>(row.line), row.path_length_mm, row.feed_mm_s * 60});
}

void Recorder::path_sample(const pipeline::PathSample& sample) {
    path_.insert(path_.end(), {sample.p_mm, sample.s_mm, sample.tip_mm.x(), sample.tip_mm.y(), sample.tip_mm.z(),
                               sample.axis.x(), sample.axis.y(), sample.axis.z(), sample.speed_limit_mm_s,
                               sample.speed_mm_s, sample.feed_top_mm_s * 60});
    for (int i = 0; i < machine_->axis_count; ++i)
        for (int order = 0; order < 4; ++order)
            path_.push_back(derivative(sample.axes[static_cast<std::size_t>(i)], order) / unit_of(machine_->axes[i]));
}

void Recorder::event(const pipeline::EventRow& row) {
    events_.push_back({row.time_s, row.s_mm, *row.event});
}

BoundPlan Recorder::finish(bool with_path) {
    BoundPlan out;
    out.columns = files::setpoint_columns(*machine_);
    out.setpoints = array_from(std::move(setpoints_), static_cast<py::ssize_t>(out.columns.size()));
    out.path_columns = {"p_mm", "s_mm", "tip_x_mm",         "tip_y_mm",   "tip_z_mm",       "i",
                        "j",    "k",    "speed_limit_mm_s", "speed_mm_s", "feed_top_mm_min"};
    for (int i = 0; i < machine_->axis_count; ++i)
        for (const char* suffix : {"", "_p", "_pp", "_ppp"})
            out.path_columns.push_back(fmt::format("{}{}", machine_->axes[i].letter, suffix));
    out.path = with_path ? py::object(array_from(std::move(path_), static_cast<py::ssize_t>(out.path_columns.size())))
                         : py::object(py::none());
    py::list events;
    for (const Event& event : events_) {
        py::dict row;
        row["time_s"] = event.time_s;
        row["s_mm"] = event.s_mm;
        row["kind"] = name_of(event.event.kind, event_kinds);
        row["word"] = event.event.word;
        row["line"] = event.event.line;
        events.append(row);
    }
    out.events = events;
    return out;
}

}  // namespace trunnion::python
