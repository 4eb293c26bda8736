#include "trunnion/controller/linuxcnc.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "trunnion/base/quantity.hpp"

#include "detail/linuxcnc_planner.hpp"
#include "detail/linuxcnc_reading.hpp"

namespace trunnion::controller {

using namespace linuxcnc;

namespace {

constexpr double moves_more_than = 1e-9;  ///< mm, deg from row to row
constexpr std::size_t read_ahead = 8;     ///< commands ready at least, while the program has any

Diagnostic bad_setting(std::string name) {
    return {.code = "CTRL0107", .text = "a setting without meaning", .value = std::move(name)};
}

Result<void> check(const LinuxcncSettings& settings) {
    const auto positive = [](double value) { return value > 0; };
    if (!positive(settings.servo_period_s) || settings.servo_period_s > 1) return fail(bad_setting("servo period"));
    if (!positive(settings.max_linear_velocity_mm_s)) return fail(bad_setting("MAX_LINEAR_VELOCITY"));
    if (!positive(settings.max_feed_override)) return fail(bad_setting("MAX_FEED_OVERRIDE"));
    if (!positive(settings.feed_override) || settings.feed_override > settings.max_feed_override)
        return fail(bad_setting("feed override"));
    if (!positive(settings.rapid_override) || settings.rapid_override > 1) return fail(bad_setting("rapid override"));
    if (settings.optimization_depth < 0) return fail(bad_setting("ARC_BLEND_OPTIMIZATION_DEPTH"));
    if (!(settings.gap_cycles >= 0)) return fail(bad_setting("ARC_BLEND_GAP_CYCLES"));
    if (!positive(settings.ramp_frequency_hz)) return fail(bad_setting("ARC_BLEND_RAMP_FREQ"));
    if (!positive(settings.kink_ratio)) return fail(bad_setting("ARC_BLEND_KINK_RATIO"));
    if (!(settings.missed_periods >= 0) || !(settings.missed_periods < 1)) return fail(bad_setting("missed periods"));
    if (!(std::abs(settings.unset_direction_cosine) <= 1)) return fail(bad_setting("unset direction"));
    if (settings.queue_full < 2) return fail(bad_setting("queue"));
    if (!positive(settings.longest_run_s) || settings.longest_run_s > 1e9) return fail(bad_setting("longest run"));
    if (!(settings.start_tolerance_mm >= 0)) return fail(bad_setting("start tolerance"));
    for (const double wait : settings.waits.seconds)
        if (!(wait >= 0) || wait > 3600) return fail(bad_setting("waits"));
    return {};
}

/// Of the letters X Y Z A B C; a letter that the machine has not never moves.
Result<Limits> limits_of(const machine::Machine& machine, const LinuxcncSettings& settings) {
    Limits limits;
    limits.velocity.fill(1);
    limits.acceleration.fill(1);
    for (const auto& [letter, unused] : settings.axis_limits)
        if (machine.index_of(letter) < 0) return fail(bad_setting(std::string("limits of ") + letter));
    for (int i = 0; i < machine.axis_count; ++i) {
        const machine::Axis& axis = machine.axes[static_cast<std::size_t>(i)];
        LinuxcncSettings::AxisLimits given;
        if (const auto found = settings.axis_limits.find(axis.letter); found != settings.axis_limits.end())
            given = found->second;
        const double velocity = given.velocity.value_or(axis.feed.velocity);
        const double acceleration = given.acceleration.value_or(axis.feed.acceleration);
        if (!(velocity > 0) || !(acceleration > 0)) return fail(bad_setting(std::string("limits of ") + axis.letter));
        const auto slot = static_cast<std::size_t>(axis.rotary ? 3 + axis.letter - 'A' : axis.letter - 'X');
        const double unit = axis.rotary ? degree : 1;
        limits.velocity[slot] = velocity / unit;
        limits.acceleration[slot] = acceleration / unit;
    }
    return limits;
}

/// What the joints get: a cubic spline through the positions of the last three periods.
class JointSmoother {
  public:
    explicit JointSmoother(const machine::AxisPosition& position) : last_{position, position, position} {}
    machine::AxisPosition next(const machine::AxisPosition& position) {
        machine::AxisPosition out;
        for (std::size_t i = 0; i < machine::max_axes; ++i) out[i] = (last_[0][i] + 4 * last_[1][i] + last_[2][i]) / 6;
        last_ = {last_[1], last_[2], position};
        return out;
    }

