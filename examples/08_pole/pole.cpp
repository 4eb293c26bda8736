// pole MACHINE_FILE FOLDER: a path that passes 0.05° beside the pole is led through it, and around it where the swivel
// axis may not go below 0; a pass over an impeller-like blade is turned so that the rotary axes have less to do. Writes
// tables of the paths and of their setpoints. docs/theory/singular-cone.md and rotary-motion.md show them as pictures.
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Geometry>
#include <fmt/format.h>
#include <trunnion/base/quantity.hpp>
#include <trunnion/deformation/avoid_pole.hpp>
#include <trunnion/deformation/dual_path_program.hpp>
#include <trunnion/deformation/reduce_rotary.hpp>
#include <trunnion/files/machine_file.hpp>
#include <trunnion/pipeline/plan.hpp>

namespace {

namespace deformation = trunnion::deformation;
namespace machine = trunnion::machine;
namespace program = trunnion::program;
using Eigen::Vector3d;
using trunnion::degree;

constexpr double pole_feed_mm_s = 50, around_feed_mm_s = 250.0 / 60, blade_feed_mm_s = 150;
const machine::Tool ball{machine::ToolKind::ball, 8, 4, 0, true};

/// A file that is written line by line.
class Table {
  public:
    Table(const std::filesystem::path& folder, const std::string& name, std::string_view columns) {
        file_.exceptions(std::ios::failbit | std::ios::badbit);
        file_.open(folder / (name + ".csv"));
        file_ << columns << '\n';
    }
    void row(std::span<const double> values) { file_ << fmt::format("{}\n", fmt::join(values, ",")); }

  private:
    std::ofstream file_;
};

/// 40 mm along X while the tool turns about Y from −10° to 10°, 0.05° beside the pole.
std::vector<deformation::Pose> past_pole() {
    std::vector<deformation::Pose> out;
    const double beside = 0.05 * degree;
    for (int i = 0; i <= 40; ++i) {
        const double tilt = (-10 + 0.5 * i) * degree;
        out.push_back({Vector3d(-20 + i, 0, 0),
                       Vector3d(std::sin(tilt), std::sin(beside) * std::cos(tilt), std::cos(beside) * std::cos(tilt))});
    }
    return out;
}

/// Across a blade with an S-shaped camber, twist and lean, the tool along its normal.
std::vector<deformation::Pose> over_blade() {
    const auto point = [](double x, double y) {
        const double s = 2 * std::numbers::pi * x / 90;
        return Vector3d(x, y, 3 * (1 - std::cos(s)) + 0.3 * std::tan(30 * degree * y / 40) * (x - 45) + 0.45 * y);
    };
    std::vector<deformation::Pose> out;
    for (int i = 0; i <= 120; ++i) {
        const double x = 0.75 * i, y = 20, step = 1e-5;
        const Vector3d along = point(x + step, y) - point(x - step, y), up = point(x, y + step) - point(x, y - step);
        out.push_back({point(x, y), along.cross(up).normalized()});
    }
    return out;
}

program::Program program_of(const deformation::DualPath& path, double feed_mm_s) {
    program::Program out;
    for (const double u : {path.begin(), path.end()}) {
        program::Move move;
        move.position_mm = path.at(u).tip_in_workpiece_mm;
        move.axis = path.at(u).axis_in_workpiece;
        move.feed = {program::FeedRule::tip_speed, feed_mm_s};
        move.line = static_cast<std::int32_t>(out.moves.size()) + 1;
        out.moves.push_back(move);
    }
    return deformation::with_dual_paths(out, {{{1, 1}, path, {path.end()}}});
}

/// Writes the setpoints as they come.
class Setpoints : public trunnion::pipeline::PlanObserver {
  public:
    Setpoints(const std::filesystem::path& folder, const std::string& name)
        : table_(folder, name + "_plan", "t_s,A_deg,C_deg,feed_mm_min") {}
    void setpoint(const trunnion::motion::Setpoint& at) override {
        table_.row(std::array{at.time_s, at.position[3] / degree, at.position[4] / degree, 60 * at.feed_mm_s});
        if (rows_++ > 0)
            for (const std::size_t axis : {3U, 4U}) travel_rad_ += std::abs(at.position[axis] - before_[axis]);
        before_ = at.position;
    }
    double travel_deg() const { return travel_rad_ / degree; }

