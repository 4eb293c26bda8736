#include "trunnion/interpolation/surface_path.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "trunnion/geometry/great_circle.hpp"

#include "detail/surface_poles.hpp"

namespace trunnion::interpolation {

namespace {

constexpr double shortest_bridge_mm = 0.01, shortest_piece_mm = 1e-3;
constexpr int parts = 8;  // of a piece, between the places looked at

struct Error {
    double tip_mm = 0, axis_rad = 0;
    void widen(const Error& other) {
        tip_mm = std::max(tip_mm, other.tip_mm);
        axis_rad = std::max(axis_rad, other.axis_rad);
    }
};

/// An end of pieces: tip and axis over the way of the contact.
struct Node {
    double w;
    std::array<Taylor3, 6> at;
};

/// The polynomial of degree 7 with value and three derivatives of both ends, by u ∈ [0, 1].
std::array<double, 8> septic(const Taylor3& from, const Taylor3& to, double length) {
    const double h = length, h2 = h * h, h3 = h2 * h;
    const double a0 = from.c[0], a1 = h * from.c[1], a2 = h2 * from.c[2], a3 = h3 * from.c[3];
    const double r0 = to.c[0] - a0 - a1 - a2 - a3, r1 = h * to.c[1] - a1 - 2 * a2 - 3 * a3;
    const double r2 = 2 * h2 * to.c[2] - 2 * a2 - 6 * a3, r3 = 6 * (h3 * to.c[3] - a3);
    return {a0,
            a1,
            a2,
            a3,
            35 * r0 - 15 * r1 + 2.5 * r2 - r3 / 6,
            -84 * r0 + 39 * r1 - 7 * r2 + r3 / 2,
            70 * r0 - 34 * r1 + 6.5 * r2 - r3 / 2,
            -20 * r0 + 10 * r1 - 2 * r2 + r3 / 6};
}

/// Where the tool is to follow a polynomial: a rough place of the curve, or one where the axis is led through a pole.
struct Place {
    double w;
    std::optional<Eigen::Vector3d> pole;
};

class PathBuilder {
  public:
    PathBuilder(const SurfaceCurve& curve, const machine::Kinematics& kinematics, const SurfacePathOptions& options)
        : curve_(curve), options_(options), knots_(curve.knots()), rough_(curve.rough_places()) {
        std::vector<double> breaks = knots_;
        for (const double w : rough_) {
            if (!(w > curve.begin() && w < curve.end())) continue;
            breaks.push_back(w);
            places_.push_back({w, {}});
        }
        std::ranges::sort(breaks);
        for (const auto& [w, pole] : detail::poles_on(curve, kinematics, breaks, options.pole_rad))
            places_.push_back({w, pole});
        std::ranges::stable_sort(places_, {}, &Place::w);
    }

    Result<SurfacePath> build() {
        double from = curve_.begin();
        for (std::size_t next = 0; next < places_.size();) {
            const auto bridge = bridge_over(next, from);
            if (!bridge) return fail(bridge.error());
            if (auto done = smooth_part(from, bridge->nodes.front().w); !done) return fail(done.error());
            add(*bridge);
            from = bridge->nodes.back().w;
            while (next < places_.size() && places_[next].w <= from) ++next;
        }
        if (auto done = smooth_part(from, curve_.end()); !done) return fail(done.error());
        return std::move(path_);
    }

  private:
    /// Polynomials from node to node: one over rough places, with a node more at every pole.
    struct Bridge {
        std::vector<Node> nodes;
        std::vector<double> lengths_mm;
        Error error;
    };

    Node node(double w) const {
        const SurfaceSeries at = curve_.by_way(w);
        return {w, {at.tip[0], at.tip[1], at.tip[2], at.axis[0], at.axis[1], at.axis[2]}};
    }

    /// The axis shifted sideways into the pole, the centre of ball or torus where it is.
    Node node_at_pole(double w, const Eigen::Vector3d& pole) const {
        Node out = node(w);
        const Eigen::Vector3d axis(out.at[3].value(), out.at[4].value(), out.at[5].value());
        const Eigen::Vector3d shift = axis.dot(pole) * pole - axis;
        for (int k = 0; k < 3; ++k) {
            out.at[k].c[0] -= curve_.tool().corner_mm * shift[k];
            out.at[3 + k].c[0] = axis.dot(pole) * pole[k];
        }
        return out;
    }

