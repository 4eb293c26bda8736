// bench_queue_drive MACHINE.toml PROGRAM.ngc [LINES_A_PERIOD [EVERY]]: feeds the lines of a program (every so many-th
// of them) to QueueMotion as LinuxCNC hands them over, in ideal time: planning takes none of the motion's. Prints the
// time of the motion, its standstills, the processor time of planning, and the rows' peaks by their differences.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <sstream>
#include <string>

#include <fmt/format.h>

#include "trunnion/base/quantity.hpp"
#include "trunnion/files/machine_file.hpp"
#include "trunnion/pipeline/queue_motion.hpp"

namespace {

using namespace trunnion;

constexpr double period_s = 1e-3;
constexpr std::size_t most_waiting = 2000, lead = 200;

/// X Y Z A C of the end of a line, mm and degrees, and its feed, mm/s.
struct Line {
    std::array<double, 5> end{};
    double feed = 0;
};

bool is_word_of(char letter, std::size_t& axis) {
    axis = std::string_view("XYZAC").find(letter);
    return axis != std::string_view::npos;
}

std::vector<Line> read(const std::string& file, int every) {
    std::ifstream in(file);
    std::vector<Line> out;
    Line now;
    int lines = 0;
    for (std::string text; std::getline(in, text);) {
        if (!text.starts_with("G1") && !text.starts_with("G0")) continue;
        std::istringstream words(text);
        for (std::string word; words >> word;) {
            std::size_t axis = 0;
            const double value = std::atof(word.c_str() + 1);
            if (is_word_of(word[0], axis)) now.end[axis] = value;
            if (word[0] == 'F') now.feed = value / 60;
        }
        if (text.starts_with("G0") || ++lines % every == 0) out.push_back(now);
    }
    return out;
}

pipeline::QueuedPose pose_of(const Line& line) {
    return {{line.end[0], line.end[1], line.end[2]}, {line.end[3] * degree, line.end[4] * degree}};
}

/// The speed as LinuxCNC resolves it: no axis beyond its velocity, as if there were no kinematics.
pipeline::QueuedMove move_of(const machine::Machine& machine, const Line& from, const Line& to, std::size_t number) {
    double way = 0, turn = 0, time_s = 0;
    for (std::size_t i = 0; i < 5; ++i) {
        const double unit = machine.axes[i].rotary ? degree : 1, step = (to.end[i] - from.end[i]) * unit;
        (machine.axes[i].rotary ? turn : way) += step * step;
        time_s = std::max(time_s, std::abs(step) / machine.axes[i].feed.velocity);
    }
    pipeline::QueuedMove out;
    out.number = static_cast<std::int32_t>(number);
    out.end = pose_of(to);
    out.feed =
        way > 0 ? program::Feed{program::FeedRule::tip_speed, std::min(to.feed, std::sqrt(way) / time_s)}
                : program::Feed{program::FeedRule::rotary_rate, std::min(to.feed * degree, std::sqrt(turn) / time_s)};
    out.tip_tolerance_mm = 0.01;
    return out;
}

/// Peaks of velocity, acceleration and jerk of the rows, of the limits.
std::array<double, 3> peaks(const std::vector<pipeline::LiveRow>& rows, const machine::Machine& machine) {
    std::array<double, 3> out{};
    for (std::size_t k = 3; k < rows.size(); ++k)
        for (int i = 0; i < machine.axis_count; ++i) {
            const machine::AxisLimits& limit = machine.axes[i].feed;
            const auto at = [&](std::size_t back) { return rows[k - back].position[i]; };
            out[0] = std::max(out[0], std::abs(at(0) - at(1)) / period_s / limit.velocity);
            out[1] = std::max(out[1], std::abs(at(0) - 2 * at(1) + at(2)) / std::pow(period_s, 2) / limit.acceleration);
            out[2] =
                std::max(out[2], std::abs(at(0) - 3 * at(1) + 3 * at(2) - at(3)) / std::pow(period_s, 3) / limit.jerk);
        }
    return out;
}

}  // namespace

int main(int argc, char** argv) {
    if (argc < 3) return 2;
    const auto machine = files::read_machine_file(argv[1]);
    const auto lines = read(argv[2], argc > 4 ? std::atoi(argv[4]) : 1);
    const double pace = argc > 3 ? std::atof(argv[3]) : 0.9;
    if (!machine || lines.size() < 2) return 2;
    auto motion = *pipeline::QueueMotion::make(*machine, 0, pose_of(lines.front()), {});
    std::vector<pipeline::LiveRow> rows{motion.begin()};
    const std::size_t all = lines.size() - 1;
    std::size_t sent = 0, plan = 0;
    double due = 0, planning_s = 0, longest_s = 0;
    int standstills = 0;
    for (bool moved = false;;) {
        const auto behind = static_cast<std::size_t>(rows.size() > lead ? rows[rows.size() - lead].line : 0);
        for (due += pace; due >= 1; --due)
            if (sent < all && sent - behind < most_waiting) {
                motion.add(move_of(*machine, lines[sent], lines[sent + 1], sent + 1));
                ++sent;
            }
        if (sent == all) motion.close();
        const std::clock_t begun = std::clock();
        const auto state = motion.tick();
        const double took_s = static_cast<double>(std::clock() - begun) / CLOCKS_PER_SEC;
        planning_s += took_s;
        longest_s = std::max(longest_s, took_s);
        if (!state) {
            fmt::print(stderr, "{}\n", to_string(state.error()));
            return 1;
        }
        if (motion.plan() != plan) motion.keep_plan(0);
        plan = motion.plan();
        const bool moves = state->status == pipeline::LiveMotionStatus::moving;
        if (moves) rows.push_back(state->row);
        standstills += moved && !moves;
        moved = moves;
        if (!moves && sent == all && motion.done_at_standstill() == static_cast<std::int32_t>(all)) break;
    }
    const double motion_s = static_cast<double>(rows.size() - 1) * period_s;
    const auto [velocity, acceleration, jerk] = peaks(rows, *machine);
    fmt::print(
        "motion {:.3f} s, standstills {}, planning {:.3f} of it, the longest {:.0f} ms, plans {}, peaks {:.4f} {:.4f} "
        "{:.4f}\n",
        motion_s, standstills, planning_s / motion_s, 1e3 * longest_s, plan, velocity, acceleration, jerk);
    return 0;
}
