#include "detail/run_ahead.hpp"

namespace trunnion::pipeline {

RunAhead::~RunAhead() {
    queue_.close();
    thread_.join();
}

NextElement RunAhead::next() {
    auto element = queue_.pop();
    if (element) return std::move(*element);
    if (thrown_) std::rethrow_exception(thrown_);
    return std::nullopt;
}

void RunAhead::work() noexcept {
    try {
        for (;;) {
            auto element = source_.next();
            const bool last = !element || !*element;
            if (!queue_.push(std::move(element)) || last) break;
        }
    } catch (...) {
        thrown_ = std::current_exception();
    }
    queue_.close();
}

}  // namespace trunnion::pipeline
