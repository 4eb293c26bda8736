#include "detail/region.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "detail/way.hpp"

namespace trunnion::surfacing::detail {

using geometry::SurfacePlace;

namespace {

constexpr int most_hops = 6;
/// So little beyond a joint a surface continued is its neighbour.
constexpr double as_good_as_on_mm = 0.02;

Eigen::Vector2d as_vector(const SurfacePlace& place) noexcept {
    return {place.u, place.v};
}

SurfacePlace between(const SurfacePlace& a, const SurfacePlace& b, double share) noexcept {
    return {a.u + share * (b.u - a.u), a.v + share * (b.v - a.v)};
}

double turn_from(const Eigen::Vector2d& a, const Eigen::Vector2d& b) noexcept {
    return a.x() * b.y() - a.y() * b.x();
}

/// mm per unit of u and v, the mean over the face's box.
Eigen::Vector2d scale_of(const Face& face, const ParameterBox& box) {
    constexpr int parts = 5;
    const Eigen::Vector2d cell = (box.high - box.low) / parts;
    Eigen::Vector2d sum(0, 0);
    for (int k = 0; k < parts * parts; ++k) {
        const auto at = face.surface.evaluate(box.low.x() + (k / parts + 0.5) * cell.x(),
                                              box.low.y() + (k % parts + 0.5) * cell.y());
        sum += Eigen::Vector2d(at.by_u.norm(), at.by_v.norm());
    }
    return sum / (parts * parts);
}

}  // namespace

Region::Region(const Face& face, std::size_t number) {
    charts_.push_back({.face = &face, .number = number, .box = parameter_box(face), .joints = {}, .open = {}});
}

Region::Region(std::span<const Face> faces, const SmoothGroup& group) {
    for (const std::size_t number : group.faces) {
        const Face& face = faces[number];
        const ParameterBox box = parameter_box(face);
        charts_.push_back(
            {.face = &face, .number = number, .box = box, .scale = scale_of(face, box), .joints = {}, .open = {}});
    }
    std::vector<std::vector<const Stretch*>> joined(group.faces.size());
    for (const SmoothJoint& joint : group.joints) {
        add_joint(static_cast<int>(joint.first), static_cast<int>(joint.second), joint.on_first);
        add_joint(static_cast<int>(joint.second), static_cast<int>(joint.first), joint.on_second);
        joined[joint.first].push_back(&joint.on_first);
        joined[joint.second].push_back(&joint.on_second);
    }
    for (std::size_t k = 0; k < joined.size(); ++k)
        if (!group.joints.empty()) add_open_borders(static_cast<int>(k), joined[k]);
}

void Region::add_joint(int number, int to, const Stretch& stretch) {
    Chart& chart = charts_[static_cast<std::size_t>(number)];
    Joint joint{.to = to, .inside = 1, .closed = stretch.closed, .lines = {}, .beyond = stretch.opposite, .points = {}};
    const std::size_t n = stretch.points.size();
    const auto scaled = [&](std::size_t k) -> Eigen::Vector2d {
        return stretch.points[k % n].place.cwiseProduct(chart.scale);
    };
    const double farther = (chart.box.high - chart.box.low).cwiseProduct(chart.scale).norm();
    // Straight on from one of its ends; what is close to it would not tell where to.
    const auto led_on = [&](std::size_t end, int step) -> Eigen::Vector2d {
        constexpr double close_mm = 0.1;
        std::size_t from = end;
        while (from + static_cast<std::size_t>(step) < n && (scaled(from) - scaled(end)).norm() < close_mm)
            from += static_cast<std::size_t>(step);
        return 0.5 * farther * (scaled(end) - scaled(from)).normalized();
    };
    if (!stretch.closed) {
        const Eigen::Vector2d back = led_on(0, 1);
        joint.lines.push_back({scaled(0) + back, -back});
    }
    for (std::size_t k = 0; k + 1 < n + (stretch.closed ? 1 : 0); ++k)
        joint.lines.push_back({scaled(k), scaled(k + 1) - scaled(k)});
    if (!stretch.closed) joint.lines.push_back({scaled(n - 1), led_on(n - 1, -1)});
    for (const BorderPoint& point : stretch.points) joint.points.push_back(point.at);
    const Line& middle = joint.lines[joint.lines.size() / 2];
    constexpr double aside_mm = 0.1;
    const Eigen::Vector2d left = aside_mm * Eigen::Vector2d(-middle.way.y(), middle.way.x()).normalized();
    const Eigen::Vector2d at = (middle.from + 0.5 * middle.way + left).cwiseQuotient(chart.scale);
    joint.inside = surfacing::contains(*chart.face, {at.x(), at.y()}) ? 1 : -1;
    chart.joints.push_back(std::move(joint));
}

void Region::add_open_borders(int number, std::span<const Stretch* const> joined) {
    Chart& chart = charts_[static_cast<std::size_t>(number)];
    for (std::size_t k = 0; k < chart.face->loops.size(); ++k) {
        const Loop& loop = chart.face->loops[k];
        std::vector<double> cuts;
        for (std::size_t i = 0; i <= loop.size(); ++i) cuts.push_back(static_cast<double>(i));
        for (const Stretch* stretch : joined)
            if (stretch->loop == k && !stretch->closed)
                for (const double end : {stretch->points.front().along, stretch->points.back().along})
                    cuts.push_back(std::fmod(end, static_cast<double>(loop.size())));
        std::ranges::sort(cuts);
        const auto place = [&](double along) -> Eigen::Vector2d {
            const auto i = std::min(static_cast<std::size_t>(along), loop.size() - 1);
            const Eigen::Vector2d& from = loop[i];
            const Eigen::Vector2d on = from + (along - static_cast<double>(i)) * (loop[(i + 1) % loop.size()] - from);
            return on.cwiseProduct(chart.scale);
        };
        for (std::size_t i = 0; i + 1 < cuts.size(); ++i) {
            const double middle = 0.5 * (cuts[i] + cuts[i + 1]);
            const auto is_there = [&](const Stretch* stretch) {
                return stretch->loop == k && stretch->holds(middle, loop.size());
            };
            if (cuts[i + 1] > cuts[i] && std::ranges::none_of(joined, is_there))
                chart.open.push_back({place(cuts[i]), place(cuts[i + 1]) - place(cuts[i])});
        }
    }
}

bool Region::is_in_box(const Place& place) const noexcept {
    const ParameterBox& in = box(place.chart);
    return place.u >= in.low.x() && place.u <= in.high.x() && place.v >= in.low.y() && place.v <= in.high.y();
}

/// Where a place is behind a joint, however far.
std::optional<Region::Crossing> Region::beyond(const Joint& joint, const Eigen::Vector2d& at) noexcept {
    double least = std::numeric_limits<double>::infinity(), share = 0;
    std::size_t nearest = 0;
    for (std::size_t k = 0; k < joint.lines.size(); ++k) {
        const Line& line = joint.lines[k];
        const double w = std::clamp((at - line.from).dot(line.way) / line.way.squaredNorm(), 0.0, 1.0);
        const double off = (at - line.from - w * line.way).squaredNorm();
        if (off < least) least = off, nearest = k, share = w;
    }
    const Line& line = joint.lines[nearest];
    if (joint.inside * turn_from(line.way, at - line.from) >= 0) return std::nullopt;
    const std::size_t before = joint.closed ? 0 : 1, last = joint.beyond.size() - 1;
    const bool continued = !joint.closed && (nearest == 0 || nearest + 1 == joint.lines.size());
    const std::size_t k = std::min(nearest - std::min(nearest, before), last);
    const SurfacePlace guess =
        continued ? joint.beyond[k] : between(joint.beyond[k], joint.beyond[(k + 1) % joint.beyond.size()], share);
    return Crossing{&joint, guess, std::sqrt(least), continued};
}

/// The joint behind which a place is; not where another border is nearer.
std::optional<Region::Crossing> Region::crossed(const Place& place) const noexcept {
    const Chart& chart = of(place.chart);
    if (chart.joints.empty() || surfacing::contains(*chart.face, place)) return std::nullopt;
    const Eigen::Vector2d at = as_vector(place).cwiseProduct(chart.scale);
    // Of two that are as near the one that is really there.
    constexpr double farther = 1.0001, slack_mm = 1e-9;
    std::optional<Crossing> nearest;
    for (const Joint& joint : chart.joints) {
        auto one = beyond(joint, at);
        if (!one) continue;
        if (one->continued) one->off_mm = farther * one->off_mm + slack_mm;
        if (!nearest || one->off_mm < nearest->off_mm) nearest = one;
    }
    if (!nearest) return std::nullopt;
    for (const Line& line : chart.open) {
        const double w = std::clamp((at - line.from).dot(line.way) / line.way.squaredNorm(), 0.0, 1.0);
        if ((at - line.from - w * line.way).norm() < nearest->off_mm) return std::nullopt;
    }
    return nearest;
}

bool Region::contains(const Place& place) const noexcept {
    if (surfacing::contains(face(place.chart), place)) return true;
    Place here = place;
    bool between_faces = true;
    std::array<int, most_hops> passed{};
    for (int hop = 0; hop < most_hops; ++hop) {
        const auto over = crossed(here);
        if (!over) return false;
        between_faces = between_faces && !over->continued;
        passed[static_cast<std::size_t>(hop)] = here.chart;
        const int to = over->joint->to;
        if (std::find(passed.begin(), passed.begin() + hop + 1, to) != passed.begin() + hop + 1) return between_faces;
        here = closest_on(to, at(here), over->beyond);
        if (surfacing::contains(face(to), here)) return true;
    }
    return false;
}

Place Region::closest_on(int chart, const Eigen::Vector3d& point, const SurfacePlace& guess) const noexcept {
    return {geometry::closest_place(face(chart).surface, point, guess, 1), chart};
}

Place Region::closest(const Eigen::Vector3d& point, const Place& guess) const noexcept {
    Place here = closest_on(guess.chart, point, guess);
    std::array<int, most_hops> passed{};
    for (int hop = 0; hop < most_hops; ++hop) {
        const auto over = crossed(here);
        if (!over) break;
        passed[static_cast<std::size_t>(hop)] = here.chart;
        const int to = over->joint->to;
        if (std::find(passed.begin(), passed.begin() + hop + 1, to) != passed.begin() + hop + 1) break;
        const Place there = closest_on(to, point, over->beyond);
        // Far beyond the region's border the neighbour may be anywhere.
        const double off = (at(there) - point).norm(), now = (at(here) - point).norm();
        if (off > now + over->off_mm) break;
        here = there;
    }
    return here;
}

template <class Visit>
void Region::each_line(const Joint& joint, const Eigen::Vector3d& point, const Visit& visit) noexcept {
    for (std::size_t k = 1; k < joint.points.size(); ++k) {
        const Eigen::Vector3d& from = joint.points[k - 1];
        const Eigen::Vector3d way = joint.points[k] - from;
        const double w = std::clamp((point - from).dot(way) / std::max(way.squaredNorm(), 1e-300), 0.0, 1.0);
        visit((from + w * way - point).squaredNorm(), way);
    }
}

double Region::to_joint_mm(int chart, const Eigen::Vector3d& point) const noexcept {
    double least = std::numeric_limits<double>::infinity();
    for (const Joint& joint : of(chart).joints)
        each_line(joint, point, [&](double squared, const auto&) { least = std::min(least, squared); });
    return std::sqrt(least);
}

std::optional<Eigen::Vector3d> Region::joint_along(int chart, int to, const Eigen::Vector3d& point) const noexcept {
    double least = std::numeric_limits<double>::infinity();
    std::optional<Eigen::Vector3d> best;
    for (const Joint& joint : of(chart).joints)
        if (joint.to == to)
            each_line(joint, point, [&](double squared, const Eigen::Vector3d& way) {
                if (squared < least) least = squared, best = way.normalized();
            });
    return best;
}

bool Region::joined(int a, int b) const noexcept {
    return std::ranges::any_of(of(a).joints, [b](const Joint& joint) { return joint.to == b; });
}

/// Ways along a joint do not change from face to face for what is as good as on either.
void Region::settle(std::vector<Place>& places) const {
    for (std::size_t begin = 0, end = 0; begin < places.size(); begin = end) {
        const int chart = places[begin].chart;
        bool near = true;
        for (end = begin; end < places.size() && places[end].chart == chart; ++end)
            near = near && to_joint_mm(chart, at(places[end])) < as_good_as_on_mm;
        const std::size_t neighbour = begin > 0 ? begin - 1 : end;
        if (!near || neighbour >= places.size() || !joined(chart, places[neighbour].chart)) continue;
        const Place to = places[neighbour];
        for (std::size_t k = begin; k < end; ++k) places[k] = closest_on(to.chart, at(places[k]), to);
    }
}

/// Where the curve leaves the face of place i, on this face and on that of the next place: on the cubic through the
/// places round about, all put onto the one face.
std::optional<std::pair<Place, Place>> Region::crossing(const std::vector<Place>& places, std::size_t i) const {
    const int chart = places[i].chart;
    std::vector<Place> on{places[i]};
    std::size_t index = 0;
    if (i > 0 && places[i - 1].chart == chart) on.insert(on.begin(), places[i - 1]), index = 1;
    const auto put = [&](std::size_t k) {
        const auto from = shape(on.back());
        if (!from || k >= places.size()) return;
        const Eigen::Vector2d step = from->parameters_along(at(places[k]) - from->point);
        on.push_back(closest_on(chart, at(places[k]), {on.back().u + step.x(), on.back().v + step.y()}));
    };
    put(i + 1);
    put(i + 2);
    const Way way(*this, on);
    if (way.places().size() != on.size() || on.size() < index + 2) return std::nullopt;
    double low = way.lengths()[index], high = way.lengths()[index + 1];
    for (int halving = 0; halving < 40; ++halving) {
        const double middle = 0.5 * (low + high);
        (is_before_joints(way.place(middle)) ? low : high) = middle;
    }
    const Place here = way.place(low);
    return std::pair(here, closest_on(places[i + 1].chart, at(here), places[i + 1]));
}

/// Appends the places from place i, which is there, up to the next one, which is not appended.
void Region::cross(const std::vector<Place>& places, std::size_t i, int depth, std::vector<Place>& out) const {
    constexpr int deepest = 12;
    if (places[i].chart == places[i + 1].chart || depth == deepest) return;
    if (joined(places[i].chart, places[i + 1].chart)) {
        const auto found = crossing(places, i);
        out.push_back(found ? found->first : closest_on(places[i].chart, at(places[i + 1]), places[i]));
        if (found) out.push_back(found->second);
        return;
    }
    const Place middle = closest(0.5 * (at(places[i]) + at(places[i + 1])), places[i]);
    const std::vector<Place> halves{places[i], middle, places[i + 1]};
    cross(halves, 0, depth + 1, out);
    out.push_back(middle);
    cross(halves, 1, depth + 1, out);
}

std::vector<Place> Region::jointed(std::vector<Place> places, double spacing) const {
    const auto leaves = [&](const Place& place) { return place.chart != places.front().chart; };
    if (charts() == 1 || std::ranges::none_of(places, leaves)) return places;
    settle(places);
    std::vector<Place> all;
    for (std::size_t i = 0; i < places.size(); ++i) {
        all.push_back(places[i]);
        if (i + 1 < places.size()) cross(places, i, 0, all);
    }
    // What is close to a joint would bend the way there.
    constexpr double close = 0.25;
    const auto leads_over = [&](std::size_t k) { return k + 1 < all.size() && all[k].chart != all[k + 1].chart; };
    const auto is_joint = [&](std::size_t k) { return leads_over(k) || (k > 0 && leads_over(k - 1)); };
    const auto is_close = [&](std::size_t i) {
        if (i == 0 || i + 1 == all.size() || is_joint(i) || (is_joint(i - 1) && is_joint(i + 1))) return false;
        const auto near = [&](std::size_t k) {
            return is_joint(k) && (at(all[i]) - at(all[k])).norm() < close * spacing;
        };
        return near(i - 1) || near(i + 1);
    };
    std::vector<Place> out;
    for (std::size_t i = 0; i < all.size(); ++i)
        if (!is_close(i)) out.push_back(all[i]);
    return out;
}

}  // namespace trunnion::surfacing::detail
