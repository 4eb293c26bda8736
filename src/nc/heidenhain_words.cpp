#include "detail/heidenhain_words.hpp"

#include <algorithm>
#include <array>
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

struct Numbered {
    int number;
    Function function;
};
constexpr Numbered functions[] = {
    {0, Function::stop},
    {1, Function::stop},
    {2, Function::end},
    {30, Function::end},
    {3, Function::spindle},
    {4, Function::spindle},
    {13, Function::spindle},
    {14, Function::spindle},
    {5, Function::spindle_off},
    {6, Function::tool_change},
    {8, Function::coolant},
    {9, Function::coolant_off},
    {89, Function::modal_call},
    {99, Function::block_call},
    {91, Function::machine_datum},
    {94, Function::reduce},
    {116, Function::rotary_mm},
    {117, Function::rotary_degrees},
    {126, Function::shortest},
    {127, Function::literal},
    {128, Function::transform_on},
    {129, Function::transform_off},
    {136, Function::per_turn},
    {137, Function::per_minute},
    {140, Function::retract},
};
constexpr int harmless[] = {90, 102, 104, 105, 106, 107, 108, 111, 113, 115, 121, 135, 141, 143, 145, 149, 150};
constexpr int ignored[] = {97, 98, 101, 118, 120, 124, 138, 148};
constexpr int refused[] = {92, 103, 109, 110, 112, 114, 130, 133, 134, 144};

constexpr auto function_table = [] {
    std::array<Function, 151> all{};
    all.fill(Function::event);
    const auto set = [&](int number, Function function) { all[static_cast<std::size_t>(number)] = function; };
    for (const Numbered& m : functions) set(m.number, m.function);
    for (const int number : harmless) set(number, Function::harmless);
    for (const int number : ignored) set(number, Function::ignored);
    for (const int number : refused) set(number, Function::refused);
    return all;
}();

}  // namespace

BlockKind kind_of_block(std::string_view name) {
    if (name == "L") return BlockKind::line;
    const auto* const found = std::ranges::find(blocks, name, &Named::name);
    return found == std::end(blocks) ? BlockKind::unknown : found->kind;
}

Function function_of(int number) {
    const bool listed = number >= 0 && number < static_cast<int>(function_table.size());
    return listed ? function_table[static_cast<std::size_t>(number)] : Function::event;
}

}  // namespace trunnion::nc::heidenhain
