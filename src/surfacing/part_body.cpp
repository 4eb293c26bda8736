#include "trunnion/surfacing/part_body.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "detail/tessellation.hpp"
#include "detail/tool_body.hpp"

namespace trunnion::surfacing {

using detail::Gap;
using detail::ToolBody;
using Eigen::Vector3d;
using Corners = std::array<Vector3d, 3>;

namespace {

Vector3d normal_of(const Corners& t) {
    return (t[1] - t[0]).cross(t[2] - t[0]).normalized();
}

/// Nearest point of a triangle. Source: Ericson, Real-Time Collision Detection, §5.1.5.
Vector3d nearest_on(const Corners& t, const Vector3d& p) {
    const Vector3d ab = t[1] - t[0], ac = t[2] - t[0], ap = p - t[0];
    const double d1 = ab.dot(ap), d2 = ac.dot(ap);
    if (d1 <= 0 && d2 <= 0) return t[0];
    const Vector3d bp = p - t[1];
    const double d3 = ab.dot(bp), d4 = ac.dot(bp);
    if (d3 >= 0 && d4 <= d3) return t[1];
    const double vc = d1 * d4 - d3 * d2;
    if (vc <= 0 && d1 >= 0 && d3 <= 0) return t[0] + d1 / (d1 - d3) * ab;
    const Vector3d cp = p - t[2];
    const double d5 = ab.dot(cp), d6 = ac.dot(cp);
    if (d6 >= 0 && d5 <= d6) return t[2];
    const double vb = d5 * d2 - d1 * d6;
    if (vb <= 0 && d2 >= 0 && d6 <= 0) return t[0] + d2 / (d2 - d6) * ac;
    const double va = d3 * d6 - d5 * d4;
    if (va <= 0 && d4 >= d3 && d5 >= d6) return t[1] + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (t[2] - t[1]);
    return t[0] + (vb * ab + vc * ac) / (va + vb + vc);
}

/// The least distance of a convex body over a triangle, below `least` by more than is fine. The plane under the
/// distance at a place bounds it from below; over the place nearest to the body that plane says it all, and a few steps
/// from place to body and back lead there. Where they do not the triangle is halved, at most 60 times.
struct Descent {
    const ToolBody& body;
    double tolerance, least;
    bool any_will_do;
    Vector3d at = Vector3d::Zero();

    /// Differences below it are not followed up.
    double fine() const { return std::max(0.1 * tolerance, -0.01 * least); }

    bool over(const Corners& triangle) {
        const double before = least;
        std::array<Corners, 64> stack;  // not filled: that would cost more than most triangles do
        stack[0] = triangle;
        for (std::size_t depth = 1; depth > 0;) {
            const Corners part = stack[--depth];
            const bool settled = is_settled(part);
            if (any_will_do && least < before) return true;
            if (settled || depth + 2 > stack.size()) continue;
            // Across the longest side: slivers as of a cylinder's skin become no thinner.
            int side = 0;
            for (int k = 1; k < 3; ++k)
                if (squared_side(part, k) > squared_side(part, side)) side = k;
            const int next = (side + 1) % 3;
            const Vector3d half = 0.5 * (part[side] + part[next]);
            stack[depth] = stack[depth + 1] = part;
            stack[depth++][next] = half;
            stack[depth++][side] = half;
        }
        return least < before;
    }

