#include "detail/polyline.hpp"

#include <algorithm>
#include <cmath>

#include "detail/turn.hpp"

namespace trunnion::smoothing {

namespace {

struct Builder {
    const path::Run& run;
    double turn_rad;
    Polyline& line;

    void add_vertex(const Coordinates& at, std::int32_t programmed) {
        line.vertex.push_back(at);
        line.lever.push_back(lever_at(run, at));
        line.programmed.push_back(programmed);
    }

    void add_block(const Coordinates& to, double length_mm, std::int32_t programmed) {
        const Coordinates from = line.vertex.back();
        line.gap_mm.push_back(length_mm);
        line.slope.emplace_back((to - from) / length_mm);
        add_vertex(to, programmed);
    }

    void add_turning_block(const Coordinates& to, double length_mm, std::int32_t programmed) {
        const Coordinates from = line.vertex.back();
        const auto turn = turn_between(from.tail<3>(), to.tail<3>());
        const int parts = std::max(1, static_cast<int>(std::ceil(turn.angle_rad() / turn_rad)));
        const double step = turn.angle_rad() / parts;
        line.largest_turn_rad = std::max(line.largest_turn_rad, step);
        for (int k = 1; k < parts; ++k) {
            Coordinates between = from + (to - from) * (static_cast<double>(k) / parts);
            between.tail<3>() = turn.at(static_cast<double>(k) / parts);
            add_block(between, length_mm / parts, -1);
        }
        add_block(to, length_mm / parts, programmed);
    }
};

}  // namespace

double lever_at(const path::Run& run, const Coordinates& at) {
    if (has_vectors(run) || !run.kinematics) return 1;
    return run.kinematics->lever({at[3], at[4]});
}

int lever_axis(const path::Run& run) {
    if (has_vectors(run) || !run.kinematics || run.kinematics->rotary_count() < 2) return -1;
    return 3 + run.kinematics->rotary_nearest_workpiece();
}

Polyline make_polyline(const path::Run& run, VertexRange range, double turn_rad) {
    Polyline line;
    Builder builder{run, turn_rad, line};
    const bool vectors = has_vectors(run);
    builder.add_vertex(joined(run.vertices[range.first]), static_cast<std::int32_t>(range.first));
    for (std::size_t i = range.first; i < range.last; ++i) {
        const double length = run.blocks[i].length_mm;
        const Coordinates to = joined(run.vertices[i + 1]);
        const auto programmed = static_cast<std::int32_t>(i + 1);
        if (vectors) {
            builder.add_turning_block(to, length, programmed);
        } else {
            builder.add_block(to, length, programmed);
        }
    }
    return line;
}

}  // namespace trunnion::smoothing
