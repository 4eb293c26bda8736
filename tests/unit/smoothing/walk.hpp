#pragma once

#include <algorithm>
#include <limits>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "trunnion/geometry/great_circle.hpp"
#include "trunnion/path/tool_path.hpp"
#include "trunnion/smoothing/smoothing.hpp"

#include "runs.hpp"

namespace trunnion::smoothing::test {

/// A place on an arc: the spoke of the start, turned about the normal (Rodrigues), and the climb.
inline Eigen::Vector3d on_arc(const program::Arc& arc, const Eigen::Vector3d& from, const Eigen::Vector3d& to,
                              double part) {
    const Eigen::Vector3d n = arc.normal, arm = from - arc.centre_mm, spoke = arm - arm.dot(n) * n;
    const double turn = part * arc.angle_rad;
    return from - spoke + std::cos(turn) * spoke + std::sin(turn) * n.cross(spoke) + part * (to - from).dot(n) * n;
}

/// The programmed place at a part of a block: position straight or on its arc, vector by slerp, rotary axes straight.
inline Pose programmed(const path::Run& run, std::size_t block, double part) {
    const auto& a = run.vertices[block];
    const auto& b = run.vertices[block + 1];
    Pose q{};
    for (int k = 0; k < 3; ++k) {
        q[k] = a.position_mm[k] + part * (b.position_mm[k] - a.position_mm[k]);
        q[3 + k] = a.orientation[k] + part * (b.orientation[k] - a.orientation[k]);
    }
    if (run.blocks[block].arc != program::no_arc) {
        const Eigen::Vector3d at = on_arc(run.arcs[run.blocks[block].arc], Eigen::Vector3d(a.position_mm.data()),
                                          Eigen::Vector3d(b.position_mm.data()), part);
        for (int k = 0; k < 3; ++k) q[k] = at[k];
    }
    if (run.law == path::OrientationLaw::vector && run.space == path::Space::workpiece) {
        const Eigen::Vector3d n =
            geometry::slerp(Eigen::Vector3d(a.orientation.data()), Eigen::Vector3d(b.orientation.data()), part);
        for (int k = 0; k < 3; ++k) q[3 + k] = n[k];
    }
    return q;
}

struct Tool {
    Eigen::Vector3d tip, axis;
};

/// What the coordinates mean for the tool in the workpiece.
inline Tool tool_at(const path::Run& run, const Pose& q) {
    const Eigen::Vector3d position(q[0], q[1], q[2]);
    if (run.space == path::Space::machine) {
        const auto pose = run.kinematics->forward({{q[0], q[1], q[2], q[3], q[4]}});
        return {pose.tip_in_workpiece_mm, pose.axis_in_workpiece};
    }
    if (run.law == path::OrientationLaw::vector) return {position, Eigen::Vector3d(q[3], q[4], q[5]).normalized()};
    return {position, run.kinematics->tool_axis(machine::RotaryPosition{q[3], q[4]})};
}

/// Everything that a test wants to know of the stretches of a run, by dense evaluation.
struct Walk {
    double tip_mm = 0, turn_rad = 0, height_mm = 0;  // largest deviation at equal p
    double bound_tip_mm = 0, bound_turn_rad = 0, bound_height_mm = 0;
    double over_tip = 0, over_turn = 0, over_height = 0;  // largest sample − bound of its own stretch
    double jump = 0;        // largest relative step of value or a derivative between pieces
    double jump_to_c2 = 0;  // the same without the third derivative
    double least_speed = std::numeric_limits<double>::infinity();
    double end_second = 0;   // largest |c″| at an end
    double end_miss = 0;     // largest |c − Q| at an end
    double axis_length = 1;  // least length of the orientation vector
    bool finite = true;
    std::size_t pieces = 0, stretches = 0;
    std::vector<float> use;
};

inline double size_of(const Pose& a) {
    return std::hypot(std::hypot(a[0], a[1], a[2]), path::reference_height_mm * std::hypot(a[3], a[4], a[5]));
}

inline Pose derivative(const path::PathPiece& piece, double offset_mm, int order) {
    const auto series = path::evaluate(piece, offset_mm);
    constexpr double factorial[] = {1, 1, 2, 6};
    Pose d{};
    for (int k = 0; k < 6; ++k) d[k] = series[k].c[order] * factorial[order];
    return d;
}

/// Steps of derivative k between abutting pieces, relative to the largest derivative k near by or to what rounding of
/// the coordinates makes of it.
inline void check_joints(const path::ToolPath& path, Walk& walk) {
    for (std::size_t i = 0; i + 1 < path.pieces.size(); ++i) {
        const auto &a = path.pieces[i], &b = path.pieces[i + 1];
        const double h = std::min(a.length_mm, b.length_mm);
        for (int order = 0; order < 4; ++order) {
            const Pose before = derivative(a, a.length_mm, order), after = derivative(b, 0, order);
            Pose step{};
            for (int k = 0; k < 6; ++k) step[k] = after[k] - before[k];
            const double scale =
                order == 0 ? std::max(1.0, size_of(after)) : std::max(size_of(after), 1 / std::pow(h, order - 1));
            walk.jump = std::max(walk.jump, size_of(step) / scale);
            if (order < 3) walk.jump_to_c2 = std::max(walk.jump_to_c2, size_of(step) / scale);
        }
    }
}

inline double speed_of(const path::Run& run, const Pose& at, const Pose& d) {
    Pose t = d;
    if (run.law == path::OrientationLaw::rotary || run.space == path::Space::machine)
        t[4] *= std::max(run.kinematics->lever({at[3], at[4]}), 0.1);
    return size_of(t);
}

inline Walk walk(const path::Run& run, const std::vector<path::ToolPath>& paths, double height_mm = 30,
                 double controlled_mm = 0, int per_piece = 12) {
    Walk w;
    for (const auto& path : paths) {
        ++w.stretches;
        w.pieces += path.pieces.size();
        w.use.insert(w.use.end(), path.transition_use.begin(), path.transition_use.end());
        w.bound_tip_mm = std::max(w.bound_tip_mm, path.bound.tip_mm);
        w.bound_turn_rad = std::max(w.bound_turn_rad, path.bound.orientation_rad);
        w.bound_height_mm = std::max(w.bound_height_mm, path.bound.height_mm);
        check_joints(path, w);
        std::size_t span = 0;
        double tip = 0, turn = 0, height = 0;
        for (const auto& piece : path.pieces) {
            std::vector<double> offsets;
            for (int s = 0; s <= per_piece; ++s) offsets.push_back(piece.length_mm * s / per_piece);
            for (std::size_t b = span;
                 b < path.blocks.size() && path.blocks[b].begin_mm < piece.begin_mm + piece.length_mm; ++b)
                if (path.blocks[b].begin_mm > piece.begin_mm)
                    offsets.push_back(path.blocks[b].begin_mm - piece.begin_mm);
            std::sort(offsets.begin(), offsets.end());
            for (const double offset : offsets) {
                const double p = piece.begin_mm + offset;
                while (span + 1 < path.blocks.size() && path.blocks[span].end_mm <= p) ++span;
                const auto& s = path.blocks[span];
                const double part = std::clamp((p - s.begin_mm) / s.time_scale_mm, 0.0, 1.0);
                const Pose c = derivative(piece, offset, 0);
                for (const double x : c) w.finite = w.finite && std::isfinite(x);
                const Tool is = tool_at(run, c), was = tool_at(run, programmed(run, s.run_block, part));
                tip = std::max(tip, (is.tip + controlled_mm * is.axis - was.tip - controlled_mm * was.axis).norm());
                turn = std::max(turn, geometry::angle_between(is.axis, was.axis));
                height = std::max(height, (is.tip + height_mm * is.axis - was.tip - height_mm * was.axis).norm());
                w.least_speed = std::min(w.least_speed, speed_of(run, c, derivative(piece, offset, 1)));
                if (run.law == path::OrientationLaw::vector && run.space == path::Space::workpiece)
                    w.axis_length = std::min(w.axis_length, std::hypot(c[3], c[4], c[5]));
            }
        }
        w.tip_mm = std::max(w.tip_mm, tip);
        w.turn_rad = std::max(w.turn_rad, turn);
        w.height_mm = std::max(w.height_mm, height);
        w.over_tip = std::max(w.over_tip, tip - path.bound.tip_mm);
        w.over_turn = std::max(w.over_turn, turn - path.bound.orientation_rad);
        w.over_height = std::max(w.over_height, height - path.bound.height_mm);
        const auto &head = path.pieces.front(), &tail = path.pieces.back();
        for (const bool end : {false, true}) {
            const auto& piece = end ? tail : head;
            const double at = end ? piece.length_mm : 0;
            Pose miss = derivative(piece, at, 0);
            const Pose q =
                programmed(run, end ? path.blocks.back().run_block : path.blocks.front().run_block, end ? 1 : 0);
            for (int k = 0; k < 6; ++k) miss[k] -= q[k];
            w.end_miss = std::max(w.end_miss, size_of(miss));
            w.end_second = std::max(w.end_second, size_of(derivative(piece, at, 2)));
        }
    }
    return w;
}

/// The bounds hold what is seen, and keep the tolerances; both ends are the programmed ones.
inline void expect_bounded(const Walk& w, const SmoothingOptions& o) {
    EXPECT_TRUE(w.finite);
    EXPECT_LE(w.over_tip, 1e-9) << "the bound does not hold";
    EXPECT_LE(w.over_turn, 1e-9);
    EXPECT_LE(w.over_height, 1e-8);
    EXPECT_LE(w.bound_tip_mm, o.tip_tolerance_mm);
    if (o.flank_tolerance_mm > 0) {
        EXPECT_LE(w.bound_height_mm, o.flank_tolerance_mm);
    } else {
        EXPECT_LE(w.bound_turn_rad, o.orientation_tolerance_rad);
    }
    EXPECT_LE(w.end_miss, 1e-9);
}

}  // namespace trunnion::smoothing::test
