#pragma once

#include <vector>

#include "trunnion/motion/controller.hpp"
#include "trunnion/motion/prediction.hpp"
#include "trunnion/program/program.hpp"

#include "detail/block_profile.hpp"

namespace trunnion::controller {

/// The controllers that the one at hand may be in truth: each parameter that is not identified at both ends of its
/// spread, the others as they are; and what the program takes with each.
class Doubts {
  public:
    Doubts(const motion::Controller& controller, const program::Program& program);

    /// Plans a run again with every one of them.
    void add(const path::Run& run, const RunGeometry& geometry, const machine::Machine& machine);
    /// Fills uncertainty and doubts.
    void finish(motion::Prediction& prediction) const;

  private:
    struct Variant {
        motion::ParameterId id;
        motion::Controller controller;
        double time_s = 0;
    };
    void add_pair(const motion::Controller& controller, motion::ParameterId id, double low, double high,
                  const program::Program& program);

    std::vector<Variant> variants_;  // low, high, low, high, …
    BlockPlanner planner_;
};

/// What weighs most first; the uncertainty is the root of the sum of the squares of the half differences.
void sum_up_doubts(motion::Prediction& prediction);

}  // namespace trunnion::controller
