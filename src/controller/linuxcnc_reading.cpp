#include "detail/linuxcnc_reading.hpp"

#include <cmath>
#include <string_view>

#include <fmt/format.h>

#include "trunnion/base/quantity.hpp"

namespace trunnion::controller::linuxcnc {

using machine::Kinematics;
using program::EventKind;
using program::Move;
using program::Space;

namespace {

constexpr double farthest_mm = 1e7;

int slot_of(char letter) {
    return letter >= 'A' && letter <= 'C' ? letter - 'A' : -1;
}

bool is_turned(const machine::Frame& frame) {
    return !frame.rotation.isIdentity(1e-12);
}

}  // namespace

Diagnostic Reading::at(const Move& move, std::string code, std::string text) const {
    return {.code = std::move(code), .text = std::move(text), .place = {.file = program_->source, .line = move.line}};
}

Result<Reading> Reading::make(const program::Program& program, const machine::Machine& machine,
                              const machine::Setup& setup, const LinuxcncWaits& waits) {
    Reading reading(program, machine, setup, waits);
    if (program.moves.size() < 2)
        return fail({.code = "CTRL0108", .text = "the program makes no move", .place = {.file = program.source}});
    if (auto good = reading.check_machine(); !good) return fail(good.error());
    if (auto good = reading.find_letters(); !good) return fail(good.error());
    return reading;
}

Result<void> Reading::check_machine() const {
    for (int i = 0; i < machine_->axis_count; ++i) {
        const machine::Axis& axis = machine_->axes[static_cast<std::size_t>(i)];
        if (std::string_view(axis.rotary ? "ABC" : "XYZ").contains(axis.letter)) continue;
        Diagnostic unknown{.code = "CTRL0101",
                           .text = "LinuxCNC is modelled with linear axes X Y Z and rotary axes A B C"};
        unknown.place.file = machine_->file;
        unknown.value = std::string(1, axis.letter);
        return fail(std::move(unknown));
    }
    if (is_turned(setup_->workpiece)) {
        Diagnostic turned{.code = "CTRL0104", .text = "the workpiece is turned: LinuxCNC has no such frame"};
        turned.place.file = setup_->file;
        return fail(std::move(turned));
    }
    return {};
}

Result<void> Reading::find_letters() {
    const auto first = static_cast<std::size_t>(machine_->linear_count());
    for (std::size_t i = 0; i < static_cast<std::size_t>(machine_->rotary_count); ++i)
        axis_slot_[i] = slot_of(machine_->axes[first + i].letter);
    for (const char letter : program_->rotary_letters) {
        const int axis = machine_->index_of(letter);
        if (axis < machine_->linear_count()) {
            Diagnostic missing{.code = "CTRL0102", .text = "rotary words of an axis that the machine has not"};
            missing.place.file = program_->source;
            missing.value = std::string(1, letter);
            return fail(std::move(missing));
        }
        letter_slot_.push_back(slot_of(letter));
    }
    return {};
}

// ---- frames

Result<const Kinematics*> Reading::kinematics_of(const Move& move) {
    const std::string& name = program_->tools[move.tool];
    const machine::Tool* named = name.empty() ? nullptr : setup_->tool_named(name);
    if (!named && !name.empty() && !setup_->tools.empty()) {
        Diagnostic missing = at(move, "CTRL0109", fmt::format("tool {} is not in the setup", name));
        missing.hint = fmt::format("add [tools.\"{}\"] with its length to the setup file", name);
        return fail(std::move(missing));
    }
    const double length_mm = (named ? *named : setup_->tool).length_mm;
    const auto known = kinematics_by_length_.find(length_mm);
    if (known != kinematics_by_length_.end()) return &kinematics_[known->second];
    auto made = Kinematics::make(*machine_, setup_->workpiece, length_mm);
    if (!made) return fail(made.error());
    kinematics_by_length_[length_mm] = kinematics_.size();
    kinematics_.push_back(*made);
    return &kinematics_.back();
}

Result<Vector3d> Reading::origin_of(const Move& move) const {
    const std::string& name = program_->offsets[move.offset];
    const auto found = setup_->offsets.find(name);
    if (found == setup_->offsets.end()) {
        if (name.empty() || name == "G54") return Vector3d::Zero().eval();
        Diagnostic missing = at(move, "CTRL0110", fmt::format("work offset {} is not in the setup", name));
        missing.hint = fmt::format("add [offsets.{}] to the setup file", name);
        return fail(std::move(missing));
    }
    if (is_turned(found->second))
        return fail(at(move, "CTRL0104", fmt::format("work offset {} is turned: not modelled", name)));
    return found->second.origin_mm;
}

std::size_t Reading::index_of(const Geometry& geometry) {
    for (std::size_t i = 0; i < geometries_.size(); ++i)
        if (geometries_[i] == geometry) return i;
    geometries_.push_back(geometry);
    return geometries_.size() - 1;
}

machine::RotaryPosition Reading::rotary_of(const Coordinates& position) const {
    machine::RotaryPosition out{};
    for (int i = 0; i < machine_->rotary_count; ++i)
        out[static_cast<std::size_t>(i)] = position.rotary_deg[axis_slot_[static_cast<std::size_t>(i)]] * degree;
    return out;
}

machine::AxisPosition Reading::axes_at(const Coordinates& position, std::size_t index) const {
    const Geometry& geometry = geometries_[index];
    const machine::RotaryPosition rotary = rotary_of(position);
    const auto linear =
        geometry.kinematics->linear_for(position.linear_mm, geometry.tcp ? rotary : machine::RotaryPosition{});
    machine::AxisPosition axes;
    for (std::size_t i = 0; i < 3; ++i) axes[i] = linear[i];
    for (int i = 0; i < machine_->rotary_count; ++i)
        axes[3 + static_cast<std::size_t>(i)] = rotary[static_cast<std::size_t>(i)];
    return axes;
}

Coordinates Reading::coordinates_of(const machine::AxisPosition& axes, const Geometry& geometry) const {
    Coordinates out;
    machine::AxisPosition seen = axes;
    for (int i = 0; i < machine_->rotary_count; ++i) {
        const auto axis = 3 + static_cast<std::size_t>(i);
        out.rotary_deg[axis_slot_[static_cast<std::size_t>(i)]] = axes[axis] / degree;
        if (!geometry.tcp) seen[axis] = 0;
    }
    out.linear_mm = geometry.kinematics->forward(seen).tip_in_workpiece_mm;
    return out;
}

/// G53 is a block of its own: what counts behind it is what counted before.
Result<void> Reading::enter(const Move& move, Canonical& canonical) {
    if (move.space == Space::machine) return {};
    auto kinematics = kinematics_of(move);
    if (!kinematics) return fail(kinematics.error());
    const Geometry geometry{*kinematics, move.space == Space::workpiece};
    if (geometries_[geometry_] != geometry) {
        const machine::AxisPosition axes = axes_at(position_, geometry_);
        geometry_ = index_of(geometry);
        position_ = coordinates_of(axes, geometry);
        canonical.recount(position_, geometry_);
        canonical.wait(LinuxcncWait::other, (*waits_)[LinuxcncWait::other]);
    } else if (move.offset != offset_ || move.tool != tool_) {
        canonical.wait(LinuxcncWait::other, (*waits_)[LinuxcncWait::other]);
    }
    offset_ = move.offset;
    tool_ = move.tool;
    return {};
}

// ---- moves

Result<void> Reading::start(Canonical& canonical) {
    const Move& first = program_->moves.front();
    Move framed = first;
    if (first.space == Space::machine) framed.space = Space::workpiece;
    auto kinematics = kinematics_of(framed);
    if (!kinematics) return fail(kinematics.error());
    geometry_ = index_of({*kinematics, framed.space == Space::workpiece});
    offset_ = first.offset;
    tool_ = first.tool;
    if (setup_->start.empty()) {
        auto begin = end_of(first);
        if (!begin) return fail(begin.error());
        position_ = *begin;
    } else {
        machine::AxisPosition axes;
        for (int i = 0; i < machine_->axis_count; ++i)
            if (const auto at = setup_->start.find(machine_->axes[static_cast<std::size_t>(i)].letter);
                at != setup_->start.end())
                axes[static_cast<std::size_t>(i)] = at->second;
        position_ = coordinates_of(axes, geometries_[geometry_]);
        next_ = 0;
    }
    canonical.stand_at(position_);
    canonical.recount(position_, geometry_);
    return {};
}

Result<void> Reading::read_on(Canonical& canonical) {
    words_before(next_, canonical);
    if (next_ < program_->moves.size()) {
        if (auto good = move(program_->moves[next_], canonical); !good) return good;
        ++next_;
    }
    if (at_end()) {
        words_before(program_->moves.size(), canonical);
        canonical.finish();
    }
    return {};
}

Result<Coordinates> Reading::end_of(const Move& move) const {
    if (move.law == program::OrientationLaw::vector && machine_->rotary_count > 0)
        return fail(at(move, "CTRL0103", "LinuxCNC takes rotary words; this move says the tool's direction"));
    Coordinates end = position_;
    Vector3d linear = move.position_mm;
    if (move.space == Space::machine) {
        machine::AxisPosition axes;
        const auto standing = geometries_[geometry_].kinematics->linear_for(position_.linear_mm, {});
        for (int i = 0; i < 3; ++i)
            axes[static_cast<std::size_t>(i)] =
                std::isnan(linear[i]) ? standing[static_cast<std::size_t>(i)] : linear[i];
        linear = geometries_[geometry_].kinematics->forward(axes).tip_in_workpiece_mm;
    } else {
        auto origin = origin_of(move);
        if (!origin) return fail(origin.error());
        linear += *origin;
    }
    for (int i = 0; i < 3; ++i)
        if (!std::isnan(linear[i])) end.linear_mm[i] = linear[i];
    for (std::size_t i = 0; i < letter_slot_.size(); ++i)
        if (!std::isnan(move.rotary_rad[i])) end.rotary_deg[letter_slot_[i]] = move.rotary_rad[i] / degree;
    if (!(end.linear_mm.cwiseAbs().maxCoeff() <= farthest_mm) ||
        !(end.rotary_deg.cwiseAbs().maxCoeff() <= farthest_mm / degree))
        return fail(at(move, "CTRL0111", "a coordinate beyond 10 km, or not finite"));
    return end;
}

Result<Circle> Reading::circle_of(const Move& move, const Coordinates& end, int& normal_axis) const {
    const program::Arc& arc = program_->arcs[static_cast<std::size_t>(move.arc)];
    const double sense = arc.angle_rad < 0 ? -1 : 1;
    const Vector3d normal = sense * arc.normal;
    arc.normal.cwiseAbs().maxCoeff(&normal_axis);
    const auto wrong = [&](std::string text) { return fail(at(move, "CTRL0106", std::move(text))); };
    if (std::abs(std::abs(arc.normal[normal_axis]) - 1) > 1e-12) return wrong("an arc that is not about X, Y or Z");
    Vector3d origin = Vector3d::Zero();
    if (move.space != Space::machine) {
        auto offset = origin_of(move);
        if (!offset) return fail(offset.error());
        origin = *offset;
    }
    Vector3d centre = arc.centre_mm + origin;
    centre[normal_axis] = position_.linear_mm[normal_axis];
    Vector3d last = end.linear_mm - centre;
    const double rise = last[normal_axis];
    last[normal_axis] = 0;
    if (!((position_.linear_mm - centre).norm() > 0) || !(std::abs(arc.angle_rad) > 0))
        return wrong("an arc without length");
    return Circle(position_.linear_mm, centre, normal, last.norm(), std::abs(arc.angle_rad),
                  rise * Vector3d::Unit(normal_axis));
}

Result<void> Reading::move(const Move& move, Canonical& canonical) {
    if (auto good = enter(move, canonical); !good) return good;
    auto end = end_of(move);
    if (!end) return fail(end.error());
    Way way;
    way.end = *end;
    way.rapid = move.kind == program::MoveKind::rapid;
    way.feed = move.feed;
    way.line = move.line;
    if (!way.rapid && !(move.feed.value > 0)) return fail(at(move, "CTRL0105", "a cutting move without a feed"));
    if (move.curve_part != program::no_curve_part)
        return fail(at(move, "CTRL0114", "a curve of the program: LinuxCNC's splines are not modelled"));
    if (move.arc != program::no_arc) {
        auto circle = circle_of(move, *end, way.normal_axis);
        if (!circle) return fail(circle.error());
        way.circle = *circle;
    }
    canonical.move(way);
    position_ = *end;
    return {};
}

// ---- words

void Reading::words_before(std::size_t move, Canonical& canonical) {
    const auto& events = program_->events;
    const auto& controls = program_->path_controls;
    for (; control_ < controls.size() && controls[control_].before_move <= move; ++control_)
        canonical.path_control(controls[control_]);
    for (; event_ < events.size() && events[event_].before_move <= move; ++event_) event(events[event_], canonical);
}

/// What the control does at a word beside motion: it waits until the motion has ended, and somewhat longer.
void Reading::event(const program::Event& event, Canonical& canonical) {
    const LinuxcncWaits& waits = *waits_;
    switch (event.kind) {
        case EventKind::dwell:
            canonical.length_over_feed_s += event.dwell_s;
            return canonical.wait(LinuxcncWait::dwell, waits[LinuxcncWait::dwell], event.dwell_s);
        case EventKind::tool:
            if (!event.stops_motion)
                prepared_line_ = event.line;
            else if (prepared_line_ == event.line)
                canonical.wait(LinuxcncWait::tool_preparation,
                               waits[LinuxcncWait::tool_preparation] + waits[LinuxcncWait::tool_change]);
            else
                canonical.wait(LinuxcncWait::tool_change, waits[LinuxcncWait::tool_change]);
            return;
        case EventKind::coolant:
            return canonical.wait(LinuxcncWait::coolant, waits[LinuxcncWait::coolant]);
        case EventKind::spindle:
            return canonical.wait(LinuxcncWait::spindle, waits[LinuxcncWait::spindle]);
        case EventKind::stop:
            return canonical.wait(LinuxcncWait::other, waits[LinuxcncWait::other]);
        case EventKind::other:
            return;
    }
}

}  // namespace trunnion::controller::linuxcnc
