#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <unordered_map>
#include <vector>

#include "trunnion/machine/kinematics.hpp"
#include "trunnion/machine/machine.hpp"
#include "trunnion/program/program.hpp"

namespace trunnion::report::detail {

/// Which tool cuts on which line of a program, and the machine's kinematics with it, in the frame of [workpiece].
class ToolsInUse {
  public:
    ToolsInUse(const program::Program& program, const machine::Machine& machine, const machine::Setup& setup);

    /// By line; a line without a move has the tool of the line asked for before.
    struct InUse {
        std::size_t index = 0;                            ///< in Program::tools
        const machine::Tool* tool = nullptr;              ///< never null
        const machine::Kinematics* kinematics = nullptr;  ///< null: the machine has none that can be worked out
    };
    InUse at_line(std::int32_t line);

    struct Change {
        double time_s = 0;
        std::size_t index = 0;
        const machine::Tool* tool = nullptr;
    };
    /// Remembers when the tool in use changes.
    void note(double time_s, const InUse& in_use);
    const std::vector<Change>& changes() const { return changes_; }

  private:
    const machine::Tool* tool_of(const std::string& name) const;

    const program::Program* program_;
    const machine::Machine* machine_;
    const machine::Setup* setup_;
    std::unordered_map<std::int32_t, std::uint16_t> tool_by_line_;
    std::map<std::size_t, std::optional<machine::Kinematics>> kinematics_;
    std::size_t last_ = 0;
    std::vector<Change> changes_;
};

}  // namespace trunnion::report::detail
