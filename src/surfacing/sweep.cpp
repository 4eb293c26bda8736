#include "detail/sweep.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "detail/front.hpp"
#include "detail/node.hpp"
#include "detail/ridge.hpp"

namespace trunnion::surfacing::detail {

namespace {

/// One way after the other, to one side of the start.
class Sweeper {
  public:
    Sweeper(const Job& job, const Field& field, double parameter, Sweep& out)
        : job_(job), field_(field), parameter_(parameter), out_(out) {}

    /// `side`: +1 towards the across direction of the start, −1 against it. Indices go on from `index` by `side_index`.
    Result<void> run(const Way& start, int index, int side) {
        side_ = side;
        Way way = start;
        for (int count = 0; count < most_ways; ++count, index += side) {
            auto nodes = nodes_of(job_, way, job_.backwards(index), uniform() ? correction_ : 1);
            if (!nodes) return fail(std::move(nodes.error()));
            if (!uniform()) blend_over_joints(*nodes);
            auto next = next_way(way, index, *nodes);
            if (!next) return fail(std::move(next.error()));
            if (!*next || !reaches_box(**next)) return {};
            out_.ways.push_back({**next, index + side});
            way = std::move(**next);
        }
        return too_many_ways();
    }

  private:
    /// Whether all places of a way go on by one step.
    bool uniform() const { return job_.options.strategy != Strategy::constant_scallop; }

    /// How far a place moves for one unit of what the strategy counts in.
    double rate(const Station& at) const {
        switch (job_.options.strategy) {
            case Strategy::along_u:
                return std::abs(at.shape.by_v.dot(at.across));
            case Strategy::along_v:
                return std::abs(at.shape.by_u.dot(at.across));
            case Strategy::constant_scallop:
            case Strategy::parallel_planes:
            case Strategy::lin_koren:
                return 1;
        }
        return 1;
    }

    /// Of what the strategy counts in, where nothing on the first way asks for a step.
    double first_step() const {
        constexpr double share = 0.01;
        const Eigen::Vector2d size = job_.region.box(0).high - job_.region.box(0).low;
        switch (job_.options.strategy) {
            case Strategy::along_u:
                return share * size.y();
            case Strategy::along_v:
                return share * size.x();
            default:
                return 0.1 * job_.cutter.radius_mm();
        }
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
        if (std::isfinite(inside)) return inside;
        // Over ways that are left out altogether passes go on as before.
        return std::isfinite(anywhere) ? anywhere : last_step_;
    }

    /// The axis that leans in another frame as it does in the station's.
    static Eigen::Vector3d axis_in(const Station& at, const Eigen::Vector3d& normal, const Eigen::Vector3d& along,
                                   const Eigen::Vector3d& across) {
        return at.pose.axis.dot(at.shape.normal) * normal + at.pose.axis.dot(at.along) * along +
               at.pose.axis.dot(at.across) * across;
    }

    /// How far the place of the next pass that belongs to a place is ahead along the way, for one unit across it: as
    /// rays of a wave front that is as fast in each direction as the interval is long, by the logarithmic derivative of
    /// the interval by the direction. Where the tool's curvature does not turn with the feed that is the direction d
    /// conjugate to it, M d ⟂ feed. Only so is the march from pass to pass stable; places that move straight across run
    /// against what decides their interval.
    double shear(const Station& at) const {
        constexpr double turn_rad = 0.01;  // wide enough to take the mean at rulings, where the derivative jumps
        const auto turned = [&](double angle) {
            const Eigen::Vector3d across = std::cos(angle) * at.across + std::sin(angle) * at.along;
            const Eigen::Vector3d along = std::cos(angle) * at.along - std::sin(angle) * at.across;
            return interval_mm(job_, at, axis_in(at, at.shape.normal, along, across), across, job_.ridge_mm());
        };
        return (turned(turn_rad) - turned(-turn_rad)) / (2 * turn_rad * turned(0));
    }

    Place offset(const Station& at, double interval) const {
        // On the circle of the surface's curvature across the way, then onto the surface.
        const double bend = at.shape.normal_curvature(at.shape.components(at.across));
        const double sine = std::clamp(0.5 * interval * bend, -0.9, 0.9), cosine = std::sqrt(1 - sine * sine);
        const Eigen::Vector3d across = side_ * interval * cosine * at.across;
        const Eigen::Vector3d way = across + (uniform() ? 0 : side_ * interval * shear(at)) * at.along;
        const Eigen::Vector2d guess = at.shape.parameters_along(way);
        return job_.region.closest(at.shape.point + way - interval * sine * at.shape.normal,
                                   {{at.place.u + guess.x(), at.place.v + guess.y()}, at.place.chart});
    }

