#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "detail/findings.hpp"
#include "detail/text.hpp"

namespace trunnion::nc {

/// The value of a parameter or expression; empty: vacant, as FANUC's #0.
using ParameterValue = std::optional<double>;

/// What tells LinuxCNC's expressions from FANUC's.
struct ParameterLanguage {
    int first_number = 1, last_number = 5602;  ///< of the parameters
    int last_local = 30;                       ///< numbers up to this one belong to the running subprogram
    bool vacant = false;                       ///< a parameter without a value is vacant, else 0; #0 is always vacant
    bool names = true;                         ///< `#<name>`
    /// FANUC: AND * / MOD bind alike, then OR XOR + -, then comparisons; AND OR XOR work on the bits of whole numbers;
    /// FIX and FUP go by the absolute value; ATAN answers 0 … 360 degrees (as delivered: parameter NAT = 0); BIN, BCD
    /// and ADP are refused. LinuxCNC: ** | * / MOD | + - | comparisons | AND OR XOR (logical); FIX and FUP go down and
    /// up; MOD is never negative.
    bool fanuc = false;
    /// What ROUND rounds to: 1, but FANUC rounds to the least increment within the value of an address.
    double rounding_step = 1;
    double equal_within = 0;  ///< EQ and NE take numbers as equal that differ by less
};

inline constexpr ParameterLanguage linuxcnc_parameters{.equal_within = 1e-4};
inline constexpr ParameterLanguage fanuc_parameters{.first_number = 0,
                                                    .last_number = 99999,
                                                    .last_local = 33,
                                                    .vacant = true,
                                                    .names = false,
                                                    .fanuc = true,
                                                    .equal_within = 1e-12};

/// Which parameter: its number, or its name (small letters, without blanks).
struct ParameterReference {
    int number = 0;
    std::string name{};
    bool operator==(const ParameterReference&) const = default;
};

/// What the control itself keeps in parameters: positions, offsets, modes.
class ControlParameters {
  public:
    enum class Answer : std::uint8_t { not_its_own, known, unknown };

    virtual ~ControlParameters() = default;
    /// Sets `value` where the answer is `known`. `unknown`: the control has it, the reader does not (NC0324).
    virtual Answer read(const ParameterReference& parameter, ParameterValue& value) const = 0;
};

/// The parameters of a program that runs: global ones, and the local ones of each subprogram. Memory: what the program
/// sets.
class Parameters {
  public:
    explicit Parameters(const ParameterLanguage& language) : language_(language) { enter(); }

    /// Empty: vacant, or never set. Of a number out of range: empty.
    ParameterValue read(const ParameterReference& parameter) const;
    /// Setting an empty value makes it vacant. Which parameters must not be set is for the reader to say: FANUC's #0.
    void set(const ParameterReference& parameter, ParameterValue value);

    /// A subprogram begins with fresh local parameters: all vacant, or 0.
    void enter() { frames_.emplace_back(language_.last_local + 1); }
    /// It ends: the caller's local ones are back. Not below the main program.
    void leave() { frames_.pop_back(); }

  private:
    struct Frame {
        explicit Frame(int numbers) : numbered(static_cast<std::size_t>(numbers)) {}
        std::vector<ParameterValue> numbered;
        std::map<std::string, double, std::less<>> named;
    };
    static bool is_global(std::string_view name) { return name.starts_with('_'); }

    ParameterLanguage language_;
    std::vector<Frame> frames_;
    std::unordered_map<int, double> numbered_;
    std::map<std::string, double, std::less<>> named_;
};

/// A line and what is left of it. Columns count from 1.
struct LineCursor {
    std::string_view line, rest;
    int number = 0;           ///< of the line
    std::string_view file{};  ///< empty: the text that is read

    int column() const { return 1 + static_cast<int>(line.size() - rest.size()); }
    Spot spot(int at) const { return {number, at, file}; }
    Spot spot() const { return spot(column()); }
    /// The next character that is no blank, and the cursor stands on it; NUL at the end.
    char front() {
        rest = skip_blanks(rest);
        return rest.empty() ? '\0' : rest.front();
    }
    bool take(char c) {
        if (front() != c || rest.empty()) return false;
        rest.remove_prefix(1);
        return true;
    }
};

/// The letters that come next, in capitals; the cursor stays. At most 15 of them.
class UpperWord {
  public:
    explicit UpperWord(std::string_view text) {
        for (const char c : text) {
            if (!is_letter(c) || size_ == letters_.size()) break;
            letters_[size_++] = upper(c);
        }
    }
    std::string_view text() const { return {letters_.data(), size_}; }

