#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "detail/findings.hpp"

namespace trunnion::nc::sinumerik {

/// How the value of an axis word counts: X10 | X=AC(10) | X=IC(10) | C=DC(10) | C=ACP(10) | C=ACN(10).
enum class Counting : std::uint8_t { modal, absolute, incremental, shortest, positive, negative };

/// One argument of a call.
struct Argument {
    enum class Kind : std::uint8_t {
        empty,   ///< nothing between two commas
        number,  ///< TRUE and FALSE are 1 and 0
        text,    ///< as written, not in capitals
        name     ///< an axis or another name that is no variable: FGROUP(X,Y); in `text`, in capitals. Where a number
                 ///< is wanted it is a variable that nobody defined
    };
    Kind kind = Kind::empty;
    double number = 0;
    std::string text;
};

/// One word with its value worked out.
struct Word {
    /// In capitals, valid until the next block is taken: the address letter (`G1` is G with value 1, `A3` is A with 3), an
    /// address with its digits where `=` follows (`A3=1` is A3, `I1=2` is I1; but M, S, H, T and D keep their number
    /// in `extension`), an address of several letters (CR, TURN) or a word of the control (TRAORI, CYCLE832).
    std::string_view name;
    Counting counting = Counting::modal;
    bool has_value = false;
    bool has_text = false;  ///< T="MILL": in `text`
    bool is_call = false;   ///< brackets stand behind it, if empty ones: TRAORI(1), CYCLE800()
    bool is_list = false;   ///< PO[X]=(1,2,3), X=PO(1,2,3): a polynomial; its values are the arguments
    double value = 0;       ///< finite; as written: mm or inch, degrees
    std::string text;
    std::vector<Argument> arguments;  ///< CYCLE800(1,"R_DATA",0,,57): five; of a call or a list, else none
    std::string index;                ///< FGREF[C]=57.3: C in capitals, or the number worked out; else empty
    int extension = 0;                ///< M2=3, S1=1000: 2 and 1; else 0
    int column = 0;                   ///< where the word starts, from 1
};

/// One line of a program that was carried out and has words for the reader, in the order written. Never empty.
struct Block {
    std::vector<Word> words;
    int line = 0;            ///< in the text that is read; within a subprogram of another file the line of the call
    Spot place;              ///< the line itself, with its file where that is another one
    std::string_view label;  ///< the label in front of the line, in capitals; else empty

    /// Where the word stands, for a diagnostic.
    Spot spot(const Word& word) const { return {place.line, word.column, place.file}; }
};

}  // namespace trunnion::nc::sinumerik
