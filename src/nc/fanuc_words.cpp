#include "detail/fanuc_words.hpp"

#include <array>
#include <cstddef>

namespace trunnion::nc::fanuc {

namespace {

struct Entry {
    int tenths;
    Meaning meaning;
    Group group = Group::once;
};

constexpr Entry g_words[] = {
    {0, Meaning::rapid, Group::motion},
    {10, Meaning::line, Group::motion},
    {20, Meaning::clockwise, Group::motion},
    {30, Meaning::counter_clockwise, Group::motion},
    {62, Meaning::nurbs, Group::motion},
    {40, Meaning::dwell},
    {50, Meaning::ignored, Group::path_control},  // high-speed modes: how the control follows the path
    {51, Meaning::ignored, Group::path_control},
    {80, Meaning::ignored, Group::path_control},
    {90, Meaning::exact_stop_once},
    {100, Meaning::data},
    {110, Meaning::harmless},  // ends G10 L50
    {150, Meaning::harmless},  // polar coordinates cannot be on
    {170, Meaning::plane, Group::plane},
    {180, Meaning::plane, Group::plane},
    {190, Meaning::plane, Group::plane},
    {200, Meaning::inch, Group::units},
    {210, Meaning::mm, Group::units},
    {220, Meaning::harmless},  // stored stroke check
    {230, Meaning::harmless},
    {280, Meaning::reference},
    {300, Meaning::reference},
    {301, Meaning::reference},
    {400, Meaning::harmless, Group::compensation},
    {410, Meaning::compensation, Group::compensation},
    {412, Meaning::compensation, Group::compensation},
    {420, Meaning::compensation, Group::compensation},
    {422, Meaning::compensation, Group::compensation},
    {430, Meaning::length, Group::length},
    {434, Meaning::tcp_rotary, Group::length},
    {435, Meaning::tcp_vector, Group::length},
    {490, Meaning::no_length, Group::length},
    {491, Meaning::no_length, Group::length},
    {500, Meaning::harmless},  // scaling cannot be on
    {501, Meaning::no_mirror, Group::mirror},
    {511, Meaning::mirror, Group::mirror},
    {520, Meaning::local_shift},
    {530, Meaning::machine_position},
    {531, Meaning::swivel},
    {536, Meaning::swivel},
    {540, Meaning::offset, Group::offset},
    {541, Meaning::numbered_offset, Group::offset},
    {550, Meaning::offset, Group::offset},
    {560, Meaning::offset, Group::offset},
    {570, Meaning::offset, Group::offset},
    {580, Meaning::offset, Group::offset},
    {590, Meaning::offset, Group::offset},
    {610, Meaning::exact_stop, Group::path_control},
    {611, Meaning::ignored, Group::path_control},
    {620, Meaning::ignored, Group::path_control},
    {630, Meaning::ignored, Group::path_control},
    {640, Meaning::continuous, Group::path_control},
    {680, Meaning::rotation, Group::turned},
    {682, Meaning::tilted_plane, Group::turned},
    {690, Meaning::no_rotation, Group::turned},
    {730, Meaning::cycle, Group::cycle},
    {740, Meaning::cycle, Group::cycle},
    {760, Meaning::cycle, Group::cycle},
    {800, Meaning::no_cycle, Group::cycle},
    {810, Meaning::cycle, Group::cycle},
    {820, Meaning::cycle, Group::cycle},
    {830, Meaning::cycle, Group::cycle},
    {840, Meaning::cycle, Group::cycle},
    {850, Meaning::cycle, Group::cycle},
    {860, Meaning::cycle, Group::cycle},
    {870, Meaning::cycle, Group::cycle},
    {880, Meaning::cycle, Group::cycle},
    {890, Meaning::cycle, Group::cycle},
    {900, Meaning::absolute, Group::distance},
    {910, Meaning::incremental, Group::distance},
    {920, Meaning::preset},
    {921, Meaning::no_preset},
    {930, Meaning::inverse_time, Group::feed_mode},
    {940, Meaning::per_minute, Group::feed_mode},
    {950, Meaning::per_revolution, Group::feed_mode},
    {970, Meaning::harmless},
    {980, Meaning::return_initial, Group::return_level},
    {990, Meaning::return_r, Group::return_level},
    {1030, Meaning::ignored},  // HAAS: how far the control reads ahead
    {1540, Meaning::numbered_offset, Group::offset},
    {1870, Meaning::ignored},  // HAAS: smoothness
    {2340, Meaning::tcp_rotary, Group::length},
    {2540, Meaning::dynamic_offset, Group::dynamic},
    {2550, Meaning::no_dynamic_offset, Group::dynamic},
};

/// Refused by name, so that the message can say more than that they are not known.
constexpr int motion_changing_g[] = {21,   22,   23,   24,   32,   33,   34,   41,   60,   70,   71,  121, 131, 101,
                                     106,  107,  120,  130,  160,  270,  290,  310,  330,  340,  411, 413, 414, 416,
                                     421,  423,  424,  426,  431,  433,  437,  438,  439,  440,  450, 460, 470, 480,
                                     510,  542,  543,  544,  600,  683,  684,  700,  710,  720,  770, 780, 801, 960,
                                     1000, 1010, 1070, 1430, 1500, 1530, 1550, 1740, 1840, 2530, 2680};

constexpr Entry m_words[] = {
    {0, Meaning::pause, Group::stop}, {10, Meaning::pause, Group::stop},
    {20, Meaning::end, Group::stop},  {300, Meaning::end, Group::stop},
    {30, Meaning::spindle},           {40, Meaning::spindle},
    {50, Meaning::spindle},           {60, Meaning::tool_change, Group::tool_change},
    {70, Meaning::coolant},           {80, Meaning::coolant},
    {90, Meaning::coolant},           {960, Meaning::changes_motion},  // macro interrupt, HAAS: jump on an input
    {1260, Meaning::tcp_word},  // rotary axes the short way, and its end, on several ISO controls
    {1270, Meaning::tcp_word},        {1280, Meaning::tcp_word},        // tool centre point on, off
    {1290, Meaning::tcp_word},        {1980, Meaning::changes_motion},  // a subprogram elsewhere
};

constexpr std::size_t table_size = 2700;
using Table = std::array<WordRule, table_size>;

constexpr Table g_table = [] {
    Table table{};
    for (const Entry& entry : g_words) table[static_cast<std::size_t>(entry.tenths)] = {entry.meaning, entry.group};
    for (const int tenths : motion_changing_g) table[static_cast<std::size_t>(tenths)] = {Meaning::changes_motion};
    for (std::size_t tenths = 1100; tenths <= 1290; tenths += 10)  // HAAS: G110 … G129 are work offsets
        table[tenths] = {Meaning::offset, Group::offset};
    return table;
}();

constexpr Table m_table = [] {
    Table table{};
    for (std::size_t tenths = 0; tenths < table_size; tenths += 10) table[tenths] = {Meaning::event};
    for (const Entry& entry : m_words) table[static_cast<std::size_t>(entry.tenths)] = {entry.meaning, entry.group};
    return table;
}();

}  // namespace

WordRule rule_of_g(int tenths) noexcept {
    return tenths >= 0 && tenths < static_cast<int>(table_size) ? g_table[static_cast<std::size_t>(tenths)]
                                                                : WordRule{};
}

WordRule rule_of_m(int tenths) noexcept {
    if (tenths >= 0 && tenths < static_cast<int>(table_size)) return m_table[static_cast<std::size_t>(tenths)];
    return tenths > 0 && tenths % 10 == 0 ? WordRule{Meaning::event} : WordRule{};
}

}  // namespace trunnion::nc::fanuc
