#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <numbers>
#include <optional>
#include <set>

#include <Eigen/Geometry>

#include "trunnion/surfacing/machined_surface.hpp"
#include "trunnion/surfacing/path_interval.hpp"
#include "trunnion/surfacing/plan_region.hpp"

namespace trunnion::surfacing {

using geometry::SurfacePlace;

namespace {

SurfacePlace between(const SurfacePlace& a, const SurfacePlace& b, double share) {
    return {a.u + share * (b.u - a.u), a.v + share * (b.v - a.v)};
}

/// The place that is some way off on the surface, by its tangent plane.
std::optional<SurfacePlace> beside(const Face& face, const SurfacePlace& from, const Eigen::Vector3d& way) {
    const auto shape = shape_at(face.surface, from, face.side);
    if (!shape) return std::nullopt;
    const Eigen::Vector2d step = shape->parameters_along(way);
    return SurfacePlace{from.u + step.x(), from.v + step.y()};
}

/// Length on the surface of the longest of three lines of one parameter over the face's box, mm.
double width_mm(const Face& face, int k) {
    const ParameterBox box = parameter_box(face);
    double longest = 0;
    for (const double share : {0.1, 0.5, 0.9}) {
        Eigen::Vector2d at = box.low;
        at[1 - k] += share * (box.high - box.low)[1 - k];
        constexpr int parts = 16;
        double length = 0;
        for (int i = 0; i < parts; ++i) {
            const Eigen::Vector3d from = face.surface.at(at.x(), at.y());
            at[k] = box.low[k] + (i + 1) * (box.high - box.low)[k] / parts;
            length += (face.surface.at(at.x(), at.y()) - from).norm();
        }
        longest = std::max(longest, length);
    }
    return longest;
}

/// Places left out, in cubes as wide as they reach, to a power of two.
class LeftPlaces {
  public:
    explicit LeftPlaces(std::span<const LeftPlace> places) {
        for (const LeftPlace& place : places) {
            if (!(place.reach_mm > 0)) continue;
            const auto size = static_cast<std::int64_t>(std::ceil(std::log2(place.reach_mm)));
            sizes_.insert(size);
            cubes_[cube_of(place.at_mm, size)].push_back(place);
        }
    }

    bool near(const Eigen::Vector3d& point) const {
        return std::ranges::any_of(sizes_, [&](std::int64_t size) { return near(point, size); });
    }

  private:
    using Cube = std::array<std::int64_t, 4>;

    static Cube cube_of(const Eigen::Vector3d& point, std::int64_t size) {
        const double width = std::exp2(static_cast<double>(size));
        const auto along = [&](int k) { return static_cast<std::int64_t>(std::floor(point[k] / width)); };
        return {size, along(0), along(1), along(2)};
    }

    bool near(const Eigen::Vector3d& point, std::int64_t size) const {
        const Cube middle = cube_of(point, size);
        const auto holds = [&](const LeftPlace& place) { return (place.at_mm - point).norm() <= place.reach_mm; };
        for (int k = 0; k < 27; ++k) {
            const auto cube =
                cubes_.find({size, middle[1] + k % 3 - 1, middle[2] + k / 3 % 3 - 1, middle[3] + k / 9 - 1});
            if (cube != cubes_.end() && std::ranges::any_of(cube->second, holds)) return true;
        }
        return false;
    }

    std::set<std::int64_t> sizes_;
    std::map<Cube, std::vector<LeftPlace>> cubes_;
};

/// A place on a pass.
struct PassPlace {
    SurfacePlace place;
    Eigen::Vector3d point_mm;
    double off_mm;  ///< from where it is the nearest
};

class Check {
  public:
    Check(std::span<const Face> faces, const Cutter& cutter, const std::vector<Pass>& passes,
          const SurfaceCheckOptions& options)
        : faces_(faces),
          cutter_(cutter),
          options_(options),
          passes_(passes),
          cut_(cutter, passes),
          left_(options.left) {}

    SurfaceVerdict run() {
        for (const Face& face : faces_) {
            grid(face);
            borders(face);
        }
        all_ridges();
        return verdict_;
    }

  private:
    std::optional<double> height(const Face& face, const SurfacePlace& place) {
        const auto shape = shape_at(face.surface, place, face.side);
        if (!shape) return std::nullopt;
        double out = cut_.height_mm(shape->point, shape->normal, options_.limit_mm);
        // Between rims that meet exactly a line of no width is left, which is no material.
        constexpr double no_width_mm = 1e-5;
        const Eigen::Vector3d aside = no_width_mm * (shape->e1 + 0.7 * shape->e2);
        for (const int side : {-1, 1})
            if (out > 0.5 * options_.limit_mm)
                out = cut_.height_mm(shape->point + side * aside, shape->normal, options_.limit_mm);
        if (out > verdict_.highest_mm && !(out > options_.left_above_mm && left_.near(shape->point)))
            verdict_.highest_mm = out, verdict_.highest_at_mm = shape->point;
        if (-out > verdict_.deepest_mm)
            if (const double depth = std::min(-out, cut_.depth_mm(shape->point)); depth > verdict_.deepest_mm)
                verdict_.deepest_mm = depth, verdict_.deepest_at_mm = shape->point;
        return out;
    }

