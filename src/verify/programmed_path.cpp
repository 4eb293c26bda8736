#include "trunnion/verify/programmed_path.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "detail/chain.hpp"
#include "detail/fault.hpp"
#include "detail/turning_in_plane.hpp"

namespace trunnion::verify {

namespace {

using machine::AxisPosition;
using program::Move;
using program::OrientationLaw;
using program::Space;

constexpr std::size_t most_poses = 10'000'000;
constexpr int deepest_halving = 40;

/// Walks through the moves and keeps where the tool is.
class Expansion {
  public:
    Expansion(const program::Program& program, const machine::Machine& machine, const machine::Setup& setup)
        : program_(program), machine_(machine), setup_(setup), chain_(machine, setup.workpiece) {}

    Result<std::vector<ProgrammedPose>> run() {
        if (program_.moves.empty()) return fail(diagnose(0, "VER0101", "the program has no moves"));
        if (auto known = find_words(); !known) return fail(known.error());
        for (const Move& move : program_.moves)
            if (auto added = add(move); !added) return fail(added.error());
        return std::move(poses_);
    }

  private:
    Diagnostic diagnose(int line, std::string code, std::string text, std::string hint = {}) const {
        auto out = fault_at(line, std::move(code), std::move(text), program_.source);
        out.hint = std::move(hint);
        return out;
    }

    Result<void> find_words() {
        for (const char letter : program_.rotary_letters) {
            const int index = machine_.index_of(letter);
            if (index < 0 || !machine_.axes[index].rotary)
                return fail(diagnose(0, "VER0102", fmt::format("the machine has no rotary axis {}", letter)));
            rotary_of_word_.push_back(index - machine_.linear_count());
        }
        return {};
    }

    Result<void> add(const Move& move) {
        if (!move.position_mm.allFinite()) return fail(diagnose(move.line, "VER0108", "a coordinate is not finite"));
        const auto length = tool_length(move);
        if (!length) return fail(length.error());
        take_tool(*length, move.line);
        return move.space == Space::workpiece ? add_in_workpiece(move) : add_in_machine(move);
    }

    Result<double> tool_length(const Move& move) {
        const std::string& name = program_.tools[move.tool];
        if (name.empty()) return setup_.tool.length_mm;
        if (const auto found = setup_.tools.find(name); found != setup_.tools.end()) return found->second.length_mm;
        if (!first_tool_) first_tool_ = name;
        if (setup_.tools.empty() && *first_tool_ == name) return setup_.tool.length_mm;
        return fail(diagnose(move.line, "VER0103", fmt::format("tool {} is not in the setup", name),
                             fmt::format("add [tools.{}] to the setup file", name)));
    }

    /// The machine stands still while the tool is changed: the new tip is elsewhere on the same axis.
    void take_tool(double length_mm, std::int32_t line) {
        const double before = std::exchange(length_mm_, length_mm);
        if (poses_.empty() || before == length_mm) return;
        ProgrammedPose pose = poses_.back();
        pose.tip_mm += (before - length_mm) * pose.axis;
        pose.tool_length_mm = length_mm;
        pose.line = line;
        poses_.push_back(pose);
    }

    Result<machine::Frame> offset(const Move& move) const {
        const std::string& name = program_.offsets[move.offset];
        if (const auto found = setup_.offsets.find(name); found != setup_.offsets.end()) return found->second;
        if (name.empty() || name == "G54") return machine::Frame{};
        return fail(diagnose(move.line, "VER0104", fmt::format("work offset {} is not in the setup", name),
                             fmt::format("add [offsets.{}] to the setup file", name)));
    }

    Result<void> add_in_workpiece(const Move& move) {
        const auto frame = offset(move);
        if (!frame) return fail(frame.error());
        ProgrammedPose pose;
        pose.tip_mm = frame->rotation * move.position_mm + frame->origin_mm;
        pose.at_rapid = move.kind == program::MoveKind::rapid;
        pose.line = move.line;
        pose.tool_length_mm = length_mm_;
        if (move.law == OrientationLaw::vector) {
            if (!(move.axis.norm() > 1e-9) || !move.axis.allFinite())
                return fail(diagnose(move.line, "VER0108", "the tool axis has no direction"));
            pose.axis = (frame->rotation * move.axis).normalized();
        } else {
            pose.rotary_rad = words(move);
            pose.axis = chain_.gauge(axes_of(pose.rotary_rad)).axis;
            if (!pose.axis.allFinite()) return fail(diagnose(move.line, "VER0108", "a rotary word is not finite"));
        }
        const bool turns_by_words = move.law == OrientationLaw::rotary && !program_.rotary_letters.empty();
        rotary_known_ = move.law == OrientationLaw::rotary || machine_.rotary_count == 0;
        pose.kind = turns_by_words ? PoseKind::rotary : pose.at_rapid ? PoseKind::rapid : PoseKind::vector;
        return push(pose);
    }

    Result<void> push(const ProgrammedPose& pose) {
        if (!poses_.empty() && pose.kind != PoseKind::rotary && opposite(poses_.back().axis, pose.axis))
            return fail(
                diagnose(pose.line, "VER0105", "the tool axis is turned by half a turn: the plane is undefined"));
        if (poses_.size() >= most_poses)
            return fail(diagnose(pose.line, "VER0109", "the program has too many poses to be checked"));
        poses_.push_back(pose);
        return {};
    }

