#pragma once

#include <cstdint>
#include <memory>
#include <string_view>

#include "detail/program_text.hpp"
#include "detail/sinumerik_block.hpp"

namespace trunnion::nc::sinumerik {

/// What a program may use up before it is refused. Recursion ends at the calls, a loop without an end at the lines.
struct Limits {
    int calls = 16;                  ///< subprograms within each other, NC0541
    std::int64_t lines = 5'000'000;  ///< lines carried out again or in subprograms, NC0542: the text once is free
    int brackets = 64;               ///< within each other in an expression, NC0543
    std::int64_t array_elements = 1000000;  ///< in all arrays together, NC0544
    int words = 1000;                       ///< words of a block, arguments of a call, NC0545
};

/// Carries out the language of a SINUMERIK program: text, variables, expressions, jumps, loops and subprograms. What is
/// left for the reader are blocks of words with their values worked out.
///
/// A word is a letter with a number, a letter (with digits) or an identifier known to `is_word` with `=`, and an
/// identifier known to `is_word` alone or with brackets. `is_word` gets capitals. The interpreter itself deals with N,
/// R, L, labels, DEF, PROC, RET, EXTERN, CALL, the words of control structures and jumps, and P behind a call:
/// `is_word` is never asked about these. MCALL is always a word, the call behind it the next word of the block. Every
/// other identifier is a variable where `=` follows, else a subprogram. M2, M30 and M17 (alike on this control) end a
/// subprogram and are not handed over there; in the main program they are handed over, and the next step is `end`.
/// Lines behind a `/` are left out and counted (NC0016); text
/// behind the end that no jump ever reached is told (NC0014).
///
/// Subprograms are found in the same text (sections that start with %_N_NAME_SPF), then in the folder of the main
/// program (NAME.SPF, NAME.MPF in any case of letters), if `file_name` is a file that is there. The main program is the
/// first section that is an MPF, else the first one.
///
/// Arithmetic is REAL. Comparisons take numbers as equal within 1e-12 of their size, as the control does. Priority,
/// high to low: NOT B_NOT | * / DIV MOD | + - | B_AND | B_XOR | B_OR | AND | XOR | OR | << | == <> > < >= <=.
///
/// `text` must outlive the interpreter. Cost: one pass over the lines carried out, about 0.5 µs a line of six words;
/// allocates nothing for plain words once the block has grown. Errors, through `findings`: NC0201, NC0202, NC0501 and
/// following.
class Interpreter {
  public:
    Interpreter(const ProgramText& text, std::string_view file_name, Findings& findings,
                bool (*is_word)(std::string_view), const Limits& limits = {});
    ~Interpreter();
    Interpreter(const Interpreter&) = delete;
    Interpreter& operator=(const Interpreter&) = delete;

    enum class Step : std::uint8_t { block, end, refused };

    /// The next line that has words. After `end` or `refused` it must not be called again.
    Step next(Block& block);
    const ProgramText& text() const;
    /// Where the next line of the text that is read starts.
    std::size_t position() const;

  private:
    class Machinery;
    std::unique_ptr<Machinery> machinery_;
};

}  // namespace trunnion::nc::sinumerik
