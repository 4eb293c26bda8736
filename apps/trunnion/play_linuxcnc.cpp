#include "play_linuxcnc.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <sstream>
#include <system_error>

#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include "trunnion/base/quantity.hpp"

namespace trunnion::app {

namespace {

using Clock = std::chrono::steady_clock;

constexpr double longest_hello_s = 10, longest_jog_s = 600;
constexpr double same_unit = 1e-9, same_period = 1e-6;

Diagnostic no_linuxcnc(const std::string& why) {
    return {.code = "RT0001",
            .text = fmt::format("no LinuxCNC to play into: {}", why),
            .hint = "start LinuxCNC with the HAL of docs/how-to/run-on-linuxcnc.md, as the same user"};
}

Diagnostic not_ready(const std::string& what, const std::string& hint) {
    return {.code = "RT0002", .text = fmt::format("LinuxCNC is not ready: {}", what), .hint = hint};
}

Diagnostic differs(const std::string& what, const std::string& value, const std::string& limit) {
    return {.code = "RT0003", .text = what, .value = value, .limit = limit};
}

Diagnostic ended(const std::string& why) {
    return {.code = "RT0009", .text = fmt::format("LinuxCNC has ended the motion: {}", why)};
}

std::string axis_letters(const machine::Machine& machine) {
    std::string out;
    for (int i = 0; i < machine.axis_count; ++i) out += machine.axes[i].letter;
    return out;
}

/// Where the bridge lies: installed, or in the sources.
std::string bridge_file() {
    std::error_code error;
    std::vector<std::filesystem::path> folders;
    const auto self = std::filesystem::read_symlink("/proc/self/exe", error);
    if (!error) folders.push_back(self.parent_path().parent_path() / "share/trunnion/linuxcnc");
    folders.push_back(std::filesystem::path(TRUNNION_INSTALL_DATA_DIR) / "linuxcnc");
    folders.push_back(std::filesystem::path(TRUNNION_SOURCE_DATA_DIR) / "../linuxcnc");
    for (const auto& folder : folders)
        if (std::filesystem::exists(folder / "bridge.py", error)) return (folder / "bridge.py").string();
    return "bridge.py";
}

bool parse_joint(const std::string& text, LinuxcncFacts::Joint& joint) {
    return std::sscanf(text.c_str(), "%lf,%lf,%lf,%lf", &joint.position, &joint.min, &joint.max,
                       &joint.following_error) == 4;
}

bool parse_fact(const std::string& key, const std::string& value, LinuxcncFacts& facts) {
    const double number = std::strtod(value.c_str(), nullptr);
    if (key == "letters") facts.letters = value;
    if (key == "on") facts.on = number > 0;
    if (key == "idle") facts.idle = number > 0;
    if (key == "homed") facts.homed = number > 0;
    if (key == "period_ns") facts.period_s = number * 1e-9;
    if (key == "linear_units") facts.linear_units = number;
    if (key == "angular_units") facts.angular_units = number;
    if (key == "room") facts.room = static_cast<std::uint64_t>(number);
    return key != "joint" || parse_joint(value, facts.joints.emplace_back());
}

}  // namespace

Result<LinuxcncFacts> LinuxcncFacts::parse(const std::string& line) {
    LinuxcncFacts out;
    std::istringstream words(line);
    std::string word;
    words >> word;
    if (word == "missing") return fail(no_linuxcnc(line.substr(word.size() + 1)));
    if (word != "facts") return fail(no_linuxcnc("the bridge said nothing that is known"));
    while (words >> word) {
        const std::size_t equals = word.find('=');
        if (equals == std::string::npos || !parse_fact(word.substr(0, equals), word.substr(equals + 1), out))
            return fail(no_linuxcnc("the bridge said nothing that is known"));
    }
    return out;
}

Result<std::vector<std::size_t>> match(const LinuxcncFacts& facts, const machine::Machine& machine, double period_s,
                                       std::uint64_t rows) {
    if (!facts.on) return fail(not_ready("the machine is off", "reset E-stop and switch it on"));
    if (!facts.homed) return fail(not_ready("not all joints are homed", "home it"));
    if (!facts.idle) return fail(not_ready("it moves or runs a program", "wait, or abort it"));
    const std::string letters = axis_letters(machine);
    std::string sorted = facts.letters, wanted = letters;
    std::ranges::sort(sorted);
    std::ranges::sort(wanted);
    if (sorted != wanted || facts.joints.size() != letters.size())
        return fail(differs("LinuxCNC has other axes than the machine file", facts.letters, letters));
    if (std::abs(facts.period_s - period_s) > same_period * period_s)
        return fail(differs("LinuxCNC's servo period is not that of --period", fmt::format("{} s", facts.period_s),
                            fmt::format("{} s", period_s)));
    if (std::abs(facts.linear_units - 1) > same_unit || std::abs(facts.angular_units - 1) > same_unit)
        return fail(differs("LinuxCNC does not count in mm and degrees",
                            fmt::format("{}, {}", facts.linear_units, facts.angular_units), "1, 1"));
    if (facts.room < rows)
        return fail(differs("LinuxCNC's streamer holds fewer rows than --depth", fmt::format("{}", facts.room),
                            fmt::format("{}", rows)));
    std::vector<std::size_t> out;
    for (const char letter : letters) out.push_back(facts.letters.find(letter));
    return out;
}

machine::Machine narrowed(machine::Machine machine, const LinuxcncFacts& facts,
                          const std::vector<std::size_t>& joints) {
    for (std::size_t i = 0; i < joints.size(); ++i) {
        machine::Axis& axis = machine.axes[i];
        const double unit = axis.rotary ? degree : 1;
        axis.range_min = std::max(axis.range_min, facts.joints[joints[i]].min * unit);
        axis.range_max = std::min(axis.range_max, facts.joints[joints[i]].max * unit);
    }
    return machine;
}

Result<void> check_place(const LinuxcncFacts& facts, const std::vector<std::size_t>& joints,
                         const machine::Machine& machine, const trunnion_row& first) {
    std::string place;
    for (std::size_t i = 0; i < joints.size(); ++i)
        place += fmt::format(" {} {}", machine.axes[i].letter, first.position[i]);
    for (std::size_t i = 0; i < joints.size(); ++i) {
        const LinuxcncFacts::Joint& joint = facts.joints[joints[i]];
        if (std::abs(joint.position - first.position[i]) <= joint.following_error) continue;
        return fail({.code = "RT0004",
                     .text = fmt::format("axis {} does not stand where the program begins", machine.axes[i].letter),
                     .value = fmt::format("{}", joint.position),
                     .limit = fmt::format("{} ± {}", first.position[i], joint.following_error),
                     .hint = fmt::format("bring the axes to{}", place)});
    }
    return {};
}

Result<std::unique_ptr<LinuxcncSink>> LinuxcncSink::connect(int plans) {
    const auto bridge = start_program({"/usr/bin/python3", bridge_file(), std::to_string(plans)});
    if (!bridge) return fail(bridge.error());
    std::unique_ptr<LinuxcncSink> out(new LinuxcncSink(*bridge));
    const auto line = out->next_line(longest_hello_s);
    if (!line) return fail(no_linuxcnc("the bridge does not answer"));
    auto facts = LinuxcncFacts::parse(*line);
    if (!facts) return fail(facts.error());
    out->facts_ = std::move(*facts);
    return out;
}

LinuxcncSink::~LinuxcncSink() {
    wait_for(bridge_);
}

Result<void> LinuxcncSink::accept(const machine::Machine& machine, double period_s, std::uint64_t depth_rows) {
    auto joints = match(facts_, machine, period_s, depth_rows);
    if (!joints) return fail(joints.error());
    joints_ = std::move(*joints);
    machine_ = machine;
    depth_rows_ = depth_rows;
    trunnion_row axes{};
    for (std::size_t i = 0; i < joints_.size(); ++i) axes.position[i] = static_cast<double>(i);
    order('X', &axes);
    return {};
}

Result<void> LinuxcncSink::prepare(const trunnion_row& first) {
    if (auto good = check_place(facts_, joints_, machine_, first); !good) return good;
    last_ = first;
    order('A', &first);
    return wait_until_done(longest_jog_s);
}

void LinuxcncSink::start() {
    order('T', nullptr);
}

std::size_t LinuxcncSink::room() {
    const std::uint64_t ahead = given_ - reached();
    return ahead < depth_rows_ ? depth_rows_ - ahead : 0;
}

void LinuxcncSink::give(const trunnion_row& row) {
    last_ = row;
    ++given_;
    order('R', &row);
}

void LinuxcncSink::order(char letter, const trunnion_row* row) {
    std::string out(1, letter);
    std::vector<double> values(joints_.size());
    for (std::size_t i = 0; row && i < joints_.size(); ++i) values[joints_[i]] = row->position[i];
    if (row) out.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(double));
    (void)!write(bridge_.to, out.data(), out.size());
}

