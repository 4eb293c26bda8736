#pragma once

#include <string_view>
#include <vector>

#include "detail/findings.hpp"

namespace trunnion::nc::fanuc {

/// A letter with its value worked out.
struct Word {
    char letter = 'G';
    bool has_point = false;  ///< the value is written with a decimal point
    int column = 0;
    double value = 0;
};

/// The words of one block, in the order in which they stand; N, comments and calls are taken out.
struct Block {
    std::vector<Word> words;
    int line = 0;
    std::string_view file{};  ///< empty: the text that is read

    Spot spot(const Word& word) const { return {line, word.column, file}; }
    Spot place() const { return {line, words.empty() ? 1 : words.front().column, file}; }
};

/// A G or M word by its number in tenths: `G43.4` is 434; -1: no such word.
int tenths_of(const Word& word);

}  // namespace trunnion::nc::fanuc