    /// Way along a part that may have knots and rough places inside.
    double way_mm(double from, double to) const {
        double sum = 0, at = from;
        const auto up_to = [&](double w) {
            if (w > at && w <= to) sum += curve_.way_mm(at, w), at = w;
        };
        auto knot = std::ranges::upper_bound(knots_, from), rough = std::ranges::upper_bound(rough_, from);
        while (at < to) {
            double next = to;
            while (knot != knots_.end() && *knot <= at) ++knot;
            while (rough != rough_.end() && *rough <= at) ++rough;
            if (knot != knots_.end()) next = std::min(next, *knot);
            if (rough != rough_.end()) next = std::min(next, *rough);
            up_to(next);
        }
        return sum;
    }

    static path::PathPiece piece(const Node& from, const Node& to, double length_mm) {
        path::PathPiece out{.begin_mm = 0, .length_mm = length_mm, .coefficient = {}};
        for (int k = 0; k < 6; ++k) out.coefficient[k] = septic(from.at[k], to.at[k], length_mm);
        return out;
    }

    static Error error_between(const std::array<Taylor3, 6>& at, const machine::Pose& pose) {
        const Eigen::Vector3d tip(at[0].value(), at[1].value(), at[2].value());
        const Eigen::Vector3d axis(at[3].value(), at[4].value(), at[5].value());
        return {(tip - pose.tip_in_workpiece_mm).norm(), geometry::angle_between(axis, pose.axis_in_workpiece)};
    }

    Error error_at(const Node& node) const { return error_between(node.at, curve_.pose(curve_.contact(node.w))); }

    /// How far the polynomial between two nodes is off the pose at equal way; its length.
    Error error_of(const Node& from, const Node& to, double& length_mm) const {
        std::array<double, parts + 1> way{};
        for (int k = 0; k < parts; ++k)
            way[k + 1] =
                way[k] + way_mm(from.w + (to.w - from.w) * k / parts, from.w + (to.w - from.w) * (k + 1) / parts);
        length_mm = way[parts];
        const path::PathPiece fitted = piece(from, to, length_mm);
        Error out;
        for (int k = 1; k < parts; ++k) {
            const machine::Pose pose = curve_.pose(curve_.contact(from.w + (to.w - from.w) * k / parts));
            out.widen(error_between(path::evaluate(fitted, way[k]), pose));
        }
        return out;
    }

    void add(const Node& from, const Node& to, double length_mm, bool bridge) {
        path::PathPiece added = piece(from, to, length_mm);
        added.begin_mm = path_.tool_path.length_mm();
        path_.tool_path.pieces.push_back(added);
        path_.pieces.push_back({from.w, to.w, bridge});
    }

    void add(const Bridge& bridge) {
        for (std::size_t k = 0; k < bridge.lengths_mm.size(); ++k) {
            add(bridge.nodes[k], bridge.nodes[k + 1], bridge.lengths_mm[k], true);
            path_.bridged_mm += bridge.lengths_mm[k];
        }
        path::DeviationBound& bound = path_.tool_path.bound;
        bound.tip_mm = std::max(bound.tip_mm, bridge.error.tip_mm);
        bound.orientation_rad = std::max(bound.orientation_rad, bridge.error.axis_rad);
    }

    /// The longest bridge over a place, and those behind it that lie within, that keeps the tolerance.
    Result<Bridge> bridge_over(std::size_t first, double earliest) const {
        for (double reach = options_.longest_bridge_mm; reach >= shortest_bridge_mm; reach /= 2) {
            Bridge out = bridge_of(first, earliest, reach);
            if (out.error.tip_mm <= options_.bridge_tip_mm && out.error.axis_rad <= options_.bridge_axis_rad)
                return out;
        }
        const Eigen::Vector3d at = curve_.contact(places_[first].w).point_mm;
        return fail({.code = "INTP0007",
                     .text = fmt::format("the surface has an edge across the curve at ({:.3f} {:.3f} {:.3f})", at.x(),
                                         at.y(), at.z()),
                     .hint = "end the pass there"});
    }

