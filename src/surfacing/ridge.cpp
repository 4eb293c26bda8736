#include "detail/ridge.hpp"

#include <algorithm>
#include <cmath>

namespace trunnion::surfacing::detail {

namespace {

/// Least height of the tool above a surface point while it runs along a way, by the parabola through three heights.
class Cover {
  public:
    Cover(const Job& job, const Track& track, double s, double spread, double limit)
        : job_(job), track_(track), s_(s), spread_(spread), limit_(limit) {}

    double height(const geometry::SurfaceShape& at) {
        double best = limit_;
        for (double spread = spread_; spread > 0.1 * spread_; spread *= 0.2) {
            const double before = height_from(s_ - spread, at), here = height_from(s_, at),
                         after = height_from(s_ + spread, at);
            const double bend = before - 2 * here + after;
            const double move = bend > 0 ? 0.5 * (before - after) / bend : 0;
            s_ = std::clamp(s_ + std::clamp(move, -4.0, 4.0) * spread, 0.0, track_.way.length());
            best = std::min({best, before, here, after});
        }
        return std::min(best, height_from(s_, at));
    }

  private:
    double height_from(double s, const geometry::SurfaceShape& at) const {
        const auto station = job_.station(track_.way, std::clamp(s, 0.0, track_.way.length()), track_.backwards);
        return station ? job_.cutter.height_mm(station->pose, at.point, at.normal, limit_) : limit_;
    }
    const Job& job_;
    const Track& track_;
    double s_, spread_, limit_;
};

}  // namespace

double ridge_between_mm(const Job& job, const Track& first, double s, const Track& second, double limit) {
    const geometry::SurfacePlace a = first.way.place(s);
    const Eigen::Vector3d from = job.face.surface.at(a.u, a.v);
    const double on_second = second.way.nearest(from);
    const geometry::SurfacePlace b = second.way.place(on_second);
    const double spread = 0.1 * (job.face.surface.at(b.u, b.v) - from).norm() + 1e-6;
    Cover one(job, first, s, spread, limit), other(job, second, on_second, spread, limit);
    double share = 0.5, ridge = 0;
    for (int step = 0; step < 4; ++step) {
        const auto at = job.shape({a.u + share * (b.u - a.u), a.v + share * (b.v - a.v)});
        if (!at) return 0;
        const double h1 = std::max(one.height(*at), 0.0), h2 = std::max(other.height(*at), 0.0);
        ridge = std::min(h1, h2);
        if (std::abs(h1 - h2) < 1e-3 * (h1 + h2) || h1 + h2 == 0) break;
        // Either height grows with about the square of the distance from its way.
        const double rate1 = std::sqrt(h1) / share, rate2 = std::sqrt(h2) / (1 - share);
        share = std::clamp(rate2 / (rate1 + rate2), 0.02, 0.98);
    }
    return ridge;
}

}  // namespace trunnion::surfacing::detail