    std::array<double, machine::max_rotary_axes> words(const Move& move) const {
        auto out = ProgrammedPose{}.rotary_rad;
        for (std::size_t w = 0; w < rotary_of_word_.size(); ++w) out[rotary_of_word_[w]] = move.rotary_rad[w];
        return out;
    }

    /// Rotary axes as the words say, the others where the setup lets them stand; linear ones at 0.
    AxisPosition axes_of(const std::array<double, machine::max_rotary_axes>& rotary_rad) const {
        AxisPosition out;
        for (int r = 0; r < machine_.rotary_count; ++r) {
            const int index = machine_.linear_count() + r;
            const auto start = setup_.start.find(machine_.axes[index].letter);
            const double standing = start == setup_.start.end() ? 0.0 : start->second;
            out[index] = std::isnan(rotary_rad[r]) ? standing : rotary_rad[r];
        }
        return out;
    }

    Result<void> add_in_machine(const Move& move) {
        const bool unknown = move.law == OrientationLaw::vector && machine_.rotary_count > 0;
        const bool from_unknown = !poses_.empty() && !rotary_known_;
        if (unknown || from_unknown)
            return fail(diagnose(move.line, "VER0106", "a move in machine coordinates needs rotary words"));
        const auto rotary = words(move);
        AxisPosition to = axes_of(rotary);
        for (int i = 0; i < std::min(3, machine_.linear_count()); ++i) to[i] = move.position_mm[i];
        const bool rapid = move.kind == program::MoveKind::rapid;
        ProgrammedPose pose = pose_at(to);
        pose.rotary_rad = rotary;
        pose.at_rapid = rapid;
        pose.kind = rapid ? PoseKind::rapid : PoseKind::vector;
        pose.line = move.line;
        rotary_known_ = true;
        if (poses_.empty()) return push(pose);
        const ProgrammedPose& last = poses_.back();
        const auto from = chain_.with_gauge_at(last.tip_mm + length_mm_ * last.axis, axes_of(last.rotary_rad));
        if (!from) return fail(diagnose(move.line, "VER0107", "the linear axes of the machine do not span space"));
        return add_chords(*from, last, to, pose, 0);
    }

    ProgrammedPose pose_at(const AxisPosition& axes) const {
        const Gauge gauge = chain_.gauge(axes);
        ProgrammedPose out;
        out.tip_mm = gauge.tip_mm(length_mm_);
        out.axis = gauge.axis;
        out.tool_length_mm = length_mm_;
        return out;
    }

    /// Halves until the machine's own way is within the chord tolerance at a quarter, the middle and three quarters.
    Result<void> add_chords(const AxisPosition& from, const ProgrammedPose from_pose, const AxisPosition& to,
                            const ProgrammedPose& to_pose, int depth) {
        if (depth == deepest_halving || is_chord(from, from_pose, to, to_pose)) return push(to_pose);
        const AxisPosition middle = between(from, to, 0.5);
        ProgrammedPose middle_pose = pose_at(middle);
        middle_pose.kind = to_pose.kind;
        middle_pose.at_rapid = to_pose.at_rapid;
        middle_pose.line = to_pose.line;
        for (int r = 0; r < machine_.rotary_count; ++r)
            middle_pose.rotary_rad[r] = 0.5 * (from_pose.rotary_rad[r] + to_pose.rotary_rad[r]);
        if (auto first = add_chords(from, from_pose, middle, middle_pose, depth + 1); !first) return first;
        return add_chords(middle, middle_pose, to, to_pose, depth + 1);
    }

    static AxisPosition between(const AxisPosition& from, const AxisPosition& to, double share) {
        AxisPosition out;
        for (int i = 0; i < machine::max_axes; ++i) out[i] = from[i] + share * (to[i] - from[i]);
        return out;
    }

    bool is_chord(const AxisPosition& from, const ProgrammedPose& a, const AxisPosition& to,
                  const ProgrammedPose& b) const {
        for (int i = machine_.linear_count(); i < machine_.axis_count; ++i)
            if (std::abs(to[i] - from[i]) > 0.5) return false;
        for (const double share : {0.25, 0.5, 0.75}) {
            const ProgrammedPose seen = pose_at(between(from, to, share));
            const Eigen::Vector3d tip = a.tip_mm + share * (b.tip_mm - a.tip_mm);
            const Eigen::Vector3d axis = turned_in_plane(a.axis, b.axis, share);
            const Eigen::Vector3d off = seen.tip_mm - tip;
            if (off.norm() > chord_tolerance_mm) return false;
            if ((off + chord_height_mm * (seen.axis - axis)).norm() > chord_tolerance_mm) return false;
        }
        return true;
    }

    const program::Program& program_;
    const machine::Machine& machine_;
    const machine::Setup& setup_;
    Chain chain_;
    std::vector<int> rotary_of_word_;
    std::optional<std::string> first_tool_;
    std::vector<ProgrammedPose> poses_;
    double length_mm_ = 0;
    bool rotary_known_ = true;
};

}  // namespace

Result<std::vector<ProgrammedPose>> programmed_poses(const program::Program& program, const machine::Machine& machine,
                                                     const machine::Setup& setup) {
    return Expansion(program, machine, setup).run();
}

}  // namespace trunnion::verify
