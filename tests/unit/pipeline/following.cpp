// Axes that go along with the path keep their ratio to it where moves are divided or smoothed.
#include "trunnion/nc/following.hpp"

#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "trunnion/base/quantity.hpp"
#include "trunnion/files/machine_file.hpp"
#include "trunnion/nc/read.hpp"
#include "trunnion/nc/write.hpp"
#include "trunnion/pipeline/convert.hpp"
#include "trunnion/pipeline/smooth_program.hpp"

namespace trunnion::pipeline {
namespace {

using program::MoveKind;
using program::OrientationLaw;
using program::Program;

machine::Machine printer() {
    machine::Machine out = *files::read_machine_file(TRUNNION_SOURCE_DIR "/data/machines/xyzac-trt.toml");
    out.words.following = {"E"};
    return out;
}

Program read(std::string_view text, const machine::Machine& machine) {
    nc::ReadOptions options;
    options.machine = &machine;
    auto out = nc::read_program(text, "program", options);
    EXPECT_TRUE(out) << to_string(out.error());
    return std::move(*out);
}

/// A round of radius 20 mm in chords of half a degree, E 0.01 mm each; from `retract` on, standing, E goes back and
/// forth; from `dry` for 100 chords nothing is printed.
std::string rim(int retract, int dry) {
    std::string out = "G21 G90 M83 G0 X20 Y0 Z0 A10 C0\nF3000\n";
    for (int k = 1; k <= 720; ++k) {
        const double angle = k * 0.5 * degree;
        out += fmt::format("G1 X{:.5f} Y{:.5f} A10 C{:.3f}", 20 * std::cos(angle), 20 * std::sin(angle), 0.5 * k);
        out += k >= dry && k < dry + 100 ? "\n" : " E0.01\n";
        if (k == retract) out += "E-1 F1200\nE1\nF3000\n";
    }
    return out;
}

double angle_at(const program::Move& move) {
    const double angle = std::atan2(move.position_mm.y(), move.position_mm.x());
    return angle <= 1e-9 ? angle + 2 * std::numbers::pi : angle;
}

TEST(Following, SmoothedMovesHaveTheirShare) {
    const machine::Machine machine = printer();
    const Program program = read(rim(1000, 1000), machine);
    const auto smoothed = smooth_program(program, machine, {}, {}, SmoothedForm::points);
    ASSERT_TRUE(smoothed) << to_string(smoothed.error());
    const Program& out = smoothed->program;
    ASSERT_LT(out.moves.size(), 300u);
    ASSERT_EQ(out.following.size(), out.moves.size());
    EXPECT_NEAR(out.following.back(), 7.2, 1e-9);
    for (std::size_t k = 1; k < out.moves.size(); ++k)
        EXPECT_NEAR(out.following[k] / 7.2, angle_at(out.moves[k]) / (2 * std::numbers::pi), 2e-4) << k;
}

TEST(Following, RetractionsAndDryPartsStayWhereTheyWere) {
    const machine::Machine machine = printer();
    const Program program = read(rim(200, 500), machine);
    const auto smoothed = smooth_program(program, machine, {}, {}, SmoothedForm::points);
    ASSERT_TRUE(smoothed) << to_string(smoothed.error());
    const Program& out = smoothed->program;
    ASSERT_LT(out.moves.size(), 400u);
    EXPECT_NEAR(out.following.back(), 6.2, 1e-9);
    int standing = 0;
    for (const program::Event& event : out.events) {
        if (event.kind != program::EventKind::dwell) continue;
        ++standing;
        EXPECT_NEAR(angle_at(out.moves[event.before_move - 1]), 100 * degree, 1e-6);
        EXPECT_NEAR(out.following[event.before_move - 1], 2, 1e-9);
    }
    EXPECT_EQ(standing, 2);
    for (std::size_t k = 1; k < out.moves.size(); ++k) {
        const double from = angle_at(out.moves[k - 1]), to = angle_at(out.moves[k]);
        const double way = nc::following_at_end(out, k, 0) - nc::following_at_begin(out, k, 0);
        const bool dry = to > 249.5 * degree && to < 299.6 * degree;
        if (dry && from > 249.4 * degree) {
            EXPECT_NEAR(way, 0, 1e-12) << k;
        } else if (!dry && k > 1) {
            EXPECT_NEAR(way, (to - from) / (0.5 * degree) * 0.01, 2e-3) << k;
        }
    }
}

TEST(Following, SplinesHaveTheirShare) {
    const machine::Machine machine = printer();
    const Program program = read(rim(200, 500), machine);
    const auto smoothed = smooth_program(program, machine, {}, {}, SmoothedForm::curves);
    ASSERT_TRUE(smoothed) << to_string(smoothed.error());
    const Program& out = smoothed->program;
    ASSERT_EQ(out.following.size(), out.moves.size());
    EXPECT_NEAR(out.following.back(), 6.2, 1e-9);
}

TEST(Following, DividedMovesHaveTheirShare) {
    const machine::Machine machine = printer();
    const Program program = read("G21 G90 G0 X0 Y0 Z0 A10 C0\nG1 X30 A60 C80 E3 F600\nE2\nX60 A10 C10 E8\n", machine);
    const auto vectors = translate(program, machine, {}, OrientationLaw::vector, 0.01 * degree);
    ASSERT_TRUE(vectors) << to_string(vectors.error());
    ASSERT_GT(vectors->moves.size(), 20u);
    ASSERT_EQ(vectors->following.size(), vectors->moves.size());
    for (std::size_t k = 0; k < vectors->moves.size(); ++k) {
        const double x = vectors->moves[k].position_mm.x();
        EXPECT_NEAR(vectors->following[k], x <= 30 ? 0.1 * x : 2 + 0.2 * (x - 30), 1e-9) << k;
    }
    const auto words = translate(*vectors, machine, {}, OrientationLaw::rotary, 0.01 * degree);
    ASSERT_TRUE(words) << to_string(words.error());
    EXPECT_NEAR(words->following.back(), 8, 1e-12);
    const auto text = nc::write_text(*words, &machine, {});
    ASSERT_TRUE(text) << to_string(text.error());
    EXPECT_NEAR(read(*text, machine).following.back(), 8, 1e-6);
}

}  // namespace
}  // namespace trunnion::pipeline
