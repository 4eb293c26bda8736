#pragma once

#include <cstdio>

#include <fmt/format.h>
#include <unistd.h>

namespace trunnion::app {

/// The share done, on a terminal: one line, written anew with every percent and wiped at the end.
class ProgressLine {
  public:
    explicit ProgressLine(bool quiet) : visible_(!quiet && isatty(STDERR_FILENO) != 0) {}
    ~ProgressLine() {
        if (shown_ >= 0) fmt::print(stderr, "\r{:<16}\r", "");
    }
    ProgressLine(const ProgressLine&) = delete;
    ProgressLine& operator=(const ProgressLine&) = delete;

    void show(double share) {
        const int percent = static_cast<int>(100 * share);
        if (!visible_ || percent == shown_) return;
        shown_ = percent;
        fmt::print(stderr, "\r{:3} % planned", percent);
    }

  private:
    bool visible_;
    int shown_ = -1;
};

}  // namespace trunnion::app
