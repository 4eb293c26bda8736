#include "detail/sinumerik_variables.hpp"

#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>

namespace trunnion::nc::sinumerik {

namespace {

constexpr std::pair<std::string_view, Type> types[] = {{"INT", Type::integer},  {"REAL", Type::real},
                                                       {"BOOL", Type::boolean}, {"CHAR", Type::character},
                                                       {"STRING", Type::text},  {"AXIS", Type::axis}};

/// The control's INT has 32 bits.
constexpr double largest_integer = std::numeric_limits<std::int32_t>::max();
constexpr double smallest_integer = std::numeric_limits<std::int32_t>::min();
constexpr double largest_character = 255;

}  // namespace

std::string written(const Value& value) {
    return value.kind == Value::Kind::number ? fmt::format("{:.10g}", value.number) : value.text;
}

std::optional<Type> type_named(std::string_view name) {
    for (const auto& [word, type] : types)
        if (word == name) return type;
    return {};
}

std::string_view name_of(Type type) {
    for (const auto& [word, named] : types)
        if (named == type) return word;
    return {};
}

Variable* Variables::find(std::string_view name) {
    const auto found = scope_->find(name);
    return found == scope_->end() ? nullptr : &found->second;
}

Value Variables::read(const Reference& reference) {
    if (reference.name.empty()) return {.number = r_[reference.element]};
    return find(reference.name)->elements[reference.element];
}

bool Variables::assign(const Reference& reference, Value value, const Cursor& cursor, int column) {
    if (reference.name.empty()) {
        if (value.kind != Value::Kind::number)
            return cursor.refuse("NC0506", column, "an R parameter takes numbers alone", value.text);
        r_[reference.element] = value.number;
        return true;
    }
    Variable& variable = *find(reference.name);
    if (!convert(variable, value, cursor, column)) return false;
    variable.elements[reference.element] = std::move(value);
    return true;
}

/// As the table of type conversions in the job planning manual has it.
bool Variables::convert(const Variable& variable, Value& value, const Cursor& cursor, int column) const {
    const bool number = value.kind == Value::Kind::number;
    const bool text = value.kind == Value::Kind::text;
    const auto other_kind = [&] {
        return cursor.refuse("NC0506", column,
                             fmt::format("a variable of type {} does not take this", name_of(variable.type)),
                             written(value));
    };
    const auto out_of_range = [&](std::string_view limit) {
        return cursor.refuse("NC0513", column,
                             fmt::format("does not fit a variable of type {}: {}", name_of(variable.type), limit),
                             written(value));
    };
    switch (variable.type) {
        case Type::real:
            return number || other_kind();
        case Type::boolean:
            if (!number && !text) return other_kind();
            value = {.number = (number ? value.number != 0 : !value.text.empty()) ? 1.0 : 0.0};
            return true;
        case Type::integer:
            if (!number) return other_kind();
            value.number = std::round(value.number);
            return (value.number >= smallest_integer && value.number <= largest_integer) || out_of_range("32 bits");
        case Type::character:
            if (text && value.text.size() == 1)
                value = {.number = static_cast<double>(static_cast<unsigned char>(value.text[0]))};
            if (value.kind != Value::Kind::number) return other_kind();
            value.number = std::round(value.number);
            return (value.number >= 0 && value.number <= largest_character) || out_of_range("0 to 255");
        case Type::text:
            if (!text) return other_kind();
            return value.text.size() <= variable.longest ||
                   out_of_range(fmt::format("it was defined with {} characters", variable.longest));
        case Type::axis:
            return value.kind == Value::Kind::axis || other_kind();
    }
    return false;
}

}  // namespace trunnion::nc::sinumerik
