#include "trunnion/smoothing/smoothing.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "trunnion/smoothing/kernel.hpp"

#include "detail/certificate.hpp"
#include "detail/handing_over.hpp"
#include "detail/local_rounding.hpp"
#include "detail/pole.hpp"
#include "detail/programmed_block.hpp"
#include "detail/straight.hpp"

namespace trunnion::smoothing {

namespace {

constexpr int narrowing_rounds = 24;

/// Where a run must stand still.
struct Stop {
    std::size_t vertex = 0;
    path::StopCause cause = path::StopCause::corner;
};

bool has_doubled_points(const path::Run& run) {
    return std::any_of(run.blocks.begin(), run.blocks.end(),
                       [](const path::Block& b) { return b.length_mm < shortest_block_mm; });
}

/// A run without its blocks that have no length, and which of its blocks are left. The last pose stays.
struct Kept {
    path::Run run;
    std::vector<std::size_t> block;
};

Kept without_doubled_points(const path::Run& run) {
    Kept kept{run, {}};
    kept.run.vertices.resize(1);
    kept.run.blocks.clear();
    for (std::size_t i = 0; i < run.blocks.size(); ++i) {
        if (run.blocks[i].length_mm < shortest_block_mm) continue;
        kept.run.vertices.push_back(run.vertices[i + 1]);
        kept.run.blocks.push_back(run.blocks[i]);
        kept.block.push_back(i);
    }
    if (!kept.block.empty()) kept.run.vertices.back() = run.vertices.back();
    for (path::PolePassage& passage : kept.run.passages) {
        const auto block = std::lower_bound(kept.block.begin(), kept.block.end(), passage.block);
        passage.block = std::min<std::size_t>(block - kept.block.begin(), kept.block.size() - 1);
    }
    return kept;
}

/// The tangent changes, or curvature does.
bool is_kink(const path::Run& run, std::size_t vertex) {
    if (is_round(run.blocks[vertex]) || is_round(run.blocks[vertex - 1])) return !curve_goes_on(run, vertex);
    return (tangent_at_begin(run, vertex) - tangent_at_end(run, vertex - 1)).norm() > no_kink;
}

std::vector<Stop> kinks(const path::Run& run) {
    std::vector<Stop> stops;
    for (std::size_t i = 1; i < run.blocks.size(); ++i)
        if (is_kink(run, i)) stops.push_back({i, path::StopCause::corner});
    return stops;
}

double tangent_cosine(const path::Run& run, std::size_t vertex) {
    return tangent_at_begin(run, vertex).normalized().dot(tangent_at_end(run, vertex - 1).normalized());
}

/// Reversals between blocks so long that nothing beside them can help. Others show when the curve is made.
std::vector<Stop> lone_reversals(const path::Run& run, const SmoothingOptions& options) {
    std::vector<Stop> stops;
    const Measure measure(run, {0, run.blocks.size()}, options);
    for (std::size_t i = 1; i < run.blocks.size(); ++i) {
        const double room = std::min(run.blocks[i - 1].length_mm, run.blocks[i].length_mm);
        const Coordinates before = tangent_at_end(run, i - 1), after = tangent_at_begin(run, i);
        if (before.normalized().dot(after.normalized()) > reversal_cosine) continue;
        Coordinates kink = after - before;
        kink.tail<3>() /= path::reference_height_mm;
        const double width = 1 / (CornerKernel::peak * measure.use(kink, 1));
        if (width < room) stops.push_back({i, path::StopCause::reversal});
    }
    return stops;
}

/// One stretch of a run on its way from widths to a proved path.
class Smoother {
  public:
    Smoother(const path::Run& run, VertexRange range, const Measure& measure)
        : run_(run), range_(range), curve_(chords(run, range, measure), measure), poles_(run, range, measure) {}

    /// Stops that the stretch needs; none: it is smoothed.
    std::vector<Stop> work() {
        find_widths(curve_);
        sections_ = make_sections(curve_);
        proofs_.resize(sections_.size());
        stale_.assign(sections_.size(), 1);
        for (int round = 0;; ++round) {
            prove();
            if (const auto places = irregular(); !places.empty()) return stops_at(places, path::StopCause::reversal);
            const std::vector<Excess> places = excess();
            if (places.empty()) return {};
            if (round == narrowing_rounds) return stops_at(blocks_of(places), path::StopCause::corner);
            forget(narrow(curve_, places, round));
        }
    }

