#include "detail/interior_point.hpp"

#include <algorithm>
#include <cmath>

namespace trunnion::feed {
namespace {

constexpr double slack_floor = 0.05;
constexpr double warm_slack_floor = 1e-3;
constexpr double residual_limit = 1e-5;  // of a limit
constexpr double promise_limit = 1e-4;
constexpr double straightness = 1e-3;  // weight of (h²x″/x)² in the time of an interval
constexpr double far_margin = 5e-3;    // so that a later window, which starts on this plan, has room around it
constexpr double boundary_fraction = 0.99, positivity_fraction = 0.9;
constexpr std::array<int, 3> row_samples{0, samples_per_interval / 2, samples_per_interval - 1};
constexpr std::array<double, 3> simpson{1.0 / 6, 4.0 / 6, 1.0 / 6};

double step_to_boundary(double block) {
    return block > 0 ? std::min(1.0, boundary_fraction / block) : 1.0;
}

template <class T>
PointState mapped(const PointMap<Pack>& m, const T& s) {
    return {s.x + m.reach * s.d + m.v_e0 * s.e0 + m.v_e1 * s.e1, s.d + m.d_e0 * s.e0 + m.d_e1 * s.e1,
            m.e_e0 * s.e0 + m.e_e1 * s.e1};
}

Symmetric3<Pack> symmetric(const Hessian& g) {
    return {g.vv, g.vd, g.ve, g.dd, g.de, g.ee};
}

template <class From>
StageMatrix<double> lane_of(const From& m, int i) {
    return {m.xx[i], m.xd[i], m.x0[i], m.x1[i], m.dd[i], m.d0[i], m.d1[i], m.e00[i], m.e01[i], m.e11[i]};
}
StageVector<double> lane_of(const StageVector<Pack>& g, int i) {
    return {g.x[i], g.d[i], g.e0[i], g.e1[i]};
}

Symmetric3<double> lane_with(const Hessian& g, int i, const CostToGo& cost) {
    return {g.vv[i] + cost.xx, g.vd[i] + cost.xd, g.ve[i], g.dd[i] + cost.dd, g.de[i], g.ee[i]};
}

/// Stage right-hand side of one lane, the state behind it included.
StageVector<double> with_right(const StageVector<Pack>& inner, const Gradient& right, int i, const Pull& pull,
                               const PointMap<double>& map) {
    StageVector<double> out = lane_of(inner, i);
    add_pullback(right.v[i] + pull.x, right.d[i] + pull.d, right.e[i], map, out);
    return out;
}

StageVector<Pack> inner_vector(const Gradient& left, const Gradient& middle, const PointMap<Pack>& map) {
    StageVector<Pack> out{left.v, left.d, left.e, Pack{}};
    add_pullback(middle.v, middle.d, middle.e, map, out);
    return out;
}

}  // namespace

void Trajectory::resize(std::size_t intervals) {
    x.assign(intervals + 1 + lanes, 0);
    d.assign(intervals + 1 + lanes, 0);
    e0.assign(intervals + lanes, 0);
    e1.assign(intervals + lanes, 0);
}

void InteriorPoint::Direction::resize(std::size_t intervals) {
    for (std::vector<double>* part : {&x, &d, &e0, &e1}) part->assign(intervals + 1 + lanes, 0);
}

void InteriorPoint::begin(const CoreProblem& problem, const Trajectory& guess) {
    problem_ = problem;
    count_ = problem.intervals.size();
    blocks_ = (count_ + lanes - 1) / lanes;
    at_ = guess;
    for (Direction* direction : {&affine_, &centring_, &corrector_, &step_}) direction->resize(count_);
    for (auto* feed : {&feed_affine_, &feed_centring_, &feed_corrector_}) feed->resize(count_);
    gain_.resize(count_);
    blocks_data_.resize(blocks_);
    scale_rows();
    build_rows();
    time_ = time();
    mu_ = 2 * time_ / rows_;
    reset(slack_floor);
}

/// w of the rows: √x where the solve starts.
void InteriorPoint::scale_rows() {
    for (std::size_t k = 0; k < lanes * blocks_; ++k) {
        auto& point = blocks_data_[k / lanes].point;
        for (int i = 0; i < 3; ++i) point[i].w[k % lanes] = k < count_ ? std::sqrt(at_.x[k + (i == 2)]) : 1;
    }
}

void InteriorPoint::build_rows() {
    axes_ = 0;
    for (int a = 0; a < problem_.limits->count; ++a) {
        const bool moves = std::ranges::any_of(problem_.intervals, [a](const Interval& interval) {
            return std::ranges::any_of(interval.samples,
                                       [a](const PathSample& s) { return s.q1[a] != 0 || s.q2[a] != 0; });
        });
        if (moves) axis_[axes_++] = a;
    }
    rows_ = static_cast<double>(count_) * (3 + 10 * axes_);
    for (std::size_t b = 0; b < blocks_; ++b)
        for (int lane = 0; lane < lanes; ++lane) fill_lane(blocks_data_[b], lane, lanes * b + lane);
    if (problem_.from_rest)
        add_joint(problem_.start, 0, 0);
    else
        blocks_data_[0].point[0].inverse_cap[0] = 0;
    add_joint(problem_.stop, count_ - 1, 2);
}

void InteriorPoint::fill_lane(Block& block, int lane, std::size_t interval) {
    const bool idle = interval >= count_;
    const double h = idle ? 0 : problem_.intervals[interval].length_mm;
    block.h[lane] = h;
    for (int k = 0; k < 3; ++k) {
        PointRows& rows = block.point[k];
        const std::size_t row = idle ? count_ - 1 : interval;
        const PathSample& s = problem_.intervals[row].samples[row_samples[k]];
        const Tightening& tight = problem_.tightening[row];
        const double use = idle ? 0 : interval >= problem_.far_from ? 1 + far_margin : 1, w = rows.w[lane];
        rows.time_weight[lane] = h * simpson[k];
        rows.calm_weight[lane] = problem_.calm * h * simpson[k] / (w * w);
        const double bend = h * h / (w * w);
        rows.bend_weight[lane] = k == 1 ? 0 : straightness * h / w * bend * bend;
        double inverse_cap = 1 / s.feed_cap;
        const bool drop = k == 0 && interval == 0 && !problem_.from_rest;  // a fixed state: these rows are constants
        for (int i = 0; i < axes_; ++i) {
            const int a = axis_[i];
            const machine::AxisLimits& limit = problem_.limits->axes[a];
            const double rate = s.q1[a] / limit.velocity;
            inverse_cap = std::max(inverse_cap, rate * rate);
            const double jerk = use * w * tight.jerk[a] / limit.jerk;
            rows.jerk[i].v[lane] = jerk * s.q3[a];
            rows.jerk[i].d[lane] = 1.5 * jerk * s.q2[a];
            rows.jerk[i].e[lane] = 0.5 * jerk * s.q1[a];
            const double acceleration = drop ? 0 : use * tight.acceleration[a] / limit.acceleration;
            rows.acceleration[i].v[lane] = acceleration * s.q2[a];
            rows.acceleration[i].d[lane] = 0.5 * acceleration * s.q1[a];
        }
        rows.inverse_cap[lane] = use * tight.speed * inverse_cap;
    }
}

void InteriorPoint::add_joint(const ArcJoint& joint, std::size_t interval, int point) {
    PointRows& rows = blocks_data_[interval / lanes].point[point];
    const std::size_t lane = interval % lanes;
    rows.time_weight[lane] += joint.weight;
    rows.inverse_cap[lane] = std::max(rows.inverse_cap[lane], 1 / joint.cap);
}

/// States (or steps) at the three points of a block; an idle lane stands still at x = idle_v.
template <class T>
InteriorPoint::Local InteriorPoint::local(const T& from, std::size_t block, double idle_v) const {
    const std::size_t k = lanes * block;
    struct {
        Pack x, d, e0, e1;
    } s{load(&from.x[k]), load(&from.d[k]), load(&from.e0[k]), load(&from.e1[k])};
    Pack right_x = load(&from.x[k + 1]), right_d = load(&from.d[k + 1]);
    if (k + 1 == count_) {
        s.x[1] = right_x[1] = idle_v;
        s.d[1] = right_d[1] = s.e0[1] = s.e1[1] = 0;
    }
    return {{s.x, s.d, s.e0}, mapped(middle_map(blocks_data_[block].h), s), {right_x, right_d, s.e1}};
}

void InteriorPoint::reset(double floor) {
    primal_ = dual_ = 0;
    for (std::size_t b = 0; b < blocks_; ++b) {
        const Local u = local(at_, b, 1);
        auto& point = blocks_data_[b].point;
        reset_rows<RowSet::all>(point[0], axes_, u.left, floor, mu_);
        reset_rows<RowSet::all>(point[1], axes_, u.middle, floor, mu_);
        reset_rows<RowSet::without_acceleration>(point[2], axes_, u.right, floor, mu_);
    }
}

void InteriorPoint::backward() {
    state_ = {};
    CostToGo cost;
    Pull affine, centring;
    for (std::size_t b = blocks_; b-- > 0;) {
        const Local u = local(at_, b, 1);
        Block& block = blocks_data_[b];
        const PointSystem left = assemble<RowSet::all>(block.point[0], axes_, u.left, primal_, dual_, state_);
        const PointSystem middle = assemble<RowSet::all>(block.point[1], axes_, u.middle, primal_, dual_, state_);
        const PointSystem right =
            assemble<RowSet::without_acceleration>(block.point[2], axes_, u.right, primal_, dual_, state_);
        const PointMap<Pack> map = middle_map(block.h);
        StageMatrix<Pack> inner{left.matrix.vv,
                                left.matrix.vd,
                                left.matrix.ve,
                                {},
                                left.matrix.dd,
                                left.matrix.de,
                                {},
                                left.matrix.ee,
                                {},
                                {}};
        add_congruence(symmetric(middle.matrix), map, inner);
        const StageVector<Pack> ga = inner_vector(left.affine, middle.affine, map);
        const StageVector<Pack> gc = inner_vector(left.centring, middle.centring, map);
        for (int i = lanes; i-- > 0;) {
            const std::size_t k = lanes * b + i;
            if (k >= count_) continue;
            const double h = block.h[i];
            const PointMap<double> to_right = right_map(h);
            StageMatrix<double> m = lane_of(inner, i);
            add_congruence(lane_with(right.matrix, i, cost), to_right, m);
            const StageVector<double> va = with_right(ga, right.affine, i, affine, to_right);
            const StageVector<double> vc = with_right(gc, right.centring, i, centring, to_right);
            gain_[k] = eliminate(m, h, {k + 1 == count_, problem_.stop.kappa}, cost);
            feed_affine_[k] = eliminate(gain_[k], va, affine);
            feed_centring_[k] = eliminate(gain_[k], vc, centring);
        }
    }
    start_cost_ = cost;
    pull_affine_ = start_pull(affine);
    pull_centring_ = start_pull(centring);
}

/// The step of the first state: none when it is fixed, along (1, κ) on a rest arc.
Pull InteriorPoint::start_pull(const Pull& pull) const {
    if (!problem_.from_rest) return {};
    const double kappa = problem_.start.kappa;
    const double y =
        (pull.x + kappa * pull.d) / (start_cost_.xx + kappa * (2 * start_cost_.xd + kappa * start_cost_.dd));
    return {y, kappa * y};
}

void InteriorPoint::forward(const std::vector<Feedforward>& feed, const Pull& start, Direction& out) const {
    double x = start.x, d = start.d;
    for (std::size_t k = 0; k < count_; ++k) {
        const StageGain& g = gain_[k];
        const double h = problem_.intervals[k].length_mm;
        const double e0 = feed[k].e0 - g.k0x * x - g.k0d * d, e1 = feed[k].e1 - g.k1x * x - g.k1d * d - g.k1e * e0;
        out.x[k] = x;
        out.d[k] = d;
        out.e0[k] = e0;
        out.e1[k] = e1;
        x += h * (d + h * (e0 / 3 + e1 / 6));
        d += h * (e0 + e1) / 2;
    }
    out.x[count_] = x;
    out.d[count_] = d;
}

void InteriorPoint::backward_corrector() {
    sums_ = {};
    Pull pull;
    for (std::size_t b = blocks_; b-- > 0;) {
        const Local u = local(at_, b, 1), du = local(affine_, b, 0);
        Block& block = blocks_data_[b];
        const Gradient left = affine_step<RowSet::all>(block.point[0], axes_, u.left, du.left, sums_);
        const Gradient middle = affine_step<RowSet::all>(block.point[1], axes_, u.middle, du.middle, sums_);
        const Gradient right =
            affine_step<RowSet::without_acceleration>(block.point[2], axes_, u.right, du.right, sums_);
        const StageVector<Pack> inner = inner_vector(left, middle, middle_map(block.h));
        for (int i = lanes; i-- > 0;) {
            const std::size_t k = lanes * b + i;
            if (k >= count_) continue;
            feed_corrector_[k] =
                eliminate(gain_[k], with_right(inner, right, i, pull, right_map<double>(block.h[i])), pull);
        }
    }
    pull_corrector_ = start_pull(pull);
}

double InteriorPoint::positive_step(const Direction& step) const {
    Pack worst{};
    for (std::size_t b = 0; b < blocks_; ++b) {
        const Local u = local(at_, b, 1), du = local(step, b, 0);
        worst = max(worst, max(-du.left.v / u.left.v, max(-du.middle.v / u.middle.v, -du.right.v / u.right.v)));
    }
    const double block = max_lane(worst);
    return block > 0 ? std::min(1.0, positivity_fraction / block) : 1.0;
}

void InteriorPoint::combine(double mu, double second_order) {
    const auto add = [&](std::vector<double>& out, const std::vector<double>& a, const std::vector<double>& b,
                         const std::vector<double>& c) {
        for (std::size_t k = 0; k < out.size(); ++k) out[k] = a[k] + mu * b[k] + second_order * c[k];
    };
    add(step_.x, affine_.x, centring_.x, corrector_.x);
    add(step_.d, affine_.d, centring_.d, corrector_.d);
    add(step_.e0, affine_.e0, centring_.e0, corrector_.e0);
    add(step_.e1, affine_.e1, centring_.e1, corrector_.e1);
}

void InteriorPoint::finish_rows(double mu, double second_order) {
    step_blocks_ = {};
    for (std::size_t b = 0; b < blocks_; ++b) {
        const Local u = local(at_, b, 1), du = local(step_, b, 0);
        auto& point = blocks_data_[b].point;
        final_step<RowSet::all>(point[0], axes_, u.left, du.left, mu, second_order, step_blocks_);
        final_step<RowSet::all>(point[1], axes_, u.middle, du.middle, mu, second_order, step_blocks_);
        final_step<RowSet::without_acceleration>(point[2], axes_, u.right, du.right, mu, second_order, step_blocks_);
    }
}

void InteriorPoint::advance(double primal) {
    for (std::size_t k = 0; k <= count_; ++k) at_.x[k] += primal * step_.x[k];
    for (std::size_t k = 0; k <= count_; ++k) at_.d[k] += primal * step_.d[k];
    for (std::size_t k = 0; k < count_; ++k) at_.e0[k] += primal * step_.e0[k];
    for (std::size_t k = 0; k < count_; ++k) at_.e1[k] += primal * step_.e1[k];
}

double InteriorPoint::time() const {
    Pack total{};
    for (std::size_t b = 0; b < blocks_; ++b) {
        const Local u = local(at_, b, 1);
        const auto& point = blocks_data_[b].point;
        total += point[0].time_weight / sqrt(u.left.v) + point[1].time_weight / sqrt(u.middle.v) +
                 point[2].time_weight / sqrt(u.right.v);
    }
    return sum(total);
}

bool InteriorPoint::done(double gap_limit) const {
    return sum(state_.gap) < gap_limit * time_ && max_lane(state_.residual) < residual_limit &&
           std::abs(sum(sums_.promise)) < std::max(gap_limit, promise_limit) * time_;
}

SolveReport InteriorPoint::run(double gap_limit, int max_iterations) {
    SolveReport report;
    for (; report.iterations < max_iterations; ++report.iterations) {
        backward();
        primal_ = dual_ = 0;  // applied
        forward(feed_affine_, pull_affine_, affine_);
        forward(feed_centring_, pull_centring_, centring_);
        backward_corrector();
        if (done(gap_limit)) {
            report.converged = true;
            break;
        }
        if (!std::isfinite(sum(sums_.promise))) break;
        forward(feed_corrector_, pull_corrector_, corrector_);
        const double gap = sum(state_.gap);
        const double ap = step_to_boundary(max_lane(sums_.primal_block)),
                     ad = step_to_boundary(max_lane(sums_.dual_block));
        const double z_dt = sum(sums_.z_dt);
        const double gap_affine = gap + ap * z_dt - ad * (gap + z_dt) + ap * ad * sum(sums_.dt_dz);
        const bool blocked = std::min(ap, ad) < 0.1;
        const double ratio = std::max(gap_affine / gap, 0.0);
        const double sigma = blocked ? 0.9 : std::clamp(ratio * ratio * ratio, 1e-3, 0.9);
        mu_ = sigma * gap / rows_;
        combine(mu_, blocked ? 0 : 1);
        finish_rows(mu_, blocked ? 0 : 1);
        primal_ = std::min(step_to_boundary(max_lane(step_blocks_.primal)), positive_step(step_));
        dual_ = step_to_boundary(max_lane(step_blocks_.dual));
        advance(primal_);
        time_ = time();
    }
    return report;
}

void InteriorPoint::retighten(const CoreProblem& problem) {
    problem_ = problem;
    build_rows();
    primal_ = dual_ = 0;
    for (std::size_t b = 0; b < blocks_; ++b) {
        const Local u = local(at_, b, 1);
        auto& point = blocks_data_[b].point;
        warm_rows<RowSet::all>(point[0], axes_, u.left, warm_slack_floor);
        warm_rows<RowSet::all>(point[1], axes_, u.middle, warm_slack_floor);
        warm_rows<RowSet::without_acceleration>(point[2], axes_, u.right, warm_slack_floor);
    }
}

}  // namespace trunnion::feed
