#include "trunnion/pipeline/smooth_program.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "trunnion/nc/following.hpp"
#include "trunnion/path/path_builder.hpp"
#include "trunnion/path/rotary_stands.hpp"
#include "trunnion/smoothing/pole_tolerance.hpp"

#include "detail/smooth_program_path.hpp"
#include "detail/smooth_program_splines.hpp"

namespace trunnion::pipeline {

using Eigen::Vector3d;
using program::FeedRule;
using program::Move;
using program::MoveKind;
using program::OrientationLaw;
using program::Program;
using program::Space;

namespace {

/// Goes through the runs of a program and builds the smoothed one.
class ProgramSmoother {
  public:
    ProgramSmoother(const Program& program, const machine::Machine& machine, const machine::Setup& setup,
                    const smoothing::SmoothingOptions& tolerances, SmoothedForm form, const SmoothedShares& shares,
                    std::vector<program::RotaryStand> stands)
        : in_(program),
          machine_(machine),
          setup_(setup),
          tolerances_(tolerances),
          form_(form),
          shares_(shares),
          stands_(std::move(stands)) {}

    Result<SmoothedProgram> run() {
        auto builder = path::PathBuilder::make(in_, machine_, setup_, stands_);
        if (!builder) return fail(builder.error());
        Program& out = out_.program;
        out = in_;
        out.moves.clear();
        out.following.clear();
        new_place_.assign(in_.moves.size() + 1, 0);
        keep(0, 1);
        path::Run run, next;
        auto more = builder->next(run);
        while (more && *more) {
            auto behind = builder->next(next);
            if (!behind) return fail(behind.error());
            const std::size_t end = *behind ? next.first_move : in_.moves.size();
            keep(done_, run.first_move);
            if (auto taken = take(run, end); !taken) return fail(taken.error());
            std::swap(run, next);
            more = behind;
        }
        if (!more) return fail(more.error());
        keep(done_, in_.moves.size());
        new_place_.back() = out.moves.size();
        for (program::Event& event : out.events) event.before_move = new_place_[event.before_move];
        for (program::PathControl& control : out.path_controls) control.before_move = new_place_[control.before_move];
        return std::move(out_);
    }

  private:
    void keep(std::size_t from, std::size_t to) {
        for (std::size_t k = from; k < to; ++k) {
            new_place_[k] = out_.program.moves.size();
            out_.program.moves.push_back(in_.moves[k]);
            for (std::size_t i = 0; i < in_.following_letters.size(); ++i)
                out_.program.following.push_back(nc::following_at_end(in_, k, i));
        }
        if (to <= from) return;
        done_ = to;
        out_.kept_moves += to - from;
    }

    /// Whether there is something to smooth: several cutting moves along which the tool turns as the program says.
    bool is_to_smooth(const path::Run& run) const {
        if (run.rapid || run.space != Space::workpiece || run.blocks.size() < 2) return false;
        if (in_.moves[run.first_move].law != run.law) return false;  // the stands turn it otherwise
        return std::ranges::any_of(run.vertices, [&](const path::PathCoordinates& at) {
            return at.orientation != run.vertices.front().orientation;
        });
    }

