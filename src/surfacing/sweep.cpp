#include "detail/sweep.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "trunnion/surfacing/path_interval.hpp"

#include "detail/front.hpp"
#include "detail/ridge.hpp"

namespace trunnion::surfacing::detail {

using geometry::SurfacePlace;

namespace {

constexpr double ridge_accuracy = 0.01;  ///< share of the scallop
constexpr int most_attempts = 6;
constexpr double steepest_shear = 20;
constexpr int most_ways = 20000;

/// What is known at a place of a way.
struct Node {
    std::optional<Station> station;
    bool inside = false;    ///< of the face
    double interval = 0;    ///< to the next way, by curvatures
    double longest = 0;     ///< that the tool's end bears
    double correction = 1;  ///< of that interval, by ridges

    void correct(double factor) {
        correction = std::min(correction * std::clamp(factor, 0.6, 1.5), longest / interval);
    }
};

/// One way after the other, to one side of the start.
class Sweeper {
  public:
    Sweeper(const Job& job, const Field& field, std::optional<Planes> planes, double parameter, Sweep& out)
        : job_(job), field_(field), planes_(planes), parameter_(parameter), out_(out) {}

    /// `side`: +1 towards the across direction of the start, −1 against it. Indices go on from `index` by `side_index`.
    Result<void> run(const Way& start, int index, int side) {
        side_ = side;
        Way way = start;
        for (int count = 0; count < most_ways; ++count, index += side) {
            auto nodes = nodes_of(way, index);
            if (!nodes) return fail(std::move(nodes.error()));
            choose_uniform(*nodes);
            auto next = next_way(way, index, *nodes);
            if (!next || !reaches_face(*next)) return {};
            correction_ = std::ranges::max_element(*nodes, {}, &Node::correction)->correction;
            out_.ways.push_back({*next, index + side});
            way = std::move(*next);
        }
        return fail({.code = "SURF0206",
                     .text = fmt::format("more than {} passes", most_ways),
                     .hint = "a larger scallop, or a larger tool"});
    }

  private:
    /// Whether all places of a way go on by one step: always but with constant_scallop, and there too where the
    /// conjugate direction leads farther ahead than the tool's end reaches (a flat tool fed nearly along the rulings of
    /// a developable surface): what bounds the ridge there is the end's rim, not curvature.
    bool uniform() const { return even_; }

    void choose_uniform(const std::vector<Node>& nodes) {
        even_ =
            job_.options.strategy != Strategy::constant_scallop || std::ranges::any_of(nodes, [this](const Node& node) {
                return node.inside && std::abs(shear(*node.station)) * node.interval >= job_.cutter.radius_mm();
            });
    }

    Result<std::vector<Node>> nodes_of(const Way& way, int index) const {
        std::vector<Node> nodes(way.places().size());
        const bool by_normal_radius = job_.options.strategy == Strategy::lin_koren;
        for (std::size_t i = 0; i < nodes.size(); ++i) {
            Node& node = nodes[i];
            node.station = job_.station(way, way.lengths()[i], job_.backwards(index));
            if (!node.station) continue;
            node.inside = contains(job_.face, way.places()[i]);
            if (node.inside)
                if (auto fits = check_fit(job_, *node.station); !fits) return fail(std::move(fits.error()));
            const Station& at = *node.station;
            node.interval = path_interval_mm(job_.cutter, at.shape, at.pose.axis, at.shape.components(at.across),
                                             job_.ridge_mm(), by_normal_radius);
            node.longest = longest_interval_mm(job_.cutter, at.shape, at.pose.axis, at.shape.components(at.across));
            node.correction = std::min(uniform() ? correction_ : 1, node.longest / node.interval);
        }
        return nodes;
    }

    /// How far a place moves for one unit of what the strategy counts in.
    double rate(const Station& at) const {
        switch (job_.options.strategy) {
            case Strategy::along_u:
                return std::abs(at.shape.by_v.dot(at.across));
            case Strategy::along_v:
                return std::abs(at.shape.by_u.dot(at.across));
            case Strategy::parallel_planes:
                return 1 / std::max(std::abs(planes_->normal.dot(at.across)), 1e-3);
            case Strategy::constant_scallop:
            case Strategy::lin_koren:
                return 1;
        }
        return 1;
    }

