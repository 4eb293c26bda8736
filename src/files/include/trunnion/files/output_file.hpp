#pragma once

#include <cstdio>
#include <filesystem>
#include <memory>
#include <string_view>
#include <system_error>

#include "trunnion/base/result.hpp"

struct gzFile_s;

namespace trunnion::files {

/// A file that appears when it is complete and on the disk, or not at all; what it replaces is replaced by rename. A
/// name that ends in `.gz` is compressed. What is there and no regular file (a device, a pipe) is written to as it is.
///
/// Until commit() the bytes are in a file without a name, so that nothing is left of them when the program is killed
/// or the power fails; what had the name before stays whole. Where the file system has no such files, they are in
/// `NAME.PID.part`, which is removed unless the program is killed.
///
/// Errors: FILE0201 cannot be created, FILE0202 cannot be written.
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
    void open_descriptor();
    void discard() noexcept;
    void remove_temporary() noexcept;
    void give_name();
    std::error_code take_place();
    void close_descriptor() noexcept;

    std::filesystem::path path_, temporary_;
    std::FILE* plain_ = nullptr;
    gzFile_s* compressed_ = nullptr;
    int descriptor_ = -1;  ///< of the same file as the stream, which may be closed before
    bool in_place_ = false, nameless_ = false, failed_ = false;
};

/// Whole content of a file, decompressed where it is gzip. Errors: FILE0203 cannot be read.
Result<std::string> read_whole_file(const std::filesystem::path& path);

}  // namespace trunnion::files
