#include "detail/rows.hpp"

namespace trunnion::feed {
namespace {

struct Sides {
    Pack plus, minus;
};

/// R and dR/dv.
struct Reciprocal {
    Pack value, slope;
};

Reciprocal jerk_room(const PointRows& rows, Pack v) {
    const Pack value = rows.w / sqrt(v);
    return {value, -0.5 * value / v};
}

Pack load_of(const JerkRow& row, const PointState& at) {
    return row.v * at.v + row.d * at.d + row.e * at.e;
}
Pack load_of(const AccelerationRow& row, const PointState& at) {
    return row.v * at.v + row.d * at.d;
}

void reset(Bound& bound, Pack c, double floor, double mu) {
    bound.t = max(c, pack(floor));
    bound.z = mu / bound.t;
    bound.dt = bound.dz = Pack{};
}

void warm(Bound& bound, Pack c, double floor) {
    bound.t = bound.t <= c ? bound.t : max(c, pack(floor));
    bound.dt = bound.dz = Pack{};
}

/// What a bound gives to the Newton system: curvature z/t, pull z/t (c − t), 1/t.
struct Terms {
    Pack curvature, pull, inverse;
};

Terms advance(Bound& bound, Pack c, double primal, double dual, RowState& state) {
    bound.t += primal * bound.dt;
    bound.z += dual * bound.dz;
    state.gap += bound.t * bound.z;
    state.residual = max(state.residual, bound.t - c);
    const Pack inverse = 1 / bound.t;
    const Pack curvature = bound.z * inverse;
    return {curvature, curvature * (c - bound.t), inverse};
}

/// Affine dt, dz; returns −dt dz/t and leaves dt dz in bound.dt.
Pack affine(Bound& bound, Pack c, Pack change, AffineSums& sums) {
    const Pack dt = change + (c - bound.t);
    const Pack ratio = dt / bound.t;
    const Pack dz = -bound.z * (1 + ratio);
    sums.primal_block = max(sums.primal_block, -ratio);
    sums.dual_block = max(sums.dual_block, 1 + ratio);
    sums.z_dt += bound.z * dt;
    bound.dt = dt * dz;
    sums.dt_dz += bound.dt;
    return -ratio * dz;
}

void finish(Bound& bound, Pack c, Pack change, double mu, double second_order, StepBlocks& blocks) {
    const Pack dt = change + (c - bound.t);
    const Pack inverse = 1 / bound.t;
    bound.dz = inverse * (mu - second_order * bound.dt - bound.z * dt) - bound.z;
    bound.dt = dt;
    blocks.primal = max(blocks.primal, -dt * inverse);
    blocks.dual = max(blocks.dual, -bound.dz / bound.z);
}

void add_objective(const PointRows& rows, Pack v, Pack jerk_multipliers, Reciprocal room, PointSystem& out) {
    const Pack inverse = 1 / v;
    const Pack slope = 0.5 * rows.time_weight * inverse / sqrt(v);
    const Pack curvature = 1.5 * slope * inverse;
    out.affine.v += slope;
    // The rows' own curvature, never more than the objective's: the matrix stays positive.
    out.matrix.vv += curvature - min(0.75 * room.value * inverse * inverse * jerk_multipliers, curvature);
}

void add_speed(PointRows& rows, Pack v, double primal, double dual, RowState& state, PointSystem& out) {
    const Pack k = rows.inverse_cap;
    const Terms t = advance(rows.speed, 1 - v * k, primal, dual, state);
    out.matrix.vv += t.curvature * k * k;
    out.affine.v += t.pull * k;
    out.centring.v -= t.inverse * k;
}

void add_acceleration(AccelerationRow& row, const PointState& at, double primal, double dual, RowState& state,
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

Pack add_jerk(JerkRow& row, const PointState& at, Reciprocal room, const Calm& calm, double primal, double dual,
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

Calm calm_of(const PointRows& rows, Pack v) {
    const Pack root = rows.calm_weight * sqrt(v);
    return {2.0 * root, 2.0 * root, 0.5 * root / v};
}

}  // namespace

/// Calls visit(bound, c) for every inequality of a point.
template <RowSet set, class Visit>
void for_each_bound(PointRows& rows, int axes, const PointState& at, const Visit& visit) {
    const Reciprocal room = jerk_room(rows, at.v);
    visit(rows.speed, 1 - at.v * rows.inverse_cap);
    for (int a = 0; a < axes; ++a) {
        const Pack load = load_of(rows.jerk[a], at);
        visit(rows.jerk[a].plus, room.value - load);
        visit(rows.jerk[a].minus, room.value + load);
    }
    if constexpr (set == RowSet::without_acceleration) return;
    for (int a = 0; a < axes; ++a) {
        const Pack load = load_of(rows.acceleration[a], at);
        visit(rows.acceleration[a].plus, 1 - load);
        visit(rows.acceleration[a].minus, 1 + load);
    }
}

template <RowSet set>
void reset_rows(PointRows& rows, int axes, const PointState& at, double floor, double mu) {
    for_each_bound<set>(rows, axes, at, [=](Bound& bound, Pack c) { reset(bound, c, floor, mu); });
}

template <RowSet set>
void warm_rows(PointRows& rows, int axes, const PointState& at, double floor) {
    for_each_bound<set>(rows, axes, at, [=](Bound& bound, Pack c) { warm(bound, c, floor); });
}

template <RowSet set>
PointSystem assemble(PointRows& rows, int axes, const PointState& at, double primal, double dual, RowState& state) {
    PointSystem out;
    const Reciprocal room = jerk_room(rows, at.v);
    const Calm calm = calm_of(rows, at.v);
    add_speed(rows, at.v, primal, dual, state, out);
    Pack multipliers{};
    for (int a = 0; a < axes; ++a) multipliers += add_jerk(rows.jerk[a], at, room, calm, primal, dual, state, out);
    add_objective(rows, at.v, multipliers, room, out);
    out.matrix.ee += 2.0 * rows.bend_weight;
    out.affine.e -= 2.0 * rows.bend_weight * at.e;
    if constexpr (set == RowSet::all)
        for (int a = 0; a < axes; ++a) add_acceleration(rows.acceleration[a], at, primal, dual, state, out);
    return out;
}

template <RowSet set>
Gradient affine_step(PointRows& rows, int axes, const PointState& at, const PointState& step, AffineSums& sums) {
    Gradient out;
    const Reciprocal room = jerk_room(rows, at.v);
    const Calm calm = calm_of(rows, at.v);
    const Pack room_change = room.slope * step.v;
    sums.promise += 0.5 * rows.time_weight / (at.v * sqrt(at.v)) * step.v - 2.0 * rows.bend_weight * at.e * step.e;
    const Pack k = rows.inverse_cap;
    out.v -= k * affine(rows.speed, 1 - at.v * k, -k * step.v, sums);
    for (int a = 0; a < axes; ++a) {
        JerkRow& row = rows.jerk[a];
        const Pack load = load_of(row, at), change = load_of(row, step);
        const Pack p = affine(row.plus, room.value - load, room_change - change, sums);
        const Pack m = affine(row.minus, room.value + load, room_change + change, sums);
        sums.promise -= load * (calm.slope * change + calm.along_v * load * step.v);
        out.v += (p + m) * room.slope + (m - p) * row.v;
        out.d += (m - p) * row.d;
        out.e += (m - p) * row.e;
    }
    if constexpr (set == RowSet::without_acceleration) return out;
    for (int a = 0; a < axes; ++a) {
        AccelerationRow& row = rows.acceleration[a];
        const Pack load = load_of(row, at), change = load_of(row, step);
        const Pack p = affine(row.plus, 1 - load, -change, sums), m = affine(row.minus, 1 + load, change, sums);
        out.v += (m - p) * row.v;
        out.d += (m - p) * row.d;
    }
    return out;
}

template <RowSet set>
void final_step(PointRows& rows, int axes, const PointState& at, const PointState& step, double mu, double second_order,
                StepBlocks& blocks) {
    const Reciprocal room = jerk_room(rows, at.v);
    const Pack room_change = room.slope * step.v;
    const Pack k = rows.inverse_cap;
    finish(rows.speed, 1 - at.v * k, -k * step.v, mu, second_order, blocks);
    for (int a = 0; a < axes; ++a) {
        JerkRow& row = rows.jerk[a];
        const Pack load = load_of(row, at), change = load_of(row, step);
        finish(row.plus, room.value - load, room_change - change, mu, second_order, blocks);
        finish(row.minus, room.value + load, room_change + change, mu, second_order, blocks);
    }
    if constexpr (set == RowSet::without_acceleration) return;
    for (int a = 0; a < axes; ++a) {
        AccelerationRow& row = rows.acceleration[a];
        const Pack load = load_of(row, at), change = load_of(row, step);
        finish(row.plus, 1 - load, -change, mu, second_order, blocks);
        finish(row.minus, 1 + load, change, mu, second_order, blocks);
    }
}

template void reset_rows<RowSet::all>(PointRows&, int, const PointState&, double, double);
template void reset_rows<RowSet::without_acceleration>(PointRows&, int, const PointState&, double, double);
template void warm_rows<RowSet::all>(PointRows&, int, const PointState&, double);
template void warm_rows<RowSet::without_acceleration>(PointRows&, int, const PointState&, double);
template PointSystem assemble<RowSet::all>(PointRows&, int, const PointState&, double, double, RowState&);
template PointSystem assemble<RowSet::without_acceleration>(PointRows&, int, const PointState&, double, double,
                                                            RowState&);
template Gradient affine_step<RowSet::all>(PointRows&, int, const PointState&, const PointState&, AffineSums&);
template Gradient affine_step<RowSet::without_acceleration>(PointRows&, int, const PointState&, const PointState&,
                                                            AffineSums&);
template void final_step<RowSet::all>(PointRows&, int, const PointState&, const PointState&, double, double,
                                      StepBlocks&);
template void final_step<RowSet::without_acceleration>(PointRows&, int, const PointState&, const PointState&, double,
                                                       double, StepBlocks&);

}  // namespace trunnion::feed
