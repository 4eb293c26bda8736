#include "detail/surface_program.hpp"

namespace trunnion::surfacing::detail {

namespace {

class ProgramWriter {
  public:
    explicit ProgramWriter(const SurfaceOptions& options) : options_(options) {
        program_.name = "surface";
        program_.dialect = "apt";
    }

    void pass(const Pass& pass, const Pass* before) {
        const CutterPose& first = pass.contacts.front().pose;
        const bool beside = before && before->index >= 0 && pass.index - before->index == 1;
        if (beside && options_.zigzag)
            link(before->contacts.back().pose, first);
        else
            approach(before, first);
        move(raised(first, 0), options_.approach_mm_s);
        for (std::size_t i = 1; i < pass.contacts.size(); ++i) move(pass.contacts[i].pose, options_.feed_mm_s);
    }

    program::Program finished(const Pass& last) {
        rapid(raised(last.contacts.back().pose, options_.retract_mm));
        return std::move(program_);
    }

  private:
    static CutterPose raised(const CutterPose& pose, double height) {
        return {pose.tip_mm + height * pose.axis, pose.axis};
    }
    void link(const CutterPose& from, const CutterPose& to) {
        move(raised(from, options_.lift_mm), options_.feed_mm_s);
        move(raised(to, options_.lift_mm), options_.feed_mm_s);
    }
    void approach(const Pass* before, const CutterPose& to) {
        if (before) rapid(raised(before->contacts.back().pose, options_.retract_mm));
        rapid(raised(to, options_.retract_mm));
        rapid(raised(to, options_.lift_mm));
    }
    void rapid(const CutterPose& to) {
        program_.moves.push_back({.position_mm = to.tip_mm, .axis = to.axis, .kind = program::MoveKind::rapid});
    }
    void move(const CutterPose& to, double feed_mm_s) {
        program_.moves.push_back({.position_mm = to.tip_mm,
                                  .axis = to.axis,
                                  .feed = {program::FeedRule::tip_speed, feed_mm_s},
                                  .kind = program::MoveKind::feed});
    }

    const SurfaceOptions& options_;
    program::Program program_;
};

}  // namespace

program::Program program_of(const std::vector<Pass>& passes, const SurfaceOptions& options) {
    ProgramWriter writer(options);
    const Pass* before = nullptr;
    for (const Pass& pass : passes) {
        writer.pass(pass, before);
        before = &pass;
    }
    return writer.finished(passes.back());
}

}  // namespace trunnion::surfacing::detail