  private:
    std::array<char, 15> letters_{};
    std::size_t size_ = 0;
};

/// Works out parameters and expressions of LinuxCNC and FANUC where the cursor stands. Angles in degrees. Every
/// function leaves the cursor behind what it took, or refuses through `findings` and returns false. Blanks mean nothing
/// between the parts and within numbers; words in either case.
///
/// A value is a number, `#…`, `[expression]`, a function (`SIN[…]`, `ATAN[y]/[x]`, FANUC also `ATAN[y,x]` and
/// `ATAN[x]`, `EXISTS[#<name>]`), each with signs in front. Functions: SIN COS TAN ASIN ACOS ATAN SQRT (SQR) ABS ROUND
/// (RND) FIX FUP LN EXP EXISTS, FANUC also POW[x,y]; operators: + - * / ** MOD AND OR XOR EQ NE GT GE LT LE, from left
/// to right. A vacant value counts as 0 in arithmetic, stays vacant where it stands alone, and is equal to a vacant
/// value only.
///
/// Errors: NC0320 something missing or not expected; NC0321 no such function or operator; NC0322 no such parameter
/// number; NC0323 a named parameter without a value; NC0324 a parameter of the control whose value is not known here;
/// NC0325 division by zero; NC0326 no value there (SQRT of −1); NC0327 too large; NC0328 more than `most_brackets`
/// within each other; NC0329 whole numbers wanted (bits).
/// Cost: one pass. Allocates for names alone. Recursion: a fixed depth for each bracket.
class ParameterExpressions {
  public:
    static constexpr int most_brackets = 64;  ///< brackets, signs, functions and `#` within each other

    ParameterExpressions(const ParameterLanguage& language, const Parameters& parameters,
                         const ControlParameters& control, Findings& findings)
        : language_(language), parameters_(parameters), control_(control), findings_(findings) {}

    /// Whether what comes next can only be a value to be worked out: `#`, `[`, or a word in front of `[`, whatever
    /// signs stand before them.
    static bool starts_here(LineCursor cursor);

    /// A value as described above: behind an address, behind `=` on LinuxCNC.
    bool value(LineCursor& cursor, ParameterValue& result);
    /// A value, or an expression without brackets to the end of what belongs to it: behind `=` on FANUC.
    bool expression(LineCursor& cursor, ParameterValue& result);
    /// `[expression]`: conditions, arguments.
    bool bracketed(LineCursor& cursor, ParameterValue& result);
    /// `#3`, `#[…]`, `##2`, `#<name>`: which parameter, for assignments. Its value is not looked at.
    bool reference(LineCursor& cursor, ParameterReference& result);

    void set_rounding_step(double step) { language_.rounding_step = step; }

  private:
    enum class Operation : std::uint8_t;
    struct Operator;

    bool climb(LineCursor& cursor, int lowest, ParameterValue& left);
    const Operator* operator_at(LineCursor& cursor, int lowest) const;
    bool apply(const LineCursor& cursor, int column, Operation operation, ParameterValue& left,
               const ParameterValue& right);
    bool compare(Operation operation, const ParameterValue& left, const ParameterValue& right) const;
    bool bits(const LineCursor& cursor, int column, Operation operation, double& left, double right);
    bool unsigned_value(LineCursor& cursor, ParameterValue& result);
    bool number(LineCursor& cursor, ParameterValue& result);
    bool function(LineCursor& cursor, ParameterValue& result);
    bool exists(LineCursor& cursor, ParameterValue& result);
    bool arc_tangent(LineCursor& cursor, int column, ParameterValue& result);
    bool power(LineCursor& cursor, int column, ParameterValue& result);
    bool read_parameter(LineCursor& cursor, ParameterValue& result);
    bool deeper(const LineCursor& cursor);
    bool finite(const LineCursor& cursor, int column, double value);
    bool refuse(const LineCursor& cursor, std::string_view code, int column, std::string text,
                std::string_view value = {}, std::string_view hint = {}) {
        return findings_.refuse(code, cursor.spot(column), std::move(text), value, hint);
    }

    ParameterLanguage language_;
    const Parameters& parameters_;
    const ControlParameters& control_;
    Findings& findings_;
    int depth_ = 0;
};

}  // namespace trunnion::nc
