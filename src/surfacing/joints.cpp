#include "detail/joints.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <optional>

#include <Eigen/Geometry>

#include "trunnion/geometry/great_circle.hpp"

namespace trunnion::surfacing::detail {

using geometry::SurfacePlace;

namespace {

constexpr double gap_mm = 0.03;    ///< between borders, each drawn within 0.01 mm
constexpr double apart_mm = 0.01;  ///< of a border from the other face's surface
constexpr double smooth_rad = std::numbers::pi / 180;
constexpr double shortest_mm = 0.3;  ///< of a joint

Eigen::Vector3d point_on(const Face& face, const Eigen::Vector2d& place) {
    return face.surface.at(place.x(), place.y());
}

/// All borders of a face, asked for what is near.
class Borders {
  public:
    explicit Borders(const Face& face) : face_(face) {
        for (std::size_t k = 0; k < face.loops.size(); ++k) {
            loops_.push_back(border_points(face, k));
            gather(loops_.back());
        }
    }

    const std::vector<std::vector<BorderPoint>>& loops() const { return loops_; }
    const Eigen::AlignedBox3d& box() const { return box_; }

    /// The place of the border nearest to a point, within the gap.
    std::optional<SurfacePlace> near(const Eigen::Vector3d& point) const {
        double least = gap_mm;
        std::optional<SurfacePlace> best;
        for (const Ball& ball : balls_) {
            if ((point - ball.middle).norm() > ball.radius + gap_mm) continue;
            for (std::size_t k = ball.begin; k < ball.end; ++k) {
                const auto& loop = loops_[ball.loop];
                const BorderPoint &a = loop[k], &b = loop[(k + 1) % loop.size()];
                const Eigen::Vector3d way = b.at - a.at;
                const double w = std::clamp((point - a.at).dot(way) / std::max(way.squaredNorm(), 1e-300), 0.0, 1.0);
                const Eigen::Vector2d place = a.place + w * (b.place - a.place);
                const double off = (point_on(face_, place) - point).norm();
                if (off < least) least = off, best = SurfacePlace{place.x(), place.y()};
            }
        }
        return best;
    }

  private:
    struct Ball {
        std::size_t loop, begin, end;  ///< lines of a loop
        Eigen::Vector3d middle;
        double radius;
    };

    void gather(const std::vector<BorderPoint>& loop) {
        constexpr std::size_t lines = 16;
        for (std::size_t begin = 0; begin < loop.size(); begin += lines) {
            Ball ball{loops_.size() - 1, begin, std::min(begin + lines, loop.size()), {}, 0};
            ball.middle = loop[(begin + ball.end) / 2 % loop.size()].at;
            for (std::size_t k = begin; k <= ball.end; ++k)
                ball.radius = std::max(ball.radius, (loop[k % loop.size()].at - ball.middle).norm());
            balls_.push_back(ball);
        }
        for (const BorderPoint& point : loop) box_.extend(point.at);
    }

    const Face& face_;
    std::vector<std::vector<BorderPoint>> loops_;
    std::vector<Ball> balls_;
    Eigen::AlignedBox3d box_;
};

/// What of one face's borders is a border of another face too.
class SharedBorders {
  public:
    SharedBorders(const Face& face, const Borders& borders, const Face& other, const Borders& others)
        : face_(face), borders_(borders), other_(other), others_(others) {}

    std::vector<Stretch> smooth() const {
        std::vector<Stretch> out;
        for (std::size_t loop = 0; loop < borders_.loops().size(); ++loop)
            for (Stretch& stretch : shared(loop))
                if (is_smooth(stretch)) out.push_back(std::move(stretch));
        return out;
    }

  private:
    bool is_shared(const BorderPoint& point) const { return opposite(point).has_value(); }

    std::optional<SurfacePlace> opposite(const BorderPoint& point) const {
        const auto there = others_.near(point.at);
        if (!there) return std::nullopt;
        const SurfacePlace on = geometry::closest_place(other_.surface, point.at, *there, 1);
        return (other_.surface.at(on.u, on.v) - point.at).norm() < apart_mm ? there : std::nullopt;
    }

