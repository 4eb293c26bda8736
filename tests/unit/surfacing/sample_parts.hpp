#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include <Eigen/Geometry>

#include "trunnion/surfacing/part_body.hpp"

#include "sample_surfaces.hpp"

namespace trunnion::surfacing::samples {

/// A generator of its own (splitmix64), the same everywhere.
class Random {
  public:
    explicit Random(std::uint64_t seed) : seed_(seed), state_(seed) {}
    std::uint64_t seed() const { return seed_; }
    double between(double low, double high) {
        std::uint64_t z = (state_ += 0x9e3779b97f4a7c15);
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9;
        z = (z ^ (z >> 27)) * 0x94d049bb133111eb;
        return low + (high - low) * (static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1p-53);
    }

  private:
    std::uint64_t seed_, state_;
};

/// A bicubic of 100 × 100 mm with hills and hollows, up.
inline Face free_form_face() {
    return facing(
        bicubic(100, [](double x, double y) { return 20 * std::sin(3 * x) * std::cos(2.5 * y) + 7.5 * x * y; }),
        {0, 0, 1});
}

/// From a corner along two sides, seen from outside: normal a × b.
inline Face rectangle(const Eigen::Vector3d& corner, const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    return facing(
        geometry::BsplineSurface::make(line(), line(), {corner, corner + b, corner + a, corner + a + b}).value(),
        a.cross(b));
}

inline std::vector<Face> block(double x, double y, double z) {
    const Eigen::Vector3d o(0, 0, 0), a(x, 0, 0), b(0, y, 0), c(0, 0, z);
    return {rectangle(o, b, a), rectangle(c, a, b), rectangle(o, a, c),
            rectangle(b, c, a), rectangle(o, c, b), rectangle(a, b, c)};
}

/// A bottom z = 0 of 60 × 60 mm and a wall x = 0 of 40 mm beside it.
inline std::vector<Face> pocket_with_wall() {
    return {rectangle({0, 0, 0}, {60, 0, 0}, {0, 60, 0}), rectangle({0, 0, 0}, {0, 60, 0}, {0, 0, 40})};
}

/// Places of faces, about `grid_mm` apart: how deep the deepest of them is within the cutter's body is a second opinion
/// that shares nothing with the tree of triangles.
class SampledPart {
  public:
    SampledPart(const std::vector<Face>& faces, double grid_mm) {
        for (const Face& face : faces) {
            const ParameterBox box = parameter_box(face);
            const auto steps = [&](const Eigen::Vector2d& to) {
                const Eigen::Vector3d way = face.surface.at(to.x(), to.y()) - face.surface.at(box.low.x(), box.low.y());
                return static_cast<int>(1.3 * way.norm() / grid_mm) + 2;
            };
            const int rows = steps({box.high.x(), box.low.y()}), columns = steps({box.low.x(), box.high.y()});
            for (int i = 0; i <= rows; ++i)
                for (int j = 0; j <= columns; ++j) {
                    const Eigen::Vector2d at = box.low + Eigen::Vector2d(i * (box.high - box.low).x() / rows,
                                                                         j * (box.high - box.low).y() / columns);
                    points_.push_back(face.surface.at(at.x(), at.y()));
                }
        }
    }
    double depth_mm(const Cutter& cutter, const CutterPose& pose) const {
        double deepest = 0;
        for (const Eigen::Vector3d& point : points_) deepest = std::max(deepest, -cutter.distance_mm(pose, point));
        return deepest;
    }

  private:
    std::vector<Eigen::Vector3d> points_;
};

}  // namespace trunnion::surfacing::samples
