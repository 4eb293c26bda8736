#include "detail/pole_piece.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include <Eigen/Geometry>

#include "trunnion/path/pole_passage.hpp"

namespace trunnion::path::detail {

using machine::Kinematics;
using machine::RotaryPosition;
using machine::RotarySeries;

namespace {

constexpr double at_pole_rad = 1e-12;
constexpr double least_turn_rad = 1e-9;  // of the tool along the piece

/// Coefficients in u as coefficients in u − 1.
std::array<double, 8> counted_from_end(std::array<double, 8> c) {
    for (int from = 0; from < 7; ++from)
        for (int i = 6; i >= from; --i) c[i] += c[i + 1];
    return c;
}

/// Bernstein coefficients over [from, to] of a polynomial given by powers (Farin, Curves and Surfaces for CAGD, ch. 5).
std::array<double, 7> bernstein(std::array<double, 7> c, double from, double to) {
    for (int low = 0; low < 6; ++low)
        for (int i = 5; i >= low; --i) c[i] += from * c[i + 1];
    double power = 1;
    std::array<double, 7> out{};
    constexpr std::array<double, 7> of_six{1, 6, 15, 20, 15, 6, 1};
    for (std::size_t i = 0; i < 7; ++i, power *= to - from) c[i] *= power / of_six[i];
    for (std::size_t j = 0; j < 7; ++j) {
        double of_j = 1;  // j over i
        for (std::size_t i = 0; i <= j; ++i) {
            out[j] += of_j * c[i];
            of_j *= static_cast<double>(j - i) / static_cast<double>(i + 1);
        }
    }
    return out;
}

template <std::size_t n>
Taylor3 value_at(const std::array<double, n>& c, const Taylor3& v) {
    Taylor3 out(c[n - 1]);
    for (std::size_t i = n - 1; i-- > 0;) out = out * v + Taylor3(c[i]);
    return out;
}

/// Which way the axis nearest to the workpiece turns the tool about the pole.
double sense_about(const Kinematics& kinematics, const Eigen::Vector3d& pole, const Eigen::Vector3d& ahead) {
    constexpr double tilt = 0.01, turn_rad = 0.1;
    const auto solutions = kinematics.rotary_for((pole + tilt * ahead).normalized());
    RotaryPosition at = solutions.rotary_rad[0];
    const Eigen::Vector3d before = beside_pole(kinematics.tool_axis(at), pole);
    at[static_cast<std::size_t>(kinematics.rotary_nearest_workpiece())] += turn_rad;
    const Eigen::Vector3d after = beside_pole(kinematics.tool_axis(at), pole);
    return pole.dot(before.cross(after)) > 0 ? 1 : -1;
}

}  // namespace

std::optional<PolePiece> PolePiece::make(std::size_t index, const PathPiece& piece, const Kinematics& kinematics,
                                         std::span<const Eigen::Vector3d> poles) {
    std::array<std::array<double, 8>, 3> c{piece.coefficient[3], piece.coefficient[4], piece.coefficient[5]};
    for (const bool at_end : {false, true}) {
        if (at_end)
            for (auto& of_one : c) of_one = counted_from_end(of_one);
        const Eigen::Vector3d there(c[0][0], c[1][0], c[2][0]), slope(c[0][1], c[1][1], c[2][1]);
        for (const Eigen::Vector3d& pole : poles) {
            const double height = pole.dot(there);
            if (height <= 0 || beside_pole(there, pole).norm() > at_pole_rad * height) continue;
            const Eigen::Vector3d leaving = beside_pole(slope, pole);
            if (leaving.norm() < least_turn_rad * height) continue;
            PolePiece out;
            out.index_ = index;
            out.length_mm_ = piece.length_mm;
            out.from_mm_ = at_end ? piece.length_mm : 0;
            out.pole_ = pole;
            out.ahead_ = leaving.normalized();
            out.sense_ = sense_about(kinematics, pole, out.ahead_);
            const Eigen::Vector3d aside = pole.cross(out.ahead_);
            for (std::size_t i = 0; i < 8; ++i) {
                const Eigen::Vector3d of_power(c[0][i], c[1][i], c[2][i]);
                out.height_[i] = pole.dot(of_power);
                if (i == 0) continue;
                out.along_[i - 1] = out.ahead_.dot(of_power);
                out.across_[i - 1] = aside.dot(of_power);
            }
            out.across_[0] = 0;
            return out;
        }
    }
    return std::nullopt;
}

RotarySeries PolePiece::rotary(const Kinematics& kinematics, double offset_mm,
                               const RotaryPosition& near) const noexcept {
    constexpr double beside = 1e-6;  // at 0 itself the kinematics leave the free axis where it is
    const std::size_t free = static_cast<std::size_t>(kinematics.rotary_nearest_workpiece());
    const Taylor3 v{(offset_mm - from_mm_) / length_mm_, 1 / length_mm_, 0, 0};
    const Taylor3 along = value_at(along_, v), across = value_at(across_, v);
    const Taylor3 turn = sense_ * atan2(across, along);
    const Taylor3 q = v * sqrt(along * along + across * across) / value_at(height_, v);
    const double base = std::abs(q.value()) > beside ? q.value() : beside;
    machine::VectorSeries in_plane;
    for (int k = 0; k < 3; ++k) in_plane[k] = {pole_[k] + base * ahead_[k], ahead_[k], 0, 0};
    RotaryPosition near_in_plane = near;
    near_in_plane[free] -= turn.value();
    const RotarySeries by_q = kinematics.rotary_series(in_plane, near_in_plane);
    const Taylor3 d = q - Taylor3(base);
    RotarySeries out;
    for (std::size_t a = 0; a < out.size(); ++a) {
        const auto& c = by_q[a].c;
        out[a] = c[0] + d * (c[1] + d * (c[2] + d * c[3]));
    }
    out[free] += turn;
    return out;
}

double PolePiece::turn_bound_rad(double from_mm, double to_mm) const noexcept {
    const double from = (from_mm - from_mm_) / length_mm_, to = (to_mm - from_mm_) / length_mm_;
    const auto along = bernstein(along_, from, to), across = bernstein(across_, from, to);
    const double towards = std::accumulate(along.begin(), along.end(), 0.0),
                 aside = std::accumulate(across.begin(), across.end(), 0.0);
    double least = 0, most = 0;
    for (std::size_t i = 0; i < along.size(); ++i) {
        const double ahead = along[i] * towards + across[i] * aside, left = across[i] * towards - along[i] * aside;
        if (!(ahead > 0)) return std::numbers::pi;
        least = std::min(least, std::atan2(left, ahead));
        most = std::max(most, std::atan2(left, ahead));
    }
    return most - least;
}

}  // namespace trunnion::path::detail
