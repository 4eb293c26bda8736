#include "detail/scale.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "trunnion/smoothing/kernel.hpp"

#include "detail/half_bump.hpp"

namespace trunnion::smoothing {

namespace {

constexpr int levels = 9;                  // widths cap, cap/2, … cap/256
constexpr std::size_t worth_moments = 16;  // vertices on one width from which sums are moved along

/// Σ Δ·w·g((p − p_j)/w) over the vertices nearer than w, all of one width, moved along from vertex to vertex: on the
/// way of one width it is a polynomial about an anchor, to which vertices come and from which they go.
template <class Kernel>
class MovingSum {
  public:
    MovingSum(const Bumps& bumps, const std::vector<double>& share, double width_mm)
        : bumps_(bumps), share_(share), width_(width_mm) {}

    /// Anchors at a vertex; to be called again after at most one width.
    void anchor(std::size_t vertex) {
        for (Coordinates& c : even_) c.setZero();
        signed_offset_.setZero();
        signed_jump_.setZero();
        anchor_ = first_ = here_ = last_ = vertex;
        add(vertex, 1);
        turn(vertex, 1);
        while (first_ > 0 && bumps_.distance(first_ - 1, vertex) < width_) {
            add(--first_, 1);
            turn(first_, 1);
        }
        take_in(vertex);
    }

    /// The sum at a vertex: the anchor or one after it and after the last.
    Coordinates at(std::size_t vertex) {
        while (here_ < vertex) turn(++here_, 2);
        take_in(vertex);
        for (; bumps_.distance(first_, vertex) >= width_; ++first_) {
            add(first_, -1);
            turn(first_, -1);
        }
        const double s = bumps_.distance(anchor_, vertex) / width_;
        Coordinates sum = even_[8];
        for (std::size_t n = 8; n-- > 0;) sum = sum * s + even_[n];
        return width_ * (sum - 0.5 * (signed_offset_ + s * signed_jump_));
    }

  private:
    /// Vertices that come near from ahead.
    void take_in(std::size_t vertex) {
        while (last_ + 1 < bumps_.size() && bumps_.distance(vertex, last_ + 1) < width_) {
            add(++last_, 1);
            if (last_ > here_) turn(last_, -1);
        }
    }

    double offset(std::size_t j) const { return -bumps_.distance(anchor_, j) / width_; }

    void add(std::size_t j, double sign) {
        const Octic q = even_part<Kernel>(offset(j));
        const Coordinates jump = (sign * share_[j]) * bumps_.jump[j];
        for (std::size_t n = 0; n < even_.size(); ++n) even_[n] += q[n] * jump;
    }

    /// Counts a vertex `times` more as one behind: |t| = ±(t of the anchor + s).
    void turn(std::size_t j, double times) {
        const Coordinates jump = (times * share_[j]) * bumps_.jump[j];
        signed_jump_ += jump;
        signed_offset_ += offset(j) * jump;
    }

    const Bumps& bumps_;
    const std::vector<double>& share_;
    double width_;
    std::size_t anchor_ = 0, first_ = 0, here_ = 0, last_ = 0;  // in the sum: first … last; behind: first … here
    std::array<Coordinates, 9> even_;
    Coordinates signed_offset_, signed_jump_;
};

template <class Kernel>
Coordinates sum_one_by_one(const Bumps& bumps, const std::vector<double>& share, double width, std::size_t vertex) {
    Coordinates sum = Coordinates::Zero();
    bumps.around({vertex, 0}, width, width, [&](std::size_t j, double d) {
        sum += bumps.jump[j] * (share[j] * width * Kernel::bump(std::abs(d) / width));
    });
    return sum;
}

/// δ of one width at all real vertices, counted from the first.
template <class Kernel>
void deviations(const Bumps& bumps, const std::vector<double>& share, double width, std::vector<Coordinates>& delta) {
    MovingSum<Kernel> sum(bumps, share, width);
    for (std::size_t k = bumps.first(), behind = k; k <= bumps.last(); k = behind) {
        while (behind <= bumps.last() && bumps.distance(k, behind) < width) ++behind;
        const bool move = behind - k >= worth_moments;
        if (move) sum.anchor(k);
        for (std::size_t i = k; i < behind; ++i)
            delta[i - bumps.first()] = move ? sum.at(i) : sum_one_by_one<Kernel>(bumps, share, width, i);
    }
}

/// Where the variation, known at cap·2^−l and rising with the width, reaches `aim`.
double crossing(const std::array<double, levels>& variation, double cap, double aim) {
    if (variation[0] <= aim) return cap;
    int l = 0;
    while (l < levels && variation[l] > aim) ++l;
    if (l == levels) return std::ldexp(cap, 1 - levels) * aim / variation[levels - 1];
    const double low = std::log(std::max(variation[l], 1e-12)), high = std::log(variation[l - 1]);
    const double step = high > low ? (std::log(aim) - low) / (high - low) : 0;
    return std::ldexp(cap, -l) * std::exp2(std::clamp(step, 0.0, 1.0));
}

template <class Kernel>
void widths_by_variation(const Curve& curve, double aim, const std::vector<double>& share, std::vector<double>& width) {
    const Bumps& bumps = curve.bumps;
    const std::size_t count = bumps.last() + 1 - bumps.first();
    std::vector<Coordinates> finer(count, Coordinates::Zero()), delta(count);
    std::vector<std::array<double, levels>> variation(count);
    for (int l = levels - 1; l >= 0; --l) {
        deviations<Kernel>(bumps, share, std::ldexp(bumps.cap_mm(), -l), delta);
        for (std::size_t i = 0; i < count; ++i)
            variation[i][l] =
                (l + 1 < levels ? variation[i][l + 1] : 0) + curve.use(delta[i] - finer[i], bumps.first() + i);
        finer.swap(delta);
    }
    for (std::size_t i = 0; i < count; ++i) {
        const std::size_t k = bumps.first() + i;
        width[k] = std::min(curve.cap[k], crossing(variation[i], bumps.cap_mm(), aim));
    }
}

}  // namespace

void find_raw_widths(Curve& curve, double aim) {
    widths_by_variation<DetectionKernel>(curve, aim, std::vector<double>(curve.bumps.size(), 1.0), curve.raw_width);
}

void find_curve_widths(Curve& curve, double aim) {
    std::vector<double> share = curve.bumps.corner_share;
    for (double& part : share) part = 1 - part;
    widths_by_variation<CurveKernel>(curve, aim, share, curve.bumps.curve_width);
}

}  // namespace trunnion::smoothing
