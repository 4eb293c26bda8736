#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "detail/findings.hpp"
#include "detail/sinumerik_flow.hpp"
#include "detail/text.hpp"

namespace trunnion::nc::sinumerik {

constexpr bool is_name_character(char c) {
    return is_letter(c) || is_digit(c) || c == '_';
}
/// A name that the programmer may give: two letters (or underscores) first. One letter and digits are an address.
constexpr bool is_own_name(std::string_view name) {
    return name.size() >= 2 && (is_letter(name[0]) || name[0] == '_') && (is_letter(name[1]) || name[1] == '_');
}

std::string in_capitals(std::string_view text);

/// The line that is being read: takes its parts one after the other, and knows where to complain. Blanks in front of a
/// part are skipped. Capitals throughout, but for texts between quotation marks.
class Cursor {
  public:
    explicit Cursor(Findings& findings) : findings_(&findings) {}

    /// `original`: the same characters before they became capitals. `file` is empty for the text that is read.
    void start(std::string_view capitals, const char* original, int number, std::string_view file);

    bool at_end();                             ///< nothing but a comment is left
    char front();                              ///< the next character that is no blank; NUL at the end
    bool sees(std::string_view symbol);        ///< it comes next, if within a longer word
    bool take(std::string_view symbol);        ///< takes the symbol if it comes next
    bool take_word(std::string_view word);     ///< takes the word if it comes next, whole
    bool want(std::string_view symbol);        ///< takes it, or NC0501
    bool want_end();                           ///< or NC0524
    std::string_view name();                   ///< letters, digits, underscores, a $ in front; empty if none comes
    std::string_view peek_name() const;        ///< the same, and stays
    std::optional<double> number();            ///< with its sign, exponents as EX-3; empty: stays where it is
    bool text(std::string& into);              ///< between quotation marks, or NC0515
    bool goes_to_word(std::string_view word);  ///< onward behind the next such word; false, and at the end, if none
    bool has_jump() const;                     ///< GOTO, GOTOF, GOTOB, GOTOC or GOTOS is still to come
    std::string_view line() const { return line_; }
    std::string_view rest() const { return rest_; }
    void go_back_to(int column) { rest_ = line_.substr(static_cast<std::size_t>(column - 1)); }
    void advance(std::size_t count) { rest_.remove_prefix(count); }

    int column() const { return 1 + static_cast<int>(line_.size() - rest_.size()); }
    int next_column() { return front(), column(); }  ///< of the next character that is no blank
    Spot spot(int column) const { return {number_, column, file_}; }
    bool refuse(std::string_view code, int column, std::string text, std::string_view value = {},
                std::string_view hint = {}) const {
        return findings_->refuse(code, spot(column), std::move(text), value, hint);
    }
    /// What comes next is not expected here.
    bool refuse_here();

  private:
    bool skip_text();

    Findings* findings_;
    std::string_view line_, rest_, file_;
    const char* original_ = nullptr;
    int number_ = 0;
};

/// One program of a file: from its %_N_NAME_SPF line, or the start of the file, to the next such line.
struct Section {
    std::string name;   ///< in capitals, without %, _N_, _MPF and _SPF; empty without such a line
    bool main = false;  ///< an MPF
    LinePlace begin;
    std::size_t end = 0;
    std::unique_ptr<FlowIndex> flow;  ///< made when the first jump or control structure is met
};

/// A line in capitals; the views are of the text itself, or of the buffer where it has small letters.
struct CapitalLine {
    std::string_view capitals{};
    const char* original = nullptr;
    std::string buffer{};
};

/// The text of one file, cut in sections.
class Source {
  public:
    /// `file` is empty for the text that is read. `text` must outlive the source.
    Source(std::string file, const ProgramText& text);
    /// Keeps the text itself.
    static std::unique_ptr<Source> keeping(std::string file, std::string text);

    std::string_view file() const { return file_; }
    const ProgramText& text() const { return text_; }
    bool is_before_end(const LinePlace& place, const Section& section) const {
        return place.offset < std::min(section.end, text_.size());
    }
    Section& main_section();
    Section* section(std::string_view name);

    /// The line that starts at `place`, without its end; `place` moves on to the next one. A last line may lack its
    /// end.
    void take_line(LinePlace& place, CapitalLine& line);
    /// From `place` to before `end`; 0: none, or comments alone.
    int next_line_that_says_something(LinePlace place, std::size_t end);
    /// For one more look at the whole text.
    Source again() const { return {file_, text_.again()}; }

  private:
    void cut_sections();

    std::string file_, kept_;
    ProgramText text_;
    std::vector<Section> sections_;
};

/// The files beside the main program, by name in capitals.
class Folder {
  public:
    /// Of the file `main_program`, if it is there; else there are none.
    explicit Folder(std::string_view main_program);

    enum class Found : std::uint8_t { file, nothing, several, outside, unreadable };

    /// Reads NAME.SPF or NAME.MPF, or `name` as it is if it has one of these endings.
    Found read(std::string_view name, std::unique_ptr<Source>& source);

  private:
    void list();

    std::filesystem::path folder_;
    bool listed_ = false;
    std::map<std::string, std::vector<std::filesystem::path>, std::less<>> files_;
};

}  // namespace trunnion::nc::sinumerik
