// What smoothing costs in time: programs of a curve against the curve itself, planned by the same planner.
// TRUNNION_SEED sets the first seed of uneven spacing, TRUNNION_RUNS how many.
#include <cstdlib>
#include <string>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "trunnion/base/quantity.hpp"

#include "planned.hpp"
#include "surface_curve.hpp"

namespace trunnion::test {
namespace {

using path::OrientationLaw;

struct Given {
    std::string name;
    Curve curve;
    OrientationLaw law;
    friend void PrintTo(const Given& g, std::ostream* out) { *out << g.name; }
};

double exact_s(const Given& given) {
    return Planned(exact_path(given.curve, given.law, table_kinematics())).duration_s();
}

double program_s(const Given& given, const Posed& how) {
    return Planned(smoothed_to_one(posed(given.curve, how, given.law, table_kinematics()))).duration_s();
}

std::uint64_t environment(const char* name, std::uint64_t otherwise) {
    const char* text = std::getenv(name);
    return text ? std::strtoull(text, nullptr, 10) : otherwise;
}

struct Uneven {
    std::uint64_t seed = 0;
    double ratio = 0;
};

/// The slowest of programs whose spacing is drawn.
Uneven slowest_uneven(const Given& given, Posed how, std::uint64_t count) {
    const double exact = exact_s(given);
    const std::uint64_t first = environment("TRUNNION_SEED", 1);
    count = environment("TRUNNION_RUNS", count);
    how.uneven = true;
    Uneven slowest;
    for (how.seed = first; how.seed < first + count; ++how.seed) {
        const double ratio = program_s(given, how) / exact;
        if (ratio > slowest.ratio) slowest = {how.seed, ratio};
    }
    fmt::print("{:<28} uneven {} mm{}, seeds {} to {}: at most {:.4f} of the exact time, seed {}\n", given.name,
               how.step_mm, how.digits == Digits::some ? ", digits" : "", first, first + count - 1, slowest.ratio,
               slowest.seed);
    return slowest;
}

class TimeOf : public testing::TestWithParam<Given> {};
class NightlyTimeOf : public TimeOf {};

TEST_P(TimeOf, AProgramIsThatOfItsCurve) {
    const Given& given = GetParam();
    const double exact = exact_s(given);
    const struct {
        const char* name;
        Posed how;
    } programs[] = {{"clean", {}},
                    {"0.2 mm", {.step_mm = 0.2}},
                    {"digits", {.digits = Digits::some}},
                    {"digits, 0.2 mm", {.step_mm = 0.2, .digits = Digits::some}},
                    {"digits, doubled", {.digits = Digits::some, .doubled = true}}};
    for (const auto& program : programs) {
        const double ratio = program_s(given, program.how) / exact;
        fmt::print("{:<28} {:<16} {:.4f} of exact {:.4f} s\n", given.name, program.name, ratio, exact);
        EXPECT_LE(ratio, 1.006) << program.name;
        EXPECT_GE(ratio, 0.99) << program.name << ": another path";
    }
    EXPECT_LE(slowest_uneven(given, {}, 2).ratio, 1.006);
    EXPECT_LE(slowest_uneven(given, {.digits = Digits::some}, 2).ratio, 1.006);
}

TEST_P(NightlyTimeOf, AnUnevenProgramIsThatOfItsCurve) {
    EXPECT_LE(slowest_uneven(GetParam(), {}, 40).ratio, 1.006);
    EXPECT_LE(slowest_uneven(GetParam(), {.digits = Digits::some}, 40).ratio, 1.006);
}

class CoarseTimeOf : public TimeOf {};

TEST_P(CoarseTimeOf, AnUnevenProgramIsNearThatOfItsCurve) {
    EXPECT_LE(slowest_uneven(GetParam(), {.step_mm = 0.2, .digits = Digits::some}, 8).ratio, 1.006);
}

/// Blocks of up to 0.34 mm around radii from 5 mm: longer than the cluster in which kinks count as one corner.
class TightCoarseTimeOf : public TimeOf {};

TEST_P(TightCoarseTimeOf, AnUnevenProgramIsNearThatOfItsCurve) {
    EXPECT_LE(slowest_uneven(GetParam(), {.step_mm = 0.2, .digits = Digits::some}, 8).ratio, 1.006);
}

std::string by(OrientationLaw law) {
    return law == OrientationLaw::vector ? "by_vectors" : "by_words";
}

std::vector<Given> spirals() {
    std::vector<Given> both;
    for (const auto law : {OrientationLaw::vector, OrientationLaw::rotary})
        both.push_back({"spiral_" + by(law), spiral(3), law});
    return both;
}

std::vector<Given> rows() {
    std::vector<Given> all;
    for (const auto law : {OrientationLaw::vector, OrientationLaw::rotary})
        for (const int y : {20, 12, 30}) {
            all.push_back({fmt::format("row_{}_{}", y, by(law)), sine_row(-y), law});
            all.push_back({fmt::format("leaning_row_{}_{}", y, by(law)), sine_row(-y, 25 * degree), law});
        }
    return all;
}

const auto name_of_given = [](const auto& which) { return which.param.name; };
INSTANTIATE_TEST_SUITE_P(Spirals, TimeOf, testing::ValuesIn(spirals()), name_of_given);
INSTANTIATE_TEST_SUITE_P(Rows, TimeOf, testing::ValuesIn(rows()), name_of_given);
INSTANTIATE_TEST_SUITE_P(Rows, CoarseTimeOf, testing::ValuesIn(rows()), name_of_given);
INSTANTIATE_TEST_SUITE_P(Spirals, TightCoarseTimeOf, testing::ValuesIn(spirals()), name_of_given);
INSTANTIATE_TEST_SUITE_P(NightlySpirals, NightlyTimeOf, testing::ValuesIn(spirals()), name_of_given);
INSTANTIATE_TEST_SUITE_P(NightlyRows, NightlyTimeOf, testing::ValuesIn(rows()), name_of_given);

}  // namespace
}  // namespace trunnion::test
