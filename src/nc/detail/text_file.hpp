#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string_view>
#include <utility>

#include "trunnion/base/result.hpp"

namespace trunnion::nc {

/// A file as text in memory: mapped, so that it takes no memory but for the pages that are looked at. A gzip archive is
/// inflated first, into a temporary file without a name that is mapped instead: programs jump back and forth.
class TextFile {
  public:
    /// At most so many bytes may come out of an archive.
    static constexpr std::uint64_t most_inflated = std::uint64_t{1} << 36;

    /// Errors: NC0001 not readable, or no room for what an archive holds; NC0008, NC0009 of inflate_archive().
    static Result<TextFile> open(const std::filesystem::path& file);

    TextFile(TextFile&& other) noexcept
        : begin_(std::exchange(other.begin_, nullptr)), size_(std::exchange(other.size_, 0)) {}
    TextFile& operator=(TextFile&&) = delete;
    ~TextFile();

    std::string_view text() const { return {begin_, size_}; }

  private:
    TextFile(const char* begin, std::size_t size) : begin_(begin), size_(size) {}
    static Result<TextFile> map(int descriptor, std::size_t size, const std::filesystem::path& file);

    const char* begin_;
    std::size_t size_;
};

}  // namespace trunnion::nc
