#include <algorithm>
#include <cmath>
#include <iterator>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "trunnion/base/quantity.hpp"
#include "trunnion/files/linuxcnc_machine.hpp"

#include "detail/exact_number.hpp"
#include "detail/linuxcnc_kinematics.hpp"

namespace trunnion::files {

using detail::LinuxcncKinematics;
using machine::Axis;
using machine::AxisLimits;
using machine::Machine;

namespace {

/// Joints and loop-back agree to rounding; the drives of a real machine need more.
constexpr double following_error = 0.01;  // mm, deg

class Export {
  public:
    Export(const Machine& machine, std::string_view stem, const LinuxcncExport& options)
        : machine_(machine), stem_(stem), options_(options) {}
    Result<LinuxcncConfiguration> operator()();

  private:
    Diagnostic refusal(std::string code, std::string text, std::string hint = {}) const;
    Result<void> check_options() const;
    Result<void> find_kinematics();
    Result<void> check_axis(const Axis& axis) const;
    std::string ini() const;
    std::string axis_sections(int joint) const;
    std::string trunnion_section() const;
    std::string hal() const;
    std::string hal_of_joint(int joint) const;
    std::string for_joints(std::string_view words, std::string_view between) const;
    std::string hal_of_thread() const;
    std::string hal_of_playing() const;
    std::string hal_of_kinematics() const;
    double together(bool rotary, double AxisLimits::* limit) const;

