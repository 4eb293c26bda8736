#include "trunnion/pipeline/surface_faces.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <string>
#include <utility>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "trunnion/files/surface_file.hpp"
#include "trunnion/surfacing/read_faces.hpp"

namespace trunnion::pipeline {

using Eigen::Vector2d;
using Eigen::Vector3d;
using geometry::SurfacePlace;
using surfacing::Face;
using surfacing::FaceList;

namespace {

constexpr int grid = 40;  ///< places each way

bool is_toml(const std::filesystem::path& file) {
    std::string ending = file.extension().string();
    std::ranges::transform(ending, ending.begin(), [](unsigned char c) { return std::tolower(c); });
    return ending == ".toml";
}

Result<FaceList> read_described(const std::filesystem::path& file) {
    auto surfaces = files::read_surface_file(file);
    if (!surfaces) return fail(surfaces.error());
    FaceList out{.unit = "mm"};
    for (auto& [surface, side] : *surfaces) {
        out.faces.push_back(surfacing::whole_face(std::move(surface), side));
        out.faces.back().number = ++out.faces_in_file;
    }
    return out;
}

/// Places in the middle of equal cells of the box of (u, v).
class Grid {
  public:
    explicit Grid(const Face& face) : box_(parameter_box(face)), step_((box_.high - box_.low) / grid) {}

    SurfacePlace place(int i, int j) const {
        return {box_.low.x() + (i + 0.5) * step_.x(), box_.low.y() + (j + 0.5) * step_.y()};
    }
    SurfacePlace share(double a, double b) const {
        return {std::lerp(box_.low.x(), box_.high.x(), a), std::lerp(box_.low.y(), box_.high.y(), b)};
    }
    double cell() const { return step_.x() * step_.y(); }

  private:
    surfacing::ParameterBox box_;
    Vector2d step_;
};

double length_mm(const Face& face, const Grid& places, bool along_u) {
    double sum = 0;
    const auto at = [&](int k) {
        const double w = static_cast<double>(k) / grid;
        const SurfacePlace place = along_u ? places.share(w, 0.5) : places.share(0.5, w);
        return face.surface.at(place.u, place.v);
    };
    for (int k = 0; k < grid; ++k) sum += (at(k + 1) - at(k)).norm();
    return sum;
}

void widen(FaceFacts& facts, const Vector3d& point) {
    facts.low_mm = facts.low_mm.cwiseMin(point);
    facts.high_mm = facts.high_mm.cwiseMax(point);
}

void take(FaceFacts& facts, const geometry::SurfaceShape& shape, double cell) {
    widen(facts, shape.point);
    facts.area_mm2 += cell * shape.by_u.cross(shape.by_v).norm();
    facts.has_normals = true;
    constexpr double flat = 1e-9;  // 1/mm: as good as a plane
    const auto [larger, smaller, direction] = geometry::principal_curvatures(shape.shape);
    if (larger > flat) facts.hump_radius_mm = std::min(facts.hump_radius_mm, 1 / larger);
    if (smaller < -flat) facts.hollow_radius_mm = std::min(facts.hollow_radius_mm, -1 / smaller);
}

bool is_whole(const Face& face) {
    const auto& u = face.surface.u();
    const auto& v = face.surface.v();
    const auto at_border = [&](const Vector2d& p) {
        return p.x() == u.begin() || p.x() == u.end() || p.y() == v.begin() || p.y() == v.end();
    };
    return face.loops.size() == 1 && std::ranges::all_of(face.loops.front(), at_border);
}

std::string numbers_text(const FaceList& list) {
    constexpr std::size_t most = 12;
    std::string out;
    for (std::size_t i = 0; i < std::min(most, list.faces.size()); ++i)
        out += fmt::format("{}{}", i == 0 ? "" : ", ", list.faces[i].number);
    return list.faces.size() > most ? fmt::format("{}, … {}", out, list.faces.back().number) : out;
}

}  // namespace

Result<FaceList> read_surface_faces(const std::filesystem::path& file) {
    return is_toml(file) ? read_described(file) : surfacing::read_faces(file.string());
}

Result<std::vector<Face>> choose_faces(const FaceList& list, std::span<const int> numbers) {
    std::vector<Face> out;
    for (std::size_t i = 0; i < numbers.size(); ++i) {
        const auto face = std::ranges::find(list.faces, numbers[i], &Face::number);
        const bool twice = std::ranges::count(numbers.first(i), numbers[i]) > 0;
        if (face == list.faces.end() || twice)
            return fail({.code = "PIPE0110",
                         .text = twice ? "a face is asked for twice" : "the file has no such face",
                         .value = fmt::format("{}", numbers[i]),
                         .hint = "its faces: " + numbers_text(list)});
        out.push_back(*face);
    }
    if (numbers.empty() && list.faces.size() > 1)
        return fail({.code = "PIPE0111",
                     .text = fmt::format("the file has {} faces, and none is asked for", list.faces.size()),
                     .hint = "--face 3,5 or --face all; trunnion surface list shows them"});
    if (numbers.empty()) out.push_back(list.faces.front());
    return out;
}

FaceFacts facts_of(const Face& face) {
    const Grid places(face);
    FaceFacts out{.number = face.number,
                  .along_u_mm = length_mm(face, places, true),
                  .along_v_mm = length_mm(face, places, false),
                  .low_mm = Vector3d::Constant(HUGE_VAL),
                  .high_mm = Vector3d::Constant(-HUGE_VAL),
                  .whole = is_whole(face)};
    for (const auto& loop : face.loops)
        for (const Vector2d& p : loop) widen(out, face.surface.at(p.x(), p.y()));
    for (int i = 0; i < grid; ++i)
        for (int j = 0; j < grid; ++j) {
            const SurfacePlace place = places.place(i, j);
            if (!contains(face, place)) continue;
            if (const auto shape = shape_at(face.surface, place, face.side)) take(out, *shape, places.cell());
        }
    return out;
}

}  // namespace trunnion::pipeline
