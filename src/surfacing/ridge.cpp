#include "detail/ridge.hpp"

#include <algorithm>
#include <cmath>

namespace trunnion::surfacing::detail {

Track::Track(const Job& job, const Way& way, bool backwards) : way_(&way), nodes_(way.places().size()) {
    for (std::size_t i = 0; i < nodes_.size(); ++i)
        if (const auto station = job.station_at_place(way, i, backwards)) {
            nodes_[i].pose = station->pose;
            nodes_[i].sound = true;
        }
    for (std::size_t arc = 0; arc < way.arcs(); ++arc) lead(way.arc_begin(arc), way.arc_end(arc));
}

/// Slopes of an arc: of the parabola through a node and its neighbours.
void Track::lead(std::size_t begin, std::size_t end) {
    const std::vector<double>& s = way_->lengths();
    if (end - begin == 2)
        for (const std::size_t i : {begin, begin + 1}) {
            const double length = s[begin + 1] - s[begin];
            nodes_[i].tip_slope = (nodes_[begin + 1].pose.tip_mm - nodes_[begin].pose.tip_mm) / length;
            nodes_[i].axis_slope = (nodes_[begin + 1].pose.axis - nodes_[begin].pose.axis) / length;
        }
    for (std::size_t i = begin; i < end && end - begin > 2; ++i) {
        const std::size_t k = std::clamp<std::size_t>(i, begin + 1, end - 2);
        const double before = s[k] - s[k - 1], after = s[k + 1] - s[k], at = s[i] - s[k];
        const auto slope = [&](const auto& of) -> Eigen::Vector3d {
            const Eigen::Vector3d rise = (of(k) - of(k - 1)) / before, next = (of(k + 1) - of(k)) / after;
            return rise + (before + 2 * at) / (before + after) * (next - rise);
        };
        nodes_[i].tip_slope = slope([this](std::size_t n) -> const Eigen::Vector3d& { return nodes_[n].pose.tip_mm; });
        nodes_[i].axis_slope = slope([this](std::size_t n) -> const Eigen::Vector3d& { return nodes_[n].pose.axis; });
        nodes_[i].sound = nodes_[i].sound && nodes_[k - 1].sound && nodes_[k].sound && nodes_[k + 1].sound;
    }
}

std::optional<CutterPose> Track::pose(double s) const noexcept {
    const std::vector<double>& lengths = way_->lengths();
    const auto next = std::upper_bound(lengths.begin() + 1, lengths.end() - 1, s);
    const auto k = static_cast<std::size_t>(next - lengths.begin()) - 1;
    const Node &a = nodes_[k], &b = nodes_[k + 1];
    if (!a.sound || !b.sound) return std::nullopt;
    const double length = lengths[k + 1] - lengths[k], w = (s - lengths[k]) / length;
    const double from = (1 + 2 * w) * (1 - w) * (1 - w), to = w * w * (3 - 2 * w);
    const double out = length * w * (1 - w) * (1 - w), in = -length * w * w * (1 - w);
    return CutterPose{from * a.pose.tip_mm + to * b.pose.tip_mm + out * a.tip_slope + in * b.tip_slope,
                      (from * a.pose.axis + to * b.pose.axis + out * a.axis_slope + in * b.axis_slope).normalized()};
}

double Track::distance_mm(const Cutter& cutter, double s, const Eigen::Vector3d& point) const noexcept {
    constexpr double nowhere_mm = 1e9;
    const auto at = pose(s);
    return at ? cutter.distance_mm(*at, point) : nowhere_mm;
}

namespace {

/// Least height of the tool above surface points while it runs along a part of a way.
class Cover {
  public:
    Cover(const Cutter& cutter, const Track& track, double s, double reach, double limit)
        : cutter_(cutter), track_(track), limit_(limit) {
        from_ = std::max(end_within(s, -reach), 0.0);
        to_ = std::min(end_within(s, reach), track.way().length());
    }

