#include "trunnion/verify/programmed_path.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <utility>

#include <Eigen/LU>
#include <fmt/format.h>

#include "detail/chain.hpp"
#include "detail/fault.hpp"
#include "detail/position_way.hpp"
#include "detail/turning_in_plane.hpp"

namespace trunnion::verify {

namespace {

using machine::AxisPosition;
using program::Move;
using program::MoveKind;
using program::OrientationLaw;
using program::Space;

constexpr int deepest_cut = 40;
constexpr double longest_turn_of_chord_rad = 0.5;
constexpr double part_margin = 1.002;  // parts are a little shorter than they need be, so that they pass at once

/// Positions of the machine's rotary axes.
using Rotary = std::array<double, machine::max_rotary_axes>;

Rotary between(const Rotary& from, const Rotary& to, double share) {
    Rotary out;
    for (std::size_t r = 0; r < out.size(); ++r) out[r] = from[r] + share * (to[r] - from[r]);
    return out;
}

/// Where positions of a space lie: the tip in the workpiece, or the linear axes.
struct Placement {
    Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
    Eigen::Vector3d shift = Eigen::Vector3d::Zero();
    Eigen::Vector3d of(const Eigen::Vector3d& position) const { return turn * position + shift; }
    Eigen::Vector3d position_of(const Eigen::Vector3d& place) const { return turn.partialPivLu().solve(place - shift); }
};

/// The exact way of one move.
struct Leg {
    PositionWay way;
    Placement placement;
    bool in_machine = false;  // the placement gives the linear axes
    bool by_axes = false;     // the rotary axes go linearly; else the tool axis turns in a plane
    Rotary from{}, to{};
    Eigen::Vector3d axis_from, axis_to;
    std::array<int, machine::max_rotary_axes> word{-1, -1};   // of the curve, by rotary axis
    Eigen::Matrix3d axis_turn = Eigen::Matrix3d::Identity();  // from the work offset

    bool says_axis() const { return !by_axes && way.curve() && way.curve()->says_axis(); }
    bool says_rotary() const { return by_axes && way.curve() && way.curve()->says_rotary() && word != no_words; }
    double turn_rad() const {
        double out = way.curve() ? turn_of_curve_rad : std::abs(way.turn_rad());
        for (std::size_t r = 0; by_axes && r < from.size(); ++r) out = std::max(out, std::abs(to[r] - from[r]));
        return out;
    }
    /// What a curve's axis and words are off the ends of the move is spread along the way.
    Eigen::Vector3d axis_at(double w) const {
        if (!says_axis()) return turned_in_plane(axis_from, axis_to, w);
        const auto said = [&](double share) { return (axis_turn * way.curve()->axis(share)).normalized().eval(); };
        return (said(w) + (1 - w) * (axis_from - said(0)) + w * (axis_to - said(1))).normalized();
    }
    Rotary rotary_at(double w) const {
        Rotary out = between(from, to, w);
        if (!says_rotary()) return out;
        const auto there = way.curve()->rotary_rad(w), first = way.curve()->rotary_rad(0),
                   last = way.curve()->rotary_rad(1);
        for (std::size_t r = 0; r < out.size(); ++r) {
            if (word[r] < 0) continue;
            const auto k = static_cast<std::size_t>(word[r]);
            out[r] += there[k] - (1 - w) * first[k] - w * last[k];
        }
        return out;
    }
    /// Whether what a curve says of the orientation is where the move begins and ends.
    bool fits_ends() const {
        double off = 0;
        for (const double w : {0.0, 1.0}) {
            if (says_axis()) {
                const Eigen::Vector3d said = axis_turn * way.curve()->axis(w);
                if (!(said.norm() > 0)) return false;
                off = std::max(off, angle_between(said.normalized(), w == 0 ? axis_from : axis_to));
            }
            for (std::size_t r = 0; r < from.size() && says_rotary(); ++r)
                if (word[r] >= 0)
                    off = std::max(off, std::abs(way.curve()->rotary_rad(w)[static_cast<std::size_t>(word[r])] -
                                                 (w == 0 ? from[r] : to[r])));
        }
        return off <= PositionWay::off_curve_mm / chord_height_mm;
    }

