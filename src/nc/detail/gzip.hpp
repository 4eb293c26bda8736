#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string_view>

#include "trunnion/base/result.hpp"

namespace trunnion::nc {

/// Whether these are the first bytes of a gzip archive.
constexpr bool is_gzip(std::string_view bytes) {
    return bytes.starts_with("\x1f\x8b");
}

/// Fills in the bytes that follow, and says how many; 0 at the end.
using ByteSource = std::function<std::size_t(std::span<char>)>;
/// Takes bytes; false where it cannot keep them.
using ByteSink = std::function<bool(std::string_view)>;

/// What a gzip archive holds, of one or of several members, in pieces of up to 256 KB. Says whether `sink` took all.
/// Errors: NC0008 more than `most` bytes come out, however small the archive is; NC0009 damaged or cut off. Cost: about
/// 3 ns a byte; half a MB of memory.
Result<bool> inflate_archive(const ByteSource& archive, std::uint64_t most, const ByteSink& sink);

}  // namespace trunnion::nc
