#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "trunnion/base/result.hpp"
#include "trunnion/surfacing/cutter.hpp"
#include "trunnion/surfacing/face.hpp"

namespace trunnion::surfacing {

/// What holds the tool: a cylinder about its axis.
struct Holder {
    double radius_mm = 0;           ///< 0: none
    double from_mm = 0, to_mm = 0;  ///< up from the tip
};

/// A place where the tool is in the part.
struct Penetration {
    double depth_mm = 0;
    Eigen::Vector3d at_mm, normal;  ///< of the skin, workpiece; unit, out of the material
    int face = 0;                   ///< index among the faces of the part
    bool by_holder = false;
};

/// The part as a body: its faces as triangles in a tree of boxes, asked how deep a tool is in it.
///
/// Depth: how far the deepest place of the skin lies under the surface of the tool, of cutter and shank up to
/// Cutter::reach_mm, or of the holder. A tool whose axis is behind the skin of a solid (Face::solid) is deeper than its
/// radius R: then R and the distance of the axis from that skin, at the height of that place. A point is behind where
/// its nearest place of the skin lies ahead, within 60° of the normal.
///
/// Faces that are no solid's are sheets as thin as paper: the tool must not cut into one from either side, and R is as
/// deep as it can be in one. Whether there is material behind a sheet its file does not say, so it does not count; a
/// tool that moves by at most half its radius from pose to pose does not get through one unseen.
///
/// Every triangle is within the tolerance of its face, and every place of a face, within its loops as polylines, within
/// the tolerance of a triangle (bounds, not samples). Depths are right to the tolerance and, too small, another tenth
/// of it or 1 % of the depth.
///
/// Immutable; some 250 bytes a triangle; their number grows with 1/tolerance: a bicubic of 100 × 100 mm with radii of
/// 60 mm takes 13 000 at 5 µm.
class PartBody {
  public:
    /// Errors: SURF0301 tolerance not above 0, SURF0302 no face or more than 4 million triangles.
    static Result<PartBody> make(std::span<const Face> faces, double tolerance_mm);

    /// How deep the tool's body is in the part, 0 outside. No allocation. Cost: 2-20 µs.
    double depth_mm(const Cutter& cutter, const CutterPose& pose) const;

    /// The same with its place; nothing where it is at most `more_than_mm`, which makes poses that touch cheap.
    std::optional<Penetration> deepest(const Cutter& cutter, const CutterPose& pose, double more_than_mm = 0,
                                       const Holder& holder = {}) const;

    /// Whether it is deeper than that at all: sooner known than how deep.
    bool is_deeper(const Cutter& cutter, const CutterPose& pose, double than_mm, const Holder& holder = {}) const;

    /// Signed distance of a point from the skin, mm, negative behind it. No allocation. Cost: some µs.
    double signed_distance_mm(const Eigen::Vector3d& point_mm) const;

    double tolerance_mm() const noexcept { return tolerance_; }
    /// A ball that holds all of it.
    const Eigen::Vector3d& middle_mm() const noexcept { return boxes_.front().middle; }
    double radius_mm() const noexcept { return boxes_.front().half.norm(); }
    std::size_t triangles() const noexcept { return triangles_.size(); }

  private:
    struct Triangle {
        std::array<Eigen::Vector3d, 3> corner;
        std::int32_t face;
    };
    struct Box {
        Eigen::Vector3d middle, half;
        std::int32_t first, count;  ///< triangles of a leaf; count = 0: children at first and first + 1
    };
    struct Nearest {
        double distance, towards;  ///< from the skin; cosine of point − place with the normal
        Eigen::Vector3d at, normal;
        int face;
        bool behind() const noexcept { return towards < -0.5; }
    };
    PartBody() = default;
    void build();
    Box box_of(std::int32_t first, std::int32_t count) const;
    Nearest nearest(const Eigen::Vector3d& point, bool of_solids) const;
    template <class Body>
    void deepen(const Body& body, bool any_will_do, Penetration& deepest) const;
    std::optional<Penetration> search(const Cutter& cutter, const CutterPose& pose, double more_than_mm,
                                      const Holder& holder, bool any_will_do) const;
    void sink(const Eigen::Vector3d& centre, double radius, Penetration& deepest) const;

    double tolerance_ = 0;
    std::vector<Triangle> triangles_;
    std::vector<Box> boxes_;
    std::vector<bool> solid_;  ///< by face
    bool any_solid_ = false;
};

}  // namespace trunnion::surfacing
