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

/// What of a tool matters: gauge line → tip, and tip → controlled point.
struct ToolHeights {
    double length_mm = 0;
    double controlled_mm = 0;
    bool operator==(const ToolHeights&) const = default;
};

inline Joint6 joint_of(const Eigen::Vector3d& tip_mm, const Eigen::Vector3d& axis, const ToolHeights& tool,
                       double flank_mm) {
    Joint6 out;
    out << tip_mm + tool.controlled_mm * axis, flank_mm * axis;
    return out;
}

inline Joint6 joint_of(const Gauge& gauge, const ToolHeights& tool, double flank_mm) {
    return joint_of(gauge.tip_mm(tool.length_mm), gauge.axis, tool, flank_mm);
}

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
        ToolHeights tool;
        double angle_rad = 0;                              ///< law plane
        Eigen::Vector3d across = Eigen::Vector3d::Zero();  ///< law plane: unit, normal to the first axis, in the plane
        machine::AxisPosition from, turn;                  ///< law rotary: axes at the start, and how far they turn
    };
    struct Piece {
        Joint6 begin = Joint6::Zero(), chord = Joint6::Zero();
        double chord2 = 0;  ///< |chord|²
        double way_mm = 0;  ///< where it begins
        ToolHeights tool;
        std::uint32_t segment = 0;
    };

    /// Keeps references to `poses` and `chain`. What a pose leaves open of its tool is that of `tool`. Pieces grow
    /// longer than `longest_piece_mm` where a path would have more than two million of them. Errors: VER0105, VER0302,
    /// VER0304.
    static Result<ProgrammedLine> make(const std::vector<ProgrammedPose>& poses, const machine::Machine& machine,
                                       const machine::Setup& setup, const Chain& chain, const ToolHeights& tool,
                                       double flank_mm, double longest_piece_mm);

    const std::vector<Piece>& pieces() const { return pieces_; }
    const std::vector<Segment>& segments() const { return segments_; }
    double flank_mm() const { return flank_mm_; }
    double length_mm() const { return length_mm_; }
    /// In use at a pose.
    const ToolHeights& tool_at(std::size_t pose) const { return tools_[pose]; }
    /// Way from the start to a pose.
    double way_of(std::size_t pose) const { return way_of_pose_[pose]; }

    /// The place that is so far from the start; the nearest end where there is none.
    Place place_on_way(double way_mm) const;

    /// Exact point of the path and its derivative by w.
    struct Sample {
        Joint6 point, rate;
    };
    Sample at(std::size_t segment, double w) const;

    /// The place nearest to a row on a piece, or up to a piece's length before it in the same segment: Gauss-Newton on
    /// the exact path.
    Place refine(const Gauge& row, std::size_t piece) const;

  private:
    ProgrammedLine(const std::vector<ProgrammedPose>& poses, const Chain& chain, double flank_mm)
        : poses_(&poses), chain_(&chain), flank_mm_(flank_mm) {}
    Result<Segment> segment_to(std::size_t pose, const machine::Machine& machine, const machine::Setup& setup) const;
    double turn_of(const Segment& segment) const;
    void limit_pieces();
    Result<void> cut(Segment segment);
    double nearest_share(const Gauge& row, std::size_t segment, double least, double most) const;
    Place place_at(std::size_t segment, double w) const;
    bool has_pieces(std::size_t segment) const { return segment < segments_.size() && segments_[segment].pieces > 0; }

    const std::vector<ProgrammedPose>* poses_;
    const Chain* chain_;
    double flank_mm_;
    std::vector<Segment> segments_;
    std::vector<Piece> pieces_;
    std::vector<ToolHeights> tools_;
    std::vector<double> way_of_pose_;
    double longest_piece_mm_ = 0;
    double turning_pieces_ = 0;
    double length_mm_ = 0;
};

}  // namespace trunnion::verify
