#include "detail/worth.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "detail/replanning.hpp"
#include "detail/stopwatch.hpp"

namespace trunnion::pipeline {

namespace {

using GoOn = std::function<bool(double)>;

constexpr double more = 1.1, twice = 2;
constexpr double calm_for_nothing = 0.001;  // this weight costs less than 0.02 % of the time
constexpr double moves_at_all = 1e-9;       // of an axis: peak / limit of its velocity
constexpr const char* calm_name = "calm";

struct LimitQuestion {
    std::string what, change;
    LimitChange limits;
    std::optional<double> gradient_s;
};

struct ToleranceQuestion {
    std::string what;
    PlanOptions options;
};

bool asks_for_calm(const PlanOptions& options) {
    return options.feed.calm > (options.worth ? 0 : calm_for_nothing);
}

class Questions {
  public:
    Questions(const PlannedJob& job, const LimitGradients& gradients, const Summary& summary)
        : options_(job.options), gradients_(gradients) {
        if (options_.worth) {
            for (int axis = 0; axis < job.machine.axis_count; ++axis)
                if (summary.axes[axis].velocity_ratio > moves_at_all) ask_axis(axis, job.machine.axes[axis].letter);
            ask_feed();
            ask_limit_of_the_tool();
            ask_tolerances();
        }
        if (!asks_for_calm(options_)) return;
        LimitQuestion& question = ask(calm_name, "off");
        question.limits.feed.calm = 0;
    }

    std::vector<LimitQuestion> limits;
    std::vector<ToleranceQuestion> tolerances;

  private:
    LimitQuestion& ask(std::string what, std::string change) {
        limits.push_back({std::move(what), std::move(change), {.feed = options_.feed}, {}});
        return limits.back();
    }

    void ask_axis(int axis, char letter) {
        const feed::LimitWorth& worth = gradients_.axes[axis];
        const auto ask_for = [&](const char* what, double feed::LimitFactors::* factor, double time_by_log_s) {
            LimitQuestion& question = ask(fmt::format("{} {}", letter, what), "+10 %");
            question.limits.feed.factors[axis].*factor *= more;
            question.gradient_s = saved_by_more(time_by_log_s);
        };
        ask_for("velocity", &feed::LimitFactors::velocity, worth.velocity_s);
        ask_for("acceleration", &feed::LimitFactors::acceleration, worth.acceleration_s);
        ask_for("jerk", &feed::LimitFactors::jerk, worth.jerk_s);
    }

    void ask_feed() {
        LimitQuestion& question = ask("feed", "+10 %");
        question.limits.feed_factor = more;
        question.gradient_s = saved_by_more(gradients_.feed_s);
    }

    void ask_limit_of_the_tool() {
        const auto ask_for = [&](const char* what, double feed::FeedOptions::* limit, double factor,
                                 const char* change) {
            if (!std::isfinite(options_.feed.*limit)) return;
            ask(what, change).limits.feed.*limit *= factor;
        };
        ask_for("tip acceleration", &feed::FeedOptions::tip_acceleration_mm_s2, more, "+10 %");
        ask_for("tip jerk", &feed::FeedOptions::tip_jerk_mm_s3, more, "+10 %");
        ask_for("tool velocity", &feed::FeedOptions::turn_velocity_rad_s, more, "+10 %");
        ask_for("chord error", &feed::FeedOptions::chord_error_mm, twice, "x 2");
    }

    void ask_tolerances() {
        const auto ask_for = [&](const char* what, double smoothing::SmoothingOptions::* tolerance) {
            tolerances.push_back({what, options_});
            tolerances.back().options.smoothing.*tolerance *= twice;
        };
        using smoothing::SmoothingOptions;
        if (options_.smoothing.rounding == smoothing::Rounding::none) return;
        ask_for("tip tolerance", &SmoothingOptions::tip_tolerance_mm);
        if (options_.smoothing.flank_tolerance_mm > 0)
            ask_for("flank tolerance", &SmoothingOptions::flank_tolerance_mm);
        else
            ask_for("orientation tolerance", &SmoothingOptions::orientation_tolerance_rad);
    }

    static double saved_by_more(double time_by_log_s) { return 0.0 - time_by_log_s * (more - 1); }

