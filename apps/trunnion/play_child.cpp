#include <algorithm>
#include <chrono>
#include <memory>

#include <fmt/format.h>
#include <poll.h>
#include <sys/resource.h>

#include "trunnion/pipeline/live_motion.hpp"

#include "play_planner.hpp"
#include "play_process.hpp"
#include "play_session.hpp"

namespace trunnion::app {

namespace {

using pipeline::LiveMotionStatus;

/// A plan may last so long, and take this share of the buffer; it is planned anew before it ends.
constexpr double longest_plan_s = 6, share_of_buffer = 0.7;
constexpr int poll_ms = 1;

double processor_s() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    const auto seconds = [](const timeval& t) {
        return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
    };
    return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

/// The planner's side of `play`: commands in, plans into the buffer, news out.
class PlanningSide {
  public:
    PlanningSide(pipeline::LiveMotion motion, const PlaySession& session, int commands, int news)
        : motion_(std::move(motion)),
          publisher_(
              motion_, [&](const auto& row) { return row_of(row, session.workplace.machine); }, *session.plans,
              session.lead_rows, session.kept_rows),
          commands_(commands),
          news_(news) {}

    Result<void> run();

  private:
    void obey(const std::string& line);
    void tell(const PlanPublisher::Advance& advance);
    void tell_status();
    void tell_figures();
    bool is_over() const { return status_ == LiveMotionStatus::finished || status_ == LiveMotionStatus::stopped; }

    pipeline::LiveMotion motion_;
    PlanPublisher publisher_;
    LineReader commands_;
    int news_;
    LiveMotionStatus status_ = LiveMotionStatus::moving, told_ = LiveMotionStatus::moving;
    std::string asked_;  // the events that wait for an answer
    double begin_s_ = processor_s();
};

Result<void> PlanningSide::run() {
    if (auto begun = publisher_.publish_begin(); !begun) return begun;
    for (bool ready = false;;) {
        for (const std::string& line : commands_.lines()) obey(line);
        if (commands_.ended()) return {};
        const auto advance = publisher_.advance();
        if (!advance) return fail(advance.error());
        tell(*advance);
        if (!ready) write_line(news_, "ready");
        ready = true;
        if (is_over() && publisher_.reader_stands()) break;
        pollfd wait{.fd = commands_.descriptor(), .events = POLLIN, .revents = 0};
        poll(&wait, 1, poll_ms);
    }
    tell_figures();
    write_line(news_, status_ == LiveMotionStatus::stopped ? "stopped" : "finished");
    return {};
}

/// The words were checked by who sends them.
void PlanningSide::obey(const std::string& line) {
    const auto command = parse_play_command(line);
    if (!command) return;
    switch (command->kind) {
        case PlayCommandKind::start:
            return;
        case PlayCommandKind::hold:
            return motion_.hold();
        case PlayCommandKind::resume:
            return motion_.resume();
        case PlayCommandKind::stop:
            return motion_.stop();
        case PlayCommandKind::single:
            return motion_.set_single_block(command->value > 0);
        case PlayCommandKind::override_feed:
            (void)motion_.set_feed_override(command->value);
            return;
        case PlayCommandKind::override_rapid:
            (void)motion_.set_rapid_override(command->value);
            return;
    }
}

void PlanningSide::tell(const PlanPublisher::Advance& advance) {
    for (const program::Event& event : advance.events) {
        write_line(news_, fmt::format("news line {}: {}", event.line, event.word));
        if (event.stops_motion && event.dwell_s <= 0) asked_ = event.word;
    }
    status_ = advance.status;
    if (status_ == LiveMotionStatus::moving) told_ = LiveMotionStatus::moving;
    tell_status();
}

/// A standstill is told when the axes have come to it.
void PlanningSide::tell_status() {
    if (status_ == told_ || !publisher_.reader_stands()) return;
    told_ = status_;
    if (status_ == LiveMotionStatus::event)
        write_line(news_, fmt::format("news {} waits: `resume` when it is done", asked_));
    if (status_ == LiveMotionStatus::standing) write_line(news_, "news stands: `resume` goes on");
}

void PlanningSide::tell_figures() {
    write_line(news_,
               fmt::format("figures {} {} {}", publisher_.rows(), processor_s() - begin_s_, publisher_.missed()));
    for (const Diagnostic& met : motion_.diagnostics()) write_line(news_, "note " + to_string(met));
}

Result<void> plan_for(const PlaySession& session, int commands, int news) {
    const auto& workplace = session.workplace;
    const auto parts = open_program(session.job, workplace);
    if (!parts) return fail(parts.error());
    const auto rows = static_cast<double>(TRUNNION_PLAN_ROWS - session.kept_rows);
    const double longest_s = std::min(longest_plan_s, share_of_buffer * rows * workplace.options.period_s);
    auto motion = pipeline::LiveMotion::make(**parts, workplace.machine, workplace.setup, workplace.options, longest_s);
    if (!motion) return fail(motion.error());
    return PlanningSide(std::move(*motion), session, commands, news).run();
}

}  // namespace

int run_planning_side(const PlaySession& session, int commands, int news) {
    const auto done = plan_for(session, commands, news);
    if (done) return 0;
    write_line(news, fmt::format("error {}", to_string(done.error())));
    return bad_input;
}

}  // namespace trunnion::app
