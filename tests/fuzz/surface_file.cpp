#include "trunnion/files/surface_file.hpp"

#include "entries.hpp"

namespace trunnion::fuzz {

namespace {

void expect_sound(const geometry::SurfaceDirection& direction) {
    expect(direction.degree >= 1 && direction.degree <= 7, "degrees are 1 to 7");
    expect(direction.points() > static_cast<std::size_t>(direction.degree), "there are points for the degree");
    expect(direction.begin() < direction.end(), "a domain has a length");
}

}  // namespace

void take_surface_file(std::string_view bytes) {
    const auto surfaces = files::read_surfaces(bytes, "fuzz");
    if (!surfaces) return expect_sound(surfaces.error(), bytes);
    expect(!surfaces->empty(), "a file without a surface is refused");
    for (const files::DescribedSurface& described : *surfaces) {
        const geometry::BsplineSurface& surface = described.surface;
        expect_sound(surface.u());
        expect_sound(surface.v());
        expect(surface.control_points_mm().size() == surface.u().points() * surface.v().points(), "the net is whole");
        for (const Eigen::Vector3d& point : surface.control_points_mm())
            expect(point.allFinite(), "points are numbers");
    }
}

}  // namespace trunnion::fuzz
