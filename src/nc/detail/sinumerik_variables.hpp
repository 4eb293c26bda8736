#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "detail/sinumerik_text.hpp"

namespace trunnion::nc::sinumerik {

/// What an expression is worth. BOOL, CHAR, INT and REAL are numbers.
struct Value {
    enum class Kind : std::uint8_t { number, text, axis };
    Kind kind = Kind::number;
    double number = 0;
    std::string text;  ///< also the name of an axis
};

/// A value as `<<` joins it: whole numbers without a point, others with ten digits.
std::string written(const Value& value);

enum class Type : std::uint8_t { integer, real, boolean, character, text, axis };

std::optional<Type> type_named(std::string_view name);
std::string_view name_of(Type type);

/// One variable that DEF or PROC made: a single value or an array of up to three indices, the last one fastest.
struct Variable {
    Type type = Type::real;
    std::size_t longest = 0;  ///< STRING[n]
    std::array<std::size_t, 3> sizes{1, 1, 1};
    int dimensions = 0;
    int line = 0, column = 0;  ///< of its DEF
    std::vector<Value> elements;
};

using Scope = std::map<std::string, Variable, std::less<>>;

/// An element of a variable, or an R parameter: what can be read and assigned.
struct Reference {
    std::string name{};  ///< of the variable; empty: R
    std::size_t element = 0;
};

/// The R parameters and the variables of the program that runs.
class Variables {
  public:
    static constexpr std::size_t r_count = 1000;

    void enter(Scope& scope) { scope_ = &scope; }
    Scope& scope() { return *scope_; }
    Variable* find(std::string_view name);

    Value read(const Reference& reference);

    /// Converts to the type of the variable. NC0506 another kind of value, NC0513 out of its range.
    bool assign(const Reference& reference, Value value, const Cursor& cursor, int column);
    bool convert(const Variable& variable, Value& value, const Cursor& cursor, int column) const;

  private:
    std::array<double, r_count> r_{};
    Scope* scope_ = nullptr;
};

}  // namespace trunnion::nc::sinumerik
