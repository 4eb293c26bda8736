#pragma once

#include <string>

#include "trunnion/feed/plan_stretch.hpp"

namespace trunnion::test {

/// What the planner makes of one path, beside the optimum that another solver finds.
struct Measured {
    std::string name;
    std::size_t intervals = 0;
    double reference_s = 0, reference_coarse_s = 0;
    double whole_s = 0, whole_calm_s = 0;    ///< one window; smoothness weight 0 and 0.001
    double stream_s = 0, stream_calm_s = 0;  ///< windows of 300
    double hurried_s = 0, jerk_free_s = 0;   ///< one window with a thousand times the jerk, and the bound without jerk
    int windows = 0, fallbacks = 0;          ///< of these plans but the hurried one
    int hurried_fallbacks = 0;
    double of_reference() const { return whole_s / reference_s; }
    double of_whole() const { return stream_s / whole_s; }
    double of_calm_whole() const { return stream_calm_s / whole_calm_s; }
    double of_calm() const { return whole_calm_s / whole_s; }
    double of_jerk_free() const { return hurried_s / jerk_free_s; }
};

Measured measure(std::string name, const path::AxisPath& path, int reference_nodes);

/// One line of a table; the heading goes above.
void print_heading();
void print(const Measured& measured);

/// Fails the test where a bar is not reached.
void expect_at_the_optimum(const Measured& measured);

}  // namespace trunnion::test
