#include "detail/sinumerik_words.hpp"

#include <algorithm>
#include <array>
#include <iterator>

namespace trunnion::nc::sinumerik {

namespace {

struct Named {
    std::string_view name;
    WordRule rule;
};

constexpr Named address(std::string_view name, Address which) {
    return {name, {Meaning::address, Group::none, static_cast<int>(which)}};
}
constexpr Named named(std::string_view name, Meaning meaning, int which = 0) {
    return {name, {meaning, Group::none, which}};
}
constexpr Named grouped(std::string_view name, Meaning meaning, Group group, int which = 0) {
    return {name, {meaning, group, which}};
}

constexpr Named meanings[] = {address("CR", Address::radius),
                              address("AR", Address::angle),
                              address("TURN", Address::turn),
                              address("I1", Address::i1),
                              address("J1", Address::j1),
                              address("K1", Address::k1),
                              address("A2", Address::a2),
                              address("B2", Address::b2),
                              address("C2", Address::c2),
                              address("A3", Address::a3),
                              address("B3", Address::b3),
                              address("C3", Address::c3),
                              address("XH", Address::xh),
                              address("YH", Address::yh),
                              address("ZH", Address::zh),
                              address("PL", Address::parameter_length),
                              address("PW", Address::point_weight),
                              address("SD", Address::spline_degree),
                              address("FB", Address::feed_once),
                              address("RPL", Address::plane_angle),
                              grouped("CIP", Meaning::via_point, Group::motion),
                              grouped("CT", Meaning::tangential, Group::motion),
                              grouped("BSPLINE", Meaning::spline, Group::motion),
                              grouped("POLY", Meaning::polynomial, Group::motion),
                              named("PO", Meaning::coefficients),
                              named("SPLINEPATH", Meaning::spline_axes),
                              named("POLYPATH", Meaning::polynomial_axes),
                              grouped("SUPA", Meaning::suppress, Group::suppression),
                              named("FGROUP", Meaning::feed_group),
                              named("FGREF", Meaning::feed_reference),
                              named("FNORM", Meaning::harmless),
                              named("MSG", Meaning::message),
                              named("TRAORI", Meaning::transform_on),
                              named("TRAFOOF", Meaning::transform_off),
                              named("ORIVECT", Meaning::vectors_in_plane),
                              named("ORIPLANE", Meaning::vectors_in_plane),
                              named("ORIAXES", Meaning::axes_linear),
                              named("ORICURVE", Meaning::second_curve),
                              named("LEAD", Meaning::lead_and_tilt),
                              named("TILT", Meaning::lead_and_tilt),
                              named("ORIPATH", Meaning::lead_and_tilt),
                              named("ORIPATHS", Meaning::lead_and_tilt),
                              named("A4", Meaning::lead_and_tilt),
                              named("B4", Meaning::lead_and_tilt),
                              named("C4", Meaning::lead_and_tilt),
                              named("A5", Meaning::lead_and_tilt),
                              named("B5", Meaning::lead_and_tilt),
                              named("C5", Meaning::lead_and_tilt),
                              named("ORIWKS", Meaning::in_workpiece),
                              named("ORIMKS", Meaning::in_machine),
                              named("ORIEULER", Meaning::euler_angles),
                              named("ORIRPY", Meaning::rpy_angles),
                              named("TRANS", Meaning::translate),
                              named("ATRANS", Meaning::translate, 1),
                              named("ROT", Meaning::rotate),
                              named("AROT", Meaning::rotate, 1),
                              named("SCALE", Meaning::scale),
                              named("ASCALE", Meaning::scale, 1),
                              named("MIRROR", Meaning::mirror),
                              named("AMIRROR", Meaning::mirror, 1),
                              named("CYCLE800", Meaning::swivel),
                              named("CYCLE832", Meaning::smoothing_cycle),
                              named("CYCLE81", Meaning::drilling, 81),
                              named("CYCLE82", Meaning::drilling, 82),
                              named("CYCLE83", Meaning::drilling, 83),
                              named("CYCLE84", Meaning::drilling, 84),
                              named("CYCLE840", Meaning::drilling, 840),
                              named("CYCLE85", Meaning::drilling, 85),
                              named("CYCLE86", Meaning::drilling, 86),
                              named("CYCLE87", Meaning::drilling, 87),
                              named("CYCLE88", Meaning::drilling, 88),
                              named("CYCLE89", Meaning::drilling, 89),
                              named("HOLES1", Meaning::pattern, 1),
                              named("HOLES2", Meaning::pattern, 2),
                              named("MCALL", Meaning::modal_call),
                              named("SPOS", Meaning::spindle_event),
                              named("SPOSA", Meaning::spindle_event)};

/// Words that change dynamics within limits, smoothing, display or coordination of channels, never where the tool goes.
constexpr std::string_view ignored[] = {
    "ADIS",         "ADISPOS",     "ATOL",      "BAUTO",    "BNAT",     "BRISK",      "BRISKA",  "BTAN",
    "CDOF",         "CDOF2",       "CDON",      "CFC",      "CFCIN",    "CFIN",       "CFTCP",   "CLEARM",
    "COMPCAD",      "COMPCURV",    "COMPOF",    "COMPON",   "COMPSURF", "CTOL",       "CUT2D",   "CUT2DF",
    "CUT3DC",       "CUT3DF",      "CUT3DFF",   "CUT3DFS",  "CUTCONOF", "DIAMOF",     "DRIVE",   "DRIVEA",
    "DYNFINISH",    "DYNNORM",     "DYNPOS",    "DYNPREC",  "DYNROUGH", "DYNSEMIFIN", "EAUTO",   "ENAT",
    "ETAN",         "FENDNORM",    "FFWOF",     "FFWON",    "FIFOCTRL", "FTOCOF",     "GET",     "GETD",
    "GROUP_ADDEND", "GROUP_BEGIN", "GROUP_END", "KONT",     "KONTC",    "KONTT",      "LFOF",    "LIMS",
    "NORM",         "ORISOF",      "ORISON",    "OTOL",     "PAROTOF",  "RELEASE",    "RTLION",  "SBLOF",
    "SBLON",        "SETM",        "SETMS",     "SOFT",     "SOFTA",    "SPATH",      "SPCOF",   "SPCON",
    "STARTFIFO",    "STOPFIFO",    "STOPRE",    "STOPREOF", "TCOABS",   "TOFFOF",     "TOROTOF", "UPATH",
    "WAITE",        "WAITM",       "WAITMC",    "WAITP",    "WAITS",    "WALIMOF",    "WALIMON", "WORKPIECE"};

constexpr std::string_view changing_motion[] = {
    "A6",       "A7",       "ACC",       "ANG",      "AP",       "AROTS",    "B6",       "B7",       "C6",
    "C7",       "CHF",      "CHR",       "CROT",     "CROTS",    "CSCALE",   "CTRANS",   "CUTCONON", "CUTMOD",
    "DIAM90",   "DIAMON",   "DISC",      "DISCL",    "DISR",     "DO",       "EVERY",    "FA",       "FCUB",
    "FLIN",     "FPO",      "FRC",       "FRCM",     "FROM",     "FTOCON",   "GEOAX",    "ID",       "IDS",
    "JERKLIM",  "LEADOF",   "LEADON",    "LFON",     "LFPOS",    "MEAS",     "MEASA",    "MEAW",     "MEAWA",
    "ORIANGLE", "ORIAXPOS", "ORICONCCW", "ORICONCW", "ORICONIO", "ORICONTO", "ORIRESET", "ORIROTA",  "ORIROTC",
    "ORIROTR",  "ORIROTT",  "ORIRPY2",   "ORIVIRT1", "ORIVIRT2", "OVR",      "OVRA",     "OVRRAP",   "PAROT",
    "POS",      "POSA",     "POSP",      "PRESETON", "RND",      "RNDM",     "ROTS",     "RP",       "RTLIOF",
    "TANG",     "TANGON",   "TCARR",     "TCOFR",    "TCOFRX",   "TCOFRY",   "TCOFRZ",   "THETA",    "TOFFL",
    "TOFFON",   "TOFFR",    "TOFRAME",   "TOFRAMEX", "TOFRAMEY", "TOFRAMEZ", "TOROT",    "TOROTX",   "TOROTY",
    "TOROTZ",   "TRAANG",   "TRACON",    "TRACYL",   "TRAILON",  "TRANSMIT", "VELOLIM",  "WHEN",     "WHENEVER"};

constexpr std::string_view curves[] = {"ASPLINE", "CSPLINE", "INVCCW", "INVCW"};

constexpr std::string_view machining_cycles[] = {
    "CYCLE60",   "CYCLE61",  "CYCLE62",  "CYCLE63",  "CYCLE64",  "CYCLE70",  "CYCLE71",  "CYCLE72",
    "CYCLE73",   "CYCLE74",  "CYCLE75",  "CYCLE76",  "CYCLE77",  "CYCLE78",  "CYCLE79",  "CYCLE90",
    "CYCLE92",   "CYCLE93",  "CYCLE94",  "CYCLE95",  "CYCLE96",  "CYCLE97",  "CYCLE98",  "CYCLE99",
    "CYCLE801",  "CYCLE802", "CYCLE899", "CYCLE930", "CYCLE940", "CYCLE951", "CYCLE952", "CYCLE971",
    "CYCLE976",  "CYCLE977", "CYCLE978", "CYCLE979", "CYCLE995", "CYCLE996", "CYCLE997", "CYCLE998",
    "CYCLE4071", "LONGHOLE", "POCKET1",  "POCKET2",  "POCKET3",  "POCKET4",  "SLOT1",    "SLOT2"};

template <std::size_t n>
constexpr auto take(const std::string_view (&names)[n], Meaning meaning, auto into) {
    return std::transform(std::begin(names), std::end(names), into,
                          [meaning](std::string_view name) { return named(name, meaning); });
}

constexpr auto table = [] {
    std::array<Named, std::size(meanings) + std::size(ignored) + std::size(changing_motion) + std::size(curves) +
                          std::size(machining_cycles)>
        all{};
    auto next = std::copy(std::begin(meanings), std::end(meanings), all.begin());
    next = take(ignored, Meaning::ignored, next);
    next = take(changing_motion, Meaning::changes_motion, next);
    next = take(curves, Meaning::curve, next);
    take(machining_cycles, Meaning::machining_cycle, next);
    std::sort(all.begin(), all.end(), [](const Named& a, const Named& b) { return a.name < b.name; });
    return all;
}();

constexpr bool listed_once = [] {
    for (std::size_t i = 1; i < table.size(); ++i)
        if (table[i - 1].name == table[i].name) return false;
    return true;
}();
static_assert(listed_once);

constexpr int most_g = 1000;

struct Numbered {
    int number;
    WordRule rule;
};

constexpr Numbered g_meanings[] = {
    {0, {Meaning::rapid, Group::motion}},
    {1, {Meaning::line, Group::motion}},
    {2, {Meaning::clockwise, Group::motion}},
    {3, {Meaning::counter_clockwise, Group::motion}},
    {4, {Meaning::dwell, Group::once}},
    {9, {Meaning::exact_stop_once, Group::none}},
    {17, {Meaning::plane, Group::plane, 2}},
    {18, {Meaning::plane, Group::plane, 1}},
    {19, {Meaning::plane, Group::plane, 0}},
    {40, {Meaning::harmless, Group::compensation}},
    {41, {Meaning::compensation, Group::compensation}},
    {42, {Meaning::compensation, Group::compensation}},
    {53, {Meaning::suppress, Group::suppression}},
    {153, {Meaning::suppress, Group::suppression}},
    {60, {Meaning::exact_stop, Group::path_control}},
    {70, {Meaning::unit_inch, Group::unit}},
    {71, {Meaning::unit_mm, Group::unit}},
    {700, {Meaning::unit_inch_feed, Group::unit}},
    {710, {Meaning::unit_mm_feed, Group::unit}},
    {90, {Meaning::absolute, Group::distance}},
    {91, {Meaning::incremental, Group::distance}},
    {93, {Meaning::inverse_time, Group::feed_kind}},
    {94, {Meaning::per_minute, Group::feed_kind}},
    {971, {Meaning::per_minute, Group::feed_kind}},
    {95, {Meaning::per_revolution, Group::feed_kind}},
    {97, {Meaning::per_revolution, Group::feed_kind}},
};
constexpr int g_offsets[] = {54, 55, 56, 57, 500};
constexpr int first_further_offset = 505, last_further_offset = 599;
constexpr int g_continuous[] = {64, 641, 642, 643, 644, 645};
constexpr int g_lathe[] = {96, 961, 962, 972};
/// They matter to G41 and G42 alone, choose among exact stops, or say that the program is no ISO program.
constexpr int g_harmless[] = {62, 140, 141, 142, 143, 290, 450, 451, 460, 461, 462, 601, 602, 603};
constexpr int g_changing_motion[] = {5,   7,   25,  26,  33,  34,  35,  58,  59,  63,  74,  75,  110, 111, 112,
                                     147, 148, 247, 248, 291, 331, 332, 335, 336, 340, 341, 347, 348, 621};

constexpr auto g_table = [] {
    std::array<WordRule, most_g> rules{};
    const auto set = [&](int number, const WordRule& rule) { rules[static_cast<std::size_t>(number)] = rule; };
    for (const Numbered& g : g_meanings) set(g.number, g.rule);
    for (const int number : g_offsets) set(number, {Meaning::offset, Group::offset});
    for (int number = first_further_offset; number <= last_further_offset; ++number)
        set(number, {Meaning::offset, Group::offset});
    for (const int number : g_continuous) set(number, {Meaning::continuous, Group::path_control});
    for (const int number : g_lathe) set(number, {Meaning::lathe_feed, Group::feed_kind});
    for (const int number : g_harmless) set(number, {Meaning::harmless, Group::none});
    for (const int number : g_changing_motion) set(number, {Meaning::changes_motion, Group::none});
    return rules;
}();

}  // namespace

WordRule rule_of_name(std::string_view name) noexcept {
    const auto* const found = std::lower_bound(table.begin(), table.end(), name,
                                               [](const Named& word, std::string_view n) { return word.name < n; });
    return found != table.end() && found->name == name ? found->rule : WordRule{};
}

bool is_word(std::string_view name) noexcept {
    return rule_of_name(name).meaning != Meaning::unknown;
}

WordRule rule_of_g(int number) noexcept {
    return number >= 0 && number < most_g ? g_table[static_cast<std::size_t>(number)] : WordRule{};
}

WordRule rule_of_m(int number) noexcept {
    switch (number) {
        case 0:
        case 1:
            return {Meaning::pause};
        case 2:
        case 17:
        case 30:
            return {Meaning::end};
        case 3:
        case 4:
        case 5:
        case 19:
        case 40:
        case 41:
        case 42:
        case 43:
        case 44:
        case 45:
        case 70:
            return {Meaning::spindle};
        case 6:
            return {Meaning::tool_change};
        case 7:
        case 8:
        case 9:
            return {Meaning::coolant};
        default:
            return {Meaning::event};
    }
}

}  // namespace trunnion::nc::sinumerik
