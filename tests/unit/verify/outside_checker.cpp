#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <sstream>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "trunnion/verify/programmed_csv.hpp"

#include "made_programs.hpp"

/// The checker against the one outside the project, on the same files.
namespace trunnion::verify::test {
namespace {

namespace fs = std::filesystem;

const fs::path shared = TRUNNION_SHARED_DIR;
const char* const python = "/usr/bin/python3";

std::string text_of(const fs::path& file) {
    std::ifstream in(file);
    return {std::istreambuf_iterator<char>(in), {}};
}

bool outside_checker_runs() {
    return fs::exists(shared / "tools/verify_setpoints.py") && fs::exists(shared / "data/cases/peer-trunnion.toml") &&
           std::system(fmt::format("{} -c 'import numpy, tomllib' 2>/dev/null", python).c_str()) == 0;
}

/// The numbers of its report by key, axes as `X.velocity_ratio`.
std::map<std::string, double> outside_verdict(const fs::path& setpoints, const fs::path& programmed) {
    const auto command = fmt::format("{} {} {} --machine {} --setup {} --programmed {}", python,
                                     (shared / "tools/verify_setpoints.py").string(), setpoints.string(),
                                     (shared / "data/cases/peer-trunnion.toml").string(),
                                     (shared / "data/cases/peer-setup.toml").string(), programmed.string());
    std::map<std::string, double> out;
    FILE* pipe = popen(command.c_str(), "r");
    std::string axis;
    std::array<char, 256> line{};
    while (pipe && std::fgets(line.data(), line.size(), pipe)) {
        std::array<char, 64> key{};
        double value = 0;
        const int got = std::sscanf(line.data(), " \"%63[^\"]\": %lf", key.data(), &value);
        if (got == 1 && key[1] == '\0') axis = key.data();
        if (got == 2) out[std::string(key.data()).ends_with("ratio") ? axis + "." + key.data() : key.data()] = value;
    }
    if (pipe) pclose(pipe);
    return out;
}

/// Goes along the programmed poses at a steady step and then averages over a window of rows: rounds corners.
std::vector<motion::Setpoint> rounded_motion(const std::vector<ProgrammedPose>& poses, double step_mm, int window) {
    std::vector<machine::AxisPosition> exact;
    std::array<double, 2> last{};
    const auto words_of = [&last](const ProgrammedPose& p) {
        last = std::isnan(p.rotary_rad[0]) ? words_near(p.axis, last[1]) : p.rotary_rad;
        return last;
    };
    for (std::size_t n = 1; n < poses.size(); ++n) {
        const Eigen::Vector3d way = poses[n].tip_mm - poses[n - 1].tip_mm;
        const auto from = words_of(poses[n - 1]);
        const auto to = words_of(poses[n]);
        const double size = way.norm() + 30 * (std::abs(to[0] - from[0]) + std::abs(to[1] - from[1]));
        const int count = std::max(1, static_cast<int>(size / step_mm));
        for (int k = n == 1 ? 0 : 1; k <= count; ++k) {
            const double w = static_cast<double>(k) / count;
            exact.push_back(axes_for(poses[n - 1].tip_mm + w * way, from[0] + w * (to[0] - from[0]),
                                     from[1] + w * (to[1] - from[1])));
        }
    }
    exact.insert(exact.begin(), static_cast<std::size_t>(window), exact.front());
    exact.insert(exact.end(), static_cast<std::size_t>(window), exact.back());
    std::vector<motion::Setpoint> out;
    for (std::size_t n = 0; n + window <= exact.size(); ++n) {
        machine::AxisPosition mean;
        for (std::size_t a = 0; a < 5; ++a)
            for (int k = 0; k < window; ++k) mean[a] += exact[n + k][a] / window;
        out.push_back(row(out.size(), mean));
    }
    return out;
}

std::string setpoint_csv(const std::vector<motion::Setpoint>& rows) {
    std::string out = "t_s,X_mm,Y_mm,Z_mm,A_deg,C_deg\n";
    for (const auto& r : rows)
        out += fmt::format("{},{},{},{},{},{}\n", r.time_s, r.position[0], r.position[1], r.position[2],
                           r.position[3] / degree, r.position[4] / degree);
    return out;
}

/// A case and over how many rows its motion is averaged. The outside checker looks 0.3 mm ahead: where a corner is cut
/// so that the place on the path must jump farther it loses its way for a millimetre, so dense turns are averaged less.
struct Case {
    const char* name;
    int window;
};

/// Both checkers say the same of a rounded motion along the poses of a file.
void expect_same_verdicts(const fs::path& programmed, const std::string& name, int window) {
    const auto poses = read_programmed_csv(text_of(programmed), peer_trunnion());
    ASSERT_TRUE(poses) << to_string(poses.error());
    const auto text = setpoint_csv(rounded_motion(*poses, 0.1, window));
    const fs::path file = fs::path(testing::TempDir()) / fmt::format("verify-{}.csv", name);
    std::ofstream(file) << text;
    const auto outside = outside_verdict(file, programmed);
    fs::remove(file);
    ASSERT_GT(outside.size(), 10u);

    const auto table = read_setpoint_csv(text, peer_trunnion());
    ASSERT_TRUE(table) << to_string(table.error());
    // so narrow that every row is judged at its nearest place: the outside checker knows no tolerances
    const CheckOptions narrow{.orientation_tolerance_rad = 1e-4 * degree};
    const auto ours = check(*table, *poses, peer_trunnion(), peer_setup(), narrow);
    ASSERT_TRUE(ours) << to_string(ours.error());
    const auto same = [&](const std::string& key, double value, double rounding) {
        ASSERT_TRUE(outside.contains(key)) << key;
        EXPECT_NEAR(value, outside.at(key), 1e-3 * std::abs(outside.at(key)) + rounding) << key;
    };
    for (const auto& axis : ours->axes) {
        same(fmt::format("{}.velocity_ratio", axis.letter), axis.velocity_ratio, 1e-6);
        same(fmt::format("{}.acceleration_ratio", axis.letter), axis.acceleration_ratio, 1e-6);
        same(fmt::format("{}.jerk_ratio", axis.letter), axis.jerk_ratio, 1e-6);
    }
    // it samples the path every 5 µm
    same("tip_deviation_mm", ours->tip_deviation_mm, 1e-6);
    same("height_deviation_mm", ours->height_deviation_mm, 1e-6);
    same("orientation_deviation_deg", ours->orientation_deviation_deg, 1e-5);
    same("tip_to_poses_mm", ours->tip_to_poses_mm, 1e-6);
    same("height_to_poses_mm", ours->height_to_poses_mm, 1e-6);
    same("orientation_to_poses_deg", ours->orientation_to_poses_deg, 1e-5);
    same("path_covered", ours->path_covered, 1e-9);
    same("start_error_mm", ours->start_error_mm, 1e-9);
    same("end_error_mm", ours->end_error_mm, 1e-9);
    same("cycle_time_s", ours->cycle_time_s, 1e-9);
    same("rows", static_cast<double>(ours->rows), 0);
}

class OutsideChecker : public testing::TestWithParam<Case> {};

TEST_P(OutsideChecker, Agrees) {
    if (!outside_checker_runs()) GTEST_SKIP() << "the outside checker, its cases or numpy are absent";
    const fs::path programmed = shared / "data/cases" / fmt::format("{}.csv", GetParam().name);
    expect_same_verdicts(programmed, GetParam().name, GetParam().window);
}

/// Vectors, a re-branched rapid, words, an arc by words, and moves in machine axes, as they are written.
TEST(OutsideCheckerOfWrittenPoses, Agrees) {
    if (!outside_checker_runs()) GTEST_SKIP() << "the outside checker, its cases or numpy are absent";
    const double a = 30 * degree, c = 70 * degree;
    auto program =
        program_of({by_vector({0, 0, 0}, {0, 0, 1}, 1), by_vector({10, 0, 0}, axis_of(a, c), 2),
                    by_vector({10, 0, 5}, axis_of(a, c), 3), by_words({20, 0, 0}, 40 * degree, 110 * degree, 4),
                    by_words({30, 10, 0}, 20 * degree, 90 * degree, 5), by_words({60, 0, 80}, 0, 0, 6)});
    program.moves[2].kind = program::MoveKind::rapid;
    program.moves[4].arc = 0;
    program.arcs = {{.centre_mm = {20, 10, 0}, .normal = {0, 0, 1}, .angle_rad = 90 * degree}};
    program.moves[5].space = Space::untransformed;
    const Stands stands{{.rotary_rad = {0, c}},
                        {.rotary_rad = {a, c}},
                        {.rotary_rad = {-a, c + 180 * degree}, .rebranched = true},
                        {.rotary_rad = {40 * degree, 110 * degree}},
                        {.rotary_rad = {20 * degree, 90 * degree}},
                        {.rotary_rad = {0, 0}}};
    const fs::path file = fs::path(testing::TempDir()) / "verify-written-poses.csv";
    std::ofstream(file) << programmed_csv(poses_of(program, peer_setup(), peer_trunnion(), stands), peer_trunnion());
    expect_same_verdicts(file, "written", 6);
    fs::remove(file);
}

INSTANTIATE_TEST_SUITE_P(Cases, OutsideChecker,
                         testing::Values(Case{"corner", 12}, Case{"fillet", 12}, Case{"pyramid", 12},
                                         Case{"pocket", 12}, Case{"cone", 12}, Case{"turn", 12}, Case{"line", 12},
                                         Case{"gentle-0.5", 12}, Case{"pole", 12}, Case{"sine-10k", 6}),
                         [](const auto& one) {
                             std::string name = one.param.name;
                             std::erase_if(name, [](char c) { return c == '-' || c == '.'; });
                             return name;
                         });

}  // namespace
}  // namespace trunnion::verify::test
