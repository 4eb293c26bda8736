#pragma once

#include <cmath>

#include <gtest/gtest.h>

#include "trunnion/program/program.hpp"

#include "curves.hpp"

namespace trunnion::nc {

/// What every program keeps that is read, whatever the text was.
inline void expect_sound(const program::Program& p) {
    ASSERT_GE(p.moves.size(), 2u);
    expect_sound_curves(p);
    ASSERT_TRUE(p.moves[0].position_mm.allFinite());
    ASSERT_EQ(p.moves[0].arc, program::no_arc);
    for (const program::Arc& arc : p.arcs) {
        ASSERT_TRUE(arc.centre_mm.allFinite());
        ASSERT_NEAR(arc.normal.norm(), 1, 1e-12);
        ASSERT_TRUE(std::isfinite(arc.angle_rad) && arc.angle_rad != 0);
    }
    for (const program::Move& move : p.moves) {
        ASSERT_FALSE(move.position_mm.array().isInf().any());
        ASSERT_TRUE(move.arc == program::no_arc || move.arc >= 0);
        ASSERT_LT(move.arc, static_cast<std::int32_t>(p.arcs.size()));
        ASSERT_NEAR(move.axis.norm(), 1, 1e-12);
        for (const double word : move.rotary_rad) ASSERT_FALSE(std::isinf(word));
        ASSERT_TRUE(std::isfinite(move.feed.value) && move.feed.value >= 0);
        ASSERT_TRUE(move.kind != program::MoveKind::rapid || move.feed.rule == program::FeedRule::none);
        ASSERT_LT(move.tool, p.tools.size());
        ASSERT_LT(move.offset, p.offsets.size());
    }
    ASSERT_EQ(p.following.size(), p.moves.size() * p.following_letters.size());
    for (const double at_mm : p.following) ASSERT_TRUE(std::isfinite(at_mm));
    for (const program::Event& event : p.events) ASSERT_LE(event.before_move, p.moves.size());
}

}  // namespace trunnion::nc
