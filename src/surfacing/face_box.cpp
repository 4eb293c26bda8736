#include "detail/face_box.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "trunnion/geometry/great_circle.hpp"

#include "detail/bezier_patch.hpp"

namespace trunnion::surfacing::detail {

namespace {

/// How often a knot counts in the surface.
int multiplicity_of(const geometry::SurfaceDirection& direction, double knot) {
    return static_cast<int>(std::ranges::count(direction.knots, knot));
}

/// Normals are one order less smooth than their surface.
int joined_by(const geometry::SurfaceDirection& direction, double knot) {
    const int smooth = direction.degree - multiplicity_of(direction, knot) - 1;
    return std::clamp(3 - smooth, 1, 3);
}

FitDirection fit_direction(const geometry::SurfaceDirection& direction, double low, double high) {
    FitDirection out{.breaks = breaks_of(direction, std::max(low, direction.begin()), std::min(high, direction.end())),
                     .multiplicity = {}};
    for (const double knot : out.breaks) out.multiplicity.push_back(joined_by(direction, knot));
    return out;
}

}  // namespace

FaceBox face_box(const Face& face) {
    const ParameterBox box = parameter_box(face);
    return {fit_direction(face.surface.u(), box.low.x(), box.high.x()),
            fit_direction(face.surface.v(), box.low.y(), box.high.y())};
}

Result<void> check_creases(const Face& face, double most_rad) {
    const FaceBox box = face_box(face);
    const auto along = [&](bool across_u) -> Result<void> {
        const FitDirection &lines = across_u ? box.u : box.v, &other = across_u ? box.v : box.u;
        constexpr int places = 64;
        for (std::size_t k = 1; k + 1 < lines.breaks.size(); ++k) {
            const double knot = lines.breaks[k], before = knot - 1e-9 * (knot - lines.breaks[k - 1]);
            for (int i = 0; lines.multiplicity[k] == 3 && i < places; ++i) {
                const double at =
                    other.breaks.front() + (i + 0.5) / places * (other.breaks.back() - other.breaks.front());
                const geometry::SurfacePlace there =
                    across_u ? geometry::SurfacePlace{knot, at} : geometry::SurfacePlace{at, knot};
                const auto one = shape_at(face.surface, there, face.side);
                const auto two = shape_at(
                    face.surface, across_u ? geometry::SurfacePlace{before, at} : geometry::SurfacePlace{at, before},
                    face.side);
                if (!one || !two || !contains(face, there)) continue;
                if (const double jump = geometry::angle_between(one->normal, two->normal); jump > most_rad)
                    return fail({.code = "SURF0306",
                                 .text = fmt::format("the surface has a crease at ({:.3f} {:.3f} {:.3f}), where the "
                                                     "guiding surface would tear",
                                                     one->point.x(), one->point.y(), one->point.z()),
                                 .value = fmt::format("{:.3g} rad at {} = {:.6g}", jump, across_u ? "u" : "v", knot),
                                 .limit = fmt::format("{:.3g} rad", most_rad),
                                 .hint = "cut the face in two along it"});
            }
        }
        return {};
    };
    if (auto smooth = along(true); !smooth) return smooth;
    return along(false);
}

}  // namespace trunnion::surfacing::detail
