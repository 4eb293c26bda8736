#pragma once

#include <deque>
#include <vector>

#include "trunnion/machine/machine.hpp"
#include "trunnion/pipeline/plan_options.hpp"
#include "trunnion/program/program.hpp"

#include "detail/element.hpp"
#include "detail/planned_part.hpp"

namespace trunnion::pipeline {

/// The stretches of a program, one after another, part by part: builds the path, smooths it, takes it through the
/// machine, and turns a free axis in place where the next stretch begins at the pole with another position of it. A
/// stretch keeps alive what it points to; the source keeps references to what it was made from.
class StretchSource {
  public:
    StretchSource(PartSource& parts, const machine::Machine& machine, const PlanOptions& options)
        : parts_(&parts), machine_(&machine), options_(&options) {}

    /// RunBegin, StretchBegin …, RunEnd for every run; a run without stretches holds events behind the last motion.
    /// Errors: those of the parts, PathBuilder and AxisPath, PIPE0003, PIPE0005.
    NextElement next();

    /// The part at hand. Precondition: next() gave an element.
    const program::Program& program() const { return *part_->program; }
    /// Of path building, met so far.
    std::vector<Diagnostic> diagnostics() const;
    double smooth_s() const { return smooth_s_; }

  private:
    Result<void> take_next_part();
    NextElement begin_run();
    void apply_feed_options();
    void smooth();
    Result<void> make_ready(path::ToolPath& tool_path);
    machine::RotaryPosition standing_before(const path::ToolPath& tool_path) const;
    Result<void> turn_in_place(const path::AxisPath& next);
    void hand_out(std::shared_ptr<const Stretch> stretch);
    Diagnostic joint_error(const path::AxisPath& next, double jump) const;
    double share(std::size_t block) const;

    PartSource* parts_;
    const machine::Machine* machine_;
    const PlanOptions* options_;
    std::shared_ptr<PlannedPart> part_;
    std::vector<Diagnostic> diagnostics_;  // of the parts before it
    path::Run run_;
    std::vector<path::ToolPath> smoothed_;  // of the run
    std::size_t next_smoothed_ = 0;
    std::deque<Element> ready_;
    bool in_run_ = false, at_end_ = false;
    machine::AxisPosition at_;
    bool moved_ = false;
    double smooth_s_ = 0;
};

}  // namespace trunnion::pipeline
