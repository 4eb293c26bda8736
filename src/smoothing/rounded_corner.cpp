#include "detail/rounded_corner.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "detail/corner_length.hpp"
#include "detail/septic.hpp"

namespace trunnion::smoothing {

namespace {

constexpr double tolerance_share = 0.97;
constexpr double narrowed_to = 0.985;  // of the tolerance, where the hull found more than all of it
constexpr int most_narrowings = 16;
constexpr double nearly_all = 0.9;
constexpr double standing_still = 1e-9;  // mm per mm of p
constexpr double same_parameter = 1e-3;  // knots nearer than this share a border: no piece is much shorter
constexpr double no_jump = 1e-9;
constexpr double as_near_mm = 0.004;  // places whose distances differ by less are equally near
constexpr double agreement_mm = 1e-4;
constexpr int most_halvings = 20;

/// How orientation makes a top point, and back. Linear: for differences too.
class TopPoint {
  public:
    TopPoint(const Measure& measure, double lever) : vectors_(measure.vectors()), height_(height_of(measure)) {
        scale_.setConstant(height_);
        if (measure.lever_axis() >= 0) scale_[measure.lever_axis() - 3] *= lever;
    }

    Coordinates of(const Coordinates& q) const {
        Coordinates top = q;
        if (vectors_) {
            top.head<3>() += height_ * q.tail<3>();
            top.tail<3>().setZero();
        } else {
            top.tail<3>().array() *= scale_.array();
        }
        return top;
    }

    Eigen::Vector3d orientation(const Coordinates& top, const Eigen::Vector3d& tip) const {
        if (vectors_) return (top.head<3>() - tip) / height_;
        return top.tail<3>().array() / scale_.array();
    }

  private:
    static double height_of(const Measure& measure) {
        return measure.flank_height_mm() > 0 ? measure.flank_height_mm() : path::reference_height_mm;
    }

    bool vectors_;
    double height_;
    Eigen::Vector3d scale_;
};

CornerPolygon polygon(const std::array<Coordinates, 2>& leg, double inner, const std::array<double, 2>& outer) {
    const double before = leg[0].norm(), after = leg[1].norm();
    return CornerPolygon({leg[0] * (outer[0] / before), leg[0] * (inner / before), Coordinates::Zero(),
                          leg[1] * (inner / after), leg[1] * (outer[1] / after)});
}

/// The inverse of p₁δ + p₂δ² + p₃δ³.
Taylor3 inverse_step(const Taylor3& p) {
    const double p1 = p.c[1], p2 = p.c[2], p3 = p.c[3];
    return {0, 1 / p1, -p2 / (p1 * p1 * p1), (2 * p2 * p2 - p1 * p3) / (p1 * p1 * p1 * p1 * p1)};
}

std::array<Coordinates, 4> composed(const std::array<Coordinates, 4>& outer, const Taylor3& inner) {
    std::array<Coordinates, 4> out;
    for (int i = 0; i < 6; ++i) {
        const Taylor3 t = compose(inner, outer[0][i], outer[1][i], outer[2][i], outer[3][i]);
        for (int k = 0; k < 4; ++k) out[k][i] = t.c[k];
    }
    return out;
}

/// p and the top curve's parameter along the bottom curve, all by path lengths: with l the length along each curve,
///
///     l_top = φ(l_bottom),   φ′ = σ, φ″ = φ‴ = 0 at both ends,
///
/// which is what closed_link_end() says, and keeps straight parts of both curves in step. Likewise p = π(l_bottom).
/// Everything counts from the corner's vertex.
class CornerCurves {
  public:
    struct Inner {
        double bottom_mm = 0, top_mm = 0;
    };

    /// Nothing: see round_corner(). `inner` is reduced to what the legs leave.
    static std::optional<CornerCurves> make(const CornerLegs& legs, const TopPoint& top_point, Link kind, Inner& inner);

    /// The tool turns C² at both ends, whatever the corner.
    bool is_linked() const { return turn_.has_value(); }
    double length_mm() const { return reach_mm_[0] + reach_mm_[1]; }
    const std::array<double, 2>& reach_mm() const { return reach_mm_; }
    double place_mm(double u) const { return place(u, half_of(u)).value(); }

    double at_place(double p_mm) const {
        const double part = place_.inverse(std::clamp(p_mm / length_mm(), 0.0, 1.0));
        return bottom_length_.parameter_at(part * bottom_length_.total_mm());
    }

    /// The vertex, and where a curve passes from one polynomial to the next.
    std::array<double, 3> knots() const { return {at_place(reach_mm_[0]), 0.5, at_middle_of_top()}; }

