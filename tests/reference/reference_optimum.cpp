#include "reference_optimum.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <ClpSimplex.hpp>

namespace trunnion::reference {
namespace {

constexpr int samples_per_piece = 64;
constexpr double listed_from = 0.5;  // rows that use less of their limit are only checked afterwards
constexpr int coarsest = 100;        // nodes of the first level

using Axes = std::array<double, machine::max_axes>;

struct Place {
    double p = 0;
    Axes q1{}, q2{}, q3{};
    double cap = 0;  // of x
};

/// The path by p alone, with this stretch's limits.
class Course {
  public:
    Course(const path::AxisPath& path, double jerk_factor) : path_(path) {
        for (int a = 0; a < axes(); ++a) {
            limits_[a] = path.tool_path().rapid ? path.machine().axes[a].rapid : path.machine().axes[a].feed;
            limits_[a].jerk *= jerk_factor;
        }
    }
    int axes() const { return path_.axis_count(); }
    double length() const { return path_.length_mm(); }
    /// Length of the arcs at rest: so short that nothing is lost by their constant jerk.
    double arc() const { return std::min(2e-4 * length(), 0.02); }
    const path::ToolPath& tool_path() const { return path_.tool_path(); }
    const machine::AxisLimits& limit(int axis) const { return limits_[axis]; }
    Place at(double p) const;

  private:
    double inverse_cap(const path::AxisSample& s, double p) const;

    const path::AxisPath& path_;
    std::array<machine::AxisLimits, machine::max_axes> limits_{};
};

Place Course::at(double p) const {
    const auto& pieces = tool_path().pieces;
    const auto next = std::upper_bound(pieces.begin() + 1, pieces.end(), p,
                                       [](double where, const auto& piece) { return where < piece.begin_mm; });
    const auto piece = next - 1;
    path::AxisSample s;
    path_.evaluate(
        {static_cast<std::size_t>(piece - pieces.begin()), std::clamp(p - piece->begin_mm, 0.0, piece->length_mm)}, s);
    Place out;
    out.p = p;
    for (int a = 0; a < axes(); ++a) {
        out.q1[a] = s.axes[a].d1();
        out.q2[a] = s.axes[a].d2();
        out.q3[a] = s.axes[a].d3();
    }
    out.cap = 1 / inverse_cap(s, p);
    return out;
}

double Course::inverse_cap(const path::AxisSample& s, double p) const {
    double inverse = 1e-12;
    for (int a = 0; a < axes(); ++a) inverse = std::max(inverse, std::pow(s.axes[a].d1() / limits_[a].velocity, 2));
    const auto& blocks = tool_path().blocks;
    const auto block = std::lower_bound(blocks.begin(), blocks.end() - 1, p,
                                        [](const auto& b, double where) { return b.end_mm < where; });
    if (block->feed.rule == path::FeedRule::tip_speed)
        inverse = std::max(inverse, std::pow(s.feed_rate / block->feed.value, 2));
    if (block->feed.rule == path::FeedRule::rotary_rate)
        inverse = std::max(inverse, std::pow(s.turn_rate / block->feed.value, 2));
    if (block->feed.rule == path::FeedRule::block_time)
        inverse = std::max(inverse, std::pow(block->feed.value / block->time_scale_mm, 2));
    return inverse;
}

/// Where nodes lie: densely where the axes bend and near the rest points, and thinning out gradually from there.
class NodeDensity {
  public:
    explicit NodeDensity(const Course& course);
    std::vector<double> nodes(int count) const;

  private:
    static double bend(const Course& course, const Place& s);
    void thin_out_gradually(std::vector<double>& size) const;

