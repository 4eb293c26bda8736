#pragma once

#include <cstddef>
#include <cstdint>

namespace trunnion::nc {

/// Xorshift: the same numbers on every platform.
struct Random {
    std::uint64_t state;
    std::size_t below(std::size_t bound) {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        return static_cast<std::size_t>(state >> 16) % bound;
    }
};

}  // namespace trunnion::nc
