#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "detail/findings.hpp"
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
    int line = 0;
    bool deleted = false;  ///< starts with a slash
    bool empty = true;     ///< no word at all

    static constexpr std::size_t index(char letter) { return static_cast<std::size_t>(letter - 'A'); }
    static constexpr std::uint32_t bit(char letter) { return 1u << index(letter); }
    bool has(char letter) const { return (present & bit(letter)) != 0; }
    double operator[](char letter) const { return value[index(letter)]; }
    Spot spot(char letter) const { return {line, column[index(letter)]}; }
};

/// Cuts G-code into blocks. Blanks mean nothing, not even inside numbers; letters count in either case.
class BlockScanner {
  public:
    BlockScanner(std::string_view text, Findings& findings) : lines_(text), findings_(findings) {}

    enum class Step { block, end, refused };

    /// Allocates nothing unless it refuses. Ends at the second line that starts with `%`.
    Step next(Block& block);
    std::string_view rest() const { return lines_.rest(); }

  private:
    bool scan(Block& block);
    bool word(Block& block);
    bool code(Block& block, char letter, double value, int column);
    bool comment();
    std::optional<double> number();
    std::optional<double> number_with_blanks();
    int column() const { return 1 + static_cast<int>(line_.size() - rest_.size()); }
    bool refuse(std::string_view code, int at, std::string_view text, std::string_view value,
                std::string_view hint = {}) {
        return findings_.refuse(code, {lines_.number(), at}, std::string(text), value, hint);
    }

    LineScanner lines_;
    Findings& findings_;
    std::string_view line_, rest_;
    int percent_signs_ = 0;
};

}  // namespace trunnion::nc