    Result<void> take(const path::Run& run, std::size_t end) {
        if (!is_to_smooth(run)) {
            keep(run.first_move, end);
            return {};
        }
        std::vector<path::ToolPath> stretches;
        auto options = tolerances_;
        options.tip_tolerance_mm *= shares_.rounding;
        options.orientation_tolerance_rad *= shares_.rounding;
        options.flank_tolerance_mm *= shares_.rounding;
        options.controlled_height_mm = run.controlled_height_mm;
        smoothing::smooth(run, options, stretches);
        find_moves(run, end);
        begun_share_ = 0;
        const std::size_t before = out_.program.moves.size();
        const SmoothedProgram so_far{.written_moves = out_.written_moves,
                                     .tip_deviation_mm = out_.tip_deviation_mm,
                                     .orientation_deviation_rad = out_.orientation_deviation_rad};
        for (std::size_t k = 0; k < stretches.size(); ++k) {
            const bool last = k + 1 == stretches.size();
            block_behind_ = last ? run.blocks.size() : stretches[k + 1].blocks.front().run_block;
            if (auto put = put_stretch(stretches[k], run, last); !put) return put;
            begin_share_behind(stretches[k]);
        }
        const std::size_t points = out_.program.moves.size() - before;
        if (form_ == SmoothedForm::points && points >= end - run.first_move) {
            // Points on the rounding of a lone corner only hinder a control's own rounding.
            out_.program.moves.resize(before);
            out_.program.following.resize(before * in_.following_letters.size());
            out_.written_moves = so_far.written_moves;
            out_.tip_deviation_mm = so_far.tip_deviation_mm;
            out_.orientation_deviation_rad = so_far.orientation_deviation_rad;
            keep(run.first_move, end);
            return {};
        }
        // Blocks too short to be of the run, and places between points.
        std::size_t place = out_.program.moves.size();
        for (std::size_t k = end; k-- > run.first_move;) {
            if (new_place_[k] == unplaced) new_place_[k] = place;
            place = new_place_[k];
        }
        out_.smoothed_moves += end - run.first_move;
        done_ = end;
        return {};
    }

    /// The move of every block of a run, and which of them must begin at a point of their own.
    void find_moves(const path::Run& run, std::size_t end) {
        move_of_block_.clear();
        std::size_t move = run.first_move;
        for (const path::Block& block : run.blocks) {
            while (move + 1 < end && in_.moves[move].line != block.line) ++move;
            move_of_block_.push_back(move);
            ++move;
        }
        move_of_block_.push_back(end);
        std::fill(new_place_.begin() + static_cast<std::ptrdiff_t>(run.first_move),
                  new_place_.begin() + static_cast<std::ptrdiff_t>(end), unplaced);
    }

    const Move& move_of(const path::BlockSpan& span) const { return in_.moves[move_of_block_[span.run_block]]; }

    bool something_happens_before(std::size_t move) const {
        const auto event = std::ranges::lower_bound(in_.events, move, {}, &program::Event::before_move);
        if (event != in_.events.end() && event->before_move == move) return true;
        const auto control = std::ranges::lower_bound(in_.path_controls, move, {}, &program::PathControl::before_move);
        return control != in_.path_controls.end() && control->before_move == move;
    }

    /// Whether a block begins with a point of its own: another feed, another offset, an event.
    bool begins_with_point(const path::BlockSpan& span, const path::BlockSpan& before) const {
        const Move &to = move_of(span), &from = move_of(before);
        return changes_feed(span, before) || to.offset != from.offset ||
               something_happens_before(move_of_block_[span.run_block]) || starts_or_ends_following(span, before);
    }

    /// Turns keep their own rate. By time it is the speed that counts, and times are rounded.
    static bool changes_feed(const path::BlockSpan& span, const path::BlockSpan& before) {
        constexpr double same_speed = 0.05;
        if (span.feed.rule != before.feed.rule || span.feed.rule == FeedRule::rotary_rate) return true;
        if (span.feed.rule != FeedRule::block_time) return span.feed != before.feed;
        return std::abs(std::log(seconds_per_mm(span) / seconds_per_mm(before))) > same_speed;
    }

    static double seconds_per_mm(const path::BlockSpan& span) { return span.feed.value / span.time_scale_mm; }

    /// Whether a following axis goes along with one of two blocks alone.
    bool starts_or_ends_following(const path::BlockSpan& span, const path::BlockSpan& before) const {
        const auto goes = [&](const path::BlockSpan& block, std::size_t axis) {
            const std::size_t move = move_of_block_[block.run_block];
            return nc::following_at_end(in_, move, axis) != nc::following_at_begin(in_, move, axis);
        };
        for (std::size_t i = 0; i < in_.following_letters.size(); ++i)
            if (goes(span, i) != goes(before, i)) return true;
        return false;
    }

