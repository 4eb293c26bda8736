#include "play_session.hpp"

#include <array>
#include <charconv>
#include <csignal>
#include <cstdio>
#include <utility>

#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

namespace trunnion::app {

namespace {

using Clock = std::chrono::steady_clock;

constexpr int poll_ms = 1;

volatile std::sig_atomic_t stop_wanted = 0;

std::string_view next_word(std::string_view& line) {
    const auto begin = std::min(line.find_first_not_of(" \t\r"), line.size());
    line.remove_prefix(begin);
    const auto end = std::min(line.find_first_of(" \t\r"), line.size());
    const std::string_view out = line.substr(0, end);
    line.remove_prefix(end);
    return out;
}

Diagnostic unknown_command(std::string_view line) {
    return {.code = "RT0010",
            .text = "no such command",
            .value = std::string(line),
            .hint = "start, hold, resume, stop, single on|off, override PERCENT, rapid PERCENT"};
}

Result<PlayCommand> override_command(PlayCommandKind kind, std::string_view word, double largest,
                                     std::string_view line) {
    if (word.ends_with('%')) word.remove_suffix(1);
    double percent = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), percent);
    if (word.empty() || error != std::errc() || end != word.data() + word.size()) return fail(unknown_command(line));
    if (!(percent >= 0 && percent <= 100 * largest))
        return fail({.code = "PIPE0141",
                     .text = "override outside its range",
                     .value = fmt::format("{} %", percent),
                     .limit = fmt::format("0…{} %", 100 * largest)});
    return PlayCommand{kind, percent / 100};
}

double seconds_since(Clock::time_point begin) {
    return std::chrono::duration<double>(Clock::now() - begin).count();
}

}  // namespace

Result<PlayCommand> parse_play_command(std::string_view line) {
    std::string_view rest = line;
    const std::string_view word = next_word(rest), value = next_word(rest);
    const bool more = !next_word(rest).empty();
    constexpr std::array<std::pair<std::string_view, PlayCommandKind>, 4> plain{{{"start", PlayCommandKind::start},
                                                                                 {"hold", PlayCommandKind::hold},
                                                                                 {"resume", PlayCommandKind::resume},
                                                                                 {"stop", PlayCommandKind::stop}}};
    for (const auto& [name, kind] : plain)
        if (word == name && value.empty()) return PlayCommand{kind, 0};
    if (more) return fail(unknown_command(line));
    if (word == "single" && (value == "on" || value == "off"))
        return PlayCommand{PlayCommandKind::single, value == "on" ? 1.0 : 0.0};
    if (word == "override") return override_command(PlayCommandKind::override_feed, value, 2, line);
    if (word == "rapid") return override_command(PlayCommandKind::override_rapid, value, 1, line);
    return fail(unknown_command(line));
}

Result<RowRecord> RowRecord::create(const std::string& name, const machine::Machine& machine, double period_s) {
    RowRecord out;
    if (name.empty()) return out;
    auto file = files::OutputFile::create(name);
    if (!file) return fail(file.error());
    out.file_.emplace(std::move(*file));
    out.axes_ = machine.axis_count;
    out.period_s_ = period_s;
    std::string head = "t_s";
    for (int i = 0; i < machine.axis_count; ++i)
        head += fmt::format(",{}_{}", machine.axes[i].letter, machine.axes[i].rotary ? "deg" : "mm");
    out.file_->write(head + ",line\n");
    return out;
}

void RowRecord::add(const trunnion_row& row) {
    if (!file_) return;
    line_ = fmt::format("{}", static_cast<double>(rows_++) * period_s_);
    for (int i = 0; i < axes_; ++i) line_ += fmt::format(",{}", row.position[i]);
    line_ += fmt::format(",{}\n", row.line);
    file_->write(line_);
}

Result<void> RowRecord::commit() {
    return file_ ? file_->commit() : Result<void>();
}

PlayingSide::PlayingSide(const PlaySession& session, Process planner, RowSink& sink, RowRecord& record)
    : session_(session),
      planner_(planner),
      news_(planner.from),
      operator_(STDIN_FILENO),
      sink_(sink),
      record_(record),
      start_wanted_(!session.waits_for_start) {
    (void)trunnion_reader_begin(&reader_, session.plans);
}

int PlayingSide::run() {
    for (const int signal : {SIGINT, SIGTERM, SIGHUP}) std::signal(signal, [](int) { stop_wanted = 1; });
    std::signal(SIGPIPE, SIG_IGN);
    begin_ = command_ = Clock::now();
    while (!is_over()) {
        wait();
        take_commands();
        take_news();
        trunnion_look(&reader_);
        if (planned_ && !ready_) get_ready();
        if (start_wanted_ && ready_ && !started_ && !broken_) start();
        if (started_) move_on();
        look_at_machine();
    }
    take_news();
    const int status = report(wait_for(planner_));
    if (broken_ || !started_) return status;
    const auto finished = sink_.finish();
    return finished ? status : report_failure(finished.error());
}

