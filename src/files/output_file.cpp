#include "trunnion/files/output_file.hpp"

#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <utility>

#include <fcntl.h>
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

std::filesystem::path folder_of(const std::filesystem::path& path) {
    return path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
}

/// Through this name a file without one gets one.
std::string name_of_descriptor(int descriptor) {
    return fmt::format("/proc/self/fd/{}", descriptor);
}

bool link_descriptor(int descriptor, const std::filesystem::path& path) {
    const std::string nameless = name_of_descriptor(descriptor);
    return ::linkat(AT_FDCWD, nameless.c_str(), AT_FDCWD, path.c_str(), AT_SYMLINK_FOLLOW) == 0;
}

/// While it lives no signal comes to this thread: whoever ends the program at once would leave a temporary name.
class SignalsHeld {
  public:
    SignalsHeld() {
        sigset_t all;
        ::sigfillset(&all);
        ::pthread_sigmask(SIG_BLOCK, &all, &before_);
    }
    ~SignalsHeld() { ::pthread_sigmask(SIG_SETMASK, &before_, nullptr); }
    SignalsHeld(const SignalsHeld&) = delete;
    SignalsHeld& operator=(const SignalsHeld&) = delete;

  private:
    sigset_t before_{};
};

/// What has no disk below it cannot be synchronised; that is no error.
bool on_disk(int descriptor) {
    return ::fsync(descriptor) == 0 || errno == EINVAL || errno == ENOTSUP;
}

/// The new name itself must survive a power cut. Where the folder cannot be opened for this, the file is whole all
/// the same.
void synchronise_folder(const std::filesystem::path& folder) {
    const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (descriptor < 0) return;
    ::fsync(descriptor);
    ::close(descriptor);
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
    out.open_descriptor();
    const int streamed = out.descriptor_ < 0 ? -1 : ::fcntl(out.descriptor_, F_DUPFD_CLOEXEC, 0);
    if (streamed >= 0 && path.extension() == ".gz") out.compressed_ = gzdopen(streamed, "wb4");
    if (streamed >= 0 && path.extension() != ".gz") out.plain_ = ::fdopen(streamed, "wb");
    if (out.plain_ || out.compressed_) return out;
    const auto trouble = file_trouble("FILE0201", "the file cannot be created", path);
    if (streamed >= 0) ::close(streamed);
    out.discard();
    return fail(trouble);
}

void OutputFile::open_descriptor() {
    constexpr mode_t by_umask = 0666;
    if (!in_place_ && ::access("/proc/self/fd", X_OK) == 0)
        descriptor_ = ::open(folder_of(path_).c_str(), O_TMPFILE | O_WRONLY | O_CLOEXEC, by_umask);
    nameless_ = descriptor_ >= 0;
    if (!nameless_) descriptor_ = ::open(temporary_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, by_umask);
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
    descriptor_ = std::exchange(other.descriptor_, -1);
    in_place_ = other.in_place_;
    nameless_ = other.nameless_;
    failed_ = other.failed_;
    return *this;
}

OutputFile::~OutputFile() {
    discard();
}

void OutputFile::discard() noexcept {
    if (descriptor_ < 0) return;
    if (plain_) std::fclose(std::exchange(plain_, nullptr));
    if (compressed_) gzclose(std::exchange(compressed_, nullptr));
    remove_temporary();
    close_descriptor();
}

void OutputFile::close_descriptor() noexcept {
    ::close(std::exchange(descriptor_, -1));
}

void OutputFile::remove_temporary() noexcept {
    if (!in_place_ && !nameless_) ::unlink(temporary_.c_str());
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

void OutputFile::give_name() {
    if (!nameless_) return;
    const auto link = [&] { return link_descriptor(descriptor_, temporary_); };
    bool linked = link();
    if (!linked && errno == EEXIST) linked = ::unlink(temporary_.c_str()) == 0 && link();  // of a killed program
    failed_ = !linked;
    nameless_ = !linked;
}

/// The bytes first, then the name: never a name without its bytes. A temporary name only where there is a file to
/// replace.
std::error_code OutputFile::take_place() {
    std::error_code error;
    if (in_place_) return error;
    failed_ = !on_disk(descriptor_);
    if (failed_) return error;
    const SignalsHeld held;
    if (nameless_ && link_descriptor(descriptor_, path_)) {
        nameless_ = false;
        ::unlink(temporary_.c_str());  // of a killed program
        synchronise_folder(folder_of(path_));
        return error;
    }
    give_name();
    if (failed_) return error;
    std::filesystem::rename(temporary_, path_, error);
    if (!error) synchronise_folder(folder_of(path_));
    return error;
}

Result<void> OutputFile::commit() {
    bool closed = true;
    if (plain_) closed = std::fclose(std::exchange(plain_, nullptr)) == 0;
    if (compressed_) closed = gzclose(std::exchange(compressed_, nullptr)) == Z_OK;
    std::error_code error;
    if (closed && !failed_) error = take_place();
    if (!closed || failed_ || error) {
        if (error) errno = error.value();
        const auto trouble = file_trouble("FILE0202", "the file cannot be written", path_);
        discard();
        return fail(trouble);
    }
    close_descriptor();
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
