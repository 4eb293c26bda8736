#pragma once

#include <atomic>
#include <cstdint>
#include <exception>
#include <memory>
#include <optional>
#include <thread>
#include <vector>

#include "trunnion/feed/live_planner.hpp"

#include "detail/bounded_queue.hpp"
#include "detail/planned_part.hpp"
#include "detail/stretch_source.hpp"

namespace trunnion::pipeline {

/// An event that falls inside a stretch, where a block of the run begins.
struct PassedEvent {
    std::size_t run_block = 0;
    program::Event event;
};

/// What LiveMotion does next: answer the events of a standstill, then move along a stretch (none behind the last one).
struct LiveStep {
    std::vector<program::Event> events;
    std::shared_ptr<const Stretch> stretch;
    std::shared_ptr<const program::Program> program;  ///< for diagnostics
    std::optional<feed::LivePlanner> planner;         ///< refers to the stretch
    std::vector<PassedEvent> passed;                  ///< by run_block
};

/// The options as the motion uses them.
PlanOptions live_options(const PlanOptions& options);

/// Turns the elements of a StretchSource into steps.
class LiveStepSource {
  public:
    LiveStepSource(program::ProgramParts& parts, const machine::Machine& machine, const machine::Setup& setup,
                   const PlanOptions& options, double longest_plan_s)
        : options_(live_options(options)),
          longest_plan_s_(longest_plan_s),
          parts_({}, parts, machine, setup, options_),
          stretches_(parts_, machine, options_) {}

    /// The next step; none behind the last one. Errors: those of StretchSource and LivePlanner::make.
    Result<std::optional<LiveStep>> next();
    std::vector<Diagnostic> diagnostics() const;

  private:
    Result<LiveStep> step_of(const StretchBegin& begin);
    void take_events_before(std::size_t block);

    PlanOptions options_;
    double longest_plan_s_;
    ReadParts parts_;
    StretchSource stretches_;
    RunBegin run_;
    std::size_t next_event_ = 0;  // of the run
    std::vector<program::Event> events_;
};

/// The steps on a thread of their own, some batches ahead.
class LiveStepsAhead {
  public:
    LiveStepsAhead(program::ProgramParts& parts, const machine::Machine& machine, const machine::Setup& setup,
                   const PlanOptions& options, double longest_plan_s)
        : source_(parts, machine, setup, options, longest_plan_s), thread_([this] { work(); }) {}
    ~LiveStepsAhead();
    LiveStepsAhead(const LiveStepsAhead&) = delete;
    LiveStepsAhead& operator=(const LiveStepsAhead&) = delete;

    enum class Next : std::uint8_t { step, not_yet, none };
    /// The next step into `step`. `wait`: until there is one, or none to come. Errors: those of LiveStepSource, behind
    /// the steps that came before.
    Result<Next> take(LiveStep& step, bool wait);
    /// Of what the thread is through with. Precondition: take() gave `none` or an error.
    std::vector<Diagnostic> diagnostics() const { return source_.diagnostics(); }

  private:
    /// Steps that are handed over together, and what ends them all.
    struct Batch {
        std::vector<LiveStep> steps;
        std::optional<Diagnostic> error;
        bool last = false;
    };
    static constexpr std::size_t capacity = 4, most_steps = 32, most_blocks = 500;

    void work() noexcept;
    Batch make_batch();

    LiveStepSource source_;
    BoundedQueue<Batch> queue_{capacity};
    Batch batch_;                // of which steps are being taken
    std::size_t next_ = 0;       // of the batch
    std::exception_ptr thrown_;  // written before threw_
    std::atomic<bool> threw_{false};
    std::thread thread_;
};

}  // namespace trunnion::pipeline