    /// Beyond a joint curvatures are others: of an interval that leads over one, each part counts with its face.
    void blend_over_joints(std::vector<Node>& nodes) const {
        for (Node& node : nodes) {
            if (!node.station || job_.region.charts() == 1) continue;
            const Station& at = *node.station;
            const Place there = offset(at, node.interval * node.correction);
            if (there.chart == at.place.chart) continue;
            const auto shape = job_.shape(there);
            if (!shape) continue;
            const Eigen::Vector3d way = job_.region.at(there) - at.shape.point;
            double low = 0, high = 1;
            for (int halving = 0; halving < 12; ++halving) {
                const double middle = 0.5 * (low + high);
                const Place on = job_.region.closest(at.shape.point + middle * way, at.place);
                (on.chart == at.place.chart ? low : high) = middle;
            }
            Station beyond = at;
            beyond.shape = *shape;
            const Eigen::Vector3d along = (at.along - at.along.dot(shape->normal) * shape->normal).normalized();
            const Eigen::Vector3d across = shape->normal.cross(along);
            const double beyond_mm =
                interval_mm(job_, beyond, axis_in(at, shape->normal, along, across), across, job_.ridge_mm());
            node.interval = low * node.interval + (1 - low) * beyond_mm;
        }
    }

    /// `step`: of uniform strategies.
    std::optional<Way> advanced(const Way& way, const std::vector<Node>& nodes, double step) {
        const Strategy strategy = job_.options.strategy;
        if (strategy == Strategy::along_u || strategy == Strategy::along_v) {
            next_parameter_ = parameter_ + step;
            return parameter_way(job_, field_, strategy == Strategy::along_u, next_parameter_);
        }
        std::vector<std::optional<Place>> moved;
        for (const Node& node : nodes) {
            moved.emplace_back();
            if (!node.station) continue;
            const double interval = uniform() ? step * rate(*node.station) : node.interval * node.correction;
            moved.back() = offset(*node.station, interval);
        }
        return way_of_moved(job_, field_, way, moved);
    }

    /// How many places a place's neighbourhood reaches to either side.
    std::size_t neighbours() const {
        const double width = std::max(4 * field_.spacing_mm, 0.25 * job_.cutter.radius_mm());
        return static_cast<std::size_t>(std::ceil(width / field_.spacing_mm));
    }

    /// Means over the neighbourhood of every place: the tool leaves a ridge from some way along the pass, and what one
    /// place is moved by shows at others. Without that the march would amplify what is finer.
    std::vector<double> smoothed(const std::vector<double>& factors) const {
        std::vector<double> sums{0.0}, out;
        for (const double factor : factors) sums.push_back(sums.back() + factor);
        for (std::size_t i = 0; i < factors.size(); ++i) {
            const std::size_t half = std::min({neighbours(), i, factors.size() - 1 - i});
            out.push_back((sums[i + half + 1] - sums[i - half]) / static_cast<double>(2 * half + 1));
        }
        return out;
    }

    /// The least factor of every neighbourhood, at most 1.
    std::vector<double> lowest_nearby(const std::vector<double>& factors) const {
        std::vector<double> out(factors.size(), 1.0);
        for (std::size_t i = 0; i < factors.size(); ++i) {
            const std::size_t begin = i - std::min(i, neighbours()),
                              end = std::min(factors.size(), i + neighbours() + 1);
            for (std::size_t k = begin; k < end; ++k) out[i] = std::min(out[i], factors[k]);
        }
        return out;
    }

    struct Ridges {
        double highest = 0;  ///< within the face
        Eigen::Vector3d highest_at{0, 0, 0};
        std::vector<LeftPlace> too_high;  ///< places within the face
        std::vector<double> factors;  ///< that intervals want, by place; 1 where the tool's reach is what bounds them
        double least_factor = most_change;  ///< within the face, where anything but the reach bounds; 1 without ridges
    };

