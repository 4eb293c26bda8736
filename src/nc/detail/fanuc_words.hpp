#pragma once

#include <cstdint>

namespace trunnion::nc::fanuc {

/// Modal groups: two words of one group contradict each other in a block.
enum class Group : std::uint8_t {
    motion,
    plane,
    distance,
    feed_mode,
    units,
    compensation,
    length,
    cycle,
    return_level,
    offset,
    path_control,
    mirror,
    turned,  ///< G68, G68.2
    dynamic,
    once,
    stop,
    tool_change,
    count
};

enum class Meaning : std::uint8_t {
    unknown,
    // refused
    changes_motion,
    compensation,
    tcp_word,
    // passed over
    harmless,
    ignored,
    // carried out
    rapid,
    line,
    clockwise,
    counter_clockwise,
    nurbs,
    cycle,
    no_cycle,
    dwell,
    exact_stop_once,
    data,
    reference,
    plane,
    inch,
    mm,
    length,
    tcp_rotary,
    tcp_vector,
    no_length,
    mirror,
    no_mirror,
    local_shift,
    machine_position,
    swivel,
    offset,
    numbered_offset,
    exact_stop,
    continuous,
    rotation,
    tilted_plane,
    no_rotation,
    absolute,
    incremental,
    preset,
    no_preset,
    inverse_time,
    per_minute,
    per_revolution,
    return_initial,
    return_r,
    dynamic_offset,
    no_dynamic_offset,
    pause,
    end,
    tool_change,
    spindle,
    coolant,
    event
};

struct WordRule {
    Meaning meaning = Meaning::unknown;
    Group group = Group::once;
};

/// What a word means whose number is given in tenths: G43.4 is 434. Cost: one look into a table.
WordRule rule_of_g(int tenths) noexcept;
WordRule rule_of_m(int tenths) noexcept;

}  // namespace trunnion::nc::fanuc
