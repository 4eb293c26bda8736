// A smoothed path depends on the run alone: not on what is far away, not on the direction it is read in, not on feeds.
// TRUNNION_SEED replays one seed, TRUNNION_RUNS sets how many.
#include <algorithm>
#include <cstdlib>
#include <string>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "trunnion/base/quantity.hpp"
#include "trunnion/nc/read.hpp"
#include "trunnion/path/path_builder.hpp"
#include "trunnion/path/rotary_stands.hpp"

#include "planned.hpp"
#include "random_run.hpp"

namespace trunnion::test {
namespace {

using path::OrientationLaw;
using path::Space;

constexpr double look_mm = 0.02;

std::uint64_t environment(const char* name, std::uint64_t otherwise) {
    const char* text = std::getenv(name);
    return text ? std::strtoull(text, nullptr, 10) : otherwise;
}

using Coordinates = Eigen::Matrix<double, 6, 1>;

/// Position, and orientation times the reference height.
Coordinates coordinates_at(const path::ToolPath& path, double p_mm) {
    auto piece = std::upper_bound(path.pieces.begin(), path.pieces.end(), p_mm,
                                  [](double p, const path::PathPiece& next) { return p < next.begin_mm; });
    if (piece != path.pieces.begin()) --piece;
    const auto q = path::evaluate(*piece, p_mm - piece->begin_mm);
    Coordinates out;
    for (int k = 0; k < 6; ++k) out[k] = q[k].value() * (k < 3 ? 1 : path::reference_height_mm);
    return out;
}

Laws laws_of(std::uint64_t seed) {
    const bool words = seed % 2;
    return {words ? OrientationLaw::rotary : OrientationLaw::vector, Space::workpiece};
}

Part part_of(std::uint64_t seed) {
    constexpr std::array<Part, 4> parts{Part::dense, Part::digits, Part::corners, Part::noise};
    return parts[seed / 2 % parts.size()];
}

std::string described(std::uint64_t seed) {
    return fmt::format("seed {}, {}, {}", seed, name_of(laws_of(seed)), name_of(part_of(seed)));
}

path::Run drawn(std::uint64_t seed, double length_mm) {
    return RandomRun(seed, laws_of(seed)).add(part_of(seed), length_mm).run();
}

/// Blocks first … last − 1 of a run.
path::Run slice(const path::Run& run, std::size_t first, std::size_t last) {
    path::Run out = run;
    const auto begin = static_cast<std::ptrdiff_t>(first), end = static_cast<std::ptrdiff_t>(last);
    out.vertices.assign(run.vertices.begin() + begin, run.vertices.begin() + end + 1);
    out.blocks.assign(run.blocks.begin() + begin, run.blocks.begin() + end);
    return out;
}

path::Run reversed(path::Run run) {
    std::reverse(run.vertices.begin(), run.vertices.end());
    std::reverse(run.blocks.begin(), run.blocks.end());
    return run;
}

std::size_t block_at(const path::Run& run, double p_mm) {
    std::size_t block = 0;
    for (double p = 0; p < p_mm; ++block) p += run.blocks[block].length_mm;
    return block;
}

/// How far the part's own path is from that of the whole, by the distance from where the part begins and ends.
struct Departure {
    static constexpr std::array<double, 4> beyond_mm{12, 18, 25, 40};
    std::array<double, 4> largest_mm{};

