#include "trunnion/nc/read.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "detail/dialects.hpp"
#include "detail/findings.hpp"
#include "detail/read_parts.hpp"
#include "detail/text_file.hpp"

namespace trunnion::nc {

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

namespace {

/// All that is left of a program, in one part.
Result<program::Program> read_whole(const ProgramText& text, std::optional<TextFile> file, std::string_view file_name,
                                    ReadOptions options) {
    constexpr std::size_t any = std::numeric_limits<std::size_t>::max();
    options.parts = {.to_rapid = any, .to_stop = any, .most = any};
    auto parts = ReadParts::open(text, std::move(file), file_name, options);
    if (!parts) return fail(std::move(parts.error()));
    program::Program program;
    if (auto read = (*parts)->next(program); !read) return fail(std::move(read.error()));
    return program;
}

}  // namespace

Result<program::Program> read_program(std::string_view text, std::string_view file_name, const ReadOptions& options) {
    return read_whole(text, {}, file_name, options);
}

Result<program::Program> read_program_file(const std::filesystem::path& file, const ReadOptions& options) {
    auto text = TextFile::open(file);
    if (!text) return fail(std::move(text.error()));
    const ProgramText mapped(text->text(), true);
    return read_whole(mapped, std::move(*text), file.string(), options);
}

Result<std::unique_ptr<program::ProgramParts>> open_program_file(const std::filesystem::path& file,
                                                                 const ReadOptions& options) {
    auto text = TextFile::open(file);
    if (!text) return fail(std::move(text.error()));
    const ProgramText mapped(text->text(), true);
    auto parts = ReadParts::open(mapped, std::move(*text), file.string(), options);
    if (!parts) return fail(std::move(parts.error()));
    return std::move(*parts);
}

}  // namespace trunnion::nc
