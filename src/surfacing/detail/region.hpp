#pragma once

#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "trunnion/geometry/surface_shape.hpp"
#include "trunnion/surfacing/face.hpp"

#include "detail/joints.hpp"

namespace trunnion::surfacing::detail {

/// A place of a region: on the surface of one of its faces.
struct Place : geometry::SurfacePlace {
    int chart = 0;  ///< which face of the region
};

/// Faces that ways run over as if they were one: a single one, or several that meet smoothly at joints. Each counts as
/// continued beyond its borders, but not beyond its joints, behind which the neighbour begins. Where a joint ends at
/// the border of the region it is taken to go on straight.
///
/// Of one face every question is that of the face. Immutable.
class Region {
  public:
    /// `number`: of the face, among those that are planned together.
    explicit Region(const Face& face, std::size_t number = 0);
    Region(std::span<const Face> faces, const SmoothGroup& group);

    int charts() const noexcept { return static_cast<int>(charts_.size()); }
    const Face& face(int chart) const noexcept { return *of(chart).face; }
    std::size_t number(int chart) const noexcept { return of(chart).number; }
    const ParameterBox& box(int chart) const noexcept { return of(chart).box; }

    Eigen::Vector3d at(const Place& place) const noexcept { return face(place.chart).surface.at(place.u, place.v); }
    std::optional<geometry::SurfaceShape> shape(const Place& place) const noexcept {
        return geometry::shape_at(face(place.chart).surface, place, face(place.chart).side);
    }
    bool is_in_box(const Place& place) const noexcept;

    /// Whether a place lies within the faces, or in the crack between two of them.
    bool contains(const Place& place) const noexcept;
    /// Whether a place is on its face or on that continued, and not behind a joint.
    bool is_before_joints(const Place& place) const noexcept { return !crossed(place); }

    /// The nearest place of the region, continued, to a point near a place of it: by Newton's method on the guess's
    /// face, and on from face to face over joints.
    Place closest(const Eigen::Vector3d& point, const Place& guess) const noexcept;
    /// The same on one face alone.
    Place closest_on(int chart, const Eigen::Vector3d& point, const geometry::SurfacePlace& guess) const noexcept;

    /// Distance of a point from the joints of a face, mm; infinite without any.
    double to_joint_mm(int chart, const Eigen::Vector3d& point) const noexcept;

    /// Unit direction of a face's joint with another one where it is nearest to a point; nothing where they have none.
    std::optional<Eigen::Vector3d> joint_along(int chart, int to, const Eigen::Vector3d& point) const noexcept;

    /// Places of a curve with those added where it crosses joints: two for one crossing, of the face before and of the
    /// one behind. `spacing`: about the distance of the places; what is much nearer to a crossing is left out.
    std::vector<Place> jointed(std::vector<Place> places, double spacing) const;

  private:
    struct Line {
        Eigen::Vector2d from, way;
    };
    struct Joint {
        int to;
        double inside;  ///< on which side of the lines the face is: +1 left, −1 right
        bool closed;
        std::vector<Line> lines;                     ///< first and last: continued, unless closed
        std::vector<geometry::SurfacePlace> beyond;  ///< of the neighbour, at the joint's points
        std::vector<Eigen::Vector3d> points;
    };
    struct Chart {
        const Face* face;
        std::size_t number;
        ParameterBox box;
        Eigen::Vector2d scale{1, 1};  ///< mm per unit of u and v: lines are in (u, v) times that
        std::vector<Joint> joints;
        std::vector<Line> open;  ///< borders that are no joints
    };
    struct Crossing {
        const Joint* joint;
        geometry::SurfacePlace beyond;  ///< near the place, on the neighbour
        double off_mm;
        bool continued;  ///< beyond the end of the joint
    };

    const Chart& of(int chart) const noexcept { return charts_[static_cast<std::size_t>(chart)]; }
    void add_joint(int chart, int to, const Stretch& stretch);
    void add_open_borders(int chart, std::span<const Stretch* const> joined);
    std::optional<Crossing> crossed(const Place& place) const noexcept;
    static std::optional<Crossing> beyond(const Joint& joint, const Eigen::Vector2d& at) noexcept;
    template <class Visit>
    static void each_line(const Joint& joint, const Eigen::Vector3d& point, const Visit& visit) noexcept;
    bool joined(int a, int b) const noexcept;
    void settle(std::vector<Place>& places) const;
    void cross(const std::vector<Place>& places, std::size_t i, int depth, std::vector<Place>& out) const;
    std::optional<std::pair<Place, Place>> crossing(const std::vector<Place>& places, std::size_t i) const;

    std::vector<Chart> charts_;
};

}  // namespace trunnion::surfacing::detail
