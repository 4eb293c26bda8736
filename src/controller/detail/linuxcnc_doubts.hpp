#pragma once

#include "trunnion/controller/linuxcnc.hpp"
#include "trunnion/motion/controller.hpp"
#include "trunnion/motion/prediction.hpp"

namespace trunnion::controller {

/// How far LinuxCNC's cycle time may be from what its model says: by parameters that are not identified, by what the
/// last digits of a number decide where arcs blend short segments, and by a direction that the control reads where
/// nobody has set it. Each is tried at both ends, the others as they are.
class LinuxcncDoubts {
  public:
    LinuxcncDoubts(const program::Program& program, const machine::Machine& machine, const machine::Setup& setup,
                   const motion::Controller& controller, const LinuxcncSettings& settings, const LinuxcncRun& run)
        : program_(program),
          machine_(machine),
          setup_(setup),
          controller_(controller),
          settings_(settings),
          run_(run) {}

    /// Fills uncertainty and doubts. Cost: some runs more; waits for words need none.
    void find(motion::Prediction& prediction) const;

  private:
    double time_with(const LinuxcncSettings& settings) const;
    double time_with(std::size_t parameter, double value) const;
    double waits_with(std::size_t parameter) const;
    void vary_parameters(motion::Prediction& prediction) const;
    void vary_last_digits(motion::Prediction& prediction) const;
    void vary_unset_direction(motion::Prediction& prediction) const;

    const program::Program& program_;
    const machine::Machine& machine_;
    const machine::Setup& setup_;
    const motion::Controller& controller_;
    const LinuxcncSettings& settings_;
    const LinuxcncRun& run_;
};

}  // namespace trunnion::controller
