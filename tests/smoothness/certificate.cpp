// The bound that smoothing proves of its path against what is seen by looking closely. TRUNNION_SEED replays one seed,
// TRUNNION_RUNS sets how many.
#include <algorithm>
#include <cstdlib>
#include <map>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "../unit/smoothing/walk.hpp"
#include "planned.hpp"
#include "random_run.hpp"

namespace trunnion::test {
namespace {

using path::OrientationLaw;
using path::Space;

/// Deviations as mm: of the tip, of a point on the tool by its turn alone, of the point at the flank height.
struct Deviation {
    double tip_mm = 0, turn_mm = 0, height_mm = 0;
};

constexpr double height_mm = 30;
constexpr int looks_per_block = 50;

Deviation bound_of(const path::ToolPath& path) {
    return {path.bound.tip_mm, height_mm * path.bound.orientation_rad, path.bound.height_mm};
}

void widen(Deviation& all, const Deviation& one) {
    all.tip_mm = std::max(all.tip_mm, one.tip_mm);
    all.turn_mm = std::max(all.turn_mm, one.turn_mm);
    all.height_mm = std::max(all.height_mm, one.height_mm);
}

/// The largest deviations at equal p of the stretch that begins with the run's block `first`.
Deviation seen(const path::Run& run, std::size_t first, const path::ToolPath& path) {
    Deviation largest;
    std::size_t piece = 0;
    for (std::size_t b = 0; b < path.blocks.size(); ++b) {
        const path::BlockSpan& span = path.blocks[b];
        for (int k = 0; k <= looks_per_block; ++k) {
            const double part = static_cast<double>(k) / looks_per_block;
            const double p = std::min(span.begin_mm + part * (span.end_mm - span.begin_mm), path.length_mm());
            while (piece + 1 < path.pieces.size() && path.pieces[piece + 1].begin_mm <= p) ++piece;
            while (piece > 0 && path.pieces[piece].begin_mm > p) --piece;
            const auto q = smoothing::test::derivative(path.pieces[piece], p - path.pieces[piece].begin_mm, 0);
            const auto is = smoothing::test::tool_at(run, q),
                       was = smoothing::test::tool_at(run, smoothing::test::programmed(run, first + b, part));
            widen(largest, {(is.tip - was.tip).norm(), height_mm * geometry::angle_between(is.axis, was.axis),
                            (is.tip + height_mm * is.axis - was.tip - height_mm * was.axis).norm()});
        }
    }
    return largest;
}

/// How far the bounds are above what is seen: largest of (bound − 0.1 µm) / seen.
struct Excess {
    Deviation ratio;
    int stretches = 0;
};

constexpr double rounding_mm = 1e-7;
constexpr double allowed_mm = 1e-4;

double ratio(double bound_mm, double seen_mm) {
    return std::max(bound_mm - allowed_mm, 0.0) / std::max(seen_mm, 1e-9);
}

void note(Excess& excess, const Deviation& bound, const Deviation& seen) {
    widen(excess.ratio, {ratio(bound.tip_mm, seen.tip_mm), ratio(bound.turn_mm, seen.turn_mm),
                         ratio(bound.height_mm, seen.height_mm)});
    ++excess.stretches;
}

std::uint64_t environment(const char* name, std::uint64_t otherwise) {
    const char* text = std::getenv(name);
    return text ? std::strtoull(text, nullptr, 10) : otherwise;
}

/// How far above what is seen a bound may be.
constexpr Deviation most_ratio{1.2, 1.2, 1.2};

struct Drawn {
    Laws laws;
    std::string kind;
    path::Run run;
    smoothing::SmoothingOptions options;
};

/// One run of parts of one kind, or of a mixture of all.
Drawn draw(std::uint64_t seed) {
    smoothing::test::Random random(seed);
    constexpr std::array<Laws, 3> laws{{{OrientationLaw::vector, Space::workpiece},
                                        {OrientationLaw::rotary, Space::workpiece},
                                        {OrientationLaw::rotary, Space::machine}}};
    constexpr std::array<Part, 5> parts{Part::dense, Part::digits, Part::corners, Part::noise, Part::arcs};
    const Laws law = laws[seed % laws.size()];
    const std::size_t which = seed / laws.size() % (parts.size() + 1);
    const bool mixed = which == parts.size();
    RandomRun walk(random.next(), law);
    for (int k = 0; k < 4; ++k) {
        const Part part = mixed ? parts[random.next() % parts.size()] : parts[which];
        walk.add(part, random.uniform(5, 40));
    }
    Drawn out{law, name_of(law) + ", " + (mixed ? "mixed" : name_of(parts[which])), walk.run(), tolerances()};
    if (law.law == OrientationLaw::rotary && random.uniform(0, 1) < 0.5) {
        smoothing::test::put_on(smoothing::test::inclined_table(), out.run);
        out.kind += ", inclined";
    }
    out.options.tip_tolerance_mm = std::pow(10, random.uniform(-2.5, -1));
    out.options.orientation_tolerance_rad = random.uniform(0.02, 0.3) * smoothing::test::degree;
    if (random.uniform(0, 1) < 0.3) {
        out.options.flank_tolerance_mm = random.uniform(0.5, 3) * out.options.tip_tolerance_mm;
        out.kind += ", flank";
    }
    return out;
}

TEST(Certificate, IsAboveWhatIsSeenAndNotFarAbove) {
    const std::uint64_t first = environment("TRUNNION_SEED", 1), count = environment("TRUNNION_RUNS", 108);
    fmt::print("seeds {} to {}\n", first, first + count - 1);
    std::map<std::string, Excess> by_kind;
    for (std::uint64_t seed = first; seed < first + count; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        const Drawn drawn = draw(seed);
        const Deviation most = most_ratio;
        std::size_t block = 0;
        for (const path::ToolPath& path : smoothed(drawn.run, drawn.options)) {
            const Deviation bound = bound_of(path), is = seen(drawn.run, block, path);
            block += path.blocks.size();
            note(by_kind[drawn.kind], bound, is);
            EXPECT_LE(is.tip_mm, bound.tip_mm + rounding_mm);
            EXPECT_LE(is.turn_mm, bound.turn_mm + rounding_mm);
            EXPECT_LE(is.height_mm, bound.height_mm + rounding_mm);
            EXPECT_LE(ratio(bound.tip_mm, is.tip_mm), most.tip_mm);
            EXPECT_LE(ratio(bound.turn_mm, is.turn_mm), most.turn_mm);
            EXPECT_LE(ratio(bound.height_mm, is.height_mm), most.height_mm);
        }
    }
    fmt::print("{:<24} {:>9} {:>8} {:>8} {:>8}\n", "bound / seen", "stretches", "tip", "turn", "height");
    for (const auto& [kind, excess] : by_kind)
        fmt::print("{:<24} {:>9} {:>8.3f} {:>8.3f} {:>8.3f}\n", kind, excess.stretches, excess.ratio.tip_mm,
                   excess.ratio.turn_mm, excess.ratio.height_mm);
}

}  // namespace
}  // namespace trunnion::test
