#pragma once

#include <cmath>

namespace trunnion::feed {

/// Two neighbouring intervals side by side: every row operation is done for both at once.
inline constexpr int lanes = 2;
using Pack = double __attribute__((vector_size(lanes * sizeof(double))));

inline Pack pack(double value) {
    return Pack{value, value};
}
inline Pack load(const double* from) {
    return Pack{from[0], from[1]};
}
inline Pack max(Pack a, Pack b) {
    return a > b ? a : b;
}
inline Pack min(Pack a, Pack b) {
    return a < b ? a : b;
}
inline Pack sqrt(Pack a) {
    return Pack{std::sqrt(a[0]), std::sqrt(a[1])};
}
inline double sum(Pack a) {
    return a[0] + a[1];
}
inline double max_lane(Pack a) {
    return a[0] > a[1] ? a[0] : a[1];
}

}  // namespace trunnion::feed