    std::vector<double> at_, sum_;  // p, and nodes up to there in parts of all
};

/// Change of direction by mm: of first order, and of second order as its root, both of the leading axis.
double NodeDensity::bend(const Course& course, const Place& s) {
    double lead = 1e-300, second = 0, third = 0;
    for (int a = 0; a < course.axes(); ++a) {
        const double jerk = course.limit(a).jerk;
        lead = std::max(lead, std::abs(s.q1[a]) / jerk);
        second = std::max(second, std::abs(s.q2[a]) / jerk);
        third = std::max(third, std::abs(s.q3[a]) / jerk);
    }
    return second / lead + std::sqrt(third / lead);
}

NodeDensity::NodeDensity(const Course& course) {
    const double length = course.length(), arc = course.arc();
    at_.push_back(arc);
    for (const path::PathPiece& piece : course.tool_path().pieces)
        for (int k = 1; k <= samples_per_piece; ++k) {
            const double p = std::min(piece.begin_mm + piece.length_mm * k / samples_per_piece, length - arc);
            if (p > at_.back()) at_.push_back(p);
        }
    constexpr double rest_share = 0.4, uniform = 4;
    std::vector<double> size;
    for (const double p : at_)
        size.push_back(
            std::min({rest_share * p, rest_share * (length - p), length / uniform, 1 / bend(course, course.at(p))}));
    thin_out_gradually(size);
    sum_.push_back(0);
    for (std::size_t k = 1; k < at_.size(); ++k)
        sum_.push_back(sum_.back() + (at_[k] - at_[k - 1]) * 2 / (size[k] + size[k - 1]));
}

void NodeDensity::thin_out_gradually(std::vector<double>& size) const {
    constexpr double growth = 0.4;
    for (std::size_t k = 1; k < size.size(); ++k)
        size[k] = std::min(size[k], size[k - 1] + growth * (at_[k] - at_[k - 1]));
    for (std::size_t k = size.size() - 1; k-- > 0;)
        size[k] = std::min(size[k], size[k + 1] + growth * (at_[k + 1] - at_[k]));
}

std::vector<double> NodeDensity::nodes(int count) const {
    std::vector<double> out;
    std::size_t k = 0;
    for (int i = 0; i <= count; ++i) {
        const double wanted = sum_.back() * i / count;
        while (k + 2 < sum_.size() && sum_[k + 1] < wanted) ++k;
        const double part = std::clamp((wanted - sum_[k]) / (sum_[k + 1] - sum_[k]), 0.0, 1.0);
        out.push_back(at_[k] + part * (at_[k + 1] - at_[k]));
    }
    return out;
}

/// A linear form of three neighbouring coefficients, of intervals first … first + 2.
struct Form {
    int first = 0;
    std::array<double, 3> by{};
    double operator()(const std::vector<double>& c) const {
        return by[0] * c[first] + by[1] * c[first + 1] + by[2] * c[first + 2];
    }
};

Form combined(double a, const Form& f, double b, const Form& g, double c, const Form& h) {
    Form out{f.first, {}};
    for (int i = 0; i < 3; ++i) out.by[i] = a * f.by[i] + b * g.by[i] + c * h.by[i];
    return out;
}

/// |load| ≤ 1, or |load| √x ≤ 1 for jerk (x at the place of the row).
struct Row {
    Form load, x;
    bool jerk = false;
    bool stiffest = false;  // of its interval: what holds x″ there; without it a programme zigzags
};

/// The spline on given nodes. Coefficients c[0 … n + 1]: c[1 … n] are those of the intervals, free; c[0] and c[n + 1]
/// follow from the arcs at rest, x′ = ±4/3 x/u at the joints, and are eliminated from every form.
class Spline {
  public:
    Spline(const Course& course, const std::vector<double>& nodes);

    int count() const { return static_cast<int>(middles_.size()); }
    const std::vector<Row>& rows() const { return rows_; }
    double cap(int interval) const { return caps_[interval]; }
    double middle(int interval) const { return middles_[interval]; }
    double time(const std::vector<double>& c) const;
    std::vector<double> time_gradient(const std::vector<double>& c) const;
    double use(const Row& row, const std::vector<double>& c) const {
        const double load = std::abs(row.load(c));
        return row.jerk ? load * std::sqrt(row.x(c)) : load;
    }

  private:
    struct TimeTerm {
        double weight;
        Form x;
    };
    Form eliminated(int interval, std::array<double, 3> by) const;
    Form knot(int node, double before, double behind) const;
    void add_interval(const Course& course, int interval);
    void add_acceleration(const Course& course, int node);
    void hold_joint(const Course& course, int node, double rest);

