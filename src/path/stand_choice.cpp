#include "detail/stand_choice.hpp"

namespace trunnion::path::detail {

using machine::AxisPosition;
using machine::Kinematics;
using machine::RotaryPosition;
using program::Move;
using program::MoveKind;
using program::RotaryStand;

namespace {

constexpr std::size_t most_states = 12;        // kept of one stage, the cheapest
constexpr double look_every_rad = 5 * degree;  // of a rapid that turns the axes themselves

}  // namespace

Result<bool> StandChoice::at_pole(std::size_t move) const {
    const auto solutions = way_.solutions_at_end(move);
    if (!solutions) return fail(solutions.error());
    return solutions->degenerate;
}

std::size_t StandChoice::end_of_literal(std::size_t first) const {
    std::size_t last = first;
    while (last + 1 < program_.moves.size() && is_literal(last + 1)) ++last;
    return last;
}

/// Up to the next place of choice: a rapid, or the pole once the moves have been off it, where the axes stand still or
/// the tool stays in its direction.
Result<std::size_t> StandChoice::end_of_vectors(std::size_t first) const {
    bool was_off_pole = false;
    for (std::size_t k = first;; ++k) {
        const std::size_t next = k + 1;
        if (next == program_.moves.size() || is_literal(next) || is_rapid(next)) return k;
        const auto here = at_pole(k);
        if (!here) return fail(here.error());
        was_off_pole = was_off_pole || !*here;
        if (!*here || !was_off_pole) continue;
        if (stop_between(program_, next) != StopCause::corner) return k;
        const auto stays = at_pole(next);
        if (!stays) return fail(stays.error());
        if (*stays && program_.moves[next].curve_part == program::no_curve_part) return k;
    }
}

RotaryPosition StandChoice::after_words(const Move& move, RotaryPosition standing) const {
    if (move.law != OrientationLaw::rotary) return standing;
    for (int a = 0; a < machine_.rotary_count; ++a) {
        const int word = surroundings_.word_of_axis(a);
        if (word < 0) continue;
        const double said = move.rotary_rad[static_cast<std::size_t>(word)];
        if (!std::isnan(said)) standing[a] = said;
    }
    return standing;
}

/// Every choice so far is carried through the words; choices that come out at one position go on as the cheapest.
Result<void> StandChoice::carry_out_literal(Stage& stage, const std::vector<State>& before) {
    for (std::size_t s = 0; s < before.size(); ++s) {
        State state{.cost_rad = before[s].cost_rad, .from = s, .end = before[s].end};
        for (std::size_t k = stage.first; k <= stage.last; ++k) {
            const Move& move = program_.moves[k];
            const auto in = surroundings_.of(move);
            if (!in) return fail(in.error());
            const RotaryPosition standing = rotary_of(machine_, state.end);
            const RotaryPosition to = after_words(move, standing);
            state.cost_rad += way_of(standing, to);
            const Eigen::Vector3d at = whole_position(move, *in, machine_, state.end);
            if (move.space == Space::workpiece)
                state.end = position(*in->kinematics, out_of_offset(*in->offset, at), to);
            else
                state.end = axes_of(machine_,
                                    move.space == Space::machine ? std::array<double, 3>{at.x(), at.y(), at.z()}
                                                                 : linear_of_untransformed(*in, at),
                                    to);
        }
        const auto same = std::find_if(stage.states.begin(), stage.states.end(), [&](const State& other) {
            return way_of(rotary_of(machine_, other.end), rotary_of(machine_, state.end)) < same_position;
        });
        if (same == stage.states.end())
            stage.states.push_back(state);
        else if (state.cost_rad < same->cost_rad)
            *same = state;
    }
    return {};
}

/// The tool where a move begins.
Result<ToolPose> StandChoice::pose_before(std::size_t move, const State& state) {
    const auto in = surroundings_.of(program_.moves[move]);
    if (!in) return fail(in.error());
    const auto pose = in->kinematics->forward(state.end);
    return ToolPose{pose.tip_in_workpiece_mm, pose.axis_in_workpiece};
}

bool StandChoice::linear_outside(const Kinematics& kinematics, const Eigen::Vector3d& tip_mm,
                                 const RotaryPosition& at) const {
    const auto linear = kinematics.linear_for(tip_mm, at);
    for (int i = 0; i < machine_.linear_count(); ++i)
        if (!(linear[i] >= machine_.axes[i].range_min - linear_slack_mm &&
              linear[i] <= machine_.axes[i].range_max + linear_slack_mm))
            return true;
    return false;
}

/// The first axis that is out of its range.
std::optional<int> StandChoice::outside(const AxisPosition& q) const {
    for (int i = 0; i < machine_.axis_count; ++i) {
        const machine::Axis& axis = machine_.axes[i];
        const double slack = axis.rotary ? rotary_slack_rad : linear_slack_mm;
        if (!(q[i] >= axis.range_min - slack && q[i] <= axis.range_max + slack)) return i;
    }
    return std::nullopt;
}

Result<std::size_t> StandChoice::add_track(Stage& stage, Entry entry, bool before_first, const RotaryPosition& begin,
                                           const ToolPose& before) {
    return add_track(stage, Track{.entry = entry, .before_first = before_first, .begin = begin}, before);
}

Result<std::size_t> StandChoice::add_track(Stage& stage, Track track, const ToolPose& before) {
    track.low = track.high = track.begin;
    track.at_end.reserve(stage.last - stage.first + 1);
    RotaryPosition last = track.begin;
    const auto on_place = [&](std::size_t, const RotaryPosition& at, const Eigen::Vector3d& tip, const Kinematics& k) {
        for (int a = 0; a < axes; ++a) {
            track.low[a] = std::min(track.low[a], at[a]);
            track.high[a] = std::max(track.high[a], at[a]);
        }
        track.travel_rad += way_of(last, at);
        last = at;
        track.last_tip_mm = tip;
        track.linear_inside = track.linear_inside && !linear_outside(k, tip, at);
    };
    if (auto walked = walk(stage, track, before, on_place, &track.at_end); !walked) return fail(walked.error());
    stage.tracks.push_back(std::move(track));
    return stage.tracks.size() - 1;
}

Result<std::optional<std::size_t>> StandChoice::first_off_pole(const Stage& stage) const {
    for (std::size_t k = stage.first; k <= stage.last; ++k) {
        const auto pole = at_pole(k);
        if (!pole) return fail(pole.error());
        if (!*pole) return std::optional(k);
    }
    return std::optional<std::size_t>();
}

/// Both ways to leave the pole with the first tilted move; the free axis stands so from the beginning.
Result<void> StandChoice::leave_by_first_tilted(Stage& stage, Entry entry, const ToolPose& before, std::size_t tilted) {
    const auto in = surroundings_.of(program_.moves[tilted]);
    ToolPose from = before;
    for (std::size_t k = stage.first; k < tilted; ++k) {
        auto next = way_.end_of(k, from.tip_mm);
        if (!next) return fail(next.error());
        from = *next;
    }
    const auto to = way_.end_of(tilted, from.tip_mm);
    if (!to) return fail(to.error());
    for (const RotaryPosition& begin : way_.leaving_pole(*in->kinematics, from, *to))
        if (auto added = add_track(stage, entry, tilted == stage.first, begin, before); !added)
            return fail(added.error());
    return {};
}

/// Both branches from the end of the first move on.
Result<void> StandChoice::add_free_tracks(Stage& stage, const ToolPose& before) {
    const auto tilted = first_off_pole(stage);
    if (!tilted) return fail(tilted.error());
    if (!*tilted) return {};
    if (**tilted > stage.first) return leave_by_first_tilted(stage, Entry::free, before, **tilted);
    const auto in = surroundings_.of(program_.moves[stage.first]);
    const auto solutions = way_.solutions_at_end(stage.first);
    for (int branch = 0; branch < solutions->count; ++branch) {
        const RotaryPosition begin = solution_of(*in->kinematics, *solutions, branch, {}).rotary_rad;
        if (auto added = add_track(stage, Entry::free, false, begin, before); !added) return fail(added.error());
    }
    return {};
}

/// Tracks of a stage that a choice can go on with where it is not free: from the pole, or from where the axes stand.
Result<std::vector<std::size_t>> StandChoice::tracks_from(Stage& stage, const State& state, Entry entry,
                                                          const ToolPose& before) {
    std::vector<std::size_t> out;
    if (entry == Entry::pole) {
        if (stage.tracks.empty()) {
            const auto tilted = first_off_pole(stage);
            if (!tilted) return fail(tilted.error());
            if (*tilted)
                if (auto added = leave_by_first_tilted(stage, Entry::pole, before, **tilted); !added)
                    return fail(added.error());
        }
        for (std::size_t t = 0; t < stage.tracks.size(); ++t)
            if (stage.tracks[t].entry == Entry::pole) out.push_back(t);
        if (!out.empty()) return out;
    }
    const RotaryPosition standing = rotary_of(machine_, state.end);
    for (std::size_t t = 0; t < stage.tracks.size(); ++t) {
        const RotaryPosition& begin = stage.tracks[t].begin;
        bool same = stage.tracks[t].entry == Entry::fixed;
        for (int a = 0; a < axes; ++a)
            same = same && std::abs(std::remainder(begin[a] - standing[a], full_turn)) < same_position;
        if (same) out.push_back(t);
    }
    if (!out.empty()) return out;
    if (stage.candidate) {
        if (auto added = add_ways_past_pole(stage, standing, before); !added) return fail(added.error());
        for (std::size_t t = 0; t < stage.tracks.size(); ++t)
            if (stage.tracks[t].begin == standing) out.push_back(t);
        return out;
    }
    const auto added = add_track(stage, Entry::fixed, true, standing, before);
    if (!added) return fail(added.error());
    return std::vector{*added};
}

/// Whole turns that may be added to an axis of a track: the number nearest to where it stands and its neighbours, or,
/// where the axis is not free, only the one that leaves it standing.
std::vector<double> StandChoice::turns_of(const Track& track, int axis, bool free, double standing_rad) const {
    const double wanted = (standing_rad - track.begin[axis]) / full_turn, rounded = std::round(wanted);
    if (axis >= machine_.rotary_count) return {0};
    const machine::Axis& range = machine_.axes[machine_.linear_count() + axis];
    const double least = std::ceil((range.range_min - rotary_slack_rad - track.low[axis]) / full_turn);
    const double most = std::floor((range.range_max + rotary_slack_rad - track.high[axis]) / full_turn);
    if (!(least <= most)) return {};
    if (!free) {
        const bool stays = std::abs(wanted - rounded) * full_turn < same_position;
        return stays && rounded >= least && rounded <= most ? std::vector{rounded} : std::vector<double>{};
    }
    const double nearest = std::clamp(rounded, least, most);
    std::vector<double> out{nearest};
    if (nearest - 1 >= least) out.push_back(nearest - 1);
    if (nearest + 1 <= most) out.push_back(nearest + 1);
    return out;
}

/// Where the turn of the tool axis in one plane takes the rotary axes on the first move of a stage; nothing where it
/// cannot, or would leave the ranges.
std::optional<RotaryPosition> StandChoice::turned_by_vector(const Stage& stage, const State& state,
                                                            const ToolPose& before) {
    const RotaryPosition standing = rotary_of(machine_, state.end);
    const auto in = surroundings_.of(program_.moves[stage.first]);
    const auto to = way_.end_of(stage.first, before.tip_mm);
    if (!in || !to) return std::nullopt;
    AlongWay along{*solution_after(*in->kinematics, in->kinematics->rotary_for(before.axis), {standing}, 0)};
    along.last_branch = along.at.branch;
    RotaryPosition at_begin = standing;
    bool inside = true;
    const auto look = [&](const RotaryPosition& at, const Eigen::Vector3d& tip, const Kinematics& k) {
        inside = inside && !outside(position(k, tip, at));
    };
    const auto gone = way_.go(stage.first, before, *to, along, at_begin, look);
    if (!gone || !inside || way_of(at_begin, standing) > same_position) return std::nullopt;
    return along.at.rotary_rad;
}

/// Whether the linear axes stay inside their ranges while the tip goes straight and the rotary axes turn linearly.
bool StandChoice::turning_stays_inside(const Kinematics& kinematics, const ToolPose& from,
                                       const Eigen::Vector3d& to_tip_mm, const RotaryPosition& begin,
                                       const RotaryPosition& end) const {
    const double parts = std::ceil(way_of(begin, end) / look_every_rad);
    for (double k = 1; k < parts; ++k) {
        const double w = k / parts;
        const RotaryPosition at{begin[0] + w * (end[0] - begin[0]), begin[1] + w * (end[1] - begin[1])};
        if (linear_outside(kinematics, from.tip_mm + w * (to_tip_mm - from.tip_mm), at)) return false;
    }
    return true;
}

/// Every choice that goes on from one of the stage before along a track.
Result<void> StandChoice::add_states(Stage& stage, std::size_t track_index, std::size_t from, const State& before,
                                     const ToolPose& pose_before, const std::optional<RotaryPosition>& by_vector) {
    const Track& track = stage.tracks[track_index];
    if (!track.linear_inside) return {};
    const auto in = surroundings_.of(program_.moves[stage.first]),
               at_last = surroundings_.of(program_.moves[stage.last]);
    if (!in || !at_last) return fail((in ? at_last : in).error());
    const auto first_end = way_.end_of(stage.first, pose_before.tip_mm);
    if (!first_end) return fail(first_end.error());
    const RotaryPosition standing = rotary_of(machine_, before.end);
    const auto free = [&](int axis) {
        return track.entry == Entry::free ||
               (track.entry == Entry::pole && axis == in->kinematics->rotary_nearest_workpiece());
    };
    for (const double turns_0 : turns_of(track, 0, free(0), standing[0]))
        for (const double turns_1 : turns_of(track, 1, free(1), standing[1])) {
            State state{.from = from, .track = track_index, .turns = {turns_0, turns_1}};
            const RotaryPosition begin = shifted(track.begin, state.turns);
            const bool moves_there = !track.before_first && stage.first > 0;
            const bool by_itself = by_vector && way_of(*by_vector, begin) < same_position;
            state.rebranched = moves_there && !by_itself && way_of(standing, begin) > same_position;
            const bool in_place = track.before_first && way_of(standing, begin) > same_position;
            if ((state.rebranched || in_place) &&
                !turning_stays_inside(*in->kinematics, pose_before, in_place ? pose_before.tip_mm : first_end->tip_mm,
                                      standing, begin))
                continue;
            state.cost_rad = before.cost_rad + way_of(standing, begin) + track.travel_rad;
            state.end = position(*at_last->kinematics, track.last_tip_mm, shifted(track.at_end.back(), state.turns));
            const auto same = std::find_if(stage.states.begin(), stage.states.end(), [&](const State& other) {
                return other.track == state.track && other.turns == state.turns;
            });
            if (same == stage.states.end())
                stage.states.push_back(state);
            else if (state.cost_rad < same->cost_rad)
                *same = state;
        }
    return {};
}

/// A stage that never leaves the pole: the free axis goes where the turn of the tool leaves it.
Result<std::size_t> StandChoice::add_resting_track(Stage& stage, const State& state, const ToolPose& before,
                                                   const std::optional<RotaryPosition>& by_vector) {
    const auto in = surroundings_.of(program_.moves[stage.first]);
    const auto solutions = way_.solutions_at_end(stage.first);
    if (!in || !solutions) return fail(in ? solutions.error() : in.error());
    const RotaryPosition standing = rotary_of(machine_, state.end);
    const RotaryPosition begin =
        by_vector ? *by_vector : solution_of(*in->kinematics, *solutions, 0, standing).rotary_rad;
    return add_track(stage, Entry::free, false, begin, before);
}

/// Continues the choices so far through a stage of law vector.
Result<void> StandChoice::choose(Stage& stage, const std::vector<State>& before, bool from_literal) {
    const bool free = stage.first == 0 || is_rapid(stage.first);
    bool rests = false;
    for (std::size_t s = 0; s < before.size(); ++s) {
        const auto pose = pose_before(stage.first, before[s]);
        if (!pose) return fail(pose.error());
        std::optional<RotaryPosition> by_vector;
        if (stage.first > 0 && is_rapid(stage.first)) by_vector = turned_by_vector(stage, before[s], *pose);
        std::vector<std::size_t> usable;
        if (free) {
            if (s == 0)
                if (auto added = add_free_tracks(stage, *pose); !added) return added;
            rests = rests || stage.tracks.empty();
            if (rests) {
                const auto track = add_resting_track(stage, before[s], *pose, by_vector);
                if (!track) return fail(track.error());
                usable = {*track};
            } else {
                for (std::size_t t = 0; t < stage.tracks.size(); ++t) usable.push_back(t);
            }
        } else {
            const auto in = surroundings_.of(program_.moves[stage.first]);
            const bool pole =
                stage.goes_on ? false : !from_literal || in->kinematics->rotary_for(pose->axis).degenerate;
            auto tracks = tracks_from(stage, before[s], pole ? Entry::pole : Entry::fixed, *pose);
            if (!tracks) return fail(tracks.error());
            usable = *tracks;
        }
        for (const std::size_t track : usable)
            if (auto added = add_states(stage, track, s, before[s], *pose, by_vector); !added) return added;
    }
    return {};
}

std::vector<RotaryStand> StandChoice::stands() const {
    std::vector<std::size_t> chosen(stages_.size(), 0);  // states are sorted: the first one is the cheapest
    for (std::size_t s = stages_.size() - 1; s > 0; --s) chosen[s - 1] = stages_[s].states[chosen[s]].from;
    std::vector<RotaryStand> out(program_.moves.size());
    RotaryPosition standing = start_;
    for (std::size_t s = 0; s < stages_.size(); ++s) {
        const Stage& stage = stages_[s];
        const State& state = stage.states[chosen[s]];
        for (std::size_t k = stage.first; k <= stage.last; ++k) {
            standing = stage.literal ? after_words(program_.moves[k], standing)
                                     : shifted(stage.tracks[state.track].at_end[k - stage.first], state.turns);
            out[k].rotary_rad = standing;
        }
        out[stage.first].rebranched = state.rebranched;
    }
    return out;
}

/// Chooses through one more stage.
Result<void> StandChoice::add_stage(Stage stage) {
    std::vector<State> start(1);
    start.front().end = axes_of(machine_, {}, start_);
    const std::vector<State>& before = stages_.empty() ? start : stages_.back().states;
    const bool from_literal = stages_.empty() || stages_.back().literal;
    const auto done = stage.literal ? carry_out_literal(stage, before) : choose(stage, before, from_literal);
    if (!done) return done;
    if (stage.states.empty()) {
        auto why = explain(stage, before.front());
        return fail(why ? *why : why.error());
    }
    std::stable_sort(stage.states.begin(), stage.states.end(),
                     [](const State& a, const State& b) { return a.cost_rad < b.cost_rad; });
    if (stage.states.size() > most_states) stage.states.resize(most_states);
    stages_.push_back(std::move(stage));
    return {};
}

Result<std::vector<RotaryStand>> StandChoice::operator()() {
    for (std::size_t first = 0; first < program_.moves.size(); first = stages_.back().last + 1) {
        if (is_literal(first)) {
            if (auto added = add_stage({.literal = true, .first = first, .last = end_of_literal(first)}); !added)
                return fail(added.error());
            continue;
        }
        State start;
        start.end = axes_of(machine_, {}, start_);
        auto stages = vector_stages(first, stages_.empty() ? start : stages_.back().states.front());
        if (!stages) return fail(stages.error());
        for (Stage& stage : *stages)
            if (auto added = add_stage(std::move(stage)); !added) return fail(added.error());
    }
    return stands();
}

}  // namespace trunnion::path::detail