    Ridges measured(const Way& way, int index, const std::vector<Node>& nodes, const Way& next, double wanted) const {
        Ridges out{.factors = std::vector(nodes.size(), 1.0)};
        bool any = false;
        const Track here(job_, way, job_.backwards(index)), there(job_, next, job_.backwards(index + side_));
        for (std::size_t i = 0; i < nodes.size(); ++i) {
            const Node& node = nodes[i];
            if (!node.station) continue;
            const auto beside = next.nearest(node.station->place, node.station->shape);
            if (!beside || *beside <= 0 || *beside >= next.length()) continue;
            const bool inside = node.inside || job_.region.contains(next.place(*beside));
            if (uniform() && !inside) continue;
            const auto ridge = highest_near(here, i, node, there, 4 * wanted);
            if (!ridge) continue;
            any = any || inside;
            if (inside && is_unbearable(job_, *ridge)) out.too_high.push_back(left_place(*node.station, next, *beside));
            if (inside && *ridge > out.highest) out.highest = *ridge, out.highest_at = node.station->shape.point;
            if (node.at_reach() && *ridge < wanted) continue;
            out.factors[i] = interval_factor(job_, *node.station, *ridge, wanted);
            if (inside) out.least_factor = std::min(out.least_factor, out.factors[i]);
        }
        for (std::size_t i = 0; i < nodes.size(); ++i)
            if (way.leads_over(i)) out.factors[i] = out.factors[i + 1];
        if (!any) out.least_factor = 1;  // as between ways near a border that is one point: left to curvatures
        return out;
    }

    /// The ridge at a place; beside a joint, where ridges change from one place to the next, the highest up to half the
    /// way to those.
    std::optional<double> highest_near(const Track& here, std::size_t i, const Node& node, const Track& there,
                                       double limit) const {
        const std::vector<double>& s = here.way().lengths();
        auto highest = ridge_between_mm(job_, here, s[i], there, limit);
        if (!highest || i == 0 || i + 1 == s.size()) return highest;
        const double off = job_.region.to_joint_mm(node.station->place.chart, node.station->shape.point);
        if (off > std::max(2 * node.interval, field_.spacing_mm)) return highest;
        const bool at_joint = here.way().leads_over(i - 1);
        for (const double share : {0.25, 0.5})
            for (const double to : {s[i - (at_joint && i > 1 ? 2 : 1)], s[i + 1]})
                if (const auto ridge = ridge_between_mm(job_, here, s[i] + share * (to - s[i]), there, limit))
                    highest = std::max(*highest, *ridge);
        return highest;
    }

    /// A ridge up to the next way.
    LeftPlace left_place(const Station& at, const Way& next, double beside) const {
        const double apart = (job_.region.at(next.place(beside)) - at.shape.point).norm();
        return {
            .at_mm = at.shape.point, .face = static_cast<int>(job_.region.number(at.place.chart)), .reach_mm = apart};
    }

    /// Corrects the intervals of constant scallop; false where they hardly change and no ridge is too high. What means
    /// cannot level is lowered in the `last` correction, as far round as they reach.
    bool corrected_each(std::vector<Node>& nodes, const Ridges& ridges, bool last) const {
        std::vector<double> factors = smoothed(ridges.factors);
        const auto change_by = [](double factor) { return std::abs(factor - 1); };
        const bool settled = change_by(*std::ranges::max_element(factors, {}, change_by)) <= 0.5 * ridge_accuracy;
        const bool too_high = ridges.highest > (1 + 0.5 * ridge_accuracy) * job_.ridge_mm();
        if (settled && !too_high) return false;
        if (last || settled) factors = smoothed(lowest_nearby(ridges.factors));
        for (std::size_t i = 0; i < nodes.size(); ++i)
            if (nodes[i].station) nodes[i].correct(factors[i]);
        return true;
    }

    Result<std::optional<Way>> next_way(const Way& way, int index, std::vector<Node>& nodes) {
        auto found = uniform() ? next_alike(way, index, nodes) : next_each(way, index, nodes);
        if (!found) return fail(std::move(found.error()));
        if (!*found) return std::nullopt;
        const Ridges& ridges = (*found)->ridges;
        if (job_.options.leave_out)
            out_.too_high.insert(out_.too_high.end(), ridges.too_high.begin(), ridges.too_high.end());
        else if (auto kept = check_ridge(job_, ridges.highest, ridges.highest_at); !kept)
            return fail(std::move(kept.error()));
        account(way, nodes, (*found)->step, ridges.highest);
        parameter_ = next_parameter_;
        return std::move((*found)->way);
    }

    struct Laid {
        Way way;
        Ridges ridges;
        double step = 0;
    };

