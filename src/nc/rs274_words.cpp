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
    {50, Meaning::spline, Group::motion},
    {51, Meaning::spline, Group::motion},
    {52, Meaning::spline, Group::motion},
    {53, Meaning::spline, Group::motion},
    {800, Meaning::no_motion, Group::motion},
    {330, Meaning::changes_motion, Group::motion},
    {331, Meaning::changes_motion, Group::motion},
    {382, Meaning::changes_motion, Group::motion},
    {383, Meaning::changes_motion, Group::motion},
    {384, Meaning::changes_motion, Group::motion},
    {385, Meaning::changes_motion, Group::motion},
    {730, Meaning::changes_motion, Group::motion},
    {740, Meaning::changes_motion, Group::motion},
    {760, Meaning::changes_motion, Group::motion},
    {810, Meaning::changes_motion, Group::motion},
    {820, Meaning::changes_motion, Group::motion},
    {830, Meaning::changes_motion, Group::motion},
    {840, Meaning::changes_motion, Group::motion},
    {850, Meaning::changes_motion, Group::motion},
    {860, Meaning::changes_motion, Group::motion},
    {870, Meaning::changes_motion, Group::motion},
    {880, Meaning::changes_motion, Group::motion},
    {890, Meaning::changes_motion, Group::motion},
    {40, Meaning::dwell, Group::once},
    {100, Meaning::changes_motion, Group::once},
    {280, Meaning::changes_motion, Group::once},
    {300, Meaning::changes_motion, Group::once},
    {520, Meaning::changes_motion, Group::shift},
    {530, Meaning::machine_position, Group::once},
    {920, Meaning::changes_motion, Group::shift},
    {921, Meaning::harmless, Group::shift},  // no shift can be active
    {922, Meaning::harmless, Group::shift},
    {923, Meaning::changes_motion, Group::shift},
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
    {950, Meaning::changes_motion, Group::feed_mode},
    {970, Meaning::harmless, Group::spindle_mode},
    {980, Meaning::harmless, Group::return_mode},
    {990, Meaning::harmless, Group::return_mode},
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

}  // namespace

WordRule rule_for(const Code& code) noexcept {
    const auto tenths = static_cast<std::size_t>(code.tenths);
    if (tenths >= table_size) return {};
    return (code.letter == 'G' ? g_table : m_table)[tenths];
}

}  // namespace trunnion::nc
