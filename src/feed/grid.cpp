#include "detail/grid.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "detail/bernstein.hpp"
#include "detail/rest_arc.hpp"
#include "detail/screening.hpp"

namespace trunnion::feed {
namespace {

constexpr double turn_tolerance =
    0.0012;  // how far q′ may bend from its chord within an interval, of the leading axis' q′
constexpr double arc_turn_tolerance = 0.05;  // the same of a rest arc, whose samples must see the bend
constexpr double largest_mm = 5;
constexpr double growth = 0.16;       // of the size per mm: neighbours differ by up to e^0.16
constexpr double rest_growth = 0.14;  // ln 1.15
// An arc must be short beside the way to the next corner: the speed turns down again long before it.
constexpr double arc_share_of_path = 0.01, arc_share_of_segment = 0.04;
constexpr int shortest_arc_steps = 80, most_straightening_steps = 20;
constexpr double intervals_of_transition = 8;
constexpr int least_halvings = 1, deepest_halving = 36;
constexpr int arc_parts = 8;
constexpr double nearest_to_rest = 1e-6, near_rest_step = 1.25;
constexpr double rounding_down = 0.3;  // a stretch of 1.3 sizes is still one interval

/// Behind a place that is farther away than this no wish for small intervals is felt.
constexpr double look_ahead_mm = largest_mm / std::min(growth, rest_growth) + largest_mm;

bool same_feed(const path::BlockSpan& a, const path::BlockSpan& b) {
    if (!(a.feed.rule == b.feed.rule)) return false;
    if (a.feed.rule != path::FeedRule::block_time) return a.feed.value == b.feed.value;
    return a.feed.value * b.time_scale_mm == b.feed.value * a.time_scale_mm;
}

double speed_cap(const PathSample& s, const LimitSet& limits) {
    double inverse = 0;
    for (int c = 0; c < coordinates; ++c) inverse = std::max(inverse, std::abs(s.q1[c]) / limits.of[c].velocity);
    return 1 / inverse;
}

/// Intervals of a leaf on which the size runs linearly from a to b: ∫ dp/size, and where a part of it is reached.
struct Ramp {
    double length, a, b;
    double count() const {
        const double ratio = b / a - 1;
        return std::abs(ratio) < 1e-6 ? length / a : length * std::log1p(ratio) / (b - a);
    }
    double at(double part) const {
        const double ratio = b / a - 1;
        if (std::abs(ratio) < 1e-6) return part * a;
        return length * std::expm1(part * (b - a) / length) / ratio;
    }
};

}  // namespace

void SegmentCutter::pass_blocks(double begin, double reached) {
    const auto& blocks = path_->tool_path().blocks;
    while (block_ + 1 < blocks.size() && blocks[block_].end_mm - begin <= reached) ++block_;
}

void SegmentCutter::pass_stations(double reached) {
    const auto& stations = path_->stations();
    while (station_ < stations.size() &&
           (stations[station_].piece < piece_ ||
            (stations[station_].piece == piece_ && stations[station_].offset_mm <= reached)))
        ++station_;
}

/// The end of the blocks that share this one's feed, or a station before it.
double SegmentCutter::next_cut(double begin, double length) const {
    const auto& blocks = path_->tool_path().blocks;
    const auto& stations = path_->stations();
    std::size_t last = block_;
    while (last + 1 < blocks.size() && blocks[last].end_mm - begin < length &&
           same_feed(blocks[last], blocks[last + 1]))
        ++last;
    double next = last + 1 < blocks.size() ? blocks[last].end_mm - begin : length;
    if (station_ < stations.size() && stations[station_].piece == piece_)
        next = std::min(next, stations[station_].offset_mm);
    return std::min(next, length);
}

std::optional<Segment> SegmentCutter::next() {
    const path::ToolPath& tool = path_->tool_path();
    for (; piece_ < tool.pieces.size(); ++piece_, at_ = 0) {
        const double length = tool.pieces[piece_].length_mm, begin = tool.pieces[piece_].begin_mm,
                     slack = std::min(1e-7, 1e-4 * length);
        while (at_ < length) {
            pass_blocks(begin, at_ + slack);
            pass_stations(at_ + slack);
            double cut = next_cut(begin, length);
            if (cut <= at_ + slack) continue;
            if (cut > length - slack) cut = length;
            const bool first = piece_ == 0 && at_ == 0, last = piece_ + 1 == tool.pieces.size() && cut == length;
            const Segment out{piece_, at_, cut, block_, first, last};
            at_ = cut;
            return out;
        }
    }
    return std::nullopt;
}

PathSample Grid::sample(const Segment& s, double offset) const {
    return sampler_.at({s.piece, offset}, s.block).sample;
}

/// As long as constant path jerk is nearly the optimum.
double Grid::arc_length(const Segment& within, bool start) const {
    const RestSide side = start ? RestSide::start : RestSide::stop;
    const LimitSet& limits = sampler_.limits();
    const auto at = [&](double u) { return sample(within, start ? within.begin_mm + u : within.end_mm - u); };
    const PathSample rest = at(0);
    const double alpha = rest_alpha(rest, limits);
    double length = std::min(arc_share_of_path * sampler_.path().length_mm(),
                             arc_share_of_segment * (within.end_mm - within.begin_mm));
    for (int k = 0; k < shortest_arc_steps && !is_jerk_phase(at(length), length, side, limits, alpha); ++k)
        length *= 0.7;
    const auto turns = [&](double arc) {
        return bends(rest, at(arc / 2), at(arc), start ? arc : -arc, arc_turn_tolerance);
    };
    double straighter = length;
    for (int k = 0; k < most_straightening_steps && turns(straighter); ++k) straighter *= 0.7;
    return turns(straighter) ? length : straighter;  // at the pole itself no arc is short enough
}

/// Takes the arc off the segment's end; its length.
double Grid::take_arc(Segment& segment, bool at_start, Cell& arc) const {
    const double length = arc_length(segment, at_start);
    if (at_start) {
        arc = {{segment.piece, segment.begin_mm}, length, segment.block, true, false};
        segment.begin_mm += length;
    } else {
        segment.end_mm -= length;
        arc = {{segment.piece, segment.end_mm}, length, segment.block, false, true};
    }
    return length;
}

/// Interval size that resolves the change from one allowed speed to another.
double Grid::transition_size(const PathSample& before, const PathSample& after) const {
    const LimitSet& limits = sampler_.limits();
    const double v0 = speed_cap(before, limits), v1 = speed_cap(after, limits), change = std::abs(v1 - v0);
    if (!(change > 1e-3 * std::max(v0, v1)) || !std::isfinite(v0 + v1)) return largest_mm;
    double jerk = std::numeric_limits<double>::max(), acceleration = jerk;
    for (int c = 0; c < programmed_feed; ++c) {
        const double q = std::abs(after.q1[c]);
        if (q == 0) continue;
        jerk = std::min(jerk, limits.of[c].jerk / q);
        acceleration = std::min(acceleration, limits.of[c].acceleration / q);
    }
    const double time = std::max(2 * std::sqrt(change / jerk), change / acceleration);
    return (v0 + v1) / 2 * time / intervals_of_transition;
}

/// Whether an axis that matters turns so much that one cubic x(p) could not follow.
bool Grid::bends(const PathSample& a, const PathSample& m, const PathSample& b, double length, double tolerance) const {
    double bend_j = 0, lead_j = 0, bend_v = 0, lead_v = 0;
    for (int i = 0; i < programmed_feed; ++i) {
        const machine::AxisLimits& limit = sampler_.limits().of[i];
        const double per_jerk = 1 / limit.jerk, per_velocity = 1 / limit.velocity;
        const double odd =
            std::abs(b.q1[i] - a.q1[i] - length * m.q2[i]) / 4;  // a turn that is symmetric about the middle
        const double bend = std::max(std::abs(m.q1[i] - (a.q1[i] + b.q1[i]) / 2), odd);
        const double lead = std::max({std::abs(a.q1[i]), std::abs(m.q1[i]), std::abs(b.q1[i])});
        bend_j = std::max(bend_j, bend * per_jerk);
        lead_j = std::max(lead_j, lead * per_jerk);
        bend_v = std::max(bend_v, bend * per_velocity);
        lead_v = std::max(lead_v, lead * per_velocity);
    }
    return bend_j > tolerance * lead_j || bend_v > tolerance * lead_v;
}

void Grid::refine(Graded& to, double begin, double end, const PathSample& at_begin, const PathSample& at_end,
                  int depth) {
    const double middle = (begin + end) / 2;
    const PathSample at_middle = sample(to.segment, middle);
    if (depth < deepest_halving &&
        (depth < least_halvings || bends(at_begin, at_middle, at_end, end - begin, turn_tolerance))) {
        refine(to, begin, middle, at_begin, at_middle, depth + 1);
        return refine(to, middle, end, at_middle, at_end, depth + 1);
    }
    const double size = std::min(end - begin, largest_mm);
    to.nodes.back().size_mm = std::min(to.nodes.back().size_mm, size);
    to.nodes.push_back({end, size});
}

/// Takes a segment up with the sizes that its own path wishes, and those that follow from what lies before it.
void Grid::take(Segment segment) {
    if (segment.first) {
        from_rest_mm_ = take_arc(segment, true, start_arc_);
        cells_.push_back(start_arc_);
    }
    if (segment.last) take_arc(segment, false, stop_arc_);
    Graded& graded = pending_.emplace_back(Graded{segment, {}});
    const PathSample begin = sample(segment, segment.begin_mm), end = sample(segment, segment.end_mm);
    graded.nodes.push_back(
        {segment.begin_mm, segment.first ? rest_growth * start_arc_.length_mm : transition_size(previous_end_, begin)});
    refine(graded, segment.begin_mm, segment.end_mm, begin, end, 0);
    if (segment.last)
        graded.nodes.back().size_mm = std::min(graded.nodes.back().size_mm, rest_growth * stop_arc_.length_mm);
    previous_end_ = end;
    pending_mm_ += segment.end_mm - segment.begin_mm;
}

void Grid::look_ahead() {
    const auto length_of_front = [this] {
        const Segment& front = pending_.front().segment;
        return front.end_mm - front.begin_mm;
    };
    while (next_ && (pending_.empty() || pending_mm_ - length_of_front() < 2 * look_ahead_mm)) {
        take(*next_);
        next_ = cutter_.next();
    }
}

/// Limits the growth of the sizes per mm from everywhere, and lays the cells of what nothing ahead can change any more.
void Grid::settle() {
    const auto limit = [](double by, Node& node) { node.size_mm = std::min(node.size_mm, by); };
    const Node* before = &settled_;
    double from_rest = from_rest_mm_;
    for (Graded& graded : pending_)
        for (Node& node : graded.nodes) {
            const double step = &node == &graded.nodes.front() ? 0 : node.offset_mm - before->offset_mm;
            from_rest += step;
            limit(before->size_mm + growth * step, node);
            limit(rest_growth * from_rest, node);
            before = &node;
        }
    const Node* behind = nullptr;
    double to_rest = next_ ? std::numeric_limits<double>::infinity() : stop_arc_.length_mm;
    for (std::size_t g = pending_.size(); g-- > 0;)
        for (std::size_t k = pending_[g].nodes.size(); k-- > 0;) {
            Node& node = pending_[g].nodes[k];
            const double step = k + 1 == pending_[g].nodes.size() ? 0 : behind->offset_mm - node.offset_mm;
            to_rest += step;
            if (behind) limit(behind->size_mm + growth * step, node);
            limit(rest_growth * to_rest, node);
            behind = &node;
        }
    while (!pending_.empty()) {
        const Segment& front = pending_.front().segment;
        const double length = front.end_mm - front.begin_mm;
        if (next_ && pending_mm_ - length < look_ahead_mm) return;
        lay(pending_.front());
        settled_ = pending_.front().nodes.back();
        from_rest_mm_ += length;
        pending_mm_ -= length;
        pending_.pop_front();
    }
    cells_.push_back(stop_arc_);
}

void Grid::lay(const Graded& graded) {
    const Segment& s = graded.segment;
    const auto& nodes = graded.nodes;
    const auto ramp = [&](std::size_t k) {
        return Ramp{nodes[k + 1].offset_mm - nodes[k].offset_mm, nodes[k].size_mm, nodes[k + 1].size_mm};
    };
    const std::size_t end = nodes.size() - 1;
    double total = 0;
    for (std::size_t k = 0; k < end; ++k) total += ramp(k).count();
    const std::size_t cells = static_cast<std::size_t>(std::max(1.0, std::ceil(total - rounding_down)));
    double from = s.begin_mm, done = 0;
    std::size_t leaf = 0;
    for (std::size_t i = 1; i <= cells; ++i) {
        const double wanted = total * static_cast<double>(i) / static_cast<double>(cells);
        while (leaf + 1 < end && done + ramp(leaf).count() < wanted) done += ramp(leaf++).count();
        const double to = i == cells ? s.end_mm : nodes[leaf].offset_mm + ramp(leaf).at(wanted - done);
        if (!(to > from)) continue;
        cells_.push_back({{s.piece, from}, to - from, s.block});
        from = to;
    }
}

std::optional<Cell> Grid::next() {
    while (cells_.empty()) {
        if (!next_ && pending_.empty()) return std::nullopt;
        look_ahead();
        settle();
    }
    const Cell out = cells_.front();
    cells_.pop_front();
    return out;
}

namespace {

constexpr double told_to = 2e-4;  // of a limit
constexpr double steepest = 3.43;
constexpr int most_halvings = 5;

Diagnostic at_cell(const path::AxisPath& path, const Cell& cell, std::string code, std::string text) {
    Diagnostic out;
    out.code = std::move(code);
    out.text = std::move(text);
    out.place.path_length_mm = path.tool_path().pieces[cell.begin.piece].begin_mm + cell.begin.offset_mm;
    if (!path.tool_path().blocks.empty()) out.place.line = path.tool_path().blocks[cell.block].line;
    return out;
}

Cell part_of(const Cell& cell, double from, double length) {
    return {{cell.begin.piece, cell.begin.offset_mm + from}, length, cell.block, cell.from_rest, cell.to_rest};
}

/// Where the chord error bounds the speed more than the feed does, the largest rate of both takes the feed's place on
/// the whole interval: nobody knows its derivatives.
void add_chord(const std::array<double, samples_per_interval>& chord, Interval& interval) {
    double rate = 0;
    for (int i = 0; i < samples_per_interval; ++i) {
        interval.chord = interval.chord || chord[i] > interval.samples[i].q1[programmed_feed];
        rate = std::max({rate, chord[i], interval.samples[i].q1[programmed_feed]});
    }
    if (!interval.chord) return;
    for (PathSample& s : interval.samples) {
        s.q1[programmed_feed] = rate;
        s.q2[programmed_feed] = s.q3[programmed_feed] = 0;
    }
}

/// Distances from the standstill at which an arc is sampled: evenly, and ever closer to it.
std::vector<double> arc_places(double length) {
    std::vector<double> out{0};
    const double part = length / arc_parts;
    for (double u = part; u > nearest_to_rest * length; u /= near_rest_step) out.push_back(u);
    std::ranges::reverse(out.begin() + 1, out.end());
    for (int k = 2; k <= arc_parts; ++k) out.push_back(k * part);
    return out;
}

Sampler::Place at(const Sampler& sampler, const Cell& cell, double way_mm) {
    return sampler.at({cell.begin.piece, cell.begin.offset_mm + way_mm}, cell.block);
}

/// The error of a quintic, e s³(1 − s)³, is largest in its middle, that of its slope beside it (3.43 e/h); those of one
/// over half the way are 2⁻⁶ of it, 2⁻⁵ in the first derivative and 2⁻⁴ in the second.
bool is_told(const Cell& cell, const PathSample& begin, const PathSample& middle, const PathSample& end,
             const LimitSet& limits) {
    const double h = cell.length_mm;
    const Extent extent = largest_motion(middle, limits);
    for (int c = 0; c < coordinates; ++c) {
        const auto f = quintic(begin.q1[c], begin.q2[c], begin.q3[c], end.q1[c], end.q2[c], end.q3[c], h);
        const auto d1 = derivative(f, h);
        const auto d2 = derivative(d1, h);
        const double error = std::abs(middle_of(f) - middle.q1[c]), slope = std::abs(middle_of(d1) - middle.q2[c]);
        const double e1 = error / 64, e2 = std::max(slope, steepest * error / h) / 32,
                     e3 = std::abs(middle_of(d2) - middle.q3[c]) / 16;
        const machine::AxisLimits& limit = limits.of[c];
        const double root = std::sqrt(extent.x);
        if (e1 * root > told_to * limit.velocity ||
            e2 * extent.x + 0.5 * e1 * extent.d > told_to * limit.acceleration ||
            (e3 * extent.x + 1.5 * e2 * extent.d) * root > told_to * limit.jerk)
            return false;
    }
    return true;
}

Result<Interval> interval_of(const Sampler& sampler, const Cell& cell, const Sampler::Place& begin,
                             const Sampler::Place& middle, const Sampler::Place& end) {
    const std::array<const Sampler::Place*, samples_per_interval> places{&begin, &middle, &end};
    Interval out;
    out.begin = cell.begin;
    out.length_mm = cell.length_mm;
    std::array<double, samples_per_interval> chord{};
    for (int i = 0; i < samples_per_interval; ++i) {
        out.samples[i] = places[i]->sample;
        chord[i] = places[i]->chord_rate;
    }
    if (!std::ranges::all_of(out.samples, is_finite))
        return fail(at_cell(sampler.path(), cell, "FEED0002", "the path has no finite derivatives here"));
    if (sampler.has_chord_error()) add_chord(chord, out);
    if (!cell.from_rest && !cell.to_rest) return out;
    for (const double u : arc_places(cell.length_mm)) {
        Sampler::Place place = at(sampler, cell, cell.from_rest ? u : cell.length_mm - u);
        place.sample.q1[programmed_feed] = std::max(place.sample.q1[programmed_feed], place.chord_rate);
        out.arc.push_back({u, place.sample});
    }
    return out;
}

}  // namespace

Result<Interval> sample_cell(const Sampler& sampler, const Cell& cell) {
    return interval_of(sampler, cell, at(sampler, cell, 0), at(sampler, cell, cell.length_mm / 2),
                       at(sampler, cell, cell.length_mm));
}

/// One path piece follows the other without a jump.
Result<void> CellSampler::check_joint(const Cell& cell, const Sampler::Place& begin) const {
    constexpr double slack = 1e-6;  // mm, rad
    for (int a = 0; any_ && a < sampler_.path().axis_count(); ++a) {
        if (std::abs(begin.position[a] - last_.position[a]) <= slack) continue;
        Diagnostic out = at_cell(sampler_.path(), cell, "FEED0009", "the path jumps here");
        out.value = fmt::format("{:.6g}", begin.position[a] - last_.position[a]);
        return fail(out);
    }
    return {};
}

Result<void> CellSampler::sample(const Cell& cell, std::deque<SampledCell>& out) {
    const bool goes_on = any_ && last_place_.piece == cell.begin.piece && last_block_ == cell.block;
    const Sampler::Place begin = goes_on ? last_ : at(sampler_, cell, 0), end = at(sampler_, cell, cell.length_mm);
    if (!goes_on)
        if (auto joined = check_joint(cell, begin); !joined) return joined;
    last_ = end;
    last_place_ = cell.begin;
    last_block_ = cell.block;
    any_ = true;
    return sample(cell, begin, end, 0, out);
}

Result<void> CellSampler::sample(const Cell& cell, const Sampler::Place& begin, const Sampler::Place& end, int halvings,
                                 std::deque<SampledCell>& out) {
    const double half = cell.length_mm / 2;
    const Sampler::Place middle = at(sampler_, cell, half);
    auto interval = interval_of(sampler_, cell, begin, middle, end);
    if (!interval) return fail(interval.error());
    if (!cell.from_rest && !cell.to_rest && halvings < most_halvings &&
        !is_told(cell, begin.sample, middle.sample, end.sample, sampler_.limits())) {
        if (auto first = sample(part_of(cell, 0, half), begin, middle, halvings + 1, out); !first) return first;
        return sample(part_of(cell, half, cell.length_mm - half), middle, end, halvings + 1, out);
    }
    out.push_back({cell, std::move(*interval)});
    return {};
}

}  // namespace trunnion::feed
