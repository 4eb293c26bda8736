#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>

#include "trunnion/base/quantity.hpp"
#include "trunnion/path/axis_path.hpp"

/// Paths made for tests: machine, tool path and axis path kept together. The axis path points into its Stretch, which
/// must stay where it was made.
namespace trunnion::test {

/// A small generator, so that a seed gives the same path everywhere.
class Random {
  public:
    explicit Random(std::uint64_t seed) : state_(seed * 0x9E3779B97F4A7C15u + 0x1234567u) {}
    double unit() {
        state_ ^= state_ << 13;
        state_ ^= state_ >> 7;
        state_ ^= state_ << 17;
        return static_cast<double>(state_ >> 11) * 0x1p-53;
    }
    double between(double low, double high) { return low + (high - low) * unit(); }

  private:
    std::uint64_t state_;
};

struct Stretch {
    machine::Machine machine;
    std::unique_ptr<machine::Kinematics> kinematics;
    path::ToolPath tool_path;
    std::unique_ptr<path::AxisPath> axis_path;

    /// After machine and tool_path are filled in; nullptr axis_path where the path is refused.
    void close() {
        kinematics = std::make_unique<machine::Kinematics>(*machine::Kinematics::make(machine, machine::Frame{}, 0));
        tool_path.kinematics = kinematics.get();
        auto made = path::AxisPath::make(tool_path, machine, machine::RotaryPosition{});
        if (made) axis_path = std::make_unique<path::AxisPath>(std::move(*made));
    }
};

/// Table/table machine C A X Y Z without ranges.
inline machine::Machine five_axis_machine(const std::array<machine::AxisLimits, 5>& limits) {
    machine::Machine out;
    out.axis_count = 5;
    out.rotary_count = 2;
    const char letters[] = "XYZAC";
    const int directions[] = {0, 1, 2, 0, 2};
    for (int i = 0; i < 5; ++i) {
        out.axes[i].letter = letters[i];
        out.axes[i].rotary = i > 2;
        out.axes[i].direction = Eigen::Vector3d::Unit(directions[i]);
        out.axes[i].feed = out.axes[i].rapid = limits[i];
    }
    out.chain = {4, 3, 0, 1, 2};
    return out;
}

/// A current trunnion machine with slow rotary jerk.
inline std::array<machine::AxisLimits, 5> trunnion_limits() {
    return {{{500, 2500, 5000},
             {500, 3000, 5000},
             {500, 2100, 50000},
             {90 * degree, 300 * degree, 1800 * degree},
             {120 * degree, 300 * degree, 1800 * degree}}};
}

/// One straight move of the machine axes.
inline Stretch straight(const std::array<double, 5>& to, double length_mm,
                        const std::array<machine::AxisLimits, 5>& limits, path::Feed feed = {}) {
    Stretch out;
    out.machine = five_axis_machine(limits);
    out.tool_path.space = path::Space::machine;
    path::PathPiece piece;
    piece.length_mm = length_mm;
    for (int i = 0; i < 5; ++i) piece.coefficient[i][1] = to[i];
    out.tool_path.pieces.push_back(piece);
    out.tool_path.blocks.push_back({0, length_mm, feed, 1, length_mm});
    out.close();
    return out;
}

/// Straight moves in machine axes whose corners are rounded C³ by a quintic turn of the direction.
class CornerPath {
  public:
    using Vector = std::array<double, 5>;

    void straight_to(const Vector& direction, double length_mm) {
        directions_.push_back(direction);
        lengths_.push_back(length_mm);
    }

    /// `deviation` of the corners in the axes' units.
    path::ToolPath make(double deviation) const {
        path::ToolPath out;
        out.space = path::Space::machine;
        Vector at{};
        double begin = 0;
        for (std::size_t k = 0; k < lengths_.size(); ++k) {
            const double reach = corner_reach(k + 1, deviation);
            add_line(out, at, directions_[k], lengths_[k] - begin - reach);
            if (k + 1 < lengths_.size()) add_corner(out, at, directions_[k], directions_[k + 1], reach);
            begin = reach;
        }
        out.blocks.push_back({0, out.length_mm(), {}, 1, out.length_mm()});
        return out;
    }

