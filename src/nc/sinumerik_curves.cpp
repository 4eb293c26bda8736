#include <algorithm>

#include "detail/sinumerik_reader.hpp"

namespace trunnion::nc::sinumerik {

using Eigen::Vector3d;
using program::Curve;
using program::Move;
using program::OrientationLaw;
using program::Space;

namespace {

constexpr int most_spline_degree = 3;
constexpr double heaviest_point = 3;      ///< PW
constexpr double smallest_second = 1e-9;  ///< mm: a second curve as near as this has no direction

constexpr Address seconds[] = {Address::xh, Address::yh, Address::zh};

bool same_point(const SplinePoint& a, const SplinePoint& b) {
    return a.position_mm == b.position_mm && (a.axis == b.axis || (a.axis.hasNaN() && b.axis.hasNaN()));
}

bool same_words(const RotaryWords& a, const RotaryWords& b) {
    return std::ranges::equal(a, b, [](double x, double y) { return x == y || (std::isnan(x) && std::isnan(y)); });
}

}  // namespace

/// SPLINEPATH and POLYPATH say which axes go along a curve: X, Y and Z do.
bool SinumerikReader::curve_axes(const Word& word) {
    const auto says = [&](std::string_view text) {
        return std::ranges::any_of(word.arguments, [&](const Argument& argument) { return argument.text == text; });
    };
    const bool spline = rule_of_name(word.name).meaning == Meaning::spline_axes;
    if (spline ? says("X") && says("Y") && says("Z") : says("AXES")) return true;
    return refuse("NC0602", word, "a curve along which not all of X, Y and Z go is not supported",
                  spline ? "SPLINEPATH(1,X,Y,Z) and rotary axes" : "POLYPATH(\"AXES\")");
}

// ------------------------------------------------------------------------------------------------- the second curve

/// ORICURVE: the tool points from its tip to XH YH ZH. With G1 it turns in one plane.
bool SinumerikReader::second_point(const Vector3d& to) {
    const bool said = said_.has_any(Address::xh, Address::zh);
    const bool goes_on = modes_.motion == Meaning::spline || modes_.motion == Meaning::polynomial;
    if (!said) {
        if (!goes_on || !modes_.second_curve) second_mm_.setConstant(unknown);
        if (second_mm_.hasNaN()) return true;
    }
    said_.use(Address::xh, Address::zh);
    if (!modes_.second_curve || counted_in_.space != Space::workpiece || !modes_.transform)
        return refuse("NC0636", spot_of_motion(), "XH YH ZH need TRAORI and ORICURVE");
    if (!goes_on && modes_.motion != Meaning::rapid && modes_.motion != Meaning::line)
        return refuse("NC0636", spot_of_motion(), "XH YH ZH with a circle are not supported");
    if (said_.has_any(Address::rotary_1, Address::rotary_3) || said_.has_any(Address::a2, Address::c3))
        return refuse("NC0617", spot_of_motion(), "XH YH ZH beside another orientation of the tool");
    Vector3d programmed = frame_.inward(second_mm_);
    for (Eigen::Index i = 0; i < 3; ++i) {
        const Address address = seconds[i];
        if (!said_.has(address)) continue;
        const Counting counting = said_.counting(address);
        const bool incremental = counting == Counting::incremental || (counting == Counting::modal && !modes_.absolute);
        if (incremental || (counting != Counting::modal && counting != Counting::absolute))
            return refuse("NC0636", spot(address), "XH YH ZH are absolute coordinates", {}, "G90 or XH=AC(…)");
        programmed[i] = said_[address] * modes_.unit_mm;
    }
    const auto outer = frame_.outward(programmed), tip = frame_.outward(to);
    if (!outer || outer->hasNaN() || !tip || tip->hasNaN())
        return refuse("NC0636", spot_of_motion(), "X Y Z and XH YH ZH must all be known", {},
                      "say all of them in the first block");
    const Vector3d up = *outer - *tip;
    if (!(up.stableNorm() > smallest_second) || !up.allFinite())
        return refuse("NC0618", spot_of_motion(), "XH YH ZH where the tip is: no direction");
    if (modes_.in_machine)
        return refuse("NC0617", spot_of_motion(), "XH YH ZH with ORIMKS are not supported", {}, "ORIWKS");
    second_mm_ = *outer;
    axis_ = up.stableNormalized();
    law_ = OrientationLaw::vector;
    tool_as_swivelled_ = false;
    return true;
}

// ---------------------------------------------------------------------------------------------------------- BSPLINE

/// Takes up a control point. The curve is made when its end is known: when another motion comes.
bool SinumerikReader::add_spline_point(const Vector3d& to) {
    if (spline_ && spline_->counted_in != counted_in_ && !end_spline()) return false;
    if (modal_cycle_) return refuse("NC0628", spot_of_motion(), "a curve under MCALL");
    if (!spline_ && !begin_spline()) return false;
    const auto outer = frame_.outward(to);
    if (!outer || outer->hasNaN()) return refuse("NC0629", spot_of_motion(), "a control point that is not known whole");
    if (outer->array().isInf().any()) return refuse("NC0201", spot_of_motion(), "the position is not finite");
    SplinePoint point;
    point.position_mm = *outer;
    point.axis.setConstant(unknown);
    if (law_ != spline_->law)
        return refuse("NC0629", spot_of_motion(), "rotary words and tool vectors along one curve");
    if (law_ == OrientationLaw::vector) {
        point.axis = axis_;
        if (modes_.second_curve && !second_mm_.hasNaN()) {
            point.axis = second_mm_ - *outer;
            point.second_mm = point.axis.norm();
        }
    }
    point.rotary_rad = rotary_rad_;
    if (!spline_words(point)) return false;
    Move move;
    move.position_mm = *outer;
    move.law = law_;
    if (!feed_of(move, {.curved = true})) return false;
    point.feed = move.feed;
    point.events = program_.events.size();
    point.line = block_.line;
    point.exact_stop = modes_.exact_stop || exact_stop_once_;
    spline_->points.push_back(point);
    position_mm_ = *outer;
    programmed_mm_ = to;
    if (law_ == OrientationLaw::vector) rotary_rad_.fill(unknown);
    return true;
}

/// Where the tool stands is the first control point.
bool SinumerikReader::begin_spline() {
    const bool left_out = rapid_left_out_ || (whole_pose_needed_ && counted_in_.space == Space::workpiece);
    if (program_.moves.empty() || position_mm_.hasNaN() || left_out)
        return refuse("NC0629", spot_of_motion(), "a curve from a place that is not known", {},
                      "say X, Y and Z in a straight move before it");
    const Move& last = program_.moves.back();
    SplinePoint start;
    start.position_mm = position_mm_;
    start.axis.setConstant(unknown);
    if (law_ == OrientationLaw::vector && last.law == OrientationLaw::vector) start.axis = last.axis;
    if (modes_.second_curve && !second_mm_.hasNaN()) {
        start.second_mm = unknown;
        if (!second_from_mm_.hasNaN()) {
            start.axis = second_from_mm_ - position_mm_;
            start.second_mm = start.axis.norm();
        }
    }
    start.rotary_rad = rotary_from_rad_;
    start.events = program_.events.size();
    spline_ = SplineInWork{.counted_in = counted_in_,
                           .degree = modes_.spline_degree,
                           .law = law_,
                           .tool = counted_in_.space == Space::machine ? tool_.in_spindle : tool_.index,
                           .place = spot_of_motion(),
                           .points = {start}};
    return true;
}

/// SD, which may stand alone.
bool SinumerikReader::spline_degree() {
    if (!said_.has(Address::spline_degree)) return true;
    said_.use(Address::spline_degree);
    const double degree = said_[Address::spline_degree];
    if (degree != 1 && degree != 2 && degree != most_spline_degree)
        return refuse("NC0631", spot(Address::spline_degree), "the degree of a B-spline is 1, 2 or 3");
    modes_.spline_degree = static_cast<int>(degree);
    if (spline_ && modes_.spline_degree != spline_->degree)
        return refuse("NC0631", spot(Address::spline_degree), "the degree changes within a B-spline", {},
                      "G1 between, or SD in its first block");
    return true;
}

/// PL and PW.
bool SinumerikReader::spline_words(SplinePoint& point) {
    said_.use(Address::parameter_length, Address::point_weight);
    point.length = said_.get(Address::parameter_length, unknown) * modes_.unit_mm;
    if (point.length < 0 || std::isinf(point.length))
        return refuse("NC0632", spot(Address::parameter_length), "a distance of knots is not negative");
    point.weight = said_.get(Address::point_weight, 1);
    if (!(point.weight > 0 && point.weight <= heaviest_point))
        return refuse("NC0633", spot(Address::point_weight), "the weight of a point lies above 0, up to 3");
    return true;
}

/// Equal distances where no block says PL.
bool SinumerikReader::complete_lengths(SplineInWork& work) {
    const std::size_t degree = static_cast<std::size_t>(work.degree), blocks = work.points.size() - 1;
    const auto said = std::ranges::count_if(work.points, [](const auto& point) { return !std::isnan(point.length); });
    if (static_cast<std::size_t>(said) == blocks) return true;
    if (said > 0) return refuse_in(work, "NC0632", "PL stands in some blocks of a B-spline, not in all of them");
    const std::size_t spare_at_start = (degree - 1) / 2, spans = blocks - degree + 1;
    for (std::size_t i = 1; i <= blocks; ++i)
        work.points[i].length = i > spare_at_start && i <= spare_at_start + spans ? 1 : 0;
    if (spans > 1)
        findings_.count("NC0661", Severity::warning, work.place, "PL",
                        "a B-spline without PL: equal distances of its knots are assumed",
                        "PL in every block, 0 in degree - 1 of them at the ends");
    return true;
}

bool SinumerikReader::end_spline() {
    if (!spline_) return true;
    SplineInWork work = std::move(*spline_);
    spline_.reset();
    const auto degree = static_cast<std::size_t>(work.degree), blocks = work.points.size() - 1;
    if (blocks < degree)
        return refuse_in(
            work, "NC0630",
            fmt::format("a B-spline of degree {} with {} blocks: it needs as many as its degree", degree, blocks));
    if (!complete_lengths(work)) return false;
    std::vector<double> lengths;
    std::vector<bool> repeats;
    for (std::size_t i = 0; i <= blocks; ++i) {
        lengths.push_back(work.points[i].length);
        repeats.push_back(i > 0 && same_point(work.points[i - 1], work.points[i]));
    }
    const auto spans = spans_of(lengths, repeats, work.degree);
    if (!spans)
        return refuse_in(work, "NC0632",
                         "the distances of knots (PL) make no B-spline from its first to its last point",
                         "PL is 0 in degree - 1 blocks at its ends, and within it less than degree times on end");
    work.points.erase(work.points.begin() + static_cast<std::ptrdiff_t>(spans->last_point) + 1, work.points.end());
    Curve curve;
    curve.degree = work.degree;
    curve.knots = clamped_knots(work.degree, spans->distances);
    for (std::size_t i = spans->first_point; i < work.points.size(); ++i) {
        curve.position_mm.push_back(work.points[i].position_mm);
        curve.weights.push_back(work.points[i].weight);
    }
    if (std::ranges::all_of(curve.weights, [](double weight) { return weight == 1; })) curve.weights.clear();
    if (std::ranges::all_of(curve.position_mm, [&](const Vector3d& p) { return p == curve.position_mm.front(); }))
        return refuse_in(work, "NC0637", "a curve along which the tip does not move", "turn the tool with G1");
    work.points.erase(work.points.begin(), work.points.begin() + static_cast<std::ptrdiff_t>(spans->first_point));
    return spline_orientation(work, curve) && add_spline(work, spans->first_point, spans->points, std::move(curve));
}

/// Vectors and rotary words are control points, as X Y Z are.
bool SinumerikReader::spline_orientation(const SplineInWork& work, Curve& curve) {
    const auto& points = work.points;
    if (work.law == OrientationLaw::rotary) {
        const auto stands = [&](const SplinePoint& p) { return same_words(p.rotary_rad, points.front().rotary_rad); };
        if (std::ranges::all_of(points, stands)) return true;
        for (const SplinePoint& point : points) {
            if (has_free_rotary(point.rotary_rad))
                return refuse_in(work, "NC0629", "a curve with rotary words from angles that are not known",
                                 "say all rotary axes in a straight move before it");
            curve.rotary_rad.push_back(point.rotary_rad);
            for (double& word : curve.rotary_rad.back())
                if (std::isnan(word)) word = 0;  // the machine has no such axis
        }
        return true;
    }
    for (const SplinePoint& point : points) curve.axis.push_back(point.axis);
    if (std::isnan(points.front().second_mm)) {
        curve.axis.front() *= points[1].second_mm;
        findings_.count("NC0662", Severity::note, work.place, "ORICURVE",
                        "the second curve starts as far from the tip as its first point: XH YH ZH were not said before",
                        "G1 X… Y… Z… XH=… YH=… ZH=… under ORICURVE before the curve");
    }
    const bool second = points.back().second_mm != 0;
    if (std::ranges::any_of(points, [&](const SplinePoint& p) { return (p.second_mm != 0) != second; }))
        return refuse_in(work, "NC0636", "XH YH ZH begin within a curve");
    if (curve.axis.front().hasNaN())
        return refuse_in(work, "NC0629", "a curve with tool vectors from a tool axis that is not known as a vector",
                         "A3 B3 C3 in a straight move before it");
    if (!second && std::ranges::all_of(curve.axis, [&](const Vector3d& a) { return a == curve.axis.front(); }))
        curve.axis.clear();
    return has_direction_everywhere(curve) ||
           refuse_in(work, "NC0637", "the tool turns so far along a curve that its direction may vanish",
                     "more control points, or lines");
}

/// One move for each span that is longer than 0, with line and feed of the block that said its PL.
bool SinumerikReader::add_spline(const SplineInWork& work, std::size_t first, const std::vector<std::size_t>& blocks,
                                 Curve curve) {
    const auto index = static_cast<std::int32_t>(program_.curves.size());
    const auto degree = static_cast<std::size_t>(curve.degree);
    const std::size_t old_moves = program_.moves.size();
    std::size_t event = work.points.front().events;
    for (std::size_t i = 0; i < blocks.size(); ++i) {
        const double from_u = curve.knots[degree + i], to_u = curve.knots[degree + i + 1];
        if (!(from_u < to_u)) continue;
        const SplinePoint& block = work.points[blocks[i] - first];
        for (; event < block.events; ++event)
            program_.events[event].before_move = std::max(program_.events[event].before_move, program_.moves.size());
        const CurvePose pose = pose_at(curve, to_u);
        Move move;
        move.position_mm = pose.position_mm;
        move.feed = block.feed;
        move.space = work.counted_in.space;
        move.offset = work.counted_in.offset;
        move.tool = work.tool;
        move.exact_stop = block.exact_stop;
        move.line = block.line;
        move.law = work.law;
        if (move.law == OrientationLaw::vector)
            move.axis = curve.axis.empty() ? work.points.back().axis : pose.axis.stableNormalized();
        else
            move.rotary_rad = curve.rotary_rad.empty() ? work.points.back().rotary_rad : pose.rotary_rad;
        if (!pose.position_mm.allFinite() || !move.axis.allFinite())
            return refuse_in(work, "NC0201", "the curve is not finite");
        follow_curve(program_, move, {index, from_u, to_u});
        program_.moves.push_back(move);
    }
    Move& last = program_.moves.back();
    last.exact_stop = last.exact_stop || work.points.back().exact_stop;
    for (; event < program_.events.size(); ++event)
        if (program_.events[event].before_move >= old_moves) program_.events[event].before_move = program_.moves.size();
    program_.curves.push_back(std::move(curve));
    return true;
}

}  // namespace trunnion::nc::sinumerik