    /// The next way with the intervals of the nodes, or one step; nothing where there is none.
    Result<std::optional<Laid>> laid(const Way& way, int index, const std::vector<Node>& nodes, double step,
                                     double wanted) {
        auto next = advanced(way, nodes, step);
        if (!next) return std::nullopt;
        if (auto fine = check_length(*next); !fine) return fail(std::move(fine.error()));
        if (auto bearable = spend(nodes.size()); !bearable) return fail(std::move(bearable.error()));
        auto ridges = measured(way, index, nodes, *next, wanted);
        return Laid{std::move(*next), std::move(ridges), step};
    }

    Result<std::optional<Laid>> next_each(const Way& way, int index, std::vector<Node>& nodes) {
        for (int attempt = 0;; ++attempt) {
            auto next = laid(way, index, nodes, 0, job_.ridge_mm());
            if (!next || !*next) return next;
            const Ridges& ridges = (*next)->ridges;
            const bool borne = attempt >= most_attempts && !is_unbearable(job_, ridges.highest);
            if (borne || attempt == utmost_attempts) return next;
            if (!corrected_each(nodes, ridges, attempt + 1 >= most_attempts)) return next;
        }
    }

    /// One step for all places, so that the highest ridge is the wanted one or just below it: after the last attempt
    /// the widest step whose ridges were no higher. Lin and Koren's step is made smaller only.
    Result<std::optional<Laid>> next_alike(const Way& way, int index, std::vector<Node>& nodes) {
        const double wanted = job_.ridge_mm(), aim = (1 - ridge_accuracy) * wanted, first = uniform_step(nodes);
        StepBracket known;
        double step = first;
        const bool by_rule = job_.options.strategy == Strategy::lin_koren;
        // What the rule leaves where it is exact is not corrected for what measuring is off.
        const double bearable =
            by_rule ? std::min((1 + 0.1 * ridge_accuracy) * wanted, job_.options.scallop_mm) : wanted;
        bool last = false;
        for (int attempt = 0;; ++attempt) {
            auto next = laid(way, index, nodes, step, aim);
            if (!next || !*next) return next;
            const Ridges& ridges = (*next)->ridges;
            const bool low_enough = ridges.highest <= bearable;
            const bool close = low_enough && (by_rule || ridges.highest > wanted * (1 - 2 * ridge_accuracy));
            if (by_rule && attempt == 0 && !low_enough) tell_rule(ridges);
            if (!last && !close && !(low_enough && attempt + 1 >= most_attempts)) {
                known.narrow(step, ridges.highest, wanted);
                const double better =
                    corrected_alike(nodes, known.is_closed() ? known.step_of(aim) / step : ridges.least_factor, step);
                const bool stands = std::abs(better - step) <= 1e-6 * step || attempt >= utmost_attempts;
                if (!stands) {
                    step = better;
                    continue;
                }
                last = !low_enough && (known.low > 0 || job_.options.leave_out);
                if (last) {
                    step = known.low > 0 ? known.low : first;  // ridges that nothing lowers are left out
                    continue;
                }
            }
            last_step_ = step;
            if (!by_rule) correction_ *= step / first;
            return next;
        }
    }

    void tell_rule(const Ridges& ridges) const {
        if (ridges.highest <= out_.rule_ridge_mm) return;
        out_.rule_ridge_mm = ridges.highest;
        out_.rule_ridge_at_mm = ridges.highest_at;
    }

    Result<void> spend(std::size_t places) {
        out_.work += places;
        const double covered = out_.covered_mm2 / field_.face_box_mm2;
        constexpr double most_covered = 5;  // both sides together, where passes fan out too
        if (covered > most_covered) return winds_up(fmt::format("{:.2g} times the face's area covered", covered), "1");
        return check_work(out_.work, covered, out_.ways.size());
    }

    static std::unexpected<Diagnostic> winds_up(std::string value, std::string limit) {
        return fail({.code = "SURF0208",
                     .text = "the passes wind up instead of crossing the face",
                     .value = std::move(value),
                     .limit = std::move(limit),
                     .hint = "another strategy or direction of feed, or a smaller tool"});
    }

    /// Ways that grow without end have run into each other's ridges, as where the tool hardly fits.
    Result<void> check_length(const Way& next) const {
        if (next.length() <= field_.longest_way_mm) return {};
        return winds_up(fmt::format("{:.4g} mm of a pass", next.length()),
                        fmt::format("{:.4g} mm", field_.longest_way_mm));
    }

