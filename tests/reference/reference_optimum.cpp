#include "reference_optimum.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <ClpSimplex.hpp>
#include <CoinPackedVector.hpp>

namespace trunnion::reference {
namespace {

constexpr double first_arc_share = 2e-4;  // of the length: where the arcs at rest end
constexpr int samples_per_piece = 400;
constexpr double listed_from = 0.3;  // rows that use less of their limit are only checked afterwards

using Axes = std::array<double, machine::max_axes>;

struct Node {
    double p = 0;
    Axes q1{}, q2{}, q3{};  // divided by nothing
    double cap = 0;         // of x
};

/// One row |a·x| ≤ limit side by side over three neighbouring nodes (i − 1, i, i + 1).
struct Row {
    int node = 0;
    double before = 0, at = 0, behind = 0;
    bool jerk = false;
    bool stiffest = false;  // of its node: what holds x″ there; without it a programme zigzags
};

class Sequence {
  public:
    Sequence(const path::AxisPath& path, const Options& options) : path_(path), options_(options) {
        for (int a = 0; a < path.axis_count(); ++a) {
            limits_[a] = path.tool_path().rapid ? path.machine().axes[a].rapid : path.machine().axes[a].feed;
            limits_[a].jerk *= options.jerk_factor;
        }
        place_nodes();
        bound_ends();
        for (int i = 1; i + 1 < count(); ++i) add_rows(i);
    }

    Optimum solve() {
        start();
        Optimum out;
        double radius = 3, best = time(x_);
        for (; out.rounds < options_.max_rounds; ++out.rounds) {
            const std::vector<double> next = step(radius);
            const double found = next.empty() ? best : time(next);
            const double gain = (best - found) / best;
            if (gain > 0) {
                x_ = next;
                best = found;
            }
            if (gain < 1e-3 * (radius - 1)) radius = 1 + (radius - 1) / 2;
            if (gain < options_.relative_gain && radius < 1.01) {
                out.converged = true;
                break;
            }
        }
        out.time_s = best;
        return out;
    }

  private:
    int count() const { return static_cast<int>(nodes_.size()); }
    Node sample(double p) const;
    void place_nodes();
    void bound_ends();
    void add_rows(int i);
    void start();
    double time(const std::vector<double>& x) const;
    double use(const Row& row, const std::vector<double>& x) const;
    std::vector<double> step(double radius) const;

