#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include <Eigen/Geometry>

#include "trunnion/surfacing/machined_surface.hpp"

namespace trunnion::surfacing {

using geometry::SurfacePlace;

namespace {

class Check {
  public:
    Check(const Face& face, const Cutter& cutter, const std::vector<Pass>& passes, const SurfaceCheckOptions& options)
        : face_(face), options_(options), passes_(passes), cut_(cutter, passes), widest_(2 * cutter.radius_mm()) {}

    SurfaceVerdict run() {
        grid();
        for (const Pass& pass : passes_)
            if (pass.index >= 0) ridges_beside(pass);
        if (!ridges_.empty()) {
            std::ranges::sort(ridges_);
            verdict_.least_ridge_mm = ridges_.front();
            verdict_.largest_ridge_mm = ridges_.back();
            verdict_.median_ridge_mm = ridges_[ridges_.size() / 2];
        }
        verdict_.ridges = ridges_.size();
        return verdict_;
    }

  private:
    std::optional<double> height(const SurfacePlace& place) {
        const auto shape = shape_at(face_.surface, place, face_.side);
        if (!shape) return std::nullopt;
        const double out = cut_.height_mm(shape->point, shape->normal, options_.limit_mm);
        verdict_.highest_mm = std::max(verdict_.highest_mm, out);
        verdict_.deepest_mm = std::max(verdict_.deepest_mm, -out);
        return out;
    }

    void grid() {
        const ParameterBox box = parameter_box(face_);
        const Eigen::Vector2d size = box.high - box.low;
        const auto corner = [&](double a, double b) {
            return face_.surface.at(box.low.x() + a * size.x(), box.low.y() + b * size.y());
        };
        const auto steps = [&](double length) { return std::max(4, static_cast<int>(length / options_.grid_mm)); };
        const double along_u = (corner(0.5, 0.5) - corner(0, 0.5)).norm() + (corner(1, 0.5) - corner(0.5, 0.5)).norm();
        const double along_v = (corner(0.5, 0.5) - corner(0.5, 0)).norm() + (corner(0.5, 1) - corner(0.5, 0.5)).norm();
        const int rows = steps(along_u), columns = steps(along_v);
        for (int i = 0; i < rows; ++i)
            for (int j = 0; j < columns; ++j) {
                const SurfacePlace place{box.low.x() + (i + 0.5) / rows * size.x(),
                                         box.low.y() + (j + 0.5) / columns * size.y()};
                if (contains(face_, place) && height(place)) ++verdict_.heights;
            }
    }

    void ridges_beside(const Pass& pass) {
        double since = options_.ridge_spacing_mm;
        for (std::size_t i = 1; i + 1 < pass.contacts.size(); ++i) {
            since += (pass.contacts[i].point_mm - pass.contacts[i - 1].point_mm).norm();
            if (since < options_.ridge_spacing_mm) continue;
            since = 0;
            const Eigen::Vector3d along = pass.contacts[i + 1].point_mm - pass.contacts[i - 1].point_mm;
            for (const int side : {-1, 1})
                if (const auto ridge = ridge_from(pass.contacts[i], side * along.normalized()))
                    ridges_.push_back(*ridge);
        }
    }

    /// A walk over the surface across a pass, by arc length; the direction is carried along.
    struct Walk {
        SurfacePlace place;
        Eigen::Vector3d direction;
    };
    std::optional<Walk> stepped(const Walk& from, double length) const {
        const auto shape = shape_at(face_.surface, from.place, face_.side);
        if (!shape) return std::nullopt;
        const Eigen::Vector3d flat = from.direction - from.direction.dot(shape->normal) * shape->normal;
        const Eigen::Vector2d way = shape->parameters_along(length * flat.normalized());
        return Walk{{from.place.u + way.x(), from.place.v + way.y()}, flat.normalized()};
    }

    bool away_from_borders(const Walk& from, double distance) const {
        constexpr int directions = 8;
        const auto shape = shape_at(face_.surface, from.place, face_.side);
        for (int k = 0; shape && k < directions; ++k) {
            const double angle = 2 * std::numbers::pi * k / directions;
            const Eigen::Vector3d way = std::cos(angle) * shape->e1 + std::sin(angle) * shape->e2;
            const auto there = stepped({from.place, way}, distance);
            if (!there || !contains(face_, there->place)) return false;
        }
        return true;
    }

    std::optional<double> ridge_from(const Contact& contact, const Eigen::Vector3d& along) {
        const auto start = shape_at(face_.surface, contact.place, face_.side);
        if (!start) return std::nullopt;
        Walk walk{contact.place, start->normal.cross(along)};
        constexpr double first_step_mm = 0.02, noise_mm = 5e-4;  // chords are seen too
        double step = first_step_mm, gone = 0, highest = 0, step_to_highest = 0;
        Walk before = walk, before_highest = walk;
        while (gone < widest_) {
            const auto next = stepped(walk, step);
            if (!next || !contains(face_, next->place)) return std::nullopt;
            const auto h = height(next->place);
            if (!h) return std::nullopt;
            gone += step;
            if (*h > highest) {
                highest = *h;
                before_highest = before;
                step_to_highest = gone;
            } else if (*h < 0.5 * highest && highest > noise_mm) {
                break;
            }
            before = walk;
            walk = *next;
            step = std::max(first_step_mm, 0.04 * gone);
        }
        if (gone >= widest_) return std::nullopt;
        if (!away_from_borders(before_highest, 4 * step_to_highest)) return std::nullopt;
        return top(before_highest, 2.2 * std::max(first_step_mm, 0.04 * step_to_highest));
    }

    /// The highest place of the next `length`, where heights rise and then fall, by the golden section.
    std::optional<double> top(const Walk& from, double length) {
        double low = 0, high = length;
        const auto at = [&](double s) {
            const auto walk = stepped(from, s);
            return walk ? height(walk->place).value_or(0) : 0;
        };
        constexpr double golden = 0.3819660112501051;
        double a = low + golden * (high - low), b = high - golden * (high - low);
        double at_a = at(a), at_b = at(b);
        for (int k = 0; k < 16; ++k) {
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

    const Face& face_;
    const SurfaceCheckOptions& options_;
    const std::vector<Pass>& passes_;
    MachinedSurface cut_;
    double widest_;
    std::vector<double> ridges_;
    SurfaceVerdict verdict_;
};

}  // namespace

SurfaceVerdict check_surface(const Face& face, const Cutter& cutter, const std::vector<Pass>& passes,
                             const SurfaceCheckOptions& options) {
    return Check(face, cutter, passes, options).run();
}

}  // namespace trunnion::surfacing