    Result<void> put_stretch(const path::ToolPath& path, const path::Run& run, bool last) {
        const StretchCurve curve(path, run);
        FitTolerance tolerance{.tip_mm = shares_.fitting * tolerances_.tip_tolerance_mm,
                               .orientation_rad = shares_.fitting * tolerances_.orientation_tolerance_rad,
                               .flank_mm = shares_.fitting * tolerances_.flank_tolerance_mm,
                               .flank_height_mm = tolerances_.flank_height_mm,
                               .controlled_height_mm = run.controlled_height_mm};
        FitDeviation deviation;
        std::vector<double> breaks;
        for (std::size_t k = 1; k < path.blocks.size(); ++k)
            if (begins_with_point(path.blocks[k], path.blocks[k - 1])) breaks.push_back(path.blocks[k].begin_mm);
        breaks.push_back(curve.length_mm());
        if (form_ == SmoothedForm::curves) {
            if (auto put = put_splines(curve, path, breaks, tolerance, deviation, last); !put) return put;
        } else {
            const auto ends = chord_ends(curve, breaks, tolerance, deviation);
            for (std::size_t k = 1; k < ends.size(); ++k)
                put_move(curve, path, ends[k - 1], ends[k], last && k + 1 == ends.size());
        }
        out_.tip_deviation_mm = std::max(out_.tip_deviation_mm, path.bound.tip_mm + deviation.tip_mm);
        out_.orientation_deviation_rad =
            std::max(out_.orientation_deviation_rad, path.bound.orientation_rad + deviation.orientation_rad);
        return {};
    }

    /// The block that a place belongs to.
    static const path::BlockSpan& span_at(const path::ToolPath& path, double p_mm) {
        auto above = std::ranges::upper_bound(path.blocks, p_mm, {}, &path::BlockSpan::begin_mm);
        if (above != path.blocks.begin()) --above;
        return *above;
    }

    /// A move from one place of the path to another, straight unless the caller makes it a part of a curve.
    Move& put_move(const StretchCurve& curve, const path::ToolPath& path, double from, double to, bool last) {
        const path::BlockSpan& span = span_at(path, 0.5 * (from + to));
        Move move = move_of(span);
        const Move& programmed_end = in_.moves[move_of_block_[move_of_block_.size() - 2]];
        for (std::size_t block = span.run_block + 1; block-- > 0;) {
            std::size_t& place = new_place_[move_of_block_[block]];
            if (place != unplaced) break;
            place = out_.program.moves.size();
        }
        move.arc = program::no_arc;
        move.curve_part = program::no_curve_part;
        const auto begin = curve.at(from), end = curve.at(to);
        set_pose(move, end, curve.by_vectors());
        if (last) {
            move.position_mm = programmed_end.position_mm.hasNaN() ? move.position_mm : programmed_end.position_mm;
            move.axis = programmed_end.axis;
            for (std::size_t i = 0; i < move.rotary_rad.size(); ++i)
                if (!std::isnan(programmed_end.rotary_rad[i])) move.rotary_rad[i] = programmed_end.rotary_rad[i];
        }
        move.exact_stop = last && programmed_end.exact_stop;
        move.feed = feed_of(span, begin, end, curve);
        if (span.feed.rule == FeedRule::block_time) move.feed.value = block_time_s(path, from, to);
        out_.program.moves.push_back(move);
        follow(path, to);
        ++out_.written_moves;
        return out_.program.moves.back();
    }