    /// Up from the surface by the distance of the nearest pose, again and again; 0 where the surface is cut into.
    /// Nothing where the nearest pose is an end of the way: beyond it the tool may be nearer.
    std::optional<double> height(const geometry::SurfaceShape& at) const {
        double height = 0, from = from_, to = to_;
        constexpr int most_rounds = 8;
        for (int round = 0; round < most_rounds && height < limit_; ++round) {
            const Eigen::Vector3d point = at.point + height * at.normal;
            const double s = nearest(point, from, to), more = track_.distance_mm(cutter_, s, point);
            constexpr double end_mm = 1e-3;
            if (s < end_mm || s > track_.way().length() - end_mm) return std::nullopt;
            height += std::max(more, 0.0);
            constexpr double exact_mm = 1e-7, narrower = 0.05;
            if (more < exact_mm) break;
            // The place moves little while the point moves up by some µm.
            const double near = narrower * (to_ - from_);
            from = std::max(s - near, from_);
            to = std::min(s + near, to_);
        }
        return std::min(height, limit_);
    }

  private:
    /// Round a sharp edge the tool comes back on the other side: there distances fall a second time.
    double end_within(double s, double reach) const {
        constexpr double far_turned = 0.5;
        const auto here = track_.pose(s);
        for (int halving = 0; here && halving < 6; ++halving, reach *= 0.5) {
            const auto there = track_.pose(std::clamp(s + reach, 0.0, track_.way().length()));
            if (there && there->axis.dot(here->axis) > far_turned) break;
        }
        return s + reach;
    }

    /// Where the tool is nearest to a point, by the golden section: distances fall and then rise.
    double nearest(const Eigen::Vector3d& point, double low, double high) const {
        constexpr double golden = 0.3819660112501051, exact_mm = 2e-4;
        const auto off = [&](double s) { return track_.distance_mm(cutter_, s, point); };
        double a = low + golden * (high - low), b = high - golden * (high - low);
        double at_a = off(a), at_b = off(b);
        while (high - low > exact_mm) {
            if (at_a < at_b) {
                high = b, b = a, at_b = at_a;
                a = low + golden * (high - low), at_a = off(a);
            } else {
                low = a, a = b, at_a = at_b;
                b = high - golden * (high - low), at_b = off(b);
            }
        }
        return at_a < at_b ? a : b;
    }

    const Cutter& cutter_;
    const Track& track_;
    double from_ = 0, to_ = 0, limit_;
};

}  // namespace

std::optional<double> ridge_between_mm(const Job& job, const Track& first, double s, const Track& second,
                                       double limit) {
    const Place a = first.way().place(s);
    const auto from = job.shape(a);
    if (!from) return std::nullopt;
    const auto on_second = second.way().nearest(a, *from);
    if (!on_second) return std::nullopt;
    const Place b = second.way().place(*on_second);
    const Eigen::Vector3d across = job.region.at(b) - from->point;
    const double reach = 1.1 * job.cutter.radius_mm() + across.norm();
    const Cover one(job.cutter, first, s, reach, limit), other(job.cutter, second, *on_second, reach, limit);
    const auto between = [&](double part) -> Place {
        if (a.chart == b.chart) return {{a.u + part * (b.u - a.u), a.v + part * (b.v - a.v)}, a.chart};
        return job.region.closest(from->point + part * across, part < 0.5 ? a : b);
    };
    double low = 0, high = 1, share = 0.5, ridge = 0;
    for (int step = 0; step < 16; ++step) {
        const auto at = job.shape(between(share));
        if (!at) return std::nullopt;
        const auto of_one = one.height(*at), of_other = other.height(*at);
        if (!of_one || !of_other) return std::nullopt;
        const double h1 = *of_one, h2 = *of_other;
        ridge = std::max(ridge, std::min(h1, h2));
        if (std::abs(h1 - h2) <= 2e-3 * (h1 + h2)) break;
        (h1 < h2 ? low : high) = share;
        // Either height grows with about the square of the distance from its way; beside a rim it does not.
        const double rate1 = std::sqrt(h1) / share, rate2 = std::sqrt(h2) / (1 - share);
        const double guess = rate2 / (rate1 + rate2);
        const bool sound = step < 4 && h1 > 0 && h2 > 0 && guess > low && guess < high;
        share = sound ? guess : 0.5 * (low + high);
    }
    return ridge;
}

}  // namespace trunnion::surfacing::detail