    void note(double from_end_mm, double off_mm) {
        for (std::size_t k = 0; k < beyond_mm.size() && from_end_mm > beyond_mm[k]; ++k)
            largest_mm[k] = std::max(largest_mm[k], off_mm);
    }
};

Departure departure(const path::ToolPath& part, const path::ToolPath& whole, std::size_t first_block) {
    Departure out;
    for (std::size_t b = 0; b < part.blocks.size(); ++b) {
        const path::BlockSpan &own = part.blocks[b], &same = whole.blocks[first_block + b];
        for (double way = 0; way < own.end_mm - own.begin_mm; way += look_mm) {
            const double p = own.begin_mm + way;
            out.note(std::min(p, part.length_mm() - p),
                     (coordinates_at(part, p) - coordinates_at(whole, same.begin_mm + way)).norm());
        }
    }
    return out;
}

/// Asked for is 1e-10 mm. Widths have it; pieces begin elsewhere, and each is within 0.1 µm of the curve.
constexpr double same_in_middle_mm = 5e-5;

TEST(Surroundings, FarAwayDoNotMatter) {
    const std::uint64_t first = environment("TRUNNION_SEED", 1), count = environment("TRUNNION_RUNS", 24);
    Departure all;
    for (std::uint64_t seed = first; seed < first + count; ++seed) {
        SCOPED_TRACE(described(seed));
        const path::Run whole = drawn(seed, 400);
        const std::size_t from = block_at(whole, 90), to = block_at(whole, 310);
        const Departure one = departure(smoothed_to_one(slice(whole, from, to)), smoothed_to_one(whole), from);
        EXPECT_LE(one.largest_mm.back(), same_in_middle_mm);
        for (std::size_t k = 0; k < all.largest_mm.size(); ++k)
            all.largest_mm[k] = std::max(all.largest_mm[k], one.largest_mm[k]);
    }
    fmt::print("seeds {} to {}: another path by", first, first + count - 1);
    for (std::size_t k = 0; k < all.largest_mm.size(); ++k)
        fmt::print("{} {:.1e} mm beyond {} mm", k ? "," : "", all.largest_mm[k], Departure::beyond_mm[k]);
    fmt::print("\n");
}

constexpr double same_backwards_mm = 1e-6;

TEST(Direction, DoesNotMatter) {
    const std::uint64_t first = environment("TRUNNION_SEED", 1), count = environment("TRUNNION_RUNS", 24);
    double most_mm = 0;
    std::uint64_t most_seed = 0;
    for (std::uint64_t seed = first; seed < first + count; ++seed) {
        SCOPED_TRACE(described(seed));
        const path::Run run = drawn(seed, 100);
        const path::ToolPath there = smoothed_to_one(run), back = smoothed_to_one(reversed(run));
        double off_mm = 0;
        for (double p = 0; p < there.length_mm(); p += look_mm)
            off_mm = std::max(off_mm, (coordinates_at(there, p) - coordinates_at(back, there.length_mm() - p)).norm());
        EXPECT_LE(off_mm, same_backwards_mm);
        if (off_mm > most_mm) most_seed = seed;
        most_mm = std::max(most_mm, off_mm);
    }
    fmt::print("seeds {} to {}: another path by {:.1e} mm, {}\n", first, first + count - 1, most_mm,
               described(most_seed));
}

TEST(Feeds, DoNotMatter) {
    const path::Run even = drawn(3, 100);
    path::Run changing = even;
    for (std::size_t i = 0; i < changing.blocks.size(); ++i)
        changing.blocks[i].feed = {i % 5 ? program::FeedRule::tip_speed : program::FeedRule::block_time,
                                   1.0 + static_cast<double>(i % 7)};
    const path::ToolPath a = smoothed_to_one(even), b = smoothed_to_one(changing);
    ASSERT_EQ(a.pieces.size(), b.pieces.size());
    for (std::size_t i = 0; i < a.pieces.size(); ++i) {
        EXPECT_EQ(a.pieces[i].begin_mm, b.pieces[i].begin_mm);
        EXPECT_EQ(a.pieces[i].length_mm, b.pieces[i].length_mm);
        EXPECT_EQ(a.pieces[i].coefficient, b.pieces[i].coefficient);
    }
    for (std::size_t i = 0; i < b.blocks.size(); ++i) EXPECT_EQ(b.blocks[i].feed, changing.blocks[i].feed);
}

/// Words of a run's poses; every block with a feed, or the first one alone.
std::string program_of(const path::Run& run, bool every_feed) {
    std::string text = "G21 G90 G94 G17 G40 G49 G54\n";
    for (std::size_t i = 0; i < run.vertices.size(); ++i) {
        const path::PathCoordinates& at = run.vertices[i];
        text += fmt::format("G1 X{:.6f} Y{:.6f} Z{:.6f} A{:.6f} C{:.6f}", at.position_mm[0], at.position_mm[1],
                            at.position_mm[2], at.orientation[0] / degree, at.orientation[1] / degree);
        if (i == 0 || every_feed) text += fmt::format(" F{}", 1000 + i % 4 * 500);
        text += '\n';
    }
    return text + "M2\n";
}

/// The first run that a program is built into.
path::Run built(const std::string& text) {
    nc::ReadOptions reading;
    reading.machine = &trunnion_table();
    const program::Program program = nc::read_program(text, "program", reading).value();
    const machine::Setup setup;
    const auto stands = path::choose_rotary_stands(program, trunnion_table(), setup).value();
    auto builder = path::PathBuilder::make(program, trunnion_table(), setup, stands).value();
    path::Run run;
    EXPECT_TRUE(builder.next(run).value());
    return run;
}

TEST(Feeds, OfAProgramDoNotSplitARun) {
    const path::Run walk = drawn(1, 50);
    const path::Run once = built(program_of(walk, false)), often = built(program_of(walk, true));
    ASSERT_EQ(once.blocks.size(), walk.blocks.size());
    ASSERT_EQ(often.blocks.size(), walk.blocks.size());
    EXPECT_NE(often.blocks[0].feed, often.blocks[1].feed);
    for (std::size_t i = 0; i < once.blocks.size(); ++i) {
        EXPECT_EQ(once.blocks[i].length_mm, often.blocks[i].length_mm);
        EXPECT_EQ(once.vertices[i + 1].position_mm, often.vertices[i + 1].position_mm);
        EXPECT_EQ(once.vertices[i + 1].orientation, often.vertices[i + 1].orientation);
    }
}

}  // namespace
}  // namespace trunnion::test
