#pragma once

#include <array>
#include <map>
#include <optional>

#include "trunnion/machine/machine.hpp"
#include "trunnion/motion/prediction.hpp"

namespace trunnion::controller {

/// A piece of motion whose speed changes evenly in time.
struct MotionPiece {
    std::int32_t line = 0;
    bool rapid = false;
    double duration_s = 0, way_mm = 0;            ///< of the tip
    double feed_from_mm_s = 0, feed_to_mm_s = 0;  ///< of the tip
    double programmed_feed_mm_s = 0;              ///< of the tip; 0: not told as such
    motion::Limit limit, limit_from, limit_to;
};

/// Adds up what a prediction tells of a motion, piece after piece.
class PredictionAccount {
  public:
    explicit PredictionAccount(const machine::Machine& machine) : machine_(machine) {}

    void add(const MotionPiece& piece);
    /// Standstill on the way: settling, counted as cutting or rapid time.
    void wait(std::int32_t line, bool rapid, double duration_s);
    /// NaN: the model has no such load.
    void note_load(std::size_t axis, double velocity_ratio, double acceleration_ratio, double jerk_ratio);
    /// Fills cut and rapid time, path length, loads, limits, drops and lines.
    void finish(motion::Prediction& prediction);

    double time_s() const { return cut_s_ + rapid_s_; }
    double path_length_mm() const { return path_mm_; }

  private:
    void add_to_line(std::int32_t line, double duration_s);
    void follow_drop(const MotionPiece& piece);
    void slow(const MotionPiece& piece, double begin_share, double end_share);
    void end_drop();

    const machine::Machine& machine_;
    double cut_s_ = 0, rapid_s_ = 0, path_mm_ = 0;
    std::array<motion::PredictedLoad, machine::max_axes> loads_{};
    std::map<std::pair<int, int>, double> limits_;  // kind, axis
    std::vector<motion::PredictedDrop> drops_;
    std::optional<motion::PredictedDrop> drop_;
    std::map<std::pair<int, int>, double> costs_;  // of the drop at hand, by limit, s
    std::vector<motion::LineTime> lines_;
};

}  // namespace trunnion::controller
