#include "trunnion/files/output_file.hpp"

#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

#include <fmt/format.h>
#include <unistd.h>
#include <zlib.h>

namespace trunnion::files {

namespace {

Diagnostic file_trouble(std::string code, std::string_view what, const std::filesystem::path& path) {
    return {.code = std::move(code),
            .text = fmt::format("{}: {}", what, std::strerror(errno)),
            .place = {.file = path.string()}};
}

}  // namespace

Result<OutputFile> OutputFile::create(const std::filesystem::path& path) {
    OutputFile out;
    out.path_ = path;
    out.temporary_ = path;
    std::error_code unknown;
    out.in_place_ = std::filesystem::exists(path, unknown) && !std::filesystem::is_regular_file(path, unknown);
    if (!out.in_place_) out.temporary_ += fmt::format(".{}.part", ::getpid());
    errno = 0;
    if (path.extension() == ".gz")
        out.compressed_ = gzopen(out.temporary_.c_str(), "wb4");
    else
        out.plain_ = std::fopen(out.temporary_.c_str(), "wb");
    if (!out.plain_ && !out.compressed_) return fail(file_trouble("FILE0201", "the file cannot be created", path));
    return out;
}

OutputFile::OutputFile(OutputFile&& other) noexcept {
    *this = std::move(other);
}

OutputFile& OutputFile::operator=(OutputFile&& other) noexcept {
    if (this == &other) return *this;
    discard();
    path_ = std::move(other.path_);
    temporary_ = std::move(other.temporary_);
    plain_ = std::exchange(other.plain_, nullptr);
    compressed_ = std::exchange(other.compressed_, nullptr);
    in_place_ = other.in_place_;
    failed_ = other.failed_;
    return *this;
}

OutputFile::~OutputFile() {
    discard();
}

void OutputFile::discard() noexcept {
    if (!plain_ && !compressed_) return;
    if (plain_) std::fclose(std::exchange(plain_, nullptr));
    if (compressed_) gzclose(std::exchange(compressed_, nullptr));
    remove_temporary();
}

void OutputFile::remove_temporary() noexcept {
    std::error_code ignored;
    if (!in_place_) std::filesystem::remove(temporary_, ignored);
}

void OutputFile::write(std::string_view bytes) {
    if (bytes.empty()) return;
    const bool written = plain_ ? std::fwrite(bytes.data(), 1, bytes.size(), plain_) == bytes.size()
                                : gzwrite(compressed_, bytes.data(), static_cast<unsigned>(bytes.size())) > 0;
    failed_ = failed_ || !written;
}

void OutputFile::rewrite_start(std::string_view bytes) {
    if (std::fseek(plain_, 0, SEEK_SET) != 0) failed_ = true;
    write(bytes);
}

Result<void> OutputFile::commit() {
    bool closed = true;
    if (plain_) closed = std::fclose(std::exchange(plain_, nullptr)) == 0;
    if (compressed_) closed = gzclose(std::exchange(compressed_, nullptr)) == Z_OK;
    std::error_code error;
    if (closed && !failed_ && !in_place_) std::filesystem::rename(temporary_, path_, error);
    if (!closed || failed_ || error) {
        if (error) errno = error.value();
        const auto trouble = file_trouble("FILE0202", "the file cannot be written", path_);
        remove_temporary();
        return fail(trouble);
    }
    return {};
}

Result<std::string> read_whole_file(const std::filesystem::path& path) {
    std::error_code error;
    const bool folder = std::filesystem::is_directory(path, error);
    gzFile in = folder ? nullptr : gzopen(path.c_str(), "rb");
    if (folder) errno = EISDIR;
    if (!in) return fail(file_trouble("FILE0203", "the file cannot be read", path));
    std::string out;
    std::array<char, 1 << 16> buffer{};
    int got = 0;
    while ((got = gzread(in, buffer.data(), buffer.size())) > 0)
        out.append(buffer.data(), static_cast<std::size_t>(got));
    gzclose(in);
    if (got < 0) return fail(file_trouble("FILE0203", "the file cannot be read", path));
    return out;
}

}  // namespace trunnion::files
