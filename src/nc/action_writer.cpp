#include "detail/action_writer.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include "trunnion/base/number.hpp"

#include "detail/text.hpp"

namespace trunnion::nc {

using Kind = Action::Kind;

namespace {

std::optional<double> whole_number(std::string_view text) {
    const auto value = take_number(text);
    return text.empty() ? value : std::nullopt;
}

Action of_m_word(int number) {
    switch (number) {
        case 0:
            return {Kind::pause};
        case 1:
            return {Kind::optional_pause};
        case 2:
        case 30:
            return {Kind::end};
        case 3:
            return {Kind::spindle_clockwise};
        case 4:
            return {Kind::spindle_counter_clockwise};
        case 5:
            return {Kind::spindle_off};
        case 6:
            return {Kind::change_tool};
        case 7:
            return {Kind::mist};
        case 8:
            return {Kind::flood};
        case 9:
            return {Kind::coolant_off};
        default:
            return {};
    }
}

std::string_view without_quotes(std::string_view text) {
    if (text.starts_with('=')) text.remove_prefix(1);
    if (text.size() >= 2 && text.front() == '"' && text.back() == '"') text = text.substr(1, text.size() - 2);
    return text;
}

/// M3, S600, T8, T="MILL".
Action of_letter(const program::Event& event) {
    const std::string_view word = event.word, rest = word.substr(1);
    const auto number = whole_number(rest);
    if (word.front() == 'M' && number && *number == static_cast<int>(*number))
        return of_m_word(static_cast<int>(*number));
    if (word.front() == 'S' && number) return {Kind::spindle_speed, *number};
    if (word.front() == 'T' && !rest.empty())
        return {event.stops_motion ? Kind::change_tool : Kind::prepare_tool, 0, without_quotes(rest)};
    return {};
}

/// The items behind the slash of an APT statement.
std::vector<std::string_view> items_of(std::string_view statement) {
    std::vector<std::string_view> out;
    const std::size_t slash = statement.find('/');
    statement = slash == statement.npos ? std::string_view{} : statement.substr(slash + 1);
    while (!statement.empty()) {
        const std::size_t end = std::min(statement.find(','), statement.size());
        out.push_back(trimmed(statement.substr(0, end)));
        statement.remove_prefix(std::min(end + 1, statement.size()));
    }
    return out;
}

std::vector<Action> of_spindle_statement(const std::vector<std::string_view>& items) {
    std::vector<Action> out;
    bool on = false, counter = false;
    for (const std::string_view item : items) {
        if (reads(item, "OFF")) return {{Kind::spindle_off}};
        if (const auto speed = whole_number(item)) out.push_back({Kind::spindle_speed, *speed});
        counter = counter || reads(item, "CCLW");
        on = on || !out.empty() || reads(item, "ON") || reads(item, "CLW");
    }
    if (on || counter) out.push_back({counter ? Kind::spindle_counter_clockwise : Kind::spindle_clockwise});
    return out;
}

std::vector<Action> of_statement(std::string_view major, std::string_view word) {
    const auto items = items_of(word);
    const std::string_view first = items.empty() ? std::string_view{} : items.front();
    if (reads(major, "SPINDL")) return of_spindle_statement(items);
    if (reads(major, "LOADTL") || reads(major, "TURRET")) return {{Kind::change_tool, 0, first}};
    if (reads(major, "STOP")) return {{Kind::pause}};
    if (reads(major, "OPSTOP")) return {{Kind::optional_pause}};
    if (reads(major, "END")) return {{Kind::end}};
    if (!reads(major, "COOLNT")) return {{}};
    if (reads(first, "OFF")) return {{Kind::coolant_off}};
    if (reads(first, "MIST")) return {{Kind::mist}};
    if (reads(first, "ON") || reads(first, "FLOOD")) return {{Kind::flood}};
    return {{}};
}

}  // namespace

std::vector<Action> actions_of(const program::Event& event) {
    if (event.kind == program::EventKind::dwell) return {{Kind::dwell, event.dwell_s}};
    const std::string_view word = event.word;
    if (word.empty()) return {{}};
    const std::string_view major = trimmed(word.substr(0, word.find('/')));
    if (const auto actions = of_statement(major, word); actions.front().kind != Kind::unknown) return actions;
    return {of_letter(event)};
}

}  // namespace trunnion::nc
