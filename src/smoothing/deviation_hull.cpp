#include "detail/deviation_hull.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace trunnion::smoothing {

namespace {

constexpr int most_halvings = 6;
constexpr double worth_halving = 1.01;  // a hull that exceeds the largest deviation seen by more than this

double angle_of_chord(double chord) {
    return 2 * std::asin(std::min(0.5 * chord, 1.0));
}

}  // namespace

void widen(Extent& a, const Extent& b) {
    a.tip = std::max(a.tip, b.tip);
    a.turn = std::max(a.turn, b.turn);
    a.height = std::max(a.height, b.height);
}

DeviationHull::DeviationHull(const path::Run& run, const Measure& measure, const Polyline& line)
    : run_(run),
      measure_(measure),
      lever_axis_(lever_axis(run)),
      has_frames_(!measure.vectors() && run.kinematics && run.kinematics->rotary_count() > 0) {
    const double turn = line.largest_turn_rad;
    sideways_ = chord_sideways * turn * turn * turn;
    const double off_mm = 1.01 * line.chord_error_mm;  // and what an arc is off along the chord
    const double arm_mm = 2 * measure.arm_mm();        // both axes
    chord_.turn = line.chord_turn_rad;
    chord_.tip = off_mm + (measure.controlled_height_mm() + arm_mm) * line.chord_turn_rad;
    chord_.height = off_mm + (measure.flank_height_mm() + arm_mm) * line.chord_turn_rad;
}

Extent DeviationHull::over(const Bernstein& curve, const Coordinates& from, const Coordinates& to) {
    return over(curve, from, to, lever_bound(from, to), 0);
}

double DeviationHull::lever_bound(const Coordinates& from, const Coordinates& to) const {
    if (lever_axis_ < 0) return 1;
    const int other = lever_axis_ == 3 ? 4 : 3;
    return std::min(1.0, lever_at(run_, 0.5 * (from + to)) + 0.5 * std::abs(to[other] - from[other]));
}

Extent DeviationHull::measured(const Coordinates& d, double lever) const {
    return {measure_.point(d, lever, measure_.controlled_height_mm()), measure_.turn(d, lever),
            measure_.point(d, lever, measure_.flank_height_mm())};
}

/// Only the part of a vector's deviation across the tool axis turns it. Takes the part along the axis at the cell's
/// middle out of `d` and adds to `slack` what that and the linear measures leave out, as an angle.
double DeviationHull::take_across(Bernstein& d, const Bernstein& curve, const Coordinates& from,
                                  const Coordinates& to) const {
    const Eigen::Vector3d along = (from + to).tail<3>().normalized();
    const double half_turn = (to - from).tail<3>().norm();  // twice the half: the chord's ends lie inside the sphere
    double all = 0, across = 0, radial = 0;
    for (int k = 0; k < 8; ++k) {
        const Eigen::Vector3d n = d[k].tail<3>();
        const double length = along.dot(n);
        d[k].tail<3>() -= length * along;
        all = std::max(all, n.norm());
        across = std::max(across, d[k].tail<3>().norm());
        radial = std::max({radial, curve[k].tail<3>().norm() - 1, 1 - along.dot(curve[k].tail<3>())});
    }
    if (radial > 0.5) return std::numbers::pi;
    const double sine = (across + all * half_turn) / (1 - radial);
    return all * half_turn + sine * radial + sine * sine + sideways_;
}

/// The lever on the deviated path too.
double DeviationHull::lever_beside(const Bernstein& d, double lever) const {
    if (lever_axis_ < 0) return 1;
    const int other = lever_axis_ == 3 ? 4 : 3;
    double largest = 0;
    for (const Coordinates& x : d) largest = std::max(largest, std::abs(x[other]));
    return std::min(1.0, lever + largest);
}

DeviationHull::Frame DeviationHull::frame(const Coordinates& at) const {
    const machine::Kinematics& kinematics = *run_.kinematics;
    const bool in_machine = run_.space == path::Space::machine;
    Frame out;
    out.tip.setZero();
    out.axis.setZero();
    if (!in_machine) out.tip.leftCols<3>().setIdentity();
    for (int k = in_machine ? 0 : 3; k < 5; ++k) {
        std::array<Taylor3, 5> q;
        for (int i = 0; i < 5; ++i) q[i] = Taylor3(at[i], i == k ? 1 : 0, 0, 0);
        const machine::RotarySeries rotary{q[3], q[4]};
        const machine::VectorSeries axis = kinematics.tool_axis(rotary);
        const machine::VectorSeries tip =
            in_machine ? kinematics.tip_for({q[0], q[1], q[2]}, rotary) : machine::VectorSeries{};
        for (int i = 0; i < 3; ++i) {
            out.axis(i, k) = axis[i].d1();
            if (in_machine) out.tip(i, k) = tip[i].d1();
        }
    }
    return out;
}

