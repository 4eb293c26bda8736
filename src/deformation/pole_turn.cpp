#include "detail/pole_turn.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "trunnion/geometry/great_circle.hpp"
#include "trunnion/geometry/rotation.hpp"
#include "trunnion/path/pole_passage.hpp"

#include "detail/axis_vectors.hpp"
#include "detail/followed_path.hpp"
#include "detail/spline_equations.hpp"

namespace trunnion::deformation::detail {

using Eigen::Vector3d;

namespace {

constexpr int looks_an_interval = 8;
constexpr int even_looks = 200, close_looks = 60;
/// Control points beside the nearest place that are turned in full: all that have a part in it.
constexpr double spans_in_full = 2;

/// The turn of the tool along a path, ∫|dn|, as a function of u.
class TurnAlong {
  public:
    explicit TurnAlong(const DualPath& path) {
        const std::vector<double> at = stations_of(path.spline.bottom().knots());
        add(path, at.front());
        for (std::size_t k = 0; k + 1 < at.size(); ++k)
            for (int i = 1; i <= looks_an_interval; ++i)
                add(path, i == looks_an_interval ? at[k + 1] : at[k] + (at[k + 1] - at[k]) * i / looks_an_interval);
    }

    double operator()(double u) const {
        const auto after = std::ranges::upper_bound(u_, u);
        if (after == u_.begin()) return turn_.front();
        if (after == u_.end()) return turn_.back();
        const auto i = static_cast<std::size_t>(after - u_.begin());
        return turn_[i - 1] + (turn_[i] - turn_[i - 1]) * (u - u_[i - 1]) / (u_[i] - u_[i - 1]);
    }

  private:
    void add(const DualPath& path, double u) {
        const Vector3d axis = path.at(u).axis_in_workpiece;
        turn_.push_back(u_.empty() ? 0 : turn_.back() + geometry::angle_between(axis, last_));
        u_.push_back(u);
        last_ = axis;
    }
    std::vector<double> u_, turn_;
    Vector3d last_ = Vector3d::UnitZ();
};

/// How far the turn reaches to one side of the nearest place, and how wide control points may stand there.
struct Reach {
    double rad = 0;
    double widest_rad() const { return path::level_share * rad / spans_in_full; }
};

Reach reach_of(double wanted_rad, double room_rad, double widest_span_rad) {
    return {std::min(room_rad, std::max(wanted_rad, spans_in_full * widest_span_rad / path::level_share))};
}

/// Knots that divide the intervals beside the nearest place so that none turns the tool by more than is allowed.
std::vector<double> knots_between(const std::vector<double>& at, const TurnAlong& turn, double place,
                                  const Reach& before, const Reach& after) {
    constexpr double most_parts = 64;
    std::vector<double> out;
    for (std::size_t k = 0; k + 1 < at.size(); ++k) {
        const double from = turn(at[k]) - place, to = turn(at[k + 1]) - place;
        if (to < -before.rad || from > after.rad) continue;
        const double widest =
            std::min(from < 0 ? before.widest_rad() : HUGE_VAL, to > 0 ? after.widest_rad() : HUGE_VAL);
        const double parts = std::min(std::ceil((to - from) / widest), most_parts);
        for (double i = 1; i < parts; ++i) out.push_back(at[k] + (at[k + 1] - at[k]) * i / parts);
    }
    return out;
}

double widest_span(const std::vector<double>& at, const TurnAlong& turn, double u) {
    double widest = 0;
    const auto here = std::ranges::upper_bound(at, u) - at.begin() - 1;
    const auto last = static_cast<std::ptrdiff_t>(at.size()) - 2;
    for (auto k = std::max<std::ptrdiff_t>(here - 2, 0); k <= std::min(here + 2, last); ++k) {
        const auto i = static_cast<std::size_t>(k);
        widest = std::max(widest, turn(at[i + 1]) - turn(at[i]));
    }
    return widest;
}

Vector3d direction_of_turn(const DualPath& path, const PoleApproach& approach) {
    constexpr double beside_rad = 1e-9;
    const auto axis = path.spline.axis(approach.u);
    const Vector3d n(axis[0].value(), axis[1].value(), axis[2].value());
    if (approach.distance_rad > beside_rad) return n.cross(approach.pole).normalized();
    return Vector3d(axis[0].d1(), axis[1].d1(), axis[2].d1()).normalized();
}

}  // namespace

PoleTurn PoleTurn::make(const DualPath& path, const PoleApproach& approach, double reach_rad, double from_u,
                        double to_u) {
    const TurnAlong turn(path);
    const double place = turn(approach.u);
    const std::vector<double> at = stations_of(path.spline.bottom().knots());
    const double span = widest_span(at, turn, approach.u);
    const Reach before = reach_of(reach_rad, place - turn(from_u), span),
                after = reach_of(reach_rad, turn(to_u) - place, span);
    const auto added = knots_between(at, turn, place, before, after);
    PoleTurn out(added.empty() ? path : with_knots(path, added));
    out.about_ = direction_of_turn(path, approach);
    const std::vector<double> places = control_places(out.path_);
    for (const double u : places) {
        const double away = turn(u) - place, reach = away < 0 ? before.rad : after.rad;
        out.share_.push_back(reach > 0 ? path::shift_share(std::abs(away) / reach) : 0);
    }
    out.share_.front() = out.share_.back() = 0;
    const auto changed = [](double share) { return share > 0; };
    const auto& knots = out.path_.spline.bottom().knots();
    const auto first = std::ranges::find_if(out.share_, changed) - out.share_.begin();
    const auto last = std::find_if(out.share_.rbegin(), out.share_.rend(), changed).base() - out.share_.begin() - 1;
    out.from_u_ = knots[static_cast<std::size_t>(first)];
    out.to_u_ = knots[static_cast<std::size_t>(last + 4)];
    return out;
}

DualPath PoleTurn::turned(double angle_rad, double controlled_height_mm) const {
    std::vector<Vector3d> vectors = axis_vectors(path_);
    for (std::size_t i = 0; i < vectors.size(); ++i)
        if (share_[i] > 0) vectors[i] = geometry::rotation_about(about_, angle_rad * share_[i]) * vectors[i];
    return with_axis_vectors(path_, vectors, controlled_height_mm);
}

double free_axis_ratio(const DualPath& path, const Machining& machining, double u) {
    const auto free = static_cast<std::size_t>(machining.kinematics.rotary_nearest_workpiece());
    const auto& axis = machining.machine.axes[static_cast<std::size_t>(machining.machine.linear_count()) + free];
    const auto at = machining.kinematics.rotary_for(path.at(u).axis_in_workpiece);
    if (at.count == 0 || at.degenerate) return 0;
    const auto series = machining.kinematics.rotary_series(path.spline.axis(u), at.rotary_rad[0]);
    return std::abs(series[free].d1()) / (seconds_per_u(path, u, machining) * axis.feed.velocity);
}

double free_axis_ratio(const DualPath& path, const Machining& machining, double from_u, double to_u, double near_u) {
    const auto ratio = [&](double u) { return free_axis_ratio(path, machining, u); };
    double out = 0;
    for (int k = 0; k <= even_looks; ++k) out = std::max(out, ratio(from_u + (to_u - from_u) * k / even_looks));
    for (int k = 0; k <= close_looks; ++k) {
        const double t = static_cast<double>(k) / close_looks, share = t * t * t;
        out = std::max({out, ratio(near_u + (from_u - near_u) * share), ratio(near_u + (to_u - near_u) * share)});
    }
    return out;
}

}  // namespace trunnion::deformation::detail