    /// The following axes at the end of a move that ends at `to_mm`: of every block of the program in proportion to p,
    /// and all of it where the block ends. Blocks without a span go along with the one before them.
    void follow(const path::ToolPath& path, double to_mm) {
        if (in_.following_letters.empty()) return;
        auto behind = std::ranges::lower_bound(path.blocks, to_mm, {}, &path::BlockSpan::begin_mm);
        if (behind == path.blocks.begin()) ++behind;
        const path::BlockSpan& span = *(behind - 1);
        const std::size_t next = behind == path.blocks.end() ? block_behind_ : behind->run_block;
        const double share = share_at(path, span, next, to_mm);
        const std::size_t first = move_of_block_[span.run_block];
        const std::size_t last = std::max(move_of_block_[next], first + 1) - 1;
        for (std::size_t i = 0; i < in_.following_letters.size(); ++i) {
            const double begin_mm = nc::following_at_begin(in_, first, i);
            const double end_mm = nc::following_at_end(in_, last, i) - nc::following_standing(in_, first + 1, last, i);
            out_.program.following.push_back(share < 1 ? begin_mm + share * (end_mm - begin_mm) : end_mm);
        }
    }

    /// Of a block of the program, till a place on one of its spans; `next` is the block of the span behind it.
    double share_at(const path::ToolPath& path, const path::BlockSpan& span, std::size_t next, double p_mm) const {
        const double begun = &span == path.blocks.data() ? begun_share_ : 0;
        const double ended = next == span.run_block ? share_behind(span, begun) : 1;
        const double within = std::clamp((p_mm - span.begin_mm) / (span.end_mm - span.begin_mm), 0.0, 1.0);
        return begun + within * (ended - begun);
    }

    /// A block that goes on in the next stretch.
    static double share_behind(const path::BlockSpan& span, double begun) {
        return std::min(begun + (span.end_mm - span.begin_mm) / span.time_scale_mm, 1.0);
    }

    void begin_share_behind(const path::ToolPath& path) {
        const path::BlockSpan& span = path.blocks.back();
        const double begun = path.blocks.size() == 1 ? begun_share_ : 0;
        begun_share_ = block_behind_ == span.run_block ? share_behind(span, begun) : 0;
    }

    const machine::Frame& offset_of(const Move& move) const {
        static const machine::Frame none;
        const auto found = setup_.offsets.find(in_.offsets[move.offset]);
        return found == setup_.offsets.end() ? none : found->second;
    }

    void set_pose(Move& move, const StretchCurve::Pose& pose, bool by_vectors) const {
        const machine::Frame& offset = offset_of(move);
        move.position_mm = offset.rotation.transpose() * (pose.tip_mm - offset.origin_mm);
        if (by_vectors) {
            move.axis = offset.rotation.transpose() * pose.orientation;
            return;
        }
        move.rotary_rad = words_of(pose.orientation);
    }

    /// Positions of the machine's rotary axes in the order of the program's letters.
    std::array<double, program::max_rotary_letters> words_of(const Vector3d& rotary) const {
        std::array<double, program::max_rotary_letters> out{};
        for (std::size_t i = 0; i < in_.rotary_letters.size(); ++i) {
            const int axis = machine_.index_of(in_.rotary_letters[i]) - machine_.linear_count();
            if (axis >= 0) out[i] = rotary[axis];
        }
        return out;
    }

    /// Of all blocks between two places, each by the share that lies there.
    static double block_time_s(const path::ToolPath& path, double from_mm, double to_mm) {
        double out = 0;
        for (const path::BlockSpan* span = &span_at(path, from_mm);
             span != path.blocks.data() + path.blocks.size() && span->begin_mm < to_mm; ++span)
            out += seconds_per_mm(*span) * (std::min(to_mm, span->end_mm) - std::max(from_mm, span->begin_mm));
        return out;
    }

    /// The speed that the block had; turns become the time of this part.
    static program::Feed feed_of(const path::BlockSpan& span, const StretchCurve::Pose& from,
                                 const StretchCurve::Pose& to, const StretchCurve& curve) {
        constexpr double still_mm = 1e-6;
        switch (span.feed.rule) {
            case FeedRule::rotary_rate: {
                const bool goes = (to.tip_mm - from.tip_mm).norm() > still_mm;
                const double turn = curve.by_vectors()
                                        ? std::acos(std::clamp(from.orientation.dot(to.orientation), -1.0, 1.0))
                                        : (to.orientation - from.orientation).norm();
                if (!goes || !(turn > 0)) return span.feed;
                return {FeedRule::block_time, turn / span.feed.value};
            }
            default:
                return span.feed;
        }
    }

