#pragma once

#include <algorithm>
#include <cmath>

#include "detail/interior_point.hpp"
#include "detail/screening.hpp"
#include "detail/stage.hpp"

/// The interior point itself; the passes over its rows are written once and compiled for every kind of processor.
namespace trunnion::feed::TRUNNION_VARIANT {

constexpr double slack_floor = 0.05;
constexpr double warm_slack_floor = 1e-3;
constexpr double residual_limit = 1e-5;  // of a limit
constexpr double promise_limit = 1e-4;
constexpr double straightness = 1e-3;  // weight of (h²x″/x)² in the time of an interval
constexpr double far_margin = 5e-3;    // so that a later window, which starts on this plan, has room around it
constexpr double boundary_fraction = 0.99, positivity_fraction = 0.9;
constexpr double most_calm_screened = 2e-3;  // with more smoothness asked, every coordinate's jerk counts
constexpr int points = samples_per_interval;
constexpr std::array<double, points> simpson{1.0 / 6, 4.0 / 6, 1.0 / 6};

inline double step_to_boundary(double block) {
    return block > 0 ? std::min(1.0, boundary_fraction / block) : 1.0;
}

template <class T>
inline PointState mapped(const PointMap<Pack>& m, const T& s) {
    return {s.x + m.reach * s.d + m.v_e0 * s.e0 + m.v_e1 * s.e1, s.d + m.d_e0 * s.e0 + m.d_e1 * s.e1,
            m.e_e0 * s.e0 + m.e_e1 * s.e1};
}

inline Symmetric3<Pack> symmetric(const Hessian& g) {
    return {g.vv, g.vd, g.ve, g.dd, g.de, g.ee};
}

inline StageMatrix<double> lane_of(const StageMatrix<Pack>& m, int i) {
    return {m.xx[i], m.xd[i], m.x0[i], m.x1[i], m.dd[i], m.d0[i], m.d1[i], m.e00[i], m.e01[i], m.e11[i]};
}
inline StageVector<double> lane_of(const StageVector<Pack>& g, int i) {
    return {g.x[i], g.d[i], g.e0[i], g.e1[i]};
}

inline StageVector<Pack> stage_vector(const Gradient& left, const Gradient& middle, const Gradient& right,
                                      const PointMap<Pack>& to_middle, const PointMap<Pack>& to_right) {
    StageVector<Pack> out{left.v, left.d, left.e, Pack{}};
    add_pullback(middle.v, middle.d, middle.e, to_middle, out);
    add_pullback(right.v, right.d, right.e, to_right, out);
    return out;
}

/// Stage right-hand side of one lane with the pull of the state behind it.
inline StageVector<double> with_pull(const StageVector<Pack>& own, int i, const Pull& pull, double h) {
    StageVector<double> out = lane_of(own, i);
    add_pull(pull, h, out);
    return out;
}

inline unsigned tightened(const std::array<Tightening::OfSamples, coordinates>& factors, int point) {
    unsigned out = 0;
    for (int c = 0; c < coordinates; ++c) out |= factors[c][point] > 1 ? 1u << c : 0;
    return out;
}

/// Coordinates that move at a place.
inline unsigned moving(const PathSample& sample) {
    unsigned out = 0;
    for (int c = 0; c < programmed_feed; ++c) out |= sample.q1[c] != 0 ? 1u << c : 0;
    return out;
}

inline void reset(Bound& bound, Pack c, double floor, double mu) {
    bound.t = max(c, floor);
    bound.z = mu / bound.t;
    bound.dt = bound.dz = Pack{};
}

/// After the coefficients grew: t stays where it still lies below c, else t = max(c, floor); z stays, and a row that is
/// new begins at μ.
inline void warm(Bound& bound, Pack c, double floor, double mu) {
    if (bound.z[0] == 0) return reset(bound, c, floor, mu);
    bound.t = bound.t <= c ? bound.t : max(c, floor);
    bound.dt = bound.dz = Pack{};
}

inline LimitName fastest(const PathSample& s, const LimitSet& limits) {
    LimitName out;
    double most = 0;
    for (int c = 0; c < coordinates; ++c) {
        const double rate = std::abs(s.q1[c]) / limits.of[c].velocity;
        if (rate <= most) continue;
        most = rate;
        out.coordinate = c;
    }
    return out;
}

/// A cap of x grows with the square of a velocity, with an acceleration, and on an arc with a jerk to 2/3.
inline void add_worth_of_cap(const LimitName& held_by, double per_cap, Worth& worth) {
    LimitWorth& to = worth[held_by.coordinate];
    switch (held_by.order) {
        case LimitName::Order::velocity:
            to.velocity_s += 2 * per_cap;
            break;
        case LimitName::Order::acceleration:
            to.acceleration_s += per_cap;
            break;
        case LimitName::Order::jerk:
            to.jerk_s += 2.0 / 3 * per_cap;
    }
}

/// Takes the multipliers and slacks of rows that stood before.
template <class List>
inline void take_over(const List& old, List& now) {
    for (std::size_t point = 0; point + 1 < now.first.size(); ++point) {
        std::uint32_t from = old.first[point];
        for (std::uint32_t to = now.first[point]; to < now.first[point + 1]; ++to) {
            while (from < old.first[point + 1] && old.coordinate[from] < now.coordinate[to]) ++from;
            if (from == old.first[point + 1] || old.coordinate[from] != now.coordinate[to]) continue;
            now.rows[to].plus = old.rows[from].plus;
            now.rows[to].minus = old.rows[from].minus;
        }
    }
}

static_assert(lanes == Trajectory::idle_lanes);

class Solver final : public InteriorPoint {
  public:
    void begin(const CoreProblem& problem, const Trajectory& guess) override;
    SolveReport run(double gap, int max_iterations) override;
    void retighten(const CoreProblem& problem) override;
    const Trajectory& trajectory() const override { return at_; }
    void add_worth(std::size_t count, Worth& worth) const override;

