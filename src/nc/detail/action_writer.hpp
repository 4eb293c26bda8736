#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "trunnion/program/program.hpp"

namespace trunnion::nc {

/// What an event asks of a machine, whatever the dialect its word is of.
struct Action {
    enum class Kind : std::uint8_t {
        dwell,          ///< number: s
        spindle_speed,  ///< number: 1/min
        spindle_clockwise,
        spindle_counter_clockwise,
        spindle_off,
        mist,
        flood,
        coolant_off,
        pause,
        optional_pause,
        end,
        prepare_tool,  ///< name
        change_tool,   ///< name; empty: the one that was prepared
        unknown
    };
    Kind kind = Kind::unknown;
    double number = 0;
    std::string_view name{};
};

/// The actions of an event, by its word in any dialect that is read; one of kind unknown where it is not understood.
/// Views into the event.
std::vector<Action> actions_of(const program::Event& event);

}  // namespace trunnion::nc