    Result<void> put_splines(const StretchCurve& curve, const path::ToolPath& path, const std::vector<double>& breaks,
                             const FitTolerance& tolerance, FitDeviation& deviation, bool last) {
        double from = 0;
        // One curve to every change of the work offset, in which its control points count, and to every event.
        for (std::size_t k = 0; k < breaks.size(); ++k) {
            const bool ends = k + 1 == breaks.size();
            const Move& here = move_of(span_at(path, breaks[k] - 1e-12 * curve.length_mm()));
            const auto& behind = span_at(path, breaks[k]);
            const bool joins =
                here.offset == move_of(behind).offset && !something_happens_before(move_of_block_[behind.run_block]);
            if (!ends && joins) continue;
            const auto first = std::ranges::upper_bound(breaks, from);
            const std::vector<double> inside(first, breaks.begin() + static_cast<std::ptrdiff_t>(k));
            auto fitted = fit_spline(curve, from, breaks[k], inside, tolerance, deviation);
            if (!fitted) return fail(fitted.error());
            put_spline(curve, path, *fitted, here, last && ends);
            from = breaks[k];
        }
        return {};
    }

    void put_spline(const StretchCurve& curve, const path::ToolPath& path, const FittedSpline& fitted,
                    const Move& in_frame, bool last) {
        Program& out = out_.program;
        program::Curve written{.degree = 3, .knots = fitted.knots};
        const machine::Frame& offset = offset_of(in_frame);
        for (const auto& point : fitted.control) {
            written.position_mm.push_back(offset.rotation.transpose() * (point.tip_mm - offset.origin_mm));
            if (curve.by_vectors())
                written.axis.push_back(offset.rotation.transpose() * point.orientation);
            else
                written.rotary_rad.push_back(words_of(point.orientation));
        }
        const auto index = static_cast<std::int32_t>(out.curves.size());
        out.curves.push_back(std::move(written));
        for (std::size_t k = 3; k + 4 < fitted.knots.size(); ++k) {
            const double begin = fitted.knots[k], end = fitted.knots[k + 1];
            Move& move = put_move(curve, path, begin, end, last && k + 5 == fitted.knots.size());
            move.curve_part = static_cast<std::int32_t>(out.curve_parts.size());
            out.curve_parts.push_back({index, begin, end});
        }
    }

    static constexpr std::size_t unplaced = static_cast<std::size_t>(-1);

    const Program& in_;
    const machine::Machine& machine_;
    const machine::Setup& setup_;
    const smoothing::SmoothingOptions& tolerances_;
    SmoothedForm form_;
    SmoothedShares shares_;
    std::vector<program::RotaryStand> stands_;
    SmoothedProgram out_;
    std::size_t done_ = 0;
    std::vector<std::size_t> new_place_;      ///< of every move of the program
    std::vector<std::size_t> move_of_block_;  ///< of a run; behind it the first move that is not its own
    std::size_t block_behind_ = 0;            ///< of the stretch behind the one in work
    double begun_share_ = 0;                  ///< of a block that the stretch before began
};

}  // namespace

Result<SmoothedProgram> smooth_program(const Program& program, const machine::Machine& machine,
                                       const machine::Setup& setup, const smoothing::SmoothingOptions& tolerances,
                                       SmoothedForm form, const SmoothedShares& shares) {
    if (smoothing::follows_exactly(tolerances))
        return fail({.code = "PIPE0016",
                     .text = "a tolerance of 0, or no rounding, leaves nothing to smooth",
                     .hint = "--tip-tolerance and --orientation-tolerance above 0"});
    auto stands = path::choose_rotary_stands(program, machine, setup, smoothing::pole_tolerance_rad(tolerances));
    if (!stands) return fail(stands.error());
    return ProgramSmoother(program, machine, setup, tolerances, form, shares, std::move(*stands)).run();
}

}  // namespace trunnion::pipeline
