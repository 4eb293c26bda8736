#pragma once

#include <fstream>
#include <memory>
#include <string>

#include <nlohmann/json.hpp>

#include "trunnion/geometry/bspline_curve.hpp"

#include "synthetic_paths.hpp"

namespace trunnion::test {

/// The published flank-milling path (dual cubic B-spline, chain C A X Y Z, limits of its file, no programmed feed);
/// nullptr where the shared data are absent. p is 100 times the spline's parameter.
inline std::unique_ptr<Stretch> flank_path(double jerk_factor = 1) {
    std::ifstream file(TRUNNION_SHARED_DIR "/data/published/flank-2012.json");
    if (!file) return nullptr;
    const auto data = nlohmann::json::parse(file);
    std::array<machine::AxisLimits, 5> limits;
    const char* names[] = {"X", "Y", "Z", "A", "C"};
    for (int i = 0; i < 5; ++i) {
        const auto& of = data["limits"][names[i]];
        const std::string unit = i < 3 ? "mm" : "rad";
        limits[i] = {of["v_" + unit + "_s"], of["a_" + unit + "_s2"],
                     of["j_" + unit + "_s3"].get<double>() * jerk_factor};
    }
    const auto curve = [&](const char* key) {
        std::vector<Eigen::Vector3d> points;
        for (const auto& p : data[key]) points.emplace_back(p[0], p[1], p[2]);
        return geometry::BsplineCurve::make(data["degree"], data["knots"], points)->pieces();
    };
    const auto bottom = curve("bottom_mm"), top = curve("top_mm");
    auto out = std::make_unique<Stretch>();
    out->machine = five_axis_machine(limits);
    for (std::size_t k = 0; k < bottom.size(); ++k) {
        path::PathPiece piece;
        piece.begin_mm = 100 * bottom[k].u_begin;
        piece.length_mm = 100 * (bottom[k].u_end - bottom[k].u_begin);
        for (int c = 0; c < 3; ++c)
            for (int i = 0; i <= bottom[k].degree; ++i) {
                piece.coefficient[c][i] = bottom[k].coefficients_mm[i][c];
                piece.coefficient[3 + c][i] = top[k].coefficients_mm[i][c] - bottom[k].coefficients_mm[i][c];
            }
        out->tool_path.pieces.push_back(piece);
    }
    out->tool_path.blocks.push_back({0, 100, {}, 1, 100});
    out->close();
    return out;
}

}  // namespace trunnion::test
