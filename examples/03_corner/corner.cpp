// corner MACHINE_FILE FOLDER: rounds one corner of a pocket with drafted walls, links its two curves in three ways and
// writes tables of what comes out. docs/theory/corner-rounding.md shows them as pictures.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <trunnion/base/quantity.hpp>
#include <trunnion/files/machine_file.hpp>
#include <trunnion/smoothing/corner_study.hpp>

namespace {

namespace smoothing = trunnion::smoothing;
using trunnion::degree;
using trunnion::Taylor3;

constexpr double height_mm = 25, tolerance_mm = 2.5, draft = 10 * degree, feed_mm_s = 50;

/// The tip at z = 0 and the tool's point at the height, leaning out of the pocket.
smoothing::RuledPose leaning(double x_mm, double y_mm, double towards_x, double towards_y) {
    const Eigen::Vector3d tip(x_mm, y_mm, 0);
    const Eigen::Vector3d tool(std::tan(draft) * towards_x, std::tan(draft) * towards_y, 1);
    return {tip, tip + height_mm * tool.normalized()};
}

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

void write_curves(const std::filesystem::path& folder, const smoothing::DualCorner& corner) {
    Table table(folder, "curves", "u,x_mm,y_mm,z_mm,top_x_mm,top_y_mm,top_z_mm");
    const auto write = [&](double u, const Eigen::Vector3d& bottom, const Eigen::Vector3d& top) {
        table.row(std::array{u, bottom.x(), bottom.y(), bottom.z(), top.x(), top.y(), top.z()});
    };
    for (int i = 0; i <= 200; ++i) {
        const double u = i / 200.0;
        write(u, corner.curves.bottom().evaluate(u)[0], corner.curves.top().evaluate(u)[0]);
    }
    Table points(folder, "polygon", "x_mm,y_mm,z_mm,top_x_mm,top_y_mm,top_z_mm");
    for (std::size_t i = 0; i < 5; ++i) {
        const auto &b = corner.curves.bottom().control_points_mm()[i], &t = corner.curves.top().control_points_mm()[i];
        points.row(std::array{b.x(), b.y(), b.z(), t.x(), t.y(), t.z()});
    }
}

void write_link(const std::filesystem::path& folder, const std::string& name, const smoothing::Link& link) {
    Table table(folder, "link_" + name, "u_bottom,u_top,first,second,third");
    for (int i = 0; i <= 400; ++i) {
        const double u = i / 400.0;
        const Taylor3 f = link(u);
        table.row(std::array{u, f.value(), f.d1(), f.d2(), f.d3()});
    }
}

void write_way(const std::filesystem::path& folder, const std::string& name,
               const std::vector<smoothing::CornerSample>& way) {
    Table table(folder, "way_" + name,
                "s_mm,first_rad_mm,second_rad_mm2,third_rad_mm3,feed_limit_mm_s,height_feed_mm_s");
    for (const auto& sample : way) {
        const auto& n = sample.pose.tool_axis;
        table.row(std::array{sample.length_mm, std::hypot(n[0].d1(), n[1].d1(), n[2].d1()),
                             std::hypot(n[0].d2(), n[1].d2(), n[2].d2()), sample.criterion_rad_mm3,
                             sample.feed_limit_mm_s, sample.height_feed_mm_s});
    }
}

void write_steps(const std::filesystem::path& folder, const std::string& name,
                 const std::vector<smoothing::CornerStep>& steps) {
    Table table(folder, "steps_" + name, "s_mm,criterion_rad_mm3,feed_limit_mm_s");
    for (const auto& step : steps) table.row(std::array{step.length_mm, step.criterion_rad_mm3, step.feed_limit_mm_s});
}

void write_sensitivity(const std::filesystem::path& folder, const smoothing::DualCorner& corner,
                       const smoothing::StudiedMachine& on, double step_mm, double best_top, double linear_top) {
    std::vector<double> tops;
    for (int i = -400; i <= 600; ++i) tops.push_back(best_top + (linear_top - best_top) * i / 400.0);
    for (int i = -100; i <= 100; ++i) tops.push_back(best_top + 1e-7 * i);
    Table table(folder, "sensitivity", "u_top,criterion_rad_mm3,feed_limit_mm_s");
    for (const auto& tried : smoothing::first_point_sensitivity(corner, step_mm, tops, on))
        table.row(std::array{tried.top, tried.criterion_rad_mm3, tried.feed_limit_mm_s});
}

/// A corner of the tip alone in the plane of two axes with 3 m/s² and 50 m/s³.
void write_ratios(const std::filesystem::path& folder) {
    const trunnion::machine::AxisLimits axis{500, 3000, 50000};
    Table table(folder, "ratio", "ratio,angle_deg,feed_limit_mm_s");
    for (const double angle : {45, 90, 135})
        for (int i = 0; i <= 147; ++i) {
            const double ratio = 1.03 + 0.01 * i, turn = (180 - angle) * degree;
            const Eigen::Vector3d after(100 * std::cos(turn), 100 * std::sin(turn), 0);
            const auto corner = smoothing::corner_spline({-100, 0, 0}, {0, 0, 0}, after, {0.02, ratio});
            if (!corner) continue;
            table.row(std::array{ratio, angle, smoothing::least_feed_limit_mm_s(*corner, {axis, axis, axis})});
        }
}

int refused(const trunnion::Diagnostic& diagnostic) {
    fmt::print(stderr, "{}\n", trunnion::to_string(diagnostic));
    return 2;
}

int study(const std::string& machine_file, const std::filesystem::path& folder) {
    const auto machine = trunnion::files::read_machine_file(machine_file);
    if (!machine) return refused(machine.error());
    const auto kinematics =
        trunnion::machine::Kinematics::make(*machine, {{0, 0, 60}, Eigen::Matrix3d::Identity()}, 100);
    if (!kinematics) return refused(kinematics.error());
    const smoothing::StudiedMachine on{*kinematics, *machine, {}, feed_mm_s};

    const auto corner = smoothing::dual_corner(leaning(-70, 0, 0, -1), leaning(0, 0, 1, -1), leaning(0, 55, 1, 0),
                                               {.tip_tolerance_mm = tolerance_mm, .top_tolerance_mm = tolerance_mm});
    if (!corner) return refused(corner.error());
    const auto closed = smoothing::closed_link(*corner);
    if (!closed) return 1;
    constexpr double step_mm = 0.05;  // 1 ms at the programmed feed
    const auto discrete = smoothing::discrete_link(*corner, step_mm);
    if (!discrete) return refused(discrete.error());

    write_curves(folder, *corner);
    const std::vector<std::pair<std::string, smoothing::Link>> links{
        {"linear", [](double u) { return Taylor3{u, 1, 0, 0}; }},
        {"closed", [&](double u) { return closed->at(u); }},
        {"discrete", [&](double u) { return discrete->at(u); }}};
    for (const auto& [name, link] : links) {
        write_link(folder, name, link);
        write_way(folder, name, smoothing::sample_corner(*corner, link, on, 6, height_mm, 300));
        const auto steps = smoothing::walk_corner(*corner, link, on, 6, step_mm);
        write_steps(folder, name, steps);
        double slowest = feed_mm_s;
        for (const auto& step : steps) slowest = std::min(slowest, step.feed_limit_mm_s);
        fmt::print("{:8} link: f' {:.4f} at the entry, Eq. 10 at {} mm falls to {:.2f} mm/s\n", name, link(0).d1(),
                   step_mm, slowest);
    }
    write_sensitivity(folder, *corner, on, step_mm, discrete->top[1], discrete->bottom[1]);
    write_ratios(folder);
    return 0;
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 3) {
        fmt::print(stderr, "corner MACHINE_FILE FOLDER\n");
        return 2;
    }
    try {
        return study(argv[1], argv[2]);
    } catch (const std::ios_base::failure&) {
        fmt::print(stderr, "{}: tables cannot be written there\n", argv[2]);
        return 2;
    }
}
