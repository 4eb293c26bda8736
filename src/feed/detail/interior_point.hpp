#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "trunnion/feed/feed_planner.hpp"

#include "detail/screening.hpp"

namespace trunnion::feed {

/// Factors ≥ 1 on the rows at an interval's samples, for what a cubic does between them.
struct Tightening {
    using OfSamples = std::array<double, samples_per_interval>;
    std::array<OfSamples, coordinates> acceleration, jerk;
    OfSamples speed{1, 1, 1};  ///< on x/cap
    /// Which rows must stand at the samples at all. Found once an interval, by the first window that sees it.
    std::optional<std::array<NeededRows, samples_per_interval>> needed;
    Tightening() {
        acceleration.fill({1, 1, 1});
        jerk.fill({1, 1, 1});
    }
};

/// A limit of a coordinate.
struct LimitName {
    enum class Order : std::uint8_t { velocity, acceleration, jerk } order = Order::velocity;
    int coordinate = 0;
};

/// The arc of constant jerk that leads from or to a standstill, as the core sees it: x′ = ±κx at the joint, x ≤ cap
/// there, time = weight · x^(−½).
struct ArcJoint {
    double kappa = 0, cap = 0, weight = 0;
    LimitName held_by;  ///< what makes the cap
};

/// What one solve works on: the intervals between the arcs.
struct CoreProblem {
    std::span<const Interval> intervals;     ///< at least 1
    std::span<const Tightening> tightening;  ///< as many, with their needed rows
    const LimitSet* limits = nullptr;
    double calm = 0;
    std::size_t far_from =
        static_cast<std::size_t>(-1);  ///< from this interval on a little of every limit is left unused
    bool from_rest = false;            ///< else x and x′ at the first knot are fixed
    ArcJoint start;                    ///< when from_rest
    ArcJoint stop;
};

/// x, x′ at the knots (one more than intervals) and x″ at both ends of every interval.
struct Trajectory {
    static constexpr int idle_lanes = 4;  ///< that the last block may have beyond the last interval
    std::vector<double> x, d, e0, e1;
    void resize(std::size_t intervals);
};

struct SolveReport {
    bool converged = false;
    int iterations = 0;
};

/// Primal-dual interior point on a core problem: infeasible start, Mehrotra predictor-corrector, clipped exact
/// curvature. Minimises ∫ x^(−½) dp + calm · Σ ∫ (jerk/limit)² dt. Rows that no motion within the other limits can
/// reach are left out. Holds all memory; about 1 kB and 0.4 µs × iterations an interval.
class InteriorPoint {
  public:
    /// For the processor at hand; all of them compute the same bits.
    static std::unique_ptr<InteriorPoint> make();
    virtual ~InteriorPoint() = default;

    /// `guess` must satisfy the end conditions and have x > 0 at all knots and middles.
    virtual void begin(const CoreProblem& problem, const Trajectory& guess) = 0;
    /// Runs until the gap is below `gap` of the time and the other two tests hold, at most `max_iterations`.
    virtual SolveReport run(double gap, int max_iterations) = 0;
    /// Takes the same problem with more tightening over and goes on from the present iterate.
    virtual void retighten(const CoreProblem& problem) = 0;
    virtual const Trajectory& trajectory() const = 0;
    /// What more of each limit is worth to the first `count` intervals and, from rest, the arc before them: multipliers
    /// of the last iterate.
    virtual void add_worth(std::size_t count, Worth& worth) const = 0;
};

namespace baseline {
std::unique_ptr<InteriorPoint> make_interior_point();
}
#ifdef TRUNNION_WITH_AVX2
namespace avx2 {
std::unique_ptr<InteriorPoint> make_interior_point();
}
#endif

}  // namespace trunnion::feed
