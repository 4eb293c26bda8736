#include "detail/block_geometry.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "trunnion/base/quantity.hpp"
#include "trunnion/geometry/great_circle.hpp"
#include "trunnion/geometry/helix.hpp"
#include "trunnion/path/curve_way.hpp"

namespace trunnion::controller {

using machine::RotaryPosition;
using path::PathCoordinates;
using path::Run;

namespace {

constexpr double rotary_mm_per_rad = 1 / degree;
constexpr int deepest = 12;                        // 4096 segments a block
constexpr double coarsest_turn_rad = 10 * degree;  // looked at no more coarsely than that
constexpr double coarsest_arc_rad = 30 * degree;
constexpr double least_of_curve = 8;  // parts

Eigen::Vector3d to_vector(const std::array<double, 3>& v) {
    return {v[0], v[1], v[2]};
}

RotaryPosition between(const RotaryPosition& from, const RotaryPosition& to, double w) {
    return {from[0] + w * (to[0] - from[0]), from[1] + w * (to[1] - from[1])};
}

double turn(const RotaryPosition& from, const RotaryPosition& to) {
    return std::hypot(to[0] - from[0], to[1] - from[1]);
}

/// One solution of the machine's rotary axes, wound as near to a position as it goes.
RotaryPosition wound(RotaryPosition solution, const RotaryPosition& near, int rotary_count) {
    for (std::size_t a = 0; a < static_cast<std::size_t>(rotary_count); ++a)
        solution[a] = near[a] + std::remainder(solution[a] - near[a], 2 * std::numbers::pi);
    return solution;
}

/// Index of the solution nearest to a position of the axes, which becomes that solution.
int nearest_solution(const machine::Kinematics& kinematics, const Eigen::Vector3d& tool_axis, RotaryPosition& near) {
    const auto solutions = kinematics.rotary_for(tool_axis);
    int best = -1;
    RotaryPosition found = near;
    for (int k = 0; k < solutions.count; ++k) {
        RotaryPosition candidate =
            wound(solutions.rotary_rad[static_cast<std::size_t>(k)], near, kinematics.rotary_count());
        const int free = kinematics.rotary_nearest_workpiece();
        if (solutions.degenerate && free >= 0)
            candidate[static_cast<std::size_t>(free)] = near[static_cast<std::size_t>(free)];
        if (best >= 0 && turn(near, candidate) >= turn(near, found)) continue;
        found = candidate;
        best = solutions.degenerate ? 2 : k;
    }
    near = found;
    return best;
}

/// One block as a way from its beginning (w = 0) to its end (w = 1).
class BlockWay {
  public:
    BlockWay(const Run& run, const machine::Machine& machine, std::size_t block)
        : run_(run), machine_(machine), from_(run.vertices[block]), to_(run.vertices[block + 1]) {
        const std::int32_t arc = run.blocks[block].arc;
        if (arc != program::no_arc) {
            const auto& given = run.arcs[static_cast<std::size_t>(arc)];
            helix_.emplace(path::helix_between(given, from_, to_));
            arc_rad_ = std::abs(given.angle_rad);
        }
        if (run.blocks[block].curve != path::no_curve) curve_.emplace(run, block);
        by_vectors_ =
            run.law == path::OrientationLaw::vector && run.space == path::Space::workpiece && machine.rotary_count > 0;
        by_axes_ = run.law == path::OrientationLaw::rotary || run.space == path::Space::machine;
        if (by_vectors_) {
            if (!curve_) circle_.emplace(to_vector(from_.orientation), to_vector(to_.orientation));
            rotary_from_ = run.stands[block];
            rotary_to_ = run.stands[block + 1];
            RotaryPosition at_from = rotary_from_, at_to = rotary_to_;
            const int first = nearest_solution(*run.kinematics, tool_axis_at(0), at_from);
            const int last = nearest_solution(*run.kinematics, tool_axis_at(1), at_to);
            follows_ = first == last || first == 2 || last == 2;
        } else if (by_axes_) {
            rotary_from_ = {from_.orientation[0], from_.orientation[1]};
            rotary_to_ = {to_.orientation[0], to_.orientation[1]};
        }
    }

    Station at(double w) const {
        if (curve_) w = curve_->at_length(w);
        Station out;
        const Eigen::Vector3d position = position_at(w);
        const RotaryPosition rotary = rotary_at(w);
        std::array<double, 3> linear{position.x(), position.y(), position.z()};
        if (run_.space == path::Space::workpiece) linear = run_.kinematics->linear_for(position, rotary);
        std::ranges::copy(linear, out.axes.v.begin());
        std::copy_n(rotary.begin(), machine_.rotary_count, out.axes.v.begin() + 3);
        if (run_.space == path::Space::workpiece) {
            out.tip_mm = position;
            out.tool_axis = run_.kinematics->tool_axis(rotary);
        } else {
            const auto pose = run_.kinematics->forward(out.axes);
            out.tip_mm = pose.tip_in_workpiece_mm;
            out.tool_axis = pose.axis_in_workpiece;
        }
        return out;
    }