    static constexpr std::array<int, machine::max_rotary_axes> no_words{-1, -1};
    static constexpr double turn_of_curve_rad = 4;  // one span: eight parts to begin with
};

/// Walks through the moves and keeps where the tool is.
class Expansion {
  public:
    Expansion(const program::Program& program, const machine::Machine& machine, const machine::Setup& setup,
              std::span<const program::RotaryStand> stands, const std::optional<Rotary>& standing)
        : program_(program),
          machine_(machine),
          setup_(setup),
          stands_(stands),
          standing_(standing),
          chain_(machine, setup.workpiece) {}

    Result<std::vector<ProgrammedPose>> run() {
        if (program_.moves.empty()) return fail(diagnose(0, "VER0101", "the program has no moves"));
        if (!stands_.empty() && stands_.size() != program_.moves.size())
            return fail(diagnose(0, "VER0110", "there is not one stand for each move"));
        if (auto known = find_words(); !known) return fail(known.error());
        find_stops();
        for (std::size_t n = 0; n < program_.moves.size(); ++n)
            if (auto added = add(n); !added) return fail(added.error());
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

    /// After which moves the program asks for standstill.
    void find_stops() {
        const auto& moves = program_.moves;
        stops_after_.assign(moves.size(), false);
        for (std::size_t n = 0; n < moves.size(); ++n)
            stops_after_[n] = moves[n].exact_stop || moves[n].kind == MoveKind::rapid || n == 0 ||
                              n + 1 == moves.size() || moves[n + 1].kind == MoveKind::rapid;
        for (const program::Event& event : program_.events)
            if (event.stops_motion && event.before_move > 0 && event.before_move <= moves.size())
                stops_after_[event.before_move - 1] = true;
    }

    Result<void> add(std::size_t n) {
        const Move& move = program_.moves[n];
        const bool open = poses_.empty() ? move.position_mm.array().isNaN().any() : false;
        if (open || move.position_mm.array().isInf().any())
            return fail(diagnose(move.line, "VER0108", "a coordinate is not finite"));
        const auto tool = tool_of(move);
        if (!tool) return fail(tool.error());
        take_tool(**tool, move.line);
        const auto frame = offset(move);
        if (!frame) return fail(frame.error());
        const auto rotary = rotary_at_end(n, *frame);
        if (!rotary) return fail(rotary.error());
        const auto placement = placement_of(move, *frame);
        if (!placement) return fail(placement.error());
        const auto position = end_of(move, *placement);
        if (!position) return fail(position.error());
        ProgrammedPose pose = end_pose(n, placement->of(*position), *rotary, *frame);
        if (auto pushed = add_way_to(pose, n, *position, *placement, *rotary); !pushed) return pushed;
        rotary_ = *rotary;
        return {};
    }

    Result<const machine::Tool*> tool_of(const Move& move) {
        const std::string& name = program_.tools[move.tool];
        if (name.empty()) return &setup_.tool;
        if (const auto* found = setup_.tool_named(name)) return found;
        if (!first_tool_) first_tool_ = name;
        if (setup_.tools.empty() && *first_tool_ == name) return &setup_.tool;
        return fail(diagnose(move.line, "VER0103", fmt::format("tool {} is not in the setup", name),
                             fmt::format("add [tools.\"{}\"] to the setup file", name)));
    }

    /// The machine stands still while the tool is changed: the new tip is elsewhere on the same axis.
    void take_tool(const machine::Tool& tool, std::int32_t line) {
        const double before = std::exchange(length_mm_, tool.length_mm);
        const double height = std::exchange(controlled_height_mm_, tool.controlled_height_mm());
        if (before != length_mm_) untransformed_.reset();
        if (poses_.empty() || (before == length_mm_ && height == controlled_height_mm_)) return;
        poses_.back().stands = true;
        ProgrammedPose pose = poses_.back();
        pose.tip_mm += (before - length_mm_) * pose.axis;
        pose.tool_length_mm = length_mm_;
        pose.controlled_height_mm = controlled_height_mm_;
        pose.line = line;
        poses_.push_back(pose);
    }

    Result<machine::Frame> offset(const Move& move) const {
        const std::string& name = program_.offsets[move.offset];
        if (const auto found = setup_.offsets.find(name); found != setup_.offsets.end()) return found->second;
        if (name.empty() || name == "G54") return machine::Frame{};
        return fail(diagnose(move.line, "VER0104", fmt::format("work offset {} is not in the setup", name),
                             fmt::format("add [offsets.\"{}\"] to the setup file", name)));
    }

    AxisPosition axes_of(const Rotary& rotary) const {
        AxisPosition out;
        for (int r = 0; r < machine_.rotary_count; ++r) out[machine_.linear_count() + r] = rotary[r];
        return out;
    }

    // Where the rotary axes stand

    bool turned_by_words(const Move& move) const {
        return move.law == OrientationLaw::rotary && !program_.rotary_letters.empty();
    }

    /// At the end of a move; empty where neither words nor stands tell.
    Result<std::optional<Rotary>> rotary_at_end(std::size_t n, const machine::Frame& frame) const {
        const Move& move = program_.moves[n];
        if (auto sound = check_stand(n); !sound) return fail(sound.error());
        return move.law == OrientationLaw::vector ? rotary_of_vector(n, frame) : rotary_of_words(n);
    }

    Result<void> check_stand(std::size_t n) const {
        if (stands_.empty()) return {};
        const Move& move = program_.moves[n];
        for (int r = 0; r < machine_.rotary_count; ++r)
            if (!std::isfinite(stands_[n].rotary_rad[r]))
                return fail(diagnose(move.line, "VER0108", "a stand of the rotary axes is not finite"));
        if (!stands_[n].rebranched) return {};
        const bool by_vectors = n > 0 && move.law == OrientationLaw::vector && move.space == Space::workpiece;
        const bool keeps_axis = by_vectors && angle_between(chain_.gauge(axes_of(stands_[n].rotary_rad)).axis,
                                                            poses_.back().axis) <= stand_axis_tolerance_rad;
        if (!by_vectors || (move.kind != MoveKind::rapid && !keeps_axis))
            return fail(diagnose(move.line, "VER0110",
                                 "only by tool vectors, on rapids or where the tool keeps its direction, may the axes "
                                 "go to another branch"));
        return {};
    }

    Result<std::optional<Rotary>> rotary_of_vector(std::size_t n, const machine::Frame& frame) const {
        const Move& move = program_.moves[n];
        if (!(move.axis.norm() > 1e-9) || !move.axis.allFinite())
            return fail(diagnose(move.line, "VER0108", "the tool axis has no direction"));
        if (machine_.rotary_count == 0) return Rotary{};
        if (stands_.empty()) return std::optional<Rotary>{};
        const Rotary& stand = stands_[n].rotary_rad;
        const Eigen::Vector3d wanted = (frame.rotation * move.axis).normalized();
        const double off = angle_between(chain_.gauge(axes_of(stand)).axis, wanted);
        if (off <= stand_axis_tolerance_rad) return stand;
        auto fault = diagnose(move.line, "VER0110", "the rotary axes do not stand at the programmed tool axis");
        fault.value = fmt::format("{} rad", off);
        fault.limit = fmt::format("{} rad", stand_axis_tolerance_rad);
        return fail(std::move(fault));
    }

    Result<std::optional<Rotary>> rotary_of_words(std::size_t n) const {
        const Move& move = program_.moves[n];
        Rotary out;
        out.fill(std::numeric_limits<double>::quiet_NaN());
        for (std::size_t w = 0; w < rotary_of_word_.size(); ++w) out[rotary_of_word_[w]] = move.rotary_rad[w];
        for (int r = 0; r < machine_.rotary_count; ++r) {
            if (std::isinf(out[r])) return fail(diagnose(move.line, "VER0108", "a rotary word is not finite"));
            if (!std::isnan(out[r])) continue;
            const auto standing = standing_at(r);
            if (!standing) return fail(unknown_rotary(move));
            out[r] = *standing;
        }
        for (int r = 0; r < machine_.rotary_count && !stands_.empty(); ++r) {
            if (std::abs(stands_[n].rotary_rad[r] - out[r]) <= stand_word_tolerance_rad) continue;
            auto fault = diagnose(move.line, "VER0110", "the rotary axes do not stand where the program says");
            fault.value = fmt::format("{} rad", stands_[n].rotary_rad[r]);
            fault.limit = fmt::format("{} rad", out[r]);
            return fail(std::move(fault));
        }
        return out;
    }

    Diagnostic unknown_rotary(const Move& move) const {
        return diagnose(move.line, "VER0106",
                        "a move by rotary axes or in machine coordinates after tool vectors needs to know where the "
                        "rotary axes stand");
    }

    /// Where a rotary axis stands before the move that is being added.
    std::optional<double> standing_at(int rotary) const {
        if (!poses_.empty()) return rotary_ ? std::optional((*rotary_)[rotary]) : std::nullopt;
        if (standing_) return (*standing_)[rotary];
        const auto start = setup_.start.find(machine_.axes[machine_.linear_count() + rotary].letter);
        return start == setup_.start.end() ? 0.0 : start->second;
    }

    // Where positions lie

    Diagnostic no_space(const Move& move) const {
        return diagnose(move.line, "VER0107", "the linear axes of the machine do not span space");
    }

    Result<Placement> placement_of(const Move& move, const machine::Frame& frame) {
        if (move.space == Space::workpiece) return Placement{frame.rotation, frame.origin_mm};
        if (move.space == Space::machine) return Placement{};
        if (untransformed_ && untransformed_offset_ == move.offset) return *untransformed_;
        const Eigen::Vector3d up = length_mm_ * chain_.gauge({}).axis;
        const auto linear_for = [&](const Eigen::Vector3d& position) {
            return chain_.with_gauge_at(frame.rotation * position + frame.origin_mm + up, {});
        };
        const auto zero = linear_for(Eigen::Vector3d::Zero());
        if (!zero) return fail(no_space(move));
        Placement out;
        out.shift = Eigen::Vector3d(zero->v.data());
        for (int i = 0; i < 3; ++i)
            out.turn.col(i) = Eigen::Vector3d(linear_for(Eigen::Vector3d::Unit(i))->v.data()) - out.shift;
        untransformed_ = out;
        untransformed_offset_ = move.offset;
        return out;
    }

    /// The present place of the machine in the coordinates of a move.
    Result<Eigen::Vector3d> start_of(const Move& move, const Placement& placement) const {
        const ProgrammedPose& last = poses_.back();
        if (move.space == Space::workpiece) return placement.position_of(last.tip_mm);
        if (!rotary_) return fail(unknown_rotary(move));
        const auto axes = chain_.with_gauge_at(last.tip_mm + length_mm_ * last.axis, axes_of(*rotary_));
        if (!axes) return fail(no_space(move));
        return placement.position_of(Eigen::Vector3d(axes->v.data()));
    }

    Result<Eigen::Vector3d> end_of(const Move& move, const Placement& placement) const {
        if (!move.position_mm.array().isNaN().any()) return move.position_mm;
        const auto start = start_of(move, placement);
        if (!start) return start;
        Eigen::Vector3d out = move.position_mm;
        for (int i = 0; i < 3; ++i)
            if (std::isnan(out[i])) out[i] = (*start)[i];
        return out;
    }

    // Poses

    ProgrammedPose end_pose(std::size_t n, const Eigen::Vector3d& place, const std::optional<Rotary>& rotary,
                            const machine::Frame& frame) const {
        const Move& move = program_.moves[n];
        ProgrammedPose out;
        out.at_rapid = move.kind == MoveKind::rapid;
        out.literal = turned_by_words(move);
        out.stands = stops_after_[n];
        out.line = move.line;
        out.tool_length_mm = length_mm_;
        out.controlled_height_mm = controlled_height_mm_;
        out.kind = out.at_rapid ? PoseKind::rapid : PoseKind::vector;
        if (move.space != Space::workpiece) {
            if (rotary) set_pose(out, linear_at(place, *rotary), *rotary);
            return out;
        }
        out.tip_mm = place;
        if (move.law == OrientationLaw::vector)
            out.axis = (frame.rotation * move.axis).normalized();
        else
            out.axis = chain_.gauge(axes_of(*rotary)).axis;
        if (!by_axes(n)) return out;
        out.kind = PoseKind::rotary;
        out.rotary_rad = *rotary;
        return out;
    }

    bool by_axes(std::size_t n) const {
        const Move& move = program_.moves[n];
        return turned_by_words(move) || move.space != Space::workpiece || (!stands_.empty() && stands_[n].rebranched);
    }

    AxisPosition linear_at(const Eigen::Vector3d& linear, const Rotary& rotary) const {
        AxisPosition out = axes_of(rotary);
        for (int i = 0; i < std::min(3, machine_.linear_count()); ++i) out[i] = linear[i];
        return out;
    }

    void set_pose(ProgrammedPose& pose, const AxisPosition& axes, const Rotary& rotary) const {
        const Gauge gauge = chain_.gauge(axes);
        pose.tip_mm = gauge.tip_mm(length_mm_);
        pose.axis = gauge.axis;
        std::copy_n(rotary.begin(), machine_.rotary_count, pose.rotary_rad.begin());
    }

    /// All poses from the last one to `pose`, which ends move n.
    Result<void> add_way_to(const ProgrammedPose& pose, std::size_t n, const Eigen::Vector3d& position,
                            const Placement& placement, const std::optional<Rotary>& rotary) {
        const Move& move = program_.moves[n];
        if (by_axes(n) && !rotary) return fail(unknown_rotary(move));
        if (poses_.empty()) return push(pose);
        if (by_axes(n) && !rotary_) return fail(unknown_rotary(move));
        if (pose.kind == PoseKind::rotary) poses_.back().rotary_rad = *rotary_;
        const bool straight = move.arc == program::no_arc && move.curve_part == program::no_curve_part;
        if (move.space == Space::workpiece && straight) return push(pose);
        const auto way = way_of(move, position, placement);
        if (!way) return fail(way.error());
        Leg leg{.way = *way, .placement = placement, .axis_from = poses_.back().axis, .axis_to = pose.axis};
        leg.in_machine = move.space != Space::workpiece;
        leg.by_axes = by_axes(n);
        if (leg.by_axes) leg.from = *rotary_, leg.to = *rotary;
        if (way->curve()) {
            leg.axis_turn = offset(move)->rotation;
            for (std::size_t w = 0; w < rotary_of_word_.size() && turned_by_words(move); ++w)
                leg.word[static_cast<std::size_t>(rotary_of_word_[w])] = static_cast<int>(w);
            if (!leg.fits_ends() || (leg.in_machine && move.law == OrientationLaw::vector && way->curve()->says_axis()))
                return fail(no_curve(move.line));
        }
        if (!leg.by_axes && !leg.says_axis() && opposite(leg.axis_from, leg.axis_to))
            return fail(half_a_turn(move.line));
        return add_chords(leg, 0, poses_.back(), 1, pose, 0);
    }

    Result<PositionWay> way_of(const Move& move, const Eigen::Vector3d& end, const Placement& placement) {
        const auto start = start_of(move, placement);
        if (!start) return fail(start.error());
        if (move.curve_part != program::no_curve_part) return along_curve(move, *start, end);
        if (move.arc == program::no_arc) return PositionWay::straight(*start, end);
        if (move.arc >= 0 && static_cast<std::size_t>(move.arc) < program_.arcs.size())
            if (const auto round = PositionWay::round(*start, end, program_.arcs[static_cast<std::size_t>(move.arc)]))
                return *round;
        return fail(diagnose(move.line, "VER0111", "the arc has no radius or direction, or does not lead to its end"));
    }

    Result<PositionWay> along_curve(const Move& move, const Eigen::Vector3d& start, const Eigen::Vector3d& end) {
        const program::Curve* curve = CurveCourse::curve_of(program_, move);
        if (!curve || move.arc != program::no_arc) return fail(no_curve(move.line));
        if (curve != sound_curve_ && !CurveCourse::is_curve(*curve, program_.rotary_letters.size()))
            return fail(no_curve(move.line));
        sound_curve_ = curve;
        const auto course = CurveCourse::make(program_, move);
        if (!course) return fail(no_curve(move.line));
        const auto way = PositionWay::along(start, end, *course);
        if (!way) return fail(no_curve(move.line));
        return *way;
    }

    Diagnostic no_curve(std::int32_t line) const {
        return diagnose(line, "VER0112",
                        "there is no such part of a curve, or it does not lead to the end of its move");
    }

    ProgrammedPose pose_at(const Leg& leg, double w, const ProgrammedPose& end) const {
        ProgrammedPose out = end;
        out.stands = out.literal = false;
        const Eigen::Vector3d place = leg.placement.of(leg.way.at(w));
        const Rotary rotary = leg.rotary_at(w);
        if (leg.in_machine) {
            set_pose(out, linear_at(place, rotary), rotary);
            return out;
        }
        out.tip_mm = place;
        out.axis = leg.by_axes ? chain_.gauge(axes_of(rotary)).axis : leg.axis_at(w);
        if (leg.by_axes) out.rotary_rad = rotary;
        return out;
    }

    /// Cuts into equal parts until the exact way is within the chord tolerance at a quarter, the middle and three
    /// quarters of each.
    Result<void> add_chords(const Leg& leg, double from, const ProgrammedPose from_pose, double to,
                            const ProgrammedPose& to_pose, int depth) {
        const double parts = parts_of(leg, from, from_pose, to, to_pose);
        if (!(parts <= most_programmed_poses)) return fail(too_many_poses(to_pose.line));
        if (parts == 1 || depth == deepest_cut) return push(to_pose);
        ProgrammedPose begin = from_pose;
        double begin_share = from;
        for (double n = 1; n <= parts; ++n) {
            const double share = n == parts ? to : from + n / parts * (to - from);
            const ProgrammedPose end = n == parts ? to_pose : pose_at(leg, share, to_pose);
            if (auto added = add_chords(leg, begin_share, begin, share, end, depth + 1); !added) return added;
            begin = end;
            begin_share = share;
        }
        return {};
    }

    /// Into how many parts a stretch of a leg should be cut: 1 where it is as good as its chord.
    double parts_of(const Leg& leg, double from, const ProgrammedPose& a, double to, const ProgrammedPose& b) const {
        const double turn = (to - from) * leg.turn_rad();
        if (!(turn <= longest_turn_of_chord_rad)) return std::ceil(turn / longest_turn_of_chord_rad);
        double error = 0;
        for (const double share : {0.25, 0.5, 0.75}) {
            const ProgrammedPose seen = pose_at(leg, from + share * (to - from), b);
            const Eigen::Vector3d off = seen.tip_mm - a.tip_mm - share * (b.tip_mm - a.tip_mm);
            const bool exact_axis = b.kind == PoseKind::rotary && !leg.says_rotary();
            const Eigen::Vector3d axis = exact_axis ? seen.axis : axis_between(leg, a, b, share);
            error = std::max({error, off.norm(), (off + chord_height_mm * (seen.axis - axis)).norm()});
        }
        if (error <= chord_tolerance_mm) return 1;
        return std::max(2.0, std::ceil(part_margin * std::sqrt(error / chord_tolerance_mm)));
    }

    /// The tool axis on the chord from one pose to another.
    Eigen::Vector3d axis_between(const Leg& leg, const ProgrammedPose& a, const ProgrammedPose& b, double share) const {
        if (b.kind != PoseKind::rotary || !leg.says_rotary()) return turned_in_plane(a.axis, b.axis, share);
        return chain_.gauge(axes_of(between(a.rotary_rad, b.rotary_rad, share))).axis;
    }

    Diagnostic half_a_turn(std::int32_t line) const {
        return diagnose(line, "VER0105", "the tool axis is turned by half a turn: the plane is undefined");
    }

    Diagnostic too_many_poses(std::int32_t line) const {
        return diagnose(line, "VER0109", "the program has too many poses to be checked");
    }

    Result<void> push(const ProgrammedPose& pose) {
        if (!poses_.empty() && pose.kind != PoseKind::rotary && opposite(poses_.back().axis, pose.axis))
            return fail(half_a_turn(pose.line));
        if (poses_.size() >= most_programmed_poses) return fail(too_many_poses(pose.line));
        poses_.push_back(pose);
        return {};
    }

    const program::Program& program_;
    const machine::Machine& machine_;
    const machine::Setup& setup_;
    std::span<const program::RotaryStand> stands_;
    const std::optional<Rotary>& standing_;
    Chain chain_;
    std::vector<int> rotary_of_word_;
    std::vector<bool> stops_after_;
    std::optional<std::string> first_tool_;
    std::vector<ProgrammedPose> poses_;
    double length_mm_ = 0, controlled_height_mm_ = 0;
    std::optional<Rotary> rotary_;            // where the rotary axes stand, if that is known
    std::optional<Placement> untransformed_;  // of the tool in use
    std::uint16_t untransformed_offset_ = 0;
    const program::Curve* sound_curve_ = nullptr;  // the last one that was looked at
};

}  // namespace

Result<std::vector<ProgrammedPose>> programmed_poses(const program::Program& program, const machine::Machine& machine,
                                                     const machine::Setup& setup,
                                                     std::span<const program::RotaryStand> stands,
                                                     const std::optional<Rotary>& standing) {
    return Expansion(program, machine, setup, stands, standing).run();
}

}  // namespace trunnion::verify
