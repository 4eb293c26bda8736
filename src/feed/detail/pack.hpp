#pragma once

#include <cmath>

/// The inner loops are compiled once for every kind of processor, in a namespace of its own: TRUNNION_VARIANT is set by
/// the source file that includes this.
#ifndef TRUNNION_VARIANT
#error "include this from a source file that names the variant"
#endif

namespace trunnion::feed::TRUNNION_VARIANT {

/// Neighbouring intervals (or coordinates) side by side: every operation is done for all of them at once. Always four,
/// so that a processor with wider registers computes the same bits.
inline constexpr int lanes = 4;
using Pack = double __attribute__((vector_size(lanes * sizeof(double)), aligned(lanes * sizeof(double))));

inline Pack load(const double* from) {
    return Pack{from[0], from[1], from[2], from[3]};
}
inline Pack max(Pack a, Pack b) {
    return a > b ? a : b;
}
inline Pack max(Pack a, double b) {
    return max(a, Pack{} + b);
}
inline Pack min(Pack a, Pack b) {
    return a < b ? a : b;
}
inline Pack abs(Pack a) {
    return a < 0 ? -a : a;
}
inline Pack sqrt(Pack a) {
    return Pack{std::sqrt(a[0]), std::sqrt(a[1]), std::sqrt(a[2]), std::sqrt(a[3])};
}
inline double sum(Pack a) {
    return (a[0] + a[1]) + (a[2] + a[3]);
}
inline double max_lane(Pack a) {
    const double low = a[0] > a[1] ? a[0] : a[1], high = a[2] > a[3] ? a[2] : a[3];
    return low > high ? low : high;
}

}  // namespace trunnion::feed::TRUNNION_VARIANT
