#include "trunnion/path/path_builder.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace trunnion::path {

using machine::Kinematics;
using program::Move;
using program::MoveKind;
using program::Program;

namespace {

constexpr double shortest_block_mm = 1e-7;
constexpr double opposite_rad = 3.14159265;  // closer to half a turn than 4e-9 rad the plane of the turn is lost

std::array<double, 3> to_array(const Eigen::Vector3d& v) {
    return {v.x(), v.y(), v.z()};
}
Eigen::Vector3d to_vector(const std::array<double, 3>& v) {
    return {v[0], v[1], v[2]};
}

machine::RotaryPosition rotary_of(const PathCoordinates& c) {
    return {c.orientation[0], c.orientation[1]};
}

Diagnostic at_move(const Program& program, const Move& move, std::string code, std::string text) {
    return {.code = std::move(code), .text = std::move(text), .place = {.file = program.source, .line = move.line}};
}

}  // namespace

Result<PathBuilder> PathBuilder::make(const Program& program, const machine::Machine& machine,
                                      const machine::Setup& setup) {
    PathBuilder builder(program, machine, setup);
    if (auto begun = builder.begin(); !begun) return fail(begun.error());
    return builder;
}

Result<void> PathBuilder::begin() {
    if (program_->moves.empty())
        return fail({.code = "PATH0001", .text = "the program moves nothing", .place = {.file = program_->source}});
    for (const char letter : program_->rotary_letters) {
        const int axis = machine_->index_of(letter);
        if (axis < 0 || !machine_->axes[axis].rotary)
            return fail({.code = "PATH0006",
                         .text = fmt::format("the machine '{}' has no rotary axis {}", machine_->name, letter),
                         .place = {.file = program_->source}});
    }
    const Move& first = program_->moves.front();
    if (auto entered = enter(first); !entered) return entered;
    auto at = coordinates_of(first);
    if (!at) return fail(at.error());
    at_ = *at;
    space_ = first.space;
    move_ = 1;
    return {};
}

machine::AxisPosition PathBuilder::home() const {
    machine::AxisPosition out;
    for (int i = 0; i < machine_->axis_count; ++i)
        if (const auto start = setup_->start.find(machine_->axes[i].letter); start != setup_->start.end())
            out[i] = start->second;
    const int turning = in_use_->rotary_nearest_workpiece();
    if (turning < 0 || program_->moves.front().law != OrientationLaw::vector) return out;
    const auto at_pole = [&](const Move& move) { return in_use_->rotary_for(move.axis).degenerate; };
    if (!at_pole(program_->moves.front())) return out;
    const auto tilted = std::find_if_not(program_->moves.begin(), program_->moves.end(), at_pole);
    if (tilted == program_->moves.end()) return out;
    const auto solutions = in_use_->rotary_for(tilted->axis);
    const int linear = machine_->linear_count();
    for (int branch = 0; branch < solutions.count; ++branch) {
        const auto& rotary = solutions.rotary_rad[branch];
        bool inside = true;
        for (int a = 0; a < machine_->rotary_count; ++a) {
            const machine::Axis& axis = machine_->axes[linear + a];
            inside = inside && rotary[a] >= axis.range_min && rotary[a] <= axis.range_max;
        }
        if (!inside) continue;
        out[linear + turning] = rotary[turning];
        break;
    }
    return out;
}

Result<const Kinematics*> PathBuilder::kinematics_for(double tool_length_mm) {
    const auto known = kinematics_by_length_.find(tool_length_mm);
    if (known != kinematics_by_length_.end()) return &kinematics_[known->second];
    auto made = Kinematics::make(*machine_, setup_->workpiece, tool_length_mm);
    if (!made) return fail(made.error());
    kinematics_by_length_[tool_length_mm] = kinematics_.size();
    kinematics_.push_back(*made);
    return &kinematics_.back();
}

Result<const machine::Tool*> PathBuilder::tool_of(const Move& move) {
    const std::string& name = program_->tools[move.tool];
    if (name.empty()) return &setup_->tool;
    if (const auto found = setup_->tools.find(name); found != setup_->tools.end()) return &found->second;
    if (setup_->tools.empty() && (borrowed_tool_.empty() || borrowed_tool_ == name)) {
        if (borrowed_tool_.empty())
            diagnostics_.push_back({.code = "PATH0007",
                                    .severity = Severity::note,
                                    .text = fmt::format("tool {} is taken to be the setup's [tool], length {} mm", name,
                                                        setup_->tool.length_mm),
                                    .place = {.file = program_->source, .line = move.line}});
        borrowed_tool_ = name;
        return &setup_->tool;
    }
    auto missing = at_move(*program_, move, "PATH0002", fmt::format("tool {} is not in the setup", name));
    missing.hint = fmt::format("add [tools.{}] with its length to the setup file", name);
    return fail(missing);
}

Result<machine::Frame> PathBuilder::offset_of(const Move& move) const {
    const std::string& name = program_->offsets[move.offset];
    if (const auto found = setup_->offsets.find(name); found != setup_->offsets.end()) return found->second;
    if (name.empty() || name == "G54") return machine::Frame{};
    auto missing = at_move(*program_, move, "PATH0003", fmt::format("work offset {} is not in the setup", name));
    missing.hint = fmt::format("add [offsets.{}] to the setup file", name);
    return fail(missing);
}

