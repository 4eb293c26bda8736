#include "surface_part.hpp"

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <string_view>
#include <system_error>
#include <tuple>
#include <utility>

#include "trunnion/base/quantity.hpp"
#include "trunnion/pipeline/surface_faces.hpp"

namespace trunnion::app {

using surfacing::Face;

namespace {

/// FILE:3,5, FILE:all or FILE.
struct PartName {
    std::string file, faces = "all";
};

PartName split(const std::string& text) {
    const std::size_t colon = text.rfind(':');
    if (colon == std::string::npos || colon == 0) return {.file = text};
    const std::string behind = text.substr(colon + 1);
    const bool numbers = behind == "all" || behind.find_first_not_of("0123456789,") == std::string::npos;
    return numbers ? PartName{text.substr(0, colon), behind} : PartName{.file = text};
}

bool is_same(const std::string& a, const std::string& b) {
    std::error_code none;
    return std::filesystem::equivalent(a, b, none);
}

/// Those of the surface's own file without those that are machined.
std::vector<Face> others_of(const std::vector<Face>& part, const std::vector<Face>& machined) {
    std::vector<Face> out;
    std::ranges::copy_if(part, std::back_inserter(out), [&](const Face& face) {
        return std::ranges::find(machined, face.number, &Face::number) == machined.end();
    });
    return out;
}

Result<std::vector<Face>> faces_of(const PartName& name, const surfacing::FaceList& list) {
    const auto numbers = face_numbers("--part", name.faces, list);
    if (!numbers) return fail(numbers.error());
    return pipeline::choose_faces(list, *numbers);
}

Result<surfacing::Holder> holder_of(const std::string& text) {
    if (text.empty()) return surfacing::Holder{};
    const Diagnostic none{.code = "PIPE0117",
                          .text = "--holder says no holder",
                          .value = text,
                          .hint =
                              "--holder \"50mm 40mm 120mm\": its diameter, and from where to where it goes up the "
                              "axis from the tool's tip"};
    const auto sizes = quantities_in(text);
    if (sizes.size() != 3) return fail(none);
    double mm[3];
    for (std::size_t i = 0; i < sizes.size(); ++i) {
        auto size = parse_quantity(sizes[i], dimension::length);
        if (!size) return fail(in_option("--holder", std::move(size.error())));
        mm[i] = *size;
    }
    if (!(mm[0] > 0 && mm[1] >= 0 && mm[2] > mm[1])) return fail(none);
    return surfacing::Holder{.radius_mm = mm[0] / 2, .from_mm = mm[1], .to_mm = mm[2]};
}

}  // namespace

void SurfacePartText::add_to(CLI::App& command) {
    command.add_option("--part", part,
                       "faces that the tool must not go into, beside those that are machined: FILE, FILE:3,5, or file: "
                       "all of the surface's file, which is the default");
    command.add_option("--holder", holder,
                       "\"50mm 40mm 120mm\": diameter, and from where to where up the axis from the tool's tip");
    CLI::Option* free = command.add_flag(
        "--free-gouges", free_gouges,
        "leans the tool out of what it goes into; then simulates as --check, as ridges change with the lean");
    command
        .add_flag("--leave-out", leave_out,
                  "leaves out what the tool cannot reach without going into the part, and says how much of the faces "
                  "that is; then simulates as --check")
        ->excludes(free);
    command
        .add_option("--least-lead", least_lead,
                    "of --free-gouges; default: -60deg; the lead of a tool that is no ball keeps its sign")
        ->needs(free);
    command.add_option("--most-lead", most_lead, "of --free-gouges")->capture_default_str()->needs(free);
    command.add_option("--most-tilt", most_tilt, "of --free-gouges, to either side")
        ->capture_default_str()
        ->needs(free);
}

std::vector<Face> SurfacePart::with(const std::vector<Face>& machined) const {
    std::vector<Face> out = machined;
    out.insert(out.end(), others.begin(), others.end());
    return out;
}

Result<SurfacePart> read_part(const SurfacePartText& text, const SurfaceText& surface, const SurfaceWork& work) {
    const auto holder = holder_of(text.holder);
    if (!holder) return fail(holder.error());
    SurfacePart out{.holder = *holder};
    const PartName name = split(text.part);
    const bool own = text.part.empty() || name.file == "file" || is_same(name.file, surface.file);
    auto list = own ? Result<surfacing::FaceList>(work.list) : pipeline::read_surface_faces(name.file);
    if (!list) return fail(list.error());
    auto faces = faces_of(name, *list);
    if (!faces) return fail(faces.error());
    out.others = own ? others_of(*faces, work.faces) : std::move(*faces);
    if (own) return out;
    out.file = name.file;
    out.told = std::move(list->diagnostics);
    return out;
}

Result<surfacing::OrientationLimits> lean_limits(const SurfacePartText& text, const SurfaceWork& work) {
    surfacing::OrientationLimits out = pipeline::lean_limits(work.cutter, work.options.lead_rad);
    const std::tuple<double*, const char*, const std::string*> angles[] = {
        {&out.least_lead_rad, "--least-lead", &text.least_lead},
        {&out.most_lead_rad, "--most-lead", &text.most_lead},
        {&out.most_tilt_rad, "--most-tilt", &text.most_tilt}};
    for (const auto& [target, option, written] : angles) {
        if (written->empty()) continue;
        auto angle = parse_quantity(*written, dimension::angle);
        if (!angle) return fail(in_option(option, std::move(angle.error())));
        *target = *angle;
    }
    return out;
}

}  // namespace trunnion::app
