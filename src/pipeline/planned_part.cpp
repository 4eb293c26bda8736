#include "detail/planned_part.hpp"

#include <algorithm>

#include "trunnion/path/rotary_stands.hpp"
#include "trunnion/smoothing/pole_tolerance.hpp"

namespace trunnion::pipeline {

namespace {

using Part = std::shared_ptr<PlannedPart>;

Result<Part> with_builder(Part part, const machine::Machine& machine, const machine::Setup& setup) {
    auto builder = path::PathBuilder::make(*part->program, machine, setup, part->stands);
    if (!builder) return fail(builder.error());
    part->builder.emplace(std::move(*builder));
    return part;
}

}  // namespace

Result<Part> PlannedPart::make(std::shared_ptr<const program::Program> program, const machine::Machine& machine,
                               const machine::Setup& setup, const PlanOptions& options,
                               const std::optional<machine::RotaryPosition>& standing) {
    auto stands = path::choose_rotary_stands(*program, machine, setup, smoothing::pole_tolerance_rad(options.smoothing),
                                             standing);
    if (!stands) return fail(stands.error());
    auto part = std::make_shared<PlannedPart>();
    part->program = std::move(program);
    part->stands = std::move(*stands);
    return with_builder(std::move(part), machine, setup);
}

Result<Part> WholeProgram::next() {
    if (given_) return Part();
    given_ = true;
    auto part = std::make_shared<PlannedPart>();
    part->program = std::shared_ptr<const program::Program>(std::shared_ptr<void>(), &program_);  // owned elsewhere
    part->stands = std::move(stands_);
    return with_builder(std::move(part), machine_, setup_);
}

/// Null behind the last one.
Result<std::shared_ptr<const program::Program>> ReadParts::next_program() {
    if (given_ < read_.size()) return std::move(read_[given_++]);
    auto program = std::make_shared<program::Program>();
    const auto more = parts_.next(*program);
    if (!more) return fail(more.error());
    if (!*more) program.reset();
    return program;
}

Result<Part> ReadParts::next() {
    auto program = next_program();
    if (!program) return fail(program.error());
    if (!*program) return Part();
    diagnostics_ = (*program)->diagnostics;
    auto part = PlannedPart::make(std::move(*program), machine_, setup_, options_, standing_);
    if (!part) return part;
    standing_ = (*part)->standing_behind();
    (*part)->share_begin = share_;
    (*part)->share_end = share_ = std::clamp(parts_.share(), share_, 1.0);
    return part;
}

}  // namespace trunnion::pipeline