    std::vector<double> nodes_, h_, middles_, caps_;
    double first_ratio_ = 0, last_ratio_ = 0;  // c[0]/c[1], c[n + 1]/c[n]
    std::vector<Row> rows_;
    std::vector<TimeTerm> time_terms_;
};

/// Beyond the ends the spline goes on for one more interval of the same length: x = (c0 + c1)/2, x′ = (c1 − c0)/h.
double ratio_beyond(double h, double arc) {
    const double slope = 2 * h / (3 * arc);
    return (1 - slope) / (1 + slope);
}

Spline::Spline(const Course& course, const std::vector<double>& nodes) : nodes_(nodes) {
    const int n = static_cast<int>(nodes.size()) - 1;
    for (int i = 0; i < n; ++i) {
        h_.push_back(nodes[i + 1] - nodes[i]);
        middles_.push_back((nodes[i] + nodes[i + 1]) / 2);
        caps_.push_back(course.at(middles_.back()).cap);
    }
    const double arc = nodes.front(), last_arc = course.length() - nodes.back();
    first_ratio_ = ratio_beyond(h_.front(), arc);
    last_ratio_ = ratio_beyond(h_.back(), last_arc);
    for (int i = 0; i < n; ++i) add_interval(course, i);
    for (int i = 1; i < n; ++i) add_acceleration(course, i);
    hold_joint(course, 0, 0);
    hold_joint(course, n, course.length());
}

/// Of coefficients interval − 1, interval, interval + 1 as a form of those that are free.
Form Spline::eliminated(int interval, std::array<double, 3> by) const {
    if (interval == 0) return {0, {by[0] * first_ratio_ + by[1], by[2], 0}};
    if (interval + 1 == count()) return {interval - 2, {0, by[0], by[1] + by[2] * last_ratio_}};
    return {interval - 1, by};
}

/// x and x′ at both ends of an interval, x in its middle, x″ inside.
struct Local {
    std::array<double, 3> left, right, middle, second;
    std::array<double, 3> slope;  // x′ in the middle
};

Local local(double before, double h, double behind) {
    Local out;
    out.left = {h / (before + h), before / (before + h), 0};
    out.right = {0, behind / (h + behind), h / (h + behind)};
    for (int i = 0; i < 3; ++i) {
        const double at = i == 1 ? 1 : 0;
        out.middle[i] = (out.left[i] + 2 * at + out.right[i]) / 4;
        out.slope[i] = (out.right[i] - out.left[i]) / h;
        out.second[i] = 2 * (out.left[i] - 2 * at + out.right[i]) / (h * h);
    }
    return out;
}

void Spline::add_interval(const Course& course, int i) {
    const double h = h_[i], before = i > 0 ? h_[i - 1] : h, behind = i + 1 < count() ? h_[i + 1] : h;
    const Local l = local(before, h, behind);
    const Form x = eliminated(i, l.middle), slope = eliminated(i, l.slope), second = eliminated(i, l.second);
    time_terms_.push_back({h / 6, eliminated(i, l.left)});
    time_terms_.push_back({h * 4 / 6, x});
    time_terms_.push_back({h / 6, eliminated(i, l.right)});
    const Place s = course.at(middles_[i]);
    double stiffness = 0;
    std::size_t stiffest = rows_.size();
    for (int a = 0; a < course.axes(); ++a) {
        if (s.q1[a] == 0 && s.q2[a] == 0 && s.q3[a] == 0) continue;
        const double limit = course.limit(a).jerk, stiff = 0.5 * s.q1[a] / limit;
        if (std::abs(stiff) > stiffness) {
            stiffness = std::abs(stiff);
            stiffest = rows_.size();
        }
        rows_.push_back({combined(s.q3[a] / limit, x, 1.5 * s.q2[a] / limit, slope, stiff, second), x, true, false});
    }
    if (stiffness > 0) rows_[stiffest].stiffest = true;
}

void Spline::add_acceleration(const Course& course, int i) {
    const double before = h_[i - 1], behind = h_[i], both = before + behind;
    const int first = std::min(i - 1, count() - 3), at = i - 1 - first;
    Form x{first, {}}, slope{first, {}};
    x.by[at] = behind / both;
    x.by[at + 1] = before / both;
    slope.by[at] = -2 / both;
    slope.by[at + 1] = 2 / both;
    const Place s = course.at(nodes_[i]);
    for (int a = 0; a < course.axes(); ++a) {
        if (s.q1[a] == 0 && s.q2[a] == 0) continue;
        const double limit = course.limit(a).acceleration;
        rows_.push_back({combined(s.q2[a] / limit, x, 0.5 * s.q1[a] / limit, slope, 0, x), x, false, false});
    }
}

/// x at the end of an arc: constant path jerk j has x = (6u)^(4/3) j^(2/3)/4. Its time is 3u/√x.
void Spline::hold_joint(const Course& course, int node, double rest) {
    const double u = std::abs(nodes_[node] - rest);
    const Place s = course.at(rest);
    double jerk = std::numeric_limits<double>::max();
    for (int a = 0; a < course.axes(); ++a)
        if (s.q1[a] != 0) jerk = std::min(jerk, course.limit(a).jerk / std::abs(s.q1[a]));
    const double cap = std::min(course.at(nodes_[node]).cap, std::pow(6 * u, 4.0 / 3) / 4 * std::pow(jerk, 2.0 / 3));
    const bool first = node == 0;
    const Form x = first ? eliminated(0, {0.5, 0.5, 0}) : eliminated(count() - 1, {0, 0.5, 0.5});
    rows_.push_back({combined(1 / cap, x, 0, x, 0, x), x, false, true});
    time_terms_.push_back({3 * u, x});
}

double Spline::time(const std::vector<double>& c) const {
    double total = 0;
    for (const TimeTerm& term : time_terms_) total += term.weight / std::sqrt(term.x(c));
    return total;
}

std::vector<double> Spline::time_gradient(const std::vector<double>& c) const {
    std::vector<double> out(c.size());
    for (const TimeTerm& term : time_terms_) {
        const double x = term.x(c), by_x = -0.5 * term.weight / (x * std::sqrt(x));
        for (int i = 0; i < 3; ++i) out[term.x.first + i] += by_x * term.x.by[i];
    }
    return out;
}

/// Scaled down until every row holds.
void make_feasible(const Spline& spline, std::vector<double>& c) {
    double factor = 1;
    for (int i = 0; i < spline.count(); ++i) factor = std::min(factor, spline.cap(i) / c[i]);
    for (const Row& row : spline.rows()) {
        const double used = spline.use(row, c);
        if (used > 1) factor = std::min(factor, row.jerk ? std::pow(used, -2.0 / 3) : 1 / used);
    }
    for (double& x : c) x *= factor;
}

/// The sequence of linear programmes on one spline.
class Sequence {
  public:
    Sequence(const Spline& spline, const Options& options)
        : spline_(spline), options_(options), is_listed_(spline.rows().size()) {}

