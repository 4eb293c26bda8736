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

/// By how much a derivative may at most be, by p, for the kernel to displace position and orientation by no more than
/// the division says: that share of both.
double share_of(const Division& division, const Coordinates& derivative) {
    return std::max(derivative.head<3>().norm() / division.chord_mm, derivative.tail<3>().norm() / division.bend_rad);
}

/// Width of the curve kernel that displaces a curve by a division's chord error: by its fourth derivative as above.
double widest_on(const Coordinates& fourth, const Division& division) {
    return std::pow(24 / CurveKernel::fourth_moment / share_of(division, fourth), 0.25);
}

/// The same where its third derivative jumps: w³·|∫₀¹ t·g(t) dt|·|jump|.
double widest_at(const Coordinates& jump_of_third, const Division& division) {
    constexpr double by_jump = 0.00228;
    return std::cbrt(1 / (by_jump * share_of(division, jump_of_third)));
}

/// Along a curve as chords: at equal shares of the curve's parameter.
struct CurveChords {
    int parts = 1;
    double off_mm = 0, bend_rad = 0;  ///< from the chords
    double turn_rad = 0;              ///< of a vector within one part

    CurveChords(const path::CurvePiece& curve, bool vectors, int into) : parts(into) {
        const double count = into;
        for (int k = 0; k < into; ++k) {
            const double from = k / count, to = (k + 1) / count;
            off_mm = std::max(off_mm, curve.position.part(from, to).chord_error());
            if (!curve.orientation) continue;
            const geometry::BezierPiece orientation = curve.orientation->part(from, to);
            bend_rad = std::max(bend_rad, vectors ? orientation.chord_turn() : orientation.chord_error());
            if (vectors) turn_rad = std::max(turn_rad, orientation.polygon_turn());
        }
    }

    /// By which the number of parts is too small: errors fall with its square, turns with itself.
    double lacks(const Division& division) const {
        const double errors = std::max(off_mm / division.chord_mm, bend_rad / division.bend_rad);
        return std::max(std::sqrt(errors), turn_rad / division.turn_rad);
    }
};

CurveChords chords_of(const path::CurvePiece& curve, bool vectors, int least_parts, const Division& division) {
    constexpr int most_rounds = 12;
    constexpr double most_growth = 8, margin = 1.01;
    CurveChords out(curve, vectors, least_parts);
    for (int round = 0; round < most_rounds; ++round) {
        const double lacks = out.lacks(division);
        if (lacks <= 1) break;
        out =
            CurveChords(curve, vectors, static_cast<int>(std::ceil(out.parts * std::min(margin * lacks, most_growth))));
    }
    return out;
}

class Builder {
  public:
    Builder(const path::Run& run, const Division& division, Polyline& line)
        : run_(run), division_(division), line_(line) {}

    void add_vertex(const Coordinates& at, std::int32_t programmed, double widest_mm) {
        line_.vertex.push_back(at);
        line_.widest_mm.push_back(widest_mm);
        line_.lever.push_back(lever_at(run_, at));
        line_.programmed.push_back(programmed);
        ends_.push_back(programmed >= 0);
    }

    void add_part(const Coordinates& to, double length_mm, std::int32_t programmed, double widest_mm = any_width) {
        const Coordinates from = line_.vertex.back();
        line_.gap_mm.push_back(length_mm);
        line_.slope.emplace_back((to - from) / length_mm);
        add_vertex(to, programmed, widest_mm);
    }

    void add_block(std::size_t block) {
        const ProgrammedBlock whole(run_, block);
        if (whole.curve()) return add_curve(block, whole);
        int parts = 1;
        if (has_vectors(run_)) {
            parts = std::max(parts, static_cast<int>(std::ceil(whole.turn_rad() / division_.turn_rad)));
        }
        if (whole.arc()) {
            parts = std::max(parts, arc_parts(*whole.arc(), division_.chord_mm));
            line_.chord_error_mm = std::max(line_.chord_error_mm, whole.arc()->chord_error(parts));
        }
        line_.largest_turn_rad = std::max(line_.largest_turn_rad, whole.turn_rad() / parts);
        const double length = whole.length_mm() / parts;
        const double widest = whole.arc() ? widest_on(*whole.arc(), division_.chord_mm) : any_width;
        for (int k = 1; k < parts; ++k) add_part(whole.place(static_cast<double>(k) / parts), length, -1, widest);
        add_part(joined(run_.vertices[block + 1]), length, static_cast<std::int32_t>(block + 1));
    }

