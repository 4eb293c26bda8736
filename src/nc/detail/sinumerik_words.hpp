#pragma once

#include <cstdint>
#include <string_view>

namespace trunnion::nc::sinumerik {

/// Addresses whose values a block holds: `X10`, `CR=5`, `A3=0.1`. Each once in a block.
enum class Address : std::uint8_t {
    x,
    y,
    z,
    rotary_1,  // in the machine's order
    rotary_2,
    rotary_3,
    i,
    j,
    k,
    i1,
    j1,
    k1,
    radius,  // CR
    angle,   // AR
    turn,
    a2,
    b2,
    c2,
    a3,
    b3,
    c3,
    xh,
    yh,
    zh,
    parameter_length,  // PL
    point_weight,      // PW
    spline_degree,     // SD
    feed,
    feed_once,    // FB
    plane_angle,  // RPL
    speed,        // S
    count
};

/// What a word does. Words of one modal group contradict each other in a block.
enum class Meaning : std::uint8_t {
    unknown,
    address,  // which: Address
    harmless,
    ignored,  // harmless, and told
    event,
    spindle_event,  // SPOS, M19 and the like
    message,
    changes_motion,  // refused from here on
    curve,
    lead_and_tilt,
    compensation,
    machining_cycle,
    lathe_feed,
    // motion
    rapid,
    line,
    clockwise,
    counter_clockwise,
    via_point,
    tangential,
    spline,
    polynomial,
    dwell,
    // modes
    plane,     // which: 0 … 2, the axis across
    offset,    // G500, G54, …
    suppress,  // G53, G153, SUPA
    exact_stop,
    exact_stop_once,
    smoothing_cycle,  // CYCLE832
    continuous,
    unit_inch,
    unit_mm,
    unit_inch_feed,
    unit_mm_feed,
    absolute,
    incremental,
    inverse_time,
    per_minute,
    per_revolution,
    feed_group,
    feed_reference,
    // orientation
    transform_on,
    transform_off,
    vectors_in_plane,
    axes_linear,
    in_workpiece,
    in_machine,
    euler_angles,
    rpy_angles,
    second_curve,     // ORICURVE
    spline_axes,      // SPLINEPATH
    polynomial_axes,  // POLYPATH
    coefficients,     // PO
    // frames; which: 1 = on top of what is in force
    translate,
    rotate,
    scale,
    mirror,
    swivel,
    // calls
    drilling,  // which: its number, 81 … 89, 84 | rigid, 0 = CYCLE840
    pattern,   // which: 1, 2
    modal_call,
    // M words
    pause,
    end,
    tool_change,
    spindle,
    coolant
};

/// Modal groups, after the control's G groups where it has them.
enum class Group : std::uint8_t {
    none,
    motion,
    plane,
    suppression,
    offset,
    path_control,
    unit,
    distance,
    feed_kind,
    compensation,
    once,
    count
};

struct WordRule {
    Meaning meaning = Meaning::unknown;
    Group group = Group::none;
    int which = 0;
};

/// An address of several characters or an identifier, in capitals. Cost: a search in a sorted table.
WordRule rule_of_name(std::string_view name) noexcept;

/// Whether the control itself knows this identifier: what the interpreter asks.
bool is_word(std::string_view name) noexcept;

/// G and M words. An M word without a meaning of its own is an event of the machine's.
WordRule rule_of_g(int number) noexcept;
WordRule rule_of_m(int number) noexcept;

}  // namespace trunnion::nc::sinumerik
