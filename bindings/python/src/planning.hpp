#pragma once

#include <chrono>
#include <exception>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "trunnion/machine/machine.hpp"
#include "trunnion/pipeline/plan.hpp"

#include "arguments.hpp"

namespace trunnion::python {

/// Tolerances and how corners are rounded.
void take_tolerances(Keywords& keywords, smoothing::SmoothingOptions& options);
/// What the speed is planned with, but for the period.
void take_feed_options(Keywords& keywords, feed::FeedOptions& options);
/// These and all else that planning takes.
pipeline::PlanOptions take_plan_options(Keywords& keywords);

/// Asks Python now and then whether to go on: signals, and a function of the caller. For work without the GIL.
class Watch {
  public:
    explicit Watch(py::handle progress) : progress_(py::reinterpret_borrow<py::object>(progress)) {}
    /// False: an exception of Python's waits in rethrow().
    bool goes_on(double share);
    /// With the GIL.
    void rethrow() const {
        if (thrown_) std::rethrow_exception(thrown_);
    }

  private:
    py::object progress_;
    std::exception_ptr thrown_;
    std::chrono::steady_clock::time_point asked_ = std::chrono::steady_clock::now();
};

/// Text in JSON as Python's own objects.
py::object from_json(const std::string& json);

/// What planning came to, as Python sees it.
struct BoundPlan {
    py::object setpoints, path, events;
    std::vector<std::string> columns, path_columns;
    std::string json, report;
    std::vector<Diagnostic> diagnostics;
    double cycle_time_s = 0, period_s = 0;
    bool usable = false;
};

/// Collects rows of what is planned in the arrays that are handed over.
class Recorder final : public pipeline::PlanObserver {
  public:
    Recorder(const machine::Machine& machine, py::handle progress) : machine_(&machine), watch_(progress) {}

    void setpoint(const motion::Setpoint& row) override;
    void path_sample(const pipeline::PathSample& sample) override;
    void event(const pipeline::EventRow& row) override;
    bool progress(double share) override { return watch_.goes_on(share); }

    /// The exception that ended the work, if there is one.
    void rethrow() const { watch_.rethrow(); }
    /// Gives the rows away; with the GIL.
    BoundPlan finish(bool with_path);

  private:
    struct Event {
        double time_s, s_mm;
        program::Event event;
    };
    const machine::Machine* machine_;
    Watch watch_;
    std::vector<double> setpoints_, path_;
    std::vector<Event> events_;
};

}  // namespace trunnion::python
