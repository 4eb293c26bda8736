#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "detail/findings.hpp"
#include "detail/parameter_expression.hpp"
#include "detail/text.hpp"

namespace trunnion::nc {

/// A G or M word: its number in tenths, as written `G43.1` is 431.
struct Code {
    char letter = 'G';
    int tenths = 0;
    int column = 0;
};

/// One line of G-code taken apart: every letter once, but for G and M.
struct Block {
    static constexpr std::size_t most_codes = 16;

    std::array<double, 26> value;  ///< by letter, where present
    std::array<int, 26> column;
    std::uint32_t present = 0;  ///< bit of each letter but G, M, N
    std::array<Code, most_codes> codes;
    std::size_t code_count = 0;
    int line = 0;             ///< in its file
    int program_line = 0;     ///< in the text that is read: of the call, where the line stands in another file
    std::string_view file{};  ///< empty: the text that is read
    bool deleted = false;     ///< starts with a slash
    bool empty = true;        ///< no word at all

    static constexpr std::size_t index(char letter) { return static_cast<std::size_t>(letter - 'A'); }
    static constexpr std::uint32_t bit(char letter) { return 1u << index(letter); }
    bool has(char letter) const { return (present & bit(letter)) != 0; }
    double operator[](char letter) const { return value[index(letter)]; }
    Spot at(int where) const { return {line, where, file}; }
    Spot spot(char letter) const { return at(column[index(letter)]); }
};

/// Cuts lines of G-code into words, with the values of expressions worked out. Blanks mean nothing, not even inside
/// numbers; letters count in either case. Assignments take effect when the whole line is read.
class BlockScanner {
  public:
    BlockScanner(Parameters& parameters, const ControlParameters& control, Findings& findings)
        : parameters_(parameters),
          control_(control),
          findings_(findings),
          expressions_(linuxcnc_parameters, parameters, control, findings) {}

    enum class Found : std::uint8_t { words, o_word, refused };

    /// `o_word`: the line starts with one, and the cursor stands behind its O. Allocates nothing for plain words.
    Found scan(LineCursor& cursor, Block& block);
    ParameterExpressions& expressions() { return expressions_; }
    /// Nothing but comments is left.
    bool at_end(LineCursor& cursor);

  private:
    bool word(LineCursor& cursor, Block& block);
    bool assignment(LineCursor& cursor);
    void assign();
    bool code(const LineCursor& cursor, Block& block, char letter, double value, int column);
    bool comment(LineCursor& cursor);
    std::optional<double> number(LineCursor& cursor);
    bool refuse(const LineCursor& cursor, std::string_view code, int at, std::string_view text, std::string_view value,
                std::string_view hint = {}) {
        return findings_.refuse(code, cursor.spot(at), std::string(text), value, hint);
    }

    Parameters& parameters_;
    const ControlParameters& control_;
    Findings& findings_;
    ParameterExpressions expressions_;
    std::vector<std::pair<ParameterReference, ParameterValue>> assignments_;
};

}  // namespace trunnion::nc
