#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "trunnion/machine/machine.hpp"
#include "trunnion/path/path_builder.hpp"
#include "trunnion/pipeline/plan_options.hpp"
#include "trunnion/program/program_parts.hpp"

namespace trunnion::pipeline {

/// A part of a program on its way to stretches. The builder refers to the stands, what it builds to the builder: all of
/// it stays together until nothing of it is in use.
struct PlannedPart {
    std::shared_ptr<const program::Program> program;
    std::vector<program::RotaryStand> stands;
    std::optional<path::PathBuilder> builder;
    double share_begin = 0, share_end = 1;  ///< of the program, as far as is known

    /// `standing`: the rotary axes stand so at the first pose, as the part before left them; free without it. Errors:
    /// those of path::choose_rotary_stands and PathBuilder::make.
    static Result<std::shared_ptr<PlannedPart>> make(std::shared_ptr<const program::Program> program,
                                                     const machine::Machine& machine, const machine::Setup& setup,
                                                     const PlanOptions& options,
                                                     const std::optional<machine::RotaryPosition>& standing);

    /// Where the rotary axes stand behind the last move.
    const machine::RotaryPosition& standing_behind() const { return stands.back().rotary_rad; }
};

/// The parts of a program, one after another. Null behind the last one.
class PartSource {
  public:
    virtual ~PartSource() = default;
    virtual Result<std::shared_ptr<PlannedPart>> next() = 0;
};

/// A program that is there as a whole, with stands that were chosen before.
class WholeProgram final : public PartSource {
  public:
    WholeProgram(const program::Program& program, const machine::Machine& machine, const machine::Setup& setup,
                 std::vector<program::RotaryStand> stands)
        : program_(program), machine_(machine), setup_(setup), stands_(std::move(stands)) {}

    Result<std::shared_ptr<PlannedPart>> next() override;

  private:
    const program::Program& program_;
    const machine::Machine& machine_;
    const machine::Setup& setup_;
    std::vector<program::RotaryStand> stands_;
    bool given_ = false;
};

/// A program that is read meanwhile: the parts that are there already, then those of the reader. Each begins with the
/// rotary axes as the one before left them.
class ReadParts final : public PartSource {
  public:
    ReadParts(std::vector<std::shared_ptr<const program::Program>> read, program::ProgramParts& parts,
              const machine::Machine& machine, const machine::Setup& setup, const PlanOptions& options)
        : read_(std::move(read)), parts_(parts), machine_(machine), setup_(setup), options_(options) {}

    Result<std::shared_ptr<PlannedPart>> next() override;

    /// Of the last part: what reading noticed.
    const std::vector<Diagnostic>& diagnostics() const { return diagnostics_; }

  private:
    Result<std::shared_ptr<const program::Program>> next_program();

    std::vector<std::shared_ptr<const program::Program>> read_;
    std::size_t given_ = 0;
    program::ProgramParts& parts_;
    const machine::Machine& machine_;
    const machine::Setup& setup_;
    const PlanOptions& options_;
    std::optional<machine::RotaryPosition> standing_;
    double share_ = 0;
    std::vector<Diagnostic> diagnostics_;
};

}  // namespace trunnion::pipeline
