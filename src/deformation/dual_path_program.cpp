#include "trunnion/deformation/dual_path_program.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "trunnion/geometry/great_circle.hpp"
#include "trunnion/geometry/helix.hpp"

#include "detail/pose_checks.hpp"
#include "detail/spline_equations.hpp"

namespace trunnion::deformation {

using Eigen::Vector3d;
using geometry::BsplineCurve;
using program::Move;
using program::Program;

namespace {

constexpr double arc_step_rad = std::numbers::pi / 36;
constexpr int places_of_part = 8;
constexpr int most_halvings = 20;

Pose end_of(const Move& move) {
    return {move.position_mm, move.axis};
}

bool is_cutting(const Move& move) {
    return move.kind == program::MoveKind::feed && move.space == program::Space::workpiece &&
           move.law == program::OrientationLaw::vector && move.position_mm.allFinite();
}

bool begins_at(const Move& start, const Move& move) {
    return start.space == program::Space::workpiece && start.law == program::OrientationLaw::vector &&
           start.position_mm.allFinite() && start.tool == move.tool && start.offset == move.offset;
}

bool event_before(const Program& program, std::size_t move) {
    const auto found = std::ranges::lower_bound(program.events, move, {}, &program::Event::before_move);
    return found != program.events.end() && found->before_move == move;
}

Diagnostic unsound(const Program& program, std::size_t move, const char* text) {
    return {.code = "DEFO0108",
            .text = text,
            .place = {.file = program.source, .line = program.moves[move].line},
            .hint = "straight moves in its place"};
}

/// Adds the places of one move behind its start.
class PosesOfMove {
  public:
    PosesOfMove(const Program& program, std::size_t move, std::vector<Pose>& out)
        : program_(program), move_(move), start_(end_of(program.moves[move - 1])), out_(out) {}

    Result<void> add() {
        const Move& move = program_.moves[move_];
        if (move.arc != program::no_arc) add_arc(move);
        if (move.curve_part != program::no_curve_part)
            if (auto added = add_curve(move); !added) return added;
        put(end_of(move));
        return {};
    }

  private:
    void put(const Pose& pose) {
        if (pose_step_mm(out_.back(), pose) >= rounding_mm) out_.push_back(pose);
    }

    void add_arc(const Move& move) {
        const program::Arc& arc = program_.arcs[static_cast<std::size_t>(move.arc)];
        const geometry::Helix helix(start_.tip_in_workpiece_mm, move.position_mm, arc.centre_mm, arc.normal,
                                    arc.angle_rad);
        const int parts = static_cast<int>(std::ceil(std::abs(arc.angle_rad) / arc_step_rad));
        for (int i = 1; i < parts; ++i) {
            const double w = static_cast<double>(i) / parts;
            put({helix.at(w), geometry::slerp(start_.axis_in_workpiece, move.axis, w)});
        }
    }

    Result<void> add_curve(const Move& move) {
        const auto& part = program_.curve_parts[static_cast<std::size_t>(move.curve_part)];
        const program::Curve& curve = program_.curves[static_cast<std::size_t>(part.curve)];
        const auto tip = BsplineCurve::make(curve.degree, curve.knots, curve.position_mm, curve.weights);
        if (!tip) return fail(unsound(program_, move_, "a curve of the program is not sound"));
        const auto axis =
            curve.axis.empty() ? tip : BsplineCurve::make(curve.degree, curve.knots, curve.axis, curve.weights);
        if (!axis) return fail(unsound(program_, move_, "a curve of the program is not sound"));
        for (int i = 1; i < places_of_part; ++i) {
            const double w = static_cast<double>(i) / places_of_part, u = part.from_u + w * (part.to_u - part.from_u);
            const Vector3d direction =
                curve.axis.empty() ? geometry::slerp(start_.axis_in_workpiece, move.axis, w) : axis->evaluate(u)[0];
            if (!(direction.norm() > unit_within))
                return fail(unsound(program_, move_, "the tool axis vanishes along a curve of the program"));
            put({tip->evaluate(u)[0], direction.normalized()});
        }
        return {};
    }

    const Program& program_;
    std::size_t move_;
    Pose start_;
    std::vector<Pose>& out_;
};

/// Builds a program anew, with curves in the place of stretches.
class Rebuilding {
  public:
    Rebuilding(const Program& program, const std::vector<ReplacedStretch>& replaced, std::optional<Chords> chords)
        : in_(program), replaced_(replaced), chords_(chords) {
        out_ = program;
        out_.moves.clear();
        out_.following.clear();
    }

