#include "detail/same_place.hpp"

#include <cmath>
#include <limits>

namespace trunnion::nc {

using program::OrientationLaw;
using program::Space;

bool same(double a, double b) {
    return a == b || (std::isnan(a) && std::isnan(b));
}

bool same_place(const program::Move& before, const program::Move& move) {
    constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
    const bool comparable = before.space == move.space && before.offset == move.offset &&
                            (before.tool == move.tool || move.space == Space::machine);
    for (Eigen::Index i = 0; i < 3; ++i)
        if (!std::isnan(move.position_mm[i]) && !(comparable && before.position_mm[i] == move.position_mm[i]))
            return false;
    if (move.law == OrientationLaw::vector) return before.law == move.law && comparable && before.axis == move.axis;
    for (std::size_t i = 0; i < move.rotary_rad.size(); ++i) {
        const double stood = before.law == OrientationLaw::rotary ? before.rotary_rad[i] : unknown;
        if (!std::isnan(move.rotary_rad[i]) && !same(stood, move.rotary_rad[i])) return false;
    }
    return true;
}

}  // namespace trunnion::nc
