#include "detail/plane_sections.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>

#include "trunnion/surfacing/path_interval.hpp"

#include "detail/front.hpp"
#include "detail/node.hpp"
#include "detail/ridge.hpp"
#include "detail/sweep.hpp"

namespace trunnion::surfacing::detail {

namespace {

/// Where the planes of one direction cut one face.
class FaceSections {
  public:
    FaceSections(const Job& job, Field field, Eigen::Vector3d normal)
        : job_(job), field_(std::move(field)), normal_(std::move(normal)) {
        for (int i = 0; i <= parts; ++i)
            for (int j = 0; j <= parts; ++j) {
                offsets_.push_back(normal_.dot(job_.region.at(place(i, j))));
            }
        const auto [low, high] = std::ranges::minmax_element(offsets_);
        low_ = *low, high_ = *high;
    }

    double low() const { return low_; }
    double high() const { return high_; }
    const Job& job() const { return job_; }

    std::vector<Way> at(double offset) const {
        std::vector<Way> out;
        for (int i = 0; i <= parts; ++i)
            for (int j = 0; j <= parts; ++j) {
                if (i < parts) across(offset, i, j, i + 1, j, out);
                if (j < parts) across(offset, i, j, i, j + 1, out);
            }
        return out;
    }

  private:
    static constexpr int parts = 40;

    Place place(int i, int j) const {
        const ParameterBox& box = field_.boxes.front();
        const Eigen::Vector2d size = box.high - box.low;
        return {{box.low.x() + size.x() * i / parts, box.low.y() + size.y() * j / parts}, 0};
    }
    double offset_at(int i, int j) const {
        return offsets_[static_cast<std::size_t>(i) * (parts + 1) + static_cast<std::size_t>(j)];
    }

    /// The way through the place where an edge of the grid crosses the plane, unless it is there already.
    void across(double offset, int i0, int j0, int i1, int j1, std::vector<Way>& out) const {
        const double a = offset_at(i0, j0) - offset, b = offset_at(i1, j1) - offset;
        if ((a > 0) == (b > 0)) return;
        const Place from = place(i0, j0), to = place(i1, j1);
        const double share = a / (a - b);
        const Planes plane{normal_, offset};
        const auto seed =
            onto_plane(job_, plane, {{from.u + share * (to.u - from.u), from.v + share * (to.v - from.v)}, 0});
        if (!seed || !field_.holds(*seed)) return;
        const auto shape = job_.shape(*seed);
        if (!shape) return;
        const double near = 0.5 * field_.spacing_mm;
        const auto is_on = [&](const Way& way) { return way.distance_mm(shape->point) < near; };
        if (std::ranges::any_of(out, is_on)) return;
        Way way = way_through(job_, field_, *seed, normal_.cross(shape->normal).normalized(), &plane);
        if (way.places().size() >= 3) out.push_back(std::move(way));
    }

    const Job& job_;
    Field field_;
    Eigen::Vector3d normal_;
    std::vector<double> offsets_;
    double low_ = 0, high_ = 0;
};

/// The ways of one plane on all faces.
using Row = std::vector<SectionWay>;

class PlaneSweep {
  public:
    PlaneSweep(std::vector<FaceSections> faces, Eigen::Vector3d normal, PlaneSections& out)
        : faces_(std::move(faces)), normal_(std::move(normal)), out_(out) {}

    Row row(double offset, int index) const {
        Row out;
        for (std::size_t k = 0; k < faces_.size(); ++k)
            for (Way& way : faces_[k].at(offset)) out.push_back({k, std::move(way), index});
        return out;
    }

    /// From one plane on to one side, until no face is there.
    Result<void> run(double offset, int side) {
        double low = faces_.front().low(), high = faces_.front().high();
        for (const FaceSections& face : faces_) {
            low = std::min(low, face.low());
            high = std::max(high, face.high());
        }
        double step = 0.01 * (high - low);
        Row here = row(offset, 0);
        for (int index = 0; std::abs(index) < most_ways; index += side) {
            auto asked = step_from(here);
            if (!asked) return fail(std::move(asked.error()));
            // Over a gap between faces the planes go on as before.
            if (std::isfinite(*asked)) step = *asked;
            Row next;
            if (auto done = corrected(here, offset, side, index, step, next); !done) return done;
            offset += side * step;
            covered_ += step / (high - low);
            if (offset < low || offset > high) return {};
            for (const SectionWay& way : next) out_.ways.push_back(way);
            here = std::move(next);
        }
        return too_many_ways();
    }

  private:
    /// Least step that curvatures ask for within the faces; infinite without any.
    Result<double> step_from(const Row& here) const {
        double step = std::numeric_limits<double>::infinity();
        for (const SectionWay& one : here) {
            const Job& job = faces_[one.face].job();
            const auto nodes = nodes_of(job, one.way, job.backwards(one.index), 1);
            if (!nodes) return fail(nodes.error());
            for (const Node& node : *nodes)
                if (node.inside && node.station)
                    step = std::min(step, std::min(node.interval, node.longest) * across(*node.station));
        }
        return step;
    }

    /// How far a plane moves while its place on the surface moves by one.
    double across(const Station& at) const { return std::max(std::abs(normal_.dot(at.across)), 1e-3); }

    struct Ridges {
        double highest = 0, factor = most_change, largest_step = std::numeric_limits<double>::infinity();
        Eigen::Vector3d highest_at{0, 0, 0};
        std::vector<LeftPlace> too_high;
    };