/// `s WRITTEN DEPTH`, or the end; `lost` comes from the bridge that stood by.
Result<void> LinuxcncSink::hear(const std::string& line) {
    std::uint64_t written = 0, waiting = 0;
    if (std::sscanf(line.c_str(), "s %lu %lu", &written, &waiting) == 2) {
        written_ = written;
        waiting_ = std::min(waiting, written);
        return {};
    }
    if (line.starts_with("halt ")) return fail(ended(line.substr(5)));
    if (line == "lost")
        return fail(
            {.code = "RT0014",
             .text = "the bridge to LinuxCNC was killed; another one plays the last plan to its standstill, and has "
                     "LinuxCNC take over the place"});
    return {};
}

Result<void> LinuxcncSink::watch() {
    for (const std::string& line : news_.lines())
        if (auto good = hear(line); !good) return good;
    if (news_.ended()) return fail(ended("the bridge to it is gone"));
    return {};
}

Result<std::string> LinuxcncSink::next_line(double longest_s) {
    const auto until = Clock::now() + std::chrono::duration<double>(longest_s);
    while (unheard_.empty()) {
        if (Clock::now() > until) return fail(ended("it does not answer"));
        if (news_.ended()) return fail(ended("the bridge to it is gone"));
        pollfd there{.fd = news_.descriptor(), .events = POLLIN, .revents = 0};
        poll(&there, 1, 10);
        unheard_ = news_.lines();
    }
    std::string out = unheard_.front();
    unheard_.erase(unheard_.begin());
    return out;
}

Result<void> LinuxcncSink::wait_until_done(double longest_s) {
    const auto until = Clock::now() + std::chrono::duration<double>(longest_s);
    while (Clock::now() < until) {
        const auto line = next_line(longest_s);
        if (!line) return fail(line.error());
        if (*line == "done") return {};
        if (auto good = hear(*line); !good) return good;
    }
    return fail(ended("it does not come to the place"));
}

Result<void> LinuxcncSink::finish() {
    order('B', &last_);
    return wait_until_done(longest_jog_s);
}

}  // namespace trunnion::app
