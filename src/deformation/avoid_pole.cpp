#include "trunnion/deformation/avoid_pole.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "trunnion/base/quantity.hpp"
#include "trunnion/path/pole_passage.hpp"

#include "detail/axis_vectors.hpp"
#include "detail/followed_path.hpp"
#include "detail/pole_approach.hpp"
#include "detail/pole_turn.hpp"

namespace trunnion::deformation {

using detail::FollowedPath;
using detail::PoleApproach;
using detail::PoleTurn;
using machine::RotaryPosition;

namespace {

constexpr double kept_ratio = 0.999;  // of the velocity limit: what a turn is found for
constexpr double widest_turn_rad = 60 * degree;
constexpr int halvings = 30;
constexpr double same_u = 1e-6;  // of the whole path
/// How far a turn reaches, in multiples of its angle. Beside it the free axis still swings by up to the inverse of
/// that.
constexpr double reach_through = 200, reach_around = 20;

using Room = std::pair<double, double>;  // from and to which u

/// A way past one pole that keeps the free axis within its limit there.
struct Candidate {
    PolePassing passing;
    double angle_rad;  // of the turn, > 0
    double distance_rad;
    DualPath path;
};

Diagnostic diagnose(const Machining& machining, double u, const DualPath& path, const char* code, std::string text) {
    Diagnostic out{.code = code, .text = std::move(text)};
    const Eigen::Vector3d tip = path.at(u).tip_in_workpiece_mm;
    out.text += fmt::format(", at the tip ({:.3f}, {:.3f}, {:.3f}) and the feed {:.1f} mm/min", tip.x(), tip.y(),
                            tip.z(), 60 * machining.feed_mm_s);
    return out;
}

class PoleAvoider {
  public:
    PoleAvoider(const DualPath& path, const Machining& machining, const PoleAvoidance& avoidance)
        : original_(path),
          machining_(machining),
          avoidance_(avoidance),
          poles_(path::poles_of(machining.kinematics)),
          height_mm_(machining.tool.controlled_height_mm()) {}

    Result<PoleAvoided> run() const {
        PoleAvoided out{.path = original_};
        const auto before = rotary_use(original_, machining_);
        if (before) out.before = *before;
        const auto passages = places_to_treat(out);
        if (passages.empty()) {
            if (!before) return fail(before.error());
            out.after = *before;
            return out;
        }
        const bool nothing_too_fast = std::ranges::all_of(passages, goes_through);
        auto led = over_beginnings(out, passages);
        // Then what keeps the machine from following is not the cone.
        if (!led && nothing_too_fast && led.error().code == "DEFO0204") return fail(before.error());
        return led;
    }

  private:
    static bool goes_through(const PoleApproach& approach) { return approach.distance_rad < detail::through_pole_rad; }

    double limit() const {
        const auto free = static_cast<std::size_t>(machining_.kinematics.rotary_nearest_workpiece());
        return machining_.machine.axes[static_cast<std::size_t>(machining_.machine.linear_count()) + free]
            .feed.velocity;
    }

    /// Exactly through the pole is well, unless that is why the path cannot be followed.
    std::vector<PoleApproach> places_to_treat(PoleAvoided& out) const {
        std::vector<PoleApproach> treated;
        for (const PoleApproach& approach : detail::pole_approaches(original_, poles_)) {
            const bool through = goes_through(approach);
            const bool too_fast = !through && detail::free_axis_ratio(original_, machining_, approach.u) > 1;
            if (approach.at_end)
                out.ends_in_cone += too_fast;
            else if (too_fast || (through && !out.before))
                treated.push_back(approach);
        }
        return treated;
    }

    /// The stretch around a passage that a turn may change: half the way to those next to it, treated or not.
    Room room_of(const DualPath& path, const PoleApproach& here) const {
        Room out{original_.begin(), original_.end()};
        for (const PoleApproach& other : detail::pole_approaches(path, poles_)) {
            const bool passage = goes_through(other) || detail::free_axis_ratio(path, machining_, other.u) > 1;
            if (!passage || other.at_end || std::abs(other.u - here.u) < same_u * (out.second - out.first)) continue;
            (other.u < here.u ? out.first : out.second) = 0.5 * (other.u + here.u);
            if (other.u > here.u) break;
        }
        return out;
    }

