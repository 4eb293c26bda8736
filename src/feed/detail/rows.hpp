#pragma once

#include <array>

#include "trunnion/machine/machine.hpp"

#include "detail/pack.hpp"

/// The inequalities at one point of an interval (two intervals side by side), as functions of x = v, x′ = d, x″ = e:
///     speed   c = 1 − v/cap
///     accel   c = 1 ∓ (q″v + ½q′d)/A
///     jerk    c = R ∓ w(q‴v + 3/2 q″d + ½q′e)/J,  R = w v^(−½)
/// and what the primal-dual method does with them. w makes R = 1 at the starting point and is inside the coefficients.
namespace trunnion::feed {

/// One inequality c ≥ 0 with slack t and multiplier z; dt, dz: their step (between the two halves of an iteration dt
/// holds the second-order product of the affine step).
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

struct PointRows {
    Pack time_weight;  ///< the objective has time_weight · v^(−½)
    Pack calm_weight;  ///< and calm_weight · √v Σ (w L)²
    Pack bend_weight;  ///< and bend_weight · e²: an interval of which no row sees the shape between the points stays
                       ///< straight
    Pack inverse_cap;
    Pack w;
    Bound speed;
    std::array<JerkRow, machine::max_axes> jerk;
    std::array<AccelerationRow, machine::max_axes> acceleration;
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

/// Which inequalities stand at a point. At an interval's right end acceleration is the next interval's left row.
enum class RowSet { all, without_acceleration };

/// t = max(c, floor), z = μ/t.
template <RowSet set>
void reset_rows(PointRows& rows, int axes, const PointState& at, double floor, double mu);

/// After the coefficients grew: t stays where it still lies below c, else t = max(c, floor); z stays.
template <RowSet set>
void warm_rows(PointRows& rows, int axes, const PointState& at, double floor);

/// Applies the last step (sizes `primal`, `dual`) to t and z, then builds the Newton system.
template <RowSet set>
PointSystem assemble(PointRows& rows, int axes, const PointState& at, double primal, double dual, RowState& state);

/// The affine step; returns the right-hand side of the corrector.
template <RowSet set>
Gradient affine_step(PointRows& rows, int axes, const PointState& at, const PointState& step, AffineSums& sums);

struct StepBlocks {
    Pack primal{}, dual{};
};

/// The final step towards μ; `second_order` 1 or 0 takes or leaves the corrector.
template <RowSet set>
void final_step(PointRows& rows, int axes, const PointState& at, const PointState& step, double mu, double second_order,
                StepBlocks& blocks);

}  // namespace trunnion::feed
