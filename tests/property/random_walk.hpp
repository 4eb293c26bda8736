// Random programs: what the tests of random programs and the soak have in common.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "trunnion/base/quantity.hpp"
#include "trunnion/files/machine_file.hpp"
#include "trunnion/geometry/bspline_curve.hpp"
#include "trunnion/geometry/helix.hpp"
#include "trunnion/machine/kinematics.hpp"
#include "trunnion/path/rotary_stands.hpp"
#include "trunnion/program/program.hpp"

namespace trunnion {

using program::Event;
using program::EventKind;
using program::FeedRule;
using program::Move;
using program::MoveKind;
using program::OrientationLaw;
using program::Program;

/// xorshift64*: the same numbers on every machine.
class Random {
  public:
    explicit Random(std::uint64_t seed) : state_(seed * 0x9E3779B97F4A7C15u + 1) {}
    double unit() {
        state_ ^= state_ >> 12;
        state_ ^= state_ << 25;
        state_ ^= state_ >> 27;
        return static_cast<double>((state_ * 0x2545F4914F6CDD1Du) >> 11) * 0x1p-53;
    }
    double between(double low, double high) { return low + (high - low) * unit(); }
    double log_between(double low, double high) { return std::exp(between(std::log(low), std::log(high))); }
    bool chance(double p) { return unit() < p; }

  private:
    std::uint64_t state_;
};

inline Eigen::Vector3d direction(Random& random) {
    const double x = random.between(-1, 1), y = random.between(-1, 1), z = random.between(-1, 1);
    const Eigen::Vector3d v(x, y, z);
    return v.norm() > 0.05 ? Eigen::Vector3d(v.normalized()) : Eigen::Vector3d::UnitX();
}

/// What a random program may contain.
struct Kind {
    bool vectors = false;  ///< begins with tool vectors, else with rotary words
    bool returns = false;  ///< also comes back over its own way
    bool changes = false;  ///< of law, moves with TCP off
    bool arcs = false;
    bool poles = false;  ///< now and then the tool is led to the pole or closely past it
    bool curves = false;
};

/// A walk: mostly going on in about the same direction, with corners, dense stretches, pure turns, doubled points,
/// rapids and dwells; see Kind.
class Walk {
  public:
    Walk(Random& random, const machine::Machine& machine, const machine::Setup& setup, const Kind& kind)
        : random_(random),
          machine_(machine),
          setup_(setup),
          kind_(kind),
          kinematics_(*machine::Kinematics::make(machine, setup.workpiece, setup.tool.length_mm)) {
        if (!kind.vectors || kind.changes)
            for (int a = 0; a < machine.rotary_count; ++a)
                program_.rotary_letters.push_back(machine.axes[machine.linear_count() + a].letter);
        at_.law = kind.vectors ? OrientationLaw::vector : OrientationLaw::rotary;
        at_.feed = {FeedRule::tip_speed, random.log_between(1, 300)};
        words_ = {random.between(-60, 60) * degree, random.between(-60, 60) * degree};
        axis_ = kinematics_.tool_axis(words_);
        scale_ = random.log_between(0.02, 20);
        way_ = direction(random);
        turning_ = {random.between(-1, 1), random.between(-1, 1)};
        tilting_ = direction(random);
    }

    Program operator()() {
        place();
        const int count = 3 + static_cast<int>(random_.between(0, 60));
        for (int k = 0; k < count; ++k) step();
        return std::move(program_);
    }

  private:
    void place() {
        if (at_.law == OrientationLaw::rotary) axis_ = kinematics_.tool_axis(words_);
        at_.rotary_rad = {words_[0], words_[1], 0};
        at_.axis = axis_;
        at_.line = static_cast<std::int32_t>(program_.moves.size()) + 1;
        program_.moves.push_back(at_);
        at_.arc = program::no_arc;
        at_.curve_part = program::no_curve_part;
    }

    void step() {
        if (random_.chance(0.2)) {
            const Eigen::Vector3d turned = direction(random_);
            if (kind_.returns || turned.dot(way_) > -0.5) way_ = turned;
        }
        if (kind_.returns && random_.chance(0.1)) way_ = -way_;
        if (random_.chance(0.2)) turning_ = {random_.between(-1, 1), random_.between(-1, 1)};
        if (random_.chance(0.2)) tilting_ = direction(random_);
        if (kind_.changes && random_.chance(0.1)) change_law();
        const double length = scale_ * random_.log_between(0.1, 3);
        if (kind_.curves && random_.chance(0.3) && add_curve(length)) return;
        at_.kind = random_.chance(0.06) ? MoveKind::rapid : MoveKind::feed;
        if (kind_.changes && random_.chance(0.04)) retract();
        if (!random_.chance(0.08)) at_.position_mm += length * (way_ + 0.05 * direction(random_)).normalized();
        if (random_.chance(0.8)) turn(std::min(0.02 * length, 0.4) * random_.between(0.2, 3));
        if (at_.position_mm.cwiseAbs().maxCoeff() > 250) way_ = -at_.position_mm.normalized();
        if (random_.chance(0.1)) at_.feed.value = random_.log_between(1, 300);
        if (random_.chance(0.03))
            program_.events.push_back(
                {EventKind::dwell, true, random_.between(0.001, 0.1), "G4", program_.moves.size(), 0});
        at_.exact_stop = random_.chance(0.03);
        if (at_.kind == MoveKind::rapid)
            at_.position_mm += 5 * direction(random_);
        else if (kind_.arcs && random_.chance(0.2))
            add_arc(length);
        place();
    }