    const PlanOptions& options_;
    const LimitGradients& gradients_;
};

/// Puts what was found into the summary.
class Answers {
  public:
    Answers(const PlannedJob& job, Summary& summary) : job_(job), summary_(summary) {}

    void add(const std::string& what, const std::string& change, const Result<double>& time_s,
             std::optional<double> gradient_s) {
        Worth out{what, change, {}, gradient_s};
        if (time_s)
            out.saves_s = summary_.cut_time_s + summary_.rapid_time_s - *time_s;
        else
            not_found(what, change, time_s.error());
        if (what == calm_name) summary_.calm.price_s = out.saves_s;
        if (job_.options.worth) summary_.worth.push_back(std::move(out));
    }

    void sort() {
        const auto saved = [](const Worth& w) { return w.saves_s.value_or(-std::numeric_limits<double>::infinity()); };
        std::stable_sort(summary_.worth.begin(), summary_.worth.end(),
                         [&](const Worth& a, const Worth& b) { return saved(a) > saved(b); });
    }

  private:
    void not_found(const std::string& what, const std::string& change, const Diagnostic& why) {
        summary_.diagnostics.push_back(
            {.code = "PIPE0103",
             .severity = Severity::warning,
             .text = fmt::format("what {} {} would be worth was not found: {} {}", what, change, why.code, why.text),
             .place = why.place,
             .value = why.value,
             .limit = why.limit});
    }

    const PlannedJob& job_;
    Summary& summary_;
};

Result<std::vector<Result<double>>> motion_times(const PlannedJob& job, const PlanOptions& options,
                                                 std::span<const LimitChange> changes, const GoOn& go_on) {
    WholeProgram program(job.program, job.machine, job.setup, {job.stands.begin(), job.stands.end()});
    StretchSource stretches(program, job.machine, options);
    return motion_times(stretches, job.machine, changes, options.threads, go_on);
}

Result<void> answer_limits(const PlannedJob& job, const std::vector<LimitQuestion>& questions, const GoOn& go_on,
                           Answers& answers) {
    std::vector<LimitChange> changes;
    changes.reserve(questions.size());
    for (const LimitQuestion& question : questions) changes.push_back(question.limits);
    const auto times_s = motion_times(job, job.options, changes, go_on);
    if (!times_s) return fail(times_s.error());
    for (std::size_t k = 0; k < questions.size(); ++k)
        answers.add(questions[k].what, questions[k].change, (*times_s)[k], questions[k].gradient_s);
    return {};
}

Result<void> answer(const PlannedJob& job, const ToleranceQuestion& question, const GoOn& go_on, Answers& answers) {
    const LimitChange same{.feed = job.options.feed};
    const auto times_s = motion_times(job, question.options, {&same, 1}, go_on);
    if (!times_s && times_s.error().code == "PIPE0002") return fail(times_s.error());
    answers.add(question.what, "x 2", times_s ? times_s->front() : Result<double>(fail(times_s.error())), {});
    return {};
}

}  // namespace

int most_replans(const PlannedJob& job) {
    constexpr int of_an_axis = 3, of_the_tool = 4, others = 3;  // feed and tolerances
    return (asks_for_calm(job.options) ? 1 : 0) +
           (job.options.worth ? of_an_axis * job.machine.axis_count + of_the_tool + others : 0);
}

Result<void> find_worth(const PlannedJob& job, const LimitGradients& gradients, const GoOn& go_on, Summary& summary) {
    if (job.options.feed.calm == 0) summary.calm.price_s = 0;
    const Stopwatch watch(summary.work.replan_s);
    const Questions questions(job, gradients, summary);
    const double limits = static_cast<double>(questions.limits.size());
    const double all = limits + static_cast<double>(questions.tolerances.size());
    Answers answers(job, summary);
    const auto part = [&](double begin, double count) {
        return [&go_on, begin, count, all](double share) { return go_on((begin + count * share) / all); };
    };
    if (!questions.limits.empty())
        if (auto done = answer_limits(job, questions.limits, part(0, limits), answers); !done) return done;
    double begin = limits;
    for (const ToleranceQuestion& question : questions.tolerances)
        if (auto done = answer(job, question, part(begin++, 1), answers); !done) return done;
    answers.sort();
    return {};
}

}  // namespace trunnion::pipeline
