#pragma once

#include <cstdint>
#include <limits>
#include <map>
#include <string_view>
#include <vector>

#include "detail/findings.hpp"
#include "detail/heidenhain_text.hpp"

namespace trunnion::nc::heidenhain {

/// Q1, QL1, QR1.
struct ParameterName {
    enum class Kind : std::uint8_t { shared, local, remanent };
    Kind kind = Kind::shared;
    int number = 0;
};

/// The Q parameters that the program has set: Q0 … Q1999 and QR0 … QR499 for all programs, QL0 … QL499 of each one.
class Parameters {
  public:
    Parameters();
    /// NaN: not set.
    double get(ParameterName name) const;
    void set(ParameterName name, double value);
    void enter_program() { locals_.emplace_back(); }
    void leave_program() { locals_.pop_back(); }
    static int most(ParameterName::Kind kind) { return kind == ParameterName::Kind::shared ? 1999 : 499; }

  private:
    std::vector<double> shared_, remanent_;
    std::vector<std::map<int, double>> locals_;
};

/// FMAX as the value of a parameter.
inline constexpr double rapid_feed = std::numeric_limits<double>::infinity();

/// Values at the cursor. Errors, through `findings`: NC0731 … NC0736; functions that return bool then say false.
class Values {
  public:
    Values(Cursor& cursor, Findings& findings) : cursor_(&cursor), findings_(&findings) {}

    /// A number or a Q parameter, with its sign.
    bool value(double& value) {
        const auto number = cursor_->number();
        if (!number) return parameter_value(value);
        value = *number;
        return true;
    }
    /// The same, of a rotary word: `position` is set where the value is that of Q120, Q121 or Q122 (0 … 2), in which
    /// the control lays the positions that reach a tilted plane, and which the program has not set itself.
    bool rotary_value(double& value, int& position);
    /// What stands behind `=`: numbers, parameters, + - * / % ^, brackets, functions. Angles are in degrees.
    bool formula(double& value);
    /// A formula, or the feed of a cycle: FMAX, or FAUTO for that of TOOL CALL.
    bool feed_or_formula(double& value);
    /// What FAUTO stands for from here on, as F says it; NaN: not set.
    void set_automatic_feed(double feed) { automatic_feed_ = feed; }
    /// Qn = formula or feed, at its Q.
    bool assignment();
    /// Qn at the cursor; false where none stands there.
    bool parameter_name(ParameterName& name);

    const Parameters& parameters() const { return parameters_; }
    Parameters& parameters() { return parameters_; }

  private:
    bool parameter_value(double& value);
    bool read_parameter(double& value);
    bool sum(double& value);
    bool product(double& value);
    bool factor(double& value, double with, std::string_view operation, std::size_t at);
    bool power(double& value);
    bool signed_part(double& value);
    bool part(double& value);
    bool function(std::string_view name, double& value, std::size_t at);
    bool finite(double value, std::size_t at);
    bool refuse(std::string_view code, std::size_t at, std::string text, std::string_view value = {},
                std::string_view hint = {});

    Cursor* cursor_;
    Findings* findings_;
    Parameters parameters_;
    double automatic_feed_ = std::numeric_limits<double>::quiet_NaN();
    int depth_ = 0;
};

}  // namespace trunnion::nc::heidenhain