    void grid(const Face& face) {
        const ParameterBox box = parameter_box(face);
        const Eigen::Vector2d size = box.high - box.low;
        const auto steps = [&](int k) { return std::max(4, static_cast<int>(width_mm(face, k) / options_.grid_mm)); };
        const int rows = steps(0), columns = steps(1);
        for (int i = 0; i < rows; ++i)
            for (int j = 0; j < columns; ++j) {
                const SurfacePlace place{box.low.x() + (i + 0.5) / rows * size.x(),
                                         box.low.y() + (j + 0.5) / columns * size.y()};
                if (!contains(face, place)) continue;
                const auto h = height(face, place);
                if (!h) continue;
                ++verdict_.heights;
                account_area(face, place, *h, size.x() * size.y() / rows / columns);
            }
    }

    void account_area(const Face& face, const SurfacePlace& place, double height, double cell) {
        const auto shape = shape_at(face.surface, place, face.side);
        const double area = cell * shape->by_u.cross(shape->by_v).norm();
        verdict_.area_mm2 += area;
        if (height > options_.left_above_mm && left_.near(shape->point)) verdict_.left_mm2 += area;
    }

    /// Along all loops, on the border and at shares of the tool's radius from it.
    void borders(const Face& face) {
        for (const Loop& loop : face.loops) {
            double since = options_.grid_mm;
            for (std::size_t i = 0, before = loop.size() - 1; i < loop.size(); before = i++) {
                const Eigen::Vector2d &a = loop[before], &b = loop[i];
                const Eigen::Vector3d from = face.surface.at(a.x(), a.y()), to = face.surface.at(b.x(), b.y());
                const double length = (to - from).norm();
                for (double gone = options_.grid_mm - since; gone < length; gone += options_.grid_mm) {
                    border_place(face, between({a.x(), a.y()}, {b.x(), b.y()}, gone / length), to - from);
                    since = -gone;
                }
                since += length;
            }
        }
    }

    void border_place(const Face& face, const SurfacePlace& place, const Eigen::Vector3d& along) {
        const auto shape = shape_at(face.surface, place, face.side);
        if (!shape) return;
        const Eigen::Vector3d across = shape->normal.cross(along).normalized();
        for (const int side : {-1, 1})
            for (const double share : {1e-4, 0.02, 0.05, 0.1, 0.2, 0.4}) {
                const auto at = beside(face, place, side * share * cutter_.radius_mm() * across);
                if (!at || !contains(face, *at)) break;
                if (height(face, *at)) ++verdict_.heights;
            }
    }

    void all_ridges() {
        std::map<int, std::vector<const Pass*>> by_index;
        for (const Pass& pass : passes_)
            if (pass.index >= 0) by_index[pass.index].push_back(&pass);
        if (by_index.empty()) return;
        for (auto next = by_index.begin(), here = next++; next != by_index.end(); here = next++)
            for (const Pass* pass : here->second) ridges_beside(*pass, next->second);
        verdict_.ridges = ridges_.size();
        if (ridges_.empty()) return;
        std::ranges::sort(ridges_);
        verdict_.least_ridge_mm = ridges_.front();
        verdict_.largest_ridge_mm = std::max(verdict_.largest_ridge_mm, ridges_.back());
        verdict_.median_ridge_mm = ridges_[ridges_.size() / 2];
    }

    void ridges_beside(const Pass& pass, const std::vector<const Pass*>& next) {
        double since = options_.ridge_spacing_mm;
        for (std::size_t i = 1; i + 1 < pass.contacts.size(); ++i) {
            since += (pass.contacts[i].point_mm - pass.contacts[i - 1].point_mm).norm();
            if (since < options_.ridge_spacing_mm) continue;
            since = 0;
            if (const auto there = nearest(next, pass.contacts[i])) ridge_between(pass.contacts[i], *there);
        }
    }

