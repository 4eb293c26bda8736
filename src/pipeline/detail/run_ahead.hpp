#pragma once

#include <exception>
#include <thread>

#include "detail/bounded_queue.hpp"
#include "detail/interval_source.hpp"

namespace trunnion::pipeline {

/// An IntervalSource on a thread of its own, a bounded number of elements ahead: the same elements in the same order,
/// the error at its place among them. What the source throws is thrown by next(). The source belongs to the thread
/// until this object is gone.
class RunAhead {
  public:
    explicit RunAhead(IntervalSource& source) : source_(source), thread_([this] { work(); }) {}
    ~RunAhead();
    RunAhead(const RunAhead&) = delete;
    RunAhead& operator=(const RunAhead&) = delete;

    NextElement next();

  private:
    void work() noexcept;

    static constexpr std::size_t capacity = 128;  // some 10 MB of intervals: room to smooth a run meanwhile

    IntervalSource& source_;
    BoundedQueue<NextElement> queue_{capacity};
    std::exception_ptr thrown_;  // written before the queue is closed
    std::thread thread_;
};

}  // namespace trunnion::pipeline
