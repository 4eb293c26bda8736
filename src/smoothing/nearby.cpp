#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "detail/widths.hpp"

namespace trunnion::smoothing {

namespace {

constexpr double as_near_mm = 0.004;  // places whose distances differ by less are equally near
constexpr double worth_a_look = 0.2;  // below, no nearest place breaks a tolerance
constexpr std::size_t most_blocks_beside = 12;
constexpr int looks_aside = 10;  // before and behind a place, as far as the path may slip

double product(const Coordinates& a, const Coordinates& b, const Coordinates& metric) {
    return a.cwiseProduct(metric).dot(b);
}

/// A deviation that changes in equal steps from look to look, and the square of its length.
struct Row {
    Coordinates middle, step;
    double square, mixed, step_square;

    Row(const Coordinates& at_middle, const Coordinates& per_look, const Coordinates& metric)
        : middle(at_middle),
          step(per_look),
          square(product(middle, middle, metric)),
          mixed(2 * product(middle, step, metric)),
          step_square(product(step, step, metric)) {}
    double square_at(double look) const { return square + look * (mixed + look * step_square); }
    Coordinates at(int look) const { return middle + look * step; }
};

/// First and last of some looks.
struct Looks {
    int first = std::numeric_limits<int>::max(), last = std::numeric_limits<int>::min();
    void add(int look) {
        first = std::min(first, look);
        last = std::max(last, look);
    }
};

/// A programmed block beside the points looked from: the ways to them from its line and from its two ends.
class BlockBeside {
  public:
    BlockBeside(const Coordinates& from_begin, const Coordinates& step, const Coordinates& along, double length_mm,
                const Coordinates& metric)
        : length_(length_mm),
          square_of_along_(product(along, along, metric)),
          foot_(product(from_begin, along, metric) / square_of_along_),
          foot_step_(product(step, along, metric) / square_of_along_),
          rows_{Row(from_begin - foot_ * along, step - foot_step_ * along, metric), Row(from_begin, step, metric),
                Row(from_begin - length_mm * along, step, metric)} {}

    /// Squared distance of the block from the point of a look, which is kept for the calls that follow.
    double look(int look) {
        const double foot = foot_ + look * foot_step_;
        nearest_ = foot < 0 ? begin : foot > length_ ? end : inside;
        return square_ = rows_[nearest_].square_at(look);
    }
    double square() const { return square_; }
    bool beside() const { return nearest_ == inside; }
    void count(int look) { looks_[nearest_].add(look); }

    /// The largest use among the looks that count. A way grows convexly along them: the first or the last has it.
    double largest_use(const Measure& measure, double lever) const {
        double use = 0;
        for (const Part part : {inside, begin, end}) {
            const auto [first, last] = looks_[part];
            if (first > last) continue;
            use = std::max(use, measure.use(rows_[part].at(first), lever));
            if (last > first) use = std::max(use, measure.use(rows_[part].at(last), lever));
        }
        return use;
    }

  private:
    enum Part { inside, begin, end };
    double length_, square_of_along_, foot_, foot_step_, square_ = 0;
    Part nearest_ = inside;
    std::array<Row, 3> rows_;
    std::array<Looks, 3> looks_;
};

/// The blocks within reach of a place, as many on both sides at most.
struct BlockRange {
    std::size_t first, last;
};

BlockRange blocks_beside(const Polyline& line, std::size_t here, double offset_mm, double reach_mm) {
    const std::size_t most_after = offset_mm > 0 ? most_blocks_beside : most_blocks_beside - 1;
    BlockRange range{here, here};
    for (double way = offset_mm; range.first > 0 && here - range.first < most_blocks_beside && way < reach_mm;)
        way += line.gap_mm[--range.first];
    for (double way = line.gap_mm[here] - offset_mm;
         range.last + 1 < line.blocks() && range.last - here < most_after && way < reach_mm;)
        way += line.gap_mm[++range.last];
    return range;
}

}  // namespace

double Curve::use_nearby(const Coordinates& deviation, Place at, std::optional<Coordinates>& kept_tangent) const {
    const std::size_t here = std::min(at.block - bumps.first(), line.blocks() - 1);
    const double lever_here = at.offset_mm > 0 ? std::max(lever(at.block), lever(at.block + 1)) : lever(at.block);
    double use = measure.use(deviation, lever_here);
    if (measure.has_arm()) return use;
    const Coordinates metric = measure.metric(lever_here);
    if (use < worth_a_look && product(deviation, deviation, metric) <= measure.nearness_square()) return use;
    if (!kept_tangent) kept_tangent = bumps.tangent(at);
    const Coordinates& tangent = *kept_tangent;
    const double reach = std::sqrt(product(deviation, deviation, metric)) + as_near_mm;
    const double slip = product(deviation, tangent, metric) / product(tangent, tangent, metric);
    // The curve's nearest place, seen from P.
    use = std::max(use, measure.use(deviation - slip * tangent, lever_here));

    const double offset = at.block - bumps.first() == here ? at.offset_mm : line.gap_mm[here];
    const Coordinates point = line.slope[here] * offset + deviation;  // from vertex `here`
    const Coordinates step = reach / looks_aside * tangent;
    const auto [first, last] = blocks_beside(line, here, offset, 2 * reach);
    std::vector<BlockBeside> blocks;
    blocks.reserve(last - first + 1);
    for (std::size_t b = first; b <= last; ++b)
        blocks.emplace_back(point + (line.vertex[here] - line.vertex[b]), step, line.slope[b], line.gap_mm[b], metric);
    for (int look = -looks_aside; look <= looks_aside; ++look) {
        BlockBeside* nearest = &blocks.front();
        for (BlockBeside& block : blocks)
            if (block.look(look) < nearest->square()) nearest = &block;
        nearest->count(look);
        const double as_near = std::sqrt(std::max(nearest->square(), 0.0)) + as_near_mm;
        for (BlockBeside& block : blocks)
            if (block.beside() && block.square() <= as_near * as_near) block.count(look);
    }
    for (const BlockBeside& block : blocks) use = std::max(use, block.largest_use(measure, lever_here));
    return use;
}

}  // namespace trunnion::smoothing
