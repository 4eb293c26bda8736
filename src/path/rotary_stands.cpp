#include "trunnion/path/rotary_stands.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <string_view>

#include <fmt/format.h>

#include "detail/vector_way.hpp"

namespace trunnion::path {

using detail::AlongWay;
using detail::full_turn;
using detail::ToolPose;
using machine::AxisPosition;
using machine::Kinematics;
using machine::RotaryPosition;
using program::Move;
using program::MoveKind;
using program::RotaryStand;

namespace {

constexpr double same_position = 1e-6;  // rad
constexpr double linear_slack_mm = 1e-6, rotary_slack_rad = 1e-9;
constexpr std::size_t most_states = 12;        // kept of one stage, the cheapest
constexpr double look_every_rad = 5 * degree;  // of a rapid that turns the axes themselves
constexpr int axes = machine::max_rotary_axes;

double way_of(const RotaryPosition& a, const RotaryPosition& b) {
    return std::abs(a[0] - b[0]) + std::abs(a[1] - b[1]);
}

RotaryPosition shifted(RotaryPosition position, const std::array<double, axes>& turns) {
    for (int a = 0; a < axes; ++a) position[a] += turns[a] * full_turn;
    return position;
}

/// How the axes come onto a track.
enum class Entry : std::uint8_t {
    free,  ///< any branch and winding: at the beginning and on rapids
    pole,  ///< any position of the free axis, the other one stays
    fixed  ///< as they stand
};

/// One way of the rotary axes through the moves of a stage, without whole turns added.
struct Track {
    Entry entry = Entry::free;
    bool before_first = false;  ///< `begin` is where the first move begins, not where it ends
    RotaryPosition begin{};
    std::vector<RotaryPosition> at_end;  ///< of every move
    RotaryPosition low{}, high{};        ///< extent
    Eigen::Vector3d last_tip_mm = Eigen::Vector3d::Zero();
    bool linear_inside = true;
    double travel_rad = 0;
};

/// A choice for the stages so far: where it ends and what it cost.
struct State {
    double cost_rad = 0;
    std::size_t from = 0;  ///< state of the stage before
    std::size_t track = 0;
    std::array<double, axes> turns{};  ///< whole turns added to the track
    bool rebranched = false;           ///< on the first move
    AxisPosition end;
};

/// Moves that are chosen as one: literal ones, or moves of law vector between two places of choice.
struct Stage {
    bool literal = false;
    std::size_t first = 0, last = 0;
    std::vector<Track> tracks;
    std::vector<State> states;
};

/// Where a way leaves the ranges.
struct Excess {
    std::size_t move = std::numeric_limits<std::size_t>::max();
    int axis = 0;
    double value = 0;
    RotaryPosition before{};  ///< where the axes stand at the end of the move before
    bool found() const { return move != std::numeric_limits<std::size_t>::max(); }
};

class StandChoice {
  public:
    StandChoice(const program::Program& program, const machine::Machine& machine, detail::Surroundings surroundings)
        : program_(program),
          machine_(machine),
          surroundings_(std::move(surroundings)),
          way_(program, surroundings_) {}
    StandChoice(const StandChoice&) = delete;

    Result<std::vector<RotaryStand>> operator()();

  private:
    bool is_literal(std::size_t move) const {
        return program_.moves[move].law == OrientationLaw::rotary || program_.moves[move].space != Space::workpiece;
    }
    bool is_rapid(std::size_t move) const { return program_.moves[move].kind == MoveKind::rapid; }
    Result<bool> at_pole(std::size_t move) const;

    std::size_t end_of_literal(std::size_t first) const;
    Result<std::size_t> end_of_vectors(std::size_t first) const;
    Result<void> carry_out_literal(Stage& stage, const std::vector<State>& before);
    RotaryPosition after_words(const Move& move, RotaryPosition standing) const;
    Result<void> choose(Stage& stage, const std::vector<State>& before, bool from_literal);

