#include "trunnion/verify/check.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include <fmt/format.h>

#include "trunnion/base/quantity.hpp"

#include "detail/axis_limits.hpp"
#include "detail/chain.hpp"
#include "detail/fault.hpp"
#include "detail/follower.hpp"
#include "detail/pose_deviations.hpp"
#include "detail/programmed_line.hpp"
#include "detail/rotary_words.hpp"

namespace trunnion::verify {

namespace {

constexpr double length_slack_mm = 1e-6;
constexpr double angle_slack_deg = 1e-6;

std::optional<Diagnostic> not_positive(const char* what, double value) {
    if (value > 0 && std::isfinite(value)) return {};
    auto fault = fault_at(0, "VER0303", fmt::format("{} must be above 0", what));
    fault.value = fmt::format("{}", value);
    return fault;
}

constexpr double largest_position = 1e12;  // squares of differences stay finite

Diagnostic not_finite(const char* what, std::int32_t line) {
    return fault_at(line, "VER0108", fmt::format("{} is not finite, or beyond {} mm or rad", what, largest_position));
}

std::optional<Diagnostic> fault_in(const machine::Axis& axis) {
    for (const double limit : {axis.feed.velocity, axis.feed.acceleration, axis.feed.jerk})
        if (auto fault = not_positive(fmt::format("a limit of axis {}", axis.letter).c_str(), limit)) return fault;
    return {};
}

std::optional<Diagnostic> fault_in(const CheckOptions& options) {
    if (auto fault = not_positive("the tip tolerance", options.tip_tolerance_mm)) return fault;
    if (auto fault = not_positive("the flank height", options.flank_height_mm)) return fault;
    if (auto fault = not_positive("the limit excess", options.limit_excess)) return fault;
    if (options.flank_tolerance_mm != 0) return not_positive("the flank tolerance", options.flank_tolerance_mm);
    return not_positive("the orientation tolerance", options.orientation_tolerance_rad);
}

std::optional<Diagnostic> fault_in(const SetpointTable& setpoints, const std::vector<ProgrammedPose>& poses,
                                   const machine::Machine& machine, const CheckOptions& options) {
    if (setpoints.rows.empty()) return fault_at(0, "VER0301", "there are no setpoints to check");
    if (poses.empty()) return fault_at(0, "VER0302", "there are no programmed poses to check against");
    for (const auto& row : setpoints.rows)
        for (const double x : row.position.v)
            if (!(std::abs(x) <= largest_position)) return not_finite("a setpoint", row.line);
    for (const auto& pose : poses)
        if (!(pose.tip_mm.cwiseAbs().maxCoeff() <= largest_position) || !pose.axis.allFinite())
            return not_finite("a programmed pose", pose.line);
    for (int i = 0; i < machine.axis_count; ++i)
        if (auto fault = fault_in(machine.axes[i])) return fault;
    return fault_in(options);
}

/// Whether the orientation is judged by the point at the flank height.
bool by_flank(const CheckOptions& options) {
    return options.flank_tolerance_mm > 0;
}

/// How far motion and programme may be apart in the joint space without breaking a tolerance.
double joint_tolerance_mm(const CheckOptions& options) {
    const double turn =
        by_flank(options) ? options.flank_tolerance_mm : options.flank_height_mm * options.orientation_tolerance_rad;
    return options.tip_tolerance_mm + turn;
}

Reach reach_for(const CheckOptions& options) {
    const double tolerance = joint_tolerance_mm(options);
    return {.window_mm = 0.3 + 4 * tolerance,
            .lost_mm = 2 * tolerance,
            .far_mm = 100,
            .beam_mm2 = 0.25 + 4 * tolerance * tolerance};
}

/// A motion may go back on the path by so much.
double slack_mm(const CheckOptions& options) {
    return 0.02 + 0.5 * joint_tolerance_mm(options);
}

Allowed allowed_by(const CheckOptions& options) {
    return {.tip_mm = options.tip_tolerance_mm,
            .height_mm = by_flank(options) ? options.flank_tolerance_mm : HUGE_VAL,
            .angle_rad = by_flank(options) ? HUGE_VAL : options.orientation_tolerance_rad};
}

/// Keeps one field's worst value and its first breach.
class Maximum {
  public:
    Maximum(const char* what, double limit, double slack) : what_(what), limit_(limit), slack_(slack) {}
    void see(double value, const motion::Setpoint& row, std::int32_t line) {
        worst_ = std::max(worst_, value);
        if (!breach_ && !(value <= limit_ + slack_)) breach_ = Breach{what_, row.time_s, line, value, limit_};
    }
    double worst() const { return worst_; }
    void tell(std::vector<Breach>& broken) const {
        if (breach_) broken.push_back(*breach_);
    }

