#pragma once

#include "detail/loads.hpp"
#include "detail/pack.hpp"

namespace trunnion::feed::TRUNNION_VARIANT {

inline void store(Pack from, Group& to) {
    for (int i = 0; i < lanes; ++i) to[i] = from[i];
}
template <std::size_t n>
void store(const std::array<Pack, n>& from, std::array<Group, n>& to) {
    for (std::size_t i = 0; i < n; ++i) store(from[i], to[i]);
}

[[gnu::flatten]] void bound_loads(const Half& half, int group, const GroupLoads& inverse, GroupPolynomials& loads,
                                  GroupLoads& bounds) {
    const std::size_t at = static_cast<std::size_t>(group) * group_size;
    const PathSample &a = half.begin, &b = half.end;
    const double h = half.length;
    const auto row = [at](const std::array<double, coordinates>& from) { return load(&from[at]); };
    const Bernstein<Pack, 5> q1 = quintic(row(a.q1), row(a.q2), row(a.q3), row(b.q1), row(b.q2), row(b.q3), h);
    const Bernstein<Pack, 4> q2 = derivative(q1, h);
    const Bernstein<Pack, 3> q3 = derivative(q2, h);
    Bernstein<Pack, 7> acceleration{};
    add_product(1, q2, half.speed.x, acceleration);
    add_product(0.5, q1, half.speed.d, acceleration);
    Bernstein<Pack, 6> jerk{};
    add_product(1, q3, half.speed.x, jerk);
    add_product(1.5, q2, half.speed.d, jerk);
    add_product(0.5, q1, half.speed.e, jerk);
    const Bernstein<Pack, 6> velocity = elevated(q1);
    Pack most_velocity{}, most_jerk{}, most_acceleration{};
    for (int i = 0; i <= 6; ++i) {
        most_velocity = max(abs(velocity[i] * half.to_room[i]), most_velocity);
        most_jerk = max(abs(jerk[i] * half.to_room[i]), most_jerk);
    }
    for (int i = 0; i <= 7; ++i) most_acceleration = max(abs(acceleration[i]), most_acceleration);
    store(velocity, loads.velocity);
    store(jerk, loads.jerk);
    store(acceleration, loads.acceleration);
    store(most_velocity * load(inverse.velocity.data()), bounds.velocity);
    store(most_acceleration * load(inverse.acceleration.data()), bounds.acceleration);
    store(most_jerk * load(inverse.jerk.data()), bounds.jerk);
}

}  // namespace trunnion::feed::TRUNNION_VARIANT
