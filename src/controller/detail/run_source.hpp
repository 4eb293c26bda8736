#pragma once

#include <vector>

#include "trunnion/controller/predict.hpp"
#include "trunnion/path/path_builder.hpp"

namespace trunnion::controller {

/// The runs of a program as a control takes them: with its choice of branch, feeds checked and overridden.
class RunSource {
  public:
    /// Errors: those of choose_rotary_stands and PathBuilder::make, CTRL0204, CTRL0206.
    static Result<RunSource> make(const program::Program& program, const machine::Machine& machine,
                                  const machine::Setup& setup, motion::BranchRule rule, const PredictOptions& options);

    /// Errors: those of PathBuilder, CTRL0201.
    Result<bool> next(path::Run& run);

    /// What was met so far, CTRL0202 at the end.
    std::vector<Diagnostic> diagnostics() const;
    std::size_t blocks() const { return blocks_; }

  private:
    RunSource() = default;

    const program::Program* program_ = nullptr;
    PredictOptions options_;
    /// Their place in memory is what the builder points to; moving the vector keeps it.
    std::vector<program::RotaryStand> stands_;
    std::optional<path::PathBuilder> builder_;
    std::size_t blocks_ = 0;
};

/// The tool that is in use along a run.
const machine::Tool& tool_of(const path::Run& run, const program::Program& program, const machine::Setup& setup);

/// Feed of the tip that a block asks for, mm/s; 0: it says something else.
double programmed_tip_feed(const path::Block& block, double way_mm);

}  // namespace trunnion::controller