    const Machine& machine_;
    std::string stem_;
    LinuxcncExport options_;
    const LinuxcncKinematics* kinematics_ = nullptr;
};

double unit_of(const Axis& axis) {
    return axis.rotary ? degree : 1;
}

std::string number(double value, const Axis& axis) {
    return detail::number_in_unit(value, unit_of(axis));
}

/// In one line: what has line breaks would go on as something else.
std::string one_line(std::string text) {
    std::ranges::replace_if(text, [](char c) { return static_cast<unsigned char>(c) < ' '; }, ' ');
    return text;
}

std::string letters_of_chain(const Machine& machine) {
    std::string out;
    for (int i = 0; i < machine.axis_count; ++i)
        out += machine.axes[static_cast<std::size_t>(machine.chain[static_cast<std::size_t>(i)])].letter;
    return out;
}

Diagnostic Export::refusal(std::string code, std::string text, std::string hint) const {
    Diagnostic out{.code = std::move(code), .text = std::move(text), .place = {.file = machine_.file}};
    out.hint = std::move(hint);
    return out;
}

Result<void> Export::check_options() const {
    if (stem_.empty() || stem_.find_first_of(" \t\r\n/") != std::string::npos)
        return fail(refusal("FILE0122", fmt::format("'{}' is no name for LinuxCNC's files", stem_),
                            "letters, digits and - _ . without blanks"));
    if (!(options_.servo_period_s >= 1e-6 && options_.servo_period_s <= 1))
        return fail(refusal("FILE0122", "the servo period is not between 1 us and 1 s"));
    return {};
}

Result<void> Export::find_kinematics() {
    const std::string chain = letters_of_chain(machine_);
    const auto found = std::ranges::find(detail::linuxcnc_kinematics, chain, &LinuxcncKinematics::chain);
    if (found == detail::linuxcnc_kinematics.end())
        return fail(refusal("FILE0123",
                            fmt::format("no kinematics of LinuxCNC for the chain {}", fmt::join(chain, " ")),
                            std::string(detail::linuxcnc_chains)));
    kinematics_ = &*found;
    for (int i = 0; i < machine_.axis_count; ++i)
        if (auto good = check_axis(machine_.axes[static_cast<std::size_t>(i)]); !good) return good;
    return {};
}

/// The modules know axes along X, Y, Z, and one way of counting for both rotary axes.
Result<void> Export::check_axis(const Axis& axis) const {
    const int along = (axis.rotary ? axis.letter - 'A' : axis.letter - 'X') % 3;
    if (axis.direction != Eigen::Vector3d::Unit(along))
        return fail(refusal("FILE0123",
                            fmt::format("axis {} does not lie along X, Y or Z as LinuxCNC's does", axis.letter),
                            std::string(detail::linuxcnc_chains)));
    if (axis.rotary ? axis.reversed != machine_.axes[3].reversed : axis.reversed)
        return fail(
            refusal("FILE0123", fmt::format("LinuxCNC's kinematics do not count axis {} so", axis.letter),
                    "linear axes as ISO 841 does, both rotary axes against it (reversed = true) or both with it"));
    return {};
}

/// Of linear or rotary axes that all go at their limit.
double Export::together(bool rotary, double AxisLimits::* limit) const {
    double sum = 0;
    for (int i = 0; i < machine_.axis_count; ++i) {
        const Axis& axis = machine_.axes[static_cast<std::size_t>(i)];
        if (axis.rotary == rotary) sum = std::hypot(sum, axis.feed.*limit / unit_of(axis));
    }
    return sum;
}

std::string limits_text(const Axis& axis) {
    std::string out = fmt::format("MAX_VELOCITY = {}\nMAX_ACCELERATION = {}\n",
                                  number(std::min(axis.feed.velocity, axis.rapid.velocity), axis),
                                  number(std::min(axis.feed.acceleration, axis.rapid.acceleration), axis));
    if (std::isfinite(axis.range_min))
        out +=
            fmt::format("MIN_LIMIT = {}\nMAX_LIMIT = {}\n", number(axis.range_min, axis), number(axis.range_max, axis));
    return out;
}

/// An axis whose range leaves out 0 is at home at its nearest end.
std::string Export::axis_sections(int joint) const {
    const Axis& axis = machine_.axes[static_cast<std::size_t>(joint)];
    const std::string home = number(std::clamp(0.0, axis.range_min, axis.range_max), axis);
    return fmt::format(
        "\n[AXIS_{}]\n{}\n[JOINT_{}]\nTYPE = {}\n{}HOME = {}\nHOME_OFFSET = {}\nHOME_SEARCH_VEL = 0\nHOME_SEQUENCE = "
        "0\n"
        "FERROR = {}\nMIN_FERROR = {}\n",
        axis.letter, limits_text(axis), joint, axis.rotary ? "ANGULAR" : "LINEAR", limits_text(axis), home, home,
        following_error, following_error);
}

std::string Export::trunnion_section() const {
    std::string out =
        "\n# What LinuxCNC does not know: mm/s^3, deg/s^3; rapids: velocity acceleration jerk.\n[TRUNNION]\n";
    const auto append = std::back_inserter(out);
    for (int i = 0; i < machine_.axis_count; ++i) {
        const Axis& axis = machine_.axes[static_cast<std::size_t>(i)];
        const AxisLimits &feed = axis.feed, &rapid = axis.rapid;
        fmt::format_to(append, "JERK_{} = {}\n", axis.letter, number(feed.jerk, axis));
        if (feed.velocity != rapid.velocity || feed.acceleration != rapid.acceleration || feed.jerk != rapid.jerk)
            fmt::format_to(append, "RAPID_{} = {} {} {}\n", axis.letter, number(rapid.velocity, axis),
                           number(rapid.acceleration, axis), number(rapid.jerk, axis));
    }
    const auto list = [&](const char* key, const std::vector<std::string>& words) {
        for (const std::string& word : words) fmt::format_to(append, "{} = {}\n", key, one_line(word));
    };
    list("TCP_ON", machine_.words.tcp_on);
    list("TCP_OFF", machine_.words.tcp_off);
    list("IGNORE", machine_.words.ignore);
    list("FOLLOWING", machine_.words.following);
    return out;
}

std::string Export::ini() const {
    constexpr const char* head = R"(# A simulated LinuxCNC 2.9 of the machine below, written by trunnion machine export.
[EMC]
VERSION = 1.1
MACHINE = {name}
DEBUG = 0

[DISPLAY]
DISPLAY = {display}
CYCLE_TIME = 0.05

[RS274NGC]
PARAMETER_FILE = {stem}.var

[KINS]
KINEMATICS = {module} coordinates={letters}
JOINTS = {joints}

[HAL]
HALFILE = {stem}.hal

[TRAJ]
{planner}COORDINATES = {letters}
LINEAR_UNITS = mm
ANGULAR_UNITS = deg
MAX_LINEAR_VELOCITY = {linear_velocity:.9g}
DEFAULT_LINEAR_VELOCITY = {linear_velocity:.9g}
MAX_LINEAR_ACCELERATION = {linear_acceleration:.9g}
DEFAULT_LINEAR_ACCELERATION = {linear_acceleration:.9g}
{angular}
[EMCMOT]
EMCMOT = motmod
SERVO_PERIOD = {period_ns:.0f}
COMM_TIMEOUT = 4

[TASK]
TASK = milltask
CYCLE_TIME = 0.001

[EMCIO]
EMCIO = io
CYCLE_TIME = 0.1
TOOL_TABLE = {stem}.tbl
)";
    const bool turns = machine_.rotary_count > 0;
    const std::string angular =
        turns ? fmt::format("MAX_ANGULAR_VELOCITY = {:.9g}\nDEFAULT_ANGULAR_VELOCITY = {:.9g}\n",
                            together(true, &AxisLimits::velocity), together(true, &AxisLimits::velocity))
              : "";
    std::string out = fmt::format(
        fmt::runtime(head), fmt::arg("name", one_line(machine_.name)), fmt::arg("display", one_line(options_.display)),
        fmt::arg("stem", stem_), fmt::arg("module", kinematics_->module), fmt::arg("letters", kinematics_->letters),
        fmt::arg("joints", machine_.axis_count), fmt::arg("linear_velocity", together(false, &AxisLimits::velocity)),
        fmt::arg("linear_acceleration", together(false, &AxisLimits::acceleration)), fmt::arg("angular", angular),
        fmt::arg("period_ns", 1e9 * options_.servo_period_s),
        fmt::arg("planner", options_.served_machine.empty() ? "" : "TPMOD = trunnion_tp\n"));
    for (int joint = 0; joint < machine_.axis_count; ++joint) out += axis_sections(joint);
    return out + trunnion_section();
}

/// How the drive of a joint is connected: to LinuxCNC's command, or for playing through a switch to the rows too. To
/// LinuxCNC a drive that lags behind the rows then looks as far behind its command: its following-error limits hold.
std::string Export::hal_of_joint(int joint) const {
    if (!options_.play)
        return fmt::format("net position-{0} joint.{0}.motor-pos-cmd => joint.{0}.motor-pos-fb\n", joint);
    return fmt::format(R"(
setp trunnion-lag-{0}.gain1 -1
net trunnion-command-{0} joint.{0}.motor-pos-cmd => trunnion-out-{0}.in0 trunnion-feedback-{0}.in0
net trunnion-row-{0} streamer.0.pin.{0} => trunnion-out-{0}.in1
net trunnion-axis-{0} trunnion-out-{0}.out => trunnion-lag-{0}.in1 trunnion-lag-{0}.in0
net trunnion-lag-{0} trunnion-lag-{0}.out => trunnion-feedback-{0}.in1
net trunnion-feedback-{0} trunnion-feedback-{0}.out => joint.{0}.motor-pos-fb
)",
                       joint);
}

