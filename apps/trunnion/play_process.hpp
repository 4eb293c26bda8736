#pragma once

#include <functional>
#include <string>
#include <vector>

#include <plan_buffer.h>
#include <sys/types.h>

#include "trunnion/base/result.hpp"

namespace trunnion::app {

/// Lines over a pipe, written and read without waiting.
class LineReader {
  public:
    explicit LineReader(int descriptor) : descriptor_(descriptor) {}
    int descriptor() const { return descriptor_; }
    /// The lines that are complete by now.
    std::vector<std::string> lines();
    /// Whether the other end is closed and all was read.
    bool ended() const { return ended_; }

  private:
    int descriptor_;
    std::string rest_;
    bool ended_ = false;
};

void write_line(int descriptor, std::string line);

/// A plan buffer that processes see: by fork(), and by the descriptor in a program that is started.
struct SharedPlans {
    trunnion_plans* plans = nullptr;  ///< null: no memory
    int descriptor = -1;
};
SharedPlans share_plans();

/// A process of ours, with a pipe each way.
struct Process {
    pid_t id = -1;
    int to = -1, from = -1;
};

/// Forks: `work` in the child with the pipes' other ends, its result the exit status. The child ends with its parent,
/// and does not see the keyboard's Ctrl-C. Precondition: no thread was started. Errors: RT0012.
Result<Process> fork_process(const std::function<int(int from_parent, int to_parent)>& work);
/// Starts a program with stdin and stdout as pipes; it sees from the end of its stdin that we have ended, and does not
/// see the keyboard's Ctrl-C. Errors: RT0012.
Result<Process> start_program(const std::vector<std::string>& words);
/// Closes the pipes and waits for the end. The exit status; −1: it was killed.
int wait_for(Process& process);

}  // namespace trunnion::app