    /// The step of uniform strategies: the least that any place within the face asks for.
    double uniform_step(const std::vector<Node>& nodes) const {
        double inside = std::numeric_limits<double>::infinity(), anywhere = inside;
        for (const Node& node : nodes) {
            if (!node.station) continue;
            const double step = node.interval * node.correction / rate(*node.station);
            anywhere = std::min(anywhere, step);
            if (node.inside) inside = std::min(inside, step);
        }
        return std::isfinite(inside) ? inside : anywhere;
    }

    /// How far the place of the next pass that belongs to a place is ahead along the way, for one unit across it: that
    /// lies in the direction conjugate to the feed, M d ⟂ feed. Only so is the march from pass to pass stable; places
    /// that move straight across run against what decides their interval.
    double shear(const Station& at) const {
        const bool turns_with_feed = !job_.cutter.is_ball() && !Cutter::upright(at.shape.normal, at.pose.axis);
        if (turns_with_feed) return shear_of_turning_tool(at);
        const Eigen::Matrix2d matrix = parting(job_.cutter, at.shape, at.pose.axis);
        const Eigen::Vector2d along = at.shape.components(at.along), across = at.shape.components(at.across);
        const double feed = along.dot(matrix * along), mixed = across.dot(matrix * along);
        if (std::abs(mixed) <= 1e-12 * across.dot(matrix * across)) return 0;
        return std::abs(mixed) < steepest_shear * feed ? -mixed / feed : std::copysign(steepest_shear, -mixed);
    }

    /// The same where K turns with the feed: the logarithmic derivative of the interval by the direction across, which
    /// is M's conjugate direction where M stays.
    double shear_of_turning_tool(const Station& at) const {
        constexpr double turn_rad = 1e-4;
        const auto interval = [&](double angle) {
            const Eigen::Vector3d across = std::cos(angle) * at.across + std::sin(angle) * at.along;
            const Eigen::Vector3d along = std::cos(angle) * at.along - std::sin(angle) * at.across;
            const Eigen::Vector3d axis = at.pose.axis.dot(at.shape.normal) * at.shape.normal +
                                         at.pose.axis.dot(at.along) * along + at.pose.axis.dot(at.across) * across;
            return path_interval_mm(job_.cutter, at.shape, axis, at.shape.components(across), job_.ridge_mm());
        };
        return (interval(turn_rad) - interval(-turn_rad)) / (2 * turn_rad * interval(0));
    }

    SurfacePlace offset(const Station& at, double interval) const {
        // On the circle of the surface's curvature across the way, then onto the surface.
        const double bend = at.shape.normal_curvature(at.shape.components(at.across));
        const double sine = std::clamp(0.5 * interval * bend, -0.9, 0.9), cosine = std::sqrt(1 - sine * sine);
        const Eigen::Vector3d across = side_ * interval * cosine * at.across;
        const Eigen::Vector3d way = across + (uniform() ? 0 : side_ * interval * shear(at)) * at.along;
        const Eigen::Vector2d guess = at.shape.parameters_along(way);
        return geometry::closest_place(job_.face.surface, at.shape.point + way - interval * sine * at.shape.normal,
                                       {at.place.u + guess.x(), at.place.v + guess.y()}, 1);
    }

    std::optional<Way> advanced(const Way& way, const std::vector<Node>& nodes) {
        const double step = uniform() ? uniform_step(nodes) : 0;
        const Strategy strategy = job_.options.strategy;
        if (strategy == Strategy::along_u || strategy == Strategy::along_v) {
            next_parameter_ = parameter_ + step;
            return parameter_way(job_, field_, strategy == Strategy::along_u, next_parameter_);
        }
        if (planes_) next_planes_ = Planes{planes_->normal, planes_->offset_mm + side_ * step};
        std::vector<std::optional<SurfacePlace>> moved;
        for (const Node& node : nodes) {
            moved.emplace_back();
            if (!node.station) continue;
            const double interval = uniform() ? step * rate(*node.station) : node.interval * node.correction;
            moved.back() = offset(*node.station, interval);
            if (planes_) moved.back() = onto_plane(job_, *next_planes_, *moved.back());
        }
        return way_of_moved(job_, field_, way, moved, planes_ ? &*next_planes_ : nullptr);
    }

    struct Measured {
        double highest = 0;
        double worst = 0;  ///< largest |ridge/wanted − 1| of constant scallop within the face, where it can be helped
    };