    const path::AxisPath& path_;
    Options options_;
    std::array<machine::AxisLimits, machine::max_axes> limits_{};
    std::vector<Node> nodes_;  // the first and the last one stand still
    std::vector<Row> rows_;
    std::vector<double> x_;
};

Node Sequence::sample(double p) const {
    const auto& pieces = path_.tool_path().pieces;
    const auto& blocks = path_.tool_path().blocks;
    const auto next = std::upper_bound(pieces.begin() + 1, pieces.end(), p,
                                       [](double at, const auto& piece) { return at < piece.begin_mm; });
    const auto piece = next - 1;
    path::AxisSample s;
    path_.evaluate(
        {static_cast<std::size_t>(piece - pieces.begin()), std::clamp(p - piece->begin_mm, 0.0, piece->length_mm)}, s);
    Node out;
    out.p = p;
    double inverse = 1e-12;
    for (int a = 0; a < path_.axis_count(); ++a) {
        out.q1[a] = s.axes[a].d1();
        out.q2[a] = s.axes[a].d2();
        out.q3[a] = s.axes[a].d3();
        inverse = std::max(inverse, std::pow(out.q1[a] / limits_[a].velocity, 2));
    }
    const auto block =
        std::lower_bound(blocks.begin(), blocks.end() - 1, p, [](const auto& b, double at) { return b.end_mm < at; });
    if (block->feed.rule == path::FeedRule::tip_speed)
        inverse = std::max(inverse, std::pow(s.feed_rate / block->feed.value, 2));
    if (block->feed.rule == path::FeedRule::rotary_rate)
        inverse = std::max(inverse, std::pow(s.turn_rate / block->feed.value, 2));
    if (block->feed.rule == path::FeedRule::block_time)
        inverse = std::max(inverse, std::pow(block->feed.value / block->time_scale_mm, 2));
    out.cap = 1 / inverse;
    return out;
}

/// Nodes densely where the axes turn and near the rest points.
void Sequence::place_nodes() {
    const double length = path_.length_mm(), arc = first_arc_share * length;
    std::vector<double> at{arc}, sum{0};
    const auto density = [&](double p) {
        const Node s = sample(p);
        double turn = 0, lead = 1e-300;
        for (int a = 0; a < path_.axis_count(); ++a) {
            turn = std::max(turn, std::abs(s.q2[a]) / limits_[a].jerk);
            lead = std::max(lead, std::abs(s.q1[a]) / limits_[a].jerk);
        }
        const double rest = 1 / p + 1 / (length - p);
        return 12 / length + 1.2 * rest + 8 * std::min(turn / lead, 1e4 / length);
    };
    for (const path::PathPiece& piece : path_.tool_path().pieces)
        for (int k = 1; k <= samples_per_piece; ++k) {
            const double p = std::min(piece.begin_mm + piece.length_mm * k / samples_per_piece, length - arc);
            if (p <= at.back()) continue;
            sum.push_back(sum.back() + (p - at.back()) * density((p + at.back()) / 2));
            at.push_back(p);
        }
    nodes_.push_back(sample(0));
    std::size_t k = 0;
    for (int i = 0; i <= options_.nodes; ++i) {
        const double wanted = sum.back() * i / options_.nodes;
        while (k + 2 < sum.size() && sum[k + 1] < wanted) ++k;
        const double part = std::clamp((wanted - sum[k]) / (sum[k + 1] - sum[k]), 0.0, 1.0);
        nodes_.push_back(sample(at[k] + part * (at[k + 1] - at[k])));
    }
    nodes_.push_back(sample(length));
}

/// x at the ends of the arcs: constant path jerk j has x = (6u)^(4/3) j^(2/3)/4.
void Sequence::bound_ends() {
    for (const bool first : {true, false}) {
        const Node& rest = first ? nodes_.front() : nodes_.back();
        Node& joint = first ? nodes_[1] : nodes_[nodes_.size() - 2];
        double jerk = std::numeric_limits<double>::max();
        for (int a = 0; a < path_.axis_count(); ++a)
            if (rest.q1[a] != 0) jerk = std::min(jerk, limits_[a].jerk / std::abs(rest.q1[a]));
        const double u = std::abs(joint.p - rest.p);
        joint.cap = std::min(joint.cap, std::pow(6 * u, 4.0 / 3) / 4 * std::pow(jerk, 2.0 / 3));
    }
}

void Sequence::add_rows(int i) {
    const Node& n = nodes_[i];
    const double left = n.p - nodes_[i - 1].p, right = nodes_[i + 1].p - n.p;
    // x′ and x″ as combinations of the three nodes; next to an arc its own slope ±4/3 x/u takes the place of a
    // difference.
    std::array<double, 3> d{}, e{};
    if (i == 1) {
        d = {0, 4 / (3 * left), 0};
        e = {0, -2 / right * (1 / right + d[1]), 2 / (right * right)};
    } else if (i + 2 == count()) {
        d = {0, -4 / (3 * right), 0};
        e = {2 / (left * left), -2 / left * (1 / left - d[1]), 0};
    } else {
        const double both = left + right;
        d = {-right / (left * both), right / (left * both) - left / (right * both), left / (right * both)};
        e = {2 / (left * both), -2 / (left * right), 2 / (right * both)};
    }
    for (int a = 0; a < path_.axis_count(); ++a) {
        if (n.q1[a] == 0 && n.q2[a] == 0 && n.q3[a] == 0) continue;
        const auto row = [&](double v, double by_d, double by_e, double limit, bool jerk) {
            rows_.push_back({i, (by_d * d[0] + by_e * e[0]) / limit, (v + by_d * d[1] + by_e * e[1]) / limit,
                             (by_d * d[2] + by_e * e[2]) / limit, jerk, false});
        };
        row(n.q2[a], n.q1[a] / 2, 0, limits_[a].acceleration, false);
        row(n.q3[a], 1.5 * n.q2[a], n.q1[a] / 2, limits_[a].jerk, true);
    }
    const auto first = std::find_if(rows_.begin(), rows_.end(), [i](const Row& r) { return r.node == i; });
    if (first == rows_.end()) return;
    std::max_element(first, rows_.end(), [](const Row& a, const Row& b) {
        return std::abs(a.at) * a.jerk < std::abs(b.at) * b.jerk;
    })->stiffest = true;
}

/// What a row uses of its limit.
double Sequence::use(const Row& row, const std::vector<double>& x) const {
    const double load = std::abs(row.before * x[row.node - 1] + row.at * x[row.node] + row.behind * x[row.node + 1]);
    return row.jerk ? load * std::sqrt(x[row.node]) : load;
}

/// A smooth hump, slow enough to be feasible.
void Sequence::start() {
    const double length = path_.length_mm();
    x_.assign(nodes_.size(), 0);
    for (int i = 1; i + 1 < count(); ++i) x_[i] = std::pow(nodes_[i].p * (length - nodes_[i].p) / length, 4.0 / 3);
    double factor = std::numeric_limits<double>::max();
    for (int i = 1; i + 1 < count(); ++i) factor = std::min(factor, nodes_[i].cap / x_[i]);
    for (const Row& row : rows_) {
        const double used = use(row, x_);
        if (used > 0) factor = std::min(factor, row.jerk ? std::pow(used, -2.0 / 3) : 1 / used);
    }
    for (double& x : x_) x *= 0.98 * factor;
}

double Sequence::time(const std::vector<double>& x) const {
    double total = 3 * (nodes_[1].p - nodes_[0].p) / std::sqrt(x[1]) +
                   3 * (nodes_.back().p - nodes_[count() - 2].p) / std::sqrt(x[count() - 2]);
    for (int i = 1; i + 2 < count(); ++i)
        total += 2 * (nodes_[i + 1].p - nodes_[i].p) / (std::sqrt(x[i]) + std::sqrt(x[i + 1]));
    return total;
}

/// One linear programme in y = x/x_k; empty when CLP finds no solution.
std::vector<double> Sequence::step(double radius) const {
    const int n = count() - 2;
    ClpSimplex lp;
    lp.setLogLevel(0);
    lp.resize(0, n);
    for (int i = 1; i <= n; ++i) {
        const double h0 = i == 1 ? 6 * (nodes_[1].p - nodes_[0].p) : nodes_[i].p - nodes_[i - 1].p;
        const double h1 = i == n ? 6 * (nodes_[n + 1].p - nodes_[n].p) : nodes_[i + 1].p - nodes_[i].p;
        lp.setObjectiveCoefficient(i - 1, -0.25 * (h0 + h1) / std::sqrt(x_[i]));
        lp.setColumnBounds(i - 1, 1 / radius, std::min(radius, nodes_[i].cap / x_[i]));
    }
    const auto list = [&](const Row& row) {
        for (const double sign : {1.0, -1.0}) {
            const double scale = row.jerk ? sign * std::sqrt(x_[row.node]) : sign;
            CoinPackedVector v;
            const double values[3] = {row.before * x_[row.node - 1], row.at * x_[row.node],
                                      row.behind * x_[row.node + 1]};
            for (int k = 0; k < 3; ++k) {
                const double extra = row.jerk && k == 1 ? 0.5 : 0;
                if (row.node - 2 + k >= 0 && row.node - 2 + k < n)
                    v.insert(row.node - 2 + k, scale * values[k] + extra);
            }
            lp.addRow(v.getNumElements(), v.getIndices(), v.getElements(), -COIN_DBL_MAX, row.jerk ? 1.5 : 1.0);
        }
    };
    std::vector<bool> listed(rows_.size());
    for (std::size_t r = 0; r < rows_.size(); ++r) listed[r] = rows_[r].stiffest || use(rows_[r], x_) > listed_from;
    for (std::size_t r = 0; r < rows_.size(); ++r)
        if (listed[r]) list(rows_[r]);
    for (int again = 0; again < 60; ++again) {
        again == 0 ? lp.initialSolve() : lp.dual();
        if (lp.status() != 0) return {};
        std::vector<double> next(x_.size());
        for (int i = 1; i <= n; ++i) next[i] = x_[i] * lp.primalColumnSolution()[i - 1];
        bool complete = true;
        for (std::size_t r = 0; r < rows_.size(); ++r) {
            if (listed[r] || use(rows_[r], next) <= 1 + 1e-9) continue;
            list(rows_[r]);
            listed[r] = true;
            complete = false;
        }
        if (complete) return next;
    }
    return {};
}

}  // namespace

Optimum reference_optimum(const path::AxisPath& path, const Options& options) {
    return Sequence(path, options).solve();
}

}  // namespace trunnion::reference
