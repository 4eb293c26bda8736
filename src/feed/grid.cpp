#include "detail/grid.hpp"

#include <algorithm>
#include <cmath>

#include "trunnion/feed/plan_stretch.hpp"

#include "detail/rest_arc.hpp"

namespace trunnion::feed {
namespace {

using path::AxisPath;
using path::AxisSample;

constexpr double turn_tolerance =
    0.004;  // how far q′ may bend from its chord within an interval, of the leading axis' q′
constexpr double arc_turn_tolerance = 0.05;  // the same of a rest arc, whose samples must see the bend
constexpr double largest_mm = 5;
constexpr double growth = 0.4;        // of the size per mm: neighbours differ by up to e^0.4
constexpr double rest_growth = 0.14;  // ln 1.15
// An arc must be short beside the way to the next corner: the speed turns down again long before it.
constexpr double arc_share_of_path = 0.01, arc_share_of_segment = 0.04;
constexpr int shortest_arc_steps = 80, most_straightening_steps = 20;
constexpr double intervals_of_transition = 8;
constexpr int least_halvings = 1, deepest_halving = 36;
constexpr double nearest_to_rest = 1e-6, near_rest_step = 1.25;
constexpr double rounding_down = 0.3;  // a stretch of 1.3 sizes is still one interval

/// A part of one path piece under one feed.
struct Segment {
    std::size_t piece = 0;
    double begin_mm = 0, end_mm = 0;
    std::size_t block = 0;
};

/// The wished interval size at a place.
struct Node {
    double offset_mm = 0, size_mm = 0;
};

bool same_feed(const path::BlockSpan& a, const path::BlockSpan& b) {
    if (!(a.feed.rule == b.feed.rule)) return false;
    if (a.feed.rule != path::FeedRule::block_time) return a.feed.value == b.feed.value;
    return a.feed.value * b.time_scale_mm == b.feed.value * a.time_scale_mm;
}

PathSample sample_of(const AxisSample& at, const path::BlockSpan* block, int axes) {
    PathSample out;
    for (int a = 0; a < axes; ++a) {
        out.q1[a] = at.axes[a].d1();
        out.q2[a] = at.axes[a].d2();
        out.q3[a] = at.axes[a].d3();
    }
    if (block) {
        const double speed = feed_speed_cap(*block, at);
        out.feed_cap = speed * speed;
    }
    return out;
}

class Gridder {
  public:
    Gridder(const AxisPath& path, const LimitSet& limits) : path_(path), limits_(limits) {}

    std::vector<Cell> make() {
        cut();
        take_arcs();
        for (std::size_t i = 0; i < segments_.size(); ++i) add_nodes(i);
        limit_growth();
        std::vector<Cell> cells{start_arc_};
        for (std::size_t i = 0; i < segments_.size(); ++i) lay(i, cells);
        cells.push_back(stop_arc_);
        return cells;
    }

  private:
    void cut();
    void take_arcs();
    double arc_length(const Segment& within, RestSide side) const;
    PathSample sample(std::size_t piece, double offset, std::size_t block) const;
    void add_nodes(std::size_t segment);
    void refine(const Segment& s, double begin, double end, const PathSample& at_begin, const PathSample& at_end,
                int depth);
    bool bends(const PathSample& a, const PathSample& m, const PathSample& b, double length, double tolerance) const;
    double transition_size(const PathSample& before, const PathSample& after) const;
    double speed_cap(const PathSample& s) const;
    void limit_growth();
    void lay(std::size_t segment, std::vector<Cell>& out) const;

