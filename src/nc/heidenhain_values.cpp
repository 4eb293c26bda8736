#include "detail/heidenhain_values.hpp"

#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include <fmt/format.h>

#include "trunnion/base/quantity.hpp"

namespace trunnion::nc::heidenhain {

namespace {

constexpr double unset = std::numeric_limits<double>::quiet_NaN();
constexpr int deepest = 64;  ///< brackets and functions within each other
constexpr int first_position = 120, last_position = 122;

struct Function {
    std::string_view name;
    double (*of)(double);
};
constexpr Function functions[] = {
    {"SIN", [](double x) { return std::sin(x * degree); }},
    {"COS", [](double x) { return std::cos(x * degree); }},
    {"TAN", [](double x) { return std::tan(x * degree); }},
    {"ASIN", [](double x) { return std::asin(x) / degree; }},
    {"ACOS", [](double x) { return std::acos(x) / degree; }},
    {"ATAN", [](double x) { return std::atan(x) / degree; }},
    {"SQ", [](double x) { return x * x; }},
    {"SQRT", [](double x) { return std::sqrt(x); }},
    {"LN", [](double x) { return std::log(x); }},
    {"LOG", [](double x) { return std::log10(x); }},
    {"EXP", [](double x) { return std::exp(x); }},
    {"NEG", [](double x) { return -x; }},
    {"INT", [](double x) { return std::trunc(x); }},
    {"FRAC", [](double x) { return x - std::trunc(x); }},
    {"ABS", [](double x) { return std::abs(x); }},
    {"SGN", [](double x) { return x > 0   ? 1.0
                                  : x < 0 ? -1.0
                                          : 0.0; }},
};

std::string written(ParameterName name) {
    constexpr std::string_view kinds[] = {"Q", "QL", "QR"};
    return fmt::format("{}{}", kinds[static_cast<std::size_t>(name.kind)], name.number);
}

}  // namespace

Parameters::Parameters()
    : shared_(static_cast<std::size_t>(most(ParameterName::Kind::shared)) + 1, unset),
      remanent_(static_cast<std::size_t>(most(ParameterName::Kind::remanent)) + 1, unset),
      locals_(1) {}

double Parameters::get(ParameterName name) const {
    const auto at = static_cast<std::size_t>(name.number);
    if (name.kind == ParameterName::Kind::shared) return shared_[at];
    if (name.kind == ParameterName::Kind::remanent) return remanent_[at];
    const auto found = locals_.back().find(name.number);
    return found == locals_.back().end() ? unset : found->second;
}

void Parameters::set(ParameterName name, double value) {
    const auto at = static_cast<std::size_t>(name.number);
    if (name.kind == ParameterName::Kind::shared) shared_[at] = value;
    if (name.kind == ParameterName::Kind::remanent) remanent_[at] = value;
    if (name.kind == ParameterName::Kind::local) locals_.back()[name.number] = value;
}

bool Values::refuse(std::string_view code, std::size_t at, std::string text, std::string_view value,
                    std::string_view hint) {
    return findings_->refuse(code, cursor_->spot(at), std::move(text), value, hint);
}

bool Values::parameter_name(ParameterName& name) {
    const std::size_t at = cursor_->next_index();
    const std::string_view kind = cursor_->name();
    if (kind == "QS") return refuse("NC0735", at, "text parameters are not supported");
    if (kind != "Q" && kind != "QL" && kind != "QR")
        return refuse("NC0731", at, "a number or a Q parameter is missing", cursor_->rest().substr(0, 12));
    name.kind = kind == "Q"    ? ParameterName::Kind::shared
                : kind == "QL" ? ParameterName::Kind::local
                               : ParameterName::Kind::remanent;
    const char first = cursor_->rest().empty() ? '\0' : cursor_->rest().front();
    const auto number = is_digit(first) ? cursor_->number() : std::nullopt;
    const int most = Parameters::most(name.kind);
    if (!number || !(*number <= most) || *number != std::floor(*number))
        return refuse("NC0733", at, fmt::format("the number of a parameter is 0 … {}", most));
    name.number = static_cast<int>(*number);
    return true;
}

bool Values::read_parameter(double& value) {
    const std::size_t at = cursor_->next_index();
    ParameterName name;
    if (!parameter_name(name)) return false;
    value = parameters_.get(name);
    if (!std::isnan(value)) return true;
    return refuse("NC0732", at, "a parameter that the program has not set", written(name),
                  "its value is in the control alone: assign it before");
}

bool Values::parameter_value(double& value) {
    const bool negative = cursor_->take('-');
    if (!negative) cursor_->take('+');
    if (!read_parameter(value)) return false;
    if (negative) value = -value;
    return true;
}

bool Values::rotary_value(double& value, int& position) {
    position = -1;
    const auto number = cursor_->number();
    if (number) {
        value = *number;
        return true;
    }
    const std::size_t at = cursor_->next_index();
    cursor_->take('+');
    ParameterName name;
    const bool named = cursor_->front() == 'Q' && parameter_name(name);
    const bool of_plane = named && name.kind == ParameterName::Kind::shared && name.number >= first_position &&
                          name.number <= last_position && std::isnan(parameters_.get(name));
    if (of_plane) {
        position = name.number - first_position;
        value = 0;
        return true;
    }
    cursor_->go_back_to(at);
    return parameter_value(value);
}

bool Values::finite(double value, std::size_t at) {
    if (std::isfinite(value)) return true;
    return refuse("NC0734", at, "the formula has no value here: division by zero, outside a function, or too large");
}

bool Values::assignment() {
    ParameterName name;
    double value = 0;
    if (!parameter_name(name)) return false;
    const std::size_t at = cursor_->next_index();
    if (!cursor_->take('=')) return refuse("NC0731", at, "= is missing behind the parameter");
    if (!feed_or_formula(value)) return false;
    parameters_.set(name, value);
    return true;
}

bool Values::feed_or_formula(double& value) {
    if (cursor_->take_word("FMAX"))
        value = rapid_feed;
    else if (cursor_->take_word("FAUTO") || cursor_->take_word("AUTO"))
        value = automatic_feed_;
    else
        return formula(value);
    return true;
}

bool Values::formula(double& value) {
    depth_ = 0;
    const std::size_t at = cursor_->next_index();
    return sum(value) && finite(value, at);
}

bool Values::sum(double& value) {
    if (!product(value)) return false;
    for (;;) {
        const bool plus = cursor_->take('+');
        if (!plus && !cursor_->take('-')) return true;
        double next = 0;
        if (!product(next)) return false;
        value += plus ? next : -next;
    }
}

/// Products, and what FN 4, FN 8 and FN 13 write between their two values.
bool Values::product(double& value) {
    if (!power(value)) return false;
    for (;;) {
        const std::size_t at = cursor_->next_index();
        std::string_view operation;
        for (const std::string_view symbol : {"*", "/", "%"})
            if (operation.empty() && cursor_->take(symbol.front())) operation = symbol;
        for (const std::string_view word : {"DIV", "LEN", "ANG"})
            if (operation.empty() && cursor_->take_word(word)) operation = word;
        if (operation.empty()) return true;
        double next = 0;
        if (!power(next) || !factor(value, next, operation, at)) return false;
    }
}

bool Values::factor(double& value, double with, std::string_view operation, std::size_t at) {
    if (operation == "*") value *= with;
    if (operation == "/" || operation == "DIV") value /= with;
    if (operation == "%") value = std::fmod(value, with);
    if (operation == "LEN") value = std::hypot(value, with);
    if (operation == "ANG") {
        const double angle = std::atan2(with, value) / degree;
        value = angle < 0 ? angle + 360 : angle;
    }
    return finite(value, at);
}

bool Values::power(double& value) {
    if (!signed_part(value)) return false;
    while (cursor_->next_index(), cursor_->take('^')) {
        const std::size_t at = cursor_->index();
        double exponent = 0;
        if (!signed_part(exponent)) return false;
        value = std::pow(value, exponent);
        if (!finite(value, at)) return false;
    }
    return true;
}

bool Values::signed_part(double& value) {
    double sign = 1;
    while (cursor_->front() == '+' || cursor_->front() == '-')
        if (cursor_->take('-'))
            sign = -sign;
        else
            cursor_->take('+');
    if (!part(value)) return false;
    value *= sign;
    return true;
}

bool Values::part(double& value) {
    const std::size_t at = cursor_->next_index();
    if (++depth_ > deepest)
        return refuse("NC0736", at, "too many brackets and functions within each other", {}, "at most 64");
    bool good = true;
    if (cursor_->take('(')) {
        good = sum(value);
        if (good && !cursor_->take(')')) good = refuse("NC0731", cursor_->next_index(), ") is missing");
    } else if (const auto number = cursor_->number()) {
        value = *number;
    } else if (cursor_->front() == 'Q') {
        good = read_parameter(value);
    } else if (cursor_->take_word("PI")) {
        value = std::numbers::pi;
    } else {
        good = function(cursor_->name(), value, at);
    }
    --depth_;
    return good;
}

bool Values::function(std::string_view name, double& value, std::size_t at) {
    for (const Function& known : functions) {
        if (known.name != name) continue;
        double of = 0;
        if (!signed_part(of)) return false;
        value = known.of(of);
        return finite(value, at);
    }
    return refuse("NC0731", at, "a number, a Q parameter or a function is missing", name);
}

}  // namespace trunnion::nc::heidenhain