/// End of a move in the coordinates of its space and law, in the workpiece frame.
Result<PathCoordinates> PathBuilder::coordinates_of(const Move& move) {
    PathCoordinates out;
    const bool in_workpiece = move.space == Space::workpiece;
    auto offset = offset_of(move);
    if (!offset) return fail(offset.error());
    out.position_mm = to_array(in_workpiece ? Eigen::Vector3d(offset->rotation * move.position_mm + offset->origin_mm)
                                            : move.position_mm);
    if (move.law == OrientationLaw::vector && in_workpiece) {
        out.orientation = to_array(offset->rotation * move.axis);
        return out;
    }
    const int linear = machine_->linear_count();
    for (int a = 0; a < machine_->rotary_count; ++a) {
        const char letter = machine_->axes[linear + a].letter;
        const auto word = std::find(program_->rotary_letters.begin(), program_->rotary_letters.end(), letter);
        if (word != program_->rotary_letters.end())
            out.orientation[a] = move.rotary_rad[static_cast<std::size_t>(word - program_->rotary_letters.begin())];
        else if (const auto start = setup_->start.find(letter); start != setup_->start.end())
            out.orientation[a] = start->second;
    }
    return out;
}

/// Takes the tool of a move into use. The machine stands still meanwhile: with a tool of another length the tip is
/// elsewhere.
Result<void> PathBuilder::enter(const Move& move) {
    auto tool = tool_of(move);
    if (!tool) return fail(tool.error());
    if (*tool == tool_) return {};
    auto kinematics = kinematics_for((*tool)->length_mm);
    if (!kinematics) return fail(kinematics.error());
    if (tool_ && space_ == Space::workpiece) {
        const bool vectors = program_->moves.front().law == OrientationLaw::vector;
        const Eigen::Vector3d axis = vectors ? to_vector(at_.orientation) : (*kinematics)->tool_axis(rotary_of(at_));
        at_.position_mm = to_array(to_vector(at_.position_mm) + (tool_->length_mm - (*tool)->length_mm) * axis);
    }
    tool_ = *tool;
    in_use_ = *kinematics;
    return {};
}

/// The present place in the coordinates of another space (law rotary).
PathCoordinates PathBuilder::converted(Space space) const {
    PathCoordinates out = at_;
    if (space == space_) return out;
    if (space == Space::machine) {
        out.position_mm = in_use_->linear_for(to_vector(at_.position_mm), rotary_of(at_));
        return out;
    }
    machine::AxisPosition axes;
    for (int i = 0; i < machine_->linear_count(); ++i) axes[i] = at_.position_mm[i];
    for (int i = 0; i < machine_->rotary_count; ++i) axes[machine_->linear_count() + i] = at_.orientation[i];
    out.position_mm = to_array(in_use_->forward(axes).tip_in_workpiece_mm);
    return out;
}

bool PathBuilder::event_stops_before(std::size_t move) const {
    for (std::size_t e = event_; e < program_->events.size() && program_->events[e].before_move <= move; ++e)
        if (program_->events[e].before_move == move && program_->events[e].stops_motion) return true;
    return false;
}

/// What cuts the path between moves[move − 1] and moves[move]; `corner`: nothing does.
StopCause PathBuilder::stop_before(std::size_t move) const {
    if (move >= program_->moves.size()) return StopCause::end;
    const Move& before = program_->moves[move - 1];
    const Move& after = program_->moves[move];
    if (before.kind == MoveKind::rapid || after.kind == MoveKind::rapid) return StopCause::rapid;
    if (event_stops_before(move)) return StopCause::event;
    if (before.exact_stop) return StopCause::exact_stop;
    if (before.space != after.space) return StopCause::space;
    if (before.tool != after.tool) return StopCause::tool;
    return StopCause::corner;
}

void PathBuilder::take_events(Run& run) {
    for (; event_ < program_->events.size() && program_->events[event_].before_move <= move_; ++event_)
        run.events.push_back({event_, run.blocks.size()});
}

Result<bool> PathBuilder::next(Run& run) {
    run = {};
    while (move_ < program_->moves.size()) {
        const Move& first = program_->moves[move_];
        if (first.law != program_->moves.front().law)
            return fail(
                at_move(*program_, first, "PATH0004", "the program changes between tool vectors and rotary words"));
        if (auto entered = enter(first); !entered) return fail(entered.error());
        at_ = converted(first.space);
        space_ = first.space;
        run.space = first.space;
        run.law = first.space == Space::machine ? OrientationLaw::rotary : first.law;
        run.rapid = first.kind == MoveKind::rapid;
        run.first_move = move_;
        run.kinematics = in_use_;
        run.controlled_height_mm = tool_->controlled_height_mm();
        run.vertices = {at_};
        do {
            take_events(run);
            const Move& move = program_->moves[move_];
            auto to = coordinates_of(move);
            if (!to) return fail(to.error());
            const double length = block_length_mm(run, at_, *to);
            if (run.law == OrientationLaw::vector && turn_rad(run, at_, *to) > opposite_rad)
                return fail(at_move(*program_, move, "PATH0005",
                                    "the tool axis is turned by half a turn: the plane is undefined"));
            ++move_;
            if (length < shortest_block_mm) continue;
            run.vertices.push_back(*to);
            run.blocks.push_back({length, move.feed, move.line});
            at_ = *to;
        } while (stop_before(move_) == StopCause::corner);
        run.stop = stop_before(move_);
        if (move_ == program_->moves.size()) take_events(run);
        if (!run.blocks.empty()) return true;
    }
    return false;
}

}  // namespace trunnion::path
