#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "trunnion/base/result.hpp"
#include "trunnion/verify/check.hpp"
#include "trunnion/verify/programmed_path.hpp"

#include "detail/chain.hpp"

namespace trunnion::verify {

/// Controlled point (mm) and flank height · tool axis (mm): the space in which motion and programme are compared.
using Joint6 = Eigen::Matrix<double, 6, 1>;

/// What turns a pose into six numbers.
struct Heights {
    double flank_mm = 30;
    double controlled_mm = 0;
    Joint6 joint(const Eigen::Vector3d& tip_mm, const Eigen::Vector3d& axis) const {
        Joint6 out;
        out << tip_mm + controlled_mm * axis, flank_mm * axis;
        return out;
    }
    Joint6 joint(const Gauge& gauge, double tool_length_mm) const {
        return joint(gauge.tip_mm(tool_length_mm), gauge.axis);
    }
};

/// A place on the programmed path: share w of the way from poses[segment] to poses[segment + 1].
struct Place {
    std::size_t segment = 0;
    double w = 0;
    double way_mm = 0;  ///< from the start of the path, in the joint space
};

/// The programmed path as segments between poses, each cut into pieces that are no longer than asked for and so short
/// that their chords in the joint space are within a micrometre.
class ProgrammedLine {
  public:
    enum class Law : std::uint8_t { straight, plane, rotary, standing };
    struct Segment {
        Law law = Law::straight;
        bool at_rapid = false;
        std::uint32_t first_piece = 0, pieces = 0;  ///< none: the tool is changed
        double tool_length_mm = 0;
        double angle_rad = 0;                              ///< law plane
        Eigen::Vector3d across = Eigen::Vector3d::Zero();  ///< law plane: unit, normal to the first axis, in the plane
        machine::AxisPosition from, turn;                  ///< law rotary: axes at the start, and how far they turn
    };
    struct Piece {
        Joint6 begin = Joint6::Zero(), chord = Joint6::Zero();
        double chord2 = 0;  ///< |chord|²
        double way_mm = 0;  ///< where it begins
        double tool_length_mm = 0;
        std::uint32_t segment = 0;
    };

    /// Keeps references to `poses` and `chain`. Pieces grow longer than `longest_piece_mm` where a path would have more
    /// than two million of them.
    /// Errors: VER0105, VER0302, VER0304.
    static Result<ProgrammedLine> make(const std::vector<ProgrammedPose>& poses, const machine::Machine& machine,
                                       const machine::Setup& setup, const Chain& chain, Heights heights,
                                       double longest_piece_mm);

    const std::vector<Piece>& pieces() const { return pieces_; }
    const std::vector<Segment>& segments() const { return segments_; }
    const Heights& heights() const { return heights_; }
    double length_mm() const { return length_mm_; }
    double tool_length_mm(std::size_t pose) const { return tool_lengths_[pose]; }
    /// Way from the start to a pose.
    double way_of(std::size_t pose) const { return way_of_pose_[pose]; }

    /// Exact point of the path and its derivative by w.
    struct Sample {
        Joint6 point, rate;
    };
    Sample at(std::size_t segment, double w) const;

    /// The place nearest to a row on a piece, or up to a piece's length before it in the same segment: Gauss-Newton on
    /// the exact path.
    Place refine(const Gauge& row, std::size_t piece) const;

  private:
    ProgrammedLine(const std::vector<ProgrammedPose>& poses, const Chain& chain, Heights heights)
        : poses_(&poses), chain_(&chain), heights_(heights) {}
    Result<Segment> segment_to(std::size_t pose, const machine::Machine& machine, const machine::Setup& setup) const;
    double turn_of(const Segment& segment) const;
    void limit_pieces();
    Result<void> cut(Segment segment);
    double nearest_share(const Gauge& row, std::size_t segment, double least, double most) const;
    Place place_at(std::size_t segment, double w) const;
    bool has_pieces(std::size_t segment) const { return segment < segments_.size() && segments_[segment].pieces > 0; }

    const std::vector<ProgrammedPose>* poses_;
    const Chain* chain_;
    Heights heights_;
    std::vector<Segment> segments_;
    std::vector<Piece> pieces_;
    std::vector<double> tool_lengths_, way_of_pose_;
    double longest_piece_mm_ = 0;
    double turning_pieces_ = 0;
    double length_mm_ = 0;
};

}  // namespace trunnion::verify
