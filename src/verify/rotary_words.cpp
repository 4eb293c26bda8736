#include "detail/rotary_words.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "trunnion/base/quantity.hpp"

namespace trunnion::verify {

namespace {

using Rotary = std::array<double, machine::max_rotary_axes>;

constexpr double word_slack_rad = 1e-6 * degree;
constexpr double least_lever = 0.02;  // a rotary axis is never quite free: it turns the tool by so much at least

/// How far rotary axes are from words.
struct Miss {
    double of_limit = HUGE_VAL;  // of the axis that uses most of its limit
    double value_rad = 0, limit_rad = 0;
    bool operator<(const Miss& other) const { return of_limit < other.of_limit; }
};

class RotaryWords {
  public:
    RotaryWords(const SetpointTable& setpoints, const std::vector<Place>& places, const machine::Machine& machine,
                const CheckOptions& options)
        : setpoints_(setpoints), first_(machine.linear_count()), count_(machine.rotary_count) {
        const double turn = options.flank_tolerance_mm > 0 ? options.flank_tolerance_mm / options.flank_height_mm
                                                           : options.orientation_tolerance_rad;
        on_the_way_.fill(word_slack_rad + turn / least_lever);
        const double half = setpoints.period_s / 2;  // a row is not farther than this from the standstill
        for (int r = 0; r < count_; ++r) {
            const machine::Axis& axis = machine.axes[first_ + r];
            const double jerk = options.limit_excess * std::max(axis.feed.jerk, axis.rapid.jerk);
            at_stops_[r] = word_slack_rad + jerk * half * half * half / 6;
        }
        reached_mm_.reserve(places.size());
        for (const Place& place : places)
            reached_mm_.push_back(reached_mm_.empty() ? place.way_mm : std::max(reached_mm_.back(), place.way_mm));
    }

    std::size_t last_row() const { return setpoints_.rows.size() - 1; }
    std::size_t first_row_at(double way_mm) const {
        const auto found = std::lower_bound(reached_mm_.begin(), reached_mm_.end(), way_mm);
        return std::min(last_row(), static_cast<std::size_t>(found - reached_mm_.begin()));
    }

    /// Between two rows the first passage within the limits, at its best; where there is none, the best of all.
    struct Passage {
        Miss miss;
        std::size_t row = 0;
    };
    Passage pass(const ProgrammedPose& pose, std::size_t low, std::size_t high) const {
        const Rotary& limit = pose.stands ? at_stops_ : on_the_way_;
        Passage best{.row = low};
        for (std::size_t row = low; row <= high; ++row) {
            const Miss here = miss(pose.rotary_rad, limit, row, std::min(row + 1, high));
            if (here < best.miss)
                best = {here, row};
            else if (best.miss.of_limit <= 1)
                break;
        }
        return best;
    }

  private:
    double at(std::size_t row, int rotary) const { return setpoints_.rows[row].position[first_ + rotary]; }

    /// Of the chord between two rows where it is nearest.
    Miss miss(const Rotary& word, const Rotary& limit, std::size_t begin, std::size_t end) const {
        double along = 0, length2 = 0;
        for (int r = 0; r < count_; ++r) {
            const double chord = at(end, r) - at(begin, r);
            along += chord * (word[r] - at(begin, r));
            length2 += chord * chord;
        }
        const double share = length2 > 0 ? std::clamp(along / length2, 0.0, 1.0) : 0.0;
        Miss out{.of_limit = 0};
        for (int r = 0; r < count_; ++r) {
            const double off = std::abs(at(begin, r) + share * (at(end, r) - at(begin, r)) - word[r]);
            if (off / limit[r] >= out.of_limit) out = {off / limit[r], off, limit[r]};
        }
        return out;
    }

    const SetpointTable& setpoints_;
    int first_, count_;
    Rotary on_the_way_{}, at_stops_{};
    std::vector<double> reached_mm_;
};

bool has_words(const ProgrammedPose& pose, int rotary_count) {
    return pose.literal && std::none_of(pose.rotary_rad.begin(), pose.rotary_rad.begin() + rotary_count,
                                        [](double word) { return std::isnan(word); });
}

}  // namespace

void check_rotary_words(const SetpointTable& setpoints, const std::vector<ProgrammedPose>& poses,
                        const ProgrammedLine& line, const std::vector<Place>& places, double window_mm,
                        const machine::Machine& machine, const CheckOptions& options, Verdict& verdict) {
    if (machine.rotary_count == 0) return;
    const RotaryWords words(setpoints, places, machine, options);
    /// Rows between which a pose may be passed; never before `row`.
    const auto look = [&](std::size_t n, std::size_t row, std::size_t last) {
        const bool begins = n == 0, ends = n + 1 == poses.size();
        const std::size_t high = begins ? 0 : std::min(last, words.first_row_at(line.way_of(n) + window_mm));
        const std::size_t low = ends ? last : std::max(row, words.first_row_at(line.way_of(n) - window_mm));
        return words.pass(poses[n], std::min(low, high), high);
    };
    const auto judge = [&](const ProgrammedPose& pose, const RotaryWords::Passage& found, const char* what,
                           double& worst) {
        worst = std::max(worst, found.miss.value_rad / degree);
        if (found.miss.of_limit <= 1) return true;
        verdict.broken.push_back({what, setpoints.rows[found.row].time_s, pose.line, found.miss.value_rad / degree,
                                  found.miss.limit_rad / degree});
        return false;
    };
    // Standstills first: what lies between two of them is looked for between their rows.
    std::vector<std::size_t> stop_row(poses.size(), words.last_row());
    std::size_t row = 0;
    for (std::size_t n = 0; n < poses.size(); ++n) {
        if (!has_words(poses[n], machine.rotary_count) || !poses[n].stands) continue;
        const auto found = look(n, row, words.last_row());
        if (!judge(poses[n], found, "words_at_stops_deg", verdict.words_at_stops_deg)) return;
        stop_row[n] = row = found.row;
    }
    for (std::size_t n = poses.size(); n-- > 1;)
        if (!poses[n - 1].stands) stop_row[n - 1] = stop_row[n];
    row = 0;
    for (std::size_t n = 0; n < poses.size(); ++n) {
        if (!has_words(poses[n], machine.rotary_count)) continue;
        if (poses[n].stands) {
            row = stop_row[n];
            continue;
        }
        const auto found = look(n, row, stop_row[n]);
        if (!judge(poses[n], found, "words_on_the_way_deg", verdict.words_on_the_way_deg)) return;
        row = found.row;
    }
}

}  // namespace trunnion::verify