    Bridge bridge_of(std::size_t first, double earliest, double reach_mm) const {
        const auto w_reach = [&](const Place& place) { return reach_mm / curve_.contact(place.w).rate_mm; };
        std::size_t last = first;
        while (last + 1 < places_.size() &&
               places_[last + 1].w - w_reach(places_[last + 1]) < places_[last].w + w_reach(places_[last]))
            ++last;
        Bridge out;
        out.nodes.push_back(node(std::max(earliest, places_[first].w - w_reach(places_[first]))));
        for (std::size_t k = first; k <= last; ++k)
            if (places_[k].pole) out.nodes.push_back(node_at_pole(places_[k].w, *places_[k].pole));
        out.nodes.push_back(node(std::min(curve_.end(), places_[last].w + w_reach(places_[last]))));
        for (std::size_t k = 0; k + 1 < out.nodes.size(); ++k)
            out.error.widen(error_of(out.nodes[k], out.nodes[k + 1], out.lengths_mm.emplace_back()));
        for (std::size_t k = 1; k + 1 < out.nodes.size(); ++k) out.error.widen(error_at(out.nodes[k]));
        return out;
    }

    /// Pieces from one parameter to another with no rough place between.
    Result<void> smooth_part(double from, double to) {
        if (!(from < to)) return {};
        Node at = node(from);
        for (auto knot = std::ranges::upper_bound(knots_, from); at.w < to;) {
            while (knot != knots_.end() && *knot <= at.w) ++knot;
            const double next = knot == knots_.end() ? to : std::min(*knot, to);
            const Node behind = node(next);
            if (auto done = fit(at, behind); !done) return done;
            at = behind;
        }
        return {};
    }

    Result<void> fit(const Node& from, const Node& to) {
        double length = 0;
        const Error error = error_of(from, to, length);
        if (error.tip_mm <= options_.fit_tip_mm && error.axis_rad <= options_.fit_axis_rad) {
            path_.fit_tip_mm = std::max(path_.fit_tip_mm, error.tip_mm);
            path_.fit_axis_rad = std::max(path_.fit_axis_rad, error.axis_rad);
            add(from, to, length, false);
            return {};
        }
        if (!(length > shortest_piece_mm)) {
            const Eigen::Vector3d at = curve_.contact(from.w).point_mm;
            return fail({.code = "INTP0008",
                         .text = fmt::format("a curve on a surface bends too sharply at ({:.3f} {:.3f} {:.3f})", at.x(),
                                             at.y(), at.z())});
        }
        const Node middle = node(0.5 * (from.w + to.w));
        if (auto done = fit(from, middle); !done) return done;
        return fit(middle, to);
    }

    const SurfaceCurve& curve_;
    const SurfacePathOptions& options_;
    std::vector<double> knots_, rough_;
    std::vector<Place> places_;
    SurfacePath path_;
};

Result<void> check_options(const SurfacePathOptions& options) {
    const std::pair<const char*, double> bounds[] = {{"feed", options.feed_mm_s},
                                                     {"tip tolerance", options.fit_tip_mm},
                                                     {"axis tolerance", options.fit_axis_rad},
                                                     {"tip tolerance of bridges", options.bridge_tip_mm},
                                                     {"axis tolerance of bridges", options.bridge_axis_rad},
                                                     {"length of bridges", options.longest_bridge_mm}};
    if (!(options.pole_rad >= 0 && options.pole_rad <= options.bridge_axis_rad))
        return fail({.code = "INTP0006",
                     .text = "the angle from a pole must be from 0 to the axis tolerance of bridges",
                     .value = fmt::format("{}", options.pole_rad)});
    for (const auto& [what, value] : bounds)
        if (!(value > 0 && std::isfinite(value)))
            return fail({.code = "INTP0006",
                         .text = fmt::format("the {} on a surface must be more than 0", what),
                         .value = fmt::format("{}", value)});
    return {};
}

}  // namespace

Result<SurfacePath> surface_path(const SurfaceCurve& curve, const machine::Kinematics& kinematics,
                                 const SurfacePathOptions& options) {
    if (auto sound = check_options(options); !sound) return fail(sound.error());
    auto out = PathBuilder(curve, kinematics, options).build();
    if (!out) return out;
    path::ToolPath& path = out->tool_path;
    path.kinematics = &kinematics;
    const double length = path.length_mm();
    path::BlockSpan block{.begin_mm = 0, .end_mm = length, .feed = {}, .line = options.line, .time_scale_mm = length};
    block.feed = options.feed_point == FeedPoint::tip
                     ? path::Feed{path::FeedRule::tip_speed, options.feed_mm_s}
                     : path::Feed{path::FeedRule::block_time, length / options.feed_mm_s};
    path.blocks = {block};
    return out;
}

}  // namespace trunnion::interpolation
