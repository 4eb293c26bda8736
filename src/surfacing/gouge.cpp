#include "trunnion/surfacing/gouge.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "trunnion/geometry/great_circle.hpp"
#include "trunnion/surfacing/path_interval.hpp"

namespace trunnion::surfacing {

using Eigen::Vector3d;

namespace {

class GougeSearch {
  public:
    GougeSearch(const Face& face, int machined, const Cutter& cutter, const PartBody& part, const GougeOptions& options)
        : face_(face), machined_(machined), cutter_(cutter), part_(part), options_(options) {}

    void along(const Pass& pass, std::size_t index) {
        for (std::size_t k = 0; k < pass.contacts.size(); ++k) {
            const Contact& from = pass.contacts[k];
            std::optional<Gouge> deepest;
            look(from, from.pose, 0, deepest);
            if (k + 1 < pass.contacts.size()) between(from, pass.contacts[k + 1], deepest);
            if (!deepest) continue;
            deepest->pass = index;
            deepest->contact = k;
            report.deepest_mm = std::max(report.deepest_mm, deepest->depth_mm);
            report.gouges.push_back(*deepest);
        }
    }

    GougeReport report;

  private:
    void between(const Contact& from, const Contact& to, std::optional<Gouge>& deepest) {
        const geometry::GreatCircle turn(from.pose.axis, to.pose.axis);
        const double arm = std::max(cutter_.reach_mm(), options_.holder.to_mm) +
                           std::max(cutter_.radius_mm(), options_.holder.radius_mm);
        const double way = (to.pose.tip_mm - from.pose.tip_mm).norm() + turn.angle_rad() * arm;
        const int parts = static_cast<int>(std::ceil(way / options_.step_mm));
        for (int k = 1; k < parts; ++k) {
            const double w = static_cast<double>(k) / parts;
            const CutterPose pose{(1 - w) * from.pose.tip_mm + w * to.pose.tip_mm, turn.at(w)};
            Contact at = from;
            at.place = {(1 - w) * from.place.u + w * to.place.u, (1 - w) * from.place.v + w * to.place.v};
            look(at, pose, w, deepest);
        }
    }

    void look(const Contact& at, const CutterPose& pose, double share, std::optional<Gouge>& deepest) {
        ++report.poses;
        const double known = deepest ? deepest->depth_mm : options_.tolerance_mm;
        const auto in = part_.deepest(cutter_, pose, known, options_.holder);
        if (!in) return;
        deepest = Gouge{.kind = kind_of(*in, at, pose),
                        .depth_mm = in->depth_mm,
                        .at_mm = in->at_mm,
                        .face = in->face,
                        .share = share,
                        .place = at.place,
                        .axis = pose.axis};
    }

    GougeKind kind_of(const Penetration& in, const Contact& at, const CutterPose& pose) const {
        if (in.by_holder) return GougeKind::holder;
        if (in.face != machined_) return GougeKind::global;
        const auto shape = shape_at(face_.surface, at.place, face_.side);
        if (shape && pose.axis.dot(shape->normal) > 0 &&
            geometry::principal_curvatures(parting(cutter_, *shape, pose.axis)).smaller < 0 &&
            (in.at_mm - shape->point).norm() < cutter_.radius_mm())
            return GougeKind::local;
        const double up = (in.at_mm - pose.tip_mm).dot(pose.axis);
        return up <= std::max(cutter_.corner_mm(), 0.1 * cutter_.radius_mm()) ? GougeKind::rear : GougeKind::global;
    }

    const Face& face_;
    int machined_;
    const Cutter& cutter_;
    const PartBody& part_;
    const GougeOptions& options_;
};

}  // namespace

const Gouge* GougeReport::worst() const noexcept {
    const auto deepest = std::ranges::max_element(gouges, {}, &Gouge::depth_mm);
    return deepest == gouges.end() ? nullptr : &*deepest;
}

Result<GougeReport> find_gouges(const Face& face, int machined, const Cutter& cutter, const PartBody& part,
                                std::span<const Pass> passes, const GougeOptions& options) {
    const auto refuse = [](const char* name, double value, std::string limit) {
        return fail({.code = "SURF0301",
                     .text = fmt::format("{} of a gouge check is out of its range", name),
                     .value = fmt::format("{} mm", value),
                     .limit = std::move(limit)});
    };
    if (!(options.tolerance_mm >= 2 * part.tolerance_mm()))
        return refuse("tolerance_mm", options.tolerance_mm,
                      fmt::format("at least twice the part's {} mm", part.tolerance_mm()));
    if (!(options.step_mm > 0)) return refuse("step_mm", options.step_mm, "above 0");
    GougeSearch search(face, machined, cutter, part, options);
    for (std::size_t k = 0; k < passes.size(); ++k) search.along(passes[k], k);
    return std::move(search.report);
}

}  // namespace trunnion::surfacing
