// Neighbouring passes over a surface: programs of rows beside each other, cut to and fro, must come out alike.
#include <algorithm>
#include <string>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "trunnion/base/quantity.hpp"

#include "planned.hpp"
#include "surface_curve.hpp"

namespace trunnion::test {
namespace {

using path::OrientationLaw;

constexpr int rows = 5;
constexpr double row_distance_mm = 0.2, grid_mm = 0.05, looked_at_mm = 39.95;

/// Where a pass is at an x, away from the surface's own place there.
struct Departure {
    double x_mm = 0;
    Eigen::Vector3d tip_mm, axis;
};

struct Pass {
    std::vector<Departure> departures;  // x on the grid
    std::vector<double> tip_speed_mm_s;
};

Eigen::Vector3d tool_axis(OrientationLaw law, const std::array<double, 3>& orientation) {
    if (law == OrientationLaw::rotary)
        return table_kinematics().tool_axis(machine::RotaryPosition{orientation[0], orientation[1]});
    return Eigen::Vector3d(orientation.data()).normalized();
}

Departure departure(const Curve& row, OrientationLaw law, const std::array<Taylor3, 6>& q) {
    const Place exact = row.at(q[0].value());
    Departure out;
    out.x_mm = q[0].value();
    const Eigen::Vector3d axis = tool_axis(law, {q[3].value(), q[4].value(), q[5].value()});
    for (int k = 0; k < 3; ++k) {
        out.tip_mm[k] = q[k].value() - exact.tip[k].value();
        out.axis[k] = axis[k] - exact.axis[k].value();
    }
    return out;
}

/// `sequence` in rising x, at an x: what to take of the element after and which it is.
template <class T, class X>
std::pair<std::size_t, double> between(const std::vector<T>& sequence, double x, X x_of) {
    const auto after = std::lower_bound(sequence.begin() + 1, sequence.end() - 1, x,
                                        [&](const T& element, double value) { return x_of(element) < value; });
    const double from = x_of(*(after - 1)), to = x_of(*after);
    return {static_cast<std::size_t>(after - sequence.begin()), (x - from) / (to - from)};
}

std::vector<Departure> departures(const Curve& row, const path::ToolPath& path) {
    constexpr int looks = 20;  // a piece
    std::vector<Departure> all;
    for (const path::PathPiece& piece : path.pieces)
        for (int k = 0; k < looks; ++k)
            all.push_back(departure(row, path.law, path::evaluate(piece, piece.length_mm * k / looks)));
    all.push_back(departure(row, path.law, path::evaluate(path.pieces.back(), path.pieces.back().length_mm)));
    if (all.front().x_mm > all.back().x_mm) std::reverse(all.begin(), all.end());
    std::vector<Departure> on_grid;
    for (double x = -looked_at_mm; x <= looked_at_mm; x += grid_mm) {
        const auto [i, part] = between(all, x, [](const Departure& d) { return d.x_mm; });
        on_grid.push_back({x, all[i - 1].tip_mm + part * (all[i].tip_mm - all[i - 1].tip_mm),
                           all[i - 1].axis + part * (all[i].axis - all[i - 1].axis)});
    }
    return on_grid;
}

std::vector<double> tip_speeds(const Planned& planned) {
    std::vector<Planned::State> states = planned.walked(2e-4);
    if (states.front().tip_mm.x() > states.back().tip_mm.x()) std::reverse(states.begin(), states.end());
    std::vector<double> speeds;
    for (double x = -looked_at_mm; x <= looked_at_mm; x += grid_mm) {
        const auto [i, part] = between(states, x, [](const Planned::State& s) { return s.tip_mm.x(); });
        const double from = states[i - 1].tip_speed_mm_s, to = states[i].tip_speed_mm_s;
        speeds.push_back(from + part * (to - from));
    }
    return speeds;
}

Curve pass_curve(int k, double lean_rad) {
    const Curve row = sine_row(-20 + row_distance_mm * k, lean_rad);
    return k % 2 ? backwards(row) : row;
}

Pass made(const Curve& row, const Planned& planned) {
    return {departures(row, planned.path()), tip_speeds(planned)};
}

/// How much more two neighbours differ than the surface under them.
struct Extra {
    double tip_mm = 0, turn_rad = 0;
};

struct Difference {
    Extra inside, near_ends;    // farther than 12 mm from where the run begins and ends, and nearer
    std::vector<double> speed;  // by what share tip speeds differ, at all places, sorted
    double median_speed() const { return speed[speed.size() / 2]; }
    double largest_speed() const { return speed.back(); }
};

void compare(const Pass& a, const Pass& b, Difference& out) {
    constexpr double ends_mm = 28, starts_mm = 39;
    for (std::size_t i = 0; i < a.departures.size(); ++i) {
        const Departure &one = a.departures[i], &other = b.departures[i];
        Extra& extra = std::abs(one.x_mm) < ends_mm ? out.inside : out.near_ends;
        extra.tip_mm = std::max(extra.tip_mm, (one.tip_mm - other.tip_mm).norm());
        extra.turn_rad = std::max(extra.turn_rad, (one.axis - other.axis).norm());
        if (std::abs(one.x_mm) < starts_mm)
            out.speed.push_back(std::abs(a.tip_speed_mm_s[i] / b.tip_speed_mm_s[i] - 1));
    }
}

Difference differences(const std::vector<Pass>& passes) {
    Difference out;
    for (std::size_t k = 0; k + 1 < passes.size(); ++k) compare(passes[k], passes[k + 1], out);
    std::sort(out.speed.begin(), out.speed.end());
    return out;
}

void print(const char* name, const Difference& d) {
    fmt::print(
        "{:<16} tip {:.3f}, at ends {:.3f} um; axis {:.3f}, at ends {:.3f} mdeg; speed median {:.3f}, largest {:.2f} "
        "%\n",
        name, 1e3 * d.inside.tip_mm, 1e3 * d.near_ends.tip_mm, 1e3 * d.inside.turn_rad / degree,
        1e3 * d.near_ends.turn_rad / degree, 100 * d.median_speed(), 100 * d.largest_speed());
}

/// 1 µm at 30 mm. Near the pole, where C is smoothed by itself and sways by some hundredths of a degree, neighbours
/// differ by more.
Extra most_extra(OrientationLaw law, double lean_deg, bool near_ends, Digits digits) {
    const bool near_pole = law == OrientationLaw::rotary && lean_deg == 0;
    const double turn_deg = near_pole ? (near_ends ? 15e-3 : 5e-3) : 1.9e-3;
    if (!near_ends) return {0.5e-3, turn_deg * degree};
    return {digits == Digits::some ? 1e-3 : 0.1e-3, turn_deg * degree};  // first and last pose are kept, as rounded
}

class Rows : public testing::TestWithParam<std::tuple<OrientationLaw, double>> {};

TEST_P(Rows, BesideEachOtherAreSmoothedAlike) {
    const auto [law, lean_deg] = GetParam();
    const double lean_rad = lean_deg * degree;
    std::vector<Pass> exact;
    for (int k = 0; k < rows; ++k)
        exact.push_back(
            made(pass_curve(k, lean_rad), Planned(exact_path(pass_curve(k, lean_rad), law, table_kinematics()))));
    const Difference surface = differences(exact);
    print("surface", surface);
    const struct {
        const char* name;
        Posed how;
    } programs[] = {{"clean", {.step_mm = 0.2}},
                    {"doubled", {.step_mm = 0.2, .doubled = true}},
                    {"digits", {.step_mm = 0.2, .digits = Digits::some, .doubled = true}},
                    {"digits, uneven", {.step_mm = 0.2, .digits = Digits::some, .uneven = true, .doubled = true}},
                    {"0.1 mm", {.step_mm = 0.1, .digits = Digits::some}},
                    {"0.1 mm, uneven", {.step_mm = 0.1, .digits = Digits::some, .uneven = true}}};
    for (const auto& program : programs) {
        std::vector<Pass> passes;
        for (int k = 0; k < rows; ++k) {
            Posed how = program.how;
            how.seed = 1 + static_cast<std::uint64_t>(k);
            const Curve row = pass_curve(k, lean_rad);
            passes.push_back(made(row, Planned(smoothed_to_one(posed(row, how, law, table_kinematics())))));
        }
        const Difference d = differences(passes);
        print(program.name, d);
        for (const bool near_ends : {false, true}) {
            const Extra most = most_extra(law, lean_deg, near_ends, program.how.digits);
            const Extra& is = near_ends ? d.near_ends : d.inside;
            EXPECT_LE(is.tip_mm, most.tip_mm) << program.name << (near_ends ? ", near ends" : "");
            EXPECT_LE(is.turn_rad, most.turn_rad) << program.name << (near_ends ? ", near ends" : "");
        }
        EXPECT_LE(d.median_speed(), surface.median_speed() + 1e-3) << program.name;
        EXPECT_LE(d.largest_speed(), surface.largest_speed() + 6e-3) << program.name;
    }
}

INSTANTIATE_TEST_SUITE_P(By, Rows,
                         testing::Combine(testing::Values(OrientationLaw::vector, OrientationLaw::rotary),
                                          testing::Values(0.0, 25.0)),
                         [](const auto& which) {
                             const bool vectors = std::get<0>(which.param) == OrientationLaw::vector;
                             return fmt::format("{}_leaning_{}", vectors ? "vectors" : "words",
                                                std::get<1>(which.param));
                         });

}  // namespace
}  // namespace trunnion::test