/// Until there is news, at most so long that no period is missed.
void PlayingSide::wait() const {
    std::array<pollfd, 3> on{{{.fd = news_.descriptor(), .events = POLLIN, .revents = 0},
                              {.fd = operator_.ended() ? -1 : operator_.descriptor(), .events = POLLIN, .revents = 0},
                              {.fd = sink_.descriptor(), .events = POLLIN, .revents = 0}}};
    if (news_.ended()) on[0].fd = -1;
    poll(on.data(), on.size(), poll_ms);
}

void PlayingSide::take_commands() {
    if (stop_wanted != 0 && !stop_sent_) {
        stop_sent_ = true;
        obey("stop");
    }
    if (operator_.ended()) return;
    for (const std::string& line : operator_.lines())
        if (line.find_first_not_of(" \t\r") != std::string::npos) obey(line);
}

void PlayingSide::obey(const std::string& line) {
    const auto command = parse_play_command(line);
    if (!command) return print(command.error());
    if (command->kind == PlayCommandKind::start) {
        if (!start_wanted_) command_ = Clock::now();
        start_wanted_ = true;
        return;
    }
    if (!news_.ended()) write_line(planner_.to, line);
}

void PlayingSide::take_news() {
    for (const std::string& line : news_.lines()) show(line);
}

void PlayingSide::show(const std::string& line) {
    std::string_view rest = line;
    const std::string_view word = next_word(rest);
    if (!rest.empty()) rest.remove_prefix(1);
    if (word == "ready") {
        planned_ = true;
    } else if (word == "finished" || word == "stopped") {
        ended_well_ = true;
        if (word == "stopped") fmt::print(stderr, "stopped\n");
    } else if (word == "figures") {
        std::uint64_t rows = 0;
        std::sscanf(std::string(rest).c_str(), "%lu %lf %lu", &rows, &planner_s_, &missed_);
    } else {
        failed_ = failed_ || word == "error";
        if (word == "error" || !session_.job.quiet) fmt::print(stderr, "{}\n", rest);
        if (operator_.ended() && word == "news") answer_alone(rest.find(" waits: ") != std::string_view::npos);
    }
}

/// Nobody is there any more who could answer an event: what plays into nothing goes on, a machine that waits stops.
void PlayingSide::answer_alone(bool waits) {
    if (!sink_.moves_axes())
        obey("resume");
    else if (waits)
        obey("stop");
}

void PlayingSide::get_ready() {
    const trunnion_plan& plan = session_.plans->plan[reader_.in_use & 1];
    if (reader_.in_use == 0) return;
    ready_ = true;
    if (auto good = sink_.prepare(plan.rows[0]); !good) return break_off(good.error());
    if (!start_wanted_) fmt::print(stderr, "ready after {:.3f} s: `start` begins\n", seconds_since(begin_));
}

void PlayingSide::start() {
    started_ = true;
    stands_ = false;
    move_on();
    sink_.start();
}

void PlayingSide::break_off(const Diagnostic& error) {
    broken_ = true;
    print(error);
    if (!news_.ended()) write_line(planner_.to, "stop");
}

/// Gives the rows of the periods that are due.
void PlayingSide::move_on() {
    for (std::size_t room = sink_.room(); room > 0 && !broken_; --room) {
        trunnion_look(&reader_);
        const trunnion_row* row = trunnion_next_row(&reader_);
        stands_ = row == nullptr;
        if (stands_) {
            sink_.stand();
            break;
        }
        sink_.give(*row);
        record_.add(*row);
        ++rows_;
    }
    if (!begun_after_s_ && sink_.reached() > 1) begun_after_s_ = seconds_since(command_);
}

void PlayingSide::look_at_machine() {
    if (broken_) return;
    if (const auto good = sink_.watch(); !good) break_off(good.error());
}

/// The planner has ended and its last plan was played; or the machine has ended the motion.
bool PlayingSide::is_over() const {
    if (broken_) return true;
    return news_.ended() && (!started_ || (stands_ && sink_.reached() == rows_));
}

int PlayingSide::report(int planner_status) {
    if (const auto committed = record_.commit(); !committed) return report_failure(committed.error());
    if (broken_) return started_ ? not_usable : bad_input;
    if (failed_) return planner_status == own_fault ? own_fault : bad_input;
    if (!ended_well_) {
        print({.code = "RT0008",
               .text = "the planner ended before the program did; the axes came to the standstill of its last plan",
               .value = fmt::format("row {}", rows_)});
        return not_usable;
    }
    const double motion_s = static_cast<double>(rows_) * session_.workplace.options.period_s;
    fmt::print("{} rows, {:.3f} s of motion, begun {:.1f} ms after the command\n", rows_, motion_s,
               1e3 * begun_after_s_.value_or(0));
    fmt::print("planned in {:.3f} s of processor time, {:.1f} x faster than the motion; {} plans came too late\n",
               planner_s_, planner_s_ > 0 ? motion_s / planner_s_ : 0, missed_);
    return done;
}

}  // namespace trunnion::app
