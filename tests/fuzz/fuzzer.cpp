// One fuzzer: libFuzzer's entry for the reader named by TRUNNION_FUZZ_ENTRY.
#include <cstddef>
#include <cstdint>

#include "entries.hpp"

// NOLINTNEXTLINE(readability-identifier-naming): libFuzzer asks for this name
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
    static const trunnion::fuzz::Entry* const entry = trunnion::fuzz::entry_named(TRUNNION_FUZZ_ENTRY);
    entry->take({reinterpret_cast<const char*>(bytes), size});
    return 0;
}
