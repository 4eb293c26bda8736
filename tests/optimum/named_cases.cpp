// The planner's time on the smoothed path of the named cases against the optimum that another solver finds on the same
// path.
#include <fstream>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "trunnion/base/quantity.hpp"
#include "trunnion/feed/plan_stretch.hpp"
#include "trunnion/files/machine_file.hpp"
#include "trunnion/files/setup_file.hpp"
#include "trunnion/nc/read.hpp"
#include "trunnion/path/path_builder.hpp"
#include "trunnion/path/rotary_stands.hpp"
#include "trunnion/smoothing/smoothing.hpp"

#include "reference_optimum.hpp"

namespace trunnion {
namespace {

struct Case {
    std::string name;
    int nodes;
    double tip_mm, flank_mm;
    friend void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }
};

class NamedCase : public testing::TestWithParam<Case> {};

TEST_P(NamedCase, is_within_three_percent_of_the_optimum) {
    const Case& which = GetParam();
    const std::string folder = TRUNNION_SHARED_DIR "/data/cases/";
    const auto machine = files::read_machine_file(folder + "peer-trunnion.toml");
    const auto setup = files::read_setup_file(folder + "peer-setup.toml");
    if (!machine || !setup) GTEST_SKIP() << "no shared cases in " << folder;
    nc::ReadOptions reading;
    reading.machine = &*machine;
    const bool apt = which.flank_mm > 0 || which.name == "cone";
    const auto program = nc::read_program_file(folder + which.name + (apt ? ".cls" : ".ngc"), reading);
    ASSERT_TRUE(program) << to_string(program.error());

    const auto stands = path::choose_rotary_stands(*program, *machine, *setup);
    ASSERT_TRUE(stands) << to_string(stands.error());
    auto builder = path::PathBuilder::make(*program, *machine, *setup, *stands);
    ASSERT_TRUE(builder);
    path::Run run;
    ASSERT_TRUE(builder->next(run).value());
    smoothing::SmoothingOptions options;
    options.tip_tolerance_mm = which.tip_mm;
    options.flank_tolerance_mm = which.flank_mm;
    std::vector<path::ToolPath> stretches;
    smoothing::smooth(run, options, stretches);
    ASSERT_EQ(stretches.size(), 1u);
    const auto axis_path = path::AxisPath::make(stretches[0], *machine, stands->front().rotary_rad);
    ASSERT_TRUE(axis_path) << to_string(axis_path.error());

    const auto plan = feed::plan_stretch(*axis_path, {});
    ASSERT_TRUE(plan) << to_string(plan.error());
    const auto optimum = reference::reference_optimum(*axis_path, {.nodes = which.nodes});
    const double ratio = plan->profile.duration_s() / optimum.time_s;
    RecordProperty("planned_s", fmt::format("{:.4f}", plan->profile.duration_s()));
    RecordProperty("reference_s", fmt::format("{:.4f}", optimum.time_s));
    fmt::print("{}: planned {:.4f} s, reference {:.4f} s ({} rounds), ratio {:.4f}\n", which.name,
               plan->profile.duration_s(), optimum.time_s, optimum.rounds, ratio);
    EXPECT_LE(ratio, 1.03);
    EXPECT_GE(ratio, 0.98) << "the reference has not converged";
    EXPECT_GE(plan->profile.duration_s(), plan->jerk_free_bound_s * (1 - 1e-4));
}

INSTANTIATE_TEST_SUITE_P(Cases, NamedCase,
                         testing::Values(Case{"fillet", 2500, 0.01, 0}, Case{"corner", 2000, 0.01, 0},
                                         Case{"pyramid", 2000, 0.02, 0.02}, Case{"pocket", 1000, 3, 3},
                                         Case{"cone", 1500, 0.01, 0}),
                         [](const auto& which) { return which.param.name; });

}  // namespace
}  // namespace trunnion