    /// Means over the neighbourhood of every place: the tool leaves a ridge from some way along the pass, and what one
    /// place is moved by shows at others. Without that the march would amplify what is finer.
    std::vector<double> smoothed(const std::vector<double>& factors) const {
        const double width = std::max(8 * field_.spacing_mm, 0.5 * job_.cutter.radius_mm());
        const auto reach = static_cast<std::size_t>(std::ceil(width / field_.spacing_mm));
        std::vector<double> sums{0.0}, out;
        for (const double factor : factors) sums.push_back(sums.back() + factor);
        for (std::size_t i = 0; i < factors.size(); ++i) {
            const std::size_t half = std::min({reach, i, factors.size() - 1 - i});
            out.push_back((sums[i + half + 1] - sums[i - half]) / static_cast<double>(2 * half + 1));
        }
        return out;
    }

    struct Ridges {
        double highest = 0;           ///< within the face
        std::vector<double> factors;  ///< that intervals want, by place
    };

    Ridges measured(const Way& way, int index, const std::vector<Node>& nodes, const Way& next) const {
        Ridges out{.factors = std::vector(nodes.size(), 1.0)};
        const double wanted = job_.ridge_mm();
        for (std::size_t i = 0; i < nodes.size(); ++i) {
            const Node& node = nodes[i];
            if (!node.station) continue;
            const double beside = next.nearest(node.station->shape.point);
            if (beside <= 0 || beside >= next.length()) continue;
            const bool inside = node.inside || contains(job_.face, next.place(beside));
            if (uniform() && !inside) continue;
            const double ridge = ridge_between_mm(job_, {way, job_.backwards(index)}, way.lengths()[i],
                                                  {next, job_.backwards(index + side_)}, 4 * wanted);
            if (inside) out.highest = std::max(out.highest, ridge);
            // Where the tool's own reach bounds the interval ridges stay lower.
            const bool bounded = node.interval * node.correction >= node.longest && ridge < wanted;
            if (!bounded && ridge > 0.1 * wanted) out.factors[i] = std::clamp(std::sqrt(wanted / ridge), 0.6, 1.5);
        }
        return out;
    }

    /// Corrects the intervals of constant scallop; false where they hardly change.
    bool corrected_each(std::vector<Node>& nodes, const Ridges& ridges) const {
        const std::vector<double> factors = smoothed(ridges.factors);
        double change = 0;
        for (std::size_t i = 0; i < nodes.size(); ++i) {
            if (!nodes[i].station) continue;
            nodes[i].correct(factors[i]);
            change = std::max(change, std::abs(factors[i] - 1));
        }
        return change > 0.5 * ridge_accuracy;
    }

    std::optional<Way> next_way(const Way& way, int index, std::vector<Node>& nodes) {
        std::optional<Way> next;
        double highest = 0;
        for (int attempt = 0; attempt < most_attempts; ++attempt) {
            next = advanced(way, nodes);
            if (!next) return next;
            const Ridges ridges = measured(way, index, nodes, *next);
            highest = ridges.highest;
            if (job_.options.strategy == Strategy::lin_koren) break;
            if (uniform() ? !corrected_alike(nodes, ridges.highest) : !corrected_each(nodes, ridges)) break;
        }
        account(nodes, highest);
        parameter_ = next_parameter_;
        planes_ = next_planes_;
        return next;
    }

    /// One correction for all places; false where the ridges are as wanted.
    bool corrected_alike(std::vector<Node>& nodes, double highest) const {
        const double wanted = job_.ridge_mm();
        if (highest < 0.1 * wanted) return false;
        if (highest <= wanted && highest > wanted * (1 - 2 * ridge_accuracy)) return false;
        const double before = uniform_step(nodes);
        for (Node& node : nodes) node.correct(std::sqrt((1 - ridge_accuracy) * wanted / highest));
        return uniform_step(nodes) != before;
    }

    void account(const std::vector<Node>& nodes, double highest) const {
        out_.highest_ridge_mm = std::max(out_.highest_ridge_mm, highest);
        const double step = uniform() ? uniform_step(nodes) : 0;
        for (const Node& node : nodes) {
            if (!node.inside || !node.station) continue;
            const double interval = uniform() ? step * rate(*node.station) : node.interval * node.correction;
            out_.least_interval_mm = std::min(out_.least_interval_mm, interval);
            out_.largest_interval_mm = std::max(out_.largest_interval_mm, interval);
        }
    }

    bool reaches_face(const Way& way) const {
        const int steps = 4 * static_cast<int>(way.places().size());
        for (int k = 0; k <= steps; ++k)
            if (contains(job_.face, way.place(way.length() * k / steps))) return true;
        return false;
    }

