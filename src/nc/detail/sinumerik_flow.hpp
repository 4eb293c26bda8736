#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

namespace trunnion::nc::sinumerik {

class Cursor;
class Source;
struct Section;

/// Where a line starts in its text, and its number from 1.
struct LinePlace {
    std::size_t offset = 0;
    int line = 1;
};

/// A line, and the one behind it.
struct LineMark {
    LinePlace at, behind;
};

/// IF to ENDIF, FOR to ENDFOR and so on.
struct Structure {
    enum class Kind : std::uint8_t { choice, count, condition_first, condition_last, endless };
    Kind kind = Kind::choice;
    bool has_middle = false;
    LineMark begin, middle, end;  ///< middle: ELSE
    int outer = -1;               ///< the structure around it
};

/// Where a jump can go.
struct Target {
    LineMark line;
    int structure = -1;  ///< the innermost one around it
};

/// The labels, block numbers and control structures of one section.
class FlowIndex {
  public:
    using BlockNumbers = std::set<std::string, std::less<>>;

    /// Of block numbers only those that jumps have asked for: long programs have one in every line.
    explicit FlowIndex(BlockNumbers block_numbers) : block_numbers_(std::move(block_numbers)) {}
    const BlockNumbers& block_numbers() const { return block_numbers_; }

    /// One pass over the section. False where structures do not fit (NC0522).
    bool build(const Source& source, const Section& section, Cursor& cursor);

    /// The structure that has its begin, middle or end at this line; null: none.
    const Structure* structure_at(std::size_t offset) const;
    int number_of(const Structure& structure) const { return static_cast<int>(&structure - structures_.data()); }

    enum class Direction : std::uint8_t { forward, backward, forward_first, backward_first };

    /// A label or a block number (N100), seen from the line at `from`. The line itself counts as backward.
    const Target* find(std::string_view name, Direction direction, std::size_t from) const;

    /// Whether `target` lies in a structure that `from` is not in.
    bool enters_structure(const Target& target, std::size_t from) const;

  private:
    bool read_line(Cursor& cursor, const LineMark& mark);
    bool open(Structure::Kind kind, const LineMark& mark);
    bool close(Structure::Kind kind, const LineMark& mark, Cursor& cursor, int column, std::string_view word);
    bool divide(const LineMark& mark, Cursor& cursor, int column);

    BlockNumbers block_numbers_;
    std::vector<Structure> structures_;
    std::vector<int> open_;
    std::unordered_map<std::size_t, int> by_line_;
    std::map<std::string, std::vector<Target>, std::less<>> targets_;
};

}  // namespace trunnion::nc::sinumerik