    Result<ToolPose> pose_before(const Stage& stage, const State& state);
    Result<void> add_free_tracks(Stage& stage, const ToolPose& before);
    Result<std::vector<std::size_t>> tracks_from(Stage& stage, const State& state, Entry entry, const ToolPose& before);
    Result<std::size_t> add_track(Stage& stage, Entry entry, bool before_first, const RotaryPosition& begin,
                                  const ToolPose& before);
    Result<void> leave_by_first_tilted(Stage& stage, Entry entry, const ToolPose& before, std::size_t tilted);
    Result<std::optional<std::size_t>> first_off_pole(const Stage& stage) const;

    Result<void> add_states(Stage& stage, std::size_t track, std::size_t from, const State& before,
                            const ToolPose& pose_before, const std::optional<RotaryPosition>& by_vector);
    std::optional<RotaryPosition> turned_by_vector(const Stage& stage, const State& state, const ToolPose& before);
    bool turning_stays_inside(const Kinematics& kinematics, const ToolPose& from, const Eigen::Vector3d& to_tip_mm,
                              const RotaryPosition& begin, const RotaryPosition& end) const;
    std::vector<double> turns_of(const Track& track, int axis, bool free, double standing_rad) const;
    Result<std::size_t> add_resting_track(Stage& stage, const State& state, const ToolPose& before,
                                          const std::optional<RotaryPosition>& by_vector);

    template <class OnPlace>
    Result<void> walk(const Stage& stage, const Track& track, const ToolPose& before, OnPlace&& on_place,
                      std::vector<RotaryPosition>* at_end = nullptr);
    std::optional<int> outside(const AxisPosition& q) const;
    bool linear_outside(const Kinematics& kinematics, const Eigen::Vector3d& tip_mm, const RotaryPosition& at) const;
    AxisPosition position(const Kinematics& kinematics, const Eigen::Vector3d& tip_mm, const RotaryPosition& at) const {
        return detail::axes_of(machine_, kinematics.linear_for(tip_mm, at), at);
    }

    Result<Excess> first_excess(const Stage& stage, const Track& track, const std::array<double, axes>& turns,
                                const ToolPose& before);
    Result<Diagnostic> explain(Stage& stage, const State& before);
    Result<std::string> remedy(const Stage& stage, const Excess& excess, const ToolPose& before);
    std::vector<std::array<double, axes>> turns_to_try(const RotaryPosition& begin, const RotaryPosition& standing,
                                                       bool only_inside) const;

    std::vector<RotaryStand> stands() const;

    const program::Program& program_;
    const machine::Machine& machine_;
    detail::Surroundings surroundings_;
    detail::VectorWay way_;
    std::vector<Stage> stages_;
};

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
        if (detail::stop_between(program_, next) != StopCause::corner) return k;
        const auto stays = at_pole(next);
        if (!stays) return fail(stays.error());
        if (*stays) return k;
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
            const RotaryPosition standing = detail::rotary_of(machine_, state.end);
            const RotaryPosition to = after_words(move, standing);
            state.cost_rad += way_of(standing, to);
            const Eigen::Vector3d at = detail::whole_position(move, *in, machine_, state.end);
            if (move.space == Space::workpiece)
                state.end = position(*in->kinematics, detail::out_of_offset(*in->offset, at), to);
            else
                state.end = detail::axes_of(machine_,
                                            move.space == Space::machine ? std::array<double, 3>{at.x(), at.y(), at.z()}
                                                                         : detail::linear_of_untransformed(*in, at),
                                            to);
        }
        const auto same = std::find_if(stage.states.begin(), stage.states.end(), [&](const State& other) {
            return way_of(detail::rotary_of(machine_, other.end), detail::rotary_of(machine_, state.end)) <
                   same_position;
        });
        if (same == stage.states.end())
            stage.states.push_back(state);
        else if (state.cost_rad < same->cost_rad)
            *same = state;
    }
    return {};
}