    Result<PoleAvoided> over_beginnings(const PoleAvoided& start, const std::vector<PoleApproach>& passages) const {
        std::optional<PoleAvoided> best;
        std::optional<Diagnostic> refusal;
        for (const RotaryPosition& begin : detail::beginnings(original_, machining_)) {
            auto led = lead(start, passages, begin);
            if (!led) {
                if (!refusal || (refusal->code != "DEFO0203" && led.error().code == "DEFO0203")) refusal = led.error();
            } else if (!best || is_better(*led, *best)) {
                best = std::move(*led);
            }
        }
        if (!best) return fail(std::move(*refusal));
        return std::move(*best);
    }

    static bool is_better(const PoleAvoided& a, const PoleAvoided& b) {
        constexpr double same_rad = 1e-6;
        const double more = a.change.orientation_deviation_rad - b.change.orientation_deviation_rad;
        return more < -same_rad || (more < same_rad && a.after.travel_rad < b.after.travel_rad - same_rad);
    }

    /// Past one pole after the other, from one beginning of the rotary axes.
    Result<PoleAvoided> lead(PoleAvoided out, const std::vector<PoleApproach>& passages,
                             const RotaryPosition& begin) const {
        for (const PoleApproach& here : passages) {
            auto taken = past(out.path, here, begin, room_of(out.path, here));
            if (!taken) return fail(taken.error());
            out.passages.push_back({here.u, here.pole, here.distance_rad, taken->distance_rad, taken->passing});
            out.path = std::move(taken->path);
        }
        return judged(std::move(out), begin);
    }

    Result<PoleAvoided> judged(PoleAvoided out, const RotaryPosition& begin) const {
        auto followed = FollowedPath::make(out.path, machining_, begin, out.path.end());
        if (!followed) return fail(followed.error());
        out.after = detail::use_of(*followed, out.path, machining_);
        out.change = orientation_change(original_, out.path, machining_.tool);
        if (out.change.orientation_deviation_rad > avoidance_.orientation_tolerance_rad)
            return fail(tolerance_too_small(original_.begin(), out.change.orientation_deviation_rad));
        for (const PoleApproach& left : detail::pole_approaches(out.path, poles_))
            if (!left.at_end && !goes_through(left) && detail::free_axis_ratio(out.path, machining_, left.u) > 1)
                return fail(not_to_be_left(out.path, left));
        return out;
    }

    /// The least turn within a room whose path, up to the end of that, stays in the ranges.
    Result<Candidate> past(const DualPath& path, const PoleApproach& approach, const RotaryPosition& begin,
                           const Room& room) const {
        std::optional<Candidate> best;
        for (const PolePassing passing : {PolePassing::through, PolePassing::near_side, PolePassing::far_side}) {
            if (avoidance_.passing && *avoidance_.passing != passing) continue;
            auto tried = candidate(path, approach, passing, room);
            if (!tried || (best && best->angle_rad <= tried->angle_rad)) continue;
            if (FollowedPath::make(tried->path, machining_, begin, room.second)) best = std::move(tried);
        }
        if (!best) return fail(not_to_be_left(path, approach));
        if (best->angle_rad > avoidance_.orientation_tolerance_rad)
            return fail(tolerance_too_small(approach.u, best->angle_rad));
        return std::move(*best);
    }

    std::optional<Candidate> candidate(const DualPath& path, const PoleApproach& approach, PolePassing passing,
                                       const Room& room) const {
        const double beside = approach.distance_rad;
        if (passing != PolePassing::through) return around(path, approach, passing, room);
        if (beside < detail::through_pole_rad) return std::nullopt;
        const PoleTurn turn = PoleTurn::make(path, approach, reach_through * beside, room.first, room.second);
        if (ratio_of(turn, beside, approach.u) > 1) return std::nullopt;
        return Candidate{passing, beside, 0, turn.turned(beside, height_mm_)};
    }