    path::ToolPath path(path::StopCause stop) const {
        path::ToolPath path = stretch(run_, range_, stop);
        std::vector<double> use;
        double begin = 0;
        for (std::size_t i = 0; i < sections_.size(); ++i) {
            for (path::PathPiece piece : sections_[i].pieces) {
                piece.begin_mm += begin;
                path.pieces.push_back(piece);
            }
            begin += sections_[i].length_mm;
            widen(path.bound, proofs_[i].bound);
            use.insert(use.end(), proofs_[i].use_at_vertex.begin(), proofs_[i].use_at_vertex.end());
        }
        path.blocks.back().end_mm = path.length_mm();
        for (std::size_t k = 1; k < use.size(); ++k)
            if (curve_.line.programmed[k] >= 0) path.transition_use.push_back(static_cast<float>(use[k]));
        return path;
    }

  private:
    static void widen(path::DeviationBound& a, const path::DeviationBound& b) {
        a.tip_mm = std::max(a.tip_mm, b.tip_mm);
        a.orientation_rad = std::max(a.orientation_rad, b.orientation_rad);
        a.height_mm = std::max(a.height_mm, b.height_mm);
    }

    void prove() {
        if (!poles_.empty()) lead_through_poles(poles_, curve_, plain_, sections_, stale_);
        for (std::size_t i = 0; i < sections_.size(); ++i) {
            if (!stale_[i]) continue;
            if (poles_.empty()) represent(curve_, sections_[i]);
            proofs_[i] = certify(run_, curve_, sections_[i]);
            stale_[i] = 0;
        }
    }

    std::vector<std::size_t> irregular() const {
        std::vector<std::size_t> places;
        for (const Certificate& proof : proofs_)
            places.insert(places.end(), proof.irregular.begin(), proof.irregular.end());
        return places;
    }

    std::vector<Excess> excess() const {
        std::vector<Excess> places;
        for (const Certificate& proof : proofs_) places.insert(places.end(), proof.excess.begin(), proof.excess.end());
        poles_.blame_curve(curve_.bumps, places);
        return places;
    }

    static std::vector<std::size_t> blocks_of(const std::vector<Excess>& places) {
        std::vector<std::size_t> blocks;
        for (const Excess& place : places) blocks.push_back(place.at.block);
        return blocks;
    }

    /// Sections that a changed bump reaches.
    void forget(const std::vector<Moved>& moved) {
        const Bumps& bumps = curve_.bumps;
        for (const Moved& m : moved) {
            mark(m.vertex);
            bumps.around({m.vertex, 0}, m.reach_mm, m.reach_mm, [&](std::size_t j, double) { mark(j); });
        }
    }

    /// The sections on both sides of a vertex or its neighbours.
    void mark(std::size_t vertex) {
        const auto after = std::upper_bound(sections_.begin(), sections_.end(), vertex + 1,
                                            [](std::size_t v, const Section& s) { return v < s.first; });
        for (auto s = after; s != sections_.begin() && std::prev(s)->last + 1 >= vertex; --s)
            stale_[static_cast<std::size_t>(std::prev(s) - sections_.begin())] = 1;
    }

    /// For each group of neighbouring blocks the sharpest programmed vertex inside the stretch.
    std::vector<Stop> stops_at(const std::vector<std::size_t>& blocks, path::StopCause cause) const {
        std::vector<Stop> stops;
        for (std::size_t i = 0; i < blocks.size();) {
            std::size_t end = i + 1;
            while (end < blocks.size() && blocks[end] <= blocks[end - 1] + 1) ++end;
            const std::size_t vertex = sharpest(programmed_before(blocks[i]), programmed_after(blocks[end - 1] + 1));
            if (stops.empty() || stops.back().vertex < vertex) stops.push_back({vertex, cause});
            i = end;
        }
        return stops;
    }

    std::size_t programmed_before(std::size_t vertex) const {
        std::size_t k = vertex - curve_.bumps.first();
        while (curve_.line.programmed[k] < 0) --k;
        return static_cast<std::size_t>(curve_.line.programmed[k]);
    }

    std::size_t programmed_after(std::size_t vertex) const {
        std::size_t k = vertex - curve_.bumps.first();
        while (curve_.line.programmed[k] < 0) ++k;
        return static_cast<std::size_t>(curve_.line.programmed[k]);
    }

    std::size_t sharpest(std::size_t from, std::size_t to) const {
        from = std::max(from, range_.first + 1);
        to = std::min(to, range_.last - 1);
        std::size_t best = std::min(from, to);
        for (std::size_t i = best; i <= to; ++i)
            if (tangent_cosine(run_, i) < tangent_cosine(run_, best)) best = i;
        return best;
    }

