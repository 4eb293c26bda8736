// Programs whose stretches become dual splines, are deformed and go on as programs.
#include "trunnion/pipeline/deform.hpp"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>

#include <gtest/gtest.h>

#include "trunnion/base/quantity.hpp"
#include "trunnion/deformation/dual_path_program.hpp"
#include "trunnion/files/machine_file.hpp"
#include "trunnion/geometry/great_circle.hpp"
#include "trunnion/nc/read.hpp"
#include "trunnion/nc/write.hpp"

namespace trunnion::pipeline {
namespace {

using deformation::CuttingStretch;
using deformation::DualPath;
using Eigen::Vector3d;
using program::FeedRule;
using program::Move;
using program::MoveKind;
using program::Program;

machine::Machine five_axes() {
    return *files::read_machine_file(TRUNNION_SOURCE_DIR "/data/machines/ucp710.toml");
}

std::vector<std::vector<Vector3d>> guide_curves() {
    std::vector<std::vector<Vector3d>> out(2);
    for (int i = 0; i <= 20; ++i) {
        const double w = i / 20.0, lean = 25 * degree * (w - 0.5) + 15 * degree;
        const Vector3d bottom(80 * w, 10 * w * (1 - w), 0);
        out[0].push_back(bottom);
        out[1].push_back(bottom + 25 * Vector3d(0, std::sin(lean), std::cos(lean)));
    }
    return out;
}

machine::Setup with_tool(double diameter_mm) {
    machine::Setup out;
    out.tool.diameter_mm = diameter_mm;
    out.tool.length_mm = 100;
    return out;
}

/// A rapid to the blade, the poses that pass both edges, and a rapid off it.
Program blade_program() {
    const auto surface = *deformation::guided_surface(guide_curves(), deformation::Side::against);
    const auto poses = *deformation::two_point_poses(surface, {.radius_mm = 5}, 25, 2);
    Program out;
    out.source = "blade.cls";
    const auto add = [&](const deformation::Pose& pose, MoveKind kind) {
        Move move;
        move.kind = kind;
        move.position_mm = pose.tip_in_workpiece_mm;
        move.axis = pose.axis_in_workpiece;
        if (kind == MoveKind::feed) move.feed = {FeedRule::tip_speed, out.moves.size() < 12 ? 20.0 : 30.0};
        move.line = static_cast<std::int32_t>(out.moves.size()) + 1;
        out.moves.push_back(move);
    };
    add({poses.front().tip_in_workpiece_mm + Vector3d(0, 0, 30), poses.front().axis_in_workpiece}, MoveKind::rapid);
    add(poses.front(), MoveKind::rapid);
    for (std::size_t i = 1; i < poses.size(); ++i) add(poses[i], MoveKind::feed);
    add({poses.back().tip_in_workpiece_mm + Vector3d(0, 0, 30), poses.back().axis_in_workpiece}, MoveKind::rapid);
    program::Event event;
    event.word = "M9";
    event.before_move = out.moves.size() - 1;
    out.events.push_back(event);
    return out;
}

FitFlank flank() {
    FitFlank out{.guide_curves_mm = guide_curves()};
    out.options.range = {.from_height_mm = 2, .to_height_mm = 27};
    return out;
}

DeformedProgram deformed(const DeformOptions& options, const Program& program = blade_program()) {
    auto made = deform(program, five_axes(), with_tool(10), options);
    if (!made) throw std::runtime_error(to_string(made.error()));
    return std::move(*made);
}

TEST(Deform, AFlankProgramStaysASplineAndFitsBetter) {
    const auto made = deformed({.aim = flank()});
    ASSERT_EQ(made.stretches.size(), 1u);
    EXPECT_LT(made.stretches[0].after, made.stretches[0].before / 3);
    EXPECT_GT(made.stretches[0].tip_movement_mm, 1e-3);
    EXPECT_EQ(made.stretches[0].first_line, 3);
    const Program& out = made.program;
    ASSERT_EQ(out.curves.size(), 1u);
    EXPECT_EQ(out.curves[0].degree, 3);
    EXPECT_EQ(out.moves.front().kind, MoveKind::rapid);
    EXPECT_EQ(out.moves.back().kind, MoveKind::rapid);
    EXPECT_EQ(out.events[0].before_move, out.moves.size() - 1) << "before the rapid off, as it was";
    const DualPath path = *deformation::dual_path_of(out, deformation::cutting_stretches(out)[0], 50);
    EXPECT_LT((out.moves[1].position_mm - path.at(0).tip_in_workpiece_mm).norm(), 1e-9)
        << "the rapid goes to its start";
    EXPECT_EQ(out.moves[2].feed.value, 20);
    EXPECT_EQ(out.moves[out.moves.size() - 2].feed.value, 30);
}

TEST(Deform, SinumerikSplinesReadBackAreTheSameCurve) {
    const auto made = deformed({.aim = flank()});
    const auto machine = five_axes();
    nc::WriteOptions writing;
    writing.dialect = nc::Dialect::sinumerik;
    const auto text = nc::write_text(made.program, &machine, writing);
    ASSERT_TRUE(text) << to_string(text.error());
    EXPECT_NE(text->find("BSPLINE"), std::string::npos);
    const auto again = nc::read_program(*text, "blade.mpf", {.machine = &machine});
    ASSERT_TRUE(again) << to_string(again.error());
    const auto was = deformation::cutting_stretches(made.program), is = deformation::cutting_stretches(*again);
    ASSERT_EQ(was.size(), 1u);
    const auto spline = *std::ranges::find_if(is, [&](const CuttingStretch& s) { return s.last > s.first + 3; });
    CuttingStretch curve = spline;
    while (again->moves[curve.first].curve_part == program::no_curve_part) ++curve.first;
    const DualPath before = *deformation::dual_path_of(made.program, was[0], 50);
    const auto after = deformation::dual_path_of(*again, curve, 50);
    ASSERT_TRUE(after) << to_string(after.error());
    for (double share = 0; share <= 1; share += 0.01) {
        const auto a = before.at(std::lerp(before.begin(), before.end(), share));
        const auto b = after->at(std::lerp(after->begin(), after->end(), share));
        EXPECT_LT((a.tip_in_workpiece_mm - b.tip_in_workpiece_mm).norm(), 2e-4);
        EXPECT_LT((a.axis_in_workpiece - b.axis_in_workpiece).norm(), 1e-5);
    }
}

TEST(Deform, ChordsKeepTheirTolerance) {
    const auto curves = deformed({.aim = flank()});
    const auto chords = deformed({.aim = flank(), .chords = deformation::Chords{1e-3, 1e-4}});
    EXPECT_TRUE(chords.program.curves.empty());
    const DualPath path =
        *deformation::dual_path_of(curves.program, deformation::cutting_stretches(curves.program)[0], 50);
    const auto& moves = chords.program.moves;
    double worst = 0;
    double u = 0;
    for (std::size_t k = 2; k + 1 < moves.size(); ++k) {
        const Vector3d middle = 0.5 * (moves[k - 1].position_mm + moves[k].position_mm);
        double nearest = 1;
        for (double at = std::max(0.0, u - 2); at <= std::min(path.end(), u + 4); at += 0.002) {
            const double off = (path.at(at).tip_in_workpiece_mm - middle).norm();
            if (off < nearest) nearest = off, u = at;
        }
        worst = std::max(worst, nearest);
    }
    EXPECT_LT(worst, 2.1e-3);
}

TEST(Deform, DeflectionIsTakenOffTheTip) {
    std::vector<deformation::DeflectionSample> samples;
    for (int i = 0; i <= 12; ++i) samples.push_back({10.0 * i, Vector3d(0, 0.02 + 0.001 * i, 0)});
    const auto made = deformed({.aim = CompensateDeflection{samples, 1e-4}});
    EXPECT_LE(made.stretches[0].after, 1e-4);
    EXPECT_NEAR(made.stretches[0].tip_movement_mm, made.stretches[0].before, 2e-4);
    const Program before = blade_program();
    EXPECT_NEAR(made.program.moves[made.program.moves.size() - 2].position_mm.y() - before.moves[25].position_mm.y(),
                -0.028, 1e-3);
}

TEST(Deform, RotaryMotionAndThePoleAreReachedToo) {
    const auto reduced = deformed({.aim = ReduceRotary{1 * degree}});
    EXPECT_LE(reduced.stretches[0].after, reduced.stretches[0].before);
    EXPECT_LE(reduced.stretches[0].orientation_change_rad, 1.001 * degree);
    const auto avoided = deformed({.aim = AvoidPole{1 * degree}});
    EXPECT_LE(avoided.stretches[0].after, avoided.stretches[0].before * (1 + 1e-9));
    EXPECT_LE(avoided.stretches[0].orientation_change_rad, 1.001 * degree);
}

TEST(Deform, RefusesWhatItCannotDo) {
    const auto refusal = [](const Program& program, const machine::Setup& setup, const DeformOptions& options) {
        const auto made = deform(program, five_axes(), setup, options);
        return made ? std::string("accepted") : made.error().code;
    };
    const Program program = blade_program();
    EXPECT_EQ(refusal(program, with_tool(0), {.aim = flank()}), "PIPE0022");
    EXPECT_EQ(refusal(program, with_tool(10), {.aim = CompensateDeflection{{{0, {0, 0, 0}}, {5, {0, 0, 0}}}}}),
              "DEFO0117");
    Program rapids = program;
    for (Move& move : rapids.moves) move.kind = MoveKind::rapid;
    EXPECT_EQ(refusal(rapids, with_tool(10), {.aim = flank()}), "PIPE0021");
}

TEST(Deform, TablesAreReadAndBadOnesRefused) {
    const auto file = std::filesystem::path(testing::TempDir()) / "trunnion_deform_table.csv";
    const auto written = [&](const std::string& text) {
        std::ofstream(file) << text;
        return file;
    };
    const auto rows = read_guide_curves(written("row,x_mm,y_mm,z_mm\n0,1,2,3\n0,4,5,6\n1,1,2,9\r\n1,4,5,1e1\n"));
    ASSERT_TRUE(rows) << to_string(rows.error());
    ASSERT_EQ(rows->size(), 2u);
    EXPECT_EQ((*rows)[1][1], Vector3d(4, 5, 10));
    for (const char* bad :
         {"", "x\n", "row,x_mm,y_mm,z_mm\n", "row,x_mm,y_mm,z_mm\n0,1,2\n", "row,x_mm,y_mm,z_mm\n1,1,2,3\n",
          "row,x_mm,y_mm,z_mm\n0,1,2,3\n0,1,nan,3\n", "row,x_mm,y_mm,z_mm\n0,1,2,3,4\n"}) {
        const auto refused = read_guide_curves(written(bad));
        ASSERT_FALSE(refused) << bad;
        EXPECT_EQ(refused.error().code, "PIPE0023");
    }
    const auto samples = read_deflections(written("s_mm,x_mm,y_mm,z_mm\n0,0,0,0\n10,0.1,0,-0.2\n"));
    ASSERT_TRUE(samples);
    EXPECT_EQ((*samples)[1].deflection_mm, Vector3d(0.1, 0, -0.2));
    EXPECT_EQ(read_deflections(written("s,x\n")).error().code, "PIPE0023");
    std::filesystem::remove(file);
}

}  // namespace
}  // namespace trunnion::pipeline
