#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "detail/rs274_block.hpp"

namespace trunnion::nc {

enum class FlowKeyword : std::uint8_t {
    program,  ///< an O number alone: a subprogram for M98, or the program's own number
    sub,
    end_sub,
    call,
    give_back,  ///< return
    when,       ///< if
    else_when,
    otherwise,
    end_when,
    loop_while,
    end_while,
    loop_do,
    repeat,
    end_repeat,
    leave_loop,  ///< break
    next_turn    ///< continue
};

/// A line that starts with an O word, and where it belongs.
struct FlowLine {
    FlowKeyword keyword = FlowKeyword::program;
    std::string label{};        ///< digits, or a name in small letters; empty where it is computed
    std::size_t start = 0;      ///< of the line in the text
    std::size_t behind = 0;     ///< of the line that follows
    int number = 0;             ///< of the line
    std::size_t head = 0;       ///< of a structure: its first line, by index
    std::size_t end = 0;        ///< its last one
    std::size_t next_part = 0;  ///< of if and elseif: the elseif, else or endif that follows
};

/// The O words of one text, matched with each other. Labels count within their subprogram.
class FlowIndex {
  public:
    /// Errors: NC0331 an O word that is none, NC0332 structures that do not fit.
    static std::optional<FlowIndex> make(const ProgramText& text, std::string_view file, Findings& findings);

    const std::vector<FlowLine>& lines() const { return lines_; }
    /// By where its line starts; the lines that are asked for have an O word.
    std::size_t at(std::size_t start) const;
    /// The line that begins this subprogram: `o100 sub`, or `O100` alone.
    std::optional<std::size_t> subprogram(std::string_view label, FlowKeyword kind) const;

  private:
    bool match(std::string_view file, Findings& findings);

    std::vector<FlowLine> lines_;
};

/// Lets the lines of a program pass in the order in which LinuxCNC carries them out: O words, subprograms of the text
/// and of its folder, M98 and M99. `o100 call` gives its arguments as #1 … #30 and fresh local parameters; M98 shares
/// those of its caller. A subprogram that the text does not have is the file `<label>.ngc` of the program's folder.
/// Errors: those of BlockScanner, and NC0331 to NC0340.
class Rs274Flow {
  public:
    static constexpr std::size_t most_calls = 10;  ///< within each other, as on LinuxCNC

    /// `text` must outlive the flow. `most_repeated_lines`: carried out again or in subprograms.
    Rs274Flow(const ProgramText& text, std::string_view file_name, const ControlParameters& control, Findings& findings,
              std::int64_t most_repeated_lines);

    enum class Step : std::uint8_t { block, end, refused };

    /// The next line with words. Ends at the second line of the text that starts with `%`.
    Step next(Block& block);
    /// M98: from the next line on, `times` times.
    bool call_program(const Block& block, int column, double number, double times);
    /// M99.
    bool return_from_program(const Block& block, int column);
    std::size_t depth() const { return frames_.size() - 1; }
    /// Whether the text that is read was found to have subprograms of its own.
    bool has_subprograms() const;
    /// What is left of the text that is read; empty within a subprogram.
    std::string_view rest() const;
    const ProgramText& text() const { return main_.text; }
    /// Where the next line of the text that is read starts.
    std::size_t position() const { return frames_.front().next; }

  private:
    struct Source {
        std::string file{};  ///< empty: the text that is read
        std::string kept{};
        ProgramText text{std::string_view{}};
        std::optional<FlowIndex> index{};
    };
    /// A running program.
    struct Frame {
        Source* source = nullptr;
        std::size_t next = 0;  ///< where its next line starts
        int line = 0;          ///< the number of the line before
        int outer_line = 0;    ///< of the call in the text that is read; 0: it runs in that text
        bool has_locals = false;
        double times = 1;  ///< of M98: this one and those to come
        std::size_t first = 0;
        int first_line = 0;
        std::map<std::size_t, double> repetitions{};  ///< turns to come, by the line of the repeat
    };

    std::string_view take_line();
    bool count_line(std::size_t start);
    bool flow(LineCursor& cursor, Block& block);
    bool carry_out(LineCursor& cursor, const FlowLine& line, std::size_t index, const std::string& label);
    bool branch(LineCursor& cursor, std::size_t index);
    bool loop(LineCursor& cursor, const FlowLine& line, std::size_t index);
    bool enclosing_loop(const LineCursor& cursor, const std::string& label, std::size_t index, std::size_t& head);
    bool call(LineCursor& cursor, const std::string& label);
    bool give_back(LineCursor& cursor);
    bool condition(LineCursor& cursor, bool& result);
    bool enter(Spot spot, const std::string& label, FlowKeyword kind, Frame& frame);
    Source* read_file(Spot spot, const std::string& label);
    const FlowIndex* index_of(Source& source);
    void go_behind(const FlowLine& line);
    void go_to(const FlowLine& line);
    bool refuse(const LineCursor& cursor, std::string_view code, std::string text, std::string_view value = {},
                std::string_view hint = {}) {
        return findings_.refuse(code, cursor.spot(), std::move(text), value, hint);
    }

    Findings& findings_;
    Parameters parameters_{linuxcnc_parameters};
    BlockScanner scanner_;
    std::filesystem::path folder_;  ///< empty: there is none
    std::map<std::string, std::unique_ptr<Source>, std::less<>> files_;
    Source main_;
    std::vector<Frame> frames_;
    std::size_t furthest_ = 0;  ///< behind the lines of the main program that were carried out
    std::int64_t lines_left_;
    int percent_signs_ = 0;
};

}  // namespace trunnion::nc
