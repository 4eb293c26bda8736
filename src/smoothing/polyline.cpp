#include "detail/polyline.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "trunnion/smoothing/kernel.hpp"

#include "detail/programmed_block.hpp"

namespace trunnion::smoothing {

namespace {

constexpr double any_width = std::numeric_limits<double>::infinity();

/// Parts into which an arc of radius r and angle φ is cut for a chord error e: r(1 − cos(φ/2n)) ≤ rφ²/8n² ≤ e.
int arc_parts(const geometry::Helix& helix, double chord_mm) {
    const double radius = std::max(helix.radius_at_start(), helix.radius_at_end());
    return std::max(1, static_cast<int>(std::ceil(std::abs(helix.angle_rad()) * std::sqrt(radius / (8 * chord_mm)))));
}

/// Width of the curve kernel that displaces a circle of this radius by `shrink_mm`: w⁴·|m₄|/(24 r³), m₄ the kernel's
/// fourth moment.
double widest_on(const geometry::Helix& helix, double shrink_mm) {
    const double radius = std::min(helix.radius_at_start(), helix.radius_at_end());
    return std::pow(24 / CurveKernel::fourth_moment * shrink_mm * radius * radius * radius, 0.25);
}

struct Builder {
    const path::Run& run;
    Division division;
    Polyline& line;

    void add_vertex(const Coordinates& at, std::int32_t programmed, double widest_mm) {
        line.vertex.push_back(at);
        line.widest_mm.push_back(widest_mm);
        line.lever.push_back(lever_at(run, at));
        line.programmed.push_back(programmed);
    }

    void add_part(const Coordinates& to, double length_mm, std::int32_t programmed, double widest_mm = any_width) {
        const Coordinates from = line.vertex.back();
        line.gap_mm.push_back(length_mm);
        line.slope.emplace_back((to - from) / length_mm);
        add_vertex(to, programmed, widest_mm);
    }

    void add_block(std::size_t block) {
        const ProgrammedBlock whole(run, block);
        int parts = 1;
        if (has_vectors(run)) {
            parts = std::max(parts, static_cast<int>(std::ceil(whole.turn_rad() / division.turn_rad)));
        }
        if (whole.arc()) {
            parts = std::max(parts, arc_parts(*whole.arc(), division.chord_mm));
            line.chord_error_mm = std::max(line.chord_error_mm, whole.arc()->chord_error(parts));
        }
        line.largest_turn_rad = std::max(line.largest_turn_rad, whole.turn_rad() / parts);
        const double length = whole.length_mm() / parts;
        const double widest = whole.arc() ? widest_on(*whole.arc(), division.chord_mm) : any_width;
        for (int k = 1; k < parts; ++k) {
            const bool inside = std::min(k, parts - k) * length > widest;
            add_part(whole.place(static_cast<double>(k) / parts), length, -1, inside ? widest : any_width);
        }
        add_part(joined(run.vertices[block + 1]), length, static_cast<std::int32_t>(block + 1));
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

Polyline make_polyline(const path::Run& run, VertexRange range, Division division) {
    Polyline line;
    Builder builder{run, division, line};
    builder.add_vertex(joined(run.vertices[range.first]), static_cast<std::int32_t>(range.first), any_width);
    for (std::size_t i = range.first; i < range.last; ++i) builder.add_block(i);
    return line;
}

}  // namespace trunnion::smoothing
