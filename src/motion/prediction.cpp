#include "trunnion/motion/prediction.hpp"

#include <array>
#include <string_view>

namespace trunnion::motion {

std::string to_string(Limit limit, const machine::Machine& machine) {
    constexpr std::array<std::string_view, 15> names{
        "feed",       "velocity",          "acceleration", "jerk",     "curvature", "curvature jump",  "transition",
        "block time", "block preparation", "look-ahead",   "axis set", "stop",      "linear velocity", "command rate",
        "planner"};
    std::string out;
    if (limit.axis >= 0) out = {machine.axes[static_cast<std::size_t>(limit.axis)].letter, ' '};
    return out += names[static_cast<std::size_t>(limit.kind)];
}

}  // namespace trunnion::motion