    const AxisPath& path_;
    const LimitSet& limits_;
    std::vector<Segment> segments_;
    std::vector<std::size_t> first_node_;  // of every segment, and the end
    std::vector<Node> nodes_;
    PathSample previous_end_;
    Cell start_arc_, stop_arc_;
};

PathSample Gridder::sample(std::size_t piece, double offset, std::size_t block) const {
    AxisSample at;
    path_.evaluate({piece, offset}, at);
    const auto& blocks = path_.tool_path().blocks;
    return sample_of(at, blocks.empty() ? nullptr : &blocks[block], limits_.count);
}

/// Cuts the path where a piece begins, where a station is, and where the feed changes.
void Gridder::cut() {
    const path::ToolPath& tool = path_.tool_path();
    std::size_t block = 0, station = 0;
    const auto& stations = path_.stations();
    for (std::size_t i = 0; i < tool.pieces.size(); ++i) {
        const double length = tool.pieces[i].length_mm, begin = tool.pieces[i].begin_mm,
                     slack = std::min(1e-7, 1e-4 * length);
        double at = 0;
        const auto cut_at = [&](double offset, std::size_t of_block) {
            if (offset <= at + slack) return;
            if (offset > length - slack) offset = length;
            segments_.push_back({i, at, offset, of_block});
            at = offset;
        };
        while (at < length) {
            while (block + 1 < tool.blocks.size() && tool.blocks[block].end_mm - begin <= at + slack) ++block;
            while (station < stations.size() &&
                   (stations[station].piece < i ||
                    (stations[station].piece == i && stations[station].offset_mm <= at + slack)))
                ++station;
            std::size_t last = block;
            while (last + 1 < tool.blocks.size() && tool.blocks[last].end_mm - begin < length &&
                   same_feed(tool.blocks[last], tool.blocks[last + 1]))
                ++last;
            double next = last + 1 < tool.blocks.size() ? tool.blocks[last].end_mm - begin : length;
            if (station < stations.size() && stations[station].piece == i)
                next = std::min(next, stations[station].offset_mm);
            cut_at(std::min(next, length), block);
        }
    }
}

/// As long as constant path jerk is nearly the optimum.
double Gridder::arc_length(const Segment& within, RestSide side) const {
    const bool start = side == RestSide::start;
    const auto at = [&](double u) {
        return sample(within.piece, start ? within.begin_mm + u : within.end_mm - u, within.block);
    };
    const PathSample rest = at(0);
    const double alpha = rest_alpha(rest, limits_);
    double length =
        std::min(arc_share_of_path * path_.length_mm(), arc_share_of_segment * (within.end_mm - within.begin_mm));
    for (int k = 0; k < shortest_arc_steps && !is_jerk_phase(at(length), length, side, limits_, alpha); ++k)
        length *= 0.7;
    const auto turns = [&](double arc) {
        return bends(rest, at(arc / 2), at(arc), start ? arc : -arc, arc_turn_tolerance);
    };
    double straighter = length;
    for (int k = 0; k < most_straightening_steps && turns(straighter); ++k) straighter *= 0.7;
    return turns(straighter) ? length : straighter;  // at the pole itself no arc is short enough
}

void Gridder::take_arcs() {
    Segment& first = segments_.front();
    const double start = arc_length(first, RestSide::start), stop = arc_length(segments_.back(), RestSide::stop);
    start_arc_ = {{first.piece, first.begin_mm}, start, first.block, true, false};
    first.begin_mm += start;
    Segment& last = segments_.back();
    last.end_mm -= stop;
    stop_arc_ = {{last.piece, last.end_mm}, stop, last.block, false, true};
}

double Gridder::speed_cap(const PathSample& s) const {
    double inverse = 1 / std::sqrt(s.feed_cap);
    for (int a = 0; a < limits_.count; ++a) inverse = std::max(inverse, std::abs(s.q1[a]) / limits_.axes[a].velocity);
    return 1 / inverse;
}

/// Interval size that resolves the change from one allowed speed to another.
double Gridder::transition_size(const PathSample& before, const PathSample& after) const {
    const double v0 = speed_cap(before), v1 = speed_cap(after), change = std::abs(v1 - v0);
    if (!(change > 1e-3 * std::max(v0, v1)) || !std::isfinite(v0 + v1)) return largest_mm;
    double jerk = std::numeric_limits<double>::max(), acceleration = jerk;
    for (int a = 0; a < limits_.count; ++a) {
        const double q = std::abs(after.q1[a]);
        if (q == 0) continue;
        jerk = std::min(jerk, limits_.axes[a].jerk / q);
        acceleration = std::min(acceleration, limits_.axes[a].acceleration / q);
    }
    const double time = std::max(2 * std::sqrt(change / jerk), change / acceleration);
    return (v0 + v1) / 2 * time / intervals_of_transition;
}

void Gridder::add_nodes(std::size_t index) {
    const Segment& s = segments_[index];
    const PathSample begin = sample(s.piece, s.begin_mm, s.block), end = sample(s.piece, s.end_mm, s.block);
    first_node_.push_back(nodes_.size());
    nodes_.push_back(
        {s.begin_mm, index == 0 ? rest_growth * start_arc_.length_mm : transition_size(previous_end_, begin)});
    refine(s, s.begin_mm, s.end_mm, begin, end, 0);
    if (index + 1 == segments_.size())
        nodes_.back().size_mm = std::min(nodes_.back().size_mm, rest_growth * stop_arc_.length_mm);
    previous_end_ = end;
}

/// Whether an axis that matters turns so much that one cubic x(p) could not follow.
bool Gridder::bends(const PathSample& a, const PathSample& m, const PathSample& b, double length,
                    double tolerance) const {
    double bend_j = 0, lead_j = 0, bend_v = 0, lead_v = 0;
    for (int i = 0; i < limits_.count; ++i) {
        const double per_jerk = 1 / limits_.axes[i].jerk, per_velocity = 1 / limits_.axes[i].velocity;
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

void Gridder::refine(const Segment& s, double begin, double end, const PathSample& at_begin, const PathSample& at_end,
                     int depth) {
    const double middle = (begin + end) / 2;
    const PathSample at_middle = sample(s.piece, middle, s.block);
    if (depth < deepest_halving &&
        (depth < least_halvings || bends(at_begin, at_middle, at_end, end - begin, turn_tolerance))) {
        refine(s, begin, middle, at_begin, at_middle, depth + 1);
        return refine(s, middle, end, at_middle, at_end, depth + 1);
    }
    const double size = std::min(end - begin, largest_mm);
    nodes_.back().size_mm = std::min(nodes_.back().size_mm, size);
    nodes_.push_back({end, size});
}

/// The size may grow by so much per mm, from everywhere.
void Gridder::limit_growth() {
    first_node_.push_back(nodes_.size());
    const auto step = [&](std::size_t k) { return std::max(nodes_[k].offset_mm - nodes_[k - 1].offset_mm, 0.0); };
    const auto pass_on = [&](double from, double way, Node& to) {
        to.size_mm = std::min(to.size_mm, from + growth * way);
    };
    for (std::size_t k = 1; k < nodes_.size(); ++k) pass_on(nodes_[k - 1].size_mm, step(k), nodes_[k]);
    for (std::size_t k = nodes_.size() - 1; k > 0; --k) pass_on(nodes_[k].size_mm, step(k), nodes_[k - 1]);
    double from_rest = start_arc_.length_mm;
    for (std::size_t k = 0; k < nodes_.size(); ++k) {
        if (k > 0) from_rest += step(k);
        nodes_[k].size_mm = std::min(nodes_[k].size_mm, rest_growth * from_rest);
    }
    double to_rest = stop_arc_.length_mm;
    for (std::size_t k = nodes_.size(); k-- > 0;) {
        nodes_[k].size_mm = std::min(nodes_[k].size_mm, rest_growth * to_rest);
        if (k > 0) to_rest += step(k);
    }
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

void Gridder::lay(std::size_t index, std::vector<Cell>& out) const {
    const Segment& s = segments_[index];
    const auto ramp = [&](std::size_t k) {
        return Ramp{nodes_[k + 1].offset_mm - nodes_[k].offset_mm, nodes_[k].size_mm, nodes_[k + 1].size_mm};
    };
    const std::size_t begin = first_node_[index], end = first_node_[index + 1] - 1;
    double total = 0;
    for (std::size_t k = begin; k < end; ++k) total += ramp(k).count();
    const std::size_t cells = static_cast<std::size_t>(std::max(1.0, std::ceil(total - rounding_down)));
    double from = s.begin_mm, done = 0;
    std::size_t leaf = begin;
    for (std::size_t i = 1; i <= cells; ++i) {
        const double wanted = total * static_cast<double>(i) / static_cast<double>(cells);
        while (leaf + 1 < end && done + ramp(leaf).count() < wanted) done += ramp(leaf++).count();
        const double to = i == cells ? s.end_mm : nodes_[leaf].offset_mm + ramp(leaf).at(wanted - done);
        if (!(to > from)) continue;
        out.push_back({{s.piece, from}, to - from, s.block});
        from = to;
    }
}

}  // namespace

namespace {

bool is_finite(const PathSample& s) {
    double sum = 0;
    for (int a = 0; a < machine::max_axes; ++a) sum += s.q1[a] + s.q2[a] + s.q3[a];
    return std::isfinite(sum) && s.feed_cap > 0;
}

Diagnostic not_finite(const AxisPath& path, const Cell& cell) {
    Diagnostic out;
    out.code = "FEED0002";
    out.text = "the path has no finite derivatives, or no feed, here";
    out.place.path_length_mm = path.tool_path().pieces[cell.begin.piece].begin_mm + cell.begin.offset_mm;
    if (!path.tool_path().blocks.empty()) out.place.line = path.tool_path().blocks[cell.block].line;
    return out;
}

}  // namespace

std::vector<Cell> make_grid(const AxisPath& path, const LimitSet& limits) {
    return Gridder(path, limits).make();
}

Result<Interval> sample_cell(const AxisPath& path, const Cell& cell) {
    Interval out;
    out.begin = cell.begin;
    out.length_mm = cell.length_mm;
    const auto& blocks = path.tool_path().blocks;
    bool finite = true;
    const auto sample = [&](double way_mm) {
        AxisSample at;
        path.evaluate({cell.begin.piece, cell.begin.offset_mm + way_mm}, at);
        const PathSample taken = sample_of(at, blocks.empty() ? nullptr : &blocks[cell.block], path.axis_count());
        finite = finite && is_finite(taken);
        return taken;
    };
    for (int i = 0; i < samples_per_interval; ++i)
        out.samples[i] = sample(cell.length_mm * i / (samples_per_interval - 1));
    if (cell.from_rest || cell.to_rest)
        for (double u = cell.length_mm / (samples_per_interval - 1); u > nearest_to_rest * cell.length_mm;
             u /= near_rest_step)
            out.near_rest.push_back({u, sample(cell.from_rest ? u : cell.length_mm - u)});
    if (!finite) return fail(not_finite(path, cell));
    return out;
}

}  // namespace trunnion::feed
