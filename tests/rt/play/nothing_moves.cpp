#include <gtest/gtest.h>

#include "player.hpp"

namespace trunnion::test {
namespace {

/// A program of no part that moves: what is left of one whose every word is an event.
class NoParts final : public program::ProgramParts {
  public:
    Result<bool> next(program::Program&) override { return false; }
};

TEST(NothingMoves, IsRefusedBeforeAnythingIsPlanned) {
    const machine::Machine machine = peer_machine();
    NoParts parts;
    const auto motion = pipeline::LiveMotion::make(parts, machine, {}, {}, 2);
    ASSERT_FALSE(motion);
    EXPECT_EQ(motion.error().code, "PIPE0140");
}

TEST(NothingMoves, IsToldByTheCheckOfTheWay) {
    const machine::Machine machine = peer_machine();
    NoParts parts;
    const auto checked = pipeline::check_way(parts, machine, {}, {}, [](double) { return true; });
    ASSERT_FALSE(checked);
    EXPECT_EQ(checked.error().code, "PIPE0140");
}

}  // namespace
}  // namespace trunnion::test
