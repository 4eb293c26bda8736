#pragma once

#include <array>

#include <Eigen/Core>

#include "trunnion/base/result.hpp"
#include "trunnion/machine/machine.hpp"
#include "trunnion/numeric/taylor3.hpp"

namespace trunnion::machine {

/// Where the tool is, seen from the part.
struct Pose {
    Eigen::Vector3d tip_in_workpiece_mm;
    Eigen::Vector3d axis_in_workpiece;  ///< unit, tip → spindle
};

using RotaryPosition =
    std::array<double, max_rotary_axes>;  ///< rad, order of the machine's rotary axes, control's count
using RotarySeries = std::array<Taylor3, max_rotary_axes>;
using VectorSeries = std::array<Taylor3, 3>;

/// The positions of the rotary axes that give an orientation, one per branch, without winding: each in (−π, π]. A
/// motion that meets neither pole nor rim keeps the index of its branch.
struct RotarySolutions {
    std::array<RotaryPosition, 2> rotary_rad{};
    int count = 0;            ///< 0: the orientation cannot be reached; 1: one axis, the pole, or where branches meet
    bool degenerate = false;  ///< pole: the axis nearest to the workpiece may stand anywhere (then 0 is given, count 1)
};

/// The geometry of one machine with one tool and one workpiece frame.
///
/// Notation (ISO 841: every positive axis motion is that of the tool relative to the workpiece). The chain, read from
/// workpiece to tool, is a product of screws; with θ₁ the rotary axis nearest to the workpiece, θ₂ the next, a₁, a₂
/// their directions and e = e_z the tool at all axes 0, the tool axis in the machine frame is n = R₁(θ₁)R₂(θ₂)e: two
/// cones, of half angles e₁ = ∠(a₁, a₂) and e₂ = ∠(a₂, e), both taken in ]0, π/2]. The axes may lie in table, head or
/// both, in any order and direction.
///
/// Reach: with β = ∠(n, a₁), every |e₁ − e₂| ≤ β ≤ e₁ + e₂. At e₁ = e₂ that has a pole, β = 0, where θ₁ may stand
/// anywhere; with e₁ = e₂ = π/2 (A, B and C at right angles) it is all orientations and two poles. All else is a *rim*:
/// there the two branches meet, and the speed of θ₂ for an even motion of n grows without bound on the way to it.
/// All positions are in the control's count (`Axis::reversed`), all poses in the workpiece frame of the program.
///
/// Immutable after make(); every other function is noexcept, allocates nothing and is thread safe.
class Kinematics {
  public:
    /// `workpiece`: program zero in the machine frame, all axes at 0. `tool_length_mm`: gauge point → tip, along −Z.
    /// Errors: MACH0101 not exactly three linear axes whose directions span space, MACH0102 more than two rotary axes,
    /// MACH0103 two rotary axes within 1e-3 rad of parallel to each other, or the second to the tool: they tilt the
    /// tool about one direction only, or not at all.
    static Result<Kinematics> make(const Machine& machine, const Frame& workpiece, double tool_length_mm);

    int axis_count() const noexcept { return axis_count_; }
    int rotary_count() const noexcept { return rotary_count_; }
    /// Index (in RotaryPosition) of the rotary axis nearest to the workpiece; −1 with no rotary axis.
    int rotary_nearest_workpiece() const noexcept { return nearest_; }

    Pose forward(const AxisPosition& position) const noexcept;

    /// Tool axis in the workpiece of the given rotary positions.
    Eigen::Vector3d tool_axis(const RotaryPosition& rotary_rad) const noexcept;
    VectorSeries tool_axis(const RotarySeries& rotary) const noexcept;

    /// Closed form, by arc tangents alone: as accurate beside the pole as elsewhere. `axis_in_workpiece` is a unit
    /// vector. Count 0 where it lies outside the reach by more than 1e-6 rad; at the rim, and outside by less, the one
    /// solution nearest to it. Beside the rim angles are as good as the square root of rounding allows, the orientation
    /// they give is as good as elsewhere. Cost about 0.1 µs.
    /// Source: two cones, by the half-angle formulas of the spherical triangle; for `C A X Y Z` it is Lavernhe 2006,
    /// Eq. 3.
    RotarySolutions rotary_for(const Eigen::Vector3d& axis_in_workpiece) const noexcept;

    /// Linear axes that bring the tip to a place with the rotary axes as given, mm. Where linear axes on both sides of
    /// a rotary one come to lie in a plane there is no answer: the result is then not finite. Cost about 0.2 µs in
    /// series.
    std::array<double, 3> linear_for(const Eigen::Vector3d& tip_in_workpiece_mm,
                                     const RotaryPosition& rotary_rad) const noexcept;
    VectorSeries linear_for(const VectorSeries& tip, const RotarySeries& rotary) const noexcept;

