#include "detail/gzip.hpp"

#include <algorithm>
#include <memory>

#include <fmt/format.h>
#include <zlib.h>

namespace trunnion::nc {

namespace {

constexpr int gzip_window = 15 + 16;  ///< the largest window, and a gzip head
constexpr std::size_t piece = std::size_t{1} << 20;

struct InflateEnd {
    void operator()(z_stream* stream) const { inflateEnd(stream); }
};

Diagnostic damaged(std::string_view why) {
    return {.code = "NC0009",
            .text = fmt::format("this gzip archive cannot be read: {}", why),
            .hint = "gzip -t says whether it is whole"};
}

}  // namespace

Result<std::string> inflated(std::string_view archive, std::size_t most) {
    z_stream stream{};
    if (inflateInit2(&stream, gzip_window) != Z_OK) return fail(damaged("no memory"));
    const std::unique_ptr<z_stream, InflateEnd> end(&stream);
    std::string text;
    std::size_t used = 0, length = 0;
    for (bool output_full = false; used < archive.size() || output_full;) {
        if (text.size() - length < piece) text.resize(std::max(2 * text.size(), piece));
        const std::size_t given = std::min(archive.size() - used, piece);
        stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(archive.data() + used));
        stream.avail_in = static_cast<uInt>(given);
        stream.next_out = reinterpret_cast<Bytef*>(text.data() + length);
        stream.avail_out = static_cast<uInt>(piece);
        const int state = inflate(&stream, Z_NO_FLUSH);
        used += given - stream.avail_in;
        length += piece - stream.avail_out;
        output_full = stream.avail_out == 0;
        if (length > most)
            return fail(Diagnostic{.code = "NC0008",
                                   .text = fmt::format("more than {} bytes come out of this archive", most),
                                   .hint = "cut the program in parts"});
        if (state == Z_STREAM_END) {
            // Another member may follow, or zeros that fill up a block of a tape.
            if (archive.substr(used).find_first_not_of('\0') == archive.npos) {
                text.resize(length);
                return text;
            }
            if (inflateReset(&stream) != Z_OK) return fail(damaged("no memory"));
        } else if (state == Z_BUF_ERROR) {
            break;
        } else if (state != Z_OK) {
            return fail(damaged(stream.msg ? stream.msg : "its data do not fit"));
        }
    }
    return fail(damaged("it is cut off"));
}

}  // namespace trunnion::nc
