#pragma once

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "trunnion/program/program.hpp"

namespace trunnion::nc {

/// N_{i,p}(u) by the recursion of Cox and de Boor, u within [first, last) of the knots.
inline double basis(const std::vector<double>& knots, std::size_t i, std::size_t p, double u) {
    if (p == 0) return knots[i] <= u && u < knots[i + 1] ? 1 : 0;
    const auto share = [&](std::size_t from, double at) {
        const double width = knots[from + p] - knots[from];
        return width > 0 ? at / width : 0;
    };
    return share(i, u - knots[i]) * basis(knots, i, p - 1, u) +
           share(i + 1, knots[i + p + 1] - u) * basis(knots, i + 1, p - 1, u);
}

/// Σ N_i w_i V_i / Σ N_i w_i, straight from its definition.
template <class Vectors>
Eigen::Vector3d blended(const program::Curve& curve, const Vectors& vectors, double u) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    double weights = 0;
    for (std::size_t i = 0; i < vectors.size(); ++i) {
        const double weight = curve.weights.empty() ? 1 : curve.weights[i];
        const double share = weight * basis(curve.knots, i, static_cast<std::size_t>(curve.degree), u);
        weights += share;
        sum += share * Eigen::Vector3d(vectors[i][0], vectors[i][1], vectors[i][2]);
    }
    return sum / weights;
}

/// The curve that a move follows.
inline const program::Curve& curve_of(const program::Program& p, const program::Move& move) {
    return p.curves.at(static_cast<std::size_t>(p.curve_parts.at(static_cast<std::size_t>(move.curve_part)).curve));
}

inline const program::CurvePart& part_of(const program::Program& p, const program::Move& move) {
    return p.curve_parts.at(static_cast<std::size_t>(move.curve_part));
}

/// What every curve keeps: knots and control points fit, and every move along it begins where the one before ends.
inline void expect_sound_curves(const program::Program& p) {
    for (const program::Curve& curve : p.curves) {
        ASSERT_TRUE(curve.degree >= 1 && curve.degree <= 7);
        const std::size_t points = curve.position_mm.size();
        ASSERT_EQ(curve.knots.size(), points + static_cast<std::size_t>(curve.degree) + 1);
        for (std::size_t i = 1; i < curve.knots.size(); ++i) ASSERT_LE(curve.knots[i - 1], curve.knots[i]);
        for (const double knot : curve.knots) ASSERT_TRUE(std::isfinite(knot));
        ASSERT_TRUE(curve.weights.empty() || curve.weights.size() == points);
        for (const double weight : curve.weights) ASSERT_TRUE(weight > 0 && std::isfinite(weight));
        ASSERT_TRUE(curve.axis.empty() || curve.axis.size() == points);
        ASSERT_TRUE(curve.rotary_rad.empty() || curve.rotary_rad.size() == points);
        for (const auto& point : curve.position_mm) ASSERT_TRUE(point.allFinite());
        for (const auto& axis : curve.axis) ASSERT_TRUE(axis.allFinite());
    }
    for (std::size_t i = 0; i < p.moves.size(); ++i) {
        const program::Move& move = p.moves[i];
        if (move.curve_part == program::no_curve_part) continue;
        ASSERT_GT(i, 0u);
        ASSERT_EQ(move.arc, program::no_arc);
        ASSERT_LT(static_cast<std::size_t>(move.curve_part), p.curve_parts.size());
        const program::CurvePart& part = part_of(p, move);
        ASSERT_LT(static_cast<std::size_t>(part.curve), p.curves.size());
        const program::Curve& curve = curve_of(p, move);
        const double end = curve.knots[curve.position_mm.size()];
        ASSERT_LT(part.from_u, part.to_u);
        ASSERT_GE(part.from_u, curve.knots[static_cast<std::size_t>(curve.degree)]);
        ASSERT_LE(part.to_u, end);
        ASSERT_EQ(move.law == program::OrientationLaw::rotary && !curve.axis.empty(), false);
        ASSERT_EQ(move.law == program::OrientationLaw::vector && !curve.rotary_rad.empty(), false);
        double size = 1;
        for (const auto& point : curve.position_mm) size = std::max(size, point.lpNorm<Eigen::Infinity>());
        const Eigen::Vector3d from = blended(curve, curve.position_mm, part.from_u);
        ASSERT_LT((from - p.moves[i - 1].position_mm).norm(), 1e-9 * size);
        if (part.to_u < end) {
            const Eigen::Vector3d to = blended(curve, curve.position_mm, part.to_u);
            ASSERT_LT((to - move.position_mm).norm(), 1e-9 * size);
        } else {
            ASSERT_LT((curve.position_mm.back() - move.position_mm).norm(), 1e-9 * size);
        }
    }
}

}  // namespace trunnion::nc