    std::vector<Stretch> shared(std::size_t number) const {
        const auto& loop = borders_.loops()[number];
        const std::size_t n = loop.size();
        std::vector<bool> is(n);
        for (std::size_t k = 0; k < n; ++k) is[k] = is_shared(loop[k]);
        if (std::ranges::find(is, true) == is.end()) return {};
        if (std::ranges::find(is, false) == is.end())
            return {completed({.loop = number, .points = loop, .opposite = {}, .closed = true})};
        std::vector<Stretch> out;
        const auto first = static_cast<std::size_t>(std::ranges::find(is, false) - is.begin());
        for (std::size_t k = first; k < first + n; ++k) {
            if (!is[k % n]) continue;
            Stretch stretch{.loop = number, .points = {end_between(number, k, k - 1)}};
            for (; is[k % n]; ++k) stretch.points.push_back(point(number, k));
            stretch.points.push_back(end_between(number, k - 1, k));
            out.push_back(completed(std::move(stretch)));
        }
        return out;
    }

    /// Number k may be beyond the loop's end.
    BorderPoint point(std::size_t number, std::size_t k) const {
        const auto& loop = borders_.loops()[number];
        BorderPoint out = loop[k % loop.size()];
        out.along += static_cast<double>(k / loop.size() * face_.loops[number].size());
        return out;
    }

    /// The last point that is shared, from one that is towards its neighbour that is not.
    BorderPoint end_between(std::size_t number, std::size_t shared, std::size_t beyond) const {
        const BorderPoint a = point(number, shared), b = point(number, beyond);
        const auto between = [&](double w) {
            const Eigen::Vector2d place = a.place + w * (b.place - a.place);
            return BorderPoint{place, point_on(face_, place), a.along + w * (b.along - a.along)};
        };
        double low = 0, high = 1;
        for (int halving = 0; halving < 20; ++halving) {
            const double middle = 0.5 * (low + high);
            (is_shared(between(middle)) ? low : high) = middle;
        }
        return between(low);
    }

    Stretch completed(Stretch stretch) const {
        auto& points = stretch.points;
        std::erase_if(points, [this](const BorderPoint& point) { return !is_shared(point); });
        // As wide as the gap is they lead on round a corner.
        const std::size_t n = points.size();
        if (!stretch.closed && n > 3 && is_hook(points[n - 3], points[n - 2], points[n - 1])) points.pop_back();
        if (!stretch.closed && n > 3 && is_hook(points[2], points[1], points[0])) points.erase(points.begin());
        for (const BorderPoint& point : stretch.points) stretch.opposite.push_back(*opposite(point));
        return stretch;
    }

    static bool is_hook(const BorderPoint& before, const BorderPoint& last, const BorderPoint& end) {
        constexpr double corner_rad = std::numbers::pi / 12;
        const Eigen::Vector3d hook = end.at - last.at;
        return hook.norm() < 2 * gap_mm && geometry::angle_between(hook, last.at - before.at) > corner_rad;
    }

    bool is_smooth(const Stretch& stretch) const {
        double length = 0;
        for (std::size_t k = 0; k < stretch.points.size(); ++k) {
            if (k > 0) length += (stretch.points[k].at - stretch.points[k - 1].at).norm();
            const auto here = shape(stretch, k);
            const auto there = geometry::shape_at(other_.surface, stretch.opposite[k], other_.side);
            // Where a border ends in a pole there is none.
            const bool at_end = !stretch.closed && (k == 0 || k + 1 == stretch.points.size());
            if (at_end && (!here || !there)) continue;
            if (!here || !there || geometry::angle_between(here->normal, there->normal) > smooth_rad) return false;
        }
        return length > shortest_mm && goes_on(stretch);
    }

    std::optional<geometry::SurfaceShape> shape(const Stretch& stretch, std::size_t k) const {
        const Eigen::Vector2d& at = stretch.points[k].place;
        return geometry::shape_at(face_.surface, {at.x(), at.y()}, face_.side);
    }