    /// The nearest place of the passes on the contact's face; nothing where that is the end of one.
    static std::optional<PassPlace> nearest(const std::vector<const Pass*>& passes, const Contact& from) {
        PassPlace best{.place = {}, .point_mm = {}, .off_mm = 1e300};
        bool at_end = true;
        for (const Pass* pass : passes)
            for (std::size_t k = 0; k + 1 < pass->contacts.size(); ++k) {
                const Contact &a = pass->contacts[k], &b = pass->contacts[k + 1];
                if (a.face != from.face || b.face != from.face) continue;
                const Eigen::Vector3d way = b.point_mm - a.point_mm;
                const double w = std::clamp((from.point_mm - a.point_mm).dot(way) / way.squaredNorm(), 0.0, 1.0);
                const Eigen::Vector3d point = a.point_mm + w * way;
                const double off = (point - from.point_mm).norm();
                if (!(off < best.off_mm)) continue;
                best = {between(a.place, b.place, w), point, off};
                at_end = (k == 0 && w == 0) || (k + 2 == pass->contacts.size() && w == 1);
            }
        return at_end ? std::nullopt : std::optional(best);
    }

    bool away_from_borders(const Face& face, const SurfacePlace& place, double distance) const {
        constexpr int directions = 8;
        const auto shape = shape_at(face.surface, place, face.side);
        for (int k = 0; shape && k < directions; ++k) {
            const double angle = 2 * std::numbers::pi * k / directions;
            const Eigen::Vector3d way = std::cos(angle) * shape->e1 + std::sin(angle) * shape->e2;
            const auto there = beside(face, place, distance * way);
            if (!there || !contains(face, *there)) return false;
        }
        return shape.has_value();
    }

    void ridge_between(const Contact& contact, const PassPlace& other) {
        const Face& face = faces_[static_cast<std::size_t>(contact.face)];
        constexpr double widest_radii = 5;  // what is farther apart does not run beside each other
        if (!(other.off_mm > 1e-6) || other.off_mm > widest_radii * cutter_.radius_mm()) return;
        constexpr int parts = 16;
        int highest_part = 0;
        double highest = -options_.limit_mm;
        for (int k = 1; k < parts; ++k) {
            const SurfacePlace at = between(contact.place, other.place, static_cast<double>(k) / parts);
            if (!contains(face, at)) return;
            const double h = height(face, at).value_or(0);
            if (h > highest) highest = h, highest_part = k;
        }
        const double share = static_cast<double>(highest_part) / parts;
        // A pass along a border cuts as far as the tool's end reaches.
        const double margin = std::max(2 * other.off_mm, 1.1 * cutter_.radius_mm());
        if (!away_from_borders(face, between(contact.place, other.place, share), margin)) return;
        const SurfacePlace top_place = between(contact.place, other.place, share);
        if (left_.near(face.surface.at(top_place.u, top_place.v))) return;
        const double ridge = std::max(highest, top(face, contact, other, share - 1.0 / parts, share + 1.0 / parts));
        if (is_at_reach(face, contact, other)) {
            ++verdict_.at_reach;
            verdict_.largest_ridge_mm = std::max(verdict_.largest_ridge_mm, ridge);
        } else {
            ridges_.push_back(ridge);
        }
    }

    /// The highest place between two shares of a line, where heights rise and then fall, by the golden section.
    double top(const Face& face, const Contact& contact, const PassPlace& other, double low, double high) {
        const auto at = [&](double s) { return height(face, between(contact.place, other.place, s)).value_or(0); };
        constexpr double golden = 0.3819660112501051;
        double a = low + golden * (high - low), b = high - golden * (high - low);
        double at_a = at(a), at_b = at(b);
        for (int k = 0; k < 12; ++k) {
            if (at_a > at_b) {
                high = b, b = a, at_b = at_a;
                a = low + golden * (high - low), at_a = at(a);
            } else {
                low = a, a = b, at_a = at_b;
                b = high - golden * (high - low), at_b = at(b);
            }
        }
        return std::max(at_a, at_b);
    }

    bool is_at_reach(const Face& face, const Contact& contact, const PassPlace& other) const {
        const auto shape = shape_at(face.surface, contact.place, face.side);
        if (!shape) return false;
        const Eigen::Vector2d across = shape->components(other.point_mm - contact.point_mm).normalized();
        constexpr double nearly = 0.98;
        return other.off_mm >= nearly * longest_interval_mm(cutter_, *shape, contact.pose.axis, across);
    }

    std::span<const Face> faces_;
    const Cutter& cutter_;
    const SurfaceCheckOptions& options_;
    const std::vector<Pass>& passes_;
    MachinedSurface cut_;
    LeftPlaces left_;
    std::vector<double> ridges_;
    SurfaceVerdict verdict_;
};

}  // namespace

SurfaceVerdict check_surface(const Face& face, const Cutter& cutter, const std::vector<Pass>& passes,
                             const SurfaceCheckOptions& options) {
    return check_region({&face, 1}, cutter, passes, options);
}

SurfaceVerdict check_region(std::span<const Face> faces, const Cutter& cutter, const std::vector<Pass>& passes,
                            const SurfaceCheckOptions& options) {
    return Check(faces, cutter, passes, options).run();
}

}  // namespace trunnion::surfacing
