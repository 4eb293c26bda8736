#include "detail/rs274_words.hpp"

#include <array>
#include <span>

namespace trunnion::nc {

namespace {

struct Entry {
    int tenths;
    Meaning meaning;
    Group group;
};

constexpr Entry g_words[] = {
    {0, Meaning::rapid, Group::motion},
    {10, Meaning::feed, Group::motion},
    {20, Meaning::clockwise_arc, Group::motion},
    {30, Meaning::counter_clockwise_arc, Group::motion},
    {50, Meaning::cubic_curve, Group::motion},
    {51, Meaning::quadratic_curve, Group::motion},
    {52, Meaning::nurbs, Group::motion},
    {53, Meaning::nurbs_end, Group::motion},
    {800, Meaning::no_motion, Group::motion},
    {330, Meaning::changes_motion, Group::motion},
    {331, Meaning::changes_motion, Group::motion},
    {382, Meaning::changes_motion, Group::motion},
    {383, Meaning::changes_motion, Group::motion},
    {384, Meaning::changes_motion, Group::motion},
    {385, Meaning::changes_motion, Group::motion},
    {730, Meaning::cycle, Group::motion},
    {740, Meaning::cycle, Group::motion},
    {760, Meaning::changes_motion, Group::motion},
    {810, Meaning::cycle, Group::motion},
    {820, Meaning::cycle, Group::motion},
    {830, Meaning::cycle, Group::motion},
    {840, Meaning::cycle, Group::motion},
    {850, Meaning::cycle, Group::motion},
    {860, Meaning::cycle, Group::motion},
    {870, Meaning::changes_motion, Group::motion},
    {880, Meaning::changes_motion, Group::motion},
    {890, Meaning::cycle, Group::motion},
    {40, Meaning::dwell, Group::once},
    {100, Meaning::set_data, Group::shift},
    {280, Meaning::go_home, Group::shift},
    {281, Meaning::harmless, Group::shift},
    {300, Meaning::go_home, Group::shift},
    {301, Meaning::harmless, Group::shift},
    {520, Meaning::local_shift, Group::shift},
    {530, Meaning::machine_position, Group::once},
    {920, Meaning::shift_to_here, Group::shift},
    {921, Meaning::end_shift, Group::shift},
    {922, Meaning::pause_shift, Group::shift},
    {923, Meaning::resume_shift, Group::shift},
    {170, Meaning::plane, Group::plane},
    {180, Meaning::plane, Group::plane},
    {190, Meaning::plane, Group::plane},
    {200, Meaning::inch, Group::units},
    {210, Meaning::mm, Group::units},
    {400, Meaning::harmless, Group::cutter},
    {410, Meaning::changes_motion, Group::cutter},
    {411, Meaning::changes_motion, Group::cutter},
    {420, Meaning::changes_motion, Group::cutter},
    {421, Meaning::changes_motion, Group::cutter},
    {430, Meaning::tool_length, Group::tool_length},
    {431, Meaning::changes_motion, Group::tool_length},
    {432, Meaning::changes_motion, Group::tool_length},
    {490, Meaning::own_tool_length, Group::tool_length},
    {540, Meaning::offset, Group::offset},
    {550, Meaning::offset, Group::offset},
    {560, Meaning::offset, Group::offset},
    {570, Meaning::offset, Group::offset},
    {580, Meaning::offset, Group::offset},
    {590, Meaning::offset, Group::offset},
    {591, Meaning::offset, Group::offset},
    {592, Meaning::offset, Group::offset},
    {593, Meaning::offset, Group::offset},
    {610, Meaning::exact_stop, Group::path_control},
    {611, Meaning::exact_stop, Group::path_control},
    {640, Meaning::continuous, Group::path_control},
    {70, Meaning::changes_motion, Group::diameter},
    {80, Meaning::harmless, Group::diameter},
    {680, Meaning::changes_motion, Group::once},
    {690, Meaning::harmless, Group::once},
    {900, Meaning::absolute, Group::distance},
    {910, Meaning::incremental, Group::distance},
    {901, Meaning::absolute_centre, Group::arc_distance},
    {911, Meaning::incremental_centre, Group::arc_distance},
    {930, Meaning::inverse_time, Group::feed_mode},
    {940, Meaning::per_minute, Group::feed_mode},
    {950, Meaning::per_turn, Group::feed_mode},
    {960, Meaning::changes_motion, Group::spindle_mode},
    {970, Meaning::harmless, Group::spindle_mode},
    {980, Meaning::initial_level, Group::return_mode},
    {990, Meaning::retract_plane, Group::return_mode},
};

constexpr Entry m_words[] = {
    {0, Meaning::pause, Group::stop},
    {10, Meaning::pause, Group::stop},
    {20, Meaning::end, Group::stop},
    {300, Meaning::end, Group::stop},
    {600, Meaning::pause, Group::stop},
    {30, Meaning::spindle, Group::spindle},
    {40, Meaning::spindle, Group::spindle},
    {50, Meaning::spindle, Group::spindle},
    {60, Meaning::tool_change, Group::tool_change},
    {70, Meaning::coolant, Group::mist},
    {80, Meaning::coolant, Group::flood},
    {90, Meaning::coolant, Group::flood},
    {480, Meaning::harmless, Group::override_switch},  // the operator's override knobs
    {490, Meaning::harmless, Group::override_switch},
    {500, Meaning::harmless, Group::override_switch},
    {510, Meaning::harmless, Group::override_switch},
    {520, Meaning::harmless, Group::override_switch},
    {530, Meaning::harmless, Group::override_switch},
    {190, Meaning::spindle, Group::spindle},
    {610, Meaning::tool_in_spindle, Group::tool_change},
    {620, Meaning::pin, Group::pins},
    {630, Meaning::pin, Group::pins},
    {640, Meaning::pin, Group::pins},
    {650, Meaning::pin, Group::pins},
    {660, Meaning::wait_for_pin, Group::pins},
    {670, Meaning::pin, Group::pins},
    {680, Meaning::pin, Group::pins},
    {700, Meaning::keep_state, Group::state},
    {710, Meaning::forget_state, Group::state},
    {720, Meaning::restore_state, Group::state},
    {730, Meaning::keep_state_till_return, Group::state},
    {820, Meaning::absolute_following, Group::following_distance},
    {830, Meaning::incremental_following, Group::following_distance},
    {840, Meaning::printing, Group::user},
    {980, Meaning::call_program, Group::subprogram},
    {990, Meaning::return_from_program, Group::subprogram},
};

constexpr std::size_t table_size = 1000;
using Table = std::array<WordRule, table_size>;

constexpr Table table_of(std::span<const Entry> entries) {
    Table table{};
    for (const Entry& entry : entries) table[static_cast<std::size_t>(entry.tenths)] = {entry.meaning, entry.group};
    return table;
}

constexpr Table g_table = table_of(g_words);
constexpr Table m_table = table_of(m_words);

/// M words from M100 on: up to M199 they are the user's own; of the further ones of 3D printers those that set
/// accelerations, jerks, advance, flow and motor currents, or wait.
constexpr WordRule further_m_word(int tenths) {
    if (tenths % 10 != 0) return {};
    if (tenths < 2000) return {Meaning::user_word, Group::user};
    for (const int number : {201, 203, 204, 205, 221, 900, 907})
        if (tenths == 10 * number) return {Meaning::printing, Group::user};
    if (tenths == 4000) return {Meaning::wait_for_pin, Group::pins};
    return {};
}

/// Our own words for surfaces: numbers that no control of this dialect and of Fanuc's has.
constexpr WordRule surface_word(int tenths) {
    switch (tenths) {
        case 3200:
            return {Meaning::surface_net, Group::surface};
        case 3210:
            return {Meaning::surface_polynomial, Group::surface};
        case 3220:
            return {Meaning::surface_end, Group::surface};
        case 3230:
            return {Meaning::surface_conditions, Group::surface};
        case 3240:
            return {Meaning::surface_machining, Group::motion};
        default:
            return {};
    }
}

}  // namespace

WordRule rule_for(const Code& code) noexcept {
    const auto tenths = static_cast<std::size_t>(code.tenths);
    if (tenths >= table_size) return code.letter == 'M' ? further_m_word(code.tenths) : surface_word(code.tenths);
    return (code.letter == 'G' ? g_table : m_table)[tenths];
}

}  // namespace trunnion::nc
