#include "detail/gzip.hpp"

#include <memory>
#include <vector>

#include <fmt/format.h>
#include <zlib.h>

namespace trunnion::nc {

namespace {

constexpr int gzip_window = 15 + 16;  ///< the largest window, and a gzip head
constexpr std::size_t piece = std::size_t{1} << 18;

struct InflateEnd {
    void operator()(z_stream* stream) const { inflateEnd(stream); }
};

Diagnostic damaged(std::string_view why) {
    return {.code = "NC0009",
            .text = fmt::format("this gzip archive cannot be read: {}", why),
            .hint = "gzip -t says whether it is whole"};
}

/// Bytes of the archive that inflate() has not taken yet.
class Packed {
  public:
    explicit Packed(const ByteSource& source) : source_(source), bytes_(piece) {}

    /// Makes the next ones known to the stream; false at the end.
    bool fill(z_stream& stream) {
        if (stream.avail_in > 0) return true;
        stream.next_in = reinterpret_cast<Bytef*>(bytes_.data());
        stream.avail_in = static_cast<uInt>(source_(bytes_));
        return stream.avail_in > 0;
    }
    /// Passes over zeros, which fill up a block of a tape; false at the end.
    bool skip_zeros(z_stream& stream) {
        while (fill(stream)) {
            if (*stream.next_in != 0) return true;
            ++stream.next_in;
            --stream.avail_in;
        }
        return false;
    }

  private:
    const ByteSource& source_;
    std::vector<char> bytes_;
};

}  // namespace

Result<bool> inflate_archive(const ByteSource& archive, std::uint64_t most, const ByteSink& sink) {
    z_stream stream{};
    if (inflateInit2(&stream, gzip_window) != Z_OK) return fail(damaged("no memory"));
    const std::unique_ptr<z_stream, InflateEnd> end(&stream);
    Packed packed(archive);
    std::vector<char> out(piece);
    std::uint64_t length = 0;
    for (bool output_full = false; output_full || packed.fill(stream);) {
        stream.next_out = reinterpret_cast<Bytef*>(out.data());
        stream.avail_out = static_cast<uInt>(piece);
        const int state = inflate(&stream, Z_NO_FLUSH);
        output_full = stream.avail_out == 0;
        const std::size_t come_out = piece - stream.avail_out;
        length += come_out;
        if (length > most)
            return fail(Diagnostic{.code = "NC0008",
                                   .text = fmt::format("more than {} bytes come out of this archive", most),
                                   .hint = "cut the program in parts"});
        if (!sink({out.data(), come_out})) return false;
        if (state == Z_STREAM_END) {
            if (!packed.skip_zeros(stream)) return true;
            if (inflateReset(&stream) != Z_OK) return fail(damaged("no memory"));
            output_full = false;
        } else if (state == Z_BUF_ERROR) {
            output_full = false;  // all that was given has come out: the next bytes, or it is cut off
        } else if (state != Z_OK) {
            return fail(damaged(stream.msg ? stream.msg : "its data do not fit"));
        }
    }
    return fail(damaged("it is cut off"));
}

}  // namespace trunnion::nc
