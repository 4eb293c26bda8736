#pragma once

#include <cstdint>

#include "detail/rs274_block.hpp"

namespace trunnion::nc {

/// Modal groups: two words of one group contradict each other in a block.
enum class Group : std::uint8_t {
    motion,
    plane,
    distance,
    following_distance,
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
    pins,
    state,
    user,
    subprogram,
    surface,
    count
};

enum class Meaning : std::uint8_t {
    unknown,
    changes_motion,  // refused
    harmless,        // nothing that is planned here depends on it
    printing,        // words of 3D printers that cannot change the path: ignored with their parameters
    rapid,
    feed,
    clockwise_arc,
    counter_clockwise_arc,
    cubic_curve,
    quadratic_curve,
    nurbs,
    nurbs_end,
    surface_machining,
    cycle,
    no_motion,
    dwell,
    machine_position,
    plane,
    absolute,
    incremental,
    absolute_following,
    incremental_following,
    absolute_centre,
    incremental_centre,
    tool_length,
    own_tool_length,
    per_minute,
    inverse_time,
    per_turn,
    initial_level,
    retract_plane,
    shift_to_here,
    end_shift,
    pause_shift,
    resume_shift,
    local_shift,
    set_data,
    go_home,
    inch,
    mm,
    offset,
    exact_stop,
    continuous,
    pause,
    end,
    spindle,
    tool_change,
    tool_in_spindle,
    coolant,
    pin,
    wait_for_pin,
    user_word,
    keep_state,
    forget_state,
    restore_state,
    keep_state_till_return,
    call_program,
    return_from_program,
    surface_net,
    surface_polynomial,
    surface_end,
    surface_conditions
};

constexpr bool is_arc(Meaning meaning) {
    return meaning == Meaning::clockwise_arc || meaning == Meaning::counter_clockwise_arc;
}

constexpr bool is_curve(Meaning meaning) {
    return meaning == Meaning::cubic_curve || meaning == Meaning::quadratic_curve || meaning == Meaning::nurbs ||
           meaning == Meaning::nurbs_end;
}

struct WordRule {
    Meaning meaning = Meaning::unknown;
    Group group = Group::once;
};

/// Of M100 to M199, which are the user's on LinuxCNC: those that printers go on at, as they set a heater or a fan.
constexpr bool sets_printer(const Code& code) {
    return code.tenths == 1040 || code.tenths == 1060 || code.tenths == 1070 || code.tenths == 1400 ||
           code.tenths == 1410;
}

/// What a G or M word means on LinuxCNC. Cost: one look into a table.
WordRule rule_for(const Code& code) noexcept;

}  // namespace trunnion::nc
