#include <array>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <exception>
#include <new>

#include <fcntl.h>
#include <unistd.h>

#include "commands.hpp"

namespace {

int run(int argc, char** argv) {
    using namespace trunnion::app;
    int status = done;
    CLI::App app("Trunnion: from a 5-axis part program to motion that the machine can really make.", "trunnion");
    app.set_version_flag("--version", "trunnion " TRUNNION_VERSION);
    app.require_subcommand(1);
    app.footer(
        "Lengths, angles, feeds and times carry their unit: 20um, 0.1deg, 20m/min, 1ms.\n"
        "Exit status: 0 done, 1 done but a limit or tolerance is broken, 2 bad input or usage, 3 a fault of ours.");
    add_plan_command(app, status);
    add_play_command(app, status);
    add_serve_command(app, status);
    add_check_command(app, status);
    add_predict_command(app, status);
    add_convert_command(app, status);
    add_smooth_command(app, status);
    add_deform_command(app, status);
    add_surface_command(app, status);
    add_report_command(app, status);
    add_machine_command(app, status);
    add_controller_command(app, status);
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        return app.exit(error) == 0 ? done : bad_input;
    }
    return status;
}

/// As a diagnostic is printed, with what a signal handler and a program without memory may do.
void say_error(const char* code, const char* text) noexcept {
    for (const char* part : {"error ", code, ": ", text, "\n"})
        if (::write(STDERR_FILENO, part, std::strlen(part)) < 0) return;
}

[[noreturn]] void leave(const char* code, const char* text, trunnion::app::ExitStatus status) noexcept {
    say_error(code, text);
    ::_exit(status);
}

[[noreturn]] void leave_without_memory() noexcept {
    leave("PIPE0007", "out of memory", trunnion::app::own_fault);
}

/// Unfinished outputs have no name yet (files::OutputFile), so ending at once leaves nothing of them. Commands that
/// can end in good order have their own handler.
void answer_signals() {
    const auto before = std::signal(SIGINT, [](int) { leave("PIPE0002", "cancelled", trunnion::app::interrupted); });
    if (before == SIG_IGN) std::signal(SIGINT, SIG_IGN);
    std::signal(SIGBUS, [](int) {
        leave("NC0001", "the program file became shorter while it was read", trunnion::app::bad_input);
    });
}

/// Libraries that do not look whether they got the memory they asked for; also a stack that is used up, so the answer
/// has a stack of its own. A sanitizer that answers itself is left alone.
void answer_wrong_access() {
    static std::array<char, 1 << 16> stack;
    struct sigaction answer{}, before{};
    if (::sigaction(SIGSEGV, nullptr, &before) != 0 || before.sa_handler != SIG_DFL) return;
    const stack_t own{.ss_sp = stack.data(), .ss_flags = 0, .ss_size = stack.size()};
    ::sigaltstack(&own, nullptr);
    answer.sa_flags = SA_ONSTACK;
    answer.sa_handler = [](int) {
        leave("PIPE0008", "a fault of ours: wrong access to memory, or none was left", trunnion::app::own_fault);
    };
    ::sigaction(SIGSEGV, &answer, nullptr);
}

/// Where no memory is left in a thread, or in a function that cannot throw.
[[noreturn]] void terminated() noexcept {
    try {
        if (const auto thrown = std::current_exception()) std::rethrow_exception(thrown);
    } catch (const std::bad_alloc&) {
        leave_without_memory();
    } catch (...) {
        leave("PIPE0008", "a fault of ours: something was thrown where nothing may be", trunnion::app::own_fault);
    }
    leave("PIPE0008", "a fault of ours: the program was ended", trunnion::app::own_fault);
}

/// A stream that the caller closed is one that nobody reads. Without this the first output file would take its number.
void open_closed_streams() {
    for (int stream = STDIN_FILENO; stream <= STDERR_FILENO; ++stream)
        if (::fcntl(stream, F_GETFD) < 0) ::open("/dev/null", O_RDWR);
}

/// What was printed must have arrived.
int flushed(int status) {
    if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return status;
    say_error("FILE0202", "what was to be printed cannot be written");
    return trunnion::app::bad_input;
}

int run_guarded(int argc, char** argv) {
    try {
        return flushed(run(argc, argv));
    } catch (const std::bad_alloc&) {
        leave_without_memory();
    } catch (const std::exception& error) {
        if (std::ferror(stdout) != 0) return flushed(trunnion::app::bad_input);
        say_error("PIPE0008", error.what());
        return trunnion::app::own_fault;
    }
}

}  // namespace

int main(int argc, char** argv) {
    open_closed_streams();
    answer_signals();
    answer_wrong_access();
    std::set_terminate(terminated);
    return run_guarded(argc, argv);
}