/// The same words for every joint, {} its number.
std::string Export::for_joints(std::string_view words, std::string_view between) const {
    std::string out;
    for (int joint = 0; joint < machine_.axis_count; ++joint)
        out += (joint ? std::string(between) : "") + fmt::format(fmt::runtime(words), joint);
    return out;
}

/// Components in the servo thread, in the order in which they run.
std::string Export::hal_of_thread() const {
    constexpr std::string_view motion =
        "addf motion-command-handler servo-thread\naddf motion-controller servo-thread\n";
    if (!options_.play) return std::string(motion);
    const auto addf = [this](std::string_view name) {
        return for_joints(fmt::format("addf {} servo-thread\n", name), "");
    };
    return addf("trunnion-lag-{}") + addf("trunnion-feedback-{}") + std::string(motion) +
           "addf trunnion-play servo-thread\naddf streamer.0 servo-thread\n" + addf("trunnion-out-{}");
}

/// A row counts while trunnion-play.ok-out is true: that goes false in the period in which LinuxCNC disables motion,
/// and stays so.
std::string Export::hal_of_playing() const {
    const std::string joints(static_cast<std::size_t>(machine_.axis_count), 'f');
    return fmt::format(
        "loadrt streamer depth={} cfg={}\nloadrt estop_latch names=trunnion-play\nloadrt mux2 names={}\n"
        "loadrt sum2 names={},{}\n\nnet trunnion-enabled motion.motion-enabled => trunnion-play.ok-in\n"
        "net trunnion-takes trunnion-play.ok-out => streamer.0.enable {}\n",
        options_.streamer_depth, joints, for_joints("trunnion-out-{}", ","), for_joints("trunnion-lag-{}", ","),
        for_joints("trunnion-feedback-{}", ","), for_joints("trunnion-out-{}.sel", " "));
}