  private:
    /// Rows of one coordinate and order at the points of all blocks, point after point.
    template <class Row>
    struct RowList {
        std::vector<Row> rows;
        std::vector<std::uint8_t> coordinate;
        std::vector<std::uint32_t> first;  ///< of every point, and the end
        void clear();
        void add_point(unsigned mask);
        std::span<Row> of(std::size_t point) {
            return std::span(rows).subspan(first[point], first[point + 1] - first[point]);
        }
    };
    struct Block {
        std::array<PointRows, samples_per_interval> point;
        Pack h;
    };
    struct Direction {
        std::vector<double> x, d, e0, e1;
        void resize(std::size_t intervals);
    };
    struct Local {
        PointState left, middle, right;
        const PointState& operator[](int i) const { return i == 0 ? left : i == 1 ? middle : right; }
    };

    void scale_rows();
    void choose_rows();
    void build_rows();
    void fill_lane(std::size_t block, int lane);
    void fill_point(std::size_t block, int lane, int point);
    void add_joint(const ArcJoint& joint, std::size_t interval, int point);
    PointView view(std::size_t block, int point);
    template <class T>
    Local local(const T& from, std::size_t block) const;
    template <class Visit>
    void for_all_bounds(const Visit& visit);
    void backward();
    void backward_corrector();
    void finish_rows(double mu, double second_order);
    Pull start_pull(const Pull& pull) const;
    void forward(std::size_t k, const Feedforward& feed, Pull& at, Direction& out) const;
    void forward_affine_and_centring();
    void forward_corrector();
    double positive_step() const;
    void combine(double mu, double second_order);
    void advance(double primal);
    bool done(double gap_limit) const;
    double time() const;