    /// Value and derivatives by p; `inside`: a parameter between the same knots.
    HermiteEnd at(double u, double inside) const {
        const Half half = half_of(inside), top_half = half_of(top_parameter(inside, half));
        const auto bottom = bottom_.at(u, half);
        const auto top = top_at(u, half, top_half);
        std::array<Coordinates, 4> q;
        for (int k = 0; k < 4; ++k) {
            q[k] = bottom[k];
            if (turns_) q[k].tail<3>() = top_point_->orientation(top[k], bottom[k].head<3>());
        }
        const auto by_p = composed(q, inverse_step(place(u, half)));
        return {by_p[0], by_p[1], 2 * by_p[2], 6 * by_p[3]};
    }

  private:
    CornerCurves(const CornerPolygon& bottom, const CornerPolygon& top, const TopPoint& top_point)
        : bottom_(bottom), top_(top), bottom_length_(bottom), top_length_(top), top_point_(&top_point) {}

    static Half half_of(double u) { return u < 0.5 ? Half::first : Half::second; }

    /// A function of the bottom's path length, both as shares, at u.
    Taylor3 along(const ParameterLink& function, double u, Half half) const {
        Taylor3 share = bottom_length_.at(u, half) * (1 / bottom_length_.total_mm());
        share.c[0] = std::clamp(share.c[0], 0.0, 1.0);
        const Taylor3 f = function.at(share.c[0]);
        return compose(share, f.c[0], f.c[1], f.c[2], f.c[3]);
    }

    Taylor3 place(double u, Half half) const { return length_mm() * along(place_, u, half); }

    double top_parameter(double u, Half half) const {
        if (!turn_) return u;
        return top_length_.parameter_at(top_length_.total_mm() * along(*turn_, u, half).value());
    }

    double at_middle_of_top() const {
        if (!turn_) return 0.5;
        const double part = turn_->inverse(top_length_.at(0.5, Half::first).value() / top_length_.total_mm());
        return bottom_length_.parameter_at(part * bottom_length_.total_mm());
    }

    std::array<Coordinates, 4> top_at(double u, Half half, Half top_half) const {
        const double v = top_parameter(u, half);
        const auto by_v = top_.at(v, top_half);
        if (!turn_) return by_v;
        Taylor3 length = top_length_.total_mm() * along(*turn_, u, half);
        length.c[0] = 0;
        const Taylor3 v_by_length = inverse_step(top_length_.at(v, top_half));
        return composed(by_v, compose(length, 0, v_by_length.c[1], v_by_length.c[2], v_by_length.c[3]));
    }

    CornerPolygon bottom_, top_;
    CornerLength bottom_length_, top_length_;
    const TopPoint* top_point_;
    ParameterLink place_ = ParameterLink::linear();
    std::optional<ParameterLink> turn_;  // nothing: the linear link
    bool turns_ = true;                  // else the orientation stays what it is, exactly
    std::array<double, 2> reach_mm_{};
};

/// The function of path length, both as shares of theirs, with these slopes and without bend at its ends.
std::optional<ParameterLink> unbent(const std::array<double, 2>& slope, double length, double of_length) {
    const double factor = of_length / length;
    return ParameterLink::through({slope[0] * factor, 0, 0}, {slope[1] * factor, 0, 0});
}

std::optional<CornerCurves> CornerCurves::make(const CornerLegs& legs, const TopPoint& top_point, Link kind,
                                               Inner& inner) {
    std::array<Coordinates, 2> tip_leg, top_leg;
    std::array<double, 2> rate, p_rate, room;
    for (int side = 0; side < 2; ++side) {
        tip_leg[side] = legs.to_neighbour[side];
        tip_leg[side].tail<3>().setZero();
        top_leg[side] = top_point.of(legs.to_neighbour[side]);
        const double way = tip_leg[side].norm(), top_way = top_leg[side].norm();
        const double least = standing_still * legs.gap_mm[side];
        if (way < least || top_way < least) return std::nullopt;
        rate[side] = top_way / way;
        p_rate[side] = legs.gap_mm[side] / way;
        room[side] = legs.free_share[side] * way;
    }
    inner.bottom_mm = std::min(inner.bottom_mm, std::min(room[0], room[1]) / usual_corner_ratio);
    std::array<double, 2> outer, top_outer;
    for (int side = 0; side < 2; ++side) {
        outer[side] = usual_corner_ratio * inner.bottom_mm;
        if (outer[side] > nearly_all * room[side]) outer[side] = room[side];  // no sliver is left between two corners
        top_outer[side] = rate[side] * outer[side];
    }
    inner.top_mm = std::min({inner.top_mm, top_outer[0] / least_top_ratio, top_outer[1] / least_top_ratio});

    CornerCurves out(polygon(tip_leg, inner.bottom_mm, outer), polygon(top_leg, inner.top_mm, top_outer), top_point);
    out.turns_ = legs.to_neighbour[0].tail<3>().norm() + legs.to_neighbour[1].tail<3>().norm() > 0;
    out.reach_mm_ = {outer[0] * p_rate[0], outer[1] * p_rate[1]};
    const double length = out.bottom_length_.total_mm();
    const auto place = unbent(p_rate, out.length_mm(), length);
    if (kind == Link::optimised) out.turn_ = unbent(rate, out.top_length_.total_mm(), length);
    if (!place || (kind == Link::optimised && !out.turn_)) return std::nullopt;
    out.place_ = *place;
    return out;
}

/// Septic pieces of a corner, its deviation, and how it joins its legs.
class Representation {
  public:
    Representation(const Coordinates& at, const CornerLegs& legs, const CornerCurves& curves, DeviationHull& hull)
        : at_(at), legs_(legs), curves_(curves), hull_(hull), vertex_(curves.knots()[0]) {}

