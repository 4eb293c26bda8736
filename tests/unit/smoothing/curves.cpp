#include <gtest/gtest.h>

#include "trunnion/geometry/bspline_curve.hpp"
#include "trunnion/path/curve_way.hpp"
#include "trunnion/smoothing/smoothing.hpp"

#include "walk.hpp"

/// Blocks along curves of the program.
namespace trunnion::smoothing {
namespace {

using namespace test;
using Eigen::Vector3d;
using path::OrientationLaw;

std::vector<double> clamped_knots(std::size_t count) {
    std::vector<double> out(4, 0);
    for (std::size_t i = 1; i + 3 < count; ++i) out.push_back(static_cast<double>(i));
    out.insert(out.end(), 4, static_cast<double>(count - 3));
    return out;
}

path::PathCoordinates coordinates(const Vector3d& position, const Vector3d& orientation) {
    return {{position.x(), position.y(), position.z()}, {orientation.x(), orientation.y(), orientation.z()}};
}

void add_block(path::Run& run, const path::PathCoordinates& to, std::int32_t curve = path::no_curve) {
    path::Block block{.curve = curve};
    run.vertices.push_back(to);
    block.feed = {program::FeedRule::tip_speed, 100};
    run.blocks.push_back(block);
    const std::size_t last = run.blocks.size() - 1;
    run.blocks[last].length_mm = curve == path::no_curve
                                     ? path::block_length_mm(run, run.vertices[last], run.vertices[last + 1])
                                     : path::CurveWay(run, last).length_mm(0, 1);
}

/// Cubic splines of position and orientation from the same control numbers as a run, one block a knot interval.
path::Run run_along(const std::vector<Vector3d>& position, const std::vector<Vector3d>& orientation, OrientationLaw law,
                    const std::vector<double>& weights = {}) {
    const auto knots = clamped_knots(position.size());
    const auto tip = geometry::BsplineCurve::make(3, knots, position, weights).value();
    const auto turn = geometry::BsplineCurve::make(3, knots, orientation, weights).value();
    const auto place = [&](double u) {
        const Vector3d there = turn.evaluate(u)[0];
        return coordinates(tip.evaluate(u)[0], law == OrientationLaw::vector ? there.normalized() : there);
    };
    path::Run run;
    run.law = law;
    run.kinematics = &table();
    run.vertices = {place(0)};
    for (double u = 0; u < tip.end(); ++u) {
        run.curves.push_back({tip.piece(u, u + 1), turn.piece(u, u + 1)});
        add_block(run, place(u + 1), static_cast<std::int32_t>(run.curves.size()) - 1);
    }
    return run;
}

path::Run wave(OrientationLaw law, bool weighted = false, int count = 24) {
    std::vector<Vector3d> position, orientation;
    std::vector<double> weights;
    for (int i = 0; i < count; ++i) {
        position.emplace_back(2 * i, 6 * std::sin(0.5 * i), std::cos(0.8 * i));
        orientation.push_back(law == OrientationLaw::vector
                                  ? Vector3d(10 + 3 * std::sin(0.4 * i), 4 * std::cos(0.3 * i), 30)
                                  : Vector3d((25 + 5 * std::sin(0.4 * i)) * degree, 3.0 * i * degree, 0));
        if (weighted) weights.push_back(1 + 0.5 * std::sin(1.1 * i));
    }
    return run_along(position, orientation, law, weights);
}

struct Off {
    double tip_mm = 1e9, turn_rad = 1e9;
    double square() const { return tip_mm * tip_mm + 900 * turn_rad * turn_rad; }
};

/// Distance of a tool from a place of a block.
Off off_place(const path::Run& run, std::size_t block, double v, const Tool& tool) {
    Pose q = programmed(run, block, v);
    if (run.blocks[block].curve != path::no_curve) {
        const auto there = path::CurveWay(run, block).at(v);
        q = {there.position_mm[0], there.position_mm[1], there.position_mm[2],
             there.orientation[0], there.orientation[1], there.orientation[2]};
    }
    const Tool programmed_tool = tool_at(run, q);
    return {(programmed_tool.tip - tool.tip).norm(), geometry::angle_between(programmed_tool.axis, tool.axis)};
}

/// Distance of a tool from the run, nearest on any of its blocks by the metric of the path.
Off off_programmed(const path::Run& run, const Tool& tool) {
    constexpr int parts = 16, rounds = 9;
    constexpr double far_mm = 6;
    Off best;
    for (std::size_t block = 0; block < run.blocks.size(); ++block) {
        if (off_place(run, block, 0.5, tool).tip_mm > far_mm + run.blocks[block].length_mm) continue;
        double from = 0, to = 1;
        for (int round = 0; round < rounds; ++round) {
            double nearest = from;
            Off least;
            for (int k = 0; k <= parts; ++k) {
                const double v = from + k * (to - from) / parts;
                const Off off = off_place(run, block, v, tool);
                if (off.square() < least.square()) least = off, nearest = v;
            }
            if (least.square() < best.square()) best = least;
            const double step = (to - from) / parts;
            from = std::max(0.0, nearest - step);
            to = std::min(1.0, nearest + step);
        }
    }
    return best;
}

struct Seen {
    double tip_mm = 0, turn_rad = 0, bound_mm = 0, bound_rad = 0;
    double jump = 0;  ///< of value, tangent and curvature where pieces meet
};

Seen seen(const path::Run& run, const std::vector<path::ToolPath>& paths, int every) {
    Seen out;
    int count = 0;
    for (const path::ToolPath& path : paths) {
        out.bound_mm = std::max(out.bound_mm, path.bound.tip_mm);
        out.bound_rad = std::max(out.bound_rad, path.bound.orientation_rad);
        for (std::size_t i = 0; i < path.pieces.size(); ++i) {
            const auto& piece = path.pieces[i];
            if (i > 0) {
                const auto& before = path.pieces[i - 1];
                const auto a = path::evaluate(before, before.length_mm), b = path::evaluate(piece, 0);
                for (std::size_t k = 0; k < 6; ++k)
                    for (int order = 0; order < 3; ++order)
                        out.jump = std::max(out.jump, std::abs(a[k].c[order] - b[k].c[order]));
            }
            if (count++ % every != 0) continue;
            const auto at = path::evaluate(piece, 0.37 * piece.length_mm);
            const Tool tool = tool_at(
                run, {at[0].value(), at[1].value(), at[2].value(), at[3].value(), at[4].value(), at[5].value()});
            const Off off = off_programmed(run, tool);
            out.tip_mm = std::max(out.tip_mm, off.tip_mm);
            out.turn_rad = std::max(out.turn_rad, off.turn_rad);
        }
    }
    return out;
}

constexpr double sampled = 1e-7;

std::vector<path::ToolPath> smoothed(const path::Run& run, const SmoothingOptions& options) {
    std::vector<path::ToolPath> out;
    smooth(run, options, out);
    return out;
}

TEST(Curve, ThatGoesOnIsFollowedExactly) {
    for (const Rounding rounding : {Rounding::smooth, Rounding::none})
        for (const OrientationLaw law : {OrientationLaw::vector, OrientationLaw::rotary})
            for (const bool weighted : {false, true}) {
                const path::Run run = wave(law, weighted);
                const auto paths = smoothed(run, {.rounding = rounding});
                ASSERT_EQ(paths.size(), 1u);
                const Seen s = seen(run, paths, 61);
                EXPECT_LT(s.bound_mm, 2e-8);
                EXPECT_LT(s.bound_rad, 2e-10);
                EXPECT_LT(s.tip_mm, sampled);
                EXPECT_LT(s.jump, 1e-7);
                double length = 0;
                for (const auto& block : run.blocks) length += block.length_mm;
                EXPECT_NEAR(paths[0].length_mm(), length, 1e-6);
                EXPECT_NEAR(paths[0].blocks.back().end_mm, length, 1e-6);
            }
}

TEST(Curve, IsFollowedAtAnEvenPace) {
    for (const OrientationLaw law : {OrientationLaw::vector, OrientationLaw::rotary}) {
        const path::Run run = wave(law);
        const auto paths = smoothed(run, {});
        EXPECT_LT(paths[0].pieces.size(), 12 * run.blocks.size()) << "septic pieces follow a smooth way from afar";
        for (const auto& piece : paths[0].pieces)
            for (const double u : {0.0, 0.3, 0.6}) {
                const auto at = path::evaluate(piece, u * piece.length_mm);
                double square = 0;
                for (int k = 0; k < 3; ++k) square += at[k].d1() * at[k].d1();
                for (int k = 3; k < 6; ++k) square += 900 * at[k].d1() * at[k].d1();
                EXPECT_NEAR(std::sqrt(square), 1, 1e-4);
            }
    }
}

/// A line of 20 mm, a curve, and another line, with corners between.
path::Run between_lines(OrientationLaw law) {
    const path::Run curve = wave(law, true, 12);
    path::Run run;
    run.law = law;
    run.kinematics = &table();
    auto first = curve.vertices.front(), last = curve.vertices.back();
    first.position_mm[2] += 20;
    last.position_mm[1] -= 20;
    run.curves = curve.curves;
    run.vertices = {first};
    add_block(run, curve.vertices.front());
    for (std::size_t i = 0; i < curve.blocks.size(); ++i) add_block(run, curve.vertices[i + 1], curve.blocks[i].curve);
    add_block(run, last);
    return run;
}

TEST(Curve, WithCornersIsRoundedWithinTolerance) {
    for (const OrientationLaw law : {OrientationLaw::vector, OrientationLaw::rotary})
        for (const double tolerance : {0.02, 0.002}) {
            const path::Run run = between_lines(law);
            const SmoothingOptions options{.tip_tolerance_mm = tolerance};
            const auto paths = smoothed(run, options);
            ASSERT_EQ(paths.size(), 1u);
            const Seen s = seen(run, paths, 3);
            EXPECT_LE(s.bound_mm, tolerance);
            EXPECT_GT(s.bound_mm, 0.5 * tolerance) << "the tolerance is there to be used";
            EXPECT_LE(s.bound_rad, options.orientation_tolerance_rad);
            EXPECT_LE(s.tip_mm, s.bound_mm + sampled) << "the bound does not hold";
            EXPECT_LE(s.turn_rad, s.bound_rad + sampled);
            EXPECT_LT(s.jump, 1e-9);
        }
}

TEST(Curve, WithoutRoundingStopsAtCornersAlone) {
    const path::Run run = between_lines(OrientationLaw::vector);
    const auto paths = smoothed(run, {.rounding = Rounding::none});
    ASSERT_EQ(paths.size(), 3u);
    EXPECT_EQ(paths[1].blocks.size(), run.blocks.size() - 2);
    EXPECT_LT(seen(run, paths, 4).bound_mm, 2e-8);
}

TEST(Curve, IsRoundedCornerByCornerToo) {
    const path::Run run = between_lines(OrientationLaw::vector);
    const SmoothingOptions options{.rounding = Rounding::beudaert};
    const Seen s = seen(run, smoothed(run, options), 11);
    EXPECT_LE(s.bound_mm, options.tip_tolerance_mm);
    EXPECT_LE(s.tip_mm, s.bound_mm + sampled);
    EXPECT_LE(s.bound_rad, options.orientation_tolerance_rad);
}

TEST(Curve, WithAKinkInsideIsRoundedThere) {
    path::Run run = wave(OrientationLaw::vector, false, 12);
    auto& piece = run.curves[4].position;
    const Vector3d off(0, 0.8, 0);  // of its second control point: another tangent where it begins
    piece.control[1].head<3>() += off;
    run.blocks[4].length_mm = path::CurveWay(run, 4).length_mm(0, 1);
    const auto paths = smoothed(run, {});
    ASSERT_EQ(paths.size(), 1u);
    const Seen s = seen(run, paths, 7);
    EXPECT_LE(s.bound_mm, 0.02);
    EXPECT_GT(s.bound_mm, 0.005);
    EXPECT_EQ(smoothed(run, {.rounding = Rounding::none}).size(), 3u) << "curvature changes where the block ends";
}

TEST(Curve, InMachineAxesKeepsTheTolerance) {
    path::Run run = between_lines(OrientationLaw::rotary);
    run.space = path::Space::machine;
    for (std::size_t i = 0; i < run.blocks.size(); ++i)
        run.blocks[i].length_mm = run.blocks[i].curve == path::no_curve
                                      ? path::block_length_mm(run, run.vertices[i], run.vertices[i + 1])
                                      : path::CurveWay(run, i).length_mm(0, 1);
    for (const path::ToolPath& path : smoothed(run, {})) {
        EXPECT_LE(path.bound.tip_mm, 0.02);
        EXPECT_LE(path.bound.orientation_rad, 0.1 * degree);
    }
}

TEST(Curve, WhoseParameterStandsStillIsRoundedAllTheSame) {
    path::Run run = wave(OrientationLaw::vector, false, 12);
    auto& piece = run.curves[4].position;
    piece.control[1] = piece.control[0];  // dC/du = 0 at its begin
    run.blocks[4].length_mm = path::CurveWay(run, 4).length_mm(0, 1);
    for (const path::ToolPath& path : smoothed(run, {})) {
        EXPECT_LE(path.bound.tip_mm, 0.02);
        for (const auto& p : path.pieces)
            for (const auto& c : p.coefficient)
                for (const double x : c) EXPECT_TRUE(std::isfinite(x));
    }
}

}  // namespace
}  // namespace trunnion::smoothing
