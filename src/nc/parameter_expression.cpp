#include "detail/parameter_expression.hpp"

#include <algorithm>
#include <numbers>
#include <utility>

#include <fmt/format.h>

#include "trunnion/base/number.hpp"
#include "trunnion/base/quantity.hpp"

namespace trunnion::nc {

enum class ParameterExpressions::Operation : std::uint8_t {
    power,
    times,
    over,
    modulo,
    plus,
    minus,
    equal,
    unequal,
    above,
    at_least,
    below,
    at_most,
    both,
    either,
    one_alone
};

struct ParameterExpressions::Operator {
    std::string_view written;
    Operation operation;
    int linuxcnc, fanuc;  ///< priority; 0: the language does not have it
};

namespace {

constexpr int comparison = 2, lowest_priority = 1;
constexpr double most_bits = 2147483647.0;

/// LinuxCNC takes what is this near to a whole number as one, where it wants one.
constexpr double nearly_whole = 1e-4;

double from_zero(double value, double step) {
    return std::copysign(std::floor(std::abs(value) / step + 0.5) * step, value);
}

bool is_whole(double value) {
    return value == std::round(value);
}

std::string_view first_characters(std::string_view text) {
    return text.substr(0, 12);
}

}  // namespace

ParameterValue Parameters::read(const ParameterReference& parameter) const {
    const Frame& frame = frames_.back();
    if (!parameter.name.empty()) {
        const auto& names = is_global(parameter.name) ? named_ : frame.named;
        const auto found = names.find(parameter.name);
        if (found == names.end()) return {};
        return found->second;
    }
    if (parameter.number >= 0 && parameter.number <= language_.last_local)
        return frame.numbered[static_cast<std::size_t>(parameter.number)];
    const auto found = numbered_.find(parameter.number);
    if (found == numbered_.end()) return {};
    return found->second;
}

void Parameters::set(const ParameterReference& parameter, ParameterValue value) {
    Frame& frame = frames_.back();
    if (!parameter.name.empty()) {
        auto& names = is_global(parameter.name) ? named_ : frame.named;
        if (value)
            names.insert_or_assign(parameter.name, *value);
        else
            names.erase(parameter.name);
    } else if (parameter.number >= 0 && parameter.number <= language_.last_local) {
        frame.numbered[static_cast<std::size_t>(parameter.number)] = value;
    } else if (value) {
        numbered_.insert_or_assign(parameter.number, *value);
    } else {
        numbered_.erase(parameter.number);
    }
}

bool ParameterExpressions::starts_here(LineCursor cursor) {
    while (cursor.take('+') || cursor.take('-')) {}
    const char next = cursor.front();
    if (next == '#' || next == '[') return true;
    cursor.rest.remove_prefix(UpperWord(cursor.rest).text().size());
    return is_letter(next) && cursor.front() == '[';
}

bool ParameterExpressions::value(LineCursor& cursor, ParameterValue& result) {
    bool negative = false;
    for (int signs = 0;; ++signs) {
        if (signs == most_brackets)
            return refuse(cursor, "NC0328", cursor.column(), "too many signs in front of a value");
        if (cursor.take('-'))
            negative = !negative;
        else if (!cursor.take('+'))
            break;
    }
    if (!unsigned_value(cursor, result)) return false;
    if (negative && result) result = -*result;
    return true;
}

bool ParameterExpressions::unsigned_value(LineCursor& cursor, ParameterValue& result) {
    const char next = cursor.front();
    if (next == '[') return bracketed(cursor, result);
    if (next == '#') return read_parameter(cursor, result);
    if (is_letter(next)) return function(cursor, result);
    return number(cursor, result);
}

bool ParameterExpressions::expression(LineCursor& cursor, ParameterValue& result) {
    return climb(cursor, lowest_priority, result);
}

bool ParameterExpressions::bracketed(LineCursor& cursor, ParameterValue& result) {
    const int column = (cursor.front(), cursor.column());
    if (!cursor.take('['))
        return refuse(cursor, "NC0320", column, "an expression in brackets is wanted here",
                      first_characters(cursor.rest), "[ … ]");
    if (!deeper(cursor) || !climb(cursor, lowest_priority, result)) return false;
    --depth_;
    if (cursor.take(']')) return true;
    const bool word = is_letter(cursor.front());
    return refuse(cursor, word ? "NC0321" : "NC0320", cursor.column(),
                  word ? "no such operator" : "an operator or ] is missing",
                  word ? UpperWord(cursor.rest).text() : first_characters(cursor.rest));
}

/// Digits with blanks between them are one number, as blanks mean nothing.
bool ParameterExpressions::number(LineCursor& cursor, ParameterValue& result) {
    const int column = (cursor.front(), cursor.column());
    std::array<char, 64> digits;
    std::size_t count = 0;
    std::string_view after = cursor.rest;
    for (; !after.empty(); after.remove_prefix(1)) {
        const char c = after.front();
        if (is_blank(c)) continue;
        if (!is_digit(c) && c != '.') break;
        if (count == digits.size())
            return refuse(cursor, "NC0201", column, "too many digits", first_characters(cursor.rest));
        digits[count++] = c;
    }
    if (count == 0) return refuse(cursor, "NC0320", column, "a value is missing", first_characters(cursor.rest));
    std::string_view written{digits.data(), count};
    const auto found = take_number(written);
    if (!found || !written.empty())
        return refuse(cursor, "NC0201", column, "no finite number", first_characters(cursor.rest));
    cursor.rest = after;
    result = found;
    return true;
}

bool ParameterExpressions::reference(LineCursor& cursor, ParameterReference& result) {
    const int column = (cursor.front(), cursor.column());
    if (!cursor.take('#'))
        return refuse(cursor, "NC0320", column, "a parameter is wanted here", first_characters(cursor.rest));
    if (cursor.take('<')) {
        if (!language_.names)
            return refuse(cursor, "NC0322", column, "parameters have no names here", first_characters(cursor.rest));
        const std::size_t end = cursor.rest.find('>');
        if (end == cursor.rest.npos)
            return refuse(cursor, "NC0320", column, "the name of a parameter without its end",
                          first_characters(cursor.rest), "close it with >");
        result = {};
        for (const char c : cursor.rest.substr(0, end))
            if (!is_blank(c)) result.name += c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
        cursor.rest.remove_prefix(end + 1);
        return !result.name.empty() || refuse(cursor, "NC0320", column, "a parameter without its name");
    }
    ParameterValue which;
    if (!deeper(cursor) || !unsigned_value(cursor, which)) return false;
    --depth_;
    const double whole = std::round(which.value_or(0));
    if (!(std::abs(which.value_or(0) - whole) < nearly_whole) || whole < language_.first_number ||
        whole > language_.last_number)
        return refuse(cursor, "NC0322", column, "no such parameter", fmt::format("#{}", which.value_or(0)),
                      fmt::format("whole numbers from {} to {}", language_.first_number, language_.last_number));
    result = {static_cast<int>(whole)};
    return true;
}

bool ParameterExpressions::read_parameter(LineCursor& cursor, ParameterValue& result) {
    const int column = cursor.column();
    ParameterReference parameter;
    if (!reference(cursor, parameter)) return false;
    result.reset();
    const std::string name =
        parameter.name.empty() ? fmt::format("#{}", parameter.number) : fmt::format("#<{}>", parameter.name);
    switch (control_.read(parameter, result)) {
        case ControlParameters::Answer::known:
            return true;
        case ControlParameters::Answer::unknown:
            return refuse(cursor, "NC0324", column, "the control's own parameter, whose value is not known here", name,
                          "give the value as a number");
        case ControlParameters::Answer::not_its_own:
            break;
    }
    result = parameters_.read(parameter);
    if (!result && !parameter.name.empty())
        return refuse(cursor, "NC0323", column, "a named parameter without a value", name,
                      "set it first; EXISTS[] asks whether it has one");
    if (!result && !language_.vacant) result = 0;
    return true;
}

bool ParameterExpressions::deeper(const LineCursor& cursor) {
    if (++depth_ <= most_brackets) return true;
    return refuse(cursor, "NC0328", cursor.column(), "too many brackets within each other", {},
                  fmt::format("at most {}", most_brackets));
}

bool ParameterExpressions::finite(const LineCursor& cursor, int column, double value) {
    return std::isfinite(value) || refuse(cursor, "NC0327", column, "the result is too large");
}

/// Climbs the priorities: takes operators of at least the lowest one, from left to right.
bool ParameterExpressions::climb(LineCursor& cursor, int lowest, ParameterValue& left) {
    if (!value(cursor, left)) return false;
    bool compared = false;
    for (;;) {
        const Operator* const op = operator_at(cursor, lowest);
        if (!op) return true;
        const int column = cursor.column();
        cursor.rest.remove_prefix(op->written.size());
        const int priority = language_.fanuc ? op->fanuc : op->linuxcnc;
        if (language_.fanuc && priority == comparison && std::exchange(compared, true))
            return refuse(cursor, "NC0320", column, "a second comparison without brackets", op->written,
                          "[[#1 GT 5] AND [#2 LT 3]]");
        ParameterValue right;
        if (!climb(cursor, priority + 1, right) || !apply(cursor, column, op->operation, left, right)) return false;
    }
}

const ParameterExpressions::Operator* ParameterExpressions::operator_at(LineCursor& cursor, int lowest) const {
    using enum Operation;
    static constexpr Operator operators[] = {
        {"**", power, 5, 0}, {"*", times, 4, 4},     {"/", over, 4, 4},        {"MOD", modulo, 4, 4},
        {"+", plus, 3, 3},   {"-", minus, 3, 3},     {"EQ", equal, 2, 2},      {"NE", unequal, 2, 2},
        {"GT", above, 2, 2}, {"GE", at_least, 2, 2}, {"LT", below, 2, 2},      {"LE", at_most, 2, 2},
        {"AND", both, 1, 4}, {"OR", either, 1, 3},   {"XOR", one_alone, 1, 3},
    };
    if (cursor.front() == ']') return nullptr;
    for (const Operator& op : operators) {
        if ((language_.fanuc ? op.fanuc : op.linuxcnc) < lowest) continue;
        if (reads(cursor.rest.substr(0, op.written.size()), op.written)) return &op;
    }
    return nullptr;
}

bool ParameterExpressions::compare(Operation operation, const ParameterValue& left, const ParameterValue& right) const {
    const double a = left.value_or(0), b = right.value_or(0);
    const bool equal = left.has_value() == right.has_value() && (a == b || std::abs(a - b) < language_.equal_within);
    switch (operation) {
        case Operation::equal:
            return equal;
        case Operation::unequal:
            return !equal;
        case Operation::above:
            return a > b;
        case Operation::at_least:
            return a >= b;
        case Operation::below:
            return a < b;
        default:
            return a <= b;
    }
}

/// FANUC's AND, OR and XOR, on whole numbers of 32 bits.
bool ParameterExpressions::bits(const LineCursor& cursor, int column, Operation operation, double& left, double right) {
    for (const double number : {left, right})
        if (!is_whole(number) || std::abs(number) > most_bits)
            return refuse(cursor, "NC0329", column, "whole numbers of 32 bits are wanted here",
                          fmt::format("{}", number));
    const auto a = static_cast<std::int64_t>(left), b = static_cast<std::int64_t>(right);
    left = static_cast<double>(operation == Operation::both ? a & b : operation == Operation::either ? a | b : a ^ b);
    return true;
}

bool ParameterExpressions::apply(const LineCursor& cursor, int column, Operation operation, ParameterValue& left,
                                 const ParameterValue& right) {
    if (operation >= Operation::equal && operation <= Operation::at_most) {
        left = compare(operation, left, right) ? 1 : 0;
        return true;
    }
    double a = left.value_or(0);
    const double b = right.value_or(0);
    switch (operation) {
        case Operation::power:
            if (a < 0 && !is_whole(b))
                return refuse(cursor, "NC0326", column, "a negative number has no such power",
                              fmt::format("{} ** {}", a, b));
            if (a == 0 && b < 0) return refuse(cursor, "NC0325", column, "division by zero");
            a = std::pow(a, b);
            break;
        case Operation::times:
            a *= b;
            break;
        case Operation::over:
        case Operation::modulo:
            if (b == 0) return refuse(cursor, "NC0325", column, "division by zero");
            if (operation == Operation::over) {
                a /= b;
            } else {
                a = std::fmod(a, b);
                if (a < 0 && !language_.fanuc) a += std::abs(b);
            }
            break;
        case Operation::plus:
            a += b;
            break;
        case Operation::minus:
            a -= b;
            break;
        default:
            if (language_.fanuc) {
                if (!bits(cursor, column, operation, a, b)) return false;
            } else if (operation == Operation::both) {
                a = a != 0 && b != 0;
            } else if (operation == Operation::either) {
                a = a != 0 || b != 0;
            } else {
                a = (a != 0) != (b != 0);
            }
            break;
    }
    left = a;
    return finite(cursor, column, a);
}

namespace {

using Arithmetic = double (*)(double);

struct Function {
    std::string_view name;
    Arithmetic value;
    bool (*defined)(double) = nullptr;  ///< empty: everywhere
};

bool within_one(double x) {
    return std::abs(x) <= 1;
}

constexpr Function functions[] = {
    {"ABS", [](double x) { return std::abs(x); }},
    {"ACOS", [](double x) { return std::acos(x) / degree; }, within_one},
    {"ASIN", [](double x) { return std::asin(x) / degree; }, within_one},
    {"COS", [](double x) { return std::cos(x * degree); }},
    {"EXP", [](double x) { return std::exp(x); }},
    {"LN", [](double x) { return std::log(x); }, [](double x) { return x > 0; }},
    {"SIN", [](double x) { return std::sin(x * degree); }},
    {"SQR", [](double x) { return std::sqrt(x); }, [](double x) { return x >= 0; }},
    {"SQRT", [](double x) { return std::sqrt(x); }, [](double x) { return x >= 0; }},
    {"TAN", [](double x) { return std::tan(x * degree); }},
};

}  // namespace

bool ParameterExpressions::function(LineCursor& cursor, ParameterValue& result) {
    const int column = (cursor.front(), cursor.column());
    const UpperWord word(cursor.rest);
    const std::string_view name = word.text();
    cursor.rest.remove_prefix(name.size());
    const bool foreign = language_.fanuc ? name == "EXISTS" : name == "POW" || name == "RND" || name == "SQR";
    const bool special = name == "EXISTS" || name == "ATAN" || name == "POW";
    const bool rounds = name == "ROUND" || name == "RND" || name == "FIX" || name == "FUP";
    const auto* const found = std::ranges::find(functions, name, &Function::name);
    if (foreign || (found == std::end(functions) && !special && !rounds))
        return refuse(cursor, "NC0321", column, "no such function", name);
    if (name == "EXISTS") return exists(cursor, result);
    if (name == "ATAN") return arc_tangent(cursor, column, result);
    if (name == "POW") return power(cursor, column, result);
    if (!bracketed(cursor, result)) return false;
    const double x = result.value_or(0);
    if (name == "ROUND" || name == "RND") {
        result = from_zero(x, language_.rounding_step);
    } else if (rounds) {
        const bool away = (name == "FUP") == !(language_.fanuc && x < 0);
        result = away ? std::ceil(x) : std::floor(x);
    } else {
        if (found->defined && !found->defined(x))
            return refuse(cursor, "NC0326", column, fmt::format("{} has no value there", name), fmt::format("{}", x));
        result = found->value(x);
    }
    return finite(cursor, column, *result);
}

/// ATAN[y]/[x]; on FANUC also ATAN[y,x], and ATAN[x] between −90 and 90 degrees.
bool ParameterExpressions::arc_tangent(LineCursor& cursor, int column, ParameterValue& result) {
    if (!cursor.take('['))
        return refuse(cursor, "NC0320", cursor.column(), "an expression in brackets is wanted here", "ATAN",
                      "ATAN[y]/[x]");
    ParameterValue x, y;
    if (!deeper(cursor) || !climb(cursor, lowest_priority, y)) return false;
    const bool comma = language_.fanuc && cursor.take(',');
    if (comma && !climb(cursor, lowest_priority, x)) return false;
    if (!cursor.take(']'))
        return refuse(cursor, "NC0320", cursor.column(), "] is missing", first_characters(cursor.rest));
    --depth_;
    LineCursor behind = cursor;
    const bool ratio = !comma && behind.take('/') && behind.front() == '[';
    if (!comma && !ratio) {
        if (!language_.fanuc)
            return refuse(cursor, "NC0320", column, "ATAN takes two values", first_characters(cursor.rest),
                          "ATAN[y]/[x]");
        result = std::atan(y.value_or(0)) / degree;
        return true;
    }
    if (ratio) {
        cursor = behind;
        if (!bracketed(cursor, x)) return false;
    }
    const double angle = std::atan2(y.value_or(0), x.value_or(0)) / degree;
    result = language_.fanuc && angle < 0 ? angle + 360 : angle;
    return true;
}

bool ParameterExpressions::power(LineCursor& cursor, int column, ParameterValue& result) {
    ParameterValue exponent;
    if (!cursor.take('[')) return refuse(cursor, "NC0320", cursor.column(), "POW takes two values", "POW", "POW[x,y]");
    if (!deeper(cursor) || !climb(cursor, lowest_priority, result)) return false;
    if (!cursor.take(',')) return refuse(cursor, "NC0320", cursor.column(), "POW takes two values", "POW", "POW[x,y]");
    if (!climb(cursor, lowest_priority, exponent)) return false;
    if (!cursor.take(']'))
        return refuse(cursor, "NC0320", cursor.column(), "] is missing", first_characters(cursor.rest));
    --depth_;
    return apply(cursor, column, Operation::power, result, exponent);
}

/// Of a parameter of the control, whether its value is known.
bool ParameterExpressions::exists(LineCursor& cursor, ParameterValue& result) {
    ParameterReference parameter;
    if (!cursor.take('['))
        return refuse(cursor, "NC0320", cursor.column(), "EXISTS takes a parameter", {}, "EXISTS[#<name>]");
    if (!reference(cursor, parameter)) return false;
    if (!cursor.take(']'))
        return refuse(cursor, "NC0320", cursor.column(), "] is missing", first_characters(cursor.rest));
    ParameterValue value;
    const bool known = control_.read(parameter, value) != ControlParameters::Answer::not_its_own;
    result = known || parameter.name.empty() || parameters_.read(parameter) ? 1 : 0;
    return true;
}

}  // namespace trunnion::nc
