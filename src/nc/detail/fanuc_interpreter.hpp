#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "detail/fanuc_block.hpp"
#include "detail/fanuc_text.hpp"
#include "detail/findings.hpp"
#include "detail/parameter_expression.hpp"

namespace trunnion::nc::fanuc {

/// Where a program stops that would not end by itself.
struct Limits {
    std::int64_t lines = 5'000'000;  ///< carried out beyond those of the text once
    std::size_t calls = 16;          ///< subprograms and macros within each other
};

/// Carries out the language of custom macros (variables, IF, WHILE, GOTO, M98, G65, G66) and hands over the blocks that
/// are left, in order, with their values worked out. A word whose value is vacant is as if it were not written.
/// fanuc_interpreter.cpp: lines, words, statements; fanuc_calls.cpp: subprograms and macros.
class Interpreter {
  public:
    enum class Step : std::uint8_t { block, end, refused };

    Interpreter(const ProgramText& text, std::string_view file_name, Findings& findings,
                const ControlParameters& control, const Limits& limits);

    Step next(Block& block);
    /// Behind a block that moved: the macro of G66 follows.
    void moved();
    /// What ROUND rounds to in the value of an address.
    void set_least_increment(double step) { least_increment_ = step; }
    /// The title, as written; empty: none.
    const std::string& program_name() const { return name_; }
    /// Whether code stands behind the block that was handed over last, which ended the program.
    bool code_is_left() const;
    const ProgramText& text() const { return main_.text(); }
    /// Where the next block of the text that is read starts.
    std::size_t position() const { return running_.front().at.offset; }

  private:
    enum class Outcome : std::uint8_t { block, nothing, section_end, refused };

    struct Loop {
        int number;
        Place begin;  ///< of the line with DO
    };
    struct Argument {
        int variable;
        double value;
    };
    struct Call {
        enum class Kind : std::uint8_t { subprogram, local, macro, give_back } kind = Kind::subprogram;
        std::optional<double> program, repeats;  ///< P, L
        bool modal = false;
        std::vector<Argument> arguments;
        Spot spot;
    };
    struct Running {
        Source* source;
        Section section;
        Place start;  ///< where a repeat begins
        Place at;
        int repeats = 1;
        bool own_parameters = false, modal = false, fresh = true;
        std::vector<Argument> arguments;
        std::vector<Loop> loops;
        std::size_t furthest = 0;  ///< lines before it were carried out before
    };

    // lines, words, statements
    Outcome line(Block& block);
    void begin_line();
    bool count_line();
    Outcome behind_number(Block& block);
    bool sequence_number();
    Outcome words(Block& block);
    bool word(Block& block);
    bool number(Word& word, bool& vacant);
    bool comment();
    void go_behind_line();
    bool statement_ends();
    Outcome assignments();
    bool assign(const ParameterReference& variable, const ParameterValue& value, const Spot& at);
    Outcome condition(Block& block);
    Outcome go_to();
    Outcome loop();
    Outcome loop_end();
    bool loop_number(int& number);
    bool leave_loop(int number);
    bool take_word(std::string_view word);
    bool truth(bool& holds);

    // calls
    bool find_call(Block& block);
    bool macro_call(Block& block, std::size_t at, bool modal);
    Outcome carry_out(const Call& call);
    Outcome call_program(const Call& call);
    void enter(const Call& call, Source& source, const Section& section, Place at, int repeats);
    bool program_of(const Call& call, int number, Source*& source, Section& section);
    Outcome give_back(std::optional<int> to_block);
    void set_arguments(const Running& running);
    bool jump(int number, const Spot& at);

    bool refuse(std::string_view code, const Spot& spot, std::string text, std::string_view value = {},
                std::string_view hint = {}) {
        return findings_.refuse(code, spot, std::move(text), value, hint);
    }
    Outcome refused(std::string_view code, const Spot& spot, std::string text, std::string_view value = {},
                    std::string_view hint = {}) {
        refuse(code, spot, std::move(text), value, hint);
        return Outcome::refused;
    }
    Running& now() { return running_.back(); }

    Findings& findings_;
    Limits limits_;
    Parameters parameters_{fanuc_parameters};
    ParameterExpressions expressions_;
    Source main_;
    Folder folder_;
    std::vector<std::pair<int, std::unique_ptr<Source>>> files_;
    std::vector<Running> running_;
    LineCursor cursor_;
    std::optional<Call> pending_, modal_;
    std::string name_;
    std::int64_t repeated_lines_ = 0;
    double least_increment_ = 0.001;
    bool line_goes_on_ = false;  ///< `;` stands in it
};

}  // namespace trunnion::nc::fanuc
