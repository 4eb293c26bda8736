#include "trunnion/nc/read.hpp"

#include <algorithm>
#include <fstream>
#include <limits>
#include <system_error>

#include <fmt/format.h>

#include "detail/dialects.hpp"
#include "detail/findings.hpp"
#include "detail/gzip.hpp"

namespace trunnion::nc {

namespace {

constexpr std::size_t longest_text = std::numeric_limits<std::int32_t>::max();
constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";

Diagnostic about_file(std::string_view code, std::string_view file, std::string text, std::string hint = {}) {
    return {.code = std::string(code),
            .text = std::move(text),
            .place = {.file = std::string(file)},
            .hint = std::move(hint)};
}

/// Why a text is no program in any dialect; empty when it may be one.
std::optional<Diagnostic> unreadable(std::string_view text, std::string_view file) {
    if (text.size() > longest_text)
        return about_file("NC0008", file, fmt::format("{} bytes are more than are read", text.size()),
                          "cut the program in parts");
    const std::size_t nul = text.find('\0');
    if (nul == text.npos) return {};
    Diagnostic binary = about_file("NC0003", file, "a NUL byte: this is no text", "give the part program itself");
    binary.place.line =
        1 + static_cast<int>(std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(nul), '\n'));
    return binary;
}

}  // namespace

std::string_view name_of(Dialect dialect) noexcept {
    switch (dialect) {
        case Dialect::apt:
            return "apt";
        case Dialect::rs274:
            return "rs274";
        case Dialect::sinumerik:
            return "sinumerik";
        case Dialect::heidenhain:
            return "heidenhain";
        case Dialect::fanuc:
            break;
    }
    return "fanuc";
}

std::optional<Dialect> dialect_named(std::string_view name) noexcept {
    for (const Dialect dialect :
         {Dialect::apt, Dialect::rs274, Dialect::sinumerik, Dialect::heidenhain, Dialect::fanuc})
        if (name_of(dialect) == name) return dialect;
    return {};
}

std::optional<std::uint16_t> index_in(std::vector<std::string>& names, std::string_view name) {
    const auto found = std::ranges::find(names, name);
    const auto index = static_cast<std::size_t>(found - names.begin());
    if (index > std::numeric_limits<std::uint16_t>::max()) return {};
    if (found == names.end()) names.emplace_back(name);
    return static_cast<std::uint16_t>(index);
}

void report_units(const UnitStatement& stated, Units wanted, Findings& findings) {
    if (wanted == Units::none && !stated.mm && !stated.inch)
        findings.count("NC0011", Severity::warning, {}, "mm", "the program states no unit of length: mm assumed",
                       "--units mm or --units inch says which");
    if ((wanted == Units::mm && stated.inch) || (wanted == Units::inch && stated.mm))
        findings.count("NC0018", Severity::note, {}, wanted == Units::mm ? "mm" : "inch",
                       "the program states another unit of length: the one that was asked for is taken");
}

Result<program::Program> read_program(std::string_view text, std::string_view file_name, const ReadOptions& options) {
    if (auto reason = unreadable(text, file_name)) return fail(std::move(*reason));
    if (text.starts_with(byte_order_mark)) text.remove_prefix(byte_order_mark.size());
    auto dialect = recognise(text);
    if (!dialect && (!options.dialect || dialect.error().code == "NC0002")) {
        dialect.error().place.file = file_name;
        return fail(std::move(dialect.error()));
    }
    const Dialect chosen = options.dialect ? *options.dialect : *dialect;
    switch (chosen) {
        case Dialect::apt:
            return read_apt(text, file_name, options);
        case Dialect::rs274:
            return read_rs274(text, file_name, options);
        case Dialect::sinumerik:
            return read_sinumerik(text, file_name, options);
        case Dialect::heidenhain:
            return read_heidenhain(text, file_name, options);
        case Dialect::fanuc:
            break;
    }
    return read_fanuc(text, file_name, options);
}

Result<program::Program> read_program_file(const std::filesystem::path& file, const ReadOptions& options) {
    std::error_code error;
    const auto size = std::filesystem::file_size(file, error);
    if (error) return fail(about_file("NC0001", file.string(), "cannot be read: " + error.message(), "check the path"));
    if (size > longest_text)
        return fail(about_file("NC0008", file.string(), fmt::format("{} bytes are more than are read", size),
                               "cut the program in parts"));
    std::ifstream in(file, std::ios::binary);
    std::string text(size, '\0');
    in.read(text.data(), static_cast<std::streamsize>(size));
    if (!in) return fail(about_file("NC0001", file.string(), "cannot be read", "check the path and its permissions"));
    if (!is_gzip(text)) return read_program(text, file.string(), options);
    auto inside = inflated(text, longest_text);
    if (!inside) {
        inside.error().place.file = file.string();
        return fail(std::move(inside.error()));
    }
    text = std::move(*inside);
    return read_program(text, file.string(), options);
}

}  // namespace trunnion::nc
