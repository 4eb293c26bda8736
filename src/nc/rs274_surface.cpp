#include <algorithm>

#include "detail/rs274_reader.hpp"

namespace trunnion::nc {

/// A block between G320 or G321 and G322: data, or the end.
bool Rs274Reader::surface_datum() {
    if (block_.code_count == 0 && block_.present == 0) return true;  // parameters alone
    if (block_.code_count == 0) return surface_words_.datum(block_, modal_.unit_mm);
    if (block_.code_count == 1 && rule_for(block_.codes[0]).meaning == Meaning::surface_end)
        return surface_words_.close(block_);
    return refuse("NC0050", block_.at(block_.codes[0].column), "no other word belongs into a surface",
                  name_of(block_.codes[0]), "G322 ends it");
}

/// G320 to G323: they move nothing, and leave modes as they are.
bool Rs274Reader::surface_word() {
    const Code& code = request_.code_of(Group::surface);
    if (block_.code_count > 1 || nurbs_)
        return refuse("NC0050", spot_of(Group::surface), "this word needs a block of its own", name_of(code));
    const Meaning asked = request_.of(Group::surface);
    if (asked == Meaning::surface_end) return surface_words_.close(block_);
    if (asked == Meaning::surface_conditions) return surface_words_.conditions(block_, modal_.unit_mm);
    if (!modal_.absolute)
        return refuse("NC0066", spot_of(Group::surface), "the points of a surface are absolute", "G91",
                      "G90 before it");
    return asked == Meaning::surface_net ? surface_words_.open_net(block_) : surface_words_.open_polynomial(block_);
}

/// G324. Where the tool stands behind it is not known here.
bool Rs274Reader::machine_surface() {
    if (!can_machine_surface() || !has_feed()) return false;
    enter(frame_in_force());
    program::SurfaceJob job;
    if (!surface_words_.job(block_, modal_.unit_mm, word_shift_.mm, program_, job)) return false;
    job.feed_mm_s = modal_.feed_per_s * modal_.feed_unit_mm;
    job.before_move = program_.moves.size();
    job.tool = frame_.tool;
    job.offset = frame_.offset;
    job.line = block_.program_line;
    event(program::EventKind::other, false, fmt::format("G324 P{}", block_['P']));
    program_.surface_jobs.push_back(job);
    stand_behind_surface();
    return true;
}

bool Rs274Reader::can_machine_surface() {
    const auto refused = [&](std::string text, std::string_view value, std::string_view hint) {
        return refuse("NC0065", spot_of(Group::motion), std::move(text), value, hint);
    };
    if (axes_ != 0) return refuse("NC0050", spot_of_motion(), "machining a surface has no axis words", "G324");
    if (shares_letters())
        return refuse("NC0313", spot_of(Group::motion), "the letters would have two uses in this block", "G324",
                      "give the other word a block of its own");
    if (left_out_home_)
        return refuse("NC0302", *left_out_home_, "the way home leads to a place that is not known here", "G28",
                      "G53 and positions instead, or nothing behind it");
    if (request_.asks(Group::once, Meaning::machine_position))
        return refused("a surface in machine positions", "G53", "it lies in the work offset");
    if (!modal_.tcp) return refused("a surface is machined with TCP on", "TCP off", "the word that turns it on before");
    if (modal_.feed_mode == FeedMode::inverse_time)
        return refused("a surface has no time of one block", "G93", "G94 or G95 before it");
    if (modal_.exact_stop) return refused("every one of the short moves would stop", "G61", "G64 before it");
    return stands_somewhere() ||
           refuse("NC0067", spot_of(Group::motion), "where the tool stands before its first surface is not known", {},
                  "say X, Y, Z and the rotary axes by G0 before it");
}

/// Whether another word of the block has letters of its own.
bool Rs274Reader::shares_letters() const {
    return request_.own_word || request_.of(Group::pins) != Meaning::unknown ||
           request_.asks(Group::tool_change, Meaning::tool_in_spindle) ||
           request_.asks(Group::subprogram, Meaning::call_program) ||
           request_.asks(Group::path_control, Meaning::continuous);
}

/// Whether a pose before the first surface is known whole.
bool Rs274Reader::stands_somewhere() const {
    return !program_.surface_jobs.empty() ||
           std::ranges::any_of(program_.moves, [&](const program::Move& move) { return is_whole(move); });
}

void Rs274Reader::stand_behind_surface() {
    for (std::size_t i = 0; i < rotary_rad_.size(); ++i) said_before_surface_[i] = is_said(i);
    position_mm_.setConstant(unknown_word);
    rotary_rad_.fill(unknown_word);
    end_tangent_mm_.reset();
    cycle_level_mm_.reset();
}

}  // namespace trunnion::nc
