#include "detail/programmed_line.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "detail/fault.hpp"
#include "detail/turning_in_plane.hpp"

namespace trunnion::verify {

namespace {

constexpr double chord_error_mm = 1e-3;
constexpr double most_turning_pieces = 1e6, most_straight_pieces = 2e6;
constexpr int most_refinements = 30;
constexpr double refined_mm = 1e-10;

/// The rotary words by which a segment turns; none where one of the poses has no word.
bool rotary_turn(const ProgrammedPose& from, const ProgrammedPose& to, const machine::Machine& machine,
                 machine::AxisPosition& turn) {
    bool any = false;
    for (int r = 0; r < machine.rotary_count; ++r) {
        if (std::isnan(from.rotary_rad[r]) || std::isnan(to.rotary_rad[r])) continue;
        turn[machine.linear_count() + r] = to.rotary_rad[r] - from.rotary_rad[r];
        any = any || to.rotary_rad[r] != from.rotary_rad[r];
    }
    return any;
}

ToolHeights tool_of(const ProgrammedPose& pose, const ToolHeights& otherwise) {
    return {std::isnan(pose.tool_length_mm) ? otherwise.length_mm : pose.tool_length_mm,
            std::isnan(pose.controlled_height_mm) ? otherwise.controlled_mm : pose.controlled_height_mm};
}

machine::AxisPosition rotary_position(const ProgrammedPose& pose, const machine::Machine& machine,
                                      const machine::Setup& setup) {
    machine::AxisPosition out;
    for (int r = 0; r < machine.rotary_count; ++r) {
        const int axis = machine.linear_count() + r;
        const auto start = setup.start.find(machine.axes[axis].letter);
        const double standing = start == setup.start.end() ? 0.0 : start->second;
        out[axis] = std::isnan(pose.rotary_rad[r]) ? standing : pose.rotary_rad[r];
    }
    return out;
}

}  // namespace

Result<ProgrammedLine> ProgrammedLine::make(const std::vector<ProgrammedPose>& poses, const machine::Machine& machine,
                                            const machine::Setup& setup, const Chain& chain, const ToolHeights& tool,
                                            double flank_mm, double longest_piece_mm) {
    ProgrammedLine line(poses, chain, flank_mm);
    line.longest_piece_mm_ = longest_piece_mm;
    line.limit_pieces();
    line.tools_.reserve(poses.size());
    for (const ProgrammedPose& pose : poses) line.tools_.push_back(tool_of(pose, tool));
    line.way_of_pose_.reserve(poses.size());
    line.segments_.reserve(poses.size());
    line.way_of_pose_.push_back(0);
    const std::size_t last = std::max<std::size_t>(1, poses.size() - 1);
    for (std::size_t n = 1; n <= last; ++n) {
        auto segment = line.segment_to(std::min(n, poses.size() - 1), machine, setup);
        if (!segment) return fail(segment.error());
        if (auto done = line.cut(*segment); !done) return fail(done.error());
        line.way_of_pose_.push_back(line.length_mm_);
    }
    if (line.pieces_.empty()) return fail(fault_at(0, "VER0302", "the programmed poses are changes of tool alone"));
    return line;
}

Result<ProgrammedLine::Segment> ProgrammedLine::segment_to(std::size_t pose, const machine::Machine& machine,
                                                           const machine::Setup& setup) const {
    const ProgrammedPose& to = (*poses_)[pose];
    const ProgrammedPose& from = (*poses_)[pose > 0 ? pose - 1 : 0];
    Segment out;
    out.at_rapid = to.at_rapid;
    out.tool = tools_[pose];
    if (pose > 0 && tools_[pose] != tools_[pose - 1]) {
        out.law = Law::standing;
    } else if (to.kind == PoseKind::rotary && rotary_turn(from, to, machine, out.turn)) {
        out.law = Law::rotary;
        out.from = rotary_position(from, machine, setup);
    } else if (opposite(from.axis, to.axis)) {
        return fail(fault_at(to.line, "VER0105", "the tool axis is turned by half a turn: the plane is undefined"));
    } else if (const double angle = angle_between(from.axis, to.axis); angle > 1e-12) {
        out.law = Law::plane;
        out.angle_rad = angle;
        out.across = (to.axis - to.axis.dot(from.axis) * from.axis).normalized();
    }
    return out;
}

double ProgrammedLine::turn_of(const Segment& segment) const {
    if (segment.law != Law::rotary) return segment.angle_rad;
    return std::accumulate(segment.turn.v.begin(), segment.turn.v.end(), 0.0,
                           [](double sum, double turn) { return sum + std::abs(turn); });
}

void ProgrammedLine::limit_pieces() {
    double way_mm = 0;
    for (std::size_t n = 1; n < poses_->size(); ++n) way_mm += ((*poses_)[n].tip_mm - (*poses_)[n - 1].tip_mm).norm();
    longest_piece_mm_ = std::max(longest_piece_mm_, way_mm / most_straight_pieces);
}

Result<void> ProgrammedLine::cut(Segment segment) {
    const std::size_t index = segments_.size();
    segment.first_piece = static_cast<std::uint32_t>(pieces_.size());
    segments_.push_back(segment);
    if (segment.law == Law::standing) return {};
    const double longest_rad = std::sqrt(8 * chord_error_mm / (flank_mm_ + std::abs(segment.tool.controlled_mm)));
    const double turning = std::ceil(turn_of(segment) / longest_rad);
    turning_pieces_ += turning;
    if (!(turning_pieces_ < most_turning_pieces + static_cast<double>(poses_->size())))
        return fail(fault_at((*poses_)[std::min(index + 1, poses_->size() - 1)].line, "VER0304",
                             "the rotary words turn too far for the path to be checked"));
    const double straight = std::ceil((at(index, 1).point - at(index, 0).point).norm() / longest_piece_mm_);
    const double count = std::max({1.0, turning, straight});
    segments_.back().pieces = static_cast<std::uint32_t>(count);
    Joint6 begin = at(index, 0).point;
    for (double n = 1; n <= count; ++n) {
        const Joint6 end = at(index, n / count).point;
        const Joint6 chord = end - begin;
        Piece& piece = pieces_.emplace_back();
        piece.begin = begin;
        piece.chord = chord;
        piece.chord2 = chord.squaredNorm();
        piece.way_mm = length_mm_;
        piece.tool = segment.tool;
        piece.segment = static_cast<std::uint32_t>(index);
        length_mm_ += chord.norm();
        begin = end;
    }
    return {};
}

ProgrammedLine::Sample ProgrammedLine::at(std::size_t index, double w) const {
    const Segment& segment = segments_[index];
    const ProgrammedPose& from = (*poses_)[index];
    const ProgrammedPose& to = (*poses_)[std::min(index + 1, poses_->size() - 1)];
    const Eigen::Vector3d way = to.tip_mm - from.tip_mm;
    Chain::Turning turning{to.axis, Eigen::Vector3d::Zero()};
    if (segment.law == Law::plane) {
        const double sine = std::sin(w * segment.angle_rad), cosine = std::cos(w * segment.angle_rad);
        turning = {cosine * from.axis + sine * segment.across,
                   segment.angle_rad * (cosine * segment.across - sine * from.axis)};
    } else if (segment.law == Law::rotary) {
        machine::AxisPosition position = segment.from;
        for (int i = 0; i < machine::max_axes; ++i) position[i] += w * segment.turn[i];
        turning = chain_->turning(position, segment.turn);
    }
    const Eigen::Vector3d tip = from.tip_mm + w * way;
    return {joint_of(tip, turning.axis, segment.tool, flank_mm_), joint_of(way, turning.rate, segment.tool, flank_mm_)};
}

Place ProgrammedLine::place_at(std::size_t segment, double w) const {
    const Segment& s = segments_[segment];
    const auto within = std::min<std::uint32_t>(s.pieces - 1, static_cast<std::uint32_t>(w * s.pieces));
    const Piece& piece = pieces_[s.first_piece + within];
    return {segment, w, piece.way_mm + (w * s.pieces - within) * std::sqrt(piece.chord2)};
}

Place ProgrammedLine::place_on_way(double way_mm) const {
    const auto after = std::upper_bound(pieces_.begin() + 1, pieces_.end(), way_mm,
                                        [](double way, const Piece& piece) { return way < piece.way_mm; });
    const Piece& piece = *(after - 1);
    const Segment& segment = segments_[piece.segment];
    const auto within = static_cast<double>(after - 1 - pieces_.begin() - segment.first_piece);
    const double length = std::sqrt(piece.chord2);
    const double share = length > 0 ? std::clamp((way_mm - piece.way_mm) / length, 0.0, 1.0) : 0.0;
    return place_at(piece.segment, std::min(1.0, (within + share) / segment.pieces));
}

double ProgrammedLine::nearest_share(const Gauge& row, std::size_t segment, double least, double most) const {
    const Joint6 point = joint_of(row, segments_[segment].tool, flank_mm_);
    double w = 0.5 * (least + most);
    for (int n = 0; n < most_refinements; ++n) {
        const Sample here = at(segment, w);
        const double speed2 = here.rate.squaredNorm();
        if (speed2 < 1e-24) return most;
        const double next = std::clamp(w + (point - here.point).dot(here.rate) / speed2, least, most);
        const double step_mm = std::abs(next - w) * std::sqrt(speed2);
        w = next;
        if (step_mm < refined_mm || segments_[segment].law == Law::straight) break;
    }
    return w;
}

Place ProgrammedLine::refine(const Gauge& row, std::size_t index) const {
    const Piece& piece = pieces_[index];
    const Segment& segment = segments_[piece.segment];
    const auto within = static_cast<double>(index - segment.first_piece);
    const double least = std::max(0.0, (within - 1) / segment.pieces), most = (within + 1) / segment.pieces;
    return place_at(piece.segment, nearest_share(row, piece.segment, least, most));
}

}  // namespace trunnion::verify
