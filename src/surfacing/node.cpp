#include "detail/node.hpp"

#include <cmath>

#include <fmt/format.h>

#include "trunnion/surfacing/path_interval.hpp"

namespace trunnion::surfacing::detail {

double interval_mm(const Job& job, const Station& at, const Eigen::Vector3d& axis, const Eigen::Vector3d& across,
                   double ridge) {
    const bool by_normal_radius = job.options.strategy == Strategy::lin_koren;
    return path_interval_mm(job.cutter, at.shape, axis, at.shape.components(across), ridge, by_normal_radius);
}

Result<std::vector<Node>> nodes_of(const Job& job, const Way& way, bool backwards, double correction) {
    std::vector<Node> nodes(way.places().size());
    for (std::size_t i = 0; i < nodes.size(); ++i) {
        if (way.leads_over(i)) continue;
        Node& node = nodes[i];
        node.station = job.station_at_place(way, i, backwards);
        if (!node.station) continue;
        node.inside = job.region.contains(way.places()[i]);
        if (node.inside)
            if (auto fits = check_fit(job, *node.station); !fits) {
                if (!job.options.leave_out) return fail(std::move(fits.error()));
                node.station.reset();  // intervals and ridges of what is left out do not count
                continue;
            }
        const Station& at = *node.station;
        node.interval = interval_mm(job, at, at.pose.axis, at.across, job.ridge_mm());
        node.longest = longest_interval_mm(job.cutter, at.shape, at.pose.axis, at.shape.components(at.across));
        // What straight moves are off their way sideways must not open a gap between rims.
        constexpr double flat_curvature = 1e-12;
        if (!at.shape.shape.isZero(flat_curvature)) node.longest -= 4 * job.options.chord_tolerance_mm;
        node.correction = std::min(correction, node.longest / node.interval);
    }
    return nodes;
}

double interval_factor(const Job& job, const Station& at, double ridge, double wanted) {
    constexpr double least_told = 0.02;
    const double measured = interval_mm(job, at, at.pose.axis, at.across, std::max(ridge, least_told * wanted));
    const double asked = interval_mm(job, at, at.pose.axis, at.across, wanted);
    return std::clamp(asked / measured, least_change, most_change);
}

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

bool is_unbearable(const Job& job, double highest) {
    const bool levelled = job.options.strategy == Strategy::constant_scallop;
    return highest > (levelled ? 1 + 0.5 * ridge_accuracy : 1.0) * job.options.scallop_mm;
}

Result<void> check_ridge(const Job& job, double highest, const Eigen::Vector3d& at) {
    if (!is_unbearable(job, highest)) return {};
    return fail(
        {.code = "SURF0209",
         .text =
             fmt::format("no distance of passes keeps the scallop near ({:.3f} {:.3f} {:.3f})", at.x(), at.y(), at.z()),
         .value = fmt::format("ridges of {:.4g} mm", highest),
         .limit = fmt::format("{:.4g} mm", job.options.scallop_mm),
         .hint = job.cutter.is_ball() ? "a smaller tool, another direction of feed, or another strategy"
                                      : "a smaller tool, more lead, another direction of feed, or another strategy"});
}

std::unexpected<Diagnostic> too_many_ways() {
    return fail({.code = "SURF0206",
                 .text = fmt::format("more than {} passes", most_ways),
                 .hint = "a larger scallop, or a larger tool"});
}

Result<void> check_work(std::size_t places, double covered, std::size_t ways) {
    constexpr double first_look = 0.05;
    const double spent = static_cast<double>(places) / static_cast<double>(most_work);
    // What is begun with may be the narrowest part of a face; the more is spent the less of that is left.
    const bool hopeless = spent >= first_look && covered < 2 * spent * spent;
    if (spent <= 1 && !hopeless) return {};
    return fail(
        {.code = "SURF0206",
         .text = fmt::format("{} passes, and far from done", ways),
         .value = fmt::format("{:.2g} % of the face covered, ridges measured at {} places", 100 * covered, places),
         .limit = fmt::format("{} places", most_work),
         .hint = "a larger scallop, a larger tool, or another strategy"});
}

}  // namespace trunnion::surfacing::detail
