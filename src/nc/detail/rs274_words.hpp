#pragma once

#include <cstdint>

#include "detail/rs274_block.hpp"

namespace trunnion::nc {

/// Modal groups: two words of one group contradict each other in a block.
enum class Group : std::uint8_t {
    motion,
    plane,
    distance,
    arc_distance,
    feed_mode,
    units,
    cutter,
    tool_length,
    return_mode,
    offset,
    path_control,
    spindle_mode,
    diameter,
    shift,
    once,
    stop,
    spindle,
    tool_change,
    mist,
    flood,
    override_switch,
    count
};

enum class Meaning : std::uint8_t {
    unknown,
    spline,
    changes_motion,  // refused
    harmless,        // nothing that is planned here depends on it
    rapid,
    feed,
    clockwise_arc,
    counter_clockwise_arc,
    no_motion,
    dwell,
    machine_position,
    plane,
    absolute,
    incremental,
    absolute_centre,
    incremental_centre,
    tool_length,
    own_tool_length,
    per_minute,
    inverse_time,
    inch,
    mm,
    offset,
    exact_stop,
    continuous,
    pause,
    end,
    spindle,
    tool_change,
    coolant
};

constexpr bool is_arc(Meaning meaning) {
    return meaning == Meaning::clockwise_arc || meaning == Meaning::counter_clockwise_arc;
}

struct WordRule {
    Meaning meaning = Meaning::unknown;
    Group group = Group::once;
};

/// What a G or M word means on LinuxCNC. Cost: one look into a table.
WordRule rule_for(const Code& code) noexcept;

}  // namespace trunnion::nc
