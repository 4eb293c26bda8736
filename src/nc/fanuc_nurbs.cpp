#include <algorithm>

#include "detail/curves.hpp"
#include "detail/fanuc_reader.hpp"

namespace trunnion::nc::fanuc {

using Eigen::Vector3d;
using program::Curve;
using program::Move;
using program::Space;

namespace {

constexpr double same_place_mm = 0.01;  ///< the first control point is where the tool stands
constexpr double same_angle_rad = 1e-4;
constexpr std::size_t fewest_order = 2, most_order = 4;

}  // namespace

/// A block of G06.2: `G06.2 P K X Y Z R`, `K X Y Z R`, and at the end `K` alone, as many as the order.
bool FanucReader::nurbs_block() {
    axis_words_ever_ = true;
    last_motion_ = block_.place();
    if (!said_.has('K'))
        return refuse("NC0850", spot_of_motion(), "a block of G06.2 without its knot", {}, "K in every block");
    if (asked(Group::once) != Meaning::unknown)
        return refuse("NC0850", code_of(Group::once), "this word cannot stand in a block of G06.2");
    if (!nurbs_ && (asked(Group::motion) != Meaning::nurbs || !begin_nurbs()))
        return nurbs_ || refuse("NC0850", spot_of_motion(), "a control point without G06.2 before it");
    Curve& curve = nurbs_->curve;
    if (!curve.knots.empty() && !(said_['K'] >= curve.knots.back()))
        return refuse("NC0850", said_.word('K'), "the knots of a NURBS never fall");
    curve.knots.push_back(said_['K']);
    said_.use("K");
    const bool axes = (said_.said() & control_.axis_letters()) != 0;
    if (axes || curve.position_mm.empty()) return control_point();
    nurbs_->only_knots = true;
    return true;
}

bool FanucReader::begin_nurbs() {
    const double order = said_.get('P', most_order);
    if (!(order >= fewest_order && order <= most_order && order == std::floor(order)))
        return refuse("NC0850", said_.word('P'), "the order of a NURBS is 2, 3 or 4");
    said_.use("P");
    if (!count_in(false)) return false;
    if (modes_.length == Meaning::tcp_vector || modes_.feed_kind == Meaning::inverse_time)
        return refuse("NC0850", spot_of_motion(), "G06.2 under G43.5 or G93 is not supported", {}, "G43.4, G94");
    if (program_.moves.empty() || programmed_mm_.hasNaN() || rapid_left_out_ || whole_pose_needed_ ||
        at_reference_ != 0)
        return refuse("NC0850", spot_of_motion(), "a NURBS from a position that is not known", {},
                      "say X, Y and Z in a straight move before it");
    double speed = 0;
    if (!path_speed(speed)) return false;
    nurbs_.emplace();
    nurbs_->order = static_cast<std::size_t>(order);
    nurbs_->spot = block_.place();
    nurbs_->start_mm = programmed_mm_;
    nurbs_->start_rad = rotary_rad_;
    nurbs_->curve.degree = static_cast<int>(order) - 1;
    nurbs_->feed = {program::FeedRule::tip_speed, speed};
    return true;
}

bool FanucReader::control_point() {
    if (nurbs_->only_knots)
        return refuse("NC0850", spot_of_motion(), "a control point behind the knots that end the NURBS");
    nurbs_->turns = nurbs_->turns || (said_.said() & rotary_mask()) != 0;
    Vector3d to = programmed_mm_;
    if (!axis_words(to)) return false;
    const double weight = said_.get('R', 1);
    said_.use("R");
    if (!(weight > 0) || !std::isfinite(1 / weight))
        return refuse("NC0850", said_.word('R'), "the weight of a control point must be positive");
    programmed_mm_ = to;
    nurbs_->curve.position_mm.push_back(to);
    nurbs_->curve.rotary_rad.push_back(rotary_rad_);
    nurbs_->curve.weights.push_back(weight);
    return true;
}

/// The curve as a whole, when its blocks are over.
bool FanucReader::end_nurbs() {
    if (!nurbs_) return true;
    const bool good = check_nurbs() && keep_curve();
    nurbs_.reset();
    return good;
}

bool FanucReader::check_nurbs() {
    const Curve& curve = nurbs_->curve;
    const std::size_t points = curve.position_mm.size(), order = nurbs_->order;
    if (points < order)
        return refuse("NC0850", nurbs_->spot, "fewer control points than the order of the NURBS",
                      fmt::format("{}", points));
    if (curve.knots.size() != points + order)
        return refuse("NC0850", nurbs_->spot, "the knots are not as many as control points and order together",
                      fmt::format("{} knots, {} control points, order {}", curve.knots.size(), points, order),
                      "K alone in as many blocks behind the last control point as the order is");
    const auto& knots = curve.knots;
    if (knots[0] != knots[order - 1] || knots[points] != knots[points + order - 1])
        return refuse("NC0850", nurbs_->spot,
                      "the first knots and the last ones are not the same, each as often as the order");
    for (std::size_t i = 1; i < points; ++i)
        if (knots[i] == knots[i + order - 1])
            return refuse("NC0850", nurbs_->spot, "a knot within the NURBS stands as often as its order: it has a gap",
                          fmt::format("K{}", knots[i]));
    bool starts_here = (curve.position_mm.front() - nurbs_->start_mm).cwiseAbs().maxCoeff() <= same_place_mm;
    for (std::size_t i = 0; i < nurbs_->start_rad.size(); ++i) {
        const double from = nurbs_->start_rad[i], to = curve.rotary_rad.front()[i];
        const bool used = nurbs_->turns && (rotary_ever_ & (1u << i)) != 0;
        starts_here = starts_here && (used ? std::abs(to - from) <= same_angle_rad : true);
    }
    if (!starts_here)
        return refuse("NC0850", nurbs_->spot, "the first control point is not where the tool stands", {},
                      "go there in a straight move before G06.2");
    return true;
}

/// One move for every span that is not empty; all together are one block to an exact stop. Weights make no difference
/// to a frame, which keeps straight lines.
bool FanucReader::keep_curve() {
    Curve curve = std::move(nurbs_->curve);
    curve.position_mm.front() = nurbs_->start_mm;
    if (nurbs_->turns)
        curve.rotary_rad.front() = nurbs_->start_rad;
    else
        curve.rotary_rad.clear();
    for (Vector3d& point : curve.position_mm) {
        point = *frame_.outward(point);
        if (!point.allFinite()) return refuse("NC0201", nurbs_->spot, "the position is not finite");
    }
    const auto number = static_cast<std::int32_t>(program_.curves.size());
    const std::size_t points = curve.position_mm.size();
    Move move = move_to(curve.position_mm.back(), program::MoveKind::feed);
    move.feed = nurbs_->feed;
    move.line = nurbs_->spot.line;
    const bool stops = move.exact_stop;
    for (std::size_t span = nurbs_->order - 1; span < points; ++span) {
        if (!(curve.knots[span] < curve.knots[span + 1])) continue;
        const bool last = span + 1 == points;
        const CurvePose end = pose_at(curve, curve.knots[span + 1]);
        move.position_mm = last ? curve.position_mm.back() : end.position_mm;
        if (nurbs_->turns) move.rotary_rad = last ? curve.rotary_rad.back() : end.rotary_rad;
        const auto infinite = [](double word) { return std::isinf(word); };
        if (!move.position_mm.allFinite() || std::ranges::any_of(move.rotary_rad, infinite))
            return refuse("NC0201", nurbs_->spot, "the position is not finite");
        move.exact_stop = last && stops;
        follow_curve(program_, move, {number, curve.knots[span], curve.knots[span + 1]});
        program_.moves.push_back(move);
    }
    position_mm_ = curve.position_mm.back();
    program_.curves.push_back(std::move(curve));
    return true;
}

}  // namespace trunnion::nc::fanuc
