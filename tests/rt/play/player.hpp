#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <plan_buffer.h>

#include "trunnion/base/quantity.hpp"
#include "trunnion/files/shipped_machines.hpp"
#include "trunnion/nc/read.hpp"
#include "trunnion/pipeline/live_motion.hpp"

namespace trunnion::test {

inline constexpr double period_s = 1e-3;

/// A program text that comes as one part.
class OnePart final : public program::ProgramParts {
  public:
    OnePart(const std::string& text, const machine::Machine& machine)
        : program_(nc::read_program(text, "test.ngc", {.machine = &machine}).value()) {}
    Result<bool> next(program::Program& part) override {
        if (given_) return false;
        part = program_;
        return given_ = true;
    }

  private:
    program::Program program_;
    bool given_ = false;
};

inline machine::Machine peer_machine() {
    const std::filesystem::path shipped = std::string(TRUNNION_SOURCE_DIR) + "/data/machines";
    return files::find_machine("xyzac-trt", {&shipped, 1}).value();
}

/// Corners of five axes with rapids and dwells between them, told by a seed.
inline std::string random_program(std::uint64_t seed, int passes) {
    std::uint64_t state = seed * 0x9e3779b97f4a7c15ull + 1;
    const auto random = [&state](double low, double high) {
        state = state * 6364136223846793005ull + 1442695040888963407ull;
        return low + (high - low) * static_cast<double>(state >> 11) / 9007199254740992.0;
    };
    std::string out = "G21 G90 G94 G64\nG0 X0 Y0 Z60 A0 C0\n";
    const auto move = [&](double f) {
        out += "G1 X" + std::to_string(random(-30, 30)) + " Y" + std::to_string(random(-30, 30)) + " Z" +
               std::to_string(random(40, 60)) + " A" + std::to_string(random(5, 40)) + " C" +
               std::to_string(random(-60, 60)) + " F" + std::to_string(f) + "\n";
    };
    for (int k = 0; k < passes; ++k) {
        const double feed = random(1000, 8000);
        for (int corner = 0; corner < 4; ++corner) move(feed);
        out += "G4 P0.05\nG0 Z70\n";
    }
    return out + "M2\n";
}

/// Holds rows against the machine's limits by their differences, which a jump of place, speed or acceleration breaks by
/// far. Jerk is checked by the third difference: at the change of a plan it may jump between its limits, no more.
class RowCheck {
  public:
    explicit RowCheck(const machine::Machine& machine) : machine_(&machine) {}
    void note(const trunnion_row& row) {
        if (rows_ == 0) last_.fill(row);
        ++rows_;
        std::rotate(last_.begin(), last_.begin() + 1, last_.end());
        last_[3] = row;
        for (int i = 0; i < machine_->axis_count; ++i) {
            const double unit = machine_->axes[i].rotary ? degree : 1;
            const auto at = [&](int k) { return last_[static_cast<std::size_t>(k)].position[i] * unit; };
            const machine::AxisLimits &feed = machine_->axes[i].feed, &rapid = machine_->axes[i].rapid;
            const auto ratio = [&](double difference, int order, double limit) {
                worst_ = std::max(worst_, std::abs(difference) / std::pow(period_s, order) / limit);
            };
            ratio(at(3) - at(2), 1, std::max(feed.velocity, rapid.velocity));
            ratio(at(3) - 2 * at(2) + at(1), 2, std::max(feed.acceleration, rapid.acceleration));
            ratio(at(3) - 3 * at(2) + 3 * at(1) - at(0), 3, std::max(feed.jerk, rapid.jerk));
        }
    }
    /// As the axes stand behind the last row.
    void stand() {
        const trunnion_row row = last_[3];
        for (int k = 0; k < 3; ++k) note(row);
    }
    double worst() const { return worst_; }
    std::uint64_t rows() const { return rows_; }

  private:
    const machine::Machine* machine_;
    std::array<trunnion_row, 4> last_{};
    std::uint64_t rows_ = 0;
    double worst_ = 0;
};

}  // namespace trunnion::test
