#pragma once

#include <array>
#include <optional>

#include "trunnion/numeric/taylor3.hpp"
#include "trunnion/smoothing/corner.hpp"

/// The link u_top = f(u_bottom) between the parameters of the two curves of a rounded corner. It decides how the tool
/// turns: with f(u) = u already the first derivative of the orientation jumps at the joins.
/// docs/theory/corner-rounding.md
namespace trunnion::smoothing {

/// df/du and its derivatives at the entry; at the exit the same of the mirrored link 1 − f(1 − u), so that both ends
/// are seen from outside.
struct LinkEnd {
    double first = 1, second = 0, third = 0;
};

/// The end that makes the orientation's first and second derivative by path length continuous at the join of a rounded
/// corner to a ruled segment, and its third as nearly so as a link can: only the part across the direction of motion
/// stays, [σ³ κ′_top n_top − κ′_bottom n_bottom]/height. For each curve a = 6 (L2 − L1), b = 12 (3 L1 − 2 L2),
/// c = −12 ((7 + cos α) L1 − 4 L2), and with σ = `rate` = dl_top/dl_bottom on the segment
///
///     f′ = σ a_b/a_t,   f″ = (σ b_b − b_t f′²)/a_t,   f‴ = (σ c_b − c_t f′³ − 3 b_t f′ f″)/a_t.
///
/// Precondition: L2 > L1 > 0 at both. No allocation.
LinkEnd closed_link_end(const CornerSide& bottom, const CornerSide& top, double rate) noexcept;

/// u_top = f(u_bottom): increasing, f(0) = 0, f(1) = 1, one polynomial of degree 7. Immutable, no allocation.
class ParameterLink {
  public:
    /// f(u) = u.
    static ParameterLink linear() noexcept { return ParameterLink({1}, {1}); }

    /// The polynomial with these ends. Nothing where f′ > 0 does not hold on all of [0, 1]: decided by the Bernstein
    /// coefficients of f′, subdivided, not by samples; a minimum below 1e-9 of the largest coefficient counts as not
    /// positive. Cost 0.2 µs.
    static std::optional<ParameterLink> through(const LinkEnd& entry, const LinkEnd& exit) noexcept;

    /// f and its derivatives by u, u in [0, 1]. Exact at both ends. 12 ns.
    Taylor3 at(double u) const noexcept;

    /// The u in [0, 1] with f(u) = value, to 1e-15 where f′ is of order 1; `value` in [0, 1]. Newton within a bracket,
    /// at most 100 steps; about 0.3 µs.
    double inverse(double value) const noexcept;

  private:
    /// Σ c_k u^(k + 1): the constant is 0.
    using Powers = std::array<double, 7>;

    ParameterLink(const Powers& from_entry, const Powers& from_exit) : sides_{from_entry, from_exit} {}
    bool increases() const noexcept;

    std::array<Powers, 2> sides_;  // of f and of 1 − f(1 − u): each is used on its own half, where it is accurate
};

/// The closed form at both ends of a corner. Nothing where the polynomial through it does not increase.
std::optional<ParameterLink> closed_link(const DualCorner& corner) noexcept;

}  // namespace trunnion::smoothing
