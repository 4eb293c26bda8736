#pragma once

#include <cstdio>
#include <filesystem>
#include <memory>
#include <string_view>

#include "trunnion/base/result.hpp"

struct gzFile_s;

namespace trunnion::files {

/// A file that appears by rename when it is complete, or not at all. A name that ends in `.gz` is compressed.
/// Without commit() the half-written file is removed. What is there and no regular file (a device, a pipe) is written
/// to as it is. Errors: FILE0201 cannot be created, FILE0202 cannot be written.
class OutputFile {
  public:
    static Result<OutputFile> create(const std::filesystem::path& path);
    OutputFile(OutputFile&& other) noexcept;
    OutputFile& operator=(OutputFile&& other) noexcept;
    ~OutputFile();

    /// Failures are kept and reported by commit().
    void write(std::string_view bytes);
    /// Overwrites bytes at the start; not for compressed files.
    void rewrite_start(std::string_view bytes);
    Result<void> commit();

  private:
    OutputFile() = default;
    void discard() noexcept;
    void remove_temporary() noexcept;

    std::filesystem::path path_, temporary_;
    std::FILE* plain_ = nullptr;
    gzFile_s* compressed_ = nullptr;
    bool in_place_ = false, failed_ = false;
};

/// Whole content of a file, decompressed where it is gzip. Errors: FILE0203 cannot be read.
Result<std::string> read_whole_file(const std::filesystem::path& path);

}  // namespace trunnion::files
