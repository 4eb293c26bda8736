#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace trunnion::pipeline {

/// The median of how much block transitions use of their tolerance (0 … 1, more counts as most), as a tally of classes
/// 0.0001 wide: the same memory for any number of blocks.
class TransitionUse {
  public:
    void add(double use) {
        if (tally_.empty()) tally_.resize(classes + 1);
        ++tally_[static_cast<std::size_t>(std::clamp(use, 0.0, most) / most * classes)];
        ++count_;
    }
    /// The middle of its class; 0 where there was no transition.
    double median() const {
        std::size_t up_to = 0;
        for (std::size_t k = 0; k < tally_.size(); ++k)
            if ((up_to += tally_[k]) > count_ / 2) return k == 0 ? 0 : (static_cast<double>(k) + 0.5) * most / classes;
        return 0;
    }

  private:
    static constexpr double most = 1.1;
    static constexpr std::size_t classes = 11000;
    std::vector<std::size_t> tally_;
    std::size_t count_ = 0;
};

}  // namespace trunnion::pipeline