    /// From feasible coefficients to the best ones. They change by at most this factor a step, at first.
    Optimum improve(std::vector<double>& c, double radius);

  private:
    std::vector<double> step(const std::vector<double>& c);
    std::vector<std::size_t> newly_listed(const std::vector<double>& c, double share, bool stiffest);
    void adapt_radii(const std::vector<double>& c, const std::vector<double>& next);

    const Spline& spline_;
    Options options_;
    std::vector<double> radii_, moved_;  // of every coefficient: trust region, and its last change
    std::vector<std::size_t> listed_;    // rows of the last programme
    std::vector<bool> is_listed_;
    std::vector<unsigned char> status_;  // its basis
};

/// The best place on the way to the programme's solution. All of it is feasible, for the programme's region is convex;
/// and the time is convex.
std::vector<double> best_between(const Spline& spline, const std::vector<double>& from, const std::vector<double>& to) {
    const auto at = [&](double part) {
        std::vector<double> out(from.size());
        for (std::size_t i = 0; i < out.size(); ++i) out[i] = from[i] + part * (to[i] - from[i]);
        return out;
    };
    const auto still_falls = [&](const std::vector<double>& c) {
        const std::vector<double> gradient = spline.time_gradient(c);
        double slope = 0;
        for (std::size_t i = 0; i < c.size(); ++i) slope += gradient[i] * (to[i] - from[i]);
        return slope < 0;
    };
    if (still_falls(to)) return to;
    double low = 0, high = 1;
    for (int k = 0; k < 8; ++k) {
        const double half = (low + high) / 2;
        (still_falls(at(half)) ? low : high) = half;
    }
    return at(low);
}

Optimum Sequence::improve(std::vector<double>& c, double radius) {
    Optimum out;
    radii_.assign(c.size(), radius);
    moved_.assign(c.size(), 0);
    double best = spline_.time(c);
    for (int still = 0; out.rounds < options_.max_rounds && still < 3; ++out.rounds) {
        const std::vector<double> to = step(c);
        if (to.empty()) break;
        adapt_radii(c, to);
        c = best_between(spline_, c, to);
        const double found = spline_.time(c);
        still = best - found < options_.relative_gain * best ? still + 1 : 0;
        out.converged = still == 3;
        best = found;
    }
    out.time_s = best;
    for (const Row& row : spline_.rows()) out.worst_use = std::max(out.worst_use, spline_.use(row, c));
    return out;
}

/// A coefficient that goes back and forth is given less room, one that goes on at its bound more.
void Sequence::adapt_radii(const std::vector<double>& c, const std::vector<double>& next) {
    constexpr double back = 1.0 / 3, on = 1.5, smallest = 1 + 1e-4, largest = 3;
    for (std::size_t i = 0; i < c.size(); ++i) {
        const double move = std::log(next[i] / c[i]), room = std::log(radii_[i]);
        if (move * moved_[i] < 0) radii_[i] = std::max(smallest, std::exp(back * room));
        if (move * moved_[i] > 0 && std::abs(move) > 0.99 * room) radii_[i] = std::min(largest, std::exp(on * room));
        moved_[i] = move;
    }
}

/// One linear programme in y = c/c_k. Rows can be added to it.
class Programme {
  public:
    Programme(const Spline& spline, const std::vector<double>& c, const std::vector<double>& radii);

