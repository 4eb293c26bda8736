// Links and retracts of a plan stay clear of the part.
#include <algorithm>

#include <gtest/gtest.h>

#include "trunnion/surfacing/part_body.hpp"
#include "trunnion/surfacing/plan_surface.hpp"

#include "sample_parts.hpp"

namespace {

using namespace trunnion;
using namespace trunnion::surfacing;
using namespace trunnion::surfacing::samples;
using program::Move;

double deepest_on_the_way(const SampledPart& part, const Cutter& cutter, const Move& from, const Move& to) {
    double out = 0;
    constexpr int parts = 100;
    for (int i = 0; i <= parts; ++i) {
        const double share = static_cast<double>(i) / parts;
        const CutterPose pose{(1 - share) * from.position_mm + share * to.position_mm,
                              ((1 - share) * from.axis + share * to.axis).normalized()};
        out = std::max(out, part.depth_mm(cutter, pose));
    }
    return out;
}

TEST(SurfaceProgram, GoesBackOverADomeAndNotThroughIt) {
    const Face dome = facing(cylinder(30, 12, 2.4), {0, 0, 1});
    const Cutter ball = Cutter::make(ball_tool(8)).value();
    SurfaceOptions options;
    options.strategy = Strategy::along_v;
    options.zigzag = false;
    options.retract_mm = 3;
    options.scallop_mm = 0.1;
    options.chord_tolerance_mm = 0.01;
    const auto plan = plan_surface(dome, ball, options);
    ASSERT_TRUE(plan) << to_string(plan.error());
    const SampledPart part({dome}, 0.5);
    const auto& moves = plan->program.moves;
    double deepest = 0;
    for (std::size_t k = 1; k < moves.size(); ++k) {
        if (moves[k].kind != program::MoveKind::rapid) continue;
        deepest = std::max(deepest, deepest_on_the_way(part, ball, moves[k - 1], moves[k]));
    }
    EXPECT_EQ(deepest, 0);
    const auto above = [&](const Contact& contact) {
        const CutterPose& pose = contact.pose;
        return Move{.position_mm = pose.tip_mm + options.retract_mm * pose.axis, .axis = pose.axis};
    };
    const Pass &first = plan->passes[0], &second = plan->passes[1];
    EXPECT_GT(deepest_on_the_way(part, ball, above(first.contacts.back()), above(second.contacts.front())), 1)
        << "at the height asked for it would go through";
}

}  // namespace
