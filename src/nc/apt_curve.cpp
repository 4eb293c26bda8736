#include <algorithm>
#include <type_traits>

#include <fmt/format.h>

#include "detail/apt_reader.hpp"

namespace trunnion::nc {

using Eigen::Vector3d;
using program::Curve;
using program::Move;

namespace {

constexpr int nurbs_degree = 3;

}  // namespace

/// NURBS/, KNOT/…, CNTRL/x,y,z …, as NX writes: a cubic from where the tool is, which is its first control point. KNOT
/// has the knots between the ends and the end's, each once: two less than there are CNTRL.
bool AptReader::nurbs() {
    if (circle_) return refuse("NC0420", "a curve where a circle waits for the GOTO that ends it");
    if (rapid_next_) return refuse("NC0420", "a curve at rapid", "FEDRAT before it");
    if (program_.moves.empty()) return refuse("NC0420", "a curve from a place that is not known", "GOTO before it");
    if (!scanner_.arguments().empty()) return refuse("NC0418", "NURBS with arguments is of another form");
    curve_ = WaitingCurve{.spot = scanner_.spot()};
    return true;
}

bool AptReader::knots() {
    if (!curve_) return refuse("NC0422", "KNOT without NURBS");
    if (!curve_->points_mm.empty()) return refuse("NC0418", "KNOT behind CNTRL");
    for (std::string_view list = scanner_.arguments(); !list.empty();) {
        const std::string_view item = take_item(list);
        const auto knot = number_of(item);
        if (!knot)
            return findings_.refuse("NC0201", scanner_.spot(item), "no finite number where one is expected", item);
        if (!(*knot >= (curve_->knots.empty() ? 0 : curve_->knots.back())))
            return findings_.refuse("NC0419", scanner_.spot(item), "the knots of a curve do not rise", item);
        curve_->knots.push_back(*knot);
    }
    return true;
}

bool AptReader::control_point() {
    Numbers point;
    if (!curve_) return refuse("NC0422", "CNTRL without NURBS");
    if (!numbers(point, false)) return false;
    if (point.count != 3)
        return refuse("NC0401", fmt::format("{} numbers, a control point has 3", point.count),
                      "a curve along which the tool turns is not read: let the CAM system put out points");
    curve_->points_mm.push_back(point_mm(point.triple(0)));
    if (!curve_->points_mm.back().allFinite()) return refuse("NC0201", "the coordinates are not finite in mm");
    curve_->lines.push_back(scanner_.spot().line);
    return true;
}

bool AptReader::end_curve() {
    if (!curve_) return true;
    if (curve_->is_catia) return refuse("NC0421", "the text ends within a curve", "END NURBS; is missing");
    const WaitingCurve waiting = std::move(*curve_);
    curve_.reset();
    const std::size_t points = waiting.points_mm.size(), said = waiting.knots.size();
    if (points < nurbs_degree || said + 2 != points)
        return findings_.refuse("NC0418", waiting.spot, "a curve whose knots do not fit its control points",
                                fmt::format("{} KNOT, {} CNTRL", said, points),
                                "a cubic has three CNTRL or more, and two KNOT less");
    std::vector<double> distances;
    int repeated = 1;
    for (std::size_t i = 0; i < said; ++i) {
        distances.push_back(waiting.knots[i] - (i == 0 ? 0 : waiting.knots[i - 1]));
        repeated = distances.back() > 0 ? 1 : repeated + 1;
        const bool at_end = i == 0 || i + 1 == said;
        if (repeated > (at_end ? 1 : nurbs_degree))
            return findings_.refuse("NC0419", waiting.spot, "knots of a curve that tear it, or repeat its ends",
                                    fmt::format("{}", waiting.knots[i]));
    }
    Curve curve;
    curve.degree = nurbs_degree;
    curve.knots = clamped_knots(nurbs_degree, distances);
    curve.position_mm.push_back(program_.moves.back().position_mm);
    curve.position_mm.insert(curve.position_mm.end(), waiting.points_mm.begin(), waiting.points_mm.end());
    std::vector<std::int32_t> lines;
    for (std::size_t i = 0; i < said; ++i) lines.push_back(waiting.lines[i + nurbs_degree - 1]);
    return add_curve(std::move(curve), lines);
}

/// One move for each span that is longer than 0; a line of the text for each span.
bool AptReader::add_curve(Curve curve, const std::vector<std::int32_t>& lines) {
    program::Feed feed;
    if (!cutting_feed(feed)) return false;
    const auto index = static_cast<std::int32_t>(program_.curves.size());
    const auto degree = static_cast<std::size_t>(curve.degree);
    for (std::size_t i = 0; i < lines.size(); ++i) {
        const double from_u = curve.knots[degree + i], to_u = curve.knots[degree + i + 1];
        if (!(from_u < to_u)) continue;
        const CurvePose pose = pose_at(curve, to_u);
        Move move;
        move.position_mm = pose.position_mm;
        if (!curve.axis.empty()) axis_ = pose.axis.stableNormalized();
        move.axis = axis_;
        move.tool = tool_;
        move.feed = feed;
        move.line = lines[i];
        if (!pose.position_mm.allFinite() || !axis_.allFinite())
            return refuse("NC0201", "the coordinates are not finite in mm");
        follow_curve(program_, move, {index, from_u, to_u});
        program_.moves.push_back(move);
    }
    program_.curves.push_back(std::move(curve));
    return true;
}

// ------------------------------------------------------------------------------------------------------------ CATIA

/// BEGIN NURBS_SIEMENS(D=3,F=4000,AXIS=0,0,1); or (D=3,F=4000,AXIS=VAR,LENGTH=100);
bool AptReader::begin_catia_curve() {
    if (circle_ || rapid_next_) return refuse("NC0420", "a curve at rapid, or where a circle waits for its GOTO");
    std::string_view list = scanner_.major();
    const std::size_t open = list.find('('), close = list.rfind(')');
    if (open == list.npos || close == list.npos || close < open)
        return refuse("NC0421", "a curve of a form that is not read", "BEGIN NURBS_SIEMENS(D=3,F=4000,AXIS=0,0,1);");
    list = list.substr(open + 1, close - open - 1);
    WaitingCurve curve{.spot = scanner_.spot(), .is_catia = true};
    const std::size_t axis = list.find("AXIS=");
    std::string_view rest = axis == list.npos ? std::string_view{} : list.substr(axis + 5);
    curve.has_second = reads(rest.substr(0, 3), "VAR");
    std::vector<double> head;
    if (!catia_fields(list.substr(0, axis), {"D", "F"}, head)) return false;
    if (head[0] != 1 && head[0] != 2 && head[0] != 3) return refuse("NC0421", "the degree of a curve is 1, 2 or 3");
    if (!(head[1] > 0)) return refuse("NC0206", "a feed must be positive");
    curve.degree = static_cast<int>(head[0]);
    feed_is_per_turn_ = false;
    feed_mm_s_ = head[1] * unit_mm_ / 60;
    if (!curve.has_second) {
        Vector3d vector;
        for (double& component : vector) {
            const auto value = number_of(take_item(rest));
            if (!value) return refuse("NC0421", "AXIS of a curve is three numbers or VAR");
            component = *value;
        }
        if (!set_axis(vector)) return false;
    }
    curve_ = std::move(curve);
    return true;
}

/// Fields with a name and a number, all of them, in this order.
bool AptReader::catia_fields(std::string_view list, std::initializer_list<std::string_view> names,
                             std::vector<double>& values) {
    for (const std::string_view name : names) {
        const std::string_view item = take_item(list);
        const std::size_t equals = std::min(item.find('='), item.size());
        const auto value = number_of(trimmed(item.substr(std::min(equals + 1, item.size()))));
        if (!reads(trimmed(item.substr(0, equals)), name) || !value)
            return findings_.refuse("NC0421", scanner_.spot(), "a curve of a form that is not read", item,
                                    "N0,XT=…,YT=…,ZT=…,[XH=…,YH=…,ZH=…,]DK=…,W=…;");
        values.push_back(*value);
    }
    return trimmed(list).empty() ||
           findings_.refuse("NC0421", scanner_.spot(), "a curve of a form that is not read", list);
}

/// N0,XT=…,YT=…,ZT=…,DK=…,W=…; with XH YH ZH where the tool turns. END NURBS; ends the curve.
bool AptReader::catia_line() {
    std::string_view list = scanner_.major();
    if (list.ends_with(';')) list.remove_suffix(1);
    if (reads(list, "END NURBS")) return end_catia_curve();
    if (list.size() < 2 || upper(list[0]) != 'N' || !is_digit(list[1]))
        return refuse("NC0421", "not expected within a curve", "END NURBS; before it");
    take_item(list);
    std::vector<double> values;
    if (!(curve_->has_second ? catia_fields(list, {"XT", "YT", "ZT", "XH", "YH", "ZH", "DK", "W"}, values)
                             : catia_fields(list, {"XT", "YT", "ZT", "DK", "W"}, values)))
        return false;
    const double weight = values.back(), length = values[values.size() - 2];
    if (!(weight > 0) || !(length >= 0))
        return refuse("NC0421", "a control point with a weight or a distance of knots that is too small");
    curve_->points_mm.push_back(point_mm(Vector3d(values.data())));
    curve_->lines.push_back(scanner_.spot().line);
    curve_->weights.push_back(weight);
    curve_->lengths.push_back(length);
    if (curve_->has_second) curve_->axes.push_back(point_mm(Vector3d(values.data() + 3)) - curve_->points_mm.back());
    return curve_->points_mm.back().allFinite() || refuse("NC0201", "the coordinates are not finite in mm");
}

bool AptReader::end_catia_curve() {
    const WaitingCurve waiting = std::move(*curve_);
    curve_.reset();
    const auto& points = waiting.points_mm;
    std::vector<bool> repeats(points.size());
    for (std::size_t i = 1; i < points.size(); ++i)
        repeats[i] = points[i] == points[i - 1] && (!waiting.has_second || waiting.axes[i] == waiting.axes[i - 1]);
    std::optional<Spans> spans;
    if (points.size() > static_cast<std::size_t>(waiting.degree))
        spans = spans_of(waiting.lengths, repeats, waiting.degree);
    if (!spans)
        return findings_.refuse("NC0418", waiting.spot, "a curve whose knots do not fit its control points", {},
                                "DK is 0 in degree - 1 points at its ends, besides the first");
    const auto part = [&](const auto& list) {
        const auto begin = list.begin();
        return std::remove_cvref_t<decltype(list)>(begin + static_cast<std::ptrdiff_t>(spans->first_point),
                                                   begin + static_cast<std::ptrdiff_t>(spans->last_point) + 1);
    };
    Curve curve;
    curve.degree = waiting.degree;
    curve.knots = clamped_knots(waiting.degree, spans->distances);
    curve.position_mm = part(points);
    curve.weights = part(waiting.weights);
    if (std::ranges::all_of(curve.weights, [](double weight) { return weight == 1; })) curve.weights.clear();
    if (waiting.has_second) curve.axis = part(waiting.axes);
    if (!has_direction_everywhere(curve))
        return findings_.refuse("NC0421", waiting.spot, "a second curve that gives the tool no direction");
    if (waiting.has_second) axis_ = curve.axis.front().stableNormalized();
    if (!add_move(curve.position_mm.front(), false)) return false;
    std::vector<std::int32_t> lines;
    for (const std::size_t point : spans->points) lines.push_back(waiting.lines[point]);
    return add_curve(std::move(curve), lines);
}

}  // namespace trunnion::nc