    RoundedCorner make() {
        out_.reach_mm = curves_.reach_mm();
        out_.joins_smoothly = curves_.is_linked() || (joins(0) && joins(1));
        const std::vector<double> border = borders();
        HermiteEnd start;
        for (std::size_t k = 1; k < border.size(); ++k) {
            const double inside = 0.5 * (border[k - 1] + border[k]);
            const HermiteEnd begin = end(border[k - 1], inside), finish = end(border[k], inside);
            if (k == 1) start = begin;
            start.third = begin.third;  // which jumps at a border
            refine({border[k - 1], start}, {border[k], finish}, inside, 0);
            start = finish;
        }
        return std::move(out_);
    }

  private:
    /// 0, the knots and 1, ascending. Where one falls on the vertex, the vertex stands for it.
    std::vector<double> borders() const {
        const auto knots = curves_.knots();
        std::vector<double> out{vertex_};
        for (const double u : {0.0, knots[1], knots[2], 1.0})
            if (std::ranges::none_of(out, [&](double v) { return std::abs(u - v) < same_parameter; })) out.push_back(u);
        std::ranges::sort(out);
        return out;
    }

    double place(double u) const { return u == vertex_ ? out_.reach_mm[0] : curves_.place_mm(u); }

    Coordinates slope(int side) const { return legs_.to_neighbour[side] * ((side == 0 ? -1 : 1) / legs_.gap_mm[side]); }

    bool joins(int side) const {
        const HermiteEnd end = curves_.at(side, 0.5 * side + 0.25);
        return (end.first - slope(side)).norm() < no_jump && end.second.norm() * curves_.length_mm() < no_jump;
    }

    /// What joins is continued as the leg goes: exactly.
    HermiteEnd end(double u, double inside) const {
        HermiteEnd end = curves_.at(u, inside);
        if (out_.joins_smoothly && (u == 0 || u == 1)) {
            end.first = slope(u == 0 ? 0 : 1);
            end.second.setZero();
        }
        return end;
    }

    /// A place between two pieces: parameter, and value and derivatives there.
    struct Station {
        double u;
        HermiteEnd end;
    };

    void refine(const Station& from, const Station& to, double inside, int depth) {
        const double begin = place(from.u), length = place(to.u) - begin;
        HermiteEnd start = from.end, finish = to.end;
        start.value += at_;
        finish.value -= from.end.value;
        const auto piece = hermite_piece(begin, length, start, finish);
        if (depth < most_halvings && !agrees(piece, from, to, inside)) {
            const double u = 0.5 * (from.u + to.u);
            const Station middle{u, end(u, inside)};
            refine(from, middle, inside, depth + 1);
            refine(middle, to, inside, depth + 1);
            return;
        }
        out_.pieces.push_back(piece);
        widen(out_.extent, hull_.over(bernstein(piece), programmed(begin), programmed(begin + length)));
        if (to.u == vertex_) out_.at_vertex = to.end.value;
    }

    /// The piece against the curves at two places inside.
    bool agrees(const path::PathPiece& piece, const Station& from, const Station& to, double inside) const {
        for (const double part : {0.3, 0.7}) {
            const double u = from.u + part * (to.u - from.u);
            const double share = std::clamp((curves_.place_mm(u) - piece.begin_mm) / piece.length_mm, 0.0, 1.0);
            if (size_mm(from.end.value + progress(piece, share) - curves_.at(u, inside).value) > agreement_mm)
                return false;
        }
        return true;
    }

