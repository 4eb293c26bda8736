#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "detail/findings.hpp"
#include "detail/text.hpp"

namespace trunnion::nc {

/// Cuts APT data into statements: joins lines over `$`, drops `$$` comments, splits at the slash.
class StatementScanner {
  public:
    explicit StatementScanner(const ProgramText& text) : lines_(text) {}

    enum class Step { statement, end, truncated };

    /// Views of a statement stay valid until the next call. Allocates only when a statement is longer than all before.
    Step next();

    std::string_view major() const { return major_; }          ///< as written; empty for a bare pose
    std::string_view arguments() const { return arguments_; }  ///< behind the slash; of a text statement its text
    Spot spot() const { return spot(body_); }
    Spot spot(std::string_view part) const;  ///< of the start of a part of the statement
    std::string_view rest() const { return lines_.rest(); }
    int line() const { return lines_.number(); }
    std::size_t offset() const { return lines_.offset(); }
    const ProgramText& text() const { return lines_.text(); }

  private:
    /// A stretch of the statement that stands in one line of the text.
    struct Segment {
        std::size_t offset;  ///< in the statement
        Spot spot;
    };

    bool is_comment(std::string_view text);
    bool append(std::string_view line);
    Step join(std::string_view first);
    void split();
    bool take_text_statement(std::string_view line);

    LineScanner lines_;
    std::string joined_;
    std::vector<Segment> segments_;
    std::string_view line_, body_, major_, arguments_;
    bool listing_ = false;  ///< the comment before goes on
};

}  // namespace trunnion::nc