    const path::Run& run_;
    VertexRange range_;
    Curve curve_;
    PoleShifts poles_;
    std::vector<Section> plain_;  // before poles_, where there are any
    std::vector<Section> sections_;
    std::vector<Certificate> proofs_;
    std::vector<char> stale_;
};

/// Nothing is to be rounded inside: one block, or parts of curves that go on with the same tangent and curvature.
bool goes_on_throughout(const path::Run& run, VertexRange range) {
    if (range.last == range.first + 1) return true;
    for (std::size_t i = range.first; i < range.last; ++i)
        if (!ProgrammedBlock(run, i).is_regular_curve() || (i > range.first && !curve_goes_on(run, i))) return false;
    return true;
}

class RunSmoother {
  public:
    RunSmoother(const path::Run& run, const SmoothingOptions& options, std::vector<path::ToolPath>& out)
        : run_(run), options_(options), out_(out) {}

    /// Smooths the parts between standstills.
    void between(VertexRange range, const std::vector<Stop>& stops, path::StopCause last) {
        for (const Stop& s : stops) {
            part({range.first, s.vertex}, s.cause);
            range.first = s.vertex;
        }
        part(range, last);
    }

  private:
    void part(VertexRange range, path::StopCause stop) {
        if (options_.corners == Corners::smooth || range.last == range.first + 1) return smooth(range, stop);
        const auto smooth_between = [&](VertexRange within, path::StopCause cause, std::vector<path::ToolPath>& made) {
            if (within.last == within.first + 1) return round_locally(run_, within, cause, options_, made);
            SmoothingOptions all_alike = options_;
            all_alike.corners = Corners::smooth;
            RunSmoother(run_, all_alike, made).smooth(within, cause);
        };
        smooth_with_handed_corners(run_, range, stop, options_, smooth_between, out_);
    }

    void smooth(VertexRange range, path::StopCause stop) {
        if (goes_on_throughout(run_, range)) {
            append_straight(run_, range, stop, options_, out_);
            return lead_through_poles(run_, range, options_, out_.back());
        }
        if (const std::vector<Stop> stops = attempt(range, stop); !stops.empty()) between(range, stops, stop);
    }

    /// Appends the smoothed stretch, or says where it must stand still.
    std::vector<Stop> attempt(VertexRange range, path::StopCause stop) {
        Smoother smoother(run_, range, Measure(run_, range, options_));
        std::vector<Stop> stops = smoother.work();
        if (stops.empty()) out_.push_back(smoother.path(stop));
        return stops;
    }

    const path::Run& run_;
    const SmoothingOptions& options_;
    std::vector<path::ToolPath>& out_;
};

void keep_as_programmed(const path::Run& run, const SmoothingOptions& options, std::vector<path::ToolPath>& out) {
    std::size_t first = 0;
    for (const Stop& s : kinks(run)) {
        append_straight(run, {first, s.vertex}, s.cause, options, out);
        first = s.vertex;
    }
    append_straight(run, {first, run.blocks.size()}, run.stop, options, out);
    if (run.blocks.size() == 1) lead_through_poles(run, {0, 1}, options, out.back());
}

}  // namespace

bool follows_exactly(const SmoothingOptions& options) {
    const double second =
        options.flank_tolerance_mm > 0 ? options.flank_tolerance_mm : options.orientation_tolerance_rad;
    return options.rounding == Rounding::none || !(options.tip_tolerance_mm > 0) || !(second > 0);
}

void smooth(const path::Run& run, const SmoothingOptions& options, std::vector<path::ToolPath>& out) {
    if (has_doubled_points(run)) {
        const Kept kept = without_doubled_points(run);
        if (kept.block.empty()) return;
        const std::size_t before = out.size();
        smooth(kept.run, options, out);
        for (std::size_t i = before; i < out.size(); ++i)
            for (path::BlockSpan& span : out[i].blocks) span.run_block = kept.block[span.run_block];
        return;
    }
    if (run.blocks.empty()) return;
    if (run.rapid || run.blocks.size() == 1 || follows_exactly(options)) return keep_as_programmed(run, options, out);
    const VertexRange all{0, run.blocks.size()};
    if (options.rounding == Rounding::beudaert) return round_locally(run, all, run.stop, options, out);
    RunSmoother(run, options, out).between(all, lone_reversals(run, options), run.stop);
}

}  // namespace trunnion::smoothing