    CoreProblem problem_;
    Trajectory at_;
    std::size_t count_ = 0, blocks_ = 0;
    double rows_ = 0, mu_ = 0;
    double primal_ = 0, dual_ = 0;  // sizes of the step not yet applied to t and z
    double time_ = 0;
    std::vector<Block> blocks_data_;
    RowList<JerkRow> jerk_, old_jerk_;
    RowList<AccelerationRow> acceleration_, old_acceleration_;
    std::vector<StageGain> gain_;
    std::vector<Feedforward> feed_affine_, feed_centring_, feed_corrector_;
    Direction affine_, centring_, corrector_, step_;
    CostToGo start_cost_;
    Pull pull_affine_, pull_centring_, pull_corrector_;
    RowState state_;
    AffineSums sums_;
    StepBlocks step_blocks_;
};

inline void Solver::Direction::resize(std::size_t intervals) {
    for (std::vector<double>* part : {&x, &d, &e0, &e1}) part->assign(intervals + 1 + lanes, 0);
}

template <class Row>
inline void Solver::RowList<Row>::clear() {
    coordinate.clear();
    first.assign(1, 0);
}

template <class Row>
inline void Solver::RowList<Row>::add_point(unsigned mask) {
    for (int c = 0; c < coordinates; ++c)
        if (mask >> c & 1) coordinate.push_back(static_cast<std::uint8_t>(c));
    first.push_back(static_cast<std::uint32_t>(coordinate.size()));
}

inline void Solver::begin(const CoreProblem& problem, const Trajectory& guess) {
    problem_ = problem;
    count_ = problem.intervals.size();
    blocks_ = (count_ + lanes - 1) / lanes;
    at_ = guess;
    for (Direction* direction : {&affine_, &centring_, &corrector_, &step_}) direction->resize(count_);
    for (auto* feed : {&feed_affine_, &feed_centring_, &feed_corrector_}) feed->resize(count_);
    gain_.resize(count_);
    blocks_data_.resize(blocks_);
    scale_rows();
    choose_rows();
    build_rows();
    time_ = time();
    mu_ = 2 * time_ / rows_;
    primal_ = dual_ = 0;
    for_all_bounds([this](Bound& bound, Pack c) { reset(bound, c, slack_floor, mu_); });
}

/// w of the rows: √x where the solve starts.
inline void Solver::scale_rows() {
    for (std::size_t k = 0; k < lanes * blocks_; ++k) {
        auto& point = blocks_data_[k / lanes].point;
        for (int i = 0; i < points; ++i) point[i].w[k % lanes] = k < count_ ? std::sqrt(at_.x[k + (i == 2)]) : 1;
    }
}

/// At an interval's right end acceleration is the next interval's left row, unless it is tightened.
inline void Solver::choose_rows() {
    jerk_.clear();
    acceleration_.clear();
    for (std::size_t b = 0; b < blocks_; ++b)
        for (int i = 0; i < points; ++i) {
            NeededRows needed;
            for (std::size_t k = lanes * b; k < std::min(lanes * (b + 1), count_); ++k) {
                const Tightening& tight = problem_.tightening[k];
                const NeededRows& own = (*tight.needed)[i];
                needed.jerk |= own.jerk | tightened(tight.jerk, i);
                if (problem_.calm > most_calm_screened) needed.jerk |= moving(problem_.intervals[k].samples[i]);
                needed.acceleration |= (i == 2 ? 0 : own.acceleration) | tightened(tight.acceleration, i);
            }
            jerk_.add_point(needed.jerk);
            acceleration_.add_point(needed.acceleration);
        }
    jerk_.rows.assign(jerk_.coordinate.size(), JerkRow{});
    acceleration_.rows.assign(acceleration_.coordinate.size(), AccelerationRow{});
    rows_ = lanes * static_cast<double>(points * blocks_ + 2 * jerk_.rows.size() + 2 * acceleration_.rows.size());
}

inline void Solver::build_rows() {
    for (std::size_t b = 0; b < blocks_; ++b)
        for (int lane = 0; lane < lanes; ++lane) fill_lane(b, lane);
    if (problem_.from_rest)
        add_joint(problem_.start, 0, 0);
    else
        blocks_data_[0].point[0].inverse_cap[0] = 0;
    add_joint(problem_.stop, count_ - 1, 2);
}

inline void Solver::fill_lane(std::size_t block, int lane) {
    const std::size_t interval = lanes * block + lane;
    if (interval < count_) {
        blocks_data_[block].h[lane] = problem_.intervals[interval].length_mm;
        for (int i = 0; i < points; ++i) fill_point(block, lane, i);
        return;
    }
    blocks_data_[block].h[lane] = 0;  // and no row has a coefficient
    for (PointRows& rows : blocks_data_[block].point)
        rows.time_weight[lane] = rows.calm_weight[lane] = rows.bend_weight[lane] = rows.inverse_cap[lane] = 0;
}

inline void Solver::fill_point(std::size_t block, int lane, int point) {
    const std::size_t interval = lanes * block + lane;
    PointRows& rows = blocks_data_[block].point[point];
    const double h = problem_.intervals[interval].length_mm, w = rows.w[lane];
    const PathSample& s = problem_.intervals[interval].samples[point];
    const Tightening& tight = problem_.tightening[interval];
    const double use = interval >= problem_.far_from ? 1 + far_margin : 1;
    rows.time_weight[lane] = h * simpson[point];
    rows.calm_weight[lane] = problem_.calm * h * simpson[point] / (w * w);
    const double bend = h * h / (w * w);
    rows.bend_weight[lane] = point == 1 ? 0 : straightness * h / w * bend * bend;
    double inverse_cap = 0;
    for (int c = 0; c < coordinates; ++c) {
        const double rate = s.q1[c] / problem_.limits->of[c].velocity;
        inverse_cap = std::max(inverse_cap, rate * rate);
    }
    rows.inverse_cap[lane] = use * tight.speed[point] * inverse_cap;
    const std::size_t at = points * block + point;
    for (std::size_t r = jerk_.first[at]; r < jerk_.first[at + 1]; ++r) {
        const int c = jerk_.coordinate[r];
        const double scale = use * w * tight.jerk[c][point] / problem_.limits->of[c].jerk;
        jerk_.rows[r].v[lane] = scale * s.q3[c];
        jerk_.rows[r].d[lane] = 1.5 * scale * s.q2[c];
        jerk_.rows[r].e[lane] = 0.5 * scale * s.q1[c];
    }
    const bool constant = point == 0 && interval == 0 && !problem_.from_rest;  // a fixed state
    for (std::size_t r = acceleration_.first[at]; r < acceleration_.first[at + 1]; ++r) {
        const int c = acceleration_.coordinate[r];
        const double scale = constant ? 0 : use * tight.acceleration[c][point] / problem_.limits->of[c].acceleration;
        acceleration_.rows[r].v[lane] = scale * s.q2[c];
        acceleration_.rows[r].d[lane] = 0.5 * scale * s.q1[c];
    }
}

inline void Solver::add_joint(const ArcJoint& joint, std::size_t interval, int point) {
    PointRows& rows = blocks_data_[interval / lanes].point[point];
    const std::size_t lane = interval % lanes;
    rows.time_weight[lane] += joint.weight;
    rows.inverse_cap[lane] = std::max(rows.inverse_cap[lane], 1 / joint.cap);
}

inline PointView Solver::view(std::size_t block, int point) {
    const std::size_t at = points * block + point;
    return {blocks_data_[block].point[point], jerk_.of(at), acceleration_.of(at)};
}

/// States (or steps) at the three points of a block. An idle lane stands where the last interval ends.
template <class T>
Solver::Local Solver::local(const T& from, std::size_t block) const {
    const std::size_t k = lanes * block;
    const struct {
        Pack x, d, e0, e1;
    } s{load(&from.x[k]), load(&from.d[k]), load(&from.e0[k]), load(&from.e1[k])};
    return {{s.x, s.d, s.e0},
            mapped(middle_map(blocks_data_[block].h), s),
            {load(&from.x[k + 1]), load(&from.d[k + 1]), s.e1}};
}

template <class Visit>
inline void Solver::for_all_bounds(const Visit& visit) {
    for (std::size_t b = 0; b < blocks_; ++b) {
        const Local u = local(at_, b);
        for (int i = 0; i < points; ++i) for_each_bound(view(b, i), u[i], visit);
    }
}

[[gnu::flatten]] inline void Solver::backward() {
    RowState state;
    CostToGo cost;
    Pull affine, centring;
    for (std::size_t b = blocks_; b-- > 0;) {
        const Local u = local(at_, b);
        const PointSystem left = assemble(view(b, 0), u.left, primal_, dual_, state);
        const PointSystem middle = assemble(view(b, 1), u.middle, primal_, dual_, state);
        const PointSystem right = assemble(view(b, 2), u.right, primal_, dual_, state);
        const Pack h = blocks_data_[b].h;
        const PointMap<Pack> to_middle = middle_map(h), to_right = right_map(h);
        StageMatrix<Pack> own{left.matrix.vv,
                              left.matrix.vd,
                              left.matrix.ve,
                              {},
                              left.matrix.dd,
                              left.matrix.de,
                              {},
                              left.matrix.ee,
                              {},
                              {}};
        add_congruence(symmetric(middle.matrix), to_middle, own);
        add_congruence(symmetric(right.matrix), to_right, own);
        const StageVector<Pack> ga = stage_vector(left.affine, middle.affine, right.affine, to_middle, to_right);
        const StageVector<Pack> gc = stage_vector(left.centring, middle.centring, right.centring, to_middle, to_right);
        for (int i = lanes; i-- > 0;) {
            const std::size_t k = lanes * b + i;
            if (k >= count_) continue;
            StageMatrix<double> m = lane_of(own, i);
            add_cost(cost, h[i], m);
            gain_[k] = eliminate(m, h[i], {k + 1 == count_, problem_.stop.kappa}, cost);
            feed_affine_[k] = eliminate(gain_[k], with_pull(ga, i, affine, h[i]), affine);
            feed_centring_[k] = eliminate(gain_[k], with_pull(gc, i, centring, h[i]), centring);
        }
    }
    state_ = state;
    start_cost_ = cost;
    pull_affine_ = start_pull(affine);
    pull_centring_ = start_pull(centring);
}

/// The step of the first state: none when it is fixed, along (1, κ) on a rest arc.
inline Pull Solver::start_pull(const Pull& pull) const {
    if (!problem_.from_rest) return {};
    const double kappa = problem_.start.kappa;
    const double y =
        (pull.x + kappa * pull.d) / (start_cost_.xx + kappa * (2 * start_cost_.xd + kappa * start_cost_.dd));
    return {y, kappa * y};
}

/// One step of a direction over interval k.
inline void Solver::forward(std::size_t k, const Feedforward& feed, Pull& at, Direction& out) const {
    const StageGain& g = gain_[k];
    const double h = problem_.intervals[k].length_mm, x = at.x, d = at.d;
    const double e0 = feed.e0 - g.k0x * x - g.k0d * d, e1 = feed.e1 - g.k1x * x - g.k1d * d - g.k1e * e0;
    out.x[k] = x;
    out.d[k] = d;
    out.e0[k] = e0;
    out.e1[k] = e1;
    at.x += h * (d + h * (e0 / 3 + e1 / 6));
    at.d += h * (e0 + e1) / 2;
    out.x[k + 1] = at.x;
    out.d[k + 1] = at.d;
}

/// Both directions that are known after the backward pass: one's arithmetic fills the waits of the other's.
inline void Solver::forward_affine_and_centring() {
    Pull affine = pull_affine_, centring = pull_centring_;
    for (std::size_t k = 0; k < count_; ++k) {
        forward(k, feed_affine_[k], affine, affine_);
        forward(k, feed_centring_[k], centring, centring_);
    }
}

inline void Solver::forward_corrector() {
    Pull at = pull_corrector_;
    for (std::size_t k = 0; k < count_; ++k) forward(k, feed_corrector_[k], at, corrector_);
}

[[gnu::flatten]] inline void Solver::backward_corrector() {
    AffineSums sums;
    Pull pull;
    for (std::size_t b = blocks_; b-- > 0;) {
        const Local u = local(at_, b), du = local(affine_, b);
        const Gradient left = affine_step(view(b, 0), u.left, du.left, sums);
        const Gradient middle = affine_step(view(b, 1), u.middle, du.middle, sums);
        const Gradient right = affine_step(view(b, 2), u.right, du.right, sums);
        const Pack h = blocks_data_[b].h;
        const StageVector<Pack> own = stage_vector(left, middle, right, middle_map(h), right_map(h));
        for (int i = lanes; i-- > 0;) {
            const std::size_t k = lanes * b + i;
            if (k < count_) feed_corrector_[k] = eliminate(gain_[k], with_pull(own, i, pull, h[i]), pull);
        }
    }
    sums_ = sums;
    pull_corrector_ = start_pull(pull);
}

[[gnu::flatten]] inline double Solver::positive_step() const {
    Pack worst{};
    for (std::size_t b = 0; b < blocks_; ++b) {
        const Local u = local(at_, b), du = local(step_, b);
        worst = max(worst, max(-du.left.v / u.left.v, max(-du.middle.v / u.middle.v, -du.right.v / u.right.v)));
    }
    const double block = max_lane(worst);
    return block > 0 ? std::min(1.0, positivity_fraction / block) : 1.0;
}

inline void Solver::combine(double mu, double second_order) {
    const auto add = [&](std::vector<double>& out, const std::vector<double>& a, const std::vector<double>& b,
                         const std::vector<double>& c) {
        for (std::size_t k = 0; k < out.size(); ++k) out[k] = a[k] + mu * b[k] + second_order * c[k];
    };
    add(step_.x, affine_.x, centring_.x, corrector_.x);
    add(step_.d, affine_.d, centring_.d, corrector_.d);
    add(step_.e0, affine_.e0, centring_.e0, corrector_.e0);
    add(step_.e1, affine_.e1, centring_.e1, corrector_.e1);
}

[[gnu::flatten]] inline void Solver::finish_rows(double mu, double second_order) {
    StepBlocks blocks;
    for (std::size_t b = 0; b < blocks_; ++b) {
        const Local u = local(at_, b), du = local(step_, b);
        final_step(view(b, 0), u.left, du.left, mu, second_order, blocks);
        final_step(view(b, 1), u.middle, du.middle, mu, second_order, blocks);
        final_step(view(b, 2), u.right, du.right, mu, second_order, blocks);
    }
    step_blocks_ = blocks;
}

inline void Solver::advance(double primal) {
    for (std::size_t k = 0; k <= count_; ++k) at_.x[k] += primal * step_.x[k];
    for (std::size_t k = 0; k <= count_; ++k) at_.d[k] += primal * step_.d[k];
    for (std::size_t k = 0; k < count_; ++k) at_.e0[k] += primal * step_.e0[k];
    for (std::size_t k = 0; k < count_; ++k) at_.e1[k] += primal * step_.e1[k];
}

[[gnu::flatten]] inline double Solver::time() const {
    Pack total{};
    for (std::size_t b = 0; b < blocks_; ++b) {
        const Local u = local(at_, b);
        const auto& point = blocks_data_[b].point;
        total += point[0].time_weight / sqrt(u.left.v) + point[1].time_weight / sqrt(u.middle.v) +
                 point[2].time_weight / sqrt(u.right.v);
    }
    return sum(total);
}

inline bool Solver::done(double gap_limit) const {
    return sum(state_.gap) < gap_limit * time_ && max_lane(state_.residual) < residual_limit &&
           std::abs(sum(sums_.promise)) < std::max(gap_limit, promise_limit) * time_;
}

inline SolveReport Solver::run(double gap_limit, int max_iterations) {
    SolveReport report;
    for (; report.iterations < max_iterations; ++report.iterations) {
        backward();
        primal_ = dual_ = 0;  // applied
        forward_affine_and_centring();
        backward_corrector();
        if (done(gap_limit)) {
            report.converged = true;
            break;
        }
        if (!std::isfinite(sum(sums_.promise))) break;
        forward_corrector();
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
        primal_ = std::min(step_to_boundary(max_lane(step_blocks_.primal)), positive_step());
        dual_ = step_to_boundary(max_lane(step_blocks_.dual));
        advance(primal_);
        time_ = time();
    }
    return report;
}

inline void Solver::retighten(const CoreProblem& problem) {
    problem_ = problem;
    std::swap(jerk_, old_jerk_);
    std::swap(acceleration_, old_acceleration_);
    choose_rows();
    take_over(old_jerk_, jerk_);
    take_over(old_acceleration_, acceleration_);
    build_rows();
    primal_ = dual_ = 0;
    for_all_bounds([this](Bound& bound, Pack c) { warm(bound, c, warm_slack_floor, mu_); });
}

inline void Solver::add_worth(std::size_t count, Worth& worth) const {
    for (std::size_t k = 0; k < std::min(count, count_); ++k) {
        const std::size_t b = k / lanes, lane = k % lanes;
        const Local u = local(at_, b);
        for (int i = 0; i < points; ++i) {
            const PointRows& point = blocks_data_[b].point[i];
            const PathSample& s = problem_.intervals[k].samples[i];
            const double speed = -point.speed.z[lane] * u[i].v[lane] * point.inverse_cap[lane];
            const bool at_start = k == 0 && i == 0 && problem_.from_rest, at_stop = k + 1 == count_ && i == points - 1;
            const ArcJoint* joint = at_start ? &problem_.start : at_stop ? &problem_.stop : nullptr;
            const bool by_arc = joint && 1 / joint->cap >= point.inverse_cap[lane];
            add_worth_of_cap(by_arc ? joint->held_by : fastest(s, *problem_.limits), speed, worth);
            const std::size_t at = points * b + i;
            for (std::size_t r = jerk_.first[at]; r < jerk_.first[at + 1]; ++r) {
                const JerkRow& row = jerk_.rows[r];
                worth[jerk_.coordinate[r]].jerk_s -=
                    (row.plus.z[lane] - row.minus.z[lane]) * rows::load_of(row, u[i])[lane];
            }
            for (std::size_t r = acceleration_.first[at]; r < acceleration_.first[at + 1]; ++r) {
                const AccelerationRow& row = acceleration_.rows[r];
                worth[acceleration_.coordinate[r]].acceleration_s -=
                    (row.plus.z[lane] - row.minus.z[lane]) * rows::load_of(row, u[i])[lane];
            }
        }
    }
}

}  // namespace trunnion::feed::TRUNNION_VARIANT
