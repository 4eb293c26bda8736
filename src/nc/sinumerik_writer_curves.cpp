#include <algorithm>
#include <cmath>

#include "trunnion/base/quantity.hpp"

#include "detail/sinumerik_writer.hpp"

namespace trunnion::nc {

using Eigen::Vector3d;
using program::Curve;
using program::CurvePart;
using program::Move;
using program::OrientationLaw;

namespace {

constexpr int most_spline_degree = 3, most_polynomial_degree = 5;
constexpr double heaviest_point = 3;                                        // PW
constexpr double second_height_mm = 100;                                    // how far up the tool XH YH ZH lie at first
constexpr double least_second_height_mm = 20, most_second_height_mm = 500;  // how far they may come from there
constexpr double knot_precision = 1e-9;                                     // share
constexpr double coefficient_share = 0.1;                                   ///< of the precision: coefficients add up
constexpr int motion_of_poly = -2, motion_of_bspline = -3;
constexpr std::string_view linear_names[] = {"X", "Y", "Z"}, second_names[] = {"XH", "YH", "ZH"};

/// Whether the first and the last control points are the ends of the curve.
bool is_clamped(const Curve& curve) {
    const auto& knots = curve.knots;
    return knots.front() == knots[static_cast<std::size_t>(curve.degree)] &&
           knots.back() == knots[curve.position_mm.size()];
}

bool turns(const Move& from, const Move& to) {
    return from.law != to.law ||
           (to.law == OrientationLaw::vector ? from.axis != to.axis : from.rotary_rad != to.rotary_rad);
}

/// Whether the tool turns along these moves though the curve does not say how.
bool turns_by_itself(const program::Program& program, const Curve& curve, std::size_t first, std::size_t count) {
    const bool by_vector = program.moves[first].law == OrientationLaw::vector;
    if (!(by_vector ? curve.axis.empty() : curve.rotary_rad.empty())) return false;
    for (std::size_t k = first; k < first + count; ++k)
        if (turns(program.moves[k - 1], program.moves[k])) return true;
    return false;
}

const CurvePart& part_of(const program::Program& program, std::size_t move) {
    return program.curve_parts[static_cast<std::size_t>(program.moves[move].curve_part)];
}

/// Of one component of the control points, times their weights.
template <class Component>
std::vector<double> ordinates_of(const Curve& curve, const Component& component) {
    std::vector<double> out;
    for (std::size_t i = 0; i < curve.position_mm.size(); ++i)
        out.push_back(component(i) * (curve.weights.empty() ? 1 : curve.weights[i]));
    return out;
}

double largest_coordinate(const Curve& curve) {
    double largest = 1;
    for (const Vector3d& point : curve.position_mm) largest = std::max(largest, point.lpNorm<Eigen::Infinity>());
    return largest;
}

}  // namespace

std::size_t SinumerikWriter::curve(std::size_t first) {
    if (said_mm().hasNaN()) return 0;
    if (const std::size_t count = moves_of_bspline(first); count > 0) return bspline(first, count);
    return fits_poly(first) ? poly(first) : 0;
}

/// Where one form is asked for nothing else is written.
bool SinumerikWriter::curve_fits(const Move& to) {
    const bool asked = options_.curves == CurveForm::bspline || options_.curves == CurveForm::poly;
    if (!asked || index_ == 0 || to.curve_part == program::no_curve_part) return true;
    if (!said_mm().hasNaN() && (moves_of_bspline(index_) > 0 || fits_poly(index_))) return true;
    return refuse("NC0909", "a curve that does not fit into the form that is asked for", {},
                  "another form, or straight moves");
}

/// How many moves from here on are the whole of one curve that BSPLINE can say; 0: they are not.
std::size_t SinumerikWriter::moves_of_bspline(std::size_t first) const {
    const bool wanted = options_.curves == CurveForm::own || options_.curves == CurveForm::bspline;
    const Curve* const curve = curve_followed(program_, first);
    if (!wanted || options_.inverse_time || !curve || curve->degree > most_spline_degree || !is_clamped(*curve))
        return 0;
    const auto heavy = [](double weight) { return weight > heaviest_point; };
    if (std::ranges::any_of(curve->weights, heavy)) return 0;
    const std::size_t count = moves_along_curve(program_, first);
    const bool whole = count > 0 && part_of(program_, first).from_u == curve->knots.front() &&
                       part_of(program_, first + count - 1).to_u == curve->knots.back();
    return whole && !turns_by_itself(program_, *curve, first, count) ? count : 0;
}

/// One polynomial; a denominator bends X, Y and Z alone.
bool SinumerikWriter::fits_poly(std::size_t move) const {
    const bool wanted = options_.curves == CurveForm::own || options_.curves == CurveForm::poly;
    const Curve* const curve = curve_followed(program_, move);
    if (!wanted || options_.inverse_time || !curve || move == 0 || curve->degree > most_polynomial_degree) return false;
    const CurvePart& part = part_of(program_, move);
    const auto inside = [&](double u) { return part.from_u < u && u < part.to_u; };
    const bool one = std::ranges::none_of(curve->knots, inside);
    const bool rational_turn = !curve->weights.empty() && (!curve->axis.empty() || !curve->rotary_rad.empty());
    return one && !rational_turn && program_.moves[move].kind == program::MoveKind::feed;
}

// ---------------------------------------------------------------------------------------------------- second curve

/// A vector from which a curve with tool vectors begins is said as the second point of that curve.
std::string_view SinumerikWriter::mode_of(const Move& to) const {
    if (to.law == OrientationLaw::rotary) return "ORIAXES";
    return second_way(index_) || second_way(index_ + 1) ? "ORIWKS ORICURVE" : "ORIWKS ORIVECT";
}

/// From the tip to XH YH ZH where moves[move] begins a curve with tool vectors.
std::optional<Vector3d> SinumerikWriter::second_way(std::size_t move) const {
    const Curve* const curve = curve_followed(program_, move);
    if (!curve || curve->axis.empty()) return {};
    if (moves_of_bspline(move) > 0) return second_height_mm * curve->axis.front();
    if (!fits_poly(move)) return {};
    return second_height_mm * pose_at(*curve, part_of(program_, move).from_u).axis.normalized();
}

void SinumerikWriter::orientation_words(const Move& to) {
    const auto way = to.law == OrientationLaw::vector ? second_way(index_ + 1) : std::nullopt;
    if (!way) return GCodeWriter::orientation_words(to);
    second_words(goal_mm(), *way);
    second_said_ = index_;
}

void SinumerikWriter::second_words(const Vector3d& tip_mm, const Vector3d& way_mm) {
    const Vector3d second = (tip_mm + way_mm) / unit_mm();
    for (int i = 0; i < 3; ++i) {
        const std::int64_t steps = linear_grid_.steps(second[i]);
        word(second_names[i], linear_grid_, steps);
        second_mm_[i] = linear_grid_.value(steps) * unit_mm();
    }
}

bool SinumerikWriter::second_stands_at(std::size_t first) const {
    const Vector3d miss = second_mm_ - said_mm() - *second_way(first);
    return second_said_ + 1 == first && miss.lpNorm<Eigen::Infinity>() <= 2 * options_.precision_mm;
}

/// Where the tool stands, once more, as the start of both curves.
void SinumerikWriter::say_second_point(std::size_t first) {
    begin_block();
    motion_word(1);
    second_words(said_mm(), *second_way(first));
    if (aim(program_.moves[first])) feed_words(program_.moves[first], true);
    out_.end_line();
    second_said_ = first - 1;
}

/// What a vector of the curve is multiplied by, so that its second curve begins where the last one ended.
double SinumerikWriter::second_scale(std::size_t index, const Curve& piece) {
    const double start = piece.axis.front().norm(), end = piece.axis.back().norm();
    if (second_said_ + 1 == index) {
        const double scale = (second_mm_ - said_mm()).norm() / start;
        if (scale * end >= least_second_height_mm && scale * end <= most_second_height_mm) return scale;
    }
    say_second_point(index);
    return second_height_mm / start;
}

// --------------------------------------------------------------------------------------------------------- BSPLINE

/// Control points from the second on, PL=0 beside the ends, the spans between them in order.
std::size_t SinumerikWriter::bspline(std::size_t first, std::size_t count) {
    const Curve& curve = *curve_followed(program_, first);
    const Move& last = program_.moves[first + count - 1];
    if (!curve.axis.empty() && !second_stands_at(first))
        say_second_point(first);
    else if (motion_ == motion_of_bspline)
        line("G1");  // else that one would go on
    const auto degree = static_cast<std::size_t>(curve.degree), points = curve.position_mm.size();
    const std::size_t in_front = degree > 1 ? 1 : 0, spans = points - degree;
    std::size_t move = first;
    for (std::size_t b = 1; b < points; ++b) {
        const bool has_span = b > in_front && b <= in_front + spans;
        const std::size_t knot = degree + b - in_front - 1;
        const double length = has_span ? curve.knots[knot + 1] - curve.knots[knot] : 0;
        const Move& to = program_.moves[move];
        if (!aim(to)) return 0;
        begin_block();
        if (b + 1 == points) words_before_motion(last);
        if (b == 1) {
            plain("BSPLINE SD=");
            out_.integer(curve.degree);
        }
        control_words(curve, b, to);
        plain("PL=");
        out_.number_within(length / unit_mm(), knot_precision);
        if (!curve.weights.empty()) {
            plain("PW=");
            out_.number_within(curve.weights[b], knot_precision);
        }
        feed_words(to, true);
        out_.end_line();
        if (length > 0 && move + 1 < first + count) ++move;
    }
    motion_ = motion_of_bspline;
    if (!aim(last)) return 0;
    arrive(last);
    if (!curve.axis.empty()) second_said_ = first + count - 1;
    forget_axis();
    return count;
}

void SinumerikWriter::control_words(const Curve& curve, std::size_t point, const Move& to) {
    Vector3d written = curve.position_mm[point];
    for (int i = 0; i < 3; ++i) {
        const std::int64_t steps = linear_grid_.steps(written[i] / unit_mm());
        word(linear_names[i], linear_grid_, steps);
        written[i] = linear_grid_.value(steps) * unit_mm();
    }
    if (!curve.axis.empty()) second_words(written, second_height_mm * curve.axis[point]);
    if (to.law != OrientationLaw::rotary || curve.rotary_rad.empty()) return;
    for (std::size_t i = 0; i < program_.rotary_letters.size(); ++i)
        word({&program_.rotary_letters[i], 1}, rotary_grid_, rotary_grid_.steps(curve.rotary_rad[point][i] / degree));
}

// ------------------------------------------------------------------------------------------------------------ POLY

/// One polynomial of every axis, from p = 0 to 1.
std::size_t SinumerikWriter::poly(std::size_t index) {
    const Move& to = program_.moves[index];
    const CurvePart& part = part_of(program_, index);
    const Curve piece = part_of_curve(*curve_followed(program_, index), part.from_u, part.to_u);
    const double scale = piece.axis.empty() ? 1 : second_scale(index, piece);
    if (!aim(to)) return 0;
    begin_block();
    words_before_motion(to);
    if (motion_ != motion_of_poly) plain("POLY");
    motion_ = motion_of_poly;
    linear_polynomials(piece);
    if (!piece.weights.empty()) denominator(piece);
    if (!piece.axis.empty())
        second_polynomials(piece, scale);
    else if (!piece.rotary_rad.empty())
        rotary_polynomials(piece);
    else
        GCodeWriter::orientation_words(to);
    feed_words(to, true);
    out_.end_line();
    arrive(to);
    if (piece.axis.empty()) return 1;
    second_said_ = index;
    forget_axis();
    return 1;
}

/// PO[X]=(end,a2,a3…), from Bézier ordinates in the unit of the text.
void SinumerikWriter::polynomial(std::string_view axis, const DecimalGrid& grid, std::int64_t end,
                                 const DecimalGrid& coefficients, const std::vector<double>& ordinates) {
    const std::vector<double> power = power_coefficients(ordinates);
    std::size_t count = power.size();
    while (count > 2 && coefficients.steps(power[count - 1]) == 0) --count;
    plain("PO[");
    out_.put(axis);
    out_.put("]=(");
    out_.number(grid, end, habits_.numbers);
    for (std::size_t k = 2; k < count; ++k) {
        out_.put(',');
        out_.number(coefficients, coefficients.steps(power[k]), habits_.numbers);
    }
    out_.put(')');
}

void SinumerikWriter::linear_polynomials(const Curve& piece) {
    const DecimalGrid grid = DecimalGrid::within(coefficient_share * options_.precision_mm / unit_mm());
    for (std::size_t i = 0; i < 3; ++i) {
        const auto axis = static_cast<Eigen::Index>(i);
        polynomial(linear_names[i], linear_grid_, goal_.linear[i], grid,
                   ordinates_of(piece, [&](std::size_t k) { return piece.position_mm[k][axis] / unit_mm(); }));
    }
}

/// PO[]: 1 at the start. Its errors count as much as the coordinates are large.
void SinumerikWriter::denominator(const Curve& piece) {
    const DecimalGrid grid =
        DecimalGrid::within(std::clamp(coefficient_share * options_.precision_mm / largest_coordinate(piece), 1e-12,
                                       coefficient_share * options_.precision_mm));
    polynomial({}, grid, grid.steps(piece.weights.back()), grid, piece.weights);
}

void SinumerikWriter::rotary_polynomials(const Curve& piece) {
    const DecimalGrid grid = DecimalGrid::within(coefficient_share * options_.precision_deg);
    for (std::size_t i = 0; i < program_.rotary_letters.size(); ++i)
        polynomial({&program_.rotary_letters[i], 1}, rotary_grid_, goal_.rotary[i], grid,
                   ordinates_of(piece, [&](std::size_t k) { return piece.rotary_rad[k][i] / degree; }));
}

void SinumerikWriter::second_polynomials(const Curve& piece, double scale) {
    const DecimalGrid grid = DecimalGrid::within(coefficient_share * options_.precision_mm / unit_mm());
    for (int i = 0; i < 3; ++i) {
        const std::vector<double> ordinates = ordinates_of(
            piece, [&](std::size_t k) { return (piece.position_mm[k][i] + scale * piece.axis[k][i]) / unit_mm(); });
        const std::int64_t end = linear_grid_.steps(ordinates.back());
        polynomial(second_names[i], linear_grid_, end, grid, ordinates);
        second_mm_[i] = linear_grid_.value(end) * unit_mm();
    }
}

}  // namespace trunnion::nc
