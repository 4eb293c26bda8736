#pragma once

#include <atomic>
#include <cstddef>
#include <memory>

#include "trunnion/motion/feed_profile.hpp"

namespace trunnion::interpolation {

/// The feed profile of one pass while it is being planned: one thread adds pieces, another one reads them, without a
/// lock. What was added never changes.
class SurfaceProfile {
  public:
    /// Room for `capacity` pieces; allocates here alone.
    explicit SurfaceProfile(std::size_t capacity)
        : pieces_(std::make_unique<motion::ProfilePiece[]>(capacity)), capacity_(capacity) {}
    /// A profile that is complete.
    explicit SurfaceProfile(const motion::FeedProfile& profile) : SurfaceProfile(profile.pieces.size()) {
        for (const motion::ProfilePiece& piece : profile.pieces) add(piece);
        finish();
    }

    /// The planner's side. False: there is no room left.
    bool add(const motion::ProfilePiece& piece) noexcept {
        const std::size_t count = count_.load(std::memory_order_relaxed);
        if (count == capacity_) return false;
        pieces_[count] = piece;
        count_.store(count + 1, std::memory_order_release);
        return true;
    }
    void finish() noexcept { finished_.store(true, std::memory_order_release); }

    /// The reader's side: pieces that are there, and whether more will come.
    std::size_t size() const noexcept { return count_.load(std::memory_order_acquire); }
    bool finished() const noexcept { return finished_.load(std::memory_order_acquire); }
    const motion::ProfilePiece& operator[](std::size_t i) const noexcept { return pieces_[i]; }

    /// Until when motion is planned, s from its start.
    double planned_s() const noexcept {
        const std::size_t count = size();
        return count == 0 ? 0 : pieces_[count - 1].begin_s + pieces_[count - 1].duration_s;
    }

  private:
    std::unique_ptr<motion::ProfilePiece[]> pieces_;
    std::size_t capacity_;
    std::atomic<std::size_t> count_{0};
    std::atomic<bool> finished_{false};
};

}  // namespace trunnion::interpolation
