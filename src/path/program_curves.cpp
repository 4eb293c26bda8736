#include "detail/program_curves.hpp"

#include <algorithm>
#include <span>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "detail/surroundings.hpp"

namespace trunnion::path::detail {

using geometry::BezierPiece;
using geometry::BsplineCurve;
using program::Curve;
using program::CurvePart;
using program::Move;

namespace {

constexpr int most_halvings = 20;

bool is_index(std::int32_t index, std::size_t size) {
    return index >= 0 && static_cast<std::size_t>(index) < size;
}

/// The words as a point; letters that the program has not count 0.
std::vector<Eigen::Vector3d> points_of(const std::vector<std::array<double, program::max_rotary_letters>>& words,
                                       std::size_t letters) {
    std::vector<Eigen::Vector3d> out;
    out.reserve(words.size());
    for (const auto& at : words) {
        Eigen::Vector3d point = Eigen::Vector3d::Zero();
        for (std::size_t k = 0; k < std::min(letters, at.size()); ++k) point[static_cast<Eigen::Index>(k)] = at[k];
        out.push_back(point);
    }
    return out;
}

/// A spline over the knots of a curve with other control points.
Result<BsplineCurve> spline(const Curve& curve, std::vector<Eigen::Vector3d> points) {
    return BsplineCurve::make(curve.degree, curve.knots, std::move(points), curve.weights);
}

/// Whether a direction is proved to be nowhere 0: its control points lie on one side, part by part.
bool has_direction(const BezierPiece& axis, int depth = 0) {
    if (axis.chord_turn() < 1) return true;
    if (depth == most_halvings || !(axis.at(0.5).norm() > 0)) return false;
    return has_direction(axis.part(0, 0.5), depth + 1) && has_direction(axis.part(0.5, 1), depth + 1);
}

/// Returns how far the ends were off.
double fit_ends(BezierPiece& piece, const Eigen::Vector3d& start, const Eigen::Vector3d& end) {
    const double off = std::max((piece.at(0) - start).norm(), (piece.at(1) - end).norm());
    piece.fit_ends(start, end);
    return off;
}

}  // namespace

Result<void> fit_ends(CurvePiece& curve, const CurveEnd& from, const CurveEnd& to, bool vectors,
                      const program::Program& program, const Move& move) {
    constexpr double off_curve_mm = 1e-3;
    const auto apart = [&](const char* what, double off, const char* unit) {
        auto out_of_place = at_move(program, move, "PATH0124",
                                    fmt::format("the {} of the curve does not begin or end as that of its move", what));
        out_of_place.value = fmt::format("{:.6g} {}", off, unit);
        return fail(std::move(out_of_place));
    };
    if (const double off_mm = fit_ends(curve.position, from.position_mm, to.position_mm); !(off_mm <= off_curve_mm))
        return apart("position", off_mm, "mm");
    if (!curve.orientation) return {};
    BezierPiece& orientation = *curve.orientation;
    const double from_length = vectors ? orientation.at(0).norm() : 1,
                 to_length = vectors ? orientation.at(1).norm() : 1;
    const double off = fit_ends(orientation, from_length * from.orientation, to_length * to.orientation);
    const double off_rad = off / std::min(from_length, to_length);
    if (!(off_rad <= off_curve_mm / reference_height_mm)) return apart("orientation", off_rad, "rad");
    return {};
}

/// Takes the splines of a move's curve into use. Precondition: the curve exists.
Result<void> ProgramCurves::take(const Move& move) {
    const std::int32_t index = program_->curve_parts[static_cast<std::size_t>(move.curve_part)].curve;
    if (index == splines_.curve) return {};
    const Curve& curve = program_->curves[static_cast<std::size_t>(index)];
    const auto none = [&](const std::string& why) {
        return fail(at_move(*program_, move, "PATH0122", fmt::format("the curve is none: {}", why)));
    };
    Splines out;
    out.curve = index;
    const auto make = [&](std::optional<BsplineCurve>& made, std::vector<Eigen::Vector3d> points) -> Result<void> {
        auto spline_of_points = spline(curve, std::move(points));
        if (!spline_of_points) return none(spline_of_points.error().text);
        made = std::move(*spline_of_points);
        return {};
    };
    if (auto made = make(out.position, curve.position_mm); !made) return made;
    if (!curve.axis.empty())
        if (auto made = make(out.axis, curve.axis); !made) return made;
    if (!curve.rotary_rad.empty())
        if (auto made = make(out.rotary, points_of(curve.rotary_rad, program_->rotary_letters.size())); !made)
            return made;
    splines_ = std::move(out);
    return {};
}

Result<void> ProgramCurves::check(const Move& move) {
    const auto refuse = [&](const char* code, std::string text) {
        return fail(at_move(*program_, move, code, std::move(text)));
    };
    const bool known =
        is_index(move.curve_part, program_->curve_parts.size()) &&
        is_index(program_->curve_parts[static_cast<std::size_t>(move.curve_part)].curve, program_->curves.size());
    if (!known) return refuse("PATH0121", "the move follows a part of a curve that does not exist");
    if (move.arc != program::no_arc) return refuse("PATH0121", "the move follows an arc and a curve at once");
    if (auto taken = take(move); !taken) return taken;
    const CurvePart& part = program_->curve_parts[static_cast<std::size_t>(move.curve_part)];
    const BsplineCurve& curve = *splines_.position;
    if (!(part.from_u < part.to_u && part.from_u >= curve.begin() && part.to_u <= curve.end()))
        return refuse("PATH0123", fmt::format("the part from {} to {} is empty, or outside of its curve, {} to {}",
                                              part.from_u, part.to_u, curve.begin(), curve.end()));
    const auto [begin, end] = curve.interval_at(0.5 * (part.from_u + part.to_u));
    if (part.from_u < begin || part.to_u > end)
        return refuse("PATH0123", fmt::format("the part from {} to {} goes over a knot", part.from_u, part.to_u));
    if (move.law == OrientationLaw::rotary || !splines_.axis) return {};
    if (move.space != Space::workpiece)
        return refuse("PATH0125", "the curve says the tool's direction, but its positions are those of the axes");
    if (!has_direction(splines_.axis->piece(part.from_u, part.to_u)))
        return refuse("PATH0125", "the tool axis that the curve says vanishes on the way");
    return {};
}

Result<void> ProgramCurves::check() {
    const std::span<const Move> moves = program_->moves;
    if (!moves.empty() && moves.front().curve_part != program::no_curve_part)
        return fail(
            at_move(*program_, moves.front(), "PATH0121", "the first pose is not a motion: it follows no curve"));
    for (const Move& move : moves)
        if (move.curve_part != program::no_curve_part)
            if (auto sound = check(move); !sound) return sound;
    return {};
}

CurvePiece ProgramCurves::part(const Move& move) {
    static_cast<void>(take(move));  // has been checked
    const CurvePart& part = program_->curve_parts[static_cast<std::size_t>(move.curve_part)];
    CurvePiece out{.position = splines_.position->piece(part.from_u, part.to_u), .orientation = std::nullopt};
    const auto& orientation = move.law == OrientationLaw::vector ? splines_.axis : splines_.rotary;
    if (orientation) out.orientation = orientation->piece(part.from_u, part.to_u);
    return out;
}

}  // namespace trunnion::path::detail
