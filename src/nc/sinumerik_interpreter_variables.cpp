#include <algorithm>
#include <string>

#include <fmt/format.h>

#include "detail/sinumerik_interpreter_machinery.hpp"

namespace trunnion::nc::sinumerik {

namespace {

/// The longest STRING of the control.
constexpr double longest_string = 200;

Value initial_value(Type type) {
    return {.kind = type == Type::text   ? Value::Kind::text
                    : type == Type::axis ? Value::Kind::axis
                                         : Value::Kind::number};
}

}  // namespace

/// DEF REAL A, B=1.5, C[10]
bool Interpreter::Machinery::define(Block& block, int column) {
    if (!lone_word(block, column)) return false;
    const std::string_view name = cursor_.peek_name();
    const auto type = type_named(name);
    if (!type)
        return refuse("NC0511", cursor_.next_column(), "no type of variable that is known here", name,
                      "INT, REAL, BOOL, CHAR, STRING and AXIS are");
    cursor_.name();
    std::size_t longest = 0;
    if (!longest_text(*type, longest)) return false;
    do {
        if (!define_one(*type, longest)) return false;
    } while (cursor_.take(","));
    return cursor_.want_end();
}

/// STRING[n]
bool Interpreter::Machinery::longest_text(Type type, std::size_t& longest) {
    if (type != Type::text) return true;
    double length = 0;
    if (!cursor_.want("[") || !expressions_.whole(1, longest_string, "length of the STRING", length)) return false;
    longest = static_cast<std::size_t>(length);
    return cursor_.want("]");
}

bool Interpreter::Machinery::define_one(Type type, std::size_t longest) {
    const int column = cursor_.next_column();
    const std::string_view name = cursor_.name();
    if (!is_own_name(name))
        return refuse("NC0511", column, "no name for a variable",
                      cursor_.line().substr(static_cast<std::size_t>(column - 1), 12),
                      "a name starts with two letters or underscores");
    if (is_taken(name)) return refuse("NC0512", column, "this name means something else already", name);
    if (const Variable* const known = variables_.find(name);
        known && (known->line != here_.at.line || known->column != column))
        return refuse("NC0512", column, "defined twice", name, fmt::format("the first time in line {}", known->line));
    Variable variable{.type = type, .longest = longest, .line = here_.at.line, .column = column, .elements = {}};
    if (!sizes_of(variable)) return false;
    if (Variable* const known = variables_.find(name); known && known->dimensions > 0)
        elements_left_ += static_cast<std::int64_t>(known->elements.size());
    const std::size_t count = variable.sizes[0] * variable.sizes[1] * variable.sizes[2];
    if (variable.dimensions > 0) elements_left_ -= static_cast<std::int64_t>(count);
    if (elements_left_ < 0)
        return refuse("NC0544", column, "the arrays become too large", name,
                      fmt::format("at most {} elements in all of them together", limits_.array_elements));
    variable.elements.assign(count, initial_value(type));
    return initial(name, variables_.scope()[std::string(name)] = std::move(variable));
}

bool Interpreter::Machinery::sizes_of(Variable& variable) {
    if (!cursor_.take("[")) return true;
    do {
        if (variable.dimensions == static_cast<int>(variable.sizes.size()))
            return refuse("NC0511", cursor_.column(), "an array has three indices at most");
        double size = 0;
        if (!expressions_.whole(1, static_cast<double>(limits_.array_elements), "size of the array", size))
            return false;
        variable.sizes[static_cast<std::size_t>(variable.dimensions++)] = static_cast<std::size_t>(size);
    } while (cursor_.take(","));
    return cursor_.want("]");
}

bool Interpreter::Machinery::initial(std::string_view name, Variable& variable) {
    if (!cursor_.take("=")) return true;
    const int column = cursor_.next_column();
    if (variable.dimensions > 0) {
        const bool repeating = cursor_.take_word("REP");
        if (!repeating) cursor_.take_word("SET");
        return cursor_.want("(") && fill(variable, 0, repeating);
    }
    Value value;
    return expressions_.value_for(variable.type, value) &&
           variables_.assign({.name = std::string(name), .element = 0}, std::move(value), cursor_, column);
}

bool Interpreter::Machinery::assign(std::string_view name, int column) {
    Reference to;
    if (!expressions_.reference(name, column, to) || !cursor_.want("=")) return false;
    const int value_column = cursor_.next_column();
    Variable* const variable = to.name.empty() ? nullptr : variables_.find(to.name);
    if (variable && variable->dimensions > 0) {
        const bool repeating = cursor_.take_word("REP");
        if (repeating || cursor_.take_word("SET")) return cursor_.want("(") && fill(*variable, to.element, repeating);
    }
    Value value;
    return expressions_.value_for(variable ? variable->type : Type::real, value) &&
           variables_.assign(to, std::move(value), cursor_, value_column);
}

/// SET(1,2,3): one element after the other; an empty place keeps its own. REP(1) and REP(1,n): the same into all that
/// follow, or into n of them.
bool Interpreter::Machinery::fill(Variable& variable, std::size_t from, bool repeating) {
    const std::size_t room = variable.elements.size() - from;
    std::size_t count = 0;
    if (repeating) {
        const int column = cursor_.next_column();
        Value value;
        double times = static_cast<double>(room);
        if (!expressions_.value_for(variable.type, value)) return false;
        if (cursor_.take(",") && !expressions_.whole(1, times, "elements to fill", times)) return false;
        if (!variables_.convert(variable, value, cursor_, column)) return false;
        std::fill_n(variable.elements.begin() + static_cast<std::ptrdiff_t>(from), static_cast<std::size_t>(times),
                    value);
        return cursor_.want(")");
    }
    do {
        const int column = cursor_.next_column();
        if (count == room) return refuse("NC0514", column, "more values than the array has elements from there");
        Value& element = variable.elements[from + count++];
        if (cursor_.sees(",") || cursor_.sees(")")) continue;
        Value value;
        if (!expressions_.value_for(variable.type, value) || !variables_.convert(variable, value, cursor_, column))
            return false;
        element = std::move(value);
    } while (cursor_.take(","));
    return cursor_.want(")");
}

bool Interpreter::Machinery::system_variable(std::string_view name, int column) {
    if (cursor_.rest().contains('='))
        return refuse("NC0504", column, "writes to the control: it might change motion", name,
                      "leave it out, and state what it sets in the setup");
    return refuse("NC0503", column, "the control's own variables are not known here", name);
}

/// The arrays of a program that ends give their room back.
void Interpreter::Machinery::release(Frame& frame) {
    for (const auto& [name, variable] : frame.scope)
        if (variable.dimensions > 0) elements_left_ += static_cast<std::int64_t>(variable.elements.size());
    frame.scope.clear();
}

}  // namespace trunnion::nc::sinumerik
