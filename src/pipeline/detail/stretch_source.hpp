#pragma once

#include <deque>
#include <span>
#include <vector>

#include "trunnion/machine/machine.hpp"
#include "trunnion/path/path_builder.hpp"
#include "trunnion/pipeline/plan_options.hpp"
#include "trunnion/program/program.hpp"

#include "detail/element.hpp"

namespace trunnion::pipeline {

/// The stretches of a program, one after another: builds the path, smooths it, takes it through the machine, and turns
/// a free axis in place where the next stretch begins at the pole with another position of it. Holds what the stretches
/// point to and must outlive them; keeps references to what it was made from.
class StretchSource {
  public:
    /// Errors: those of PathBuilder::make.
    static Result<StretchSource> make(const program::Program& program, const machine::Machine& machine,
                                      const machine::Setup& setup, const PlanOptions& options,
                                      std::span<const program::RotaryStand> stands);

    /// RunBegin, StretchBegin …, RunEnd for every run; a run without stretches holds events behind the last motion.
    /// Errors: those of PathBuilder and AxisPath, PIPE0003, PIPE0005.
    NextElement next();

    const program::Program& program() const { return *program_; }
    /// Of the path builder, met so far.
    const std::vector<Diagnostic>& diagnostics() const { return builder_.diagnostics(); }
    double smooth_s() const { return smooth_s_; }

  private:
    StretchSource(const program::Program& program, const machine::Machine& machine, const PlanOptions& options,
                  path::PathBuilder builder)
        : program_(&program), machine_(&machine), options_(&options), builder_(std::move(builder)) {}
    NextElement begin_run();
    void apply_feed_options();
    void smooth();
    Result<void> make_ready(path::ToolPath& tool_path);
    machine::RotaryPosition standing_before(const path::ToolPath& tool_path) const;
    Result<void> turn_in_place(const path::AxisPath& next);
    void hand_out(std::shared_ptr<const Stretch> stretch);
    Diagnostic joint_error(const path::AxisPath& next, double jump) const;
    double share(std::size_t block) const;

    const program::Program* program_;
    const machine::Machine* machine_;
    const PlanOptions* options_;
    path::PathBuilder builder_;
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