    const Job& job_;
    const Field& field_;
    std::optional<Planes> planes_, next_planes_ = planes_;
    double parameter_, next_parameter_ = parameter_;
    Sweep& out_;
    int side_ = 1;
    bool even_ = false;
    double correction_ = 1;  ///< of the pass before, where one holds for all places
};

/// The way where the sweep starts, and what it starts with.
struct Start {
    Way way;
    std::optional<Planes> planes;
    double parameter = 0;
    bool both_sides = true;
    int side = 1;
};

Start border_start(const Job& job, const Field& field) {
    const bool along_u = job.options.strategy != Strategy::along_v;
    const ParameterBox box = parameter_box(job.face);
    const int k = along_u ? 1 : 0;
    // Just within, so that the first pass is there.
    const double at = std::max(box.low[k] + 1e-9 * (box.high[k] - box.low[k]), field.box.low[k]);
    Start out{.way = parameter_way(job, field, along_u, at), .planes = {}, .parameter = at, .both_sides = false};
    if (const auto middle = job.station(out.way, 0.5 * out.way.length(), false); middle) {
        const Eigen::Vector3d inward = along_u ? middle->shape.by_v : middle->shape.by_u;
        out.side = inward.dot(middle->across) > 0 ? 1 : -1;
    }
    return out;
}

Start middle_start(const Job& job, const Field& field) {
    const SurfacePlace middle{field.middle.x(), field.middle.y()};
    const geometry::SurfaceShape shape = *job.shape(middle);
    // S_u × S_v leads out of the material or into it: from S_u towards S_v is against e₂ then.
    const double turn = (shape.e2.dot(shape.by_v) > 0 ? 1 : -1) * job.options.feed_angle_rad;
    const Eigen::Vector3d feed = shape.in_space({std::cos(turn), std::sin(turn)});
    Start out;
    if (job.options.strategy == Strategy::parallel_planes) {
        const Eigen::Vector3d across = shape.normal.cross(feed);
        out.planes = Planes{across, across.dot(shape.point)};
    }
    out.way = way_through(job, field, middle, feed, out.planes ? &*out.planes : nullptr);
    return out;
}

bool starts_in_middle(Strategy strategy) {
    return strategy == Strategy::constant_scallop || strategy == Strategy::parallel_planes;
}

}  // namespace

Result<void> check_fit(const Job& job, const Station& station) {
    const Cutter& cutter = job.cutter;
    const bool upright = !cutter.is_ball() && Cutter::upright(station.shape.normal, station.pose.axis);
    const double least = geometry::principal_curvatures(parting(cutter, station.shape, station.pose.axis)).smaller;
    // An upright flat end may stand on its rim, as deep as gouging is allowed.
    const double depth = upright ? -0.5 * least * std::pow(cutter.flat_radius_mm(), 2) : 0;
    if (upright ? depth <= job.options.gouge_tolerance_mm : least > 0) return {};
    const double hollow = -geometry::principal_curvatures(station.shape.shape).smaller;
    const Eigen::Vector3d& at = station.shape.point;
    return fail({.code = "SURF0203",
                 .text = fmt::format("the surface is too hollow for the tool at ({:.3f} {:.3f} {:.3f})", at.x(), at.y(),
                                     at.z()),
                 .value = fmt::format("radius of the hollow {:.4g} mm", 1 / hollow),
                 .limit = cutter.is_ball() ? fmt::format("ball of radius {:.4g} mm", cutter.radius_mm())
                                           : fmt::format("end of radius {:.4g} mm", cutter.radius_mm()),
                 .hint = fmt::format("a ball of radius below {:.4g} mm could", 1 / hollow)});
}

Result<Sweep> sweep(const Job& job) {
    const auto field = field_of(job);
    if (!field) return fail(field.error());
    const Start start = starts_in_middle(job.options.strategy) ? middle_start(job, *field) : border_start(job, *field);
    if (start.way.places().size() < 3)
        return fail({.code = "SURF0205", .text = "no pass can be laid over the face from where passes begin"});
    Sweep out;
    out.least_interval_mm = std::numeric_limits<double>::infinity();
    out.ways.push_back({start.way, 0});
    const auto to_side = [&](int side) {
        return Sweeper(job, *field, start.planes, start.parameter, out).run(start.way, 0, side);
    };
    if (auto done = to_side(start.side); !done) return fail(std::move(done.error()));
    if (start.both_sides)
        if (auto done = to_side(-start.side); !done) return fail(std::move(done.error()));
    std::ranges::stable_sort(out.ways, {}, &SweepWay::index);
    return out;
}

}  // namespace trunnion::surfacing::detail
