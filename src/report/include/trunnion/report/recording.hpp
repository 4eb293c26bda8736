#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <nlohmann/json_fwd.hpp>

#include "trunnion/machine/machine.hpp"
#include "trunnion/motion/prediction.hpp"
#include "trunnion/pipeline/plan.hpp"
#include "trunnion/program/program.hpp"

namespace trunnion::report {

namespace detail {
class BucketTable;
class PathThinning;
class ProgrammedDistance;
class ToolsInUse;
class Blob;
struct MotionRow;
}  // namespace detail

/// What a recording is made from. All of it must outlive the recording.
struct RecordedJob {
    const program::Program& program;
    const machine::Machine& machine;
    const machine::Setup& setup;
    double pole_tolerance_rad = 0;  ///< as path::choose_rotary_stands takes it, for the distance to the program
    double contact_lead_rad = 0;    ///< see controller/contact_feed.hpp
};

/// One motion as a page can show it: rows of time are kept in at most 2¹⁷ buckets with the least and the greatest of
/// every quantity, the tool path as a polyline of at most some 10⁵ places that stays within a few µm and a hundredth of
/// the feed of what was given. So memory does not grow with the length of the motion. Allocates; not thread safe.
class Recording {
  public:
    /// `label`: as the page calls it.
    Recording(RecordedJob job, std::string label);
    ~Recording();
    Recording(Recording&&) noexcept;

    /// Rows in order of time.
    void add(const detail::MotionRow& row);
    /// Behind the last row.
    void finish();

    const std::string& label() const { return label_; }
    std::size_t rows() const { return rows_; }
    double end_s() const { return end_s_; }

    /// Number of a cause in the list of names, which it joins where it is new. At most 255; the last one is shared.
    std::uint8_t cause_number(const std::string& name);
    const RecordedJob& job() const { return job_; }

    /// What the page has to know to find the columns in the blob, to which they are added.
    nlohmann::ordered_json describe(detail::Blob& blob) const;

  private:
    struct Last {
        double time_s = 0, turn_rad_s = 0;
        Eigen::Vector3d tip_mm, axis;
    };
    double turning(double time_s, const Eigen::Vector3d& axis) const;
    double contact_feed(const detail::MotionRow& row, const Eigen::Vector3d& tip_mm, const Eigen::Vector3d& axis,
                        const machine::Tool& tool) const;

    RecordedJob job_;
    std::string label_;
    std::vector<std::string> causes_;
    std::optional<Last> last_;
    std::unique_ptr<detail::BucketTable> buckets_;
    std::unique_ptr<detail::PathThinning> path_;
    std::unique_ptr<detail::ProgrammedDistance> distance_;
    std::unique_ptr<detail::ToolsInUse> tools_;
    std::size_t rows_ = 0;
    double end_s_ = 0;
};

/// Records what plan() gives; PlanOptions::setpoint_limits must be set. Velocities, accelerations and jerks are
/// differences of the setpoints, so that they tell what the axes are really asked to do.
class PlanRecording : public pipeline::PlanObserver {
  public:
    PlanRecording(RecordedJob job, std::string label, double period_s);

    void setpoint_limit(const pipeline::SetpointLimit& limit) override { limit_ = limit; }
    void setpoint(const motion::Setpoint& row) override;
    void event(const pipeline::EventRow& event) override;
    /// The recording, complete. Once, after plan(), whether it went well or not.
    Recording take();

    struct TimedEvent {
        double time_s = 0;
        std::int32_t line = 0;
        std::string word;
    };
    const std::vector<TimedEvent>& events() const { return events_; }

  private:
    struct Row {
        motion::Setpoint setpoint;
        std::optional<pipeline::SetpointLimit> limit;
    };
    void push(Row row);
    void give_middle();
    std::uint8_t cause_of(const Row& row);

    Recording recording_;
    double period_s_;
    std::optional<pipeline::SetpointLimit> limit_;
    std::array<Row, 5> window_{};
    std::size_t pushed_ = 0;
    std::map<std::pair<int, int>, std::uint8_t> cause_numbers_;
    std::vector<TimedEvent> events_;
};

/// Records the rows of a prediction.
class PredictionRecording {
  public:
    PredictionRecording(RecordedJob job, std::string label) : recording_(job, std::move(label)) {}

    void add(const motion::PredictedRow& row);
    Recording take();

  private:
    Recording recording_;
    std::optional<motion::PredictedRow> last_;
};

}  // namespace trunnion::report
