#include <gtest/gtest.h>

#include "player.hpp"

namespace trunnion::test {
namespace {

/// A part that has only where motion starts.
class StandingPart final : public program::ProgramParts {
  public:
    explicit StandingPart(const machine::Machine& machine)
        : moving_("G21 G90 G94\nG0 X0 Y0 Z0 A0 C0\nG1 X1 F60\n", machine) {}
    Result<bool> next(program::Program& part) override {
        const auto more = moving_.next(part);
        if (more && *more) part.moves.resize(1);
        return more;
    }

  private:
    OnePart moving_;
};

TEST(NothingMoves, IsRefusedBeforeAnythingIsPlanned) {
    const machine::Machine machine = peer_machine();
    StandingPart parts(machine);
    const auto motion = pipeline::LiveMotion::make(parts, machine, {}, {}, 2);
    ASSERT_FALSE(motion);
    EXPECT_EQ(motion.error().code, "PIPE0140");
}

TEST(NothingMoves, NoPartIsRefusedToo) {
    struct NoPart final : program::ProgramParts {
        Result<bool> next(program::Program&) override { return false; }
    };
    const machine::Machine machine = peer_machine();
    NoPart parts, again;
    const auto motion = pipeline::LiveMotion::make(parts, machine, {}, {}, 2);
    ASSERT_FALSE(motion);
    EXPECT_EQ(motion.error().code, "PIPE0140");
    const auto checked = pipeline::check_way(again, machine, {}, {}, [](double) { return true; });
    ASSERT_FALSE(checked);
    EXPECT_EQ(checked.error().code, "PIPE0140");
}

TEST(NothingMoves, IsToldByTheCheckOfTheWay) {
    const machine::Machine machine = peer_machine();
    StandingPart parts(machine);
    const auto checked = pipeline::check_way(parts, machine, {}, {}, [](double) { return true; });
    ASSERT_FALSE(checked);
    EXPECT_EQ(checked.error().code, "PIPE0140");
}

}  // namespace
}  // namespace trunnion::test
