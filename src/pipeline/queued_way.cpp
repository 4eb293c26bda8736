#include "detail/queued_way.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "trunnion/path/path_builder.hpp"
#include "trunnion/path/rotary_stands.hpp"
#include "trunnion/smoothing/smoothing.hpp"

namespace trunnion::pipeline {

namespace {

constexpr double nothing_mm = 1e-7, nothing_rad = 1e-9;

double turn_between(const QueuedPose& a, const QueuedPose& b) {
    double out = 0;
    for (std::size_t i = 0; i < a.rotary_rad.size(); ++i) out += std::abs(a.rotary_rad[i] - b.rotary_rad[i]);
    return out;
}

double way_of(const QueuedPose& begin, const QueuedMove& move) {
    double way = (move.end.tip_mm - begin.tip_mm).norm();
    if (move.arc) {
        const Eigen::Vector3d arm = begin.tip_mm - move.arc->centre_mm;
        way = std::hypot(move.arc->angle_rad * move.arc->normal.cross(arm).norm(),
                         move.arc->normal.dot(move.end.tip_mm - begin.tip_mm));
    }
    return way + path::reference_height_mm * turn_between(begin, move.end);
}

/// What the stretches of one smoothing point to.
struct Holder {
    program::Program program;
    std::vector<program::RotaryStand> stands;
    std::optional<path::PathBuilder> builder;
};

}  // namespace

QueuedWay::QueuedWay(const machine::Machine& machine, double tool_length_mm, const QueuedPose& begin,
                     const PlanOptions& options)
    : machine_(&machine), options_(options), begin_(begin) {
    setup_.tool.length_mm = tool_length_mm;
}

/// A move that leads nowhere is none.
void QueuedWay::add(const QueuedMove& move) {
    const double way = way_of(end(), move);
    const bool moves =
        move.arc || (move.end.tip_mm - end().tip_mm).norm() > nothing_mm || turn_between(move.end, end()) > nothing_rad;
    if (!moves) return;
    moves_.push_back(move);
    way_mm_.push_back(way);
}

std::size_t QueuedWay::index_of(std::int32_t number) const {
    const auto found = std::lower_bound(moves_.begin(), moves_.end(), number,
                                        [](const QueuedMove& move, std::int32_t n) { return move.number < n; });
    return static_cast<std::size_t>(found - moves_.begin());
}

std::size_t QueuedWay::moves_behind(std::int32_t number) const {
    return moves_.size() - index_of(number + 1);
}

double QueuedWay::way_behind_mm(std::int32_t number) const {
    double way = 0;
    for (std::size_t k = index_of(number + 1); k < moves_.size(); ++k) way += way_mm_[k];
    return way;
}

std::int32_t QueuedWay::before(std::int32_t number, std::size_t moves, double way_mm) const {
    std::size_t k = index_of(number);
    for (double way = 0; k > 0 && (moves > 0 || way < way_mm); --k) {
        way += way_mm_[k - 1];
        moves -= moves > 0;
    }
    return k < moves_.size() ? moves_[k].number : number;
}

void QueuedWay::drop_before(std::int32_t number) {
    const std::size_t count = std::min(index_of(number), moves_.empty() ? 0 : moves_.size() - 1);
    if (count == 0) return;
    begin_ = moves_[count - 1].end;
    moves_.erase(moves_.begin(), moves_.begin() + static_cast<std::ptrdiff_t>(count));
    way_mm_.erase(way_mm_.begin(), way_mm_.begin() + static_cast<std::ptrdiff_t>(count));
}

double QueuedWay::tolerance_of(const QueuedMove& move) const {
    return move.tip_tolerance_mm > 0 ? move.tip_tolerance_mm : options_.smoothing.tip_tolerance_mm;
}

bool QueuedWay::stands_between(const QueuedMove& move, const QueuedMove& next) const {
    return move.exact_stop || next.stop_first || tolerance_of(move) != tolerance_of(next);
}

program::Program QueuedWay::program_of(std::size_t first, std::size_t end) const {
    program::Program out;
    for (int i = machine_->linear_count(); i < machine_->axis_count; ++i)
        out.rotary_letters.push_back(machine_->axes[i].letter);
    const auto add = [&out](const QueuedPose& pose) -> program::Move& {
        program::Move& move = out.moves.emplace_back();
        move.position_mm = pose.tip_mm;
        move.law = program::OrientationLaw::rotary;
        std::ranges::copy(pose.rotary_rad, move.rotary_rad.begin());
        return move;
    };
    add(begin_of(first));
    for (std::size_t k = first; k < end; ++k) {
        const QueuedMove& from = moves_[k];
        program::Move& move = add(from.end);
        move.feed = from.feed;
        move.kind = from.rapid ? program::MoveKind::rapid : program::MoveKind::feed;
        move.exact_stop = k + 1 < moves_.size() ? stands_between(from, moves_[k + 1]) : from.exact_stop;
        move.line = from.number;
        if (!from.arc) continue;
        move.arc = static_cast<std::int32_t>(out.arcs.size());
        out.arcs.push_back(*from.arc);
    }
    return out;
}

std::int32_t QueuedWay::behind(std::int32_t number, std::size_t moves) const {
    const std::size_t index = index_of(number + 1) + moves;
    return index <= moves_.size() && index > 0 ? moves_[index - 1].number : last_number();
}

Result<std::vector<Leg>> QueuedWay::legs_of(std::int32_t first, std::int32_t last) const {
    std::vector<Leg> out;
    const std::size_t index = index_of(first), end = index_of(last + 1);
    if (index >= end) return out;
    const auto holder = std::make_shared<Holder>();
    holder->program = program_of(index, end);
    auto stands = path::choose_rotary_stands(holder->program, *machine_, setup_);
    if (!stands) return fail(stands.error());
    holder->stands = std::move(*stands);
    auto builder = path::PathBuilder::make(holder->program, *machine_, setup_, holder->stands);
    if (!builder) return fail(builder.error());
    holder->builder.emplace(std::move(*builder));
    for (path::Run run;;) {
        const auto more = holder->builder->next(run);
        if (!more) return fail(more.error());
        if (!*more) return out;
        auto options = options_.smoothing;
        options.tip_tolerance_mm = tolerance_of(moves_[index_of(run.blocks.front().line)]);
        std::vector<path::ToolPath> stretches;
        smoothing::smooth(run, options, stretches);
        for (path::ToolPath& tool_path : stretches) {
            Leg leg{.first = tool_path.blocks.front().line, .last = tool_path.blocks.back().line};
            auto stretch = Stretch::make(std::move(tool_path), *machine_, {}, holder);
            if (!stretch) return fail(stretch.error());
            leg.stretch = std::move(*stretch);
            out.push_back(std::move(leg));
        }
        const bool is_last = run.blocks.back().line == moves_[end - 1].number;
        out.back().open = is_last && !run.rapid && !holder->program.moves.back().exact_stop;
    }
}

}  // namespace trunnion::pipeline