    Result<void> corrected(const Row& here, double offset, int side, int index, double& step, Row& next) {
        const Job& job = faces_.front().job();
        const double wanted = job.ridge_mm();
        const double first = step;
        StepBracket known;
        Ridges ridges;
        bool last = false;
        for (int attempt = 0;; ++attempt) {
            next = row(offset + side * step, index + side);
            if (auto bearable = spend(here); !bearable) return bearable;
            ridges = measured(here, next);
            if (last || (ridges.highest <= wanted && ridges.highest > wanted * (1 - 2 * ridge_accuracy))) break;
            known.narrow(step, ridges.highest, wanted);
            const double asked =
                known.is_closed() ? known.step_of((1 - ridge_accuracy) * wanted) : step * ridges.factor;
            double better = std::min(asked, ridges.largest_step);
            if (attempt + 1 >= most_attempts && ridges.highest <= wanted) break;
            if (attempt + 1 >= utmost_attempts || std::abs(better - step) < 1e-6 * step) {
                if (ridges.highest <= wanted || (known.low == 0 && !job.options.leave_out)) break;
                better = known.low > 0 ? known.low : first;  // ridges that nothing lowers are left out
                last = true;
            }
            step = better;
        }
        if (job.options.leave_out)
            out_.too_high.insert(out_.too_high.end(), ridges.too_high.begin(), ridges.too_high.end());
        else if (auto kept = check_ridge(job, ridges.highest, ridges.highest_at); !kept)
            return kept;
        account(here, step, ridges.highest);
        return {};
    }

    Result<void> spend(const Row& here) {
        for (const SectionWay& one : here) work_ += one.way.lengths().size();
        return check_work(work_, covered_, out_.ways.size());
    }

    Ridges measured(const Row& here, const Row& next) const {
        Ridges out;
        bool any = false;
        for (const SectionWay& one : here)
            for (const SectionWay& other : next)
                if (other.face == one.face) any |= measure(one, other, out);
        if (!any) out.factor = 1;
        return out;
    }

    bool measure(const SectionWay& one, const SectionWay& other, Ridges& out) const {
        const Job& job = faces_[one.face].job();
        const Track first(job, one.way, job.backwards(one.index)), second(job, other.way, job.backwards(other.index));
        const double wanted = (1 - ridge_accuracy) * job.ridge_mm();
        bool any = false;
        for (const double s : one.way.lengths()) {
            const auto station = job.station(one.way, s, job.backwards(one.index));
            if (!station) continue;
            const auto beside = other.way.nearest(station->place, station->shape);
            if (!beside || *beside <= 0 || *beside >= other.way.length()) continue;
            if (!job.region.contains(station->place) && !job.region.contains(other.way.place(*beside))) continue;
            // Another part of the face's section is not beside this one.
            const double apart = other.way.distance_mm(station->shape.point);
            if (apart > 3 * job.cutter.radius_mm()) continue;
            const auto ridge = ridge_between_mm(job, first, s, second, 4 * wanted);
            if (!ridge) continue;
            any = true;
            if (is_unbearable(job, *ridge))
                out.too_high.push_back({station->shape.point, static_cast<int>(one.face), apart});
            if (*ridge > out.highest) out.highest = *ridge, out.highest_at = station->shape.point;
            const double longest = longest_interval_mm(job.cutter, station->shape, station->pose.axis,
                                                       station->shape.components(station->across));
            out.largest_step = std::min(out.largest_step, longest * across(*station));
            out.factor = std::min(out.factor, interval_factor(job, *station, *ridge, wanted));
        }
        return any;
    }

    void account(const Row& here, double step, double highest) {
        out_.highest_ridge_mm = std::max(out_.highest_ridge_mm, highest);
        for (const SectionWay& one : here)
            for (const double s : one.way.lengths()) {
                const Job& job = faces_[one.face].job();
                const auto station = job.station(one.way, s, false);
                if (!station || !job.region.contains(station->place)) continue;
                const double interval = step / across(*station);
                out_.least_interval_mm = std::min(out_.least_interval_mm, interval);
                out_.largest_interval_mm = std::max(out_.largest_interval_mm, interval);
            }
    }

    std::vector<FaceSections> faces_;
    Eigen::Vector3d normal_;
    PlaneSections& out_;
    std::size_t work_ = 0;
    double covered_ = 0;  ///< share of all planes that are gone over
};

}  // namespace

Result<PlaneSections> plane_sections(std::span<const Job> jobs) {
    std::vector<Field> fields;
    for (const Job& job : jobs) {
        auto field = field_of(job);
        if (!field) return fail(std::move(field.error()));
        fields.push_back(*field);
    }
    const geometry::SurfaceShape middle = *jobs.front().shape(fields.front().middle);
    const Eigen::Vector3d normal = middle.normal.cross(feed_in_middle(jobs.front().options, middle));
    std::vector<FaceSections> faces;
    for (std::size_t k = 0; k < jobs.size(); ++k) faces.emplace_back(jobs[k], fields[k], normal);
    PlaneSections out;
    out.least_interval_mm = std::numeric_limits<double>::infinity();
    PlaneSweep sweep(std::move(faces), normal, out);
    const double offset = normal.dot(middle.point);
    out.ways = sweep.row(offset, 0);
    for (const int side : {1, -1})
        if (auto done = sweep.run(offset, side); !done) return fail(std::move(done.error()));
    std::ranges::stable_sort(out.ways, {}, &SectionWay::index);
    return out;
}

}  // namespace trunnion::surfacing::detail