    /// One correction for all places; at most as far as the tool's end reaches at each.
    double corrected_alike(std::vector<Node>& nodes, double factor, double step) const {
        const double before = uniform_step(nodes);
        for (Node& node : nodes)
            if (node.station) node.correct(factor * step / before);
        return uniform_step(nodes);
    }

    void account(const Way& way, const std::vector<Node>& nodes, double step, double highest) const {
        out_.highest_ridge_mm = std::max(out_.highest_ridge_mm, highest);
        for (std::size_t i = 0; i < nodes.size(); ++i) {
            const Node& node = nodes[i];
            if (!node.station || !job_.region.is_in_box(node.station->place)) continue;
            const double interval = uniform() ? step * rate(*node.station) : node.interval * node.correction;
            const std::size_t before = i > 1 && way.leads_over(i - 1) ? i - 2 : i - 1;
            const double length = way.lengths()[i] - (i > 0 ? way.lengths()[before] : 0);
            out_.covered_mm2 += interval * length;
            if (!node.inside) continue;
            out_.least_interval_mm = std::min(out_.least_interval_mm, interval);
            out_.largest_interval_mm = std::max(out_.largest_interval_mm, interval);
        }
    }

    /// Where a way misses the face within its box, as in a bay of it, the next ones may reach it again.
    bool reaches_box(const Way& way) const {
        return std::ranges::any_of(way.places(), [this](const Place& at) { return job_.region.is_in_box(at); });
    }

    const Job& job_;
    const Field& field_;
    double parameter_, next_parameter_ = parameter_;
    Sweep& out_;
    int side_ = 1;
    double last_step_ = first_step();
    double correction_ = 1;  ///< of the pass before, where one holds for all places
};

/// The way where the sweep starts, and what it starts with.
struct Start {
    Way way;
    double parameter = 0;
    bool both_sides = true;
    int side = 1;
};

Start border_start(const Job& job, const Field& field) {
    const bool along_u = job.options.strategy != Strategy::along_v;
    const ParameterBox& box = job.region.box(0);
    const int k = along_u ? 1 : 0;
    // Just within, so that the first pass is there.
    const double at = std::max(box.low[k] + 1e-9 * (box.high[k] - box.low[k]), field.boxes.front().low[k]);
    Start out{.way = parameter_way(job, field, along_u, at), .parameter = at, .both_sides = false};
    if (const auto middle = job.station(out.way, 0.5 * out.way.length(), false); middle) {
        const Eigen::Vector3d inward = along_u ? middle->shape.by_v : middle->shape.by_u;
        out.side = inward.dot(middle->across) > 0 ? 1 : -1;
    }
    return out;
}

}  // namespace

Eigen::Vector3d feed_in_middle(const SurfaceOptions& options, const geometry::SurfaceShape& middle) {
    // S_u × S_v leads out of the material or into it: from S_u towards S_v is against e₂ then.
    const double turn = (middle.e2.dot(middle.by_v) > 0 ? 1 : -1) * options.feed_angle_rad;
    return middle.in_space({std::cos(turn), std::sin(turn)});
}

namespace {

Start middle_start(const Job& job, const Field& field) {
    const Eigen::Vector3d feed = feed_in_middle(job.options, *job.shape(field.middle));
    return {.way = way_through(job, field, field.middle, feed, nullptr)};
}

}  // namespace

Result<Sweep> sweep(const Job& job) {
    const auto field = field_of(job);
    if (!field) return fail(field.error());
    const bool from_middle = job.options.strategy == Strategy::constant_scallop;
    const Start start = from_middle ? middle_start(job, *field) : border_start(job, *field);
    if (start.way.places().size() < 3)
        return fail({.code = "SURF0205", .text = "no pass can be laid over the face from where passes begin"});
    if (start.way.length() > field->longest_way_mm)
        return fail({.code = "SURF0208", .text = "the first pass does not get to the borders of the face"});
    Sweep out;
    out.least_interval_mm = std::numeric_limits<double>::infinity();
    out.ways.push_back({start.way, 0});
    const auto to_side = [&](int side) { return Sweeper(job, *field, start.parameter, out).run(start.way, 0, side); };
    if (auto done = to_side(start.side); !done) return fail(std::move(done.error()));
    if (start.both_sides)
        if (auto done = to_side(-start.side); !done) return fail(std::move(done.error()));
    std::ranges::stable_sort(out.ways, {}, &SweepWay::index);
    return out;
}

}  // namespace trunnion::surfacing::detail
