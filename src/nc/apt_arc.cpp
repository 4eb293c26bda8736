#include <cmath>
#include <numbers>
#include <vector>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "detail/apt_reader.hpp"
#include "detail/arcs.hpp"

namespace trunnion::nc {

using Eigen::Vector3d;
using program::Arc;

namespace {

constexpr double whole_turn = 2 * std::numbers::pi, half_turn = std::numbers::pi;
/// CL data has four decimals, in inches too.
constexpr ArcTolerance cl_data_arcs{0.01, 1e-3, 0.5, 0.01};
constexpr double angle_slack_rad = 1e-3;   ///< what an angle may be off besides what the points are
constexpr double smallest_vector = 1e-9;   ///< a vector shorter than this has no direction
constexpr double least_along_way = 1e-3;   ///< INDIRV must have this share along the circle to tell the sense
constexpr std::size_t circle_numbers = 7;  ///< centre, normal, radius
constexpr std::size_t most_numbers = 11;   ///< tolerance, its share inside, tool diameter, corner radius

double allowed_mm(double radius_mm) {
    return std::min(cl_data_arcs.most_mm, std::max(cl_data_arcs.least_mm, cl_data_arcs.share * radius_mm));
}

/// What two directions from the centre may be off by because their points are.
double angle_tolerance(double radius_mm) {
    return angle_slack_rad + 2 * allowed_mm(radius_mm) / radius_mm;
}

bool are_same_direction(double angle, double other, double tolerance) {
    return std::abs(std::remainder(angle - other, whole_turn)) <= tolerance;
}

/// Signed about the normal, in (−half a turn, half a turn].
double shorter_way(const Arc& arc) {
    return arc.angle_rad > half_turn ? arc.angle_rad - whole_turn : arc.angle_rad;
}

/// Words and numbers of APT source, whatever brackets, slashes and commas stand between them.
std::vector<std::string_view> tokens_of(std::string_view text) {
    std::vector<std::string_view> out;
    while (!text.empty()) {
        const std::size_t end = std::min(text.find_first_of("(),/"), text.size());
        if (const std::string_view token = trimmed(text.substr(0, end)); !token.empty()) out.push_back(token);
        text.remove_prefix(std::min(end + 1, text.size()));
    }
    return out;
}

}  // namespace

/// CIRCLE/x,y,z,i,j,k,r. With more numbers behind (tolerances and tool, as NX writes) one GOTO ends the arc, which
/// turns in the right-hand sense about i,j,k. With seven (as Creo writes) all GOTO that follow at once and lie on the
/// circle are of it: one alone in the right-hand sense, several each by the shorter way from the one before.
bool AptReader::circle() {
    return wait_for_end(true);
}

/// MOVARC/x,y,z,i,j,k,r[,ANGLE,degrees] or [,TIMES,turns]: one GOTO ends it. Right-hand sense about i,j,k; where only
/// the other sense fits the angle, that one.
bool AptReader::arc_ahead() {
    return wait_for_end(false);
}

bool AptReader::wait_for_end(bool is_circle) {
    if (circle_ || program_.moves.empty())
        return refuse("NC0415", program_.moves.empty() ? "a circle from a place that is not known"
                                                       : "a circle where another one waits for the GOTO that ends it");
    Numbers given;
    WaitingCircle circle;
    for (std::string_view list = scanner_.arguments(); !list.empty();) {
        const std::string_view item = take_item(list);
        const bool label = (given.count == 0 && is_word(item, {"CENTER"})) ||
                           (given.count == 3 && is_word(item, {"AXIS"})) ||
                           (given.count == 6 && is_word(item, {"RADIUS"}));
        if (label) continue;
        const bool says_more = given.count >= circle_numbers && !circle.sweep_rad;
        const bool angle = says_more && is_word(item, {"ANGLE", "TIMES"});
        const auto value = number_of(angle ? take_item(list) : item);
        if (!value && !angle && !item.empty() && is_letter(item.front()))
            return findings_.refuse("NC0412", scanner_.spot(item), "not understood in a circle", item,
                                    "ANGLE and TIMES are; let the CAM system put out points instead");
        if (!value)
            return findings_.refuse("NC0201", scanner_.spot(item), "no finite number where one is expected", item);
        if (angle)
            circle.sweep_rad = *value * (is_word(item, {"TIMES"}) ? whole_turn : degree);
        else if (given.count == most_numbers)
            return refuse("NC0401", "too many numbers");
        else
            given.value[given.count++] = *value;
    }
    if (given.count < circle_numbers || (!is_circle && given.count > circle_numbers))
        return refuse("NC0401", fmt::format("{} numbers, a circle has centre, normal and radius", given.count));
    circle.centre_mm = point_mm(given.triple(0));
    circle.radius_mm = given.value[6] * unit_mm_;
    const double length = given.triple(3).norm();
    if (!(length > smallest_vector) || !std::isfinite(length)) return refuse("NC0402", "a normal without direction");
    circle.normal = direction(given.triple(3) / length);
    if (!circle.centre_mm.allFinite() || !std::isfinite(circle.radius_mm))
        return refuse("NC0201", "the circle is not finite in mm");
    circle.by_points = is_circle && given.count == circle_numbers && !circle.sweep_rad;
    circle_ = circle;
    return true;
}

bool AptReader::is_on_circle(const Vector3d& point_mm) const {
    const Vector3d arm = point_mm - circle_->centre_mm;
    const double radius = arm.cross(circle_->normal).norm();
    return std::abs(radius - circle_->radius_mm) <= allowed_mm(circle_->radius_mm);
}

/// A GOTO behind a circle. Ends the circle unless it goes by points.
bool AptReader::add_on_circle(const Vector3d& end_mm) {
    if (rapid_next_) return refuse("NC0416", "a circle at rapid");
    if (circle_->points > 0) return add_point_of_circle(end_mm);
    const Vector3d start_mm = program_.moves.back().position_mm;
    for (const Vector3d& point_mm : {start_mm, end_mm})
        if (!is_on_circle(point_mm))
            return findings_.refuse(
                scanner_.spot(), {.code = "NC0207",
                                  .text = "a circle whose radius does not fit its ends",
                                  .value = fmt::format("{:.6g} mm from the centre",
                                                       (point_mm - circle_->centre_mm).cross(circle_->normal).norm()),
                                  .limit = fmt::format("{:.6g} mm within {:.4g} mm", circle_->radius_mm,
                                                       allowed_mm(circle_->radius_mm))});
    auto arc = arc_by_centre(start_mm, end_mm, circle_->centre_mm, circle_->normal, false, 0, cl_data_arcs);
    if (!arc) return findings_.refuse(scanner_.spot(), std::move(arc.error()));
    if (circle_->sweep_rad && !take_angle(start_mm, end_mm, *arc)) return false;
    circle_->points = 1;
    circle_->turned_rad = shorter_way(*arc);
    const bool good = add_move(end_mm, false, &*arc);
    if (!circle_->by_points) circle_.reset();
    return good;
}

/// Gives an arc of less than a turn in the right-hand sense the turns and the sense that the ANGLE of its record says.
bool AptReader::take_angle(const Vector3d& start_mm, const Vector3d& end_mm, Arc& arc) {
    const double sweep = *circle_->sweep_rad, tolerance = angle_tolerance(circle_->radius_mm);
    const bool right_hand = sweep > 0 && are_same_direction(sweep, arc.angle_rad, tolerance);
    const bool left_hand = are_same_direction(-std::abs(sweep), arc.angle_rad, tolerance);
    if (!right_hand && !left_hand)
        return findings_.refuse(
            "NC0414", scanner_.spot(), "the ANGLE of a circle does not fit its ends",
            fmt::format("{:.6g} deg", sweep / degree),
            fmt::format("from its start to this GOTO it turns by {:.6g} deg", arc.angle_rad / degree));
    if (!right_hand) arc = *arc_by_centre(start_mm, end_mm, arc.centre_mm, arc.normal, true, 0, cl_data_arcs);
    const double turns = std::max(0.0, std::round((std::abs(sweep) - std::abs(arc.angle_rad)) / whole_turn));
    arc.angle_rad += std::copysign(whole_turn * turns, arc.angle_rad);
    return true;
}

/// The second and later ones of the points of a circle. The first of them tells that the circle goes by points, so that
/// the arc before it is taken by the shorter way too.
bool AptReader::add_point_of_circle(const Vector3d& end_mm) {
    const Vector3d start_mm = program_.moves.back().position_mm;
    const double climb = (end_mm - start_mm).dot(circle_->normal);
    if (!is_on_circle(end_mm) || std::abs(climb) > allowed_mm(circle_->radius_mm)) {
        circle_.reset();
        return add_move(end_mm, false);
    }
    if (end_mm == start_mm) return add_move(end_mm, false);
    if (circle_->points == 1) program_.arcs.back().angle_rad = circle_->turned_rad;
    const bool clockwise = circle_->turned_rad < 0;
    const auto arc = arc_by_centre(start_mm, end_mm, circle_->centre_mm, circle_->normal, clockwise, 0, cl_data_arcs);
    if (!arc) return findings_.refuse(scanner_.spot(), Diagnostic(arc.error()));
    circle_->turned_rad += arc->angle_rad;
    ++circle_->points;
    const double tolerance = angle_tolerance(circle_->radius_mm);
    if (std::abs(arc->angle_rad) > half_turn + tolerance || std::abs(circle_->turned_rad) > whole_turn + tolerance)
        return refuse("NC0414", "the points on a circle do not follow one another in one sense within one turn",
                      "put a statement, FEDRAT say, between the end of the circle and what follows");
    return add_move(end_mm, false, &*arc);
}

bool AptReader::initial_direction() {
    Numbers vector;
    if (!numbers(vector, false)) return false;
    if (vector.count != 3) return refuse("NC0401", fmt::format("{} numbers, a direction has 3", vector.count));
    const double length = vector.triple(0).norm();
    if (!(length > smallest_vector) || !std::isfinite(length)) return refuse("NC0402", "a vector without direction");
    direction_ = direction(vector.triple(0) / length);
    return true;
}

/// TLON,GOFWD/(CIRCLE/x,y,z,r),ON,[2,INTOF,](LINE/x,y,z,x,y,z) as CATIA writes an arc: along the circle, in the sense
/// of INDIRV, to the first (second) place on the line from the centre to the end of the arc.
/// (CIRCLE/CANON,x,y,z,i,j,k,r) has a normal, the other one is parallel to XY.
bool AptReader::go_forward() {
    const std::vector<std::string_view> tokens = tokens_of(scanner_.arguments());
    std::size_t at = 0;
    const auto takes = [&](std::string_view word) {
        const bool there = at < tokens.size() && reads(tokens[at], word);
        if (there) ++at;
        return there;
    };
    const auto takes_numbers = [&](std::size_t count, Numbers& out) {
        for (; out.count < count; ++at) {
            const auto value = at < tokens.size() ? number_of(tokens[at]) : std::nullopt;
            if (!value) return false;
            out.value[out.count++] = *value;
        }
        return true;
    };
    Numbers circle, line;
    const bool is_circle = takes("CIRCLE");
    const bool canonical = takes("CANON");
    const bool understood = is_circle && takes_numbers(canonical ? 7 : 4, circle) && takes("ON");
    const bool second_crossing = takes("2") && takes("INTOF");
    if (!understood || !takes("LINE") || !takes_numbers(6, line) || at != tokens.size())
        return refuse("NC0417", "APT source of this form is not read",
                      "TLON,GOFWD/(CIRCLE/x,y,z,r),ON,(LINE/x,y,z,x,y,z) is; or let the CAM system put out points");
    const Vector3d normal = direction(canonical ? circle.triple(3) : Vector3d(Vector3d::UnitZ()));
    const double length = normal.norm();
    if (!(length > smallest_vector) || !std::isfinite(length)) return refuse("NC0402", "a normal without direction");
    const Vector3d centre_mm = point_mm(circle.triple(0)), off_centre = point_mm(line.triple(0)) - centre_mm;
    const double radius_mm = circle.value[circle.count - 1] * unit_mm_;
    if (!(off_centre.cross(normal / length).norm() <= allowed_mm(radius_mm)))
        return refuse("NC0417", "the line at which an arc ends does not start at its centre");
    return add_driven_arc(centre_mm, normal / length, radius_mm, point_mm(line.triple(3)), second_crossing);
}

bool AptReader::add_driven_arc(const Vector3d& centre_mm, const Vector3d& normal, double radius_mm,
                               const Vector3d& end_mm, bool second_crossing) {
    if (program_.moves.empty() || circle_)
        return refuse("NC0415", circle_ ? "a circle where another one waits for the GOTO that ends it"
                                        : "a circle from a place that is not known");
    if (rapid_next_) return refuse("NC0416", "a circle at rapid");
    if (!direction_) return refuse("NC0414", "a circle without INDIRV: in which sense?");
    const Vector3d start_mm = program_.moves.back().position_mm, arm = start_mm - centre_mm;
    const double allowed = allowed_mm(radius_mm);
    if (!(std::abs(arm.cross(normal).norm() - radius_mm) <= allowed))
        return refuse("NC0207", fmt::format("a circle of {:.6g} mm that starts {:.6g} mm from its centre", radius_mm,
                                            arm.cross(normal).norm()));
    if (!(std::abs((end_mm - start_mm).dot(normal)) <= allowed))
        return refuse("NC0414", "the end of a circle lies out of the plane of its start");
    const double along = direction_->dot(normal.cross(arm)) / radius_mm;
    direction_.reset();
    if (!(std::abs(along) >= least_along_way))
        return refuse("NC0414", "INDIRV points across the circle: in which sense?");
    auto arc = arc_by_centre(start_mm, end_mm, centre_mm, normal, along < 0, 0, cl_data_arcs);
    if (!arc) return findings_.refuse(scanner_.spot(), std::move(arc.error()));
    const double beyond = std::abs(arc->angle_rad) - half_turn, tolerance = angle_tolerance(radius_mm);
    if (second_crossing ? beyond < -tolerance : beyond > tolerance)
        return refuse("NC0414", second_crossing ? "the end of the circle is met first, not second"
                                                : "the line is met on the other side of the centre first");
    return add_move(end_mm, false, &*arc);
}

}  // namespace trunnion::nc
