#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "trunnion/base/diagnostic.hpp"

namespace trunnion::nc {

/// Line and column in the text, from 1; 0 = unknown. `file` names another file than the one that is read; else empty.
struct Spot {
    int line = 0;
    int column = 0;
    std::string_view file{};
};

/// What a reader has to say besides the program: the one error that ends it, and warnings, each once with its count.
class Findings {
  public:
    explicit Findings(std::string_view file) : file_(file) {}

    /// Keeps the error; false, so that a reader can return it.
    bool refuse(std::string_view code, Spot spot, std::string text, std::string_view value = {},
                std::string_view hint = {}) {
        error_ = diagnostic(code, Severity::error, spot, std::move(text), value, hint);
        return false;
    }

    /// The same for a diagnostic from elsewhere, placed here.
    bool refuse(Spot spot, Diagnostic found) {
        error_ = std::move(found);
        error_.place = place(spot);
        return false;
    }

    /// `times` more of `word` under `code`; the first one sets place and text. Allocates at the first one only. Where
    /// very many words are told of, those to come count with the first one of their code.
    void count(std::string_view code, Severity severity, Spot spot, std::string_view word, std::string_view text,
               std::string_view hint = {}, int times = 1) {
        for (Diagnostic& notice : notices_)
            if (notice.code == code && (notice.value == word || notices_.size() >= most_notices))
                return void(notice.count += times);
        notices_.push_back(diagnostic(code, severity, spot, std::string(text), word, hint));
        notices_.back().count = times;
    }

    void ignored(Spot spot, std::string_view word) {
        count("NC0012", Severity::warning, spot, word, "ignored: it cannot change motion");
    }

    Diagnostic take_error() { return std::move(error_); }
    std::vector<Diagnostic> take_notices() { return std::move(notices_); }

  private:
    static constexpr std::size_t most_notices = 1000;

    Place place(Spot spot) const {
        return {.file = spot.file.empty() ? file_ : std::string(spot.file), .line = spot.line, .column = spot.column};
    }
    Diagnostic diagnostic(std::string_view code, Severity severity, Spot spot, std::string text, std::string_view value,
                          std::string_view hint) const {
        return {.code = std::string(code),
                .severity = severity,
                .text = std::move(text),
                .place = place(spot),
                .value = std::string(value),
                .hint = std::string(hint)};
    }

    std::string file_;
    Diagnostic error_;
    std::vector<Diagnostic> notices_;
};

}  // namespace trunnion::nc
