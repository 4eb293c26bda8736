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

bool goes(const Eigen::Vector3d& from_mm, const Eigen::Vector3d& to_mm) {
    constexpr double still_mm = 1e-7;
    for (Eigen::Index i = 0; i < 3; ++i)
        if (!std::isnan(to_mm[i]) && !(std::abs(to_mm[i] - from_mm[i]) <= still_mm)) return true;
    return false;
}

void append(program::Program& program, const program::Move& move) {
    const bool straight = move.arc == program::no_arc && move.curve_part == program::no_curve_part;
    if (straight && !program.moves.empty() && same_place(program.moves.back(), move)) return;
    program.moves.push_back(move);
}

}  // namespace trunnion::nc