    double way_mm() const {
        if (curve_) return curve_->way_mm();
        return helix_ ? helix_->length() : (to_vector(to_.position_mm) - to_vector(from_.position_mm)).norm();
    }
    /// Parts that are looked at whatever they look like at their middles.
    int least_parts() const {
        double turned = turn(rotary_from_, rotary_to_);
        if (circle_) turned = std::max(turned, circle_->angle_rad());
        if (curve_) turned = std::max(turned, least_of_curve * coarsest_turn_rad);
        const bool bent = run_.space == path::Space::workpiece && turned > 0;
        return std::clamp(
            static_cast<int>(std::ceil(std::max(bent ? turned / coarsest_turn_rad : 0.0, arc_rad_ / coarsest_arc_rad))),
            1, 1 << deepest);
    }
    /// The axes go straight from end to end: nothing turns, nothing is round.
    bool straight() const {
        return !helix_ && !curve_ && (run_.space == path::Space::machine || !(turn(rotary_from_, rotary_to_) > 0));
    }

  private:
    // along a curve w is the share of its parameter

    Eigen::Vector3d position_at(double w) const {
        if (curve_) return to_vector(curve_->at(w).position_mm);
        if (helix_) return helix_->at(w);
        return (1 - w) * to_vector(from_.position_mm) + w * to_vector(to_.position_mm);
    }
    Eigen::Vector3d tool_axis_at(double w) const {
        return curve_ ? to_vector(curve_->at(w).orientation) : circle_->at(w);
    }
    RotaryPosition rotary_at(double w) const {
        RotaryPosition out = between(rotary_from_, rotary_to_, w);
        if (by_vectors_ && follows_ && w > 0 && w < 1) nearest_solution(*run_.kinematics, tool_axis_at(w), out);
        if (by_axes_ && curve_) {
            const auto there = curve_->at(w).orientation;
            out = {there[0], there[1]};
        }
        return out;
    }

    const Run& run_;
    const machine::Machine& machine_;
    const PathCoordinates &from_, &to_;
    std::optional<geometry::Helix> helix_;
    std::optional<path::CurveWay> curve_;
    std::optional<geometry::GreatCircle> circle_;
    RotaryPosition rotary_from_{}, rotary_to_{};
    double arc_rad_ = 0;
    bool by_vectors_ = false, by_axes_ = false, follows_ = false;
};

/// How far the axes at the middle are from the chord.
double chord_error_mm(const Station& from, const Station& middle, const Station& to, int axis_count) {
    double sum = 0;
    for (int a = 0; a < axis_count; ++a) {
        const double off = middle.axes[a] - 0.5 * (from.axes[a] + to.axes[a]);
        const double mm = a < 3 ? off : off * rotary_mm_per_rad;
        sum += mm * mm;
    }
    return std::sqrt(sum);
}

class Tracer {
  public:
    Tracer(const Run& run, const machine::Machine& machine, double chord_mm, RunGeometry& out)
        : run_(run), machine_(machine), chord_mm_(chord_mm), out_(out) {}

    void add_block(std::size_t block) {
        const BlockWay way(run_, machine_, block);
        block_ = static_cast<std::uint32_t>(block);
        way_mm_ = way.way_mm();
        if (out_.stations.empty()) out_.stations.push_back(way.at(0));
        if (way.straight()) return add_segment(1, way.at(1));
        const int parts = way.least_parts();
        for (int k = 0; k < parts; ++k) {
            const double from = static_cast<double>(k) / parts, to = static_cast<double>(k + 1) / parts;
            add_between(way, from, Station(out_.stations.back()), to, way.at(to), deepest);
        }
    }

  private:
    void add_between(const BlockWay& way, double w0, const Station& from, double w1, const Station& to, int depth) {
        const double w = 0.5 * (w0 + w1);
        const Station middle = way.at(w);
        if (depth == 0 || chord_error_mm(from, middle, to, machine_.axis_count) <= chord_mm_)
            return add_segment(w1 - w0, to);
        out_.refined = true;
        add_between(way, w0, from, w, middle, depth - 1);
        add_between(way, w, middle, w1, to, depth - 1);
    }

    void add_segment(double share, const Station& to) {
        const Station& from = out_.stations.back();
        double turned = 0;
        for (int a = 3; a < machine_.axis_count; ++a) turned = std::hypot(turned, to.axes[a] - from.axes[a]);
        out_.segments.push_back({share * way_mm_, turned, share, block_});
        out_.stations.push_back(to);
    }

    const Run& run_;
    const machine::Machine& machine_;
    double chord_mm_, way_mm_ = 0;
    std::uint32_t block_ = 0;
    RunGeometry& out_;
};

}  // namespace

void trace(const Run& run, const machine::Machine& machine, double chord_mm, RunGeometry& out) {
    out.stations.clear();
    out.segments.clear();
    out.refined = false;
    out.stations.reserve(run.vertices.size());
    out.segments.reserve(run.blocks.size());
    Tracer tracer(run, machine, chord_mm, out);
    for (std::size_t block = 0; block < run.blocks.size(); ++block) tracer.add_block(block);
}

}  // namespace trunnion::controller
