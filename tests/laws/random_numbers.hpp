#pragma once

#include <cstdint>
#include <cstdlib>
#include <iostream>

/// Small portable generator (splitmix64): the same numbers everywhere for the same seed.
class RandomNumbers {
  public:
    explicit RandomNumbers(std::uint64_t seed) : state_(seed) {}

    double between(double low, double high) {
        state_ += 0x9e3779b97f4a7c15u;
        std::uint64_t z = state_;
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
        z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
        z ^= z >> 31;
        return low + (high - low) * static_cast<double>(z >> 11) * 0x1p-53;
    }

  private:
    std::uint64_t state_;
};

/// Of TRUNNION_SEED, or the usual one; said once a run.
inline std::uint64_t random_seed() {
    static const std::uint64_t value = [] {
        const char* given = std::getenv("TRUNNION_SEED");
        const std::uint64_t out = given ? std::strtoull(given, nullptr, 10) : 20240611u;
        std::cout << "seed " << out << " (set TRUNNION_SEED to replay another)\n";
        return out;
    }();
    return value;
}
