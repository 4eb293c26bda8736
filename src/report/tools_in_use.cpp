#include "detail/tools_in_use.hpp"

namespace trunnion::report::detail {

ToolsInUse::ToolsInUse(const program::Program& program, const machine::Machine& machine, const machine::Setup& setup)
    : program_(&program), machine_(&machine), setup_(&setup) {
    if (program.tools.size() > 1)
        for (const program::Move& move : program.moves) tool_by_line_.emplace(move.line, move.tool);
    if (!program.moves.empty()) last_ = program.moves.front().tool;
}

/// A tool that the setup lacks was refused, or is the setup's [tool] (PATH0007).
const machine::Tool* ToolsInUse::tool_of(const std::string& name) const {
    const machine::Tool* named = name.empty() ? nullptr : setup_->tool_named(name);
    return named ? named : &setup_->tool;
}

ToolsInUse::InUse ToolsInUse::at_line(std::int32_t line) {
    if (const auto found = tool_by_line_.find(line); found != tool_by_line_.end()) last_ = found->second;
    const machine::Tool* tool = tool_of(program_->tools[last_]);
    auto known = kinematics_.find(last_);
    if (known == kinematics_.end()) {
        auto made = machine::Kinematics::make(*machine_, setup_->workpiece, tool->length_mm);
        known = kinematics_.emplace(last_, made ? std::optional(*made) : std::nullopt).first;
    }
    return {last_, tool, known->second ? &*known->second : nullptr};
}

void ToolsInUse::note(double time_s, const InUse& in_use) {
    if (changes_.empty() || changes_.back().index != in_use.index)
        changes_.push_back({time_s, in_use.index, in_use.tool});
}

}  // namespace trunnion::report::detail
