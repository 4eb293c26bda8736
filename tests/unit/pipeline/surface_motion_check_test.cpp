#include "trunnion/pipeline/surface_motion_check.hpp"

#include <gtest/gtest.h>

#include "surface_motion_samples.hpp"

namespace trunnion::pipeline {
namespace {

using namespace surface_motion_samples;

/// A wall at y = 13 across the slope, its outside towards the tool.
Face wall() {
    Face out = surfacing::whole_face(
        geometry::polynomial_surface(1, 1, {{-10, 13, -20}, {0, 0, 60}, {60, 0, 0}, {0, 0, 0}}).value());
    const auto shape = geometry::shape_at(out.surface, {0.5, 0.5}, out.side);
    if (shape->normal.y() > 0) out.side = geometry::opposite(out.side);
    out.number = 7;
    return out;
}

struct Looked {
    SurfaceCase work{slope()};
    surfacing::SurfacePlan plan = work.plan();
    surfacing::Cutter cutter = surfacing::Cutter::make(work.setup.tool, 20).value();
    machine::Kinematics kinematics = machine::Kinematics::make(work.machine, work.setup.workpiece, 100).value();
    Recorder recorder;

    Result<SurfacePartCheck> at(const std::vector<Face>& part, const surfacing::Holder& holder = {}) {
        MotionInPart motion(kinematics, cutter, holder, recorder);
        EXPECT_TRUE(work.move(plan, motion));
        return motion.check(part, work.surface.gouge_tolerance_mm);
    }
};

/// The motion is nowhere far from its program: what is found of both is the same.
TEST(SurfaceMotionCheck, finds_where_the_motion_goes_into_the_part) {
    Looked looked;
    const std::vector<Face> part{looked.work.face, wall()};
    const auto found = looked.at(part);
    ASSERT_TRUE(found && found->in_part);
    EXPECT_EQ(found->faces, 2u);
    EXPECT_EQ(found->in_part_face, 7);
    EXPECT_FALSE(found->in_part->by_holder);
    const auto of_program = check_part(part, looked.cutter, {.plan = looked.plan}, 0.001);
    ASSERT_TRUE(of_program && of_program->in_part);
    EXPECT_NEAR(found->in_part->depth_mm, of_program->in_part->depth_mm, 0.03);
    EXPECT_GT(found->in_part->depth_mm, 0.2);
}

TEST(SurfaceMotionCheck, finds_nothing_where_there_is_nothing) {
    Looked looked;
    const auto found = looked.at({looked.work.face});
    ASSERT_TRUE(found);
    EXPECT_FALSE(found->in_part);
    Recorder alone;
    ASSERT_TRUE(looked.work.move(looked.plan, alone));
    EXPECT_EQ(looked.recorder.rows.size(), alone.rows.size());
    EXPECT_EQ(looked.recorder.shares, alone.shares);
}

TEST(SurfaceMotionCheck, looks_at_the_holder_and_at_the_part) {
    Looked looked;
    const auto found = looked.at({looked.work.face, wall()}, {.radius_mm = 30, .from_mm = 20, .to_mm = 60});
    ASSERT_TRUE(found && found->in_part);
    EXPECT_TRUE(found->in_part->by_holder);
    MotionInPart motion(looked.kinematics, looked.cutter, {}, looked.recorder);
    EXPECT_EQ(motion.check({}, 0.001).error().code, "SURF0302");
}

}  // namespace
}  // namespace trunnion::pipeline
