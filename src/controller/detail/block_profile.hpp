#pragma once

#include <array>
#include <vector>

#include "trunnion/machine/machine.hpp"
#include "trunnion/motion/controller.hpp"
#include "trunnion/motion/prediction.hpp"
#include "trunnion/path/run.hpp"

#include "detail/block_geometry.hpp"
#include "detail/block_ramp.hpp"

namespace trunnion::controller {

/// The speed along a run, in the space of the axes: all lengths there in mm, a rotary axis counted at the reference
/// radius.
struct SegmentSpeed {
    double length_mm = 0;
    std::array<double, machine::max_axes> direction{};  ///< axis units (mm, rad) per mm
    double from_mm_s = 0, peak_mm_s = 0, to_mm_s = 0;
    double rise_s = 0, cruise_s = 0, fall_s = 0;
    double rise_mm = 0, fall_mm = 0;
    double settle_s = 0;                        ///< standstill at its end
    motion::Limit limit, from_limit, to_limit;  ///< of the peak, and at both ends
    double acceleration_mm_s2 = 0;              ///< along the path, the highest on the way up or down
    double jerk_mm_s3 = 0;                      ///< of the ramps that the law of the speed stands for; NaN: no limit
    double duration_s() const { return rise_s + cruise_s + fall_s; }
};

/// Finds the speed along runs by the block model. Keeps its memory from run to run.
class BlockPlanner {
  public:
    /// Time that a run takes, s, its standstills' settling included. `speeds`: null, or what it consists of.
    double plan(const path::Run& run, const RunGeometry& geometry, const machine::Machine& machine,
                const motion::Controller& controller, std::vector<SegmentSpeed>* speeds);

  private:
    struct Piece {
        double length = 0;
        std::array<double, machine::max_axes> direction{};  // unit, mm of the axes' space
        double speed_limit = 0, acceleration = 0, jerk = 0;
        motion::Limit limit, acceleration_limit, jerk_limit;
    };
    struct Joint {
        double speed_limit = 0, speed = 0;
        motion::Limit limit;
        bool stop = false, bends = false;
    };
    struct Block {
        double length = 0, speed_limit = 0;
        std::array<double, machine::max_axes> chord{};
        std::uint32_t first = 0, behind = 0;  // pieces
        unsigned moving = 0;                  // axes, as bits
        motion::LimitKind limit{};
    };

    void read_settings(const machine::Machine& machine, const motion::Controller& controller);
    void measure();
    void limit_by_feed(const Segment& segment, Piece& piece) const;
    void limit_by_axes(Piece& piece) const;
    void gather_blocks();
    void limit_by_cycle();
    void limit_by_preparation();
    void limit_joints();
    void limit_curve(double length, const Piece& before, const Piece& after, double tolerance, motion::LimitKind kind,
                     Joint& joint) const;
    void limit_step(const Piece& before, const Piece& after, Joint& joint) const;
    void limit_transition(std::size_t joint);
    void limit_curvature_jumps();
    void share_acceleration();
    void limit_by_look_ahead();
    void pass_forward();
    void pass_backward();
    double time_of(std::vector<SegmentSpeed>* speeds);
    void lengthen_rest_to_rest(std::vector<SegmentSpeed>* speeds, std::size_t first, std::size_t behind, double& sum);
    motion::Limit limit_of(std::size_t piece, double peak) const;
    motion::Limit limit_at(std::size_t joint, motion::Limit otherwise) const;

    const path::Run* run_ = nullptr;
    const RunGeometry* geometry_ = nullptr;
    const machine::Machine* machine_ = nullptr;

    int axes_ = 0;
    std::array<double, machine::max_axes> weight_{}, velocity_{}, acceleration_{}, jerk_{}, step_{};
    motion::Transition transition_{};
    bool jerk_limited_ = true, stops_at_axis_set_ = false, rotary_in_feed_ = false;
    double cycle_s_ = 0, preparation_s_ = 0, rounding_ = 0, centripetal_ = 0, jump_share_ = 0, settle_s_ = 0;
    double reference_radius_ = 0;
    std::size_t buffer_ = 1;
    double look_ahead_blocks_ = 0, look_ahead_mm_ = 0;

    std::vector<Piece> pieces_;
    std::vector<Joint> joints_;
    std::vector<Block> blocks_;
    std::vector<Ramp> ramps_;
    std::vector<double> sums_a_, sums_j_, sums_s_;  // Σ 2A·h, Σ √J·h, Σ h before each joint
    std::vector<double> window_;                    // speed that each row of blocks of the buffer's length allows
    std::vector<std::size_t> window_queue_;
};

}  // namespace trunnion::controller
