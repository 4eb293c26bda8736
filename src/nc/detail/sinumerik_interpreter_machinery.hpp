#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "detail/sinumerik_expression.hpp"
#include "detail/sinumerik_interpreter.hpp"
#include "detail/sinumerik_text.hpp"
#include "detail/sinumerik_variables.hpp"

namespace trunnion::nc::sinumerik {

/// Reads one line after the other and carries it out. Functions that return bool say false when they have refused.
class Interpreter::Machinery {
  public:
    Machinery(const ProgramText& text, std::string_view file_name, Findings& findings,
              bool (*is_word)(std::string_view), const Limits& limits);

    Step next(Block& block);
    const ProgramText& text() const { return main_.text(); }
    std::size_t position() const { return frames_.front().next.offset; }

  private:
    struct Program {
        Source* source = nullptr;
        Section* section = nullptr;
    };
    /// What a call hands to a subprogram.
    struct Passed {
        bool given = false;
        Value value{};
        std::optional<Reference> variable;  ///< the argument is no more than this
    };
    /// REPEAT: the lines from `start` to before `end`, `left` times more, then on at `resume`.
    struct Repetition {
        LinePlace start, resume;
        std::size_t end = 0;
        double left = 0;
    };
    /// One running program.
    struct Frame {
        Program program{};
        LinePlace next{};
        Scope scope;
        int outer_line = 0;  ///< the line of the call in the text that is read; 0 within that text
        double runs = 1;     ///< this one and those still to come
        bool begun = false;
        std::vector<Passed> passed;
        std::vector<std::pair<std::string, Reference>> handed_back;  ///< VAR parameters
        std::vector<Repetition> repetitions;
        std::map<int, double> count_ends;  ///< of FOR, by the number of the structure
        int counting = -1;                 ///< the FOR that ENDFOR goes back to
    };
    static constexpr double most_repetitions = 1e9;
    using Statement = bool (Machinery::*)(Block&, int column);

    static Statement statement_named(std::string_view name);
    bool is_taken(std::string_view name) const;

    // lines and words
    bool carry_out(Block& block);
    bool begin_line(Block& block);
    bool word(Block& block);
    bool plain_word(Block& block, int column);
    bool extended_word(Block& block, int column, std::string_view letter, std::string_view digits);
    bool named_word(Block& block, int column);
    bool control_word(Block& block, int column, std::string_view name);
    std::optional<double> number_alone();
    bool value_of(Word& word);
    bool index_of(Word& word);
    Word* add_word(Block& block, std::string_view name, int column);
    bool ends_program(const Word& word) const;
    bool charge_line();

    // variables
    bool define(Block& block, int column);
    bool define_one(Type type, std::size_t longest);
    bool sizes_of(Variable& variable);
    bool longest_text(Type type, std::size_t& longest);
    bool initial(std::string_view name, Variable& variable);
    bool assign(std::string_view name, int column);
    bool fill(Variable& variable, std::size_t from, bool repeating);
    bool system_variable(std::string_view name, int column);
    void release(Frame& frame);

    // jumps and control structures
    bool flow(FlowIndex*& index, std::string_view block_number = {});
    bool structure(int column, const Structure*& found);
    void go_to(const LinePlace& place);
    bool jump(std::string_view name, FlowIndex::Direction direction, bool if_there, int column);
    bool jump_statement(bool carried_out);
    bool target_name(std::string& name);
    bool find_target(std::string_view name, FlowIndex::Direction direction, int column, const Target*& found);
    bool end_line(const LinePlace& next);
    bool if_statement(Block& block, int column);
    bool else_statement(Block& block, int column);
    bool for_statement(Block& block, int column);
    bool while_statement(Block& block, int column);
    bool until_statement(Block& block, int column);
    bool back_to_begin(Block& block, int column);
    bool nothing_to_do(Block& block, int column);
    bool case_statement(Block& block, int column);
    bool repeat_statement(Block& block, int column);
    bool repeat_block(Block& block, int column);
    bool repeat(const LinePlace& start, std::size_t end, int column);
    bool times(double& count);
    bool jump_word(Block& block, int column);
    bool turn_back(Frame& frame);
    bool lone_word(Block& block, int column);

    // subprograms
    bool call(std::string_view name, Block& block, int column);
    bool pass_arguments(std::vector<Passed>& passed);
    bool enter(const Program& program, std::vector<Passed> passed, double runs, int column);
    bool find_program(std::string_view name, int column, Program& program);
    bool leave();
    void end_main();
    bool hand_back(Frame& frame);
    bool procedure(Block& block, int column);
    bool parameter(std::size_t number);
    bool attributes();
    bool external(Block& block, int column);
    bool call_statement(Block& block, int column);
    bool refused_call(Block& block, int column);
    bool return_statement(Block& block, int column);
    bool modal_call(Block& block, int column);

    Frame& frame() { return frames_.back(); }
    bool refuse(std::string_view code, int column, std::string text, std::string_view value = {},
                std::string_view hint = {}) const {
        return cursor_.refuse(code, column, std::move(text), value, hint);
    }

    Findings& findings_;
    bool (*is_word_)(std::string_view);
    Limits limits_;
    std::int64_t lines_left_;
    std::int64_t elements_left_;
    Source main_;
    Folder folder_;
    std::vector<std::unique_ptr<Source>> sources_;
    std::map<std::string, Program, std::less<>> programs_;
    Variables variables_;
    Cursor cursor_;
    Expressions expressions_;
    std::deque<Frame> frames_;

    LinePlace furthest_;  ///< behind the last line of the main program that was carried out
    LineMark here_;       ///< the line that is carried out
    CapitalLine line_;
    bool first_ = true;          ///< nothing but number and label stood before in it
    bool line_done_ = false;     ///< the rest of it is not read
    bool opens_program_ = true;  ///< it is the first line of its program that says something
    bool leaving_ = false;       ///< it ends its program
    bool ended_ = false;
};

}  // namespace trunnion::nc::sinumerik
