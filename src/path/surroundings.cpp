#include "detail/surroundings.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace trunnion::path::detail {

using machine::AxisPosition;
using machine::Kinematics;
using machine::RotaryPosition;
using program::Move;
using program::MoveKind;
using program::Program;

namespace {

bool is_far(const Move& move) {
    const auto far = [](double x) { return std::abs(x) > longest_move_mm; };
    return move.position_mm.unaryExpr(far).any() || std::ranges::any_of(move.rotary_rad, far) || !move.axis.allFinite();
}

}  // namespace

Result<Surroundings> Surroundings::make(const Program& program, const machine::Machine& machine,
                                        const machine::Setup& setup) {
    if (program.moves.empty())
        return fail({.code = "PATH0001", .text = "the program moves nothing", .place = {.file = program.source}});
    if (!program.surface_jobs.empty())
        return fail({.code = "PATH0011",
                     .text = "the program has surfaces to be machined whose passes are not laid yet",
                     .place = {.file = program.source, .line = program.surface_jobs.front().line},
                     .hint = "pipeline::expand_surfaces() lays them"});
    for (const Move& move : program.moves)
        if (is_far(move))
            return fail(
                at_move(program, move, "PATH0010", "the move goes beyond 10 km, or a coordinate is not finite"));
    Surroundings out(program, machine, setup);
    if (auto found = out.find_words(); !found) return fail(found.error());
    if (auto sound = out.curves_.check(); !sound) return fail(sound.error());
    out.tools_.resize(program.tools.size());
    out.offsets_.resize(program.offsets.size());
    return out;
}

Result<void> Surroundings::find_words() {
    for (std::size_t word = 0; word < program_->rotary_letters.size(); ++word) {
        const char letter = program_->rotary_letters[word];
        const int axis = machine_->index_of(letter);
        if (axis < 0 || !machine_->axes[axis].rotary)
            return fail({.code = "PATH0006",
                         .text = fmt::format("the machine '{}' has no rotary axis {}", machine_->name, letter),
                         .place = {.file = program_->source}});
        word_of_axis_[static_cast<std::size_t>(axis - machine_->linear_count())] = static_cast<int>(word);
    }
    return {};
}

RotaryPosition Surroundings::start() const {
    RotaryPosition out{};
    for (int a = 0; a < machine_->rotary_count; ++a)
        if (const auto at = setup_->start.find(machine_->axes[machine_->linear_count() + a].letter);
            at != setup_->start.end())
            out[a] = at->second;
    return out;
}

Result<const Kinematics*> Surroundings::kinematics_for(double tool_length_mm) {
    const auto known = kinematics_by_length_.find(tool_length_mm);
    if (known != kinematics_by_length_.end()) return &kinematics_[known->second];
    auto made = Kinematics::make(*machine_, setup_->workpiece, tool_length_mm);
    if (!made) return fail(made.error());
    kinematics_by_length_[tool_length_mm] = kinematics_.size();
    kinematics_.push_back(*made);
    return &kinematics_.back();
}

Result<const machine::Tool*> Surroundings::tool_of(const Move& move) {
    const std::string& name = program_->tools[move.tool];
    if (name.empty()) return &setup_->tool;
    if (const machine::Tool* found = setup_->tool_named(name)) return found;
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
    missing.hint = fmt::format("add [tools.\"{}\"] with its length to the setup file", name);
    return fail(missing);
}

Result<const machine::Frame*> Surroundings::offset_of(const Move& move) {
    const std::string& name = program_->offsets[move.offset];
    if (const auto found = setup_->offsets.find(name); found != setup_->offsets.end()) return &found->second;
    if (name.empty() || name == "G54") return &no_offset_.front();
    auto missing = at_move(*program_, move, "PATH0003", fmt::format("work offset {} is not in the setup", name));
    missing.hint = fmt::format("add [offsets.{}] to the setup file", name);
    return fail(missing);
}

Result<Surrounding> Surroundings::of(const Move& move) {
    Surrounding& with_tool = tools_[move.tool];
    if (!with_tool.kinematics) {
        auto tool = tool_of(move);
        if (!tool) return fail(tool.error());
        auto kinematics = kinematics_for((*tool)->length_mm);
        if (!kinematics) return fail(kinematics.error());
        with_tool.tool = *tool;
        with_tool.kinematics = *kinematics;
    }
    const machine::Frame*& offset = offsets_[move.offset];
    if (!offset) {
        auto found = offset_of(move);
        if (!found) return fail(found.error());
        offset = *found;
    }
    return Surrounding{with_tool.tool, with_tool.kinematics, offset};
}

Diagnostic at_move(const Program& program, const Move& move, std::string code, std::string text) {
    return {.code = std::move(code), .text = std::move(text), .place = {.file = program.source, .line = move.line}};
}

Eigen::Vector3d out_of_offset(const machine::Frame& offset, const Eigen::Vector3d& position_mm) {
    return offset.rotation * position_mm + offset.origin_mm;
}
Eigen::Vector3d into_offset(const machine::Frame& offset, const Eigen::Vector3d& tip_in_workpiece_mm) {
    return offset.rotation.transpose() * (tip_in_workpiece_mm - offset.origin_mm);
}

AxisPosition axes_of(const machine::Machine& machine, const std::array<double, 3>& linear_mm,
                     const RotaryPosition& rotary_rad) {
    AxisPosition out;
    for (int i = 0; i < machine.linear_count(); ++i) out[i] = linear_mm[i];
    for (int a = 0; a < machine.rotary_count; ++a) out[machine.linear_count() + a] = rotary_rad[a];
    return out;
}

RotaryPosition rotary_of(const machine::Machine& machine, const AxisPosition& position) {
    RotaryPosition out{};
    for (int a = 0; a < machine.rotary_count; ++a) out[a] = position[machine.linear_count() + a];
    return out;
}

Eigen::Vector3d whole_position(const Move& move, const Surrounding& in, const machine::Machine& machine,
                               const AxisPosition& here) {
    if (!move.position_mm.hasNaN()) return move.position_mm;
    Eigen::Vector3d standing(here[0], here[1], here[2]);
    if (move.space == Space::workpiece) {
        standing = into_offset(*in.offset, in.kinematics->forward(here).tip_in_workpiece_mm);
    } else if (move.space == Space::untransformed) {
        const AxisPosition unturned = axes_of(machine, {here[0], here[1], here[2]}, {});
        standing = into_offset(*in.offset, in.kinematics->forward(unturned).tip_in_workpiece_mm);
    }
    return move.position_mm.array().isNaN().select(standing, move.position_mm);
}

std::array<double, 3> linear_of_untransformed(const Surrounding& in, const Eigen::Vector3d& position_mm) {
    return in.kinematics->linear_for(out_of_offset(*in.offset, position_mm), RotaryPosition{});
}

StopCause stop_between(const Program& program, std::size_t move) {
    if (move >= program.moves.size()) return StopCause::end;
    const Move& before = program.moves[move - 1];
    const Move& after = program.moves[move];
    if (before.kind == MoveKind::rapid || after.kind == MoveKind::rapid) return StopCause::rapid;
    for (auto event = std::lower_bound(program.events.begin(), program.events.end(), move,
                                       [](const program::Event& e, std::size_t at) { return e.before_move < at; });
         event != program.events.end() && event->before_move == move; ++event)
        if (event->stops_motion) return StopCause::event;
    if (before.exact_stop) return StopCause::exact_stop;
    if (before.space != after.space) return StopCause::space;
    if (before.tool != after.tool) return StopCause::tool;
    return StopCause::corner;
}

}  // namespace trunnion::path::detail
