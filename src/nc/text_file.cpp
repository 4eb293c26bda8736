#include "detail/text_file.hpp"

#include <array>
#include <cerrno>
#include <string>
#include <system_error>

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include "detail/gzip.hpp"

namespace trunnion::nc {

namespace {

/// An open file.
class Descriptor {
  public:
    explicit Descriptor(int number) : number_(number) {}
    Descriptor(Descriptor&& other) noexcept : number_(std::exchange(other.number_, -1)) {}
    Descriptor& operator=(Descriptor&&) = delete;
    ~Descriptor() {
        if (number_ >= 0) close(number_);
    }
    int operator*() const { return number_; }

  private:
    int number_;
};

std::unexpected<Diagnostic> unreadable(const std::filesystem::path& file, std::string text, std::string hint) {
    return fail({.code = "NC0001", .text = std::move(text), .place = {.file = file.string()}, .hint = std::move(hint)});
}

std::string reason(std::string what) {
    return what + ": " + std::generic_category().message(errno);
}

/// A file in the folder for temporary files that has lost its name, so that it goes with this process.
Descriptor nameless_file() {
    std::error_code error;
    std::string name = (std::filesystem::temp_directory_path(error) / "trunnion-XXXXXX").string();
    Descriptor file(mkostemp(name.data(), O_CLOEXEC));
    if (*file >= 0) unlink(name.c_str());
    return file;
}

bool write_all(int descriptor, std::string_view bytes) {
    while (!bytes.empty()) {
        const ssize_t written = write(descriptor, bytes.data(), bytes.size());
        if (written < 0 && errno == EINTR) continue;
        if (written <= 0) return false;
        bytes.remove_prefix(static_cast<std::size_t>(written));
    }
    return true;
}

/// What a packed file holds, in a file without a name.
Result<Descriptor> unpacked(const Descriptor& packed, const std::filesystem::path& file, std::size_t& size) {
    Descriptor text = nameless_file();
    if (*text < 0) return unreadable(file, reason("no temporary file for what it holds"), "TMPDIR says where they lie");
    off_t at = 0;
    const auto source = [&](std::span<char> into) {
        const ssize_t count = pread(*packed, into.data(), into.size(), at);
        at += count > 0 ? count : 0;
        return count > 0 ? static_cast<std::size_t>(count) : 0;
    };
    const auto sink = [&](std::string_view bytes) {
        size += bytes.size();
        return write_all(*text, bytes);
    };
    auto whole = inflate_archive(source, TextFile::most_inflated, sink);
    if (!whole) {
        whole.error().place.file = file.string();
        return fail(std::move(whole.error()));
    }
    if (!*whole) return unreadable(file, reason("no room for what it holds"), "TMPDIR says where temporary files lie");
    return text;
}

}  // namespace

TextFile::~TextFile() {
    if (begin_) munmap(const_cast<char*>(begin_), size_);
}

Result<TextFile> TextFile::map(int descriptor, std::size_t size, const std::filesystem::path& file) {
    if (size == 0) return TextFile(nullptr, 0);
    void* const begin = mmap(nullptr, size, PROT_READ, MAP_PRIVATE, descriptor, 0);
    if (begin == MAP_FAILED) return unreadable(file, reason("cannot be read"), "check the path and its permissions");
    madvise(begin, size, MADV_SEQUENTIAL);
    return TextFile(static_cast<const char*>(begin), size);
}

Result<TextFile> TextFile::open(const std::filesystem::path& file) {
    const Descriptor descriptor(::open(file.c_str(), O_RDONLY | O_CLOEXEC));
    struct stat status{};
    if (*descriptor < 0 || fstat(*descriptor, &status) != 0)
        return unreadable(file, reason("cannot be read"), "check the path");
    if (!S_ISREG(status.st_mode)) return unreadable(file, "cannot be read: no regular file", "check the path");
    std::array<char, 2> head{};
    const ssize_t known = pread(*descriptor, head.data(), head.size(), 0);
    if (known < 0) return unreadable(file, reason("cannot be read"), "check the path and its permissions");
    auto size = static_cast<std::size_t>(status.st_size);
    if (!is_gzip({head.data(), static_cast<std::size_t>(known)})) return map(*descriptor, size, file);
    size = 0;
    auto text = unpacked(descriptor, file, size);
    if (!text) return fail(std::move(text.error()));
    return map(**text, size, file);
}

}  // namespace trunnion::nc