  private:
    Table table_;
    std::size_t rows_ = 0;
    machine::AxisPosition before_;
    double travel_rad_ = 0;
};

int refused(const trunnion::Diagnostic& diagnostic) {
    fmt::print(stderr, "{}\n", trunnion::to_string(diagnostic));
    return 2;
}

/// Tables of one path, and a line of what it asks for.
int write(const std::filesystem::path& folder, const std::string& name, const deformation::DualPath& path,
          const deformation::Machining& machining) {
    Table table(folder, name, "u_mm,i,j,k");
    for (int n = 0; n <= 2000; ++n) {
        const double u = path.begin() + (path.end() - path.begin()) * n / 2000;
        const Vector3d axis = path.at(u).axis_in_workpiece;
        table.row(std::array{u, axis.x(), axis.y(), axis.z()});
    }
    Setpoints setpoints(folder, name);
    trunnion::pipeline::PlanOptions options;
    options.smoothing.orientation_tolerance_rad = 0.001 * degree;  // the planner is not to turn the tool by itself
    const auto planned =
        trunnion::pipeline::plan(program_of(path, machining.feed_mm_s), machining.machine, {}, options, setpoints);
    if (!planned) return refused(planned.error());
    const auto use = rotary_use(path, machining);
    if (!use) return refused(use.error());
    fmt::print(
        "{:14} rotary travel {:7.2f} deg, at the feed up to {:8.2f} of a rotary limit; {:.3f} s at best, planned "
        "{:.3f} s with {:.2f} deg\n",
        name, use->travel_rad / degree, use->velocity_ratio, use->velocity_limited_time_s, planned->cycle_time_s,
        setpoints.travel_deg());
    return 0;
}

int lead_past(const std::filesystem::path& folder, const machine::Machine& on, const machine::Kinematics& kinematics,
              const std::string& name, double feed_mm_s, double tolerance_deg) {
    const auto path = deformation::fit_dual_path(past_pole());
    if (!path) return refused(path.error());
    const deformation::Machining machining{on, kinematics, ball, feed_mm_s, {}};
    const auto led =
        avoid_pole(path->path, machining, {.orientation_tolerance_rad = tolerance_deg * degree, .passing = {}});
    if (!led) return refused(led.error());
    fmt::print("{}: turned by {:.4f} deg, the ball's surface moved by less than {:.1e} mm\n", name,
               led->change.orientation_deviation_rad / degree, led->change.surface_mm);
    if (const int code = write(folder, name + "_before", path->path, machining); code != 0) return code;
    return write(folder, name + "_after", led->path, machining);
}

int calm_blade(const std::filesystem::path& folder, const machine::Machine& on, const machine::Kinematics& kinematics) {
    const auto path = deformation::fit_dual_path(over_blade());
    if (!path) return refused(path.error());
    const deformation::Machining machining{on, kinematics, ball, blade_feed_mm_s, {}};
    deformation::OrientationFreedom freedom;
    freedom.orientation_tolerance_rad = 5 * degree;
    const auto reduced = reduce_rotary(path->path, machining, freedom);
    if (!reduced) return refused(reduced.error());
    if (const int code = write(folder, "blade_before", path->path, machining); code != 0) return code;
    return write(folder, "blade_after", reduced->path, machining);
}

int study(const std::string& machine_file, const std::filesystem::path& folder) {
    auto on = trunnion::files::read_machine_file(machine_file);
    if (!on) return refused(on.error());
    const auto kinematics = machine::Kinematics::make(*on, {}, 0);
    if (!kinematics) return refused(kinematics.error());
    if (const int code = lead_past(folder, *on, *kinematics, "through", pole_feed_mm_s, 0.06); code != 0) return code;
    if (const int code = calm_blade(folder, *on, *kinematics); code != 0) return code;
    on->axes[3].range_min = 0;
    return lead_past(folder, *on, *kinematics, "around", around_feed_mm_s, 1);
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 3) {
        fmt::print(stderr, "usage: example_pole MACHINE_FILE FOLDER\n");
        return 2;
    }
    try {
        std::filesystem::create_directories(argv[2]);
        return study(argv[1], argv[2]);
    } catch (const std::exception& problem) {
        fmt::print(stderr, "{}\n", problem.what());
        return 2;
    }
}