  private:
    const char* what_;
    double limit_, slack_;
    double worst_ = 0;
    std::optional<Breach> breach_;
};

/// Tip, angle and height together.
class Maxima {
  public:
    Maxima(const char* tip, const char* angle, const char* height, const CheckOptions& options)
        : tip_(tip, options.tip_tolerance_mm, length_slack_mm),
          angle_(angle, by_flank(options) ? HUGE_VAL : options.orientation_tolerance_rad / degree, angle_slack_deg),
          height_(height, by_flank(options) ? options.flank_tolerance_mm : HUGE_VAL, length_slack_mm) {}
    void see(const Distance& distance, const motion::Setpoint& row, std::int32_t line) {
        tip_.see(distance.tip_mm, row, line);
        angle_.see(distance.angle_rad / degree, row, line);
        height_.see(distance.height_mm, row, line);
    }
    void tell(std::vector<Breach>& broken) const {
        for (const Maximum* one : {&tip_, &angle_, &height_}) one->tell(broken);
    }
    double tip_mm() const { return tip_.worst(); }
    double angle_deg() const { return angle_.worst(); }
    double height_mm() const { return height_.worst(); }

  private:
    Maximum tip_, angle_, height_;
};

/// Compares one motion with one programme.
class Comparison {
  public:
    Comparison(const SetpointTable& setpoints, const std::vector<ProgrammedPose>& poses, const ProgrammedLine& line,
               const Chain& chain, const CheckOptions& options)
        : setpoints_(setpoints), poses_(poses), line_(line), options_(options) {
        rows_.reserve(setpoints.rows.size());
        for (const auto& row : setpoints.rows) rows_.push_back(chain.gauge(row.position));
        places_ = places_in_order(line, rows_, reach_for(options));
    }

    std::vector<bool> rows_at_rapid() const {
        std::vector<bool> out(places_.size());
        for (std::size_t n = 0; n < out.size(); ++n) out[n] = line_.segments()[places_[n].segment].at_rapid;
        return out;
    }

    void rows_from_path(Verdict& verdict) const {
        Maxima maxima("tip_deviation_mm", "orientation_deviation_deg", "height_deviation_mm", options_);
        for (std::size_t n = 0; n < rows_.size(); ++n) {
            const Distance nearest = distance(n, places_[n]);
            const bool kept = allowed_by(options_).used_by(nearest) <= 1;
            maxima.see(kept ? nearest : distance_within_slack(n, nearest), setpoints_.rows[n], line_at(places_[n]));
        }
        verdict.tip_deviation_mm = maxima.tip_mm();
        verdict.orientation_deviation_deg = maxima.angle_deg();
        verdict.height_deviation_mm = maxima.height_mm();
        maxima.tell(verdict.broken);
    }

    void poses_from_motion(Verdict& verdict) const {
        Maxima maxima("tip_to_poses_mm", "orientation_to_poses_deg", "height_to_poses_mm", options_);
        const PosePasses passes(line_, rows_, places_, reach_for(options_).window_mm, allowed_by(options_));
        for (std::size_t n = 0; n < poses_.size(); ++n) {
            const auto pass = passes.at(n, poses_[n]);
            maxima.see(pass.distance, setpoints_.rows[pass.row], poses_[n].line);
        }
        verdict.tip_to_poses_mm = maxima.tip_mm();
        verdict.orientation_to_poses_deg = maxima.angle_deg();
        verdict.height_to_poses_mm = maxima.height_mm();
        maxima.tell(verdict.broken);
    }

    void words(const machine::Machine& machine, Verdict& verdict) const {
        check_rotary_words(setpoints_, poses_, line_, places_, reach_for(options_).window_mm, machine, options_,
                           verdict);
    }

    void coverage(Verdict& verdict) const {
        const auto farthest = std::max_element(places_.begin(), places_.end(),
                                               [](const Place& a, const Place& b) { return a.way_mm < b.way_mm; });
        const double length = line_.length_mm(), left = length - farthest->way_mm;
        verdict.path_covered = left <= length_slack_mm ? 1.0 : farthest->way_mm / length;
        if (left > joint_tolerance_mm(options_))
            verdict.broken.push_back(
                {"path_covered", setpoints_.rows.back().time_s, line_at(*farthest), verdict.path_covered, 1});
    }