    Coordinates programmed(double p_mm) const {
        const double d = p_mm - out_.reach_mm[0];
        return at_ + slope(d < 0 ? 0 : 1) * d;
    }

    const Coordinates& at_;
    const CornerLegs& legs_;
    const CornerCurves& curves_;
    DeviationHull& hull_;
    double vertex_;  // its parameter
    RoundedCorner out_;
};

/// Use of the tolerances between corner and legs from the places nearest to each other, by |Δtip|² + (flank height ·
/// turn)²: where tip and tool slip along the path by different amounts, these leave the tip more than equal p does.
class NearestPlaces {
  public:
    NearestPlaces(const Coordinates& at, const CornerLegs& legs, const Measure& measure)
        : at_(at), legs_(legs), measure_(measure) {}

    double use(const RoundedCorner& corner) const {
        double largest = 0, nearest = std::numeric_limits<double>::infinity();
        Coordinates vertex_from_nearest = Coordinates::Zero();
        for (const path::PathPiece& piece : corner.pieces) {
            for (int k = 0; k <= looks; ++k) {
                const auto series = path::evaluate(piece, piece.length_mm * k / looks);
                Coordinates q, ahead;
                for (int i = 0; i < 6; ++i) {
                    q[i] = series[i].value() - at_[i];
                    ahead[i] = series[i].d1();
                }
                largest = std::max(largest, from_legs(q));
                const Coordinates rest = q - ahead * (product(q, ahead) / product(ahead, ahead));
                if (product(q, q) >= nearest) continue;
                nearest = product(q, q);
                vertex_from_nearest = rest;
            }
        }
        return std::max(largest, measure_.use(vertex_from_nearest, legs_.lever));
    }

  private:
    static constexpr int looks = 12;

    double product(const Coordinates& a, const Coordinates& b) const { return measure_.product(a, b, legs_.lever); }

    double from_legs(const Coordinates& q) const {
        std::array<double, 2> distance, use;
        for (int side = 0; side < 2; ++side) {
            const Coordinates& leg = legs_.to_neighbour[side];
            const Coordinates rest = q - leg * std::clamp(product(q, leg) / product(leg, leg), 0.0, 1.0);
            distance[side] = std::sqrt(product(rest, rest));
            use[side] = measure_.use(rest, legs_.lever);
        }
        if (std::abs(distance[0] - distance[1]) <= as_near_mm) return std::max(use[0], use[1]);
        return distance[0] < distance[1] ? use[0] : use[1];
    }

    const Coordinates& at_;
    const CornerLegs& legs_;
    const Measure& measure_;
};

/// Deviation at the middle of a corner of unit inner length.
Coordinates unit_error(const Coordinates& before, const Coordinates& after) {
    return 0.25 * (before.normalized() + after.normalized());
}

/// Inner lengths that use each curve's own tolerance.
CornerCurves::Inner inner_by_tolerance(const CornerLegs& legs, const TopPoint& top_point, const Measure& measure) {
    std::array<Coordinates, 2> tip = legs.to_neighbour;
    for (Coordinates& leg : tip) leg.tail<3>().setZero();
    const Coordinates bottom = unit_error(tip[0], tip[1]);
    const Coordinates top = unit_error(top_point.of(legs.to_neighbour[0]), top_point.of(legs.to_neighbour[1]));
    Coordinates turned = Coordinates::Zero();
    turned.tail<3>() = top_point.orientation(top, Eigen::Vector3d::Zero());
    return {tolerance_share * measure.tip_tolerance_mm() / measure.point(bottom, legs.lever, 0),
            tolerance_share / measure.use(turned, legs.lever)};
}

}  // namespace

std::optional<RoundedCorner> round_corner(const Coordinates& at, const CornerLegs& legs, Link link,
                                          const Measure& measure, DeviationHull& hull) {
    const TopPoint top_point(measure, legs.lever);
    CornerCurves::Inner inner = inner_by_tolerance(legs, top_point, measure);
    for (int round = 0; round < most_narrowings; ++round) {
        const auto curves = CornerCurves::make(legs, top_point, link, inner);
        if (!curves) return std::nullopt;
        RoundedCorner corner = Representation(at, legs, *curves, hull).make();
        double use = measure.use_of(corner.extent.tip, corner.extent.turn, corner.extent.height);
        if (!measure.has_arm()) use = std::max(use, NearestPlaces(at, legs, measure).use(corner));
        if (use <= 1) return corner;
        inner.bottom_mm *= narrowed_to / use;
        inner.top_mm *= narrowed_to / use;
    }
    return std::nullopt;
}

}  // namespace trunnion::smoothing
