#include "trunnion/files/setup_file.hpp"

#include <cmath>

#include "entries.hpp"

namespace trunnion::fuzz {

namespace {

void expect_sound(const machine::Frame& frame) {
    expect(frame.origin_mm.allFinite(), "origins are finite");
    expect((frame.rotation.transpose() * frame.rotation - Eigen::Matrix3d::Identity()).norm() < 1e-9,
           "rotations turn and do nothing else");
}

void expect_sound(const machine::Tool& tool) {
    expect(std::isfinite(tool.diameter_mm) && tool.diameter_mm >= 0, "diameters are finite and not negative");
    expect(std::isfinite(tool.corner_radius_mm) && tool.corner_radius_mm >= 0, "corner radii too");
    expect(tool.corner_radius_mm <= tool.diameter_mm / 2 * (1 + 1e-12), "a corner radius fits the tool");
    expect(std::isfinite(tool.length_mm), "lengths are finite");
}

}  // namespace

void take_setup_file(std::string_view bytes) {
    const auto setup = files::read_setup(bytes, "fuzz");
    if (!setup) return expect_sound(setup.error(), bytes);
    expect_sound(setup->workpiece);
    expect_sound(setup->tool);
    for (const auto& [name, tool] : setup->tools) expect_sound(tool);
    for (const auto& [name, frame] : setup->offsets) expect_sound(frame);
    for (const auto* places : {&setup->start, &setup->home})
        for (const auto& [letter, place] : *places) expect(std::isfinite(place), "places of axes are finite");
}

}  // namespace trunnion::fuzz
