#include "detail/program_text.hpp"

#include <cstdint>

#include <sys/mman.h>
#include <unistd.h>

namespace trunnion::nc {

namespace {

constexpr std::size_t stretch = std::size_t{1} << 16;  ///< looked through at once
constexpr std::size_t window = std::size_t{1} << 21;   ///< kept behind the line that is taken

}  // namespace

void ProgramText::look_ahead(std::size_t from, std::size_t end) {
    if (from > kept_from_ + window) {
        give_back(kept_from_, from);
        kept_from_ = from;
    }
    kept_from_ = std::min(kept_from_, from);
    const std::size_t to = std::min(text_.size(), std::max(end + 1, from + stretch));
    const std::size_t nul = text_.substr(0, to).find('\0', looked_up_to_);
    looked_up_to_ = std::max(looked_up_to_, to);
    if (nul == text_.npos) return;
    nul_ = nul;
    const std::size_t before = text_.substr(0, nul).rfind('\n');
    text_ = text_.substr(0, before == text_.npos ? 0 : before + 1);
}

void ProgramText::look_to_the_end() {
    while (looked_up_to_ < text_.size()) look_ahead(looked_up_to_, looked_up_to_);
}

/// Whole pages between two places.
void ProgramText::give_back(std::size_t from, std::size_t end) const {
    if (!is_mapped_) return;
    const auto page = static_cast<std::uintptr_t>(sysconf(_SC_PAGESIZE));
    const auto begin = reinterpret_cast<std::uintptr_t>(text_.data());
    const std::uintptr_t first = (begin + from + page - 1) / page * page, last = (begin + end) / page * page;
    if (first < last) madvise(reinterpret_cast<void*>(first), last - first, MADV_DONTNEED);
}

}  // namespace trunnion::nc