    Program run() {
        auto next = replaced_.begin();
        for (std::size_t k = 0; k < in_.moves.size(); ++k) {
            if (next != replaced_.end() && k == next->stretch.first) {
                put_stretch(*next);
                k = next->stretch.last;
                ++next;
                continue;
            }
            place(k);
            out_.moves.push_back(in_.moves[k]);
            for (std::size_t f = 0; f < letters(); ++f) out_.following.push_back(followed(k, f));
        }
        place(in_.moves.size());
        return std::move(out_);
    }

  private:
    std::size_t letters() const { return in_.following_letters.size(); }
    double followed(std::size_t move, std::size_t letter) const { return in_.following[move * letters() + letter]; }

    /// What stood before a move of the program stands before the next one that is put.
    void place(std::size_t move) {
        const std::size_t here = out_.moves.size();
        for (; event_ < in_.events.size() && in_.events[event_].before_move <= move; ++event_)
            out_.events[event_].before_move = here;
        for (; control_ < in_.path_controls.size() && in_.path_controls[control_].before_move <= move; ++control_)
            out_.path_controls[control_].before_move = here;
    }

    void put_stretch(const ReplacedStretch& replaced) {
        const auto index = static_cast<std::int32_t>(out_.curves.size());
        if (!chords_) out_.curves.push_back(curve_of(replaced.path));
        const std::vector<double> at = places_of(replaced.path);
        std::size_t move = 0;  // of the stretch
        place(replaced.stretch.first);
        lead_to(replaced);
        for (std::size_t k = 0; k + 1 < at.size(); ++k) {
            const double middle = 0.5 * (at[k] + at[k + 1]);
            const std::size_t before = move;
            while (move + 1 < replaced.move_end_u.size() && replaced.move_end_u[move] <= middle) ++move;
            if (move != before) place(replaced.stretch.first + move);
            put_part(replaced, move, index, at[k], at[k + 1]);
        }
        out_.moves.back().exact_stop = in_.moves[replaced.stretch.last].exact_stop;
    }

    /// The move before ends where the path begins: a straight rapid goes there itself, behind others a short move does.
    void lead_to(const ReplacedStretch& replaced) {
        const Pose start = replaced.path.at(replaced.path.begin());
        const double gap_mm = pose_step_mm(end_of(out_.moves.back()), start);
        if (gap_mm < rounding_mm) return;
        const std::size_t first = replaced.stretch.first;
        const bool straight =
            out_.moves.back().arc == program::no_arc && out_.moves.back().curve_part == program::no_curve_part;
        const bool goes_itself =
            straight && (out_.moves.size() == 1 || out_.moves.back().kind == program::MoveKind::rapid);
        if (!goes_itself) {
            Move link = in_.moves[first];
            link.arc = program::no_arc;
            link.curve_part = program::no_curve_part;
            link.exact_stop = false;
            const double step_mm = pose_step_mm(end_of(in_.moves[first - 1]), end_of(in_.moves[first]));
            if (link.feed.rule == program::FeedRule::block_time) link.feed.value *= std::min(1.0, gap_mm / step_mm);
            out_.moves.push_back(link);
            for (std::size_t f = 0; f < letters(); ++f) out_.following.push_back(followed(first - 1, f));
        }
        out_.moves.back().position_mm = start.tip_in_workpiece_mm;
        out_.moves.back().axis = start.axis_in_workpiece;
    }

    std::vector<double> places_of(const DualPath& path) const {
        const std::vector<double> at = stations_of(path.spline.bottom().knots());
        if (!chords_) return at;
        std::vector<double> out{at.front()};
        for (std::size_t k = 0; k + 1 < at.size(); ++k) divide(path, at[k], at[k + 1], 0, out);
        return out;
    }

    /// Halves a piece until its middle and quarters lie near the chord.
    void divide(const DualPath& path, double from, double to, int halvings, std::vector<double>& out) const {
        const Pose a = path.at(from), b = path.at(to);
        bool near = true;
        for (const double w : {0.25, 0.5, 0.75}) {
            const Pose at = path.at(std::lerp(from, to, w));
            const Vector3d chord = a.tip_in_workpiece_mm + w * (b.tip_in_workpiece_mm - a.tip_in_workpiece_mm);
            near &= (at.tip_in_workpiece_mm - chord).norm() <= chords_->tip_mm &&
                    geometry::angle_between(at.axis_in_workpiece,
                                            geometry::slerp(a.axis_in_workpiece, b.axis_in_workpiece, w)) <=
                        chords_->axis_rad;
        }
        if (!near && halvings < most_halvings) {
            const double middle = 0.5 * (from + to);
            divide(path, from, middle, halvings + 1, out);
            divide(path, middle, to, halvings + 1, out);
            return;
        }
        out.push_back(to);
    }

