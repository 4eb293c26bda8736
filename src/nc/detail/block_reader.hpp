#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string_view>
#include <vector>

#include "trunnion/nc/read.hpp"

#include "detail/findings.hpp"
#include "detail/program_text.hpp"

namespace trunnion::nc {

/// The reader of one dialect, as far as all are alike: it carries out one block after the other, and what they say
/// gathers in a program, of which the beginning may be given out while reading goes on.
///
/// While reading goes on the rotary words of moves and curves are by the machine's rotary axes, unknown (NaN) until
/// said; a part that is given out has those that the program uses.
class BlockReader {
  public:
    virtual ~BlockReader() = default;
    BlockReader(const BlockReader&) = delete;
    BlockReader& operator=(const BlockReader&) = delete;

    enum class Step : std::uint8_t { block, end, refused };
    /// Carries out the next block. Behind `end` finish() is called.
    virtual Step read_block() = 0;
    /// What is left to do and to say when the text is over; false: refused.
    virtual bool finish() = 0;
    /// Of the block that was read.
    virtual int line() const = 0;
    /// The text that is read, and where its next line starts.
    virtual const ProgramText& text() const = 0;
    virtual std::size_t position() const = 0;
    /// Something begins in blocks that were read and ends in a later one, so that no part can end here.
    virtual bool waits() const { return false; }
    /// Leaves out moves before the first pose that is known whole. Called before the first part is given out.
    virtual void leave_out_start() {}
    /// Letter of a rotary axis of the machine; NUL: there is none.
    virtual char rotary_letter(std::size_t) const { return '\0'; }
    /// Whether a word of this axis has been carried out.
    virtual bool is_said(std::size_t) const { return false; }

    const program::Program& program() const { return program_; }
    Findings& findings() { return findings_; }

    /// Gives out what ends with moves[last], behind which there is at least one more move; reading goes on with the
    /// rest. `part` lends its storage to the moves from the next reuse() on.
    void give_out(std::size_t last, program::Program& part);
    /// Gives out all.
    void give_out_rest(program::Program& part);
    /// Takes the storage of a part for the moves to come.
    void reuse(program::Program& part, std::size_t moves);
    /// The program asks for no stop at the end of this move: one is made there.
    void stop_behind(std::size_t move) { program_.moves[move].exact_stop = true; }

  protected:
    BlockReader(std::string_view file_name, const ReadOptions& options, Dialect dialect);

    /// Where motion starts.
    const program::Move& first_move() const { return first_move_ ? *first_move_ : program_.moves.front(); }
    /// Whether a move counts in this offset.
    bool is_moved_in(std::uint16_t offset) const;

    Findings findings_;
    const ReadOptions& options_;
    program::Program program_;

  private:
    void take_used_letters(program::Program& part);

    std::optional<program::Move> first_move_;  ///< once it was given out
    std::vector<bool> offsets_moved_in_;       ///< of what was given out
    std::vector<std::size_t> used_axes_;       ///< of the machine, in the order of the program's rotary letters
};

}  // namespace trunnion::nc