  private:
    /// Goes from place to body and back; whether nothing of the triangle is left that could be lower.
    bool is_settled(const Corners& part) {
        constexpr int steps = 4;
        Vector3d place = (part[0] + part[1] + part[2]) / 3;
        for (int step = 0; step < steps; ++step) {
            const Gap gap = body.gap(place);
            meet(place, gap.distance);
            double bound = std::numeric_limits<double>::infinity();
            for (const Vector3d& corner : part)
                bound = std::min(bound, gap.distance + gap.gradient.dot(corner - place));
            if (bound >= least - fine()) return true;
            if (any_will_do && gap.distance <= least) return false;
            place = nearest_on(part, body.within(place, gap));
        }
        return false;
    }
    static double squared_side(const Corners& t, int k) { return (t[(k + 1) % 3] - t[k]).squaredNorm(); }
    void meet(const Vector3d& point, double distance) {
        if (distance < least) least = distance, at = point;
    }
};

/// Cuts needles across, as of a ruled surface, so that their boxes are not as long as the part: most queries would meet
/// them all. Shorter than `length_mm` nothing is cut.
void add_short(const detail::Triangle& triangle, double length_mm, std::vector<detail::Triangle>& out) {
    constexpr double needle = 8;
    std::vector<detail::Triangle> left{triangle};
    while (!left.empty()) {
        const detail::Triangle part = left.back();
        left.pop_back();
        const auto side = [&](int k) { return (part.corner[(k + 1) % 3] - part.corner[k]).norm(); };
        const int longest = std::max({0, 1, 2}, [&](int a, int b) { return side(a) < side(b); });
        const double shortest = std::min({side(0), side(1), side(2)});
        if (side(longest) <= length_mm || side(longest) <= needle * shortest) {
            out.push_back(part);
            continue;
        }
        const int next = (longest + 1) % 3;
        const Vector3d half = 0.5 * (part.corner[longest] + part.corner[next]);
        left.insert(left.end(), 2, part);
        left[left.size() - 1].corner[longest] = half;
        left[left.size() - 2].corner[next] = half;
    }
}

/// The largest extent along an axis.
double size_mm(const std::vector<detail::Triangle>& triangles) {
    Vector3d low = triangles.front().corner[0], high = low;
    for (const detail::Triangle& t : triangles)
        for (const Vector3d& corner : t.corner) low = low.cwiseMin(corner), high = high.cwiseMax(corner);
    return (high - low).maxCoeff();
}

}  // namespace

Result<PartBody> PartBody::make(std::span<const Face> faces, double tolerance_mm) {
    if (!(tolerance_mm > 0) || !std::isfinite(tolerance_mm))
        return fail({.code = "SURF0301",
                     .text = "the tolerance of a part body is out of its range",
                     .value = fmt::format("{} mm", tolerance_mm),
                     .limit = "above 0"});
    constexpr std::size_t most = 4'000'000;
    std::vector<detail::Triangle> triangles;
    for (std::size_t k = 0; k < faces.size(); ++k)
        if (auto done = tessellate(faces[k], static_cast<std::int32_t>(k), tolerance_mm, most, triangles); !done)
            return fail(std::move(done.error()));
    if (triangles.empty()) return fail({.code = "SURF0302", .text = "a part needs faces with an extent to be a body"});
    constexpr double share_of_part = 1.0 / 16;
    const double length_mm = share_of_part * size_mm(triangles);
    std::vector<detail::Triangle> cut;
    for (const detail::Triangle& t : triangles) add_short(t, length_mm, cut);
    PartBody out;
    out.tolerance_ = tolerance_mm;
    out.triangles_.reserve(cut.size());
    for (const detail::Triangle& t : cut) out.triangles_.push_back({t.corner, t.face});
    for (const Face& face : faces) out.solid_.push_back(face.solid);
    out.any_solid_ = std::ranges::any_of(faces, &Face::solid);
    out.build();
    return out;
}

PartBody::Box PartBody::box_of(std::int32_t first, std::int32_t count) const {
    Vector3d low = Vector3d::Constant(1e300), high = -low;
    for (std::int32_t i = first; i < first + count; ++i)
        for (const Vector3d& corner : triangles_[static_cast<std::size_t>(i)].corner) {
            low = low.cwiseMin(corner);
            high = high.cwiseMax(corner);
        }
    return {0.5 * (low + high), 0.5 * (high - low), first, count};
}

void PartBody::build() {
    constexpr std::int32_t leaf = 4;
    boxes_.push_back(box_of(0, static_cast<std::int32_t>(triangles_.size())));
    for (std::size_t at = 0; at < boxes_.size(); ++at) {
        const Box box = boxes_[at];
        if (box.count <= leaf) continue;
        int axis = 0;
        box.half.maxCoeff(&axis);
        const auto begin = triangles_.begin() + box.first;
        const std::int32_t half = box.count / 2;
        std::nth_element(begin, begin + half, begin + box.count, [axis](const Triangle& a, const Triangle& b) {
            return a.corner[0][axis] + a.corner[1][axis] + a.corner[2][axis] <
                   b.corner[0][axis] + b.corner[1][axis] + b.corner[2][axis];
        });
        boxes_[at].count = 0;
        boxes_[at].first = static_cast<std::int32_t>(boxes_.size());
        boxes_.push_back(box_of(box.first, half));
        boxes_.push_back(box_of(box.first + half, box.count - half));
    }
}

/// Deepens what is known by one convex piece of the tool; `any_will_do`: by the first place that is deeper.
template <class Body>
void PartBody::deepen(const Body& body, bool any_will_do, Penetration& deepest) const {
    // Under a box of half sides h a convex distance is at least its value in the middle − |gradient|·h.
    const auto bound = [&](const Box& box) {
        const Gap gap = body.gap(box.middle);
        return gap.distance - gap.gradient.cwiseAbs().dot(box.half);
    };
    Descent descent{.body = body, .tolerance = tolerance_, .least = -deepest.depth_mm, .any_will_do = any_will_do};
    struct Entry {
        std::int32_t box;
        double bound;
    };
    std::array<Entry, 64> stack{Entry{0, bound(boxes_.front())}};
    for (std::size_t depth = 1; depth > 0;) {
        const Entry entry = stack[--depth];
        if (entry.bound >= descent.least - descent.fine()) continue;
        const Box& box = boxes_[static_cast<std::size_t>(entry.box)];
        if (box.count == 0) {
            const Entry a{box.first, bound(boxes_[static_cast<std::size_t>(box.first)])};
            const Entry b{box.first + 1, bound(boxes_[static_cast<std::size_t>(box.first) + 1])};
            stack[depth++] = a.bound < b.bound ? b : a;
            stack[depth++] = a.bound < b.bound ? a : b;
            continue;
        }
        for (std::int32_t i = box.first; i < box.first + box.count; ++i) {
            const Triangle& triangle = triangles_[static_cast<std::size_t>(i)];
            if (!descent.over(triangle.corner)) continue;
            deepest = {-descent.least, descent.at, normal_of(triangle.corner), triangle.face, deepest.by_holder};
            if (any_will_do) return;
        }
    }
}

PartBody::Nearest PartBody::nearest(const Vector3d& point, bool of_solids) const {
    const auto apart = [&](const Box& box) {
        return ((point - box.middle).cwiseAbs() - box.half).cwiseMax(0.0).squaredNorm();
    };
    Nearest best{std::numeric_limits<double>::infinity(), 0, {}, {}, 0};
    double least = best.distance;
    std::array<std::int32_t, 64> stack{0};
    for (std::size_t depth = 1; depth > 0;) {
        const Box& box = boxes_[static_cast<std::size_t>(stack[--depth])];
        constexpr double same = 1 + 1e-9;  // on an edge the face that is seen more squarely tells the side
        if (apart(box) > same * least) continue;
        if (box.count == 0) {
            const bool second = apart(boxes_[static_cast<std::size_t>(box.first)]) >
                                apart(boxes_[static_cast<std::size_t>(box.first) + 1]);
            stack[depth++] = box.first + (second ? 0 : 1);
            stack[depth++] = box.first + (second ? 1 : 0);
            continue;
        }
        for (std::int32_t i = box.first; i < box.first + box.count; ++i) {
            const Triangle& triangle = triangles_[static_cast<std::size_t>(i)];
            if (of_solids && !solid_[static_cast<std::size_t>(triangle.face)]) continue;
            const Vector3d at = nearest_on(triangle.corner, point), normal = normal_of(triangle.corner);
            const double squared = (point - at).squaredNorm();
            if (squared > same * least) continue;
            const double distance = std::sqrt(squared),
                         towards = distance > 0 ? (point - at).dot(normal) / distance : 1;
            if (squared * same < least || std::abs(towards) > std::abs(best.towards))
                best = {distance, towards, at, normal, triangle.face};
            least = std::min(least, squared);
        }
    }
    return best;
}

double PartBody::signed_distance_mm(const Vector3d& point) const {
    const Nearest there = nearest(point, false);
    return there.behind() ? -there.distance : there.distance;
}

/// A ball of the tool whose middle is behind the skin of a solid is in it by its radius and more.
void PartBody::sink(const Vector3d& centre, double radius, Penetration& deepest) const {
    if (!any_solid_) return;
    const Nearest there = nearest(centre, true);
    if (there.behind() && radius + there.distance > deepest.depth_mm)
        deepest = {radius + there.distance, there.at, there.normal, there.face, deepest.by_holder};
}

std::optional<Penetration> PartBody::search(const Cutter& cutter, const CutterPose& pose, double more_than_mm,
                                            const Holder& holder, bool any_will_do) const {
    Penetration deepest{.depth_mm = more_than_mm, .at_mm = pose.tip_mm, .normal = pose.axis};
    const auto meet = [&](const ToolBody& body, bool by_holder) {
        Penetration here = deepest;
        here.by_holder = by_holder;
        deepen(body, any_will_do, here);
        const bool met = here.depth_mm > deepest.depth_mm;
        if (!met || !any_will_do) sink(body.ball_beside(met ? here.at_mm : pose.tip_mm), body.ball_radius(), here);
        if (here.depth_mm > deepest.depth_mm) deepest = here;
    };
    meet(ToolBody::of(cutter, pose), false);
    const bool enough = any_will_do && deepest.depth_mm > more_than_mm;
    if (holder.radius_mm > 0 && !enough) meet(ToolBody::of(holder, pose), true);
    if (deepest.depth_mm > more_than_mm) return deepest;
    return std::nullopt;
}

std::optional<Penetration> PartBody::deepest(const Cutter& cutter, const CutterPose& pose, double more_than_mm,
                                             const Holder& holder) const {
    return search(cutter, pose, more_than_mm, holder, false);
}

bool PartBody::is_deeper(const Cutter& cutter, const CutterPose& pose, double than_mm, const Holder& holder) const {
    return search(cutter, pose, than_mm, holder, true).has_value();
}

double PartBody::depth_mm(const Cutter& cutter, const CutterPose& pose) const {
    const auto there = deepest(cutter, pose);
    return there ? there->depth_mm : 0;
}

}  // namespace trunnion::surfacing
