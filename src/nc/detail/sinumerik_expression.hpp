#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "detail/sinumerik_block.hpp"
#include "detail/sinumerik_variables.hpp"

namespace trunnion::nc::sinumerik {

/// Whether expressions use this name for themselves: SIN, DIV, TRUE.
bool is_expression_word(std::string_view name);

/// Works out expressions where the cursor stands. Every function leaves the cursor behind what it took, or refuses:
/// NC0501 syntax, NC0502 to NC0510 and NC0513, NC0516 for what is meant, NC0543 too many brackets within each other.
class Expressions {
  public:
    enum class Symbol : std::uint8_t;

    Expressions(Cursor& cursor, Variables& variables, int most_brackets)
        : cursor_(cursor), variables_(variables), most_brackets_(most_brackets) {}

    bool value(Value& result);
    bool number(double& result);
    bool condition(bool& result);
    /// Whether the value that comes next is the same as `other`.
    bool equals(const Value& other, bool& result);
    /// A whole number from `least` to `most`, or NC0510 about `what`.
    bool whole(double least, double most, std::string_view what, double& result);

    /// A single name that is no variable, function or constant, up to the , ) ] or end that follows: an axis. False,
    /// and nothing taken, where something else stands.
    bool bare_name(std::string_view& name);

    /// A variable or R parameter with its index: `name` was taken already, at `column`.
    bool reference(std::string_view name, int column, Reference& result);
    /// Whether `name` is R with a number, a variable, or R in front of a bracket.
    bool is_variable(std::string_view name);

    /// What stands between brackets: `(` was taken, `)` is taken.
    bool arguments(std::vector<Argument>& into, int most);

    /// A value for a variable of this type: as value(), and names of axes where it is an AXIS.
    bool value_for(Type type, Value& result);

  private:
    bool climb(int lowest, Value& left);
    bool operand(Value& result);
    bool primary(Value& result);
    bool named(Value& result);
    bool call(std::string_view name, int column, Value& result);
    bool take_operator(int lowest, int& which);
    bool apply(int which, int column, Value& left, const Value& right);
    bool compare(Symbol symbol, int column, Value& left, const Value& right);
    bool whole_numbers(int column, double left, double right);
    bool finite(int column, double value);
    bool deeper();

    Cursor& cursor_;
    Variables& variables_;
    int most_brackets_;
    int depth_ = 0;
};

}  // namespace trunnion::nc::sinumerik
