#include "detail/sinumerik_expression.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <utility>

#include <fmt/format.h>

namespace trunnion::nc::sinumerik {

enum class Expressions::Symbol : std::uint8_t {
    times,
    over,
    whole_over,
    remainder,
    plus,
    minus,
    bit_and,
    bit_xor,
    bit_or,
    both,
    one_alone,
    either,
    join,
    equal,
    unequal,
    at_least,
    at_most,
    above,
    below
};

namespace {

using Symbol = Expressions::Symbol;

struct Operator {
    std::string_view written;
    Symbol symbol;
    int priority;  ///< the higher, the earlier
};

constexpr int comparison = 1;
/// The job planning manual's order of operators; of those that start alike the longer ones first.
constexpr Operator operators[] = {
    {"*", Symbol::times, 10},
    {"/", Symbol::over, 10},
    {"DIV", Symbol::whole_over, 10},
    {"MOD", Symbol::remainder, 10},
    {"+", Symbol::plus, 9},
    {"-", Symbol::minus, 9},
    {"B_AND", Symbol::bit_and, 8},
    {"B_XOR", Symbol::bit_xor, 7},
    {"B_OR", Symbol::bit_or, 6},
    {"AND", Symbol::both, 5},
    {"XOR", Symbol::one_alone, 4},
    {"OR", Symbol::either, 3},
    {"<<", Symbol::join, 2},
    {"==", Symbol::equal, comparison},
    {"<>", Symbol::unequal, comparison},
    {">=", Symbol::at_least, comparison},
    {"<=", Symbol::at_most, comparison},
    {">", Symbol::above, comparison},
    {"<", Symbol::below, comparison},
};

/// Two numbers are the same to the control within this part of the greater one.
constexpr double relative_equality = 1e-12;
constexpr std::size_t longest_text = 10000;
constexpr double degree = std::numbers::pi / 180;

bool same(double a, double b) {
    return std::abs(a - b) <= relative_equality * std::max(std::abs(a), std::abs(b));
}

double truncated(double x) {
    return same(x, std::round(x)) ? std::round(x) : std::trunc(x);
}

using Arguments = std::array<double, 3>;
struct Function {
    std::string_view name;
    int count;
    double (*value)(const Arguments&);
    bool (*defined)(const Arguments&) = nullptr;  ///< null: everywhere
};

constexpr Function functions[] = {
    {"SIN", 1, [](const Arguments& a) { return std::sin(a[0] * degree); }},
    {"COS", 1, [](const Arguments& a) { return std::cos(a[0] * degree); }},
    {"TAN", 1, [](const Arguments& a) { return std::tan(a[0] * degree); },
     [](const Arguments& a) { return !same(std::abs(std::remainder(a[0], 180)), 90); }},
    {"ASIN", 1, [](const Arguments& a) { return std::asin(a[0]) / degree; },
     [](const Arguments& a) { return std::abs(a[0]) <= 1; }},
    {"ACOS", 1, [](const Arguments& a) { return std::acos(a[0]) / degree; },
     [](const Arguments& a) { return std::abs(a[0]) <= 1; }},
    {"ATAN2", 2, [](const Arguments& a) { return std::atan2(a[0], a[1]) / degree; },
     [](const Arguments& a) { return a[0] != 0 || a[1] != 0; }},
    {"SQRT", 1, [](const Arguments& a) { return std::sqrt(a[0]); }, [](const Arguments& a) { return a[0] >= 0; }},
    {"ABS", 1, [](const Arguments& a) { return std::abs(a[0]); }},
    {"POT", 1, [](const Arguments& a) { return a[0] * a[0]; }},
    {"TRUNC", 1, [](const Arguments& a) { return truncated(a[0]); }},
    {"ROUND", 1, [](const Arguments& a) { return std::round(a[0]); }},
    {"ROUNDUP", 1,
     [](const Arguments& a) { return same(a[0], std::round(a[0])) ? std::round(a[0]) : std::ceil(a[0]); }},
    {"LN", 1, [](const Arguments& a) { return std::log(a[0]); }, [](const Arguments& a) { return a[0] > 0; }},
    {"EXP", 1, [](const Arguments& a) { return std::exp(a[0]); }},
    {"MINVAL", 2, [](const Arguments& a) { return std::min(a[0], a[1]); }},
    {"MAXVAL", 2, [](const Arguments& a) { return std::max(a[0], a[1]); }},
    {"BOUND", 3, [](const Arguments& a) { return std::clamp(a[2], a[0], a[1]); },
     [](const Arguments& a) { return a[0] <= a[1]; }},
};

const Function* function_named(std::string_view name) {
    const auto* const found = std::ranges::find(functions, name, &Function::name);
    return found == std::end(functions) ? nullptr : found;
}

bool is_r_parameter(std::string_view name) {
    return name.size() > 1 && name[0] == 'R' && std::ranges::all_of(name.substr(1), is_digit);
}

std::int64_t bits(double number) {
    return static_cast<std::int64_t>(number);
}

}  // namespace

bool is_expression_word(std::string_view name) {
    return function_named(name) || std::ranges::find(operators, name, &Operator::written) != std::end(operators) ||
           name == "NOT" || name == "B_NOT" || name == "TRUE" || name == "FALSE";
}

bool Expressions::value(Value& result) {
    return climb(comparison, result);
}

bool Expressions::number(double& result) {
    const int column = cursor_.next_column();
    Value found;
    if (!value(found)) return false;
    result = found.number;
    return found.kind == Value::Kind::number || cursor_.refuse("NC0506", column, "a number is wanted here", found.text);
}

bool Expressions::condition(bool& result) {
    double number = 0;
    if (!this->number(number)) return false;
    result = number != 0;
    return true;
}

bool Expressions::equals(const Value& other, bool& result) {
    const int column = cursor_.next_column();
    Value found;
    if (!value(found) || !compare(Symbol::equal, column, found, other)) return false;
    result = found.number != 0;
    return true;
}

bool Expressions::whole(double least, double most, std::string_view what, double& result) {
    const int column = cursor_.next_column();
    if (!number(result)) return false;
    if (same(result, std::round(result))) result = std::round(result);
    if (result == std::round(result) && result >= least && result <= most) return true;
    return cursor_.refuse("NC0510", column,
                          fmt::format("{}: a whole number from {} to {} is wanted", what, least, most),
                          fmt::format("{}", result));
}

bool Expressions::bare_name(std::string_view& name) {
    const std::string_view next = cursor_.peek_name();
    if (next.empty() || next[0] == '$' || next == "TRUE" || next == "FALSE" || is_variable(next)) return false;
    Cursor ahead = cursor_;
    ahead.name();
    if (const char c = ahead.front(); c != ',' && c != ')' && c != ']' && c != '\0') return false;
    name = cursor_.name();
    return true;
}

bool Expressions::value_for(Type type, Value& result) {
    std::string_view name;
    if (type != Type::axis || !bare_name(name)) return value(result);
    result = {.kind = Value::Kind::axis, .text = std::string(name)};
    return true;
}

bool Expressions::is_variable(std::string_view name) {
    return is_r_parameter(name) || name == "R" || variables_.find(name) != nullptr;
}

/// Climbs the priorities: takes operators of at least the lowest one. Comparisons do not follow one another: nobody
/// means (a < b) < c, and without brackets AND comes before them.
bool Expressions::climb(int lowest, Value& left) {
    if (!operand(left)) return false;
    bool compared = false;
    for (;;) {
        const int column = cursor_.next_column();
        int which = 0;
        if (!take_operator(lowest, which)) return true;
        const Operator& op = operators[which];
        if (op.priority == comparison && std::exchange(compared, true))
            return cursor_.refuse("NC0501", column, "a second comparison without brackets", op.written,
                                  "AND and OR come before comparisons: (R1>5) AND (R2<3)");
        Value right;
        if (!climb(op.priority + 1, right) || !apply(which, column, left, right)) return false;
    }
}

bool Expressions::take_operator(int lowest, int& symbol) {
    const char c = cursor_.front();
    if (!is_letter(c) && !std::string_view("*/+-<>=").contains(c)) return false;
    const std::string_view word = cursor_.peek_name();
    for (std::size_t i = 0; i < std::size(operators); ++i) {
        const Operator& op = operators[i];
        if (op.priority < lowest) continue;
        if (word.empty() ? is_letter(op.written[0]) || !cursor_.sees(op.written) : word != op.written) continue;
        cursor_.take(op.written);
        symbol = static_cast<int>(i);
        return true;
    }
    return false;
}

bool Expressions::deeper() {
    if (++depth_ <= most_brackets_) return true;
    return cursor_.refuse("NC0543", cursor_.column(), "too many brackets within each other", {},
                          fmt::format("at most {}", most_brackets_));
}

/// With the signs in front. They nest as brackets do.
bool Expressions::operand(Value& result) {
    const int column = cursor_.next_column();
    const bool negation = cursor_.take_word("NOT");
    const bool bit_negation = !negation && cursor_.take_word("B_NOT");
    const bool minus = !negation && !bit_negation && cursor_.take("-");
    if (!negation && !bit_negation && !minus && !cursor_.take("+")) return primary(result);
    if (!deeper() || !operand(result)) return false;
    --depth_;
    if (result.kind != Value::Kind::number)
        return cursor_.refuse("NC0506", column, "a number is wanted here", result.text);
    if (negation) result.number = result.number == 0;
    if (minus) result.number = -result.number;
    if (!bit_negation) return true;
    if (!whole_numbers(column, result.number, 0)) return false;
    result.number = static_cast<double>(~bits(result.number));
    return true;
}

bool Expressions::primary(Value& result) {
    const char c = cursor_.front();
    if (c == '"') {
        result.kind = Value::Kind::text;
        return cursor_.text(result.text);
    }
    if (c == '\'')
        return cursor_.refuse("NC0516", cursor_.column(), "hexadecimal and binary numbers are not read", "'",
                              "write it as a decimal number");
    if (c == '(') {
        cursor_.take("(");
        if (!deeper() || !value(result) || !cursor_.want(")")) return false;
        --depth_;
        return true;
    }
    if (is_letter(c) || c == '_' || c == '$') return named(result);
    const int column = cursor_.column();
    const auto number = cursor_.number();
    if (!number) {
        if (is_digit(c) || c == '.')
            return cursor_.refuse("NC0201", column, "no finite number", cursor_.rest().substr(0, 12));
        return cursor_.refuse("NC0501", column, "a value is missing", cursor_.rest().substr(0, 12));
    }
    result = {.number = *number};
    return true;
}

bool Expressions::named(Value& result) {
    const int column = cursor_.next_column();
    const std::string_view name = cursor_.name();
    if (name == "TRUE" || name == "FALSE") {
        result = {.number = name == "TRUE" ? 1.0 : 0.0};
        return true;
    }
    if (name == "$PI") {
        result = {.number = std::numbers::pi};
        return true;
    }
    if (name.empty() || name[0] == '$')
        return cursor_.refuse("NC0503", column, "the control's own variables are not known here",
                              name.empty() ? "$" : name,
                              "give the value as a number, or a variable that the program defines");
    if (is_variable(name)) {
        Reference from;
        if (!reference(name, column, from)) return false;
        result = variables_.read(from);
        return true;
    }
    if (cursor_.sees("(")) return call(name, column, result);
    return cursor_.refuse("NC0502", column, "no such variable in this program", name,
                          "DEF makes one; variables of a calling program are not seen within a subprogram");
}

bool Expressions::call(std::string_view name, int column, Value& result) {
    const Function* const function = function_named(name);
    if (!function) return cursor_.refuse("NC0505", column, "no such function", name);
    if (!deeper()) return false;
    cursor_.take("(");
    Arguments arguments{};
    for (int i = 0; i < function->count; ++i) {
        if (i > 0 && !cursor_.take(","))
            return cursor_.refuse("NC0514", column, fmt::format("takes {} values", function->count), name);
        if (!number(arguments[static_cast<std::size_t>(i)])) return false;
    }
    if (cursor_.sees(","))
        return cursor_.refuse("NC0514", column, fmt::format("takes {} values", function->count), name);
    if (!cursor_.want(")")) return false;
    --depth_;
    if (function->defined && !function->defined(arguments))
        return cursor_.refuse(
            "NC0508", column, fmt::format("{} has no value there", name),
            fmt::format("{}", fmt::join(arguments.begin(), arguments.begin() + function->count, ", ")));
    result = {.number = function->value(arguments)};
    return finite(column, result.number);
}

bool Expressions::reference(std::string_view name, int column, Reference& result) {
    if (is_r_parameter(name) || name == "R") {
        double number = 0;
        constexpr std::string_view what = "R parameter";
        constexpr double last = Variables::r_count - 1;
        if (name == "R") {
            if (!cursor_.want("[") || !whole(0, last, what, number) || !cursor_.want("]")) return false;
        } else {
            for (const char digit : name.substr(1)) number = std::min(number * 10 + (digit - '0'), 1e9);
            if (number > last)
                return cursor_.refuse("NC0510", column, fmt::format("R parameters go from R0 to R{}", last), name);
        }
        result = {.name = {}, .element = static_cast<std::size_t>(number)};
        return true;
    }
    const Variable& variable = *variables_.find(name);
    result = {.name = std::string(name), .element = 0};
    const bool indexed = cursor_.take("[");
    if (indexed != (variable.dimensions > 0))
        return cursor_.refuse("NC0514", column, indexed ? "this variable is no array" : "an array needs its index",
                              name);
    for (int i = 0; i < variable.dimensions; ++i) {
        const auto size = variable.sizes[static_cast<std::size_t>(i)];
        double index = 0;
        if (i > 0 && !cursor_.want(",")) return false;
        if (!whole(0, static_cast<double>(size - 1), "index of the array", index)) return false;
        result.element = result.element * size + static_cast<std::size_t>(index);
    }
    return !indexed || cursor_.want("]");
}

bool Expressions::arguments(std::vector<Argument>& into, int most) {
    if (cursor_.take(")")) return true;
    do {
        if (into.size() == static_cast<std::size_t>(most))
            return cursor_.refuse("NC0545", cursor_.column(), "too many values in brackets", {},
                                  fmt::format("at most {}", most));
        Argument& argument = into.emplace_back();
        if (cursor_.sees(",") || cursor_.sees(")")) continue;
        Value found;
        if (!value_for(Type::axis, found)) return false;
        argument.number = found.number;
        argument.text = std::move(found.text);
        argument.kind = found.kind == Value::Kind::number ? Argument::Kind::number
                        : found.kind == Value::Kind::text ? Argument::Kind::text
                                                          : Argument::Kind::name;
    } while (cursor_.take(","));
    return cursor_.want(")");
}

bool Expressions::whole_numbers(int column, double left, double right) {
    constexpr double most = 2147483648.0;
    for (const double number : {left, right})
        if (number != std::round(number) || std::abs(number) > most)
            return cursor_.refuse("NC0506", column, "whole numbers of 32 bits are wanted here",
                                  fmt::format("{}", number));
    return true;
}

bool Expressions::finite(int column, double value) {
    return std::isfinite(value) || cursor_.refuse("NC0509", column, "the result is too large");
}

bool Expressions::apply(int which, int column, Value& left, const Value& right) {
    const Symbol symbol = operators[which].symbol;
    if (symbol == Symbol::join) {
        left = {.kind = Value::Kind::text, .text = written(left) + written(right)};
        return left.text.size() <= longest_text || cursor_.refuse("NC0545", column, "the text becomes too long", {},
                                                                  fmt::format("at most {}", longest_text));
    }
    if (operators[which].priority == comparison) return compare(symbol, column, left, right);
    if (left.kind != Value::Kind::number || right.kind != Value::Kind::number)
        return cursor_.refuse("NC0506", column, "takes numbers alone", operators[which].written);
    double& a = left.number;
    const double b = right.number;
    const bool divides = symbol == Symbol::over || symbol == Symbol::whole_over || symbol == Symbol::remainder;
    if (divides && b == 0) return cursor_.refuse("NC0507", column, "division by zero");
    const bool bitwise = symbol == Symbol::bit_and || symbol == Symbol::bit_or || symbol == Symbol::bit_xor;
    if ((bitwise || symbol == Symbol::remainder) && !whole_numbers(column, a, b)) return false;
    switch (symbol) {
        case Symbol::times:
            a *= b;
            break;
        case Symbol::over:
            a /= b;
            break;
        case Symbol::whole_over:
            a = truncated(a / b);
            break;
        case Symbol::remainder:
            a = std::fmod(a, b);
            break;
        case Symbol::plus:
            a += b;
            break;
        case Symbol::minus:
            a -= b;
            break;
        case Symbol::bit_and:
            a = static_cast<double>(bits(a) & bits(b));
            break;
        case Symbol::bit_xor:
            a = static_cast<double>(bits(a) ^ bits(b));
            break;
        case Symbol::bit_or:
            a = static_cast<double>(bits(a) | bits(b));
            break;
        case Symbol::both:
            a = a != 0 && b != 0;
            break;
        case Symbol::one_alone:
            a = (a != 0) != (b != 0);
            break;
        case Symbol::either:
            a = a != 0 || b != 0;
            break;
        default:
            break;
    }
    return finite(column, a);
}

bool Expressions::compare(Symbol symbol, int column, Value& left, const Value& right) {
    if (left.kind != right.kind) return cursor_.refuse("NC0506", column, "a text and a number cannot be compared");
    const bool numbers = left.kind == Value::Kind::number;
    if (!numbers && symbol != Symbol::equal && symbol != Symbol::unequal)
        return cursor_.refuse("NC0506", column, "texts are equal or not, but have no order");
    const bool equal = numbers ? same(left.number, right.number) : left.text == right.text;
    const bool below = numbers && !equal && left.number < right.number;
    bool holds = equal;
    if (symbol == Symbol::unequal) holds = !equal;
    if (symbol == Symbol::below) holds = below;
    if (symbol == Symbol::at_most) holds = below || equal;
    if (symbol == Symbol::above) holds = !below && !equal;
    if (symbol == Symbol::at_least) holds = !below;
    left = {.number = holds ? 1.0 : 0.0};
    return true;
}

}  // namespace trunnion::nc::sinumerik
