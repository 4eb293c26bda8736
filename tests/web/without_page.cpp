// A program that was built where Node.js was missing: `report` says so, with its code, and leaves no file.
#include <filesystem>

#include <gtest/gtest.h>
#include <unistd.h>

#include "trunnion/report/page.hpp"

namespace trunnion::report {
namespace {

TEST(WithoutNodeJs, ReportSaysWhatIsMissingAndWritesNothing) {
    const auto there = page_is_there();
    ASSERT_FALSE(there.has_value());
    EXPECT_EQ(there.error().code, "REP0001");
    EXPECT_EQ(there.error().value, "Node.js was not there when it was built");
    EXPECT_NE(there.error().hint.find("scripts/install_dependencies.sh"), std::string::npos);

    const auto file = std::filesystem::temp_directory_path() / ("trunnion-without-page-" + std::to_string(getpid()));
    const auto written = write_page(file, {});
    ASSERT_FALSE(written.has_value());
    EXPECT_EQ(written.error().code, "REP0001");
    EXPECT_FALSE(std::filesystem::exists(file));
}

}  // namespace
}  // namespace trunnion::report