    void turn(double by_rad) {
        if (at_.law == OrientationLaw::rotary) {
            words_[0] = std::clamp(words_[0] + turning_[0] * by_rad, -80 * degree, 80 * degree);
            words_[1] = std::clamp(words_[1] + turning_[1] * by_rad, -170 * degree, 170 * degree);
            return;
        }
        if (axis_.z() < 0.3) tilting_ = Eigen::Vector3d::UnitZ();
        axis_ = (axis_ + by_rad * tilting_).normalized();
        if (!kind_.poles || !random_.chance(0.1)) return;
        const double beside = random_.chance(0.3) ? 0 : random_.log_between(1e-6, 1e-2);
        axis_ = Eigen::Vector3d(beside, 0.3 * beside, 1).normalized();
    }

    /// To words where the axes stand, or to vectors from there.
    void change_law() {
        if (at_.law == OrientationLaw::vector) {
            const auto stands = path::choose_rotary_stands(program_, machine_, setup_);
            if (!stands) return;
            words_ = stands->back().rotary_rad;
        }
        at_.law = at_.law == OrientationLaw::vector ? OrientationLaw::rotary : OrientationLaw::vector;
    }

    /// A rapid with TCP off, up or to some place, and the next move is a rapid too.
    void retract() {
        Move away = at_;
        away.kind = MoveKind::rapid;
        away.exact_stop = false;
        away.arc = program::no_arc;
        away.curve_part = program::no_curve_part;
        away.law = OrientationLaw::rotary;
        constexpr double stays = std::numeric_limits<double>::quiet_NaN();
        away.rotary_rad = {stays, stays, stays};
        const bool up = random_.chance(0.5);
        away.space = up ? program::Space::machine : program::Space::untransformed;
        away.position_mm = up ? Eigen::Vector3d(stays, stays, random_.between(0, 200)) : at_.position_mm;
        away.line = static_cast<std::int32_t>(program_.moves.size()) + 1;
        if (program_.rotary_letters.empty()) return;
        program_.moves.push_back(away);
        at_.kind = MoveKind::rapid;
    }

    /// The move becomes a piece of a helix about any direction.
    void add_arc(double length) {
        const Eigen::Vector3d start = program_.moves.back().position_mm, normal = direction(random_);
        Eigen::Vector3d spoke = direction(random_);
        spoke = (spoke - spoke.dot(normal) * normal);
        if (spoke.norm() < 0.1 || program_.moves.back().space != program::Space::workpiece) return;
        const double radius = length * random_.between(0.3, 3), angle = random_.between(-3.5, 3.5);
        if (std::abs(angle) < 0.05) return;
        const Eigen::Vector3d arm = -radius * spoke.normalized();
        const program::Arc arc{start - arm, normal, angle};
        const double rise = random_.chance(0.5) ? 0 : length * random_.between(-0.3, 0.3);
        at_.position_mm = arc.centre_mm + Eigen::AngleAxisd(angle, normal) * arm + rise * normal;
        at_.arc = static_cast<std::int32_t>(program_.arcs.size());
        program_.arcs.push_back(arc);
        way_ = (Eigen::AngleAxisd(angle, normal) * normal.cross(arm) * (angle < 0 ? -1 : 1)).normalized();
    }