double DeviationHull::point(const Frame& frame, const Coordinates& d, double height_mm) const {
    return (frame.tip * d + height_mm * (frame.axis * d)).norm();
}

/// What a frame leaves out over a cell whose blocks turn by `step`: the frame turns by at most half of that, and with
/// the deviation itself.
double DeviationHull::beyond_frame(const Bernstein& d, const Coordinates& step, double height_mm) const {
    const double half_turn = 0.5 * step.tail<3>().lpNorm<1>();
    const double arm = height_mm + measure_.arm_mm();
    double turn = 0, way = 0;
    for (const Coordinates& x : d) {
        turn = std::max(turn, x.tail<3>().lpNorm<1>());
        way = std::max(way, x.head<3>().norm());
    }
    if (run_.space != path::Space::machine) way = 0;
    return (half_turn + 0.5 * turn) * arm * turn + (half_turn + turn) * way;
}

/// The same of the tool axis alone, as the chord between two unit vectors.
double DeviationHull::turn_beyond_frame(const Bernstein& d, const Coordinates& step) const {
    double turn = 0;
    for (const Coordinates& x : d) turn = std::max(turn, x.tail<3>().lpNorm<1>());
    return (0.5 * step.tail<3>().lpNorm<1>() + 0.5 * turn) * turn;
}

/// Tip and tool move points of the flank together: in the same direction they add, in opposite ones they do not. So do
/// two rotary axes that turn the tool.
void DeviationHull::sharpen(Extent& hull, Extent& ends, const Bernstein& d, const Coordinates& from,
                            const Coordinates& to) const {
    const Frame at = frame(0.5 * (from + to));
    const auto sharper = [&](double& largest, double& at_ends, double height_mm) {
        double linear = 0;
        for (const Coordinates& x : d) linear = std::max(linear, point(at, x, height_mm));
        largest = std::min(largest, linear + beyond_frame(d, to - from, height_mm));
        at_ends = std::min(at_ends, std::max(point(at, d[0], height_mm), point(at, d[7], height_mm)));
    };
    sharper(hull.tip, ends.tip, measure_.controlled_height_mm());
    sharper(hull.height, ends.height, measure_.flank_height_mm());
    const auto turn = [&](const Coordinates& x) { return (at.axis * x).norm(); };
    double linear = 0;
    for (const Coordinates& x : d) linear = std::max(linear, turn(x));
    hull.turn = std::min(hull.turn, angle_of_chord(linear + turn_beyond_frame(d, to - from)));
    ends.turn = std::min(ends.turn, std::max(turn(d[0]), turn(d[7])));
}

Extent DeviationHull::over(const Bernstein& curve, const Coordinates& from, const Coordinates& to, double block_lever,
                           int depth) {
    Bernstein d;
    for (int k = 0; k < 8; ++k) d[k] = curve[k] - (from + (to - from) * (k / 7.0));
    const double beyond = measure_.vectors() ? take_across(d, curve, from, to) : 0;
    const double lever = lever_beside(d, block_lever);
    Extent ends = measured(d[0], lever);
    widen(ends, measured(d[7], lever));
    Extent hull = ends;
    for (int k = 1; k < 7; ++k) widen(hull, measured(d[k], lever));
    if (has_frames_) sharpen(hull, ends, d, from, to);
    widen(seen_, ends);
    hull.tip += measure_.controlled_height_mm() * beyond + chord_.tip;
    hull.turn += beyond + chord_.turn;
    hull.height += measure_.flank_height_mm() * beyond + chord_.height;
    if (depth == most_halvings || !slack(hull)) return hull;
    const Coordinates middle = 0.5 * (from + to);
    Bernstein after = curve;
    const Bernstein before = split(after, 0.5);
    hull = over(before, from, middle, block_lever, depth + 1);
    widen(hull, over(after, middle, to, block_lever, depth + 1));
    return hull;
}

bool DeviationHull::slack(const Extent& hull) const {
    return hull.tip > worth_halving * seen_.tip + chord_.tip + 1e-9 ||
           hull.turn > worth_halving * seen_.turn + chord_.turn + 1e-11 ||
           hull.height > worth_halving * seen_.height + chord_.height + 1e-9;
}

}  // namespace trunnion::smoothing
