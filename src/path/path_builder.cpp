#include "trunnion/path/path_builder.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <fmt/format.h>

#include "trunnion/base/quantity.hpp"
#include "trunnion/geometry/great_circle.hpp"
#include "trunnion/path/curve_way.hpp"

#include "detail/branch_following.hpp"
#include "detail/surroundings.hpp"

namespace trunnion::path {

using detail::Surrounding;
using detail::Surroundings;
using machine::AxisPosition;
using machine::RotaryPosition;
using program::Arc;
using program::Move;
using program::MoveKind;
using program::Program;

namespace {

constexpr double shortest_block_mm = 1e-7;
constexpr double least_radius_mm = 1e-9;
constexpr double right_angle_slack = 1e-9;

std::array<double, 3> to_array(const Eigen::Vector3d& v) {
    return {v.x(), v.y(), v.z()};
}
Eigen::Vector3d to_vector(const std::array<double, 3>& v) {
    return {v[0], v[1], v[2]};
}

/// Machine axes count for two spaces of a program.
Space space_of_run(Space space) {
    return space == Space::workpiece ? Space::workpiece : Space::machine;
}

/// Where the blocks from one vertex to another come nearest to a pole.
PolePassage passage_between(const Run& run, std::size_t from, std::size_t to) {
    PolePassage out;
    double least = 2;
    for (const Eigen::Vector3d& pole : poles_of(*run.kinematics))
        for (std::size_t k = from; k < to; ++k) {
            const auto nearest = nearest_to_pole(to_vector(run.vertices[k].orientation),
                                                 to_vector(run.vertices[k + 1].orientation), pole);
            if (nearest.distance() >= least) continue;
            least = nearest.distance();
            out = {k, nearest.share, pole};
        }
    return out;
}

}  // namespace

PathBuilder::PathBuilder(PathBuilder&&) noexcept = default;
PathBuilder& PathBuilder::operator=(PathBuilder&&) noexcept = default;
PathBuilder::~PathBuilder() = default;

PathBuilder::PathBuilder(const Program& program, const machine::Machine& machine,
                         std::span<const program::RotaryStand> stands, Surroundings surroundings)
    : program_(&program),
      machine_(&machine),
      stands_(stands),
      surroundings_(std::make_unique<Surroundings>(std::move(surroundings))) {}

Result<PathBuilder> PathBuilder::make(const Program& program, const machine::Machine& machine,
                                      const machine::Setup& setup, std::span<const program::RotaryStand> stands) {
    auto surroundings = Surroundings::make(program, machine, setup);
    if (!surroundings) return fail(surroundings.error());
    PathBuilder builder(program, machine, stands, std::move(*surroundings));
    if (auto begun = builder.begin(); !begun) return fail(begun.error());
    return builder;
}

const std::vector<Diagnostic>& PathBuilder::diagnostics() const {
    return surroundings_->diagnostics();
}

Result<void> PathBuilder::begin() {
    const Move& first = program_->moves.front();
    auto in = surroundings_->of(first);
    if (!in) return fail(in.error());
    space_ = space_of_run(first.space);
    law_ = law_of(0);
    tool_ = in->tool;
    kinematics_ = in->kinematics;
    auto at = coordinates_of(0, *in);
    if (!at) return fail(at.error());
    at_ = *at;
    move_ = 1;
    return {};
}

/// How a move turns the rotary axes: by themselves wherever it is not the tool's direction that leads.
OrientationLaw PathBuilder::law_of(std::size_t move) const {
    const Move& m = program_->moves[move];
    const bool by_axes = m.law == OrientationLaw::rotary || m.space != Space::workpiece || stands_[move].rebranched;
    return by_axes ? OrientationLaw::rotary : OrientationLaw::vector;
}

Eigen::Vector3d PathBuilder::tool_axis() const {
    if (law_ == OrientationLaw::vector) return to_vector(at_.orientation);
    return kinematics_->tool_axis(RotaryPosition{at_.orientation[0], at_.orientation[1]});
}

/// Where the machine stands at the end of the last move taken.
AxisPosition PathBuilder::here() const {
    const RotaryPosition& rotary = stands_[move_ - 1].rotary_rad;
    const bool in_workpiece = space_ == Space::workpiece;
    return detail::axes_of(*machine_,
                           in_workpiece ? kinematics_->linear_for(to_vector(at_.position_mm), rotary) : at_.position_mm,
                           rotary);
}

/// End of a move in the coordinates of its run, in the workpiece frame.
Result<PathCoordinates> PathBuilder::coordinates_of(std::size_t move, const Surrounding& in) const {
    const Move& to = program_->moves[move];
    const Eigen::Vector3d position =
        to.position_mm.hasNaN() ? detail::whole_position(to, in, *machine_, here()) : to.position_mm;
    PathCoordinates out;
    if (to.space == Space::workpiece)
        out.position_mm = to_array(detail::out_of_offset(*in.offset, position));
    else
        out.position_mm =
            to.space == Space::machine ? to_array(position) : detail::linear_of_untransformed(in, position);
    if (law_of(move) == OrientationLaw::vector) {
        out.orientation = to_array(in.offset->rotation * to.axis);
    } else {
        const RotaryPosition& rotary = stands_[move].rotary_rad;
        out.orientation = {rotary[0], rotary[1], 0};
    }
    return out;
}

/// Untransformed coordinates become machine axes by an affine map.
PathBuilder::Placement PathBuilder::placement_of(const Move& move, const Surrounding& in) const {
    if (move.space == Space::machine) return {};
    if (move.space == Space::workpiece) return {in.offset->rotation, in.offset->origin_mm};
    const auto linear = [&](const Eigen::Vector3d& position) {
        return to_vector(detail::linear_of_untransformed(in, position));
    };
    Placement out{.shift_mm = linear(Eigen::Vector3d::Zero())};
    for (int k = 0; k < 3; ++k) out.map.col(k) = linear(Eigen::Vector3d::Unit(k)) - out.shift_mm;
    return out;
}

/// The arc of a move in the frame of its run's positions. Where the linear axes stand at right angles untransformed
/// coordinates become machine axes by a rigid motion; where that is a reflection (axes counted the other way) the arc
/// turns the other way about the reflected normal.
Result<Arc> PathBuilder::arc_of(const Move& move, const Surrounding& in) const {
    const Arc& arc = program_->arcs[static_cast<std::size_t>(move.arc)];
    const Placement placement = placement_of(move, in);
    const Eigen::Matrix3d& map = placement.map;
    if (move.space == Space::untransformed &&
        (map.transpose() * map - Eigen::Matrix3d::Identity()).norm() > right_angle_slack)
        return fail(detail::at_move(*program_, move, "PATH0008",
                                    "an arc without TCP on a machine whose linear axes are not at right angles"));
    const double sense = map.determinant() < 0 ? -1 : 1;
    return Arc{map * arc.centre_mm + placement.shift_mm, sense * (map * arc.normal), arc.angle_rad};
}

/// Program words as positions of the machine's rotary axes; an axis without a word stays where it stands.
geometry::BezierPiece PathBuilder::machine_axes_of(const geometry::BezierPiece& words,
                                                   const PathCoordinates& from) const {
    Eigen::Matrix3d map = Eigen::Matrix3d::Zero();
    Eigen::Vector3d standing = Eigen::Vector3d::Zero();
    for (int axis = 0; axis < machine_->rotary_count; ++axis) {
        const int word = surroundings_->word_of_axis(axis);
        if (word >= 0)
            map(axis, word) = 1;
        else
            standing[axis] = from.orientation[static_cast<std::size_t>(axis)];
    }
    return words.mapped(map, standing);
}

/// The curve of a move in the coordinates of its run, from where the machine is to `to`.
Result<CurvePiece> PathBuilder::curve_of(std::size_t index, const PathCoordinates& to, const Surrounding& in) const {
    const Move& move = program_->moves[index];
    const Placement placement = placement_of(move, in);
    CurvePiece out = surroundings_->curve_of(move);
    out.position = out.position.mapped(placement.map, placement.shift_mm);
    const bool by_axes = law_of(index) == OrientationLaw::rotary;
    if (by_axes && move.law == OrientationLaw::vector) out.orientation.reset();  // the tool stays, the axes turn
    if (out.orientation)
        out.orientation = by_axes ? machine_axes_of(*out.orientation, at_)
                                  : out.orientation->mapped(in.offset->rotation, Eigen::Vector3d::Zero());
    const auto end_at = [](const PathCoordinates& at) {
        return detail::CurveEnd{to_vector(at.position_mm), to_vector(at.orientation)};
    };
    if (auto fits = detail::fit_ends(out, end_at(at_), end_at(to), !by_axes, *program_, move); !fits)
        return fail(fits.error());
    return out;
}

/// Takes space, law and tool of the next move into use. The machine stands still meanwhile: with a tool of another
/// length the tip is elsewhere.
Result<void> PathBuilder::begin_run(Run& run) {
    const Move& first = program_->moves[move_];
    auto in = surroundings_->of(first);
    if (!in) return fail(in.error());
    const Space space = space_of_run(first.space);
    const OrientationLaw law = law_of(move_);
    const Eigen::Vector3d axis = tool_axis();
    const RotaryPosition& rotary = stands_[move_ - 1].rotary_rad;
    if (space != space_) {
        const AxisPosition standing = here();
        at_.position_mm = space == Space::machine ? std::array<double, 3>{standing[0], standing[1], standing[2]}
                                                  : to_array(in->kinematics->forward(standing).tip_in_workpiece_mm);
    } else if (space == Space::workpiece && in->tool != tool_) {
        at_.position_mm = to_array(to_vector(at_.position_mm) + (tool_->length_mm - in->tool->length_mm) * axis);
    }
    at_.orientation = law == OrientationLaw::vector ? to_array(axis) : std::array<double, 3>{rotary[0], rotary[1], 0};
    space_ = space;
    law_ = law;
    tool_ = in->tool;
    kinematics_ = in->kinematics;
    run.space = space;
    run.law = law;
    run.rapid = first.kind == MoveKind::rapid;
    run.first_move = move_;
    run.kinematics = kinematics_;
    run.controlled_height_mm = tool_->controlled_height_mm();
    run.vertices = {at_};
    if (law == OrientationLaw::vector) run.stands = {rotary};
    return {};
}

/// The block from where the machine is to the end of a move; its arc or curve becomes the run's last one.
Result<Block> PathBuilder::block_to(std::size_t index, const PathCoordinates& to, Run& run) {
    const Move& move = program_->moves[index];
    const auto in = surroundings_->of(move);
    Block block{.feed = move.feed, .line = move.line};
    if (move.curve_part != program::no_curve_part) {
        auto curve = curve_of(index, to, *in);
        if (!curve) return fail(curve.error());
        block.curve = static_cast<std::int32_t>(run.curves.size());
        block.length_mm = CurveWay(run, *curve, at_, to).length_mm(0, 1);
        run.curves.push_back(*curve);
    } else if (move.arc != program::no_arc) {
        auto arc = arc_of(move, *in);
        if (!arc) return fail(arc.error());
        const Eigen::Vector3d arm = to_vector(at_.position_mm) - arc->centre_mm;
        if (!(arm.cross(arc->normal).norm() > least_radius_mm))
            return fail(detail::at_move(*program_, move, "PATH0009", "the arc begins on its own axis"));
        block.arc = static_cast<std::int32_t>(run.arcs.size());
        block.length_mm = block_length_mm(run, at_, to, &*arc);
        run.arcs.push_back(*arc);
    } else {
        block.length_mm = block_length_mm(run, at_, to);
    }
    return block;
}

Result<void> PathBuilder::add_move(Run& run) {
    const Move& move = program_->moves[move_];
    auto in = surroundings_->of(move);
    if (!in) return fail(in.error());
    auto to = coordinates_of(move_, *in);
    if (!to) return fail(to.error());
    const auto block = block_to(move_, *to, run);
    if (!block) return fail(block.error());
    if (!(block->length_mm <= detail::longest_move_mm))
        return fail(detail::at_move(*program_, move, "PATH0010", "the move is longer than 10 km"));
    if (block->length_mm < shortest_block_mm) {
        if (block->arc != program::no_arc) run.arcs.pop_back();
        if (block->curve != no_curve) run.curves.pop_back();
        return {};
    }
    run.vertices.push_back(*to);
    run.blocks.push_back(*block);
    if (run.law == OrientationLaw::vector) run.stands.push_back(stands_[move_].rotary_rad);
    at_ = *to;
    return {};
}

/// Where a run begins at the pole the free axis is to stand as the first block off the pole wants it.
void PathBuilder::stand_where_it_leaves_the_pole(Run& run) const {
    const auto solutions = [&](std::size_t vertex) {
        return run.kinematics->rotary_for(to_vector(run.vertices[vertex].orientation));
    };
    if (run.law != OrientationLaw::vector || !solutions(0).degenerate) return;
    std::size_t tilted = 1;
    while (tilted < run.vertices.size() && solutions(tilted).degenerate) ++tilted;
    if (tilted == run.vertices.size()) return;
    const geometry::GreatCircle back(to_vector(run.vertices[tilted].orientation),
                                     to_vector(run.vertices[tilted - 1].orientation));
    constexpr double half_turn_rad = 10 * degree, shortest = 1e-13;
    const auto solutions_at = [&](double w) { return run.kinematics->rotary_for(back.at(w)); };
    const auto pass = [](double, const detail::Followed&) {};
    const auto from = detail::solution_after(*run.kinematics, solutions(tilted), {run.stands[tilted]}, 0);
    if (!from) return;
    const auto at = detail::follow(*run.kinematics, solutions_at, 0, 1, *from, {half_turn_rad, shortest}, pass);
    if (!at) return;
    for (std::size_t k = 0; k < tilted; ++k)
        run.stands[k] = detail::solution_of(*run.kinematics, solutions(k), 0, at->rotary_rad).rotary_rad;
}

/// Where the stands change to the other branch from one pose to the next that is off the pole.
void PathBuilder::find_passages(Run& run) const {
    if (run.law != OrientationLaw::vector || run.rapid || machine_->rotary_count < 2) return;
    int last_branch = detail::unknown_branch;
    std::size_t last = 0;
    for (std::size_t k = 0; k < run.vertices.size(); ++k) {
        const auto solutions = run.kinematics->rotary_for(to_vector(run.vertices[k].orientation));
        if (solutions.count < 2) continue;
        const auto way_to = [&](int branch) {
            const auto there = detail::solution_of(*run.kinematics, solutions, branch, run.stands[k]).rotary_rad;
            return std::abs(there[0] - run.stands[k][0]) + std::abs(there[1] - run.stands[k][1]);
        };
        const int branch = way_to(0) <= way_to(1) ? 0 : 1;
        if (last_branch != detail::unknown_branch && branch != last_branch)
            run.passages.push_back(passage_between(run, last, k));
        last_branch = branch;
        last = k;
    }
}

/// What cuts the path between moves[move − 1] and moves[move]; `corner`: nothing does.
StopCause PathBuilder::stop_before(std::size_t move) const {
    const StopCause cause = detail::stop_between(*program_, move);
    return cause == StopCause::corner && law_of(move) != law_of(move - 1) ? StopCause::law : cause;
}

void PathBuilder::take_events(Run& run) {
    for (; event_ < program_->events.size() && program_->events[event_].before_move <= move_; ++event_)
        run.events.push_back({event_, run.blocks.size()});
}

Result<bool> PathBuilder::next(Run& run) {
    run = {};
    while (move_ < program_->moves.size()) {
        if (auto begun = begin_run(run); !begun) return fail(begun.error());
        do {
            take_events(run);
            if (auto added = add_move(run); !added) return fail(added.error());
            ++move_;
            run.stop = stop_before(move_);
        } while (run.stop == StopCause::corner);
        if (move_ == program_->moves.size()) take_events(run);
        if (run.blocks.empty()) continue;
        stand_where_it_leaves_the_pole(run);
        find_passages(run);
        return true;
    }
    return false;
}

}  // namespace trunnion::path