    /// Some moves along a B-spline that begins where the last move ended; now and then it says nothing of the tool.
    bool add_curve(double length) {
        if (program_.moves.back().space != program::Space::workpiece) return false;
        at_.kind = MoveKind::feed;
        at_.exact_stop = false;
        program::Curve curve;
        curve.degree = 1 + static_cast<int>(random_.between(0, 5));
        const int spans = 1 + static_cast<int>(random_.between(0, 6)), count = spans + curve.degree;
        double knot = 0;
        for (int i = 0; i < count + curve.degree + 1; ++i) {
            curve.knots.push_back(knot);
            if (i >= curve.degree && i < count) knot += random_.between(0.7, 1.5);
        }
        const bool weighted = random_.chance(0.3), turns = random_.chance(0.8),
                   vectors = at_.law == OrientationLaw::vector;
        Eigen::Vector3d way = way_, axis = axis_, at = program_.moves.back().position_mm;
        std::vector<Eigen::Vector3d> orientation;
        for (int i = 0; i < count; ++i) {
            curve.position_mm.push_back(at);
            if (weighted) curve.weights.push_back(random_.between(0.6, 1.6));
            orientation.push_back(vectors ? Eigen::Vector3d(random_.between(10, 40) * axis)
                                          : Eigen::Vector3d(words_[0], words_[1], 0));
            way = (way + 0.5 * direction(random_)).normalized();
            at += 0.3 * length * random_.between(0.7, 1.3) * way;
            if (i + 1 < count) turn(std::min(0.02 * length, 0.2) * random_.between(0.2, 2));
            axis = axis_;
        }
        const auto spline = [&](const std::vector<Eigen::Vector3d>& points) {
            return geometry::BsplineCurve::make(curve.degree, curve.knots, points, curve.weights).value();
        };
        const auto positions = spline(curve.position_mm), orientations = spline(orientation);
        if (turns && vectors) curve.axis = orientation;
        for (const Eigen::Vector3d& words : orientation)
            if (turns && !vectors) curve.rotary_rad.push_back({words[0], words[1], 0});
        for (int k = 0; k < spans; ++k) {
            const double from = curve.knots[static_cast<std::size_t>(curve.degree + k)],
                         to = curve.knots[static_cast<std::size_t>(curve.degree + k + 1)];
            at_.curve_part = static_cast<std::int32_t>(program_.curve_parts.size());
            program_.curve_parts.push_back({static_cast<std::int32_t>(program_.curves.size()), from, to});
            at_.position_mm = positions.evaluate(to)[0];
            const Eigen::Vector3d there = orientations.evaluate(to)[0];
            if (vectors)
                axis_ = there.normalized();
            else
                words_ = {there[0], there[1]};
            place();
        }
        program_.curves.push_back(std::move(curve));
        way_ = way;
        return true;
    }

    Random& random_;
    const machine::Machine& machine_;
    const machine::Setup& setup_;
    Kind kind_;
    machine::Kinematics kinematics_;
    Program program_;
    Move at_;
    machine::RotaryPosition words_{};
    Eigen::Vector3d axis_, way_, tilting_;
    std::array<double, 2> turning_{};
    double scale_ = 1;
};

/// Whether tip and turn together (one radian counts 30 mm) change direction by more than a right angle anywhere: near
/// such a corner the nearest place of the path, by which the checker matches, is not the corresponding one.
inline bool turns_back(const Program& program) {
    using Step = Eigen::Matrix<double, 6, 1>;
    Step before = Step::Zero();
    for (std::size_t k = 1; k < program.moves.size(); ++k) {
        const Move &from = program.moves[k - 1], &to = program.moves[k];
        if (to.space != from.space) {
            before = Step::Zero();
            continue;
        }
        constexpr int parts = 16;  // of an arc or curve
        const bool curved = to.curve_part != program::no_curve_part;
        const int count = to.arc == program::no_arc && !curved ? 1 : parts;
        Eigen::Vector3d last = from.position_mm;
        for (int part_number = 1; part_number <= count; ++part_number) {
            Eigen::Vector3d next = to.position_mm;
            if (curved) {
                const program::CurvePart& part = program.curve_parts[static_cast<std::size_t>(to.curve_part)];
                const program::Curve& curve = program.curves[static_cast<std::size_t>(part.curve)];
                next = geometry::BsplineCurve::make(curve.degree, curve.knots, curve.position_mm, curve.weights)
                           ->evaluate(part.from_u +
                                      static_cast<double>(part_number) / count * (part.to_u - part.from_u))[0];
            } else if (count > 1) {
                const program::Arc& arc = program.arcs[static_cast<std::size_t>(to.arc)];
                next = geometry::Helix(from.position_mm, to.position_mm, arc.centre_mm, arc.normal, arc.angle_rad)
                           .at(static_cast<double>(part_number) / count);
            }
            Step step;
            step << next - last, 30 * (to.axis - from.axis) / count;
            last = next;
            if (step.norm() < 1e-6) continue;
            if (step.dot(before) < 0) return true;
            before = step;
        }
    }
    return false;
}

/// A shipped machine with ranges wide enough for a random walk.
inline machine::Machine wide(const char* name) {
    auto machine =
        files::read_machine_file(std::string(TRUNNION_SOURCE_DIR "/data/machines/") + name + ".toml").value();
    for (int i = 0; i < machine.axis_count; ++i) {
        machine.axes[i].range_min = i < 3 ? 10 * machine.axes[i].range_min : -720 * degree;
        machine.axes[i].range_max = i < 3 ? 10 * machine.axes[i].range_max : 720 * degree;
    }
    return machine;
}

}  // namespace trunnion
