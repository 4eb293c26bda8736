#include <algorithm>

#include "detail/rs274_reader.hpp"

namespace trunnion::nc {

using Eigen::Vector3d;

namespace {

constexpr int lowest_order = 2, highest_order = 8;
constexpr std::size_t most_points = 100'000;

/// The curve passes through its first and last control point, the knots between are 1 apart.
program::Curve clamped(std::vector<Vector3d> points, int degree) {
    const auto inner = static_cast<double>(points.size()) - degree;
    program::Curve curve;
    curve.degree = degree;
    curve.knots.resize(points.size() + static_cast<std::size_t>(degree) + 1);
    for (std::size_t i = 0; i < curve.knots.size(); ++i)
        curve.knots[i] = std::clamp(static_cast<double>(i) - degree, 0.0, inner);
    curve.position_mm = std::move(points);
    return curve;
}

program::Curve bezier(std::vector<Vector3d> points) {
    const int degree = static_cast<int>(points.size()) - 1;
    return clamped(std::move(points), degree);
}

}  // namespace

/// G5, G5.1, G5.2 and G5.3: in the plane G17, the other axes stand still.
bool Rs274Reader::curve() {
    if (!check_curve()) return false;
    switch (modal_.motion) {
        case Meaning::cubic_curve:
            return cubic_curve();
        case Meaning::quadratic_curve:
            return quadratic_curve();
        case Meaning::nurbs:
            return nurbs_point();
        default:
            return nurbs_end();
    }
}

bool Rs274Reader::check_curve() {
    const std::uint32_t plane = Block::bit('X') | Block::bit('Y');
    if (modal_.plane_normal != 2)
        return refuse("NC0350", spot_of_motion(), "curves lie in the plane G17", name_of(modal_.motion_code));
    if ((axes_ & ~plane) != 0)
        return refuse("NC0350", spot_of_motion(), "a curve moves X and Y alone", name_of(modal_.motion_code),
                      "move the other axes in a block of their own");
    if (request_.asks(Group::once, Meaning::machine_position))
        return refuse("NC0350", spot_of_motion(), "a curve in machine positions", name_of(modal_.motion_code));
    enter(frame_in_force());
    if (!position_mm_.hasNaN()) return true;
    return refuse("NC0344", spot_of_motion(), "a curve from a position that is not known in this frame", {},
                  "say X, Y and Z by G0 or G1 before it");
}

Vector3d Rs274Reader::in_plane(char first, char second) const {
    return modal_.unit_mm * Vector3d(block_[first], block_[second], 0);
}

/// I J: from the start to the second control point; P Q: from the end to the third. Without I J the curve goes on as
/// the one before ended.
bool Rs274Reader::cubic_curve() {
    const bool starts = block_.has('I') && block_.has('J');
    if (!block_.has('P') || !block_.has('Q') || (!starts && (block_.has('I') || block_.has('J') || !end_tangent_mm_)))
        return refuse("NC0350", spot_of_motion(), "G5 needs P and Q, and I and J but right behind another G5");
    const Vector3d start_mm = position_mm_;
    const Vector3d leaving_mm = starts ? in_plane('I', 'J') : Vector3d(-*end_tangent_mm_);
    if (!target()) return false;
    const Vector3d arriving_mm = in_plane('P', 'Q');
    if (!follow(bezier({start_mm, start_mm + leaving_mm, position_mm_ + arriving_mm, position_mm_}))) return false;
    end_tangent_mm_ = arriving_mm;
    return true;
}

/// I J: from the start to the control point.
bool Rs274Reader::quadratic_curve() {
    if (!block_.has('I') || !block_.has('J') || (block_['I'] == 0 && block_['J'] == 0))
        return refuse("NC0350", spot_of_motion(), "G5.1 needs I and J, not both 0");
    const Vector3d start_mm = position_mm_;
    if (!target()) return false;
    return follow(bezier({start_mm, start_mm + in_plane('I', 'J'), position_mm_}));
}

/// The point before G5.2 is the first control point; P without X and Y is its weight.
bool Rs274Reader::nurbs_point() {
    const auto refused = [&](std::string text, std::string_view hint = {}) {
        return refuse("NC0351", spot_of_motion(), std::move(text), {}, hint);
    };
    if (!nurbs_) nurbs_ = OpenNurbs{{position_mm_}, {1}, 3, request_.code_of(Group::motion).column};
    const double weight = block_.has('P') ? block_['P'] : 1;
    if (!(weight > 0)) return refused("the weight of a control point is positive");
    if (block_.has('L')) {
        const double order = block_['L'];
        if (order != std::floor(order) || order < lowest_order || order > highest_order)
            return refused("the order of a NURBS is 2 … 8");
        nurbs_->order = static_cast<int>(order);
    }
    if (axes_ == 0) {
        if (block_.has('P') && nurbs_->points.size() > 1) return refused("a weight without its control point");
        if (block_.has('P')) nurbs_->weights.front() = weight;
        return true;
    }
    if (!block_.has('X') || !block_.has('Y') || !modal_.absolute) return refused("control points have X and Y, in G90");
    if (nurbs_->points.size() == most_points) return refused("too many control points");
    if (!target()) return false;
    nurbs_->points.push_back(position_mm_);
    nurbs_->weights.push_back(weight);
    return true;
}

bool Rs274Reader::nurbs_end() {
    if (!nurbs_ || axes_ != 0)
        return refuse("NC0351", spot_of_motion(), "G5.3 ends the control points of G5.2, and has no words of its own");
    const OpenNurbs open = std::move(*nurbs_);
    nurbs_.reset();
    if (open.points.size() < static_cast<std::size_t>(open.order))
        return refuse("NC0351", spot_of_motion(), "a NURBS needs as many control points as its order",
                      fmt::format("{} points", open.points.size()), fmt::format("order {}", open.order));
    program::Curve curve = clamped(open.points, open.order - 1);
    if (std::ranges::any_of(open.weights, [](double weight) { return weight != 1; })) curve.weights = open.weights;
    modal_.motion = Meaning::no_motion;
    return follow(std::move(curve));
}

/// From where the move before ended, along the whole curve.
bool Rs274Reader::follow(program::Curve curve) {
    const Vector3d& start_mm = curve.position_mm.front();
    for (const Vector3d& point : curve.position_mm)
        if (!point.allFinite())
            return refuse("NC0201", spot_of_motion(), "a control point is not finite", name_of(modal_.motion_code));
    if (std::ranges::all_of(curve.position_mm, [&](const Vector3d& point) { return point == start_mm; })) return true;
    program::Move move = move_here();
    move.curve_part = static_cast<std::int32_t>(program_.curve_parts.size());
    if (!feed_of(move)) return false;
    program_.curve_parts.push_back(
        {static_cast<std::int32_t>(program_.curves.size()), curve.knots.front(), curve.knots.back()});
    program_.curves.push_back(std::move(curve));
    return add(move);
}

}  // namespace trunnion::nc
