#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "trunnion/path/rotary_stands.hpp"

#include "detail/pole_candidates.hpp"
#include "detail/vector_way.hpp"

/// The choice behind choose_rotary_stands: dynamic programming over stages.
namespace trunnion::path::detail {

inline constexpr double same_position = 1e-6;  // rad
inline constexpr double linear_slack_mm = 1e-6, rotary_slack_rad = 1e-9;
inline constexpr int axes = machine::max_rotary_axes;

inline double way_of(const machine::RotaryPosition& a, const machine::RotaryPosition& b) {
    return std::abs(a[0] - b[0]) + std::abs(a[1] - b[1]);
}

inline machine::RotaryPosition shifted(machine::RotaryPosition position, const std::array<double, axes>& turns) {
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
    bool through_pole = false;  ///< by the shift of the stage's candidate
    machine::RotaryPosition begin{};
    std::vector<machine::RotaryPosition> at_end;  ///< of every move
    machine::RotaryPosition low{}, high{};        ///< extent
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
    machine::AxisPosition end;
};

/// Moves that are chosen as one: literal ones, or moves of law vector between two places of choice. Where moves come
/// near the pole they are a stage of their own: around it or through it.
struct Stage {
    bool literal = false;
    bool goes_on = false;  ///< the axes begin as they stand, off the pole
    std::optional<PoleCandidate> candidate;
    std::size_t first = 0, last = 0;
    std::vector<Track> tracks;
    std::vector<State> states;
};

/// Where a way leaves the ranges.
struct Excess {
    std::size_t move = std::numeric_limits<std::size_t>::max();
    int axis = 0;
    double value = 0;
    machine::RotaryPosition before{};  ///< where the axes stand at the end of the move before
    bool found() const { return move != std::numeric_limits<std::size_t>::max(); }
};

class StandChoice {
  public:
    StandChoice(const program::Program& program, const machine::Machine& machine, Surroundings surroundings,
                double pole_tolerance_rad, const std::optional<machine::RotaryPosition>& standing)
        : program_(program),
          machine_(machine),
          surroundings_(std::move(surroundings)),
          pole_tolerance_rad_(pole_tolerance_rad),
          start_(standing.value_or(surroundings_.start())),
          begins_as_it_stands_(standing.has_value()),
          way_(program, surroundings_) {}
    StandChoice(const StandChoice&) = delete;

    Result<std::vector<program::RotaryStand>> operator()();

  private:
    /// Moves that leave no choice.
    bool is_literal(std::size_t move) const {
        return (move == 0 && begins_as_it_stands_) || program_.moves[move].law == OrientationLaw::rotary ||
               program_.moves[move].space != Space::workpiece;
    }
    bool is_rapid(std::size_t move) const { return program_.moves[move].kind == program::MoveKind::rapid; }
    Result<bool> at_pole(std::size_t move) const;

    std::size_t end_of_literal(std::size_t first) const;
    Result<std::size_t> end_of_vectors(std::size_t first) const;
    Result<void> add_stage(Stage stage);
    Result<std::vector<Stage>> vector_stages(std::size_t first, const State& before);
    Result<std::vector<PoleCandidate>> candidates(std::size_t first, std::size_t last, const State& before);
    Result<void> carry_out_literal(Stage& stage, const std::vector<State>& before);
    machine::RotaryPosition after_words(const program::Move& move, machine::RotaryPosition standing) const;
    Result<void> choose(Stage& stage, const std::vector<State>& before, bool from_literal);

    Result<ToolPose> pose_before(std::size_t move, const State& state);
    Result<void> add_free_tracks(Stage& stage, const ToolPose& before);
    Result<std::vector<std::size_t>> tracks_from(Stage& stage, const State& state, Entry entry, const ToolPose& before);
    Result<std::size_t> add_track(Stage& stage, Entry entry, bool before_first, const machine::RotaryPosition& begin,
                                  const ToolPose& before);
    Result<std::size_t> add_track(Stage& stage, Track track, const ToolPose& before);
    Result<void> add_ways_past_pole(Stage& stage, const machine::RotaryPosition& standing, const ToolPose& before);
    Result<void> leave_by_first_tilted(Stage& stage, Entry entry, const ToolPose& before, std::size_t tilted);
    Result<std::optional<std::size_t>> first_off_pole(const Stage& stage) const;

    Result<void> add_states(Stage& stage, std::size_t track, std::size_t from, const State& before,
                            const ToolPose& pose_before, const std::optional<machine::RotaryPosition>& by_vector);
    std::optional<machine::RotaryPosition> turned_by_vector(const Stage& stage, const State& state,
                                                            const ToolPose& before);
    bool turning_stays_inside(const machine::Kinematics& kinematics, const ToolPose& from,
                              const Eigen::Vector3d& to_tip_mm, const machine::RotaryPosition& begin,
                              const machine::RotaryPosition& end) const;
    std::vector<double> turns_of(const Track& track, int axis, bool free, double standing_rad) const;
    Result<std::size_t> add_resting_track(Stage& stage, const State& state, const ToolPose& before,
                                          const std::optional<machine::RotaryPosition>& by_vector);