    /// Lengths of the chords are in proportion to their own, so that the path goes at an even pace.
    void add_curve(std::size_t block, const ProgrammedBlock& whole) {
        const auto by_turn = static_cast<int>(std::ceil(whole.turn_rad() / division_.turn_rad));
        const CurveChords chords =
            chords_of(whole.curve()->curve(), has_vectors(run_), std::max(1, by_turn), division_);
        line_.chord_error_mm = std::max(line_.chord_error_mm, chords.off_mm);
        line_.chord_turn_rad = std::max(line_.chord_turn_rad, chords.bend_rad);
        line_.largest_turn_rad = std::max(line_.largest_turn_rad, whole.turn_rad() / chords.parts);
        std::vector<HermiteEnd> station;
        std::vector<double> length;
        double sum = 0;
        for (int k = 0; k <= chords.parts; ++k) {
            station.push_back(whole.at(static_cast<double>(k) / chords.parts));
            if (k == 0) continue;
            length.push_back(path::block_length_mm(run_, apart(station.end()[-2].value), apart(station.back().value)));
            sum += length.back();
        }
        for (double& part : length) part *= whole.length_mm() / sum;
        join_to(block, station.front());
        for (std::size_t k = 1; k < station.size(); ++k) {
            const bool last = k + 1 == station.size();
            const Coordinates& third = station[last ? k : k + 1].third;
            const double way = length[k - 1] + (last ? 0 : length[k]);
            add_part(last ? joined(run_.vertices[block + 1]) : station[k].value, length[k - 1],
                     last ? static_cast<std::int32_t>(block + 1) : -1,
                     widest_on((third - station[k - 1].third) / way, division_));
        }
        third_at_end_ = station.back().third;
    }

    /// Where a curve goes on with the same tangent and curvature it has no end.
    void join_to(std::size_t block, const HermiteEnd& begin) {
        if (line_.gap_mm.empty() || !curve_goes_on(run_, block)) return;
        ends_.back() = 0;
        line_.widest_mm.back() = std::min(line_.widest_mm.back(), widest_at(begin.third - third_at_end_, division_));
    }

    /// Beside its ends an arc or curve is rounded like anything else.
    void free_ends() {
        const std::size_t count = line_.vertex.size();
        std::vector<double> from_end(count, 0);
        for (std::size_t k = 1; k < count; ++k) from_end[k] = ends_[k] ? 0 : from_end[k - 1] + line_.gap_mm[k - 1];
        double to_end = 0;
        for (std::size_t k = count; k-- > 0;) {
            to_end = ends_[k] || k + 1 == count ? 0 : to_end + line_.gap_mm[k];
            if (!(std::min(from_end[k], to_end) > line_.widest_mm[k])) line_.widest_mm[k] = any_width;
        }
    }

  private:
    static path::PathCoordinates apart(const Coordinates& at) { return {{at[0], at[1], at[2]}, {at[3], at[4], at[5]}}; }

    const path::Run& run_;
    Division division_;
    Polyline& line_;
    std::vector<char> ends_;  // at every vertex: an arc or curve ends_ there, or does not go on as before
    Coordinates third_at_end_ = Coordinates::Zero();
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
    Builder builder(run, division, line);
    builder.add_vertex(joined(run.vertices[range.first]), static_cast<std::int32_t>(range.first), any_width);
    for (std::size_t i = range.first; i < range.last; ++i) builder.add_block(i);
    builder.free_ends();
    return line;
}

}  // namespace trunnion::smoothing
