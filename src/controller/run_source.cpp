#include "detail/run_source.hpp"

#include <cmath>

#include <fmt/format.h>

#include "trunnion/base/quantity.hpp"

#include "detail/branch_rule.hpp"

namespace trunnion::controller {

using program::FeedRule;

namespace {

bool positive(double x) {
    return std::isfinite(x) && x > 0;
}

Result<void> check(const PredictOptions& options) {
    if (!positive(options.feed_override) || (options.feed_mm_s && !positive(*options.feed_mm_s)))
        return fail({.code = "CTRL0206", .text = "feed and feed override must be above 0"});
    if (!(std::abs(options.contact_lead_rad) < 90 * degree))
        return fail({.code = "CTRL0204",
                     .text = "the tool cannot lean so far along the feed",
                     .value = fmt::format("{:g} deg", options.contact_lead_rad / degree),
                     .limit = "less than 90 deg"});
    return {};
}

}  // namespace

Result<RunSource> RunSource::make(const program::Program& program, const machine::Machine& machine,
                                  const machine::Setup& setup, motion::BranchRule rule, const PredictOptions& options) {
    if (auto good = check(options); !good) return fail(good.error());
    auto stands = stands_by_rule(program, machine, setup, rule);
    if (!stands) return fail(stands.error());
    RunSource out;
    out.program_ = &program;
    out.options_ = options;
    out.stands_ = std::move(*stands);
    auto builder = path::PathBuilder::make(program, machine, setup, out.stands_);
    if (!builder) return fail(builder.error());
    out.builder_.emplace(std::move(*builder));
    return out;
}

Result<bool> RunSource::next(path::Run& run) {
    auto more = builder_->next(run);
    if (!more || !*more) return more;
    blocks_ += run.blocks.size();
    if (run.rapid) return true;
    for (path::Block& block : run.blocks) {
        if (options_.feed_mm_s) block.feed = {FeedRule::tip_speed, *options_.feed_mm_s};
        if (block.feed.rule == FeedRule::block_time)
            block.feed.value /= options_.feed_override;
        else
            block.feed.value *= options_.feed_override;
        if (block.feed.rule == FeedRule::none || !positive(block.feed.value))
            return fail({.code = "CTRL0201",
                         .text = "a block without a feed or time above 0",
                         .place = {.file = program_->source, .line = block.line}});
    }
    return true;
}

std::vector<Diagnostic> RunSource::diagnostics() const {
    auto out = builder_->diagnostics();
    const std::size_t moves = program_->moves.size() - 1;
    if (moves > blocks_)
        out.push_back({.code = "CTRL0202",
                       .severity = Severity::warning,
                       .text = "blocks in which nothing moves: no time is counted for them",
                       .place = {.file = program_->source},
                       .count = static_cast<int>(moves - blocks_)});
    return out;
}

const machine::Tool& tool_of(const path::Run& run, const program::Program& program, const machine::Setup& setup) {
    const std::string& name = program.tools[program.moves[run.first_move].tool];
    const machine::Tool* tool = name.empty() ? nullptr : setup.tool_named(name);
    return tool ? *tool : setup.tool;
}

double programmed_tip_feed(const path::Block& block, double way_mm) {
    if (block.feed.rule == FeedRule::tip_speed) return block.feed.value;
    if (block.feed.rule == FeedRule::block_time) return way_mm / block.feed.value;
    return 0;
}

}  // namespace trunnion::controller