    template <class OnPlace>
    Result<void> walk(const Stage& stage, const Track& track, const ToolPose& before, OnPlace&& on_place,
                      std::vector<machine::RotaryPosition>* at_end = nullptr);
    template <class OnPlace>
    Result<void> walk_through_pole(const Stage& stage, const Track& track, const ToolPose& before, OnPlace&& on_place,
                                   std::vector<machine::RotaryPosition>* at_end);
    std::optional<int> outside(const machine::AxisPosition& q) const;
    bool linear_outside(const machine::Kinematics& kinematics, const Eigen::Vector3d& tip_mm,
                        const machine::RotaryPosition& at) const;
    machine::AxisPosition position(const machine::Kinematics& kinematics, const Eigen::Vector3d& tip_mm,
                                   const machine::RotaryPosition& at) const {
        return axes_of(machine_, kinematics.linear_for(tip_mm, at), at);
    }

    Result<Excess> first_excess(const Stage& stage, const Track& track, const std::array<double, axes>& turns,
                                const ToolPose& before);
    Result<Diagnostic> explain(Stage& stage, const State& before);
    Result<std::string> remedy(const Stage& stage, const Excess& excess, const ToolPose& before);
    std::vector<std::array<double, axes>> turns_to_try(const machine::RotaryPosition& begin,
                                                       const machine::RotaryPosition& standing, bool only_inside) const;

    std::vector<program::RotaryStand> stands() const;

    const program::Program& program_;
    const machine::Machine& machine_;
    Surroundings surroundings_;
    double pole_tolerance_rad_;
    machine::RotaryPosition start_;  // of the rotary axes before the program
    bool begins_as_it_stands_;
    VectorWay way_;
    std::vector<Stage> stages_;
};

/// Goes along all moves of a stage. `on_place(move, rotary, tip, kinematics)`.
template <class OnPlace>
Result<void> StandChoice::walk(const Stage& stage, const Track& track, const ToolPose& before, OnPlace&& on_place,
                               std::vector<machine::RotaryPosition>* at_end) {
    if (track.through_pole) return walk_through_pole(stage, track, before, on_place, at_end);
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
    AlongWay along{*solution_after(*in->kinematics, solutions, {track.begin}, 0)};
    along.last_branch = along.at.branch;
    on_place(stage.first, along.at.rotary_rad, pose.tip_mm, *in->kinematics);
    for (; move <= stage.last; ++move) {
        auto to = way_.end_of(move, pose.tip_mm);
        if (!to) return fail(to.error());
        machine::RotaryPosition at_begin = along.at.rotary_rad;
        const auto gone = way_.go(move, pose, *to, along, at_begin,
                                  [&](const machine::RotaryPosition& at, const Eigen::Vector3d& tip,
                                      const machine::Kinematics& k) { on_place(move, at, tip, k); });
        if (!gone) return gone;
        if (at_end && !at_end->empty()) at_end->back() = at_begin;
        if (at_end) at_end->push_back(along.at.rotary_rad);
        pose = *to;
    }
    return {};
}

/// Follows the shifted vectors: on the branch on which the axes come up to the passage, from there on the other one.
/// Where the axes stand at a pose is on the programmed vector, on that branch. Error PATH0103: the other branch cannot
/// be reached.
template <class OnPlace>
Result<void> StandChoice::walk_through_pole(const Stage& stage, const Track& track, const ToolPose& before,
                                            OnPlace&& on_place, std::vector<machine::RotaryPosition>* at_end) {
    constexpr double look_every_rad = 2 * degree;
    const PoleCandidate& candidate = *stage.candidate;
    const auto in = surroundings_.of(program_.moves[stage.first]);
    if (!in) return fail(in.error());
    const machine::Kinematics& kinematics = *in->kinematics;
    const auto at_begin = kinematics.rotary_for(before.axis);
    if (at_begin.count < 2) return fail(way_.too_close_to_pole(stage.first));
    Followed at = *solution_after(kinematics, at_begin, {track.begin}, 0);
    ToolPose from = before;
    double begin_mm = candidate.begin_mm;
    on_place(stage.first, at.rotary_rad, from.tip_mm, kinematics);
    for (std::size_t move = stage.first; move <= stage.last; ++move) {
        const auto to = way_.end_of(move, from.tip_mm);
        if (!to) return fail(to.error());
        const auto poses = way_.between(move, from, *to);
        if (!poses) return fail(poses.error());
        const double length_mm = candidate.length_mm[move - stage.first];
        const double parts = std::max(1.0, std::ceil(poses->turn_rad() / look_every_rad));
        bool passed = move > candidate.move;
        for (double part = 1; part <= parts; ++part) {
            const double w = part / parts, p = begin_mm + w * length_mm;
            if (!passed && move == candidate.move && w >= candidate.share) {
                passed = true;
                at.branch = 1 - at.branch;
            }
            const ToolPose pose = poses->at(w);
            const Eigen::Vector3d axis = (pose.axis + candidate.shift_at(p)).normalized();
            const auto solutions = kinematics.rotary_for(axis);
            if (solutions.count == 2)
                at = solution_of(kinematics, solutions, at.branch, at.rotary_rad);
            else if (!solutions.degenerate)
                return fail(way_.too_close_to_pole(move));
            on_place(move, at.rotary_rad, pose.tip_mm, kinematics);
        }
        const auto programmed = kinematics.rotary_for(to->axis);
        if (programmed.count == 0) return fail(way_.out_of_reach(move));
        const int branch = programmed.count == 2 ? at.branch : 0;
        if (at_end) at_end->push_back(solution_of(kinematics, programmed, branch, at.rotary_rad).rotary_rad);
        begin_mm += length_mm;
        from = *to;
    }
    return {};
}

}  // namespace trunnion::path::detail
