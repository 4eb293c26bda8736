#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "detail/findings.hpp"
#include "detail/text.hpp"

namespace trunnion::nc::heidenhain {

/// Where a line begins.
struct LinePlace {
    std::size_t offset = 0;
    int line = 1;
    bool operator==(const LinePlace&) const = default;
};

inline constexpr std::size_t longest_statement = 20'000;  ///< characters of lines that `~` joins

/// One block: a line without its number and comment, or several that `~` joins.
class Statement {
  public:
    std::string_view text() const { return text_; }
    int line() const { return parts_.front().line; }
    Spot spot(std::size_t index) const;

  private:
    friend class Source;
    /// From `begin` on the text stands in `line`, from `column` on.
    struct Part {
        std::size_t begin;
        int line, column;
    };

    std::string_view text_, file_;
    std::string joined_;
    std::vector<Part> parts_{{0, 1, 1}};
};

/// The text of one program, and where its labels are.
class Source {
  public:
    /// `file` is empty for the text that is read; `text` must outlive the source.
    Source(std::string file, const ProgramText& text) : file_(std::move(file)), text_(text) {}
    /// Keeps the text itself.
    static std::unique_ptr<Source> keeping(std::string file, std::string text);

    enum class Taken : std::uint8_t { statement, end, too_long };
    /// The next block that says something; `place` moves on behind it.
    Taken next(LinePlace& place, Statement& statement);

    enum class Found : std::uint8_t { once, nowhere, twice };
    /// `name` as label_name() writes it; `place` comes to lie behind the line of the label.
    Found label(std::string_view name, LinePlace& place);

    std::string_view file() const { return file_; }
    const ProgramText& text() const { return text_; }

  private:
    std::string_view take_line(LinePlace& place);
    bool join(LinePlace& place, Statement& statement);
    void index_labels();

    struct Label {
        LinePlace place;
        bool twice = false;
    };
    std::string file_, kept_;
    ProgramText text_;
    bool indexed_ = false;
    std::map<std::string, Label, std::less<>> labels_;
};

/// The name of a label for Source::label: digits without leading zeros, or a name with a quotation mark in front.
std::string label_name(std::string_view written);

/// A number of Klartext, with its sign and a decimal point or comma; taken off the text. Empty: there is none.
std::optional<double> take_klartext_number(std::string_view& text) noexcept;

/// The block that is being read: takes its parts one after the other. Blanks in front of a part are skipped.
class Cursor {
  public:
    void start(const Statement& statement) {
        statement_ = &statement;
        rest_ = statement.text();
    }
    bool at_end() {
        rest_ = skip_blanks(rest_);
        return rest_.empty();
    }
    /// The next character that is no blank, in capitals; NUL at the end.
    char front() { return at_end() ? '\0' : upper(rest_.front()); }
    char behind_front() const { return rest_.size() > 1 ? upper(rest_[1]) : '\0'; }
    bool take(char symbol) {
        if (front() != symbol || symbol == '\0') return false;
        rest_.remove_prefix(1);
        return true;
    }
    /// Takes the word if it comes next, whole.
    bool take_word(std::string_view capitals);
    /// The letters and underscores that come next, in capitals, at most 16 of them; a Q, QL or QR before a digit is
    /// left where another word stands before it (FQ5). Valid until the next call.
    std::string_view name();
    std::optional<double> number() {
        rest_ = skip_blanks(rest_);
        return take_klartext_number(rest_);
    }
    /// Between quotation marks; empty where none comes, or it is not closed.
    std::optional<std::string_view> quoted();
    /// Up to the next blank.
    std::string_view bare();
    std::string_view rest() const { return rest_; }
    void skip(std::size_t count) { rest_.remove_prefix(std::min(count, rest_.size())); }
    void go_back_to(std::size_t index) { rest_ = statement_->text().substr(index); }
    std::size_t index() const { return statement_->text().size() - rest_.size(); }
    /// Of the next character that is no blank.
    std::size_t next_index() { return at_end(), index(); }
    Spot spot(std::size_t index) const { return statement_->spot(index); }

  private:
    const Statement* statement_ = nullptr;
    std::string_view rest_;
    std::array<char, 16> name_{};
};

/// The programs beside the main program, by name in capitals.
class Folder {
  public:
    /// Of the file `main_program`, if it is there; else there are none.
    explicit Folder(std::string_view main_program);

    enum class Found : std::uint8_t { file, nothing, several, outside, unreadable };
    /// Reads NAME.H, or `name` as it is if it has this ending, in any case of letters.
    Found read(std::string_view name, std::unique_ptr<Source>& source);

  private:
    void list();

    std::filesystem::path folder_;
    bool listed_ = false;
    std::map<std::string, std::vector<std::filesystem::path>, std::less<>> files_;
};

}  // namespace trunnion::nc::heidenhain