    void list(const std::vector<std::size_t>& rows);
    /// False when CLP finds no solution.
    bool solve() { return lp_.dual() == 0; }
    std::vector<double> solution() const;
    /// The basis, for the next programme with these rows and, behind them, more.
    std::vector<unsigned char> status() {
        return {lp_.statusArray(), lp_.statusArray() + lp_.numberColumns() + lp_.numberRows()};
    }
    void start_from(const std::vector<unsigned char>& status) {
        lp_.createStatus();
        std::copy(status.begin(), status.end(), lp_.statusArray());
    }

  private:
    struct Rows {
        std::vector<CoinBigIndex> start{0};
        std::vector<int> column;
        std::vector<double> value, low, high;
        void add(const std::array<double, 3>& by, int first, double lowest, double highest);
    };
    void list(const Row& row, Rows& out) const;

    const std::vector<double>& c_;
    const Spline& spline_;
    ClpSimplex lp_;
};

Programme::Programme(const Spline& spline, const std::vector<double>& c, const std::vector<double>& radii)
    : c_(c), spline_(spline) {
    const int n = spline.count();
    lp_.setLogLevel(0);
    lp_.scaling(0);  // scaled, a row near rest may be broken by a fifth within CLP's tolerance
    lp_.resize(0, n);
    const std::vector<double> gradient = spline.time_gradient(c);
    for (int i = 0; i < n; ++i) {
        lp_.setObjectiveCoefficient(i, gradient[i] * c[i]);
        lp_.setColumnBounds(i, 1 / radii[i], std::min(radii[i], std::max(spline.cap(i) / c[i], 1.0)));
    }
}

void Programme::Rows::add(const std::array<double, 3>& by, int first, double lowest, double highest) {
    for (int i = 0; i < 3; ++i)
        if (by[i] != 0) {
            column.push_back(first + i);
            value.push_back(by[i]);
        }
    start.push_back(static_cast<CoinBigIndex>(column.size()));
    low.push_back(lowest);
    high.push_back(highest);
}

void Programme::list(const Row& row, Rows& out) const {
    std::array<double, 3> load{}, x{};
    for (int i = 0; i < 3; ++i) {
        load[i] = row.load.by[i] * c_[row.load.first + i];
        x[i] = row.x.by[i] * c_[row.x.first + i];
    }
    // The present coefficients are a solution, to CLP's tolerance: they must stay one.
    const auto at_present = [](const std::array<double, 3>& by) { return by[0] + by[1] + by[2]; };
    if (!row.jerk)
        return out.add(load, row.load.first, std::min(-1.0, at_present(load)), std::max(1.0, at_present(load)));
    const double at = row.x(c_), root = std::sqrt(at);
    for (const double sign : {1.0, -1.0}) {
        std::array<double, 3> by{};
        for (int i = 0; i < 3; ++i) by[i] = sign * root * load[i] + 0.5 * x[i] / at;
        out.add(by, row.load.first, -COIN_DBL_MAX, std::max(1.5, at_present(by)));
    }
}

void Programme::list(const std::vector<std::size_t>& rows) {
    Rows out;
    for (const std::size_t r : rows) list(spline_.rows()[r], out);
    lp_.addRows(static_cast<int>(out.low.size()), out.low.data(), out.high.data(), out.start.data(), out.column.data(),
                out.value.data());
}

std::vector<double> Programme::solution() const {
    std::vector<double> out(c_.size());
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = c_[i] * lp_.primalColumnSolution()[i];
    return out;
}

/// Rows not listed yet that use more than this share; they are listed from now on.
std::vector<std::size_t> Sequence::newly_listed(const std::vector<double>& c, double share, bool stiffest) {
    std::vector<std::size_t> out;
    const auto& rows = spline_.rows();
    for (std::size_t r = 0; r < rows.size(); ++r)
        if (!is_listed_[r] && ((stiffest && rows[r].stiffest) || spline_.use(rows[r], c) > share)) {
            is_listed_[r] = true;
            listed_.push_back(r);
            out.push_back(r);
        }
    return out;
}

/// Empty when CLP finds no solution.
std::vector<double> Sequence::step(const std::vector<double>& c) {
    Programme programme(spline_, c, radii_);
    if (listed_.empty()) newly_listed(c, listed_from, true);
    programme.list(listed_);
    if (!status_.empty()) programme.start_from(status_);
    constexpr int most_tries = 60;
    for (int tries = 0; tries < most_tries && programme.solve(); ++tries) {
        std::vector<double> next = programme.solution();
        const std::vector<std::size_t> broken = newly_listed(next, 1 + 1e-9, false);
        if (broken.empty()) {
            status_ = programme.status();
            return next;
        }
        programme.list(broken);
    }
    return {};
}

/// A smooth hump.
std::vector<double> hump(const Spline& spline, double length) {
    std::vector<double> out;
    for (int i = 0; i < spline.count(); ++i) {
        const double p = spline.middle(i);
        out.push_back(1e12 * std::pow(p * (length - p) / (length * length), 4.0 / 3));
    }
    return out;
}

/// What was found on coarser nodes, at the finer ones: linear in x^(3/4), in which runs from rest are straight.
std::vector<double> carried_over(const Spline& coarse, const std::vector<double>& c, const Spline& fine) {
    std::vector<double> out;
    int k = 0;
    for (int i = 0; i < fine.count(); ++i) {
        const double p = fine.middle(i);
        while (k + 2 < coarse.count() && coarse.middle(k + 1) < p) ++k;
        const double part = (p - coarse.middle(k)) / (coarse.middle(k + 1) - coarse.middle(k));
        const double y0 = std::pow(c[k], 0.75), y1 = std::pow(c[k + 1], 0.75);
        out.push_back(std::pow(std::max(y0 + part * (y1 - y0), 0.2 * std::min(y0, y1)), 4.0 / 3));
    }
    return out;
}

}  // namespace

Optimum reference_optimum(const path::AxisPath& path, const Options& options) {
    const Course course(path, options.jerk_factor);
    const NodeDensity density(course);
    int nodes = options.nodes;
    while (nodes >= 2 * coarsest) nodes /= 2;
    Spline spline(course, density.nodes(nodes));
    std::vector<double> c = hump(spline, course.length());
    make_feasible(spline, c);
    Optimum out = Sequence(spline, options).improve(c, 3);
    while (2 * nodes <= options.nodes) {
        nodes = 4 * nodes > options.nodes ? options.nodes : 2 * nodes;
        Spline finer(course, density.nodes(nodes));
        c = carried_over(spline, c, finer);
        make_feasible(finer, c);
        spline = std::move(finer);
        const double coarse = out.time_s;
        const int rounds = out.rounds;
        out = Sequence(spline, options).improve(c, 1.5);
        out.coarse_time_s = coarse;
        out.rounds += rounds;
    }
    return out;
}

}  // namespace trunnion::reference
