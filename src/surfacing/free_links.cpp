#include "detail/free_links.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include <fmt/format.h>

#include "trunnion/geometry/great_circle.hpp"

#include "detail/surface_program.hpp"

namespace trunnion::surfacing::detail {

namespace {

constexpr double step_mm = 0.5;  ///< no point of the tool moves farther between two poses that are looked at
constexpr int most_doublings = 5;

class LinkSearch {
  public:
    LinkSearch(const Cutter& cutter, const PartBody& part, const SurfaceOptions& options, const FreeingOptions& freeing)
        : cutter_(cutter), part_(part), options_(options), freeing_(freeing) {}

    Result<double> height_mm(const Pass* before, const Pass* next) const {
        const bool beside = before && next && is_beside(*before, *next, options_);
        if (!in_part(before, next, beside ? options_.lift_mm : options_.retract_mm)) return 0.0;
        double height_mm = options_.retract_mm;
        for (int k = 0;; ++k, height_mm *= 2) {
            const auto in = in_part(before, next, height_mm);
            if (!in) return height_mm;
            if (k == most_doublings) return fail(none_free(*in, height_mm));
        }
    }

  private:
    /// The first place where the tool is in the part on its way over a height.
    std::optional<Penetration> in_part(const Pass* before, const Pass* next, double height_mm) const {
        std::vector<CutterPose> way;
        if (before) {
            const CutterPose& from = before->contacts.back().pose;
            way.push_back(from);
            way.push_back(raised(from, height_mm));
        }
        if (next) {
            const CutterPose& to = next->contacts.front().pose;
            way.push_back(raised(to, height_mm));
            way.push_back(to);
        }
        for (std::size_t k = 1; k < way.size(); ++k)
            if (auto in = on_straight(way[k - 1], way[k])) return in;
        return std::nullopt;
    }

    std::optional<Penetration> on_straight(const CutterPose& from, const CutterPose& to) const {
        const geometry::GreatCircle turn(from.axis, to.axis);
        const double arm_mm = std::max(cutter_.reach_mm(), freeing_.holder.to_mm) +
                              std::max(cutter_.radius_mm(), freeing_.holder.radius_mm);
        const double way_mm = (to.tip_mm - from.tip_mm).norm() + turn.angle_rad() * arm_mm;
        const int parts = std::max(1, static_cast<int>(std::ceil(way_mm / step_mm)));
        for (int k = 0; k <= parts; ++k) {
            const double w = static_cast<double>(k) / parts;
            const CutterPose pose{(1 - w) * from.tip_mm + w * to.tip_mm, turn.at(w)};
            if (auto in = part_.deepest(cutter_, pose, freeing_.tolerance_mm, freeing_.holder)) return in;
        }
        return std::nullopt;
    }

    static Diagnostic none_free(const Penetration& in, double height_mm) {
        return {.code = "SURF0314",
                .text = fmt::format("no way between two passes is free of the part; over the highest one that was "
                                    "tried the {} goes into it at ({:.3f} {:.3f} {:.3f})",
                                    in.by_holder ? "holder" : "tool", in.at_mm.x(), in.at_mm.y(), in.at_mm.z()),
                .value = fmt::format("depth {:.4g} mm", in.depth_mm),
                .limit = fmt::format("{:.4g} mm up the tool axis", height_mm),
                .hint = "another retract height, or another direction of the passes"};
    }

    const Cutter& cutter_;
    const PartBody& part_;
    const SurfaceOptions& options_;
    const FreeingOptions& freeing_;
};

const Pass* before(std::span<const Pass> passes, std::size_t k) {
    return k > 0 ? &passes[k - 1] : nullptr;
}
const Pass* next(std::span<const Pass> passes, std::size_t k) {
    return k < passes.size() ? &passes[k] : nullptr;
}

}  // namespace

Result<std::vector<double>> free_links(std::span<const Pass> passes, const Cutter& cutter, const PartBody& part,
                                       const SurfaceOptions& options, const FreeingOptions& freeing) {
    const LinkSearch search(cutter, part, options, freeing);
    std::vector<double> out;
    for (std::size_t k = 0; k <= passes.size(); ++k) {
        const auto height = search.height_mm(before(passes, k), next(passes, k));
        if (!height) return fail(height.error());
        out.push_back(*height);
    }
    return out;
}

std::vector<double> links_where_free(std::span<const Pass> passes, const Cutter& cutter, const PartBody& part,
                                     const SurfaceOptions& options) {
    const FreeingOptions freeing{.tolerance_mm = 2 * part.tolerance_mm()};
    const LinkSearch search(cutter, part, options, freeing);
    std::vector<double> out;
    for (std::size_t k = 0; k <= passes.size(); ++k)
        out.push_back(search.height_mm(before(passes, k), next(passes, k)).value_or(0.0));
    return out;
}

}  // namespace trunnion::surfacing::detail