    void ends(Verdict& verdict) const {
        const auto error = [&](std::size_t row, std::size_t pose) {
            return (rows_[row].tip_mm(line_.tool_at(pose).length_mm) - poses_[pose].tip_mm).norm();
        };
        Maximum start("start_error_mm", options_.tip_tolerance_mm, length_slack_mm);
        Maximum end("end_error_mm", options_.tip_tolerance_mm, length_slack_mm);
        start.see(error(0, 0), setpoints_.rows.front(), poses_.front().line);
        end.see(error(rows_.size() - 1, poses_.size() - 1), setpoints_.rows.back(), poses_.back().line);
        verdict.start_error_mm = start.worst();
        verdict.end_error_mm = end.worst();
        start.tell(verdict.broken);
        end.tell(verdict.broken);
    }

  private:
    Distance distance(std::size_t row, const Place& place) const {
        const ToolHeights& tool = line_.segments()[place.segment].tool;
        const Joint6 point = joint_of(rows_[row], tool, line_.flank_mm());
        return distance_between(point, line_.at(place.segment, place.w).point, tool, line_.flank_mm());
    }

    /// The nearest place weighs tip against turn by the flank height, not by the tolerances. Where a row breaks one
    /// there, a place that keeps both is looked for in the slack around: golden section of the larger share. Else
    /// `nearest`.
    Distance distance_within_slack(std::size_t row, const Distance& nearest) const {
        const Allowed allowed = allowed_by(options_);
        const double way = places_[row].way_mm, golden = 0.5 * (std::sqrt(5.0) - 1);
        double low = way - slack_mm(options_), high = way + slack_mm(options_);
        for (int n = 0; n < 24; ++n) {
            const double cut = golden * (high - low);
            const double before = allowed.used_by(distance(row, line_.place_on_way(high - cut)));
            const double behind = allowed.used_by(distance(row, line_.place_on_way(low + cut)));
            (before < behind ? high : low) = before < behind ? low + cut : high - cut;
        }
        const Distance found = distance(row, line_.place_on_way(0.5 * (low + high)));
        return allowed.used_by(found) <= 1 ? found : nearest;
    }

    std::int32_t line_at(const Place& place) const {
        return poses_[std::min(place.segment + 1, poses_.size() - 1)].line;
    }

    const SetpointTable& setpoints_;
    const std::vector<ProgrammedPose>& poses_;
    const ProgrammedLine& line_;
    const CheckOptions& options_;
    std::vector<Gauge> rows_;
    std::vector<Place> places_;
};

}  // namespace

const Breach* Verdict::first_of(std::string_view what) const {
    const auto found = std::find_if(broken.begin(), broken.end(), [what](const Breach& b) { return b.what == what; });
    return found == broken.end() ? nullptr : &*found;
}

Result<Verdict> check(const SetpointTable& setpoints, const std::vector<ProgrammedPose>& poses,
                      const machine::Machine& machine, const machine::Setup& setup, const CheckOptions& options) {
    if (auto fault = fault_in(setpoints, poses, machine, options)) return fail(std::move(*fault));
    const Chain chain(machine, setup.workpiece);
    const auto line =
        ProgrammedLine::make(poses, machine, setup, chain,
                             {.length_mm = setup.tool.length_mm, .controlled_mm = options.controlled_height_mm},
                             options.flank_height_mm, slack_mm(options));
    if (!line) return fail(line.error());
    Verdict verdict;
    verdict.rows = setpoints.rows.size();
    verdict.period_s = setpoints.period_s;
    verdict.cycle_time_s = setpoints.rows.back().time_s - setpoints.rows.front().time_s;
    const Comparison comparison(setpoints, poses, *line, chain, options);
    check_axes(setpoints, comparison.rows_at_rapid(), machine, options.limit_excess, verdict);
    comparison.rows_from_path(verdict);
    comparison.poses_from_motion(verdict);
    comparison.words(machine, verdict);
    comparison.coverage(verdict);
    comparison.ends(verdict);
    std::stable_sort(verdict.broken.begin(), verdict.broken.end(),
                     [](const Breach& a, const Breach& b) { return a.time_s < b.time_s; });
    verdict.ok = verdict.broken.empty();
    return verdict;
}

}  // namespace trunnion::verify
