#include "detail/surface_program.hpp"

namespace trunnion::surfacing::detail {

namespace {

class ProgramWriter {
  public:
    explicit ProgramWriter(const SurfaceOptions& options) : options_(options) {
        program_.name = "surface";
        program_.dialect = "apt";
    }

    void stand(const CutterPose& at) { rapid(at); }
    void pass(const Pass& pass, const Pass* before, const Link& to) {
        lead_to(pass, before, to);
        for (std::size_t i = 1; i < pass.contacts.size(); ++i) move(pass.contacts[i].pose, options_.feed_mm_s);
    }
    void lead_to(const Pass& pass, const Pass* before, const Link& to) {
        const CutterPose& first = pass.contacts.front().pose;
        if (!to.round.empty())
            approach_round(to, first);
        else if (before && to.height_mm == 0 && is_beside(*before, pass, options_))
            link(before->contacts.back().pose, first);
        else
            approach(before, first, height_of(to));
        move(raised(first, 0), options_.approach_mm_s);
    }
    void lead_away(const Pass& last, const Link& up) { rapid(raised(last.contacts.back().pose, height_of(up))); }

    program::Program finished() { return std::move(program_); }

  private:
    double height_of(const Link& link) const { return link.height_mm > 0 ? link.height_mm : options_.retract_mm; }
    void approach_round(const Link& link, const CutterPose& to) {
        for (const CutterPose& pose : link.round) rapid(pose);
        rapid(raised(to, options_.lift_mm));
    }
    void link(const CutterPose& from, const CutterPose& to) {
        move(raised(from, options_.lift_mm), options_.feed_mm_s);
        move(raised(to, options_.lift_mm), options_.feed_mm_s);
    }
    void approach(const Pass* before, const CutterPose& to, double height_mm) {
        if (before) rapid(raised(before->contacts.back().pose, height_mm));
        rapid(raised(to, height_mm));
        if (height_mm > options_.lift_mm) rapid(raised(to, options_.lift_mm));
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

CutterPose raised(const CutterPose& pose, double height_mm) {
    return {pose.tip_mm + height_mm * pose.axis, pose.axis};
}

bool is_beside(const Pass& before, const Pass& next, const SurfaceOptions& options) {
    return options.zigzag && before.index >= 0 && next.index - before.index == 1;
}

void write_program(SurfacePlan& plan, const SurfaceOptions& options, std::span<const Link> links) {
    ProgramWriter writer(options);
    const auto link = [&](std::size_t k) { return k < links.size() ? links[k] : Link{}; };
    const Pass* before = nullptr;
    const std::vector<Pass>& passes = plan.passes;
    for (std::size_t k = 0; k < passes.size(); ++k) {
        writer.pass(passes[k], before, link(k));
        before = &passes[k];
    }
    writer.lead_away(passes.back(), link(passes.size()));
    program::Program written = writer.finished();
    written.diagnostics = std::move(plan.program.diagnostics);
    plan.program = std::move(written);
}

program::Program program_of_link(const Pass* before, const Pass* next, const SurfaceOptions& options,
                                 const Link& link) {
    ProgramWriter writer(options);
    if (before) writer.stand(before->contacts.back().pose);
    if (next)
        writer.lead_to(*next, before, link);
    else if (before)
        writer.lead_away(*before, link);
    return writer.finished();
}

}  // namespace trunnion::surfacing::detail
