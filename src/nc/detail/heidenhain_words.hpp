#pragma once

#include <cstdint>
#include <string_view>

namespace trunnion::nc::heidenhain {

/// What a block does, by the words that it begins with.
enum class BlockKind : std::uint8_t {
    unknown,
    line,              ///< L
    line_with_vector,  ///< LN
    polar_line,        ///< LP
    centre,            ///< CC
    circle,            ///< C
    circle_by_radius,  ///< CR
    tangential,        ///< CT
    polar_circle,      ///< CP
    rounding,          ///< RND
    chamfer,           ///< CHF
    words,             ///< M words, or paraxial positions, alone
    begin,             ///< BEGIN PGM
    blank,             ///< BLK FORM
    tool,              ///< TOOL
    cycle,             ///< CYCL
    plane,             ///< PLANE
    function,          ///< FUNCTION
    shift,             ///< TRANS DATUM
    stop,              ///< STOP
    contour,           ///< APPR, DEP, FK, SPL: the control works out the path
    other_control      ///< understood, but of the control's own tables and probes: refused
};

/// `name` in capitals: the letters that the block begins with.
BlockKind kind_of_block(std::string_view name);

/// What an M function means for motion.
enum class Function : std::uint8_t {
    event,           ///< takes its place among the moves
    stop,            ///< M0, M1
    end,             ///< M2, M30
    spindle,         ///< M3, M4, M13, M14 at the start of the block
    spindle_off,     ///< M5 at the end of the block
    coolant,         ///< M8
    coolant_off,     ///< M9, at the end of the block
    tool_change,     ///< M6
    modal_call,      ///< M89
    block_call,      ///< M99
    machine_datum,   ///< M91
    reduce,          ///< M94
    rotary_mm,       ///< M116
    rotary_degrees,  ///< M117
    shortest,        ///< M126
    literal,         ///< M127
    transform_on,    ///< M128
    transform_off,   ///< M129
    per_turn,        ///< M136
    per_minute,      ///< M137
    retract,         ///< M140
    harmless,        ///< says what is so anyway
    ignored,         ///< cannot change the programmed path; with a warning
    refused
};
Function function_of(int number);

}  // namespace trunnion::nc::heidenhain