  private:
    double corner_reach(std::size_t next, double deviation) const {
        if (next >= lengths_.size()) return 0;
        double turn = 0;
        for (int i = 0; i < 5; ++i) turn += std::pow(directions_[next][i] - directions_[next - 1][i], 2);
        const double free = 0.45 * std::min(lengths_[next], lengths_[next - 1]);
        return std::min(free, deviation / (0.15625 * std::max(std::sqrt(turn), 1e-9)));
    }
    static path::PathPiece& add_piece(path::ToolPath& out, double length) {
        path::PathPiece piece;
        piece.begin_mm = out.length_mm();
        piece.length_mm = length;
        return out.pieces.emplace_back(piece);
    }
    static void add_line(path::ToolPath& out, Vector& at, const Vector& direction, double length) {
        path::PathPiece& piece = add_piece(out, length);
        for (int i = 0; i < 5; ++i) {
            piece.coefficient[i][0] = at[i];
            piece.coefficient[i][1] = direction[i] * length;
            at[i] += direction[i] * length;
        }
    }
    /// q′ turns from a to b by the odd quintic smoothstep: in w = u ∈ [0, 1], 10w³ − 15w⁴ + 6w⁵.
    static void add_corner(path::ToolPath& out, Vector& at, const Vector& a, const Vector& b, double reach) {
        const double length = 2 * reach;
        path::PathPiece& piece = add_piece(out, length);
        for (int i = 0; i < 5; ++i) {
            const double turn = (b[i] - a[i]) * length;
            piece.coefficient[i] = {at[i], a[i] * length, 0, 0, 2.5 * turn, -3 * turn, turn, 0};
            at[i] += (a[i] + b[i]) / 2 * length;
        }
    }

    std::vector<Vector> directions_;
    std::vector<double> lengths_;
};

/// 60 mm on which the tool axis passes the pole at that distance.
inline Stretch past_the_pole(double distance) {
    Stretch out;
    out.machine = five_axis_machine(trunnion_limits());
    path::PathPiece piece;
    piece.length_mm = 60;
    piece.coefficient[0][1] = 60;
    piece.coefficient[3] = {-0.5, 1, 0, 0, 0, 0, 0, 0};
    piece.coefficient[4][0] = distance;
    piece.coefficient[5][0] = 1;
    out.tool_path.pieces.push_back(piece);
    out.tool_path.blocks.push_back({0, 60, {}, 1, 60});
    out.close();
    return out;
}

/// Random moves of 0.3-25 mm with corners rounded to 0.02, half of the paths under a feed of 20-120 mm/s.
inline Stretch random_corners(std::uint64_t seed, int moves) {
    Random random(seed);
    CornerPath corners;
    for (int k = 0; k < moves; ++k) {
        std::array<double, 5> direction{};
        double norm = 0;
        for (int i = 0; i < 3; ++i) direction[i] = random.between(-1, 1);
        for (int i = 0; i < 3; ++i) norm += direction[i] * direction[i];
        for (int i = 0; i < 3; ++i) direction[i] /= std::sqrt(norm) + 0.1;
        for (int i = 3; i < 5; ++i) direction[i] = random.between(-0.05, 0.05);
        corners.straight_to(direction, std::exp(random.between(std::log(0.3), std::log(25.0))));
    }
    Stretch out;
    out.machine = five_axis_machine(trunnion_limits());
    out.tool_path = corners.make(0.02);
    if (random.unit() < 0.5) out.tool_path.blocks[0].feed = {path::FeedRule::tip_speed, random.between(20, 120)};
    out.close();
    return out;
}

}  // namespace trunnion::test
