#include "trunnion/report/recording.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <nlohmann/json.hpp>

#include "trunnion/base/quantity.hpp"
#include "trunnion/controller/contact_feed.hpp"
#include "trunnion/path/rotary_stands.hpp"
#include "trunnion/verify/programmed_path.hpp"

#include "detail/blob.hpp"
#include "detail/bucket_table.hpp"
#include "detail/motion_row.hpp"
#include "detail/neighbour_difference.hpp"
#include "detail/path_thinning.hpp"
#include "detail/programmed_distance.hpp"
#include "detail/tools_in_use.hpp"

namespace trunnion::report {

using nlohmann::ordered_json;

namespace {

constexpr double nothing = std::numeric_limits<double>::quiet_NaN();
constexpr double per_minute = 60, um = 1000;
/// What a browser that draws by software turns at 30 pictures a second.
constexpr std::size_t most_places_in_motion = 3000;

/// What a bucket holds of every axis, and of the tool.
constexpr std::array axis_quantities{"position", "velocity", "acceleration", "jerk"};
constexpr std::array tool_quantities{"feed", "programmed", "contact", "deviation", "turn"};

/// A program whose poses cannot be worked out is shown without deviations.
std::vector<verify::ProgrammedPose> poses_of(const RecordedJob& job) {
    const auto stands = path::choose_rotary_stands(job.program, job.machine, job.setup, job.pole_tolerance_rad);
    if (!stands) return {};
    auto poses = verify::programmed_poses(job.program, job.machine, job.setup, *stands);
    return poses ? std::move(*poses) : std::vector<verify::ProgrammedPose>{};
}

ordered_json place_json(const detail::Blob::Place& place) {
    return {{"at", place.offset}, {"n", place.count}, {"type", place.type}};
}

template <class Number, class Item, class Get>
ordered_json column(detail::Blob& blob, const std::vector<Item>& items, Get get) {
    std::vector<Number> numbers;
    numbers.reserve(items.size());
    for (const Item& item : items) numbers.push_back(static_cast<Number>(get(item)));
    return place_json(blob.add(std::span<const Number>(numbers)));
}

template <class Number, class Get>
ordered_json vectors(detail::Blob& blob, const std::vector<detail::PathPlace>& places, double scale, Get get) {
    std::vector<Number> numbers;
    numbers.reserve(3 * places.size());
    for (const detail::PathPlace& place : places)
        for (int c = 0; c < 3; ++c) numbers.push_back(static_cast<Number>(scale * get(place)[c]));
    return place_json(blob.add(std::span<const Number>(numbers)));
}

ordered_json buckets_json(const detail::BucketTable& table, const machine::Machine& machine, detail::Blob& blob) {
    using Begin = detail::BucketTable::Begin;
    const auto& begins = table.begins();
    ordered_json out = {{"rows_per_bucket", table.rows_per_bucket()}};
    out["time"] = column<double>(blob, begins, [](const Begin& b) { return b.time_s; });
    out["way"] = column<float>(blob, begins, [](const Begin& b) { return b.path_length_mm; });
    out["line"] = column<std::int32_t>(blob, begins, [](const Begin& b) { return b.line; });
    out["cause"] = column<std::uint8_t>(blob, begins, [](const Begin& b) { return b.cause; });
    out["rapid"] = column<std::uint8_t>(blob, begins, [](const Begin& b) { return b.rapid ? 1 : 0; });
    const auto range = [&](std::size_t quantity) {
        ordered_json both = {{"least", place_json(blob.add(std::span<const float>(table.least(quantity))))}};
        if (table.rows_per_bucket() > 1)
            both["greatest"] = place_json(blob.add(std::span<const float>(table.greatest(quantity))));
        return both;
    };
    std::size_t quantity = 0;
    for (int a = 0; a < machine.axis_count; ++a)
        for (const char* name : axis_quantities)
            out["axes"][std::string(1, machine.axes[static_cast<std::size_t>(a)].letter)][name] = range(quantity++);
    for (const char* name : tool_quantities) out[name] = range(quantity++);
    return out;
}

ordered_json path_json(const std::vector<detail::PathPlace>& places, detail::Blob& blob) {
    using detail::PathPlace;
    constexpr double whole = 32767;
    ordered_json out;
    out["time"] = column<double>(blob, places, [](const PathPlace& p) { return p.time_s; });
    out["way"] = column<double>(blob, places, [](const PathPlace& p) { return p.path_length_mm; });
    out["tip"] = vectors<float>(blob, places, 1, [](const PathPlace& p) { return p.tip_mm; });
    out["axis"] = vectors<std::int16_t>(blob, places, whole, [](const PathPlace& p) { return p.axis; });
    out["feed"] = column<float>(blob, places, [](const PathPlace& p) { return p.feed_mm_s * per_minute; });
    out["programmed"] =
        column<float>(blob, places, [](const PathPlace& p) { return p.programmed_feed_mm_s * per_minute; });
    out["contact"] = column<float>(blob, places, [](const PathPlace& p) { return p.contact_feed_mm_s * per_minute; });
    out["deviation"] = column<float>(blob, places, [](const PathPlace& p) { return p.deviation_mm * um; });
    out["turn"] = column<float>(blob, places, [](const PathPlace& p) { return p.turn_rad_s / degree; });
    const auto differences = detail::neighbour_differences(places, detail::neighbour_reaches_mm(places));
    out["neighbour"] = column<float>(blob, differences, [](float share) { return 100 * share; });
    out["line"] = column<std::int32_t>(blob, places, [](const PathPlace& p) { return p.line; });
    out["cause"] = column<std::uint8_t>(blob, places, [](const PathPlace& p) { return p.cause; });
    out["rapid"] = column<std::uint8_t>(blob, places, [](const PathPlace& p) { return p.rapid ? 1 : 0; });
    const std::vector<std::int32_t> coarse = detail::coarse_places(places, most_places_in_motion);
    out["coarse"] = place_json(blob.add(std::span<const std::int32_t>(coarse)));
    return out;
}

const char* name_of(machine::ToolKind kind) {
    switch (kind) {
        case machine::ToolKind::flat:
            return "flat";
        case machine::ToolKind::ball:
            return "ball";
        case machine::ToolKind::torus:
            return "torus";
        case machine::ToolKind::taper:
            break;
    }
    return "taper";
}

ordered_json tools_json(const std::vector<detail::ToolsInUse::Change>& changes, const program::Program& program) {
    ordered_json out = ordered_json::array();
    for (const auto& change : changes)
        out.push_back({{"from_s", change.time_s},
                       {"name", program.tools[change.index]},
                       {"kind", name_of(change.tool->kind)},
                       {"diameter_mm", change.tool->diameter_mm},
                       {"corner_radius_mm", change.tool->corner_radius_mm},
                       {"length_mm", change.tool->length_mm}});
    return out;
}

}  // namespace

Recording::Recording(RecordedJob job, std::string label)
    : job_(job),
      label_(std::move(label)),
      buckets_(std::make_unique<detail::BucketTable>(
          static_cast<std::size_t>(job.machine.axis_count) * axis_quantities.size() + tool_quantities.size())),
      path_(std::make_unique<detail::PathThinning>()),
      distance_(std::make_unique<detail::ProgrammedDistance>(poses_of(job))),
      tools_(std::make_unique<detail::ToolsInUse>(job.program, job.machine, job.setup)) {}

Recording::~Recording() = default;
Recording::Recording(Recording&&) noexcept = default;

std::uint8_t Recording::cause_number(const std::string& name) {
    constexpr std::size_t most = 255;
    const auto known = std::ranges::find(causes_, name);
    if (known != causes_.end()) return static_cast<std::uint8_t>(known - causes_.begin());
    if (causes_.size() < most) causes_.push_back(name);
    return static_cast<std::uint8_t>(causes_.size() - 1);
}

/// How fast the tool axis turns in the workpiece; where no time has passed, as before.
double Recording::turning(double time_s, const Eigen::Vector3d& axis) const {
    if (!last_) return 0;
    const double passed = time_s - last_->time_s;
    return passed > 0 ? 2 * std::asin(std::min(1.0, (axis - last_->axis).norm() / 2)) / passed : last_->turn_rad_s;
}

double Recording::contact_feed(const detail::MotionRow& row, const Eigen::Vector3d& tip_mm, const Eigen::Vector3d& axis,
                               const machine::Tool& tool) const {
    if (std::isfinite(row.contact_feed_mm_s)) return row.contact_feed_mm_s;
    if (!(tool.diameter_mm > 0) || !last_) return nothing;
    const Eigen::Vector3d way = tip_mm - last_->tip_mm;
    if (!(way.norm() > 0)) return row.feed_mm_s;
    const Eigen::Vector3d turning_rad_s =
        controller::tool_turning_rad_s(job_.machine, job_.setup.workpiece, row.position, row.velocity);
    const Eigen::Vector3d contact = controller::contact_from_tip_mm(tool, axis, way, job_.contact_lead_rad);
    return controller::contact_velocity(way.normalized() * row.feed_mm_s, turning_rad_s, contact).norm();
}

void Recording::add(const detail::MotionRow& row) {
    const auto in_use = tools_->at_line(row.line);
    tools_->note(row.time_s, in_use);
    const machine::Pose pose = in_use.kinematics ? in_use.kinematics->forward(row.position) : machine::Pose{};
    const Eigen::Vector3d &tip = pose.tip_in_workpiece_mm, &axis = pose.axis_in_workpiece;
    const double turn = turning(row.time_s, axis);
    const double contact = contact_feed(row, tip, axis, *in_use.tool);
    const double deviation = distance_->at(tip, axis, row.line, in_use.tool->controlled_height_mm());

    std::array<float, axis_quantities.size() * machine::max_axes + tool_quantities.size()> values{};
    std::size_t n = 0;
    for (int a = 0; a < job_.machine.axis_count; ++a) {
        const auto k = static_cast<std::size_t>(a);
        const double unit = job_.machine.axes[k].rotary ? degree : 1;
        for (const double value : {row.position[k], row.velocity[k], row.acceleration[k], row.jerk[k]})
            values[n++] = static_cast<float>(value / unit);
    }
    for (const double value : {row.feed_mm_s * per_minute, row.programmed_feed_mm_s * per_minute, contact * per_minute,
                               deviation * um, turn / degree})
        values[n++] = static_cast<float>(value);
    buckets_->add({row.time_s, row.path_length_mm, row.line, row.cause, row.rapid},
                  std::span<const float>(values).first(n));
    path_->add({.time_s = row.time_s,
                .path_length_mm = row.path_length_mm,
                .tip_mm = tip,
                .axis = axis,
                .feed_mm_s = row.feed_mm_s,
                .programmed_feed_mm_s = row.programmed_feed_mm_s,
                .contact_feed_mm_s = contact,
                .deviation_mm = deviation,
                .turn_rad_s = turn,
                .line = row.line,
                .cause = row.cause,
                .rapid = row.rapid});
    last_ = {row.time_s, turn, tip, axis};
    end_s_ = row.time_s;
    ++rows_;
}

void Recording::finish() {
    path_->finish();
}

ordered_json Recording::describe(detail::Blob& blob) const {
    return {{"label", label_},
            {"program", job_.program.source},
            {"rows", rows_},
            {"end_s", end_s_},
            {"causes", causes_},
            {"tools", tools_json(tools_->changes(), job_.program)},
            {"buckets", buckets_json(*buckets_, job_.machine, blob)},
            {"path", path_json(path_->places(), blob)}};
}

PlanRecording::PlanRecording(RecordedJob job, std::string label, double period_s)
    : recording_(job, std::move(label)), period_s_(period_s) {}

void PlanRecording::setpoint(const motion::Setpoint& row) {
    // The machine stands before the first setpoint and behind the last one.
    if (pushed_ == 0)
        for (int k = 0; k < 2; ++k) push({row, {}});
    push({row, std::exchange(limit_, std::nullopt)});
}

void PlanRecording::event(const pipeline::EventRow& event) {
    constexpr std::size_t most = 5000;
    if (events_.size() < most) events_.push_back({event.time_s, event.event->line, event.event->word});
}

void PlanRecording::push(Row row) {
    std::move(window_.begin() + 1, window_.end(), window_.begin());
    window_.back() = std::move(row);
    if (++pushed_ >= window_.size()) give_middle();
}

/// Central differences about the middle of five setpoints.
void PlanRecording::give_middle() {
    const Row& middle = window_[2];
    const double h = period_s_;
    detail::MotionRow out{.time_s = middle.setpoint.time_s,
                          .position = middle.setpoint.position,
                          .line = middle.setpoint.line,
                          .path_length_mm = middle.setpoint.path_length_mm,
                          .feed_mm_s = middle.setpoint.feed_mm_s,
                          .cause = cause_of(middle)};
    for (std::size_t a = 0; a < machine::max_axes; ++a) {
        const auto q = [&](std::size_t k) { return window_[k].setpoint.position[a]; };
        out.velocity[a] = (q(3) - q(1)) / (2 * h);
        out.acceleration[a] = (q(3) - 2 * q(2) + q(1)) / (h * h);
        out.jerk[a] = (q(4) - 2 * q(3) + 2 * q(1) - q(0)) / (2 * h * h * h);
    }
    if (middle.limit) {
        out.rapid = middle.limit->rapid;
        if (std::isfinite(middle.limit->programmed_feed_mm_s))
            out.programmed_feed_mm_s = middle.limit->programmed_feed_mm_s;
    }
    recording_.add(out);
}

std::uint8_t PlanRecording::cause_of(const Row& row) {
    constexpr std::pair standstill{-1, -1};
    const auto key = row.limit ? std::pair{static_cast<int>(row.limit->cause.kind), row.limit->cause.axis} : standstill;
    const auto known = cause_numbers_.find(key);
    if (known != cause_numbers_.end()) return known->second;
    const std::string name =
        row.limit ? feed::name_of(row.limit->cause, recording_.job().machine) : std::string("standstill");
    return cause_numbers_[key] = recording_.cause_number(name);
}

Recording PlanRecording::take() {
    if (pushed_ > 0)
        for (int k = 0; k < 2; ++k) push({window_.back().setpoint, {}});
    recording_.finish();
    return std::move(recording_);
}

void PredictionRecording::add(const motion::PredictedRow& row) {
    detail::MotionRow out{.time_s = row.time_s,
                          .position = row.position,
                          .velocity = row.velocity,
                          .line = row.line,
                          .path_length_mm = row.path_length_mm,
                          .feed_mm_s = row.tip_feed_mm_s,
                          .contact_feed_mm_s = row.contact_feed_mm_s,
                          .cause = recording_.cause_number(to_string(row.limit, recording_.job().machine)),
                          .rapid = row.rapid};
    const double passed = last_ ? row.time_s - last_->time_s : 0;
    for (std::size_t a = 0; a < machine::max_axes; ++a) {
        out.acceleration[a] = passed > 0 ? (row.velocity[a] - last_->velocity[a]) / passed : nothing;
        out.jerk[a] = nothing;
    }
    last_ = row;
    recording_.add(out);
}

Recording PredictionRecording::take() {
    recording_.finish();
    return std::move(recording_);
}

}  // namespace trunnion::report
