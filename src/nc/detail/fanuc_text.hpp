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

#include "detail/program_text.hpp"

namespace trunnion::nc::fanuc {

/// Where a line of a text begins, or what follows a `;` in it.
struct Place {
    std::size_t offset = 0;
    int line = 1;
};

/// Where the code of a tape begins: behind its first `%`, if nothing that looks like code stands before it.
struct Beginning {
    Place place;
    bool behind_header = false;  ///< lines that are neither code nor comments were passed over
};
Beginning beginning_of(const ProgramText& text);

/// Whether a line, without blanks around it, begins like a block: a word, a variable, a statement.
bool begins_like_code(std::string_view line);

/// A program of a text: from its O number to before the next one.
struct Section {
    int number = -1;  ///< -1: it has a name, or none
    Place begin;      ///< its title, if it has one
    std::size_t end = 0;
};

/// A text with its programs and their sequence numbers, which are looked for when a jump or call first asks for them.
class Source {
  public:
    /// `text` outlives it. `file`: empty for the text that is read.
    explicit Source(const ProgramText& text, std::string file = {});
    static std::unique_ptr<Source> keeping(std::string file, std::string text);

    const ProgramText& text() const { return text_; }
    std::string_view file() const { return file_; }
    const Beginning& beginning() const { return beginning_; }
    /// The first program, with what stands before its title; where it ends is not looked for.
    Section main_section();
    /// Where a program ends that begins there.
    std::size_t end_of(const Section& section);
    const Section* section(int number);
    /// The blocks `N number` of a program, in order.
    const std::vector<Place>& labels(const Section& section, int number);
    /// The whole line at a place, without its end.
    std::string_view line_at(const Place& place);
    /// The line behind that one; its offset is text().size() at the end.
    Place line_behind(const Place& place);

  private:
    void cut_sections();

    std::string kept_, file_;
    ProgramText text_;
    Beginning beginning_;
    std::vector<Section> sections_;
    /// By where the section begins, and the number: those that were asked for.
    std::map<std::pair<std::size_t, int>, std::vector<Place>> labels_;
};

/// `O123` or `:123` at the start of a line; what follows is left in `line`.
std::optional<int> take_program_number(std::string_view& line);
/// Whether a line is the title of a program, by number or by name.
bool is_title(std::string_view line);

/// The files beside the main program.
class Folder {
  public:
    /// Of the file `main_program`, if it is there; else there are none.
    explicit Folder(std::string_view main_program);

    enum class Found : std::uint8_t { file, nothing, several, outside, unreadable };

    /// Reads the program of a number: a file O0123 or 0123, with an ending or without.
    Found read(int number, std::unique_ptr<Source>& source);

  private:
    void list();

    std::filesystem::path folder_;
    bool listed_ = false;
    std::map<int, std::vector<std::filesystem::path>> files_;
};

}  // namespace trunnion::nc::fanuc
