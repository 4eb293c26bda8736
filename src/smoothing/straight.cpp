#include "detail/straight.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "detail/polyline.hpp"
#include "detail/septic.hpp"
#include "detail/turn.hpp"

namespace trunnion::smoothing {

namespace {

constexpr double largest_turn_rad = 20 * std::numbers::pi / 180;  // of one septic piece: 2e-11 rad off the slerp
constexpr double least_lever_of_length = 0.1;                     // as in the definition of p

/// One programmed block as a function of the way along it.
class Block {
  public:
    Block(const path::Run& run, std::size_t index)
        : from_(joined(run.vertices[index])),
          to_(joined(run.vertices[index + 1])),
          length_(run.blocks[index].length_mm),
          turns_(has_vectors(run)),
          turn_(turns_ ? turn_between(from_.tail<3>(), to_.tail<3>())
                       : turn_between(Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitX())) {}

    double length_mm() const { return length_; }
    double turn_rad() const { return turn_.angle_rad(); }

    HermiteEnd at(double part) const {
        HermiteEnd end{from_ + part * (to_ - from_), (to_ - from_) / length_, Coordinates::Zero(), Coordinates::Zero()};
        if (!turns_) return end;
        const auto axis = turn_.at(Taylor3{part, 1 / length_, 0, 0});
        for (int k = 0; k < 3; ++k) {
            end.value[3 + k] = axis[k].value();
            end.first[3 + k] = axis[k].d1();
            end.second[3 + k] = axis[k].d2();
            end.third[3 + k] = axis[k].d3();
        }
        return end;
    }

  private:
    Coordinates from_, to_;
    double length_;
    bool turns_;
    geometry::GreatCircle turn_;
};

Coordinates tangent(const path::Run& run, std::size_t block, double part) {
    const HermiteEnd end = Block(run, block).at(part);
    Coordinates t = end.first;
    t.tail<3>() *= path::reference_height_mm;
    if (const int axis = lever_axis(run); axis >= 0)
        t[axis] *= std::max(lever_at(run, end.value), least_lever_of_length);
    return t;
}

void append_block(const Block& block, path::ToolPath& path) {
    const int parts = std::max(1, static_cast<int>(std::ceil(block.turn_rad() / largest_turn_rad)));
    const double length = block.length_mm() / parts, begin = path.length_mm();
    for (int k = 0; k < parts; ++k) {
        const HermiteEnd start = block.at(static_cast<double>(k) / parts);
        HermiteEnd end = block.at(static_cast<double>(k + 1) / parts);
        end.value -= start.value;
        path.pieces.push_back(hermite_piece(begin + k * length, length, start, end));
    }
    // Remainder of Hermite interpolation of a circle: (h/2)⁸/8!, both components.
    const double off = 1.5 * std::pow(0.5 * block.turn_rad() / parts, 8) / 40320;
    path.bound.orientation_rad = std::max(path.bound.orientation_rad, off);
}

}  // namespace

Coordinates tangent_at_begin(const path::Run& run, std::size_t block) {
    return tangent(run, block, 0);
}
Coordinates tangent_at_end(const path::Run& run, std::size_t block) {
    return tangent(run, block, 1);
}

path::ToolPath stretch(const path::Run& run, VertexRange range, path::StopCause stop) {
    path::ToolPath path;
    path.space = run.space;
    path.law = run.law;
    path.rapid = run.rapid;
    path.kinematics = run.kinematics;
    path.first_move = run.first_move + range.first;
    path.stop = stop;
    double begin = 0;
    for (std::size_t i = range.first; i < range.last; ++i) {
        const path::Block& block = run.blocks[i];
        path.blocks.push_back({begin, begin + block.length_mm, block.feed, block.line, block.length_mm});
        begin += block.length_mm;
    }
    return path;
}

void append_straight(const path::Run& run, VertexRange range, path::StopCause stop, const SmoothingOptions& options,
                     std::vector<path::ToolPath>& out) {
    path::ToolPath path = stretch(run, range, stop);
    for (std::size_t i = range.first; i < range.last; ++i) append_block(Block(run, i), path);
    path.bound.tip_mm = options.controlled_height_mm * path.bound.orientation_rad;
    path.bound.height_mm = options.flank_height_mm * path.bound.orientation_rad;
    path.transition_use.assign(range.last - range.first - 1, 0.0F);
    path.blocks.back().end_mm = path.length_mm();
    out.push_back(std::move(path));
}

}  // namespace trunnion::smoothing