    void put_part(const ReplacedStretch& replaced, std::size_t move, std::int32_t curve, double from, double to) {
        const Pose end = replaced.path.at(to);
        Move part = in_.moves[replaced.stretch.first + move];
        part.position_mm = end.tip_in_workpiece_mm;
        part.axis = end.axis_in_workpiece;
        part.exact_stop = false;
        part.arc = program::no_arc;
        part.curve_part = chords_ ? program::no_curve_part : static_cast<std::int32_t>(out_.curve_parts.size());
        const double begins = move == 0 ? replaced.path.begin() : replaced.move_end_u[move - 1];
        if (part.feed.rule == program::FeedRule::block_time)
            part.feed.value *= (to - from) / (replaced.move_end_u[move] - begins);
        if (!chords_) out_.curve_parts.push_back({curve, from, to});
        out_.moves.push_back(part);
        for (std::size_t f = 0; f < letters(); ++f) out_.following.push_back(following_at(replaced, f, to));
    }

    double following_at(const ReplacedStretch& replaced, std::size_t letter, double u) const {
        const auto& ends = replaced.move_end_u;
        const std::size_t move =
            std::min(static_cast<std::size_t>(std::ranges::lower_bound(ends, u) - ends.begin()), ends.size() - 1);
        const double from = move == 0 ? replaced.path.begin() : ends[move - 1];
        const double share = std::clamp((u - from) / (ends[move] - from), 0.0, 1.0);
        const std::size_t k = replaced.stretch.first + move;
        return std::lerp(followed(k - 1, letter), followed(k, letter), share);
    }

    const Program& in_;
    const std::vector<ReplacedStretch>& replaced_;
    std::optional<Chords> chords_;
    Program out_;
    std::size_t event_ = 0, control_ = 0;
};

}  // namespace

std::vector<CuttingStretch> cutting_stretches(const Program& program) {
    std::vector<CuttingStretch> out;
    for (std::size_t k = 1; k < program.moves.size(); ++k) {
        const Move &before = program.moves[k - 1], &move = program.moves[k];
        if (!is_cutting(move) || !begins_at(before, move)) continue;
        const bool goes_on =
            !out.empty() && out.back().last + 1 == k && !before.exact_stop && !event_before(program, k);
        if (goes_on)
            out.back().last = k;
        else
            out.push_back({k, k});
    }
    return out;
}

Result<StretchPoses> poses_of(const Program& program, const CuttingStretch& stretch) {
    StretchPoses out;
    out.poses.push_back(end_of(program.moves[stretch.first - 1]));
    for (std::size_t k = stretch.first; k <= stretch.last; ++k) {
        if (auto added = PosesOfMove(program, k, out.poses).add(); !added) return fail(added.error());
        out.move_end.push_back(out.poses.size() - 1);
    }
    return out;
}

Result<DualPath> dual_path_of(const Program& program, const CuttingStretch& stretch, double distance_mm) {
    const auto part_of = [&](std::size_t k) -> const program::CurvePart* {
        const std::int32_t part = program.moves[k].curve_part;
        return part == program::no_curve_part ? nullptr : &program.curve_parts[static_cast<std::size_t>(part)];
    };
    const program::CurvePart *first = part_of(stretch.first), *last = part_of(stretch.last);
    const auto refuse = [&] {
        return fail(unsound(program, stretch.first, "the moves are not one whole cubic dual spline"));
    };
    if (!first || !last || first->curve != last->curve) return refuse();
    const program::Curve& curve = program.curves[static_cast<std::size_t>(first->curve)];
    if (curve.degree != 3 || curve.axis.size() != curve.position_mm.size() || !curve.weights.empty()) return refuse();
    std::vector<Vector3d> top;
    for (std::size_t i = 0; i < curve.axis.size(); ++i) top.push_back(curve.position_mm[i] + curve.axis[i]);
    auto bottom = BsplineCurve::make(3, curve.knots, curve.position_mm);
    auto above = BsplineCurve::make(3, curve.knots, std::move(top));
    if (!bottom || !above || first->from_u != bottom->begin() || last->to_u != bottom->end()) return refuse();
    auto spline = geometry::DualSpline::make(std::move(*bottom), std::move(*above));
    if (!spline) return refuse();
    return DualPath{std::move(*spline), distance_mm};
}

program::Curve curve_of(const DualPath& path) {
    const BsplineCurve &bottom = path.spline.bottom(), &top = path.spline.top();
    program::Curve out{.degree = bottom.degree(), .knots = bottom.knots(), .position_mm = bottom.control_points_mm()};
    for (std::size_t i = 0; i < out.position_mm.size(); ++i)
        out.axis.push_back(top.control_points_mm()[i] - out.position_mm[i]);
    return out;
}

Program with_dual_paths(const Program& program, const std::vector<ReplacedStretch>& replaced,
                        std::optional<Chords> chords) {
    return Rebuilding(program, replaced, chords).run();
}

}  // namespace trunnion::deformation
