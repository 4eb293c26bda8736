#include "detail/pole_candidates.hpp"

#include <algorithm>

#include "trunnion/geometry/great_circle.hpp"

namespace trunnion::path::detail {

namespace {

constexpr double same_passage = 4;  // times the tolerance: so far off two passages are told apart
constexpr double least_tilts = 3;   // times the distance of the passage
constexpr double least_tilt = 1e-5;
constexpr double least_reach_mm = 0.01;

struct Passage {
    std::size_t block = 0;
    NearestToPole nearest;
    Eigen::Vector3d pole;
};

/// A stretch of p along the blocks from `first` up to `end`.
struct Stretch {
    double begin_mm = 0, end_mm = 0;
    std::size_t first = 0, end = 0;
};

/// Short and well off the pole, the rule in dense programs.
bool is_far(const VectorBlock& block, const Eigen::Vector3d& pole) {
    constexpr double far_cosine = 0.9, short_chord = 0.1;
    return block.from.dot(pole) < far_cosine && (block.to - block.from).squaredNorm() < short_chord * short_chord;
}

std::vector<Passage> passages_of(std::span<const VectorBlock> blocks, const Eigen::Vector3d& pole, double tolerance) {
    std::vector<Passage> out;
    bool open = false;
    for (std::size_t k = 0; k < blocks.size(); ++k) {
        open = open && !blocks[k].begins_at_rest && !is_far(blocks[k], pole);
        if (is_far(blocks[k], pole)) continue;
        const NearestToPole nearest = nearest_to_pole(blocks[k].from, blocks[k].to, pole);
        if (nearest.distance() > same_passage * tolerance) {
            open = false;
        } else if (!open) {
            out.push_back({k, nearest, pole});
            open = true;
        } else if (nearest.distance() < out.back().nearest.distance()) {
            out.back() = {k, nearest, pole};
        }
    }
    std::erase_if(out, [&](const Passage& passage) { return passage.nearest.distance() > tolerance; });
    return out;
}

/// p along the blocks, from the first one, and where the run of a block begins and ends.
class Lengths {
  public:
    explicit Lengths(std::span<const VectorBlock> blocks) : blocks_(blocks), begin_mm_{0} {
        for (const VectorBlock& block : blocks) begin_mm_.push_back(begin_mm_.back() + block.length_mm);
    }
    double begin(std::size_t block) const { return begin_mm_[block]; }
    double place(const Passage& passage) const {
        return begin_mm_[passage.block] + passage.nearest.share * blocks_[passage.block].length_mm;
    }
    std::size_t first_of_run(std::size_t block) const {
        while (block > 0 && !blocks_[block].begins_at_rest) --block;
        return block;
    }
    std::size_t end_of_run(std::size_t block) const {
        ++block;
        while (block < blocks_.size() && !blocks_[block].begins_at_rest) ++block;
        return block;
    }
    /// The part of the tool axis beside a pole at a place on the blocks of a run.
    Eigen::Vector3d beside(double at_mm, std::size_t first, std::size_t end, const Eigen::Vector3d& pole) const {
        const auto after = std::upper_bound(begin_mm_.begin() + static_cast<std::ptrdiff_t>(first) + 1,
                                            begin_mm_.begin() + static_cast<std::ptrdiff_t>(end), at_mm);
        const std::size_t block = static_cast<std::size_t>(after - begin_mm_.begin()) - 1;
        const double share = std::clamp((at_mm - begin_mm_[block]) / blocks_[block].length_mm, 0.0, 1.0);
        return beside_pole(geometry::slerp(blocks_[block].from, blocks_[block].to, share), pole);
    }

  private:
    std::span<const VectorBlock> blocks_;
    std::vector<double> begin_mm_;
};

/// The stretch that a passage has for itself: half the way to the next ones, and not beyond its run.
Stretch own_stretch(const Lengths& lengths, std::span<const Passage> passages, std::size_t which) {
    const Passage& passage = passages[which];
    const double here = lengths.place(passage);
    Stretch out{.first = lengths.first_of_run(passage.block), .end = lengths.end_of_run(passage.block)};
    out.begin_mm = std::max(lengths.begin(out.first), here - longest_shift_mm);
    out.end_mm = std::min(lengths.begin(out.end), here + longest_shift_mm);
    if (which > 0 && passages[which - 1].block >= out.first)
        out.begin_mm = std::max(out.begin_mm, 0.5 * (lengths.place(passages[which - 1]) + here));
    if (which + 1 < passages.size() && passages[which + 1].block < out.end)
        out.end_mm = std::min(out.end_mm, 0.5 * (here + lengths.place(passages[which + 1])));
    return out;
}

/// Whether the tool goes by the pole and gets well away from it on both sides. Else it wanders about there, or turns
/// back, and a shift calms nothing: led to the pole, the free axis would have to turn half round at one place.
bool goes_past(const Lengths& lengths, const Passage& passage, const Stretch& stretch) {
    const double here = lengths.place(passage);
    if (here - stretch.begin_mm < least_reach_mm || stretch.end_mm - here < least_reach_mm) return false;
    const double enough = std::max(least_tilts * passage.nearest.distance(), least_tilt);
    const Eigen::Vector3d coming = lengths.beside(stretch.begin_mm, stretch.first, stretch.end, passage.pole),
                          going = lengths.beside(stretch.end_mm, stretch.first, stretch.end, passage.pole);
    return coming.norm() >= enough && going.norm() >= enough && coming.dot(going) < 0;
}

}  // namespace

std::vector<PoleCandidate> pole_candidates(std::span<const VectorBlock> blocks, std::span<const Eigen::Vector3d> poles,
                                           double tolerance_rad) {
    std::vector<Passage> passages;
    for (const Eigen::Vector3d& pole : poles) {
        const auto more = passages_of(blocks, pole, tolerance_rad);
        passages.insert(passages.end(), more.begin(), more.end());
    }
    std::vector<PoleCandidate> out;
    if (passages.empty()) return out;
    std::sort(passages.begin(), passages.end(), [](const Passage& a, const Passage& b) { return a.block < b.block; });
    const Lengths lengths(blocks);
    std::size_t taken = 0;  // blocks of the candidates so far
    for (std::size_t k = 0; k < passages.size(); ++k) {
        const Passage& passage = passages[k];
        const Stretch stretch = own_stretch(lengths, passages, k);
        if (passage.block < taken || !goes_past(lengths, passage, stretch)) continue;
        std::size_t first = passage.block, last = passage.block;
        while (first > std::max(stretch.first, taken) && lengths.begin(first) > stretch.begin_mm) --first;
        while (last + 1 < stretch.end && lengths.begin(last + 1) < stretch.end_mm) ++last;
        taken = last + 1;
        const double here = lengths.place(passage);
        PoleCandidate candidate{.move = blocks[passage.block].move,
                                .share = passage.nearest.share,
                                .pole = passage.pole,
                                .shift = -passage.nearest.beside,
                                .reach_before_mm = here - stretch.begin_mm,
                                .reach_after_mm = stretch.end_mm - here,
                                .first = blocks[first].move,
                                .last = blocks[last].move,
                                .begin_mm = lengths.begin(first) - here};
        for (std::size_t b = first; b <= last; ++b) candidate.length_mm.push_back(blocks[b].length_mm);
        out.push_back(std::move(candidate));
    }
    return out;
}

}  // namespace trunnion::path::detail