/// The tool where the first move of a stage begins.
Result<ToolPose> StandChoice::pose_before(const Stage& stage, const State& state) {
    const auto in = surroundings_.of(program_.moves[stage.first]);
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

/// Goes along all moves of a stage. `on_place(move, rotary, tip, kinematics)`.
template <class OnPlace>
Result<void> StandChoice::walk(const Stage& stage, const Track& track, const ToolPose& before, OnPlace&& on_place,
                               std::vector<RotaryPosition>* at_end) {
    const auto in = surroundings_.of(program_.moves[stage.first]);
    if (!in) return fail(in.error());
    ToolPose pose = before;
    std::size_t move = stage.first;
    if (!track.before_first) {
        auto first = way_.end_of(move, before.tip_mm);
        if (!first) return fail(first.error());
        pose = *first;
        if (at_end) at_end->push_back(track.begin);
        ++move;
    }
    const auto solutions = in->kinematics->rotary_for(pose.axis);
    if (solutions.count == 0) return fail(way_.out_of_reach(stage.first));
    AlongWay along{*detail::solution_after(*in->kinematics, solutions, {track.begin}, 0)};
    along.last_branch = along.at.branch;
    on_place(stage.first, along.at.rotary_rad, pose.tip_mm, *in->kinematics);
    for (; move <= stage.last; ++move) {
        auto to = way_.end_of(move, pose.tip_mm);
        if (!to) return fail(to.error());
        RotaryPosition at_begin = along.at.rotary_rad;
        const auto gone = way_.go(move, pose, *to, along, at_begin,
                                  [&](const RotaryPosition& at, const Eigen::Vector3d& tip, const Kinematics& k) {
                                      on_place(move, at, tip, k);
                                  });
        if (!gone) return gone;
        if (at_end && !at_end->empty()) at_end->back() = at_begin;
        if (at_end) at_end->push_back(along.at.rotary_rad);
        pose = *to;
    }
    return {};
}

Result<std::size_t> StandChoice::add_track(Stage& stage, Entry entry, bool before_first, const RotaryPosition& begin,
                                           const ToolPose& before) {
    Track track{.entry = entry, .before_first = before_first, .begin = begin, .low = begin, .high = begin};
    track.at_end.reserve(stage.last - stage.first + 1);
    RotaryPosition last = begin;
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
        const RotaryPosition begin = detail::solution_of(*in->kinematics, *solutions, branch, {}).rotary_rad;
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
    const RotaryPosition standing = detail::rotary_of(machine_, state.end);
    for (std::size_t t = 0; t < stage.tracks.size(); ++t) {
        const RotaryPosition& begin = stage.tracks[t].begin;
        bool same = stage.tracks[t].entry == Entry::fixed;
        for (int a = 0; a < axes; ++a)
            same = same && std::abs(std::remainder(begin[a] - standing[a], full_turn)) < same_position;
        if (same) return std::vector{t};
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
    const RotaryPosition standing = detail::rotary_of(machine_, state.end);
    const auto in = surroundings_.of(program_.moves[stage.first]);
    const auto to = way_.end_of(stage.first, before.tip_mm);
    if (!in || !to) return std::nullopt;
    AlongWay along{*detail::solution_after(*in->kinematics, in->kinematics->rotary_for(before.axis), {standing}, 0)};
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
    const RotaryPosition standing = detail::rotary_of(machine_, before.end);
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
    const RotaryPosition standing = detail::rotary_of(machine_, state.end);
    const RotaryPosition begin =
        by_vector ? *by_vector : detail::solution_of(*in->kinematics, *solutions, 0, standing).rotary_rad;
    return add_track(stage, Entry::free, false, begin, before);
}

/// Continues the choices so far through a stage of law vector.
Result<void> StandChoice::choose(Stage& stage, const std::vector<State>& before, bool from_literal) {
    const bool free = stage.first == 0 || is_rapid(stage.first);
    bool rests = false;
    for (std::size_t s = 0; s < before.size(); ++s) {
        const auto pose = pose_before(stage, before[s]);
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
            const bool pole = !from_literal || in->kinematics->rotary_for(pose->axis).degenerate;
            auto tracks = tracks_from(stage, before[s], pole ? Entry::pole : Entry::fixed, *pose);
            if (!tracks) return fail(tracks.error());
            usable = *tracks;
        }
        for (const std::size_t track : usable)
            if (auto added = add_states(stage, track, s, before[s], *pose, by_vector); !added) return added;
    }
    return {};
}

Result<Excess> StandChoice::first_excess(const Stage& stage, const Track& track, const std::array<double, axes>& turns,
                                         const ToolPose& before) {
    Excess out;
    RotaryPosition at_end_before = shifted(track.begin, turns), last = at_end_before;
    std::size_t at_move = stage.first;
    const auto look = [&](std::size_t move, const RotaryPosition& at, const Eigen::Vector3d& tip, const Kinematics& k) {
        if (out.found()) return;
        if (move != at_move) at_end_before = last;
        at_move = move;
        last = shifted(at, turns);
        const AxisPosition q = position(k, tip, last);
        if (const auto axis = outside(q)) out = {move, *axis, q[static_cast<std::size_t>(*axis)], at_end_before};
    };
    if (auto walked = walk(stage, track, before, look); !walked) return fail(walked.error());
    return out;
}

/// Whole turns to look at from a place on: near where the axes stand, and where it can be so that they are inside.
std::vector<std::array<double, axes>> StandChoice::turns_to_try(const RotaryPosition& begin,
                                                                const RotaryPosition& standing,
                                                                bool only_inside) const {
    constexpr double most = 2;
    std::array<std::vector<double>, axes> each;
    for (int a = 0; a < axes; ++a) {
        const double nearest = std::round((standing[a] - begin[a]) / full_turn);
        if (a < machine_.rotary_count) {
            const machine::Axis& range = machine_.axes[machine_.linear_count() + a];
            for (double k = nearest - most; k <= nearest + most; ++k) {
                const double at = begin[a] + k * full_turn;
                if (at >= range.range_min - rotary_slack_rad && at <= range.range_max + rotary_slack_rad)
                    each[a].push_back(k);
            }
        }
        if (each[a].empty() && (!only_inside || a >= machine_.rotary_count)) each[a] = {nearest};
    }
    std::vector<std::array<double, axes>> out;
    for (const double k0 : each[0])
        for (const double k1 : each[1]) out.push_back({k0, k1});
    return out;
}

/// Why no choice is left: the way that lasts longest, and what would help there.
Result<Diagnostic> StandChoice::explain(Stage& stage, const State& before) {
    const auto pose = pose_before(stage, before);
    if (!pose) return fail(pose.error());
    const RotaryPosition standing = detail::rotary_of(machine_, before.end);
    Excess longest;
    bool any = false;
    for (const Track& track : stage.tracks)
        for (const auto& turns : turns_to_try(track.begin, standing, false)) {
            if (track.entry == Entry::fixed && way_of(shifted(track.begin, turns), standing) > same_position) continue;
            const auto excess = first_excess(stage, track, turns, *pose);
            if (!excess) return fail(excess.error());
            if (excess->found() && (!any || excess->move > longest.move)) longest = *excess;
            any = any || excess->found();
        }
    if (!any) {
        auto out =
            detail::at_move(program_, program_.moves[stage.first], "PATH0102",
                            "an axis leaves its range while the rotary axes turn to where the next moves need them");
        out.hint = "retract farther before, or turn the part on the table";
        return out;
    }
    const machine::Axis& axis = machine_.axes[longest.axis];
    const double unit = axis.rotary ? degree : 1.0;
    const char* name = axis.rotary ? "deg" : "mm";
    auto out = detail::at_move(
        program_, program_.moves[longest.move], "PATH0102",
        fmt::format("axis {} leaves its range, whatever branch and winding the rotary axes take", axis.letter));
    out.value = fmt::format("{} = {:.4f} {}", axis.letter, longest.value / unit, name);
    out.limit = fmt::format("{:.4f} … {:.4f} {}", axis.range_min / unit, axis.range_max / unit, name);
    auto hint = remedy(stage, longest, *pose);
    if (!hint) return fail(hint.error());
    out.hint = std::move(*hint);
    return out;
}

/// The retract and turn after which the axes stay inside longest. Every way that lasts beyond the excess is also there
/// at the end of the move before it, so that is the last place to retract.
Result<std::string> StandChoice::remedy(const Stage& stage, const Excess& excess, const ToolPose& before) {
    constexpr std::string_view nothing =
        "no retract and turn of the rotary axes would do; check the setup's origin and tool length, or turn the part "
        "on the table";
    if (excess.move == stage.first) return std::string(nothing);
    ToolPose pose = before;
    for (std::size_t k = stage.first; k < excess.move; ++k) {
        const auto next = way_.end_of(k, pose.tip_mm);
        if (!next) return fail(next.error());
        pose = *next;
    }
    const Stage rest{.first = excess.move, .last = stage.last};
    const auto in = surroundings_.of(program_.moves[rest.first]);
    if (!in) return fail(in.error());
    const auto solutions = in->kinematics->rotary_for(pose.axis);
    Excess longest{.move = excess.move};
    RotaryPosition best{};
    for (int branch = 0; branch < solutions.count; ++branch) {
        const RotaryPosition near = detail::solution_of(*in->kinematics, solutions, branch, excess.before).rotary_rad;
        for (const auto& turns : turns_to_try(near, excess.before, true)) {
            const RotaryPosition begin = shifted(near, turns);
            const Track track{.entry = Entry::fixed, .before_first = true, .begin = begin};
            const auto end = first_excess(rest, track, {}, pose);
            if (!end) return fail(end.error());
            const bool nearer = end->move == longest.move && end->move != excess.move &&
                                way_of(begin, excess.before) < way_of(best, excess.before);
            if (end->move > longest.move || nearer) longest = *end, best = begin;
        }
    }
    if (longest.move == excess.move) return std::string(nothing);
    std::string standing, turning;
    for (int a = 0; a < machine_.rotary_count; ++a) {
        const double from = excess.before[a], by = best[a] - from;
        if (std::abs(by) < same_position) continue;
        const char letter = machine_.axes[machine_.linear_count() + a].letter;
        const char* joint = standing.empty() ? "" : ", ";
        standing += fmt::format("{}{} at {:.4g} deg", joint, letter, from / degree);
        turning += fmt::format("{}turn {} by {:.4g} deg to {:.4g} deg", joint, letter, by / degree, best[a] / degree);
    }
    const std::size_t last = longest.found() ? longest.move - 1 : stage.last;
    return fmt::format("retract before line {} ({}), {}, and go on: then the axes stay in range up to line {}",
                       program_.moves[excess.move].line, standing, turning, program_.moves[last].line);
}

std::vector<RotaryStand> StandChoice::stands() const {
    std::vector<std::size_t> chosen(stages_.size(), 0);  // states are sorted: the first one is the cheapest
    for (std::size_t s = stages_.size() - 1; s > 0; --s) chosen[s - 1] = stages_[s].states[chosen[s]].from;
    std::vector<RotaryStand> out(program_.moves.size());
    RotaryPosition standing = surroundings_.start();
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

Result<std::vector<RotaryStand>> StandChoice::operator()() {
    std::vector<State> start(1);
    start.front().end = detail::axes_of(machine_, {}, surroundings_.start());
    for (std::size_t first = 0; first < program_.moves.size(); first = stages_.back().last + 1) {
        Stage stage{.literal = is_literal(first), .first = first};
        const auto last = stage.literal ? Result<std::size_t>(end_of_literal(first)) : end_of_vectors(first);
        if (!last) return fail(last.error());
        stage.last = *last;
        const std::vector<State>& before = stages_.empty() ? start : stages_.back().states;
        const bool from_literal = stages_.empty() || stages_.back().literal;
        const auto done = stage.literal ? carry_out_literal(stage, before) : choose(stage, before, from_literal);
        if (!done) return fail(done.error());
        if (stage.states.empty()) {
            auto why = explain(stage, before.front());
            return fail(why ? *why : why.error());
        }
        std::stable_sort(stage.states.begin(), stage.states.end(),
                         [](const State& a, const State& b) { return a.cost_rad < b.cost_rad; });
        if (stage.states.size() > most_states) stage.states.resize(most_states);
        stages_.push_back(std::move(stage));
    }
    return stands();
}

}  // namespace

Result<std::vector<RotaryStand>> choose_rotary_stands(const program::Program& program, const machine::Machine& machine,
                                                      const machine::Setup& setup) {
    auto surroundings = detail::Surroundings::make(program, machine, setup);
    if (!surroundings) return fail(surroundings.error());
    return StandChoice(program, machine, std::move(*surroundings))();
}

}  // namespace trunnion::path
