#pragma once

#include <array>
#include <span>
#include <vector>

#include "trunnion/feed/interval.hpp"

#include "detail/rows.hpp"
#include "detail/stage.hpp"

namespace trunnion::feed {

/// Factors ≥ 1 on an interval's rows, for what a cubic does between the points where rows stand.
struct Tightening {
    std::array<double, machine::max_axes> acceleration{1, 1, 1, 1, 1}, jerk{1, 1, 1, 1, 1};
    double speed = 1;  ///< on x/cap
};

/// The arc of constant jerk that leads from or to a standstill, as the core sees it: x′ = ±κx at the joint, x ≤ cap
/// there, time = weight · x^(−½).
struct ArcJoint {
    double kappa = 0, cap = 0, weight = 0;
};

/// What one solve works on: the intervals between the arcs.
struct CoreProblem {
    std::span<const Interval> intervals;     ///< at least 1
    std::span<const Tightening> tightening;  ///< as many
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
    std::vector<double> x, d, e0, e1;
    void resize(std::size_t intervals);
};

struct SolveReport {
    bool converged = false;
    int iterations = 0;
};

/// Primal-dual interior point on a core problem: infeasible start, Mehrotra predictor-corrector, clipped exact
/// curvature. Minimises ∫ x^(−½) dp + calm · Σ ∫ (jerk/limit)² dt. Holds all memory; about 2.5 kB and 1.5 µs ×
/// iterations an interval.
class InteriorPoint {
  public:
    /// `guess` must satisfy the end conditions and have x > 0 at all knots and middles.
    void begin(const CoreProblem& problem, const Trajectory& guess);
    /// Runs until the gap is below `gap` of the time and the other two tests hold, at most `max_iterations`.
    SolveReport run(double gap, int max_iterations);
    /// Takes the same problem with more tightening over and goes on from the present iterate.
    void retighten(const CoreProblem& problem);
    const Trajectory& trajectory() const { return at_; }

  private:
    struct Block {
        std::array<PointRows, 3> point;
        Pack h;
    };
    struct Direction {
        std::vector<double> x, d, e0, e1;
        void resize(std::size_t intervals);
    };
    struct Local {
        PointState left, middle, right;
    };

    void scale_rows();
    void build_rows();
    void fill_lane(Block& block, int lane, std::size_t interval);
    void add_joint(const ArcJoint& joint, std::size_t interval, int point);
    template <class T>
    Local local(const T& from, std::size_t block, double idle_v) const;
    void reset(double floor);
    void backward();
    void backward_corrector();
    void finish_rows(double mu, double second_order);
    Pull start_pull(const Pull& pull) const;
    void forward(const std::vector<Feedforward>& feed, const Pull& start, Direction& out) const;
    double positive_step(const Direction& step) const;
    void combine(double mu, double second_order);
    void advance(double primal);
    bool done(double gap_limit) const;
    double time() const;

    CoreProblem problem_;
    Trajectory at_;
    std::size_t count_ = 0, blocks_ = 0;
    int axes_ = 0;
    std::array<int, machine::max_axes> axis_{};
    double rows_ = 0, mu_ = 0;
    double primal_ = 0, dual_ = 0;  // sizes of the step not yet applied to t and z
    double time_ = 0;
    std::vector<Block> blocks_data_;
    std::vector<StageGain> gain_;
    std::vector<Feedforward> feed_affine_, feed_centring_, feed_corrector_;
    Direction affine_, centring_, corrector_, step_;
    CostToGo start_cost_;
    Pull pull_affine_, pull_centring_, pull_corrector_;
    RowState state_;
    AffineSums sums_;
    StepBlocks step_blocks_;
};

}  // namespace trunnion::feed