  private:
    std::array<machine::AxisPosition, 3> last_;
};

/// Runs one program: commands into the planner, periods out of it.
class Control {
  public:
    Control(Reading reading, const LinuxcncSettings& settings, const Limits& limits, const machine::Machine& machine,
            const std::function<void(const LinuxcncRow&)>& each_row)
        : reading_(std::move(reading)),
          settings_(settings),
          machine_(machine),
          each_row_(each_row),
          canonical_(limits, settings.start_tolerance_mm),
          planner_(settings, limits) {}

    Result<LinuxcncRun> run();

  private:
    Result<void> read_ahead_in_program();
    bool take_command();
    void start_waiting(const Command& command);
    void go_on_after_waiting();
    bool misses_this_period();
    motion::Limit limit_of(Hold hold) const;
    void one_period();
    void write_row(const machine::AxisPosition& axes);
    void note_motion(const machine::AxisPosition& axes);
    double now_s() const { return static_cast<double>(run_.rows) * settings_.servo_period_s; }

    Reading reading_;
    const LinuxcncSettings& settings_;
    const machine::Machine& machine_;
    const std::function<void(const LinuxcncRow&)>& each_row_;
    Canonical canonical_;
    Planner planner_;
    LinuxcncRun run_;
    std::size_t geometry_ = 0;
    std::size_t waiting_ = 0;  // periods
    double missed_ = 0;        // share of a period that is still to be missed
    bool moved_ = false;
    /// Where motion stands; it counts when motion goes on.
    struct Wait {
        double dwell_s = 0, tool_change_s = 0, other_stop_s = 0;
        std::array<std::size_t, linuxcnc_wait_count> words{};
    } wait_;
    machine::AxisPosition axes_;
    machine::AxisVelocity velocity_;
    std::optional<JointSmoother> smoother_;
    bool planner_moves_ = false;
    std::optional<std::size_t> first_moving_;  // rows
    std::size_t last_moving_ = 0;
};

Result<void> Control::read_ahead_in_program() {
    while (canonical_.commands.size() < read_ahead && !reading_.at_end())
        if (auto good = reading_.read_on(canonical_); !good) return good;
    return {};
}

bool Control::misses_this_period() {
    missed_ += settings_.missed_periods;
    if (missed_ < 1) return false;
    missed_ -= 1;
    return true;
}

/// At most one command a period. False: nothing is left to do.
bool Control::take_command() {
    auto& commands = canonical_.commands;
    if (waiting_ > 0) {
        --waiting_;
        return true;
    }
    if (commands.empty()) {
        planner_.nothing_follows();
        return !planner_.idle();
    }
    Command& command = commands.front();
    if (command.kind == Command::Kind::wait || command.kind == Command::Kind::geometry) planner_.nothing_follows();
    switch (command.kind) {
        case Command::Kind::segment:
            if (planner_.full() || misses_this_period()) return true;
            go_on_after_waiting();
            planner_.add(std::move(command.segment));
            break;
        case Command::Kind::mode:
            break;
        case Command::Kind::wait:
            if (!planner_.idle()) return true;
            start_waiting(command);
            break;
        case Command::Kind::geometry:
            if (!planner_.idle()) return true;
            planner_.stand_at(command.position);
            geometry_ = command.geometry;
            break;
    }
    commands.pop_front();
    return true;
}

/// The period in which it begins is one of them.
void Control::start_waiting(const Command& command) {
    const double asked_s = command.dwell_s + command.answer_s;
    const double counted_s = std::min(asked_s, 2 * settings_.longest_run_s);  // which ends in a refusal
    const auto periods = static_cast<std::size_t>(std::llround(counted_s / settings_.servo_period_s));
    waiting_ = periods > 0 ? periods - 1 : 0;
    const double waited_s = static_cast<double>(periods) * settings_.servo_period_s;
    const bool tool = command.word == LinuxcncWait::tool_change || command.word == LinuxcncWait::tool_preparation;
    const double dwell_s = command.word == LinuxcncWait::dwell ? waited_s : std::min(command.dwell_s, waited_s);
    wait_.dwell_s += dwell_s;
    (tool ? wait_.tool_change_s : wait_.other_stop_s) += waited_s - dwell_s;
    ++wait_.words[static_cast<std::size_t>(command.word)];
}

/// What stood before the first motion does not count.
void Control::go_on_after_waiting() {
    if (moved_) {
        run_.dwell_s += wait_.dwell_s;
        run_.tool_change_s += wait_.tool_change_s;
        run_.other_stop_s += wait_.other_stop_s;
        for (std::size_t i = 0; i < linuxcnc_wait_count; ++i) run_.waits[i] += wait_.words[i];
    }
    moved_ = true;
    wait_ = {};
}

Result<LinuxcncRun> Control::run() {
    if (auto good = reading_.start(canonical_); !good) return fail(good.error());
    take_command();
    axes_ = reading_.axes_at(planner_.position(), geometry_);
    smoother_.emplace(axes_);
    write_row(axes_);
    for (;;) {
        if (auto good = read_ahead_in_program(); !good) return fail(good.error());
        if (!take_command()) break;
        one_period();
        if (now_s() > settings_.longest_run_s)
            return fail({.code = "CTRL0112",
                         .text = "the program takes longer than is run",
                         .place = {.line = planner_.line()},
                         .limit = fmt::format("{} s", settings_.longest_run_s)});
    }
    for (int i = 0; i < 3; ++i) one_period();
    if (!first_moving_) return fail({.code = "CTRL0108", .text = "nothing moves"});
    run_.cycle_time_s = static_cast<double>(last_moving_ - *first_moving_ + 1) * settings_.servo_period_s;
    run_.length_over_feed_s = canonical_.length_over_feed_s;
    run_.segments = canonical_.segments;
    run_.arc_blends = planner_.arc_blends();
    run_.standstills = planner_.standstills();
    run_.unset_directions = planner_.unset_directions();
    return std::move(run_);
}

motion::Limit Control::limit_of(Hold hold) const {
    motion::Limit out{.kind = hold.kind};
    if (hold.slot >= 0) out.axis = static_cast<std::int8_t>(machine_.index_of("XYZABC"[hold.slot]));
    return out;
}

void Control::one_period() {
    planner_moves_ = !planner_.idle();
    planner_.run_period(now_s(), run_.blocks);
    write_row(smoother_->next(reading_.axes_at(planner_.position(), geometry_)));
}

void Control::write_row(const machine::AxisPosition& axes) {
    if (run_.rows > 0) note_motion(axes);
    if (each_row_) {
        LinuxcncRow row{.time_s = now_s(), .tip_mm = planner_.position().linear_mm, .axes = axes};
        for (int i = 0; i < 3; ++i)
            row.rotary_rad[static_cast<std::size_t>(i)] = planner_.position().rotary_deg[i] * degree;
        row.speed_mm_s = planner_.speed() * (planner_.turns_only() ? degree : 1);
        row.line = planner_.line();
        row.moves = planner_moves_;
        row.limit = limit_of(planner_.hold());
        row.slower_end = limit_of(planner_.slower_end());
        each_row_(row);
    }
    axes_ = axes;
    ++run_.rows;
}

void Control::note_motion(const machine::AxisPosition& axes) {
    bool moves = false;
    for (int i = 0; i < machine_.axis_count; ++i) {
        const auto axis = static_cast<std::size_t>(i);
        const double step = axes[axis] - axes_[axis];
        moves |= std::abs(step) > moves_more_than * (machine_.axes[axis].rotary ? degree : 1);
        const double velocity = step / settings_.servo_period_s;
        const double acceleration = (velocity - velocity_[axis]) / settings_.servo_period_s;
        velocity_[axis] = velocity;
        run_.peak_velocity[axis] = std::max(run_.peak_velocity[axis], std::abs(velocity));
        run_.peak_acceleration[axis] = std::max(run_.peak_acceleration[axis], std::abs(acceleration));
    }
    if (!moves) return;
    if (!first_moving_) first_moving_ = run_.rows;
    last_moving_ = run_.rows;
}

}  // namespace

Result<LinuxcncSettings> linuxcnc_settings(const motion::Controller& controller) {
    using motion::ParameterId;
    if (controller.arc_blend_fallback_enable.way == motion::Switch::on)
        return fail({.code = "CTRL0113",
                     .text = "arc_blend_fallback_enable is on: how LinuxCNC then blends is not modelled",
                     .place = {.file = controller.file},
                     .hint = "off is the default of its INI file"});
    LinuxcncSettings out;
    const auto take = [&](ParameterId id, double& value) {
        if (controller[id].given) value = controller[id].value;
    };
    double depth = out.optimization_depth;
    take(ParameterId::servo_period, out.servo_period_s);
    take(ParameterId::max_linear_velocity, out.max_linear_velocity_mm_s);
    take(ParameterId::max_feed_override, out.max_feed_override);
    take(ParameterId::arc_blend_optimization_depth, depth);
    take(ParameterId::arc_blend_gap_cycles, out.gap_cycles);
    take(ParameterId::arc_blend_ramp_freq, out.ramp_frequency_hz);
    take(ParameterId::arc_blend_kink_ratio, out.kink_ratio);
    take(ParameterId::missed_command_periods, out.missed_periods);
    take(ParameterId::spindle_time, out.waits[LinuxcncWait::spindle]);
    take(ParameterId::other_stop_time, out.waits[LinuxcncWait::other]);
    take(ParameterId::dwell_excess, out.waits[LinuxcncWait::dwell]);
    take(ParameterId::coolant_time, out.waits[LinuxcncWait::coolant]);
    take(ParameterId::tool_change_time, out.waits[LinuxcncWait::tool_change]);
    take(ParameterId::tool_preparation_time, out.waits[LinuxcncWait::tool_preparation]);
    out.optimization_depth = static_cast<int>(depth);
    out.arc_blends = controller.arc_blend_enable.way == motion::Switch::on;
    for (const auto& [letter, limits] : controller.axis_limits) {
        const auto given = [&](motion::AxisLimitId id) {
            const motion::Parameter& limit = limits[static_cast<std::size_t>(id)];
            return limit.given ? std::optional(limit.value) : std::nullopt;
        };
        out.axis_limits[letter] = {given(motion::AxisLimitId::max_velocity),
                                   given(motion::AxisLimitId::max_acceleration)};
    }
    return out;
}

Result<LinuxcncRun> run_as_linuxcnc(const program::Program& program, const machine::Machine& machine,
                                    const machine::Setup& setup, const LinuxcncSettings& settings,
                                    const std::function<void(const LinuxcncRow&)>& each_row) {
    if (auto good = check(settings); !good) return fail(good.error());
    auto reading = Reading::make(program, machine, setup, settings.waits);
    if (!reading) return fail(reading.error());
    auto limits = limits_of(machine, settings);
    if (!limits) return fail(limits.error());
    return Control(std::move(*reading), settings, *limits, machine, each_row).run();
}

}  // namespace trunnion::controller
