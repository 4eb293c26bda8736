#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <mutex>
#include <optional>

namespace trunnion::pipeline {

/// First in, first out, between one thread that pushes and one that pops; holds at most `capacity` elements. Whoever
/// gives up closes it, and neither side waits any longer.
template <class T>
class BoundedQueue {
  public:
    explicit BoundedQueue(std::size_t capacity) : capacity_(capacity) {}

    /// Waits for room; false when the queue is closed, the element is dropped then.
    bool push(T element) {
        std::unique_lock lock(mutex_);
        room_.wait(lock, [this] { return closed_ || elements_.size() < capacity_; });
        if (closed_) return false;
        elements_.push_back(std::move(element));
        filled_.notify_one();
        return true;
    }

    /// Waits for an element; what is in the queue still comes out after it was closed, then nothing.
    std::optional<T> pop() {
        std::unique_lock lock(mutex_);
        filled_.wait(lock, [this] { return closed_ || !elements_.empty(); });
        return take();
    }

    /// An element if there is one. Does not wait for one.
    std::optional<T> try_pop() {
        const std::lock_guard lock(mutex_);
        return take();
    }

    void close() {
        const std::lock_guard lock(mutex_);
        closed_ = true;
        room_.notify_one();
        filled_.notify_one();
    }

  private:
    std::optional<T> take() {
        if (elements_.empty()) return std::nullopt;
        std::optional<T> out(std::move(elements_.front()));
        elements_.pop_front();
        room_.notify_one();
        return out;
    }

    std::size_t capacity_;
    std::mutex mutex_;
    std::condition_variable room_, filled_;
    std::deque<T> elements_;
    bool closed_ = false;
};

}  // namespace trunnion::pipeline
