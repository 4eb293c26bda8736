#include "play_sink.hpp"

namespace trunnion::app {

std::size_t ClockSink::room() {
    if (!start_) return 0;
    const double passed_s = std::chrono::duration<double>(Clock::now() - *start_).count();
    const auto due = static_cast<std::uint64_t>(passed_s / period_s_) + 1;
    return due > periods_ ? due - periods_ : 0;
}

}  // namespace trunnion::app