std::string Export::hal_of_kinematics() const {
    if (machine_.rotary_count == 0) return {};
    const Axis &tilt = machine_.axes[3], &turn = machine_.axes[4];
    const auto module = kinematics_->module;
    std::string out = "\n# Lengths of the kinematics, mm; the tool's comes from the tool table.\n";
    const auto set = [&](std::string_view pin, double value) {
        out += fmt::format("setp {}.{} {}\n", module, pin, detail::number_in_unit(value, 1));
    };
    set("x-rot-point", turn.point_mm.x());
    set("y-rot-point", turn.point_mm.y());
    set("z-rot-point", turn.point_mm.z());
    set(kinematics_->side_pin, tilt.point_mm[kinematics_->side] - turn.point_mm[kinematics_->side]);
    set("z-offset", tilt.point_mm.z() - turn.point_mm.z());
    if (!turn.reversed) {
        out += "# This pin came after version 2.9.0~pre1.\n";
        set("conventional-directions", 1);
    }
    return out + fmt::format("net :tool-offset motion.tooloffset.z => {}.tool-offset\n", module);
}

std::string Export::hal() const {
    const int joints = machine_.axis_count;
    std::string out =
        fmt::format("# A simulated LinuxCNC 2.9, written by trunnion machine export.\nloadrt {} coordinates={}\n",
                    kinematics_->module, kinematics_->letters);
    out += fmt::format("loadrt motmod servo_period_nsec={:.0f} num_joints={}\n", 1e9 * options_.servo_period_s, joints);
    if (options_.play) out += hal_of_playing();
    out += "\n" + hal_of_thread();
    out += "\n# What goes out comes back: here the drives are connected";
    out += options_.play ? ", to trunnion-axis-N, and what they measure to trunnion-lag-N.in0.\n" : ".\n";
    for (int joint = 0; joint < joints; ++joint) out += hal_of_joint(joint);
    out += hal_of_kinematics();
    if (!options_.served_machine.empty())
        out += fmt::format("\nloadusr trunnion serve --linuxcnc -m {}\n", one_line(options_.served_machine));
    return out + R"(
net estop iocontrol.0.user-enable-out => iocontrol.0.emc-enable-in
net tool-prepare iocontrol.0.tool-prepare => iocontrol.0.tool-prepared
net tool-change iocontrol.0.tool-change => iocontrol.0.tool-changed
)";
}

/// The numbered parameters that LinuxCNC wants in its file: G28, G30, G92, and the nine work offsets.
std::string parameter_file() {
    std::string out;
    const auto rows = [&](int from, int to) {
        for (int n = from; n <= to; ++n) out += fmt::format("{}\t0.000000\n", n);
    };
    rows(5161, 5169);
    rows(5181, 5189);
    rows(5210, 5219);
    out += "5220\t1.000000\n";
    for (int system = 5221; system <= 5381; system += 20) rows(system, system + 9);
    return out;
}

Result<LinuxcncConfiguration> Export::operator()() {
    if (auto good = check_options(); !good) return fail(good.error());
    if (auto good = find_kinematics(); !good) return fail(good.error());
    return LinuxcncConfiguration{ini(), hal(), "; T1 P1 Z100 D10 ; number, pocket, length, diameter\n",
                                 parameter_file()};
}

}  // namespace

Result<LinuxcncConfiguration> linuxcnc_configuration(const Machine& machine, std::string_view stem,
                                                     const LinuxcncExport& options) {
    return Export(machine, stem, options)();
}

}  // namespace trunnion::files