    /// Whether the other face is on the other side of the border, and does not turn back below this one.
    bool goes_on(const Stretch& stretch) const {
        constexpr double aside_mm = 0.1;
        const std::size_t middle = stretch.points.size() / 2;
        const auto here = shape(stretch, middle);
        const auto there = geometry::shape_at(other_.surface, stretch.opposite[middle], other_.side);
        if (middle == 0 || !here || !there) return false;
        const Eigen::Vector3d along = stretch.points[middle].at - stretch.points[middle - 1].at;
        const Eigen::Vector3d across = aside_mm * here->normal.cross(along).normalized();
        const auto holds = [](const Face& face, const SurfacePlace& from, const geometry::SurfaceShape& shape,
                              const Eigen::Vector3d& way) {
            const Eigen::Vector2d step = shape.parameters_along(way);
            return contains(face, {from.u + step.x(), from.v + step.y()});
        };
        const Eigen::Vector2d& place = stretch.points[middle].place;
        const auto held_here = [&](double side) { return holds(face_, {place.x(), place.y()}, *here, side * across); };
        const auto held_there = [&](double side) {
            return holds(other_, stretch.opposite[middle], *there, side * across);
        };
        return held_here(1) != held_here(-1) && held_here(1) == held_there(-1) && held_here(-1) == held_there(1);
    }

    const Face& face_;
    const Borders& borders_;
    const Face& other_;
    const Borders& others_;
};

/// Whether two stretches of two faces are one border.
bool is_same(const Stretch& a, const Stretch& b) {
    const Eigen::Vector3d& middle = a.points[a.points.size() / 2].at;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t k = 1; k < b.points.size(); ++k) {
        const Eigen::ParametrizedLine<double, 3> line =
            Eigen::ParametrizedLine<double, 3>::Through(b.points[k - 1].at, b.points[k].at);
        const double length = (b.points[k].at - b.points[k - 1].at).norm();
        const double on = std::clamp((middle - line.origin()).dot(line.direction()), 0.0, length);
        least = std::min(least, (line.pointAt(on) - middle).norm());
    }
    return least < 2 * gap_mm;
}

}  // namespace

bool Stretch::holds(double number, std::size_t size) const noexcept {
    if (closed) return true;
    const double from = points.front().along, to = points.back().along, n = static_cast<double>(size);
    for (const double turned : {number - n, number, number + n})
        if (turned >= from && turned <= to) return true;
    return false;
}

std::vector<BorderPoint> border_points(const Face& face, std::size_t number) {
    constexpr double finest_mm = 0.25;
    constexpr int most = 1000, parts_to_measure = 8;
    const Loop& loop = face.loops[number];
    std::vector<double> lengths;
    for (std::size_t k = 0; k < loop.size(); ++k) {
        const Eigen::Vector2d &a = loop[k], &b = loop[(k + 1) % loop.size()];
        double length = 0;
        for (int part = 0; part < parts_to_measure; ++part)
            length += (point_on(face, a + (b - a) * (part + 1) / parts_to_measure) -
                       point_on(face, a + (b - a) * part / parts_to_measure))
                          .norm();
        lengths.push_back(length);
    }
    const double step = std::max(finest_mm, std::accumulate(lengths.begin(), lengths.end(), 0.0) / most);
    std::vector<BorderPoint> out;
    for (std::size_t k = 0; k < loop.size(); ++k) {
        const Eigen::Vector2d &a = loop[k], &b = loop[(k + 1) % loop.size()];
        const int parts = std::max(1, static_cast<int>(std::ceil(lengths[k] / step)));
        for (int part = 0; part < parts; ++part) {
            const double share = static_cast<double>(part) / parts;
            const Eigen::Vector2d place = a + share * (b - a);
            out.push_back({place, point_on(face, place), static_cast<double>(k) + share});
        }
    }
    return out;
}

std::vector<SmoothJoint> smooth_joints(std::span<const Face> faces) {
    std::vector<Borders> borders;
    borders.reserve(faces.size());
    for (const Face& face : faces) borders.emplace_back(face);
    std::vector<SmoothJoint> joints;
    for (std::size_t i = 0; i < faces.size(); ++i)
        for (std::size_t j = i + 1; j < faces.size(); ++j) {
            if (borders[i].box().exteriorDistance(borders[j].box()) > gap_mm) continue;
            auto first = SharedBorders(faces[i], borders[i], faces[j], borders[j]).smooth();
            if (first.empty()) continue;
            const auto second = SharedBorders(faces[j], borders[j], faces[i], borders[i]).smooth();
            for (Stretch& one : first)
                if (const auto other = std::ranges::find_if(second, [&](const Stretch& s) { return is_same(one, s); });
                    other != second.end())
                    joints.push_back({i, j, std::move(one), *other});
        }
    return joints;
}

}  // namespace trunnion::surfacing::detail
