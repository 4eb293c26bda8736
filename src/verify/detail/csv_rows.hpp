#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "trunnion/base/result.hpp"

namespace trunnion::verify {

/// Rows of a CSV text with a header, fields without quotes. Blank lines are passed over. Views point into the text.
class CsvRows {
  public:
    /// Reads the header. Errors: VER0201 the text is empty, VER0205 a column twice.
    static Result<CsvRows> open(std::string_view text, std::string file);

    const std::vector<std::string_view>& header() const { return header_; }
    std::optional<std::size_t> find(std::string_view column) const;
    /// Error: VER0202.
    Result<std::size_t> require(std::string_view column) const;

    /// Goes to the next row; false at the end. Error: VER0204 not as many fields as the header.
    Result<bool> next();
    std::string_view field(std::size_t column) const { return fields_[column]; }
    /// Error: VER0203, also for a number beyond ±1e12.
    Result<double> number(std::size_t column) const;
    int line() const { return line_; }

    Diagnostic diagnose(std::string code, std::string text, std::string value = {}) const;

  private:
    CsvRows(std::string_view text, std::string file) : rest_(text), file_(std::move(file)) {}
    bool take_line(std::vector<std::string_view>& fields);

    std::string_view rest_;
    std::string file_;
    std::vector<std::string_view> header_, fields_;
    int line_ = 0;
};

}  // namespace trunnion::verify
