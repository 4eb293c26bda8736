#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "detail/findings.hpp"
#include "detail/heidenhain_text.hpp"
#include "detail/heidenhain_values.hpp"

namespace trunnion::nc::heidenhain {

/// Carries out the language of a Klartext program: Q parameters, FN 0 … FN 13, labels, repeats, jumps and calls of
/// other programs. What is left for the reader are blocks, which it takes apart at cursor().
///
/// Other programs are found in the folder of the main program (NAME.H in any case of letters), if `file_name` is a
/// file that is there. Subprograms and programs may lie 16 deep in each other; blocks carried out beyond the lines of
/// the text are counted. `text` must outlive the interpreter. Errors, through `findings`: NC0731 … NC0749.
class Interpreter {
  public:
    Interpreter(const ProgramText& text, std::string_view file_name, Findings& findings,
                std::int64_t most_repeated_lines);

    enum class Step : std::uint8_t { block, end, refused };
    /// The next block that is not of the language itself.
    Step next();

    Cursor& cursor() { return cursor_; }
    Values& values() { return values_; }
    /// In the text that is read: the block, or the call that led to it.
    int line() const { return frames_.back().outer_line != 0 ? frames_.back().outer_line : statement_.line(); }
    /// The unit that BEGIN PGM of the program says that is being carried out.
    bool inch() const { return frames_.back().inch; }
    bool in_main_program() const;
    const ProgramText& text() const { return main_.text(); }
    /// Where the next line of the text that is read starts.
    std::size_t position() const { return frames_.front().place.offset; }

  private:
    enum class Outcome : std::uint8_t { block, done, ended, refused };
    /// CALL LBL … REP: how often its part is still to be repeated.
    struct Repetition {
        std::size_t behind;  ///< the place behind the call
        double left;
    };
    /// A program, or a subprogram from its label on.
    struct Frame {
        Source* source = nullptr;
        LinePlace place{};
        bool program = true;  ///< else LBL 0 ends it
        bool inch = false;
        int outer_line = 0;  ///< the line of the call in the text that is read; 0 within that text
        std::vector<Repetition> repetitions{};
    };

    bool count_block();
    Outcome carry_out();
    Outcome begin_program();
    Outcome end_program();
    Outcome end_of_text();
    Outcome label();
    Outcome call();
    Outcome call_label();
    Outcome repeat_from(const LinePlace& label);
    Outcome call_program();
    Outcome function();
    Outcome condition();
    Outcome done();
    Outcome refuse(std::string_view code, std::size_t at, std::string text, std::string_view value = {},
                   std::string_view hint = {});
    bool find_label(LinePlace& place);
    bool find_program(std::string_view name, std::size_t at, Source*& source);
    bool enter(Frame frame, std::size_t at);
    void leave();

    Findings& findings_;
    Source main_;
    Folder folder_;
    std::map<std::string, std::unique_ptr<Source>, std::less<>> programs_;
    Statement statement_;
    Cursor cursor_;
    Values values_;
    std::vector<Frame> frames_;
    std::size_t furthest_ = 0;  ///< behind the lines of the main program that were carried out
    std::int64_t blocks_left_;
};

}  // namespace trunnion::nc::heidenhain