    /// The other way: tip in the workpiece from the linear and rotary axes, mm.
    VectorSeries tip_for(const VectorSeries& linear, const RotarySeries& rotary) const noexcept;

    /// Series of the rotary axes from that of the tool axis (any length ≠ 0, normalised here), on the branch and
    /// winding nearest to `near_rad`: at right angles, where the branches stand half a turn of the first axis apart, by
    /// that axis and then by the other; inclined, where they come together at the rim, by the sum of both ways. Within
    /// 1e-8 rad of the pole the axis next to the workpiece keeps `near_rad` and zero derivatives. Derivatives are
    /// exact, to rounding, beside the pole too. An orientation out of reach gives the nearest one, with the derivatives
    /// of its foot point on the rim: all numbers stay finite; whether it was within reach rotary_for() says. Cost about
    /// 0.13 µs, inclined 0.3 µs.
    RotarySeries rotary_series(const VectorSeries& axis, const RotaryPosition& near_rad) const noexcept;

    /// How much the axis nearest to the workpiece turns the tool axis: |a₁ × n| = sin of the angle between tool and
    /// that axis, in [0, 1]; depends on the other rotary axis only. 1 with fewer than two rotary axes. Cost about 0.05
    /// µs.
    double lever(const RotaryPosition& rotary_rad) const noexcept;

  private:
    /// One rotary axis of the chain; the first stands nearest to the workpiece.
    struct Turn {
        Eigen::Vector3d direction = Eigen::Vector3d::UnitZ(), point_mm = Eigen::Vector3d::Zero();
        double sign = 1;        // control's count → ISO 841
        std::size_t index = 0;  // in RotaryPosition
    };
    /// The directions of the linear axes (columns, in the control's count) that stand between two turns of the chain.
    struct LinearGroup {
        Eigen::Matrix3d directions = Eigen::Matrix3d::Zero();
        bool used = false;
    };
    template <class S>
    struct Posture;  // sines and cosines of the turns

    template <class S>
    Posture<S> posture(const std::array<S, max_rotary_axes>& rotary) const noexcept;
    template <class S>
    std::array<S, 3> axis_of(const Posture<S>& posture) const noexcept;
    template <class S>
    std::array<S, 3> tip_of(const std::array<S, 3>& linear, const Posture<S>& posture) const noexcept;
    template <class S>
    std::array<S, 3> linear_of(const std::array<S, 3>& tip, const Posture<S>& posture) const noexcept;
    template <class S>
    std::array<S, 3> solve_mixed(const std::array<S, 3>& sum, int first, const Posture<S>& posture) const noexcept;
    template <class S>
    struct Triangle;  // the second turn and what it adds to the first; see orientation.cpp

    void prepare_orientation();
    void fold_cones();
    template <class S>
    Triangle<S> oblique_triangle(const S& radius, const S& height) const noexcept;
    Taylor3 oblique_turn_at_pole(const VectorSeries& n, double first_rad) const noexcept;
    RotarySolutions solutions_of_one(const Eigen::Vector3d& axis_in_workpiece) const noexcept;
    RotarySeries turn_of_one(const VectorSeries& n, const RotaryPosition& near_rad) const noexcept;
    RotarySeries right_angled_turns(const VectorSeries& n, const RotaryPosition& near_rad) const noexcept;
    RotarySeries oblique_turns(const VectorSeries& n, const RotaryPosition& near_rad) const noexcept;
    RotarySeries positions_of(const Taylor3& theta_first, const Taylor3& theta_last,
                              const RotaryPosition& near_rad) const noexcept;

    int axis_count_ = 0, rotary_count_ = 0, nearest_ = -1;
    std::array<Turn, max_rotary_axes> turns_{};
    std::array<LinearGroup, max_rotary_axes + 1> groups_{};  // group k stands behind k turns
    int only_group_ = -1;  // the group that holds all linear axes; −1: they are spread
    Eigen::Matrix3d only_inverse_ = Eigen::Matrix3d::Identity();
    Frame workpiece_;
    double tool_length_mm_ = 0;
    /// The half angles e₁, e₂ of the two cones and what follows from them; D = e₁ − e₂, S = e₁ + e₂.
    struct Cones {
        bool right_angles = true, pole = true;  // e₁ = e₂ = π/2; D = 0
        double cos_first = 0, sin_first = 1, sin_last = 1;
        double inner = 0, sin_inner = 0;  // 1 − cos D, sin D
        double outer = 2, beyond = 0;     // 1 − cos S, 1 + cos S
    };
    /// Workpiece → the frame in which the orientation is solved; see orientation.cpp.
    Eigen::Matrix3d to_orientation_frame_ = Eigen::Matrix3d::Identity();
    Cones cones_;
    double tool_angle_ = 0;    // rad: ψ₀, where the tool stands on the second cone with all axes at 0
    bool along_tool_ = false;  // the only rotary axis is parallel to the tool
};

}  // namespace trunnion::machine
