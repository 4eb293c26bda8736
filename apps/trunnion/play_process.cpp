#include "play_process.hpp"

#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "commands.hpp"

namespace trunnion::app {

namespace {

struct Pipes {
    std::array<int, 2> down{}, up{};  // read end, write end
};

Diagnostic no_process() {
    return {.code = "RT0012", .text = fmt::format("no process or pipe: {}", std::strerror(errno))};
}

Result<Pipes> make_pipes() {
    Pipes out;
    if (pipe2(out.down.data(), O_CLOEXEC) != 0 || pipe2(out.up.data(), O_CLOEXEC) != 0) return fail(no_process());
    return out;
}

Process parents_ends(const Pipes& pipes, pid_t child) {
    close(pipes.down[0]);
    close(pipes.up[1]);
    return {.id = child, .to = pipes.down[1], .from = pipes.up[0]};
}

/// In the child: what the terminal or a group is told is told to the parent.
void leave_terminal() {
    for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGPIPE}) std::signal(signal, SIG_IGN);
}

}  // namespace

std::vector<std::string> LineReader::lines() {
    std::array<char, 4096> bytes;
    pollfd there{.fd = descriptor_, .events = POLLIN, .revents = 0};
    while (!ended_ && poll(&there, 1, 0) > 0) {
        const ssize_t got = read(descriptor_, bytes.data(), bytes.size());
        ended_ = got == 0;
        if (got > 0) rest_.append(bytes.data(), static_cast<std::size_t>(got));
    }
    std::vector<std::string> out;
    for (std::size_t end = 0; (end = rest_.find('\n')) != std::string::npos; rest_.erase(0, end + 1))
        out.push_back(rest_.substr(0, end));
    return out;
}

void write_line(int descriptor, std::string line) {
    line += '\n';
    (void)!write(descriptor, line.data(), line.size());
}

SharedPlans share_plans() {
    SharedPlans out;
    out.descriptor = memfd_create("trunnion-plans", 0);
    if (out.descriptor < 0 || ftruncate(out.descriptor, sizeof(trunnion_plans)) != 0) return out;
    void* const memory = mmap(nullptr, sizeof(trunnion_plans), PROT_READ | PROT_WRITE, MAP_SHARED, out.descriptor, 0);
    if (memory != MAP_FAILED) out.plans = static_cast<trunnion_plans*>(memory);
    return out;
}

Result<Process> fork_process(const std::function<int(int, int)>& work) {
    const auto pipes = make_pipes();
    if (!pipes) return fail(pipes.error());
    std::fflush(nullptr);
    const pid_t child = fork();
    if (child < 0) return fail(no_process());
    if (child > 0) return parents_ends(*pipes, child);
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    leave_terminal();
    close(pipes->down[1]);
    close(pipes->up[0]);
    int status = own_fault;
    try {
        status = work(pipes->down[0], pipes->up[1]);
    } catch (const std::exception& error) {
        write_line(pipes->up[1], fmt::format("error {} error: {}", static_cast<int>(own_fault), error.what()));
    }
    _exit(status);
}

Result<Process> start_program(const std::vector<std::string>& words) {
    const auto pipes = make_pipes();
    if (!pipes) return fail(pipes.error());
    std::fflush(nullptr);
    const pid_t child = fork();
    if (child < 0) return fail(no_process());
    if (child > 0) return parents_ends(*pipes, child);
    leave_terminal();
    std::vector<char*> arguments;
    for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
    arguments.push_back(nullptr);
    dup2(pipes->down[0], STDIN_FILENO);
    dup2(pipes->up[1], STDOUT_FILENO);
    execvp(arguments.front(), arguments.data());
    _exit(127);
}

int wait_for(Process& process) {
    if (process.id < 0) return 0;
    close(process.to);
    close(process.from);
    int status = 0;
    waitpid(process.id, &status, 0);
    process.id = -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

}  // namespace trunnion::app
