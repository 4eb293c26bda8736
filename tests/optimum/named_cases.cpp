// The planner's time on the smoothed path of the named cases against the optimum that another solver finds on the same
// path.
#include <fstream>
#include <iterator>
#include <string>

#include <gtest/gtest.h>

#include "trunnion/files/machine_file.hpp"
#include "trunnion/files/setup_file.hpp"

#include "measured.hpp"
#include "smoothed_path.hpp"

namespace trunnion::test {
namespace {

struct Case {
    std::string name, file;
    double tip_mm, flank_mm;
    friend void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }
};

class NamedCase : public testing::TestWithParam<Case> {};

TEST_P(NamedCase, is_at_the_optimum) {
    const Case& which = GetParam();
    const std::string folder = TRUNNION_SHARED_DIR "/data/cases/";
    const auto machine = files::read_machine_file(folder + "peer-trunnion.toml");
    const auto setup = files::read_setup_file(folder + "peer-setup.toml");
    if (!machine || !setup) GTEST_SKIP() << "no shared cases in " << folder;
    std::ifstream file(folder + which.file);
    const std::string text(std::istreambuf_iterator<char>(file), {});
    smoothing::SmoothingOptions options;
    options.tip_tolerance_mm = which.tip_mm;
    options.flank_tolerance_mm = which.flank_mm;
    const SmoothedPath path(*machine, *setup, text, options);
    const Measured measured = measure(which.name, path.axis_path(), 3200);
    print_heading();
    print(measured);
    expect_at_the_optimum(measured);
}

INSTANTIATE_TEST_SUITE_P(Cases, NamedCase,
                         testing::Values(Case{"fillet", "fillet.ngc", 0.01, 0}, Case{"corner", "corner.ngc", 0.01, 0},
                                         Case{"pyramid", "pyramid.cls", 0.02, 0.02}, Case{"pocket", "pocket.cls", 3, 3},
                                         Case{"cone", "cone.cls", 0.01, 0}),
                         [](const auto& which) { return which.param.name; });

}  // namespace
}  // namespace trunnion::test
