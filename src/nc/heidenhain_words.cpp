#include "detail/heidenhain_words.hpp"

#include <algorithm>
#include <iterator>

#include "detail/dialects.hpp"
#include "detail/heidenhain_text.hpp"
#include "detail/text.hpp"

namespace trunnion::nc {

namespace {

/// An axis with its value behind L or LN: no other dialect has a blank there.
bool is_position(std::string_view words) {
    if (words.empty() || !is_blank(words.front())) return false;
    words = skip_blanks(words);
    if (words.size() > 1 && upper(words.front()) == 'I') words.remove_prefix(1);
    constexpr std::string_view letters = "XYZABCUVW";
    return words.size() > 1 && letters.find(upper(words.front())) != letters.npos && starts_number(words[1]);
}

}  // namespace

/// A block number may stand in front, and a comment behind.
bool is_heidenhain_line(std::string_view line) noexcept {
    while (!line.empty() && is_digit(line.front())) line.remove_prefix(1);
    line = skip_blanks(line);
    const auto starts = [&](std::string_view first, std::string_view second) {
        if (!reads(line.substr(0, first.size()), first)) return false;
        const std::string_view rest = skip_blanks(line.substr(first.size()));
        const bool apart = rest.size() + first.size() < line.size();
        const bool whole =
            rest.size() == second.size() || (rest.size() > second.size() && !is_letter(rest[second.size()]));
        return apart && whole && reads(rest.substr(0, second.size()), second);
    };
    if (starts("BEGIN", "PGM") || starts("BLK", "FORM") || starts("TOOL", "CALL") || starts("TOOL", "DEF") ||
        starts("CYCL", "DEF") || starts("FUNCTION", "TCPM") || starts("CALL", "LBL"))
        return true;
    if (line.size() < 2 || upper(line.front()) != 'L') return false;
    return is_position(line.substr(upper(line[1]) == 'N' ? 2 : 1));
}

}  // namespace trunnion::nc

namespace trunnion::nc::heidenhain {

namespace {

struct Named {
    std::string_view name;
    BlockKind kind;
};
constexpr Named blocks[] = {
    {"C", BlockKind::circle},
    {"CC", BlockKind::centre},
    {"CR", BlockKind::circle_by_radius},
    {"CT", BlockKind::tangential},
    {"CP", BlockKind::polar_circle},
    {"LN", BlockKind::line_with_vector},
    {"LP", BlockKind::polar_line},
    {"RND", BlockKind::rounding},
    {"CHF", BlockKind::chamfer},
    {"M", BlockKind::words},
    {"X", BlockKind::words},
    {"Y", BlockKind::words},
    {"Z", BlockKind::words},
    {"A", BlockKind::words},
    {"B", BlockKind::words},
    {"S", BlockKind::words},
    {"BEGIN", BlockKind::begin},
    {"BLK", BlockKind::blank},
    {"TOOL", BlockKind::tool},
    {"CYCL", BlockKind::cycle},
    {"PLANE", BlockKind::plane},
    {"FUNCTION", BlockKind::function},
    {"TRANS", BlockKind::shift},
    {"STOP", BlockKind::stop},
    {"APPR", BlockKind::contour},
    {"DEP", BlockKind::contour},
    {"CTP", BlockKind::contour},
    {"FL", BlockKind::contour},
    {"FLT", BlockKind::contour},
    {"FC", BlockKind::contour},
    {"FCT", BlockKind::contour},
    {"FPOL", BlockKind::contour},
    {"FSELECT", BlockKind::contour},
    {"SPL", BlockKind::contour},
    {"PATTERN", BlockKind::other_control},
    {"SEL", BlockKind::other_control},
    {"TCH", BlockKind::other_control},
    {"DECLARE", BlockKind::other_control},
    {"OPEN", BlockKind::other_control},
    {"POLARKIN", BlockKind::other_control},
};

}  // namespace

BlockKind kind_of_block(std::string_view name) {
    if (name == "L") return BlockKind::line;
    const auto* const found = std::ranges::find(blocks, name, &Named::name);
    return found == std::end(blocks) ? BlockKind::unknown : found->kind;
}

Function function_of(int number) {
    switch (number) {
        case 0:
        case 1:
            return Function::stop;
        case 2:
        case 30:
            return Function::end;
        case 3:
        case 4:
        case 13:
        case 14:
            return Function::spindle;
        case 5:
            return Function::spindle_off;
        case 6:
            return Function::tool_change;
        case 8:
            return Function::coolant;
        case 9:
            return Function::coolant_off;
        case 89:
            return Function::modal_call;
        case 99:
            return Function::block_call;
        case 91:
            return Function::machine_datum;
        case 94:
            return Function::reduce;
        case 116:
            return Function::rotary_mm;
        case 117:
            return Function::rotary_degrees;
        case 126:
            return Function::shortest;
        case 127:
            return Function::literal;
        case 128:
            return Function::transform_on;
        case 129:
            return Function::transform_off;
        case 136:
            return Function::per_turn;
        case 137:
            return Function::per_minute;
        case 140:
            return Function::retract;
        case 90:
        case 102:
        case 104:
        case 105:
        case 106:
        case 107:
        case 108:
        case 111:
        case 113:
        case 115:
        case 121:
        case 135:
        case 141:
        case 143:
        case 145:
        case 149:
        case 150:
            return Function::harmless;
        case 97:
        case 98:
        case 101:
        case 118:
        case 120:
        case 124:
        case 138:
        case 148:
            return Function::ignored;
        case 92:
        case 103:
        case 109:
        case 110:
        case 112:
        case 114:
        case 130:
        case 133:
        case 134:
        case 144:
            return Function::refused;
        default:
            return Function::event;
    }
}

}  // namespace trunnion::nc::heidenhain
