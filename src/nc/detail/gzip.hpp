#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "trunnion/base/result.hpp"

namespace trunnion::nc {

/// Whether these are the first bytes of a gzip archive.
constexpr bool is_gzip(std::string_view bytes) {
    return bytes.starts_with("\x1f\x8b");
}

/// What a gzip archive holds, of one or of several members. Errors: NC0008 more than `most` bytes come out, however
/// small the archive is; NC0009 damaged or cut off. Cost: about 3 ns a byte; the memory of the text.
Result<std::string> inflated(std::string_view archive, std::size_t most);

}  // namespace trunnion::nc
