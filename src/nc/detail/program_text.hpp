#pragma once

#include <algorithm>
#include <concepts>
#include <cstddef>
#include <limits>
#include <optional>
#include <string_view>

namespace trunnion::nc {

/// The number of the line behind another one. The last number there is stays: a reader that gets there is stopped.
constexpr int number_behind(int line) {
    return line < std::numeric_limits<int>::max() ? line + 1 : line;
}

/// A text of any length, of which lines are taken wherever they begin.
///
/// It is looked through for NUL bytes a stretch ahead of the line that is taken. One that is found ends the text where
/// its line begins: nul() says where it stood. Of a file that is mapped into memory the pages that lie some MB behind
/// are given back; they come again by themselves when a line of theirs is taken again. A copy has a window of its own.
class ProgramText {
  public:
    /// `text` must outlive this and all copies. `is_mapped`: its pages are those of a file that nobody writes to.
    template <std::convertible_to<std::string_view> Text>
    ProgramText(const Text& text, bool is_mapped = false) : text_(text), is_mapped_(is_mapped) {}

    std::string_view view() const { return text_; }
    std::size_t size() const { return text_.size(); }
    /// Where the NUL byte stands that ended the text.
    std::optional<std::size_t> nul() const { return nul_; }

    /// The line that starts at `from`, without its end; `behind`: where the next one starts, size() behind the last.
    std::string_view line(std::size_t from, std::size_t& behind) {
        std::size_t end = std::min(text_.find('\n', from), text_.size());
        if (end >= looked_up_to_) {
            look_ahead(from, end);
            end = std::min(text_.find('\n', from), text_.size());
        }
        behind = std::min(end + 1, text_.size());
        return from < end ? text_.substr(from, end - from) : std::string_view{};
    }

    /// The same text for one more look from its beginning.
    ProgramText again() const { return {text_, is_mapped_}; }
    /// The same text without its first bytes.
    ProgramText without(std::size_t first) const { return {text_.substr(first), is_mapped_}; }
    /// Looks through all that is left for NUL bytes.
    void look_to_the_end();

  private:
    void look_ahead(std::size_t from, std::size_t end);
    void give_back(std::size_t from, std::size_t end) const;

    std::string_view text_;
    bool is_mapped_;
    std::size_t looked_up_to_ = 0;
    std::size_t kept_from_ = 0;  ///< pages before it were given back
    std::optional<std::size_t> nul_{};
};

/// Lines of a text, without their ends, counted from 1.
class LineScanner {
  public:
    explicit LineScanner(const ProgramText& text) : text_(text) {}

    bool next(std::string_view& line) {
        if (offset_ >= text_.size()) return false;
        line = text_.line(offset_, offset_);
        number_ = number_behind(number_);
        return true;
    }
    int number() const { return number_; }
    /// Where the next line starts.
    std::size_t offset() const { return offset_; }
    std::string_view rest() const { return text_.view().substr(std::min(offset_, text_.size())); }
    const ProgramText& text() const { return text_; }
    ProgramText& text() { return text_; }

  private:
    ProgramText text_;
    std::size_t offset_ = 0;
    int number_ = 0;
};

}  // namespace trunnion::nc
