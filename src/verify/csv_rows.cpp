#include "detail/csv_rows.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "trunnion/base/number.hpp"

#include "detail/fault.hpp"

namespace trunnion::verify {

namespace {

constexpr double largest_number =
    1e12;  // mm, deg, s: beyond it a square may overflow, and nothing measured is so large

std::string_view trimmed(std::string_view text) {
    constexpr std::string_view blanks = " \t\r";
    const auto first = text.find_first_not_of(blanks);
    if (first == std::string_view::npos) return {};
    return text.substr(first, text.find_last_not_of(blanks) - first + 1);
}

/// Everything up to the mark, which is dropped with it.
std::string_view take_until(std::string_view& text, char mark) {
    const auto end = text.find(mark);
    const std::string_view out = text.substr(0, end);
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    return out;
}

}  // namespace

Result<CsvRows> CsvRows::open(std::string_view text, std::string file) {
    CsvRows rows(text, std::move(file));
    if (!rows.take_line(rows.header_)) return fail(rows.diagnose("VER0201", "the table is empty"));
    for (auto name = rows.header_.begin(); name != rows.header_.end(); ++name)
        if (std::find(rows.header_.begin(), name, *name) != name)
            return fail(rows.diagnose("VER0205", fmt::format("column {} is there twice", *name)));
    return rows;
}

std::optional<std::size_t> CsvRows::find(std::string_view column) const {
    const auto found = std::find(header_.begin(), header_.end(), column);
    if (found == header_.end()) return {};
    return static_cast<std::size_t>(found - header_.begin());
}

Result<std::size_t> CsvRows::require(std::string_view column) const {
    if (const auto found = find(column)) return *found;
    return fail(diagnose("VER0202", fmt::format("column {} is missing", column)));
}

bool CsvRows::take_line(std::vector<std::string_view>& fields) {
    while (!rest_.empty()) {
        ++line_;
        std::string_view text = trimmed(take_until(rest_, '\n'));
        if (text.empty()) continue;
        fields.clear();
        const bool ends_open = text.back() == ',';
        while (!text.empty()) fields.push_back(trimmed(take_until(text, ',')));
        if (ends_open) fields.emplace_back();
        return true;
    }
    return false;
}

Result<bool> CsvRows::next() {
    if (!take_line(fields_)) return false;
    if (fields_.size() != header_.size())
        return fail(
            diagnose("VER0204", fmt::format("the row has {} fields, the header {}", fields_.size(), header_.size())));
    return true;
}

Result<double> CsvRows::number(std::size_t column) const {
    std::string_view text = fields_[column];
    const auto value = take_number(text, Exponent::allowed);
    if (value && text.empty() && std::abs(*value) <= largest_number) return *value;
    return fail(
        diagnose("VER0203", fmt::format("column {} has no number", header_[column]), std::string(fields_[column])));
}

Diagnostic CsvRows::diagnose(std::string code, std::string text, std::string value) const {
    auto out = fault_at(line_, std::move(code), std::move(text), file_);
    out.value = std::move(value);
    return out;
}

}  // namespace trunnion::verify
