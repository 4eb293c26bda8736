#pragma once

#include <span>

#include "detail/pack.hpp"

/// The inequalities at one point of an interval (four intervals side by side), as functions of x = v, x′ = d, x″ = e:
///     speed   c = 1 − v/cap
///     accel   c = 1 ∓ (q″v + ½q′d)/A
///     jerk    c = R ∓ w(q‴v + 3/2 q″d + ½q′e)/J,  R = w v^(−½)
/// and what the primal-dual method does with them. w makes R = 1 at the starting point and is inside the coefficients.
namespace trunnion::feed::TRUNNION_VARIANT {

/// One inequality c ≥ 0 with slack t and multiplier z; dt, dz: their step. Between the parts of an iteration dt holds
/// the second-order product of the affine step, and dz holds 1/t.
struct Bound {
    Pack t, z, dt, dz;
};

struct JerkRow {
    Pack v, d, e;
    Bound plus, minus;
};

struct AccelerationRow {
    Pack v, d;
    Bound plus, minus;
};

/// What every point has. Its jerk and acceleration rows lie in lists of their own, for most coordinates need none.
struct PointRows {
    Pack time_weight;  ///< the objective has time_weight · v^(−½)
    Pack calm_weight;  ///< and calm_weight · √v Σ (w L)²
    Pack bend_weight;  ///< and bend_weight · e²: an interval of which no row sees the shape between the points stays
                       ///< straight
    Pack inverse_cap;
    Pack w;
    Bound speed;
};

struct PointState {
    Pack v, d, e;
};

struct Gradient {
    Pack v{}, d{}, e{};
};

struct Hessian {
    Pack vv{}, vd{}, ve{}, dd{}, de{}, ee{};
};

/// Newton system of a point: matrix, right-hand side of the affine step, and what μ adds to it.
struct PointSystem {
    Hessian matrix;
    Gradient affine, centring;
};

/// Accumulated over all rows of an assembly.
struct RowState {
    Pack gap{};       ///< Σ t z
    Pack residual{};  ///< max (t − c)
};

/// Accumulated over all rows of an affine step.
struct AffineSums {
    Pack primal_block{}, dual_block{};  ///< max −dt/t, max −dz/z
    Pack z_dt{}, dt_dz{};
    Pack promise{};  ///< −∇f·step: what the objective still gains
};

struct StepBlocks {
    Pack primal{}, dual{};
};

/// One point with the rows that stand there.
struct PointView {
    PointRows& rows;
    std::span<JerkRow> jerk;
    std::span<AccelerationRow> acceleration;
};

namespace rows {

/// R and dR/dv.
struct Reciprocal {
    Pack value, slope;
};

inline Reciprocal jerk_room(const PointRows& at, Pack v) {
    const Pack value = at.w / sqrt(v);
    return {value, -0.5 * value / v};
}

inline Pack load_of(const JerkRow& row, const PointState& at) {
    return row.v * at.v + row.d * at.d + row.e * at.e;
}
inline Pack load_of(const AccelerationRow& row, const PointState& at) {
    return row.v * at.v + row.d * at.d;
}

/// What a bound gives to the Newton system: curvature z/t, pull z/t (c − t), 1/t.
struct Terms {
    Pack curvature, pull, inverse;
};

inline Terms advance(Bound& bound, Pack c, double primal, double dual, RowState& state) {
    bound.t += primal * bound.dt;
    bound.z += dual * bound.dz;
    state.gap += bound.t * bound.z;
    const Pack room = c - bound.t, inverse = 1 / bound.t;
    state.residual = max(state.residual, -room);
    bound.dz = inverse;
    const Pack curvature = bound.z * inverse;
    return {curvature, curvature * room, inverse};
}

/// Affine dt, dz; returns −dt dz/t and leaves dt dz in bound.dt.
inline Pack affine(Bound& bound, Pack c, Pack change, AffineSums& sums) {
    const Pack dt = change + (c - bound.t);
    const Pack ratio = dt * bound.dz;
    const Pack dz = -bound.z * (1 + ratio);
    sums.primal_block = max(sums.primal_block, -ratio);
    sums.dual_block = max(sums.dual_block, 1 + ratio);
    sums.z_dt += bound.z * dt;
    bound.dt = dt * dz;
    sums.dt_dz += bound.dt;
    return -ratio * dz;
}

inline void finish(Bound& bound, Pack c, Pack change, double mu, double second_order, StepBlocks& blocks) {
    const Pack dt = change + (c - bound.t);
    const Pack inverse = bound.dz;
    bound.dz = inverse * (mu - second_order * bound.dt - bound.z * dt) - bound.z;
    bound.dt = dt;
    blocks.primal = max(blocks.primal, -dt * inverse);
    blocks.dual = max(blocks.dual, -bound.dz / bound.z);
}

inline void add_objective(const PointRows& at, Pack v, Pack jerk_multipliers, Reciprocal room, PointSystem& out) {
    const Pack inverse = 1 / v;
    const Pack slope = 0.5 * at.time_weight * inverse / sqrt(v);
    const Pack curvature = 1.5 * slope * inverse;
    out.affine.v += slope;
    // The rows' own curvature, never more than the objective's: the matrix stays positive.
    out.matrix.vv += curvature - min(0.75 * room.value * inverse * inverse * jerk_multipliers, curvature);
}

inline void add_speed(PointRows& at, Pack v, double primal, double dual, RowState& state, PointSystem& out) {
    const Pack k = at.inverse_cap;
    const Terms t = advance(at.speed, 1 - v * k, primal, dual, state);
    out.matrix.vv += t.curvature * k * k;
    out.affine.v += t.pull * k;
    out.centring.v -= t.inverse * k;
}

inline void add_acceleration(AccelerationRow& row, const PointState& at, double primal, double dual, RowState& state,
                             PointSystem& out) {
    const Pack load = load_of(row, at);
    const Terms p = advance(row.plus, 1 - load, primal, dual, state),
                m = advance(row.minus, 1 + load, primal, dual, state);
    const Pack s = p.curvature + m.curvature, pull = p.pull - m.pull, centre = m.inverse - p.inverse;
    out.matrix.vv += s * row.v * row.v;
    out.matrix.vd += s * row.v * row.d;
    out.matrix.dd += s * row.d * row.d;
    out.affine.v += pull * row.v;
    out.affine.d += pull * row.d;
    out.centring.v += centre * row.v;
    out.centring.d += centre * row.d;
}

/// Weights of the smoothness term at a point: of l lᵀ, of −L l, and of −L² along v.
struct Calm {
    Pack outer, slope, along_v;
};

inline Calm calm_of(const PointRows& at, Pack v) {
    const Pack root = at.calm_weight * sqrt(v);
    return {2.0 * root, 2.0 * root, 0.5 * root / v};
}

inline Pack add_jerk(JerkRow& row, const PointState& at, Reciprocal room, const Calm& calm, double primal, double dual,
                     RowState& state, PointSystem& out) {
    const Pack load = load_of(row, at);
    const Terms p = advance(row.plus, room.value - load, primal, dual, state);
    const Terms m = advance(row.minus, room.value + load, primal, dual, state);
    const Pack s = p.curvature + m.curvature, skew = (m.curvature - p.curvature) * room.slope, outer = s + calm.outer;
    Hessian& g = out.matrix;
    g.vv += outer * row.v * row.v + 2.0 * skew * row.v + s * room.slope * room.slope;
    g.vd += row.d * (outer * row.v + skew);
    g.ve += row.e * (outer * row.v + skew);
    g.dd += outer * row.d * row.d;
    g.de += outer * row.d * row.e;
    g.ee += outer * row.e * row.e;
    const Pack pull = p.pull - m.pull - calm.slope * load, centre = m.inverse - p.inverse;
    out.affine.v += pull * row.v - (p.pull + m.pull) * room.slope - calm.along_v * load * load;
    out.affine.d += pull * row.d;
    out.affine.e += pull * row.e;
    out.centring.v += centre * row.v + (p.inverse + m.inverse) * room.slope;
    out.centring.d += centre * row.d;
    out.centring.e += centre * row.e;
    return row.plus.z + row.minus.z;
}

}  // namespace rows

/// Calls visit(bound, c) for every inequality of a point.
template <class Visit>
void for_each_bound(const PointView& point, const PointState& at, const Visit& visit) {
    const rows::Reciprocal room = rows::jerk_room(point.rows, at.v);
    visit(point.rows.speed, 1 - at.v * point.rows.inverse_cap);
    for (JerkRow& row : point.jerk) {
        const Pack load = rows::load_of(row, at);
        visit(row.plus, room.value - load);
        visit(row.minus, room.value + load);
    }
    for (AccelerationRow& row : point.acceleration) {
        const Pack load = rows::load_of(row, at);
        visit(row.plus, 1 - load);
        visit(row.minus, 1 + load);
    }
}

/// Applies the last step (sizes `primal`, `dual`) to t and z, then builds the Newton system.
inline PointSystem assemble(const PointView& point, const PointState& at, double primal, double dual, RowState& state) {
    PointSystem out;
    PointRows& own = point.rows;
    const rows::Reciprocal room = rows::jerk_room(own, at.v);
    const rows::Calm calm = rows::calm_of(own, at.v);
    rows::add_speed(own, at.v, primal, dual, state, out);
    Pack multipliers{};
    for (JerkRow& row : point.jerk) multipliers += rows::add_jerk(row, at, room, calm, primal, dual, state, out);
    rows::add_objective(own, at.v, multipliers, room, out);
    out.matrix.ee += 2.0 * own.bend_weight;
    out.affine.e -= 2.0 * own.bend_weight * at.e;
    for (AccelerationRow& row : point.acceleration) rows::add_acceleration(row, at, primal, dual, state, out);
    return out;
}

/// The affine step; returns the right-hand side of the corrector.
inline Gradient affine_step(const PointView& point, const PointState& at, const PointState& step, AffineSums& sums) {
    Gradient out;
    PointRows& own = point.rows;
    const rows::Reciprocal room = rows::jerk_room(own, at.v);
    const rows::Calm calm = rows::calm_of(own, at.v);
    const Pack room_change = room.slope * step.v;
    sums.promise += 0.5 * own.time_weight / (at.v * sqrt(at.v)) * step.v - 2.0 * own.bend_weight * at.e * step.e;
    const Pack k = own.inverse_cap;
    out.v -= k * rows::affine(own.speed, 1 - at.v * k, -k * step.v, sums);
    for (JerkRow& row : point.jerk) {
        const Pack load = rows::load_of(row, at), change = rows::load_of(row, step);
        const Pack p = rows::affine(row.plus, room.value - load, room_change - change, sums);
        const Pack m = rows::affine(row.minus, room.value + load, room_change + change, sums);
        sums.promise -= load * (calm.slope * change + calm.along_v * load * step.v);
        out.v += (p + m) * room.slope + (m - p) * row.v;
        out.d += (m - p) * row.d;
        out.e += (m - p) * row.e;
    }
    for (AccelerationRow& row : point.acceleration) {
        const Pack load = rows::load_of(row, at), change = rows::load_of(row, step);
        const Pack p = rows::affine(row.plus, 1 - load, -change, sums),
                   m = rows::affine(row.minus, 1 + load, change, sums);
        out.v += (m - p) * row.v;
        out.d += (m - p) * row.d;
    }
    return out;
}

/// The final step towards μ; `second_order` 1 or 0 takes or leaves the corrector.
inline void final_step(const PointView& point, const PointState& at, const PointState& step, double mu,
                       double second_order, StepBlocks& blocks) {
    PointRows& own = point.rows;
    const rows::Reciprocal room = rows::jerk_room(own, at.v);
    const Pack room_change = room.slope * step.v;
    const Pack k = own.inverse_cap;
    rows::finish(own.speed, 1 - at.v * k, -k * step.v, mu, second_order, blocks);
    for (JerkRow& row : point.jerk) {
        const Pack load = rows::load_of(row, at), change = rows::load_of(row, step);
        rows::finish(row.plus, room.value - load, room_change - change, mu, second_order, blocks);
        rows::finish(row.minus, room.value + load, room_change + change, mu, second_order, blocks);
    }
    for (AccelerationRow& row : point.acceleration) {
        const Pack load = rows::load_of(row, at), change = rows::load_of(row, step);
        rows::finish(row.plus, 1 - load, -change, mu, second_order, blocks);
        rows::finish(row.minus, 1 + load, change, mu, second_order, blocks);
    }
}

}  // namespace trunnion::feed::TRUNNION_VARIANT
