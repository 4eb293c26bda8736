#pragma once

#include <array>
#include <atomic>
#include <bit>
#include <cstddef>
#include <memory>

#include "trunnion/motion/feed_profile.hpp"

namespace trunnion::interpolation {

/// The feed profile of one pass while it is being planned: one thread adds pieces, another one reads them, without a
/// lock. What was added never changes, and never moves.
class SurfaceProfile {
  public:
    SurfaceProfile() = default;
    /// A profile that is complete.
    explicit SurfaceProfile(const motion::FeedProfile& profile) {
        for (const motion::ProfilePiece& piece : profile.pieces) add(piece);
        finish();
    }

    /// The planner's side; allocates now and then.
    void add(const motion::ProfilePiece& piece) {
        const std::size_t count = count_.load(std::memory_order_relaxed);
        const Place at(count);
        if (!blocks_[at.block]) blocks_[at.block] = std::make_unique<motion::ProfilePiece[]>(at.block_size);
        blocks_[at.block][at.index] = piece;
        count_.store(count + 1, std::memory_order_release);
    }
    void finish() noexcept { finished_.store(true, std::memory_order_release); }

    /// The reader's side: pieces that are there, and whether more will come. Allocates nothing.
    std::size_t size() const noexcept { return count_.load(std::memory_order_acquire); }
    bool finished() const noexcept { return finished_.load(std::memory_order_acquire); }
    const motion::ProfilePiece& operator[](std::size_t i) const noexcept {
        const Place at(i);
        return blocks_[at.block][at.index];
    }

    /// Until when motion is planned, s from its start.
    double planned_s() const noexcept {
        const std::size_t count = size();
        return count == 0 ? 0 : (*this)[count - 1].begin_s + (*this)[count - 1].duration_s;
    }

  private:
    static constexpr std::size_t first_block = 64;

    /// Every block holds as many pieces as all before it together, the first two as many as each other.
    struct Place {
        std::size_t block, block_size, index;
        explicit Place(std::size_t i) noexcept
            : block(static_cast<std::size_t>(std::bit_width(i / first_block))),
              block_size(block == 0 ? first_block : first_block << (block - 1)),
              index(block == 0 ? i : i - block_size) {}
    };

    std::array<std::unique_ptr<motion::ProfilePiece[]>, 48> blocks_;
    std::atomic<std::size_t> count_{0};
    std::atomic<bool> finished_{false};
};

}  // namespace trunnion::interpolation