    /// The least angle that keeps the limit; on the far side more than what leads to the same distance over the pole.
    std::optional<Candidate> around(const DualPath& path, const PoleApproach& approach, PolePassing passing,
                                    const Room& room) const {
        const bool near = passing == PolePassing::near_side;
        const double sense = near ? -1 : 1, beside = approach.distance_rad, cone = cone_at(path, approach);
        double enough = std::min(cone + sense * beside, widest_turn_rad), too_little = near ? 0 : beside;
        const PoleTurn turn = PoleTurn::make(path, approach, reach_around * enough, room.first, room.second);
        const auto keeps_limit = [&](double angle) { return ratio_of(turn, sense * angle, approach.u) <= kept_ratio; };
        while (enough <= widest_turn_rad && !keeps_limit(enough)) enough *= 1.1;
        if (enough > widest_turn_rad) return std::nullopt;
        for (int i = 0; i < halvings && enough - too_little > 1e-6 * enough; ++i) {
            const double middle = 0.5 * (too_little + enough);
            (keeps_limit(middle) ? enough : too_little) = middle;
        }
        return Candidate{passing, enough, std::abs(beside - sense * enough), turn.turned(sense * enough, height_mm_)};
    }

    double ratio_of(const PoleTurn& turn, double angle_rad, double u) const {
        return detail::free_axis_ratio(turn.turned(angle_rad, height_mm_), machining_, turn.from_u(), turn.to_u(), u);
    }

    double turn_rate(const DualPath& path, double u) const {
        const auto axis = path.spline.axis(u);
        return std::hypot(axis[0].d1(), axis[1].d1(), axis[2].d1()) / detail::seconds_per_u(path, u, machining_);
    }

    /// Half angle within which this rate of turn, across the way to the pole, is too fast for the free axis.
    double cone_at(const DualPath& path, const PoleApproach& approach) const {
        return std::asin(std::min(1.0, turn_rate(path, approach.u) / limit()));
    }

    Diagnostic tolerance_too_small(double u, double needed_rad) const {
        auto out = diagnose(machining_, u, original_, "DEFO0203",
                            "the orientation tolerance does not suffice to lead the path past the pole");
        out.value = fmt::format("{:.6g} deg", avoidance_.orientation_tolerance_rad / degree);
        out.limit = fmt::format("{:.6g} deg would", needed_rad * 1.001 / degree);
        out.hint = "allow more, or lower the feed: the cone shrinks with it";
        return out;
    }

    Diagnostic not_to_be_left(const DualPath& path, const PoleApproach& approach) const {
        auto out = diagnose(machining_, approach.u, path, "DEFO0204",
                            "the singular cone cannot be left inside the ranges of the axes");
        const double rate = turn_rate(path, approach.u);
        const double within =
            std::sin(std::min(avoidance_.orientation_tolerance_rad + approach.distance_rad, 90 * degree));
        out.value = fmt::format("half angle {:.4g} deg", cone_at(path, approach) / degree);
        out.hint = fmt::format("at {:.3g} mm/min the tolerance leaves it",
                               60 * machining_.feed_mm_s * within * limit() / rate);
        return out;
    }

    const DualPath& original_;
    const Machining& machining_;
    const PoleAvoidance& avoidance_;
    std::vector<Eigen::Vector3d> poles_;
    double height_mm_;
};

Result<void> check_avoidance(const Machining& machining, const PoleAvoidance& avoidance) {
    if (auto ok = detail::check_machining(machining); !ok) return ok;
    if (avoidance.orientation_tolerance_rad > 0 && std::isfinite(avoidance.orientation_tolerance_rad)) return {};
    Diagnostic out{.code = "DEFO0202", .text = "the orientation tolerance is not above 0"};
    out.value = fmt::format("{} deg", avoidance.orientation_tolerance_rad / degree);
    return fail(std::move(out));
}

}  // namespace

Result<PoleAvoided> avoid_pole(const DualPath& path, const Machining& machining, const PoleAvoidance& avoidance) {
    if (auto ok = detail::check_cubic(path); !ok) return fail(ok.error());
    if (auto ok = check_avoidance(machining, avoidance); !ok) return fail(ok.error());
    return PoleAvoider(path, machining, avoidance).run();
}

Result<PosesPoleAvoided> avoid_pole(std::span<const Pose> poses, const DualFit& fit, const Machining& machining,
                                    const PoleAvoidance& avoidance) {
    const auto fitted = fit_dual_path(poses, fit);
    if (!fitted) return fail(fitted.error());
    auto avoided = avoid_pole(fitted->path, machining, avoidance);
    if (!avoided) return fail(avoided.error());
    auto out = detail::poses_about(poses, fitted->parameters, avoided->path, machining.tool.controlled_height_mm());
    return PosesPoleAvoided{std::move(out), std::move(*avoided)};
}

}  // namespace trunnion::deformation
