#include "trunnion/base/diagnostic.hpp"

#include <gtest/gtest.h>

namespace {

using namespace trunnion;

TEST(Diagnostic, IsOneLineWithAllThatIsKnown) {
    Diagnostic d{.code = "NC0101", .text = "unknown word"};
    EXPECT_EQ(to_string(d), "error NC0101: unknown word");
    d.place = {.file = "part.ngc", .line = 7, .column = 3};
    d.severity = Severity::warning;
    d.value = "12 mm";
    d.limit = "10 mm";
    d.count = 4;
    d.hint = "leave it out";
    EXPECT_EQ(to_string(d), "part.ngc:7:3: warning NC0101: unknown word (12 mm, limit 10 mm) [4 times]; leave it out");
}

TEST(Diagnostic, MayPointOntoThePath) {
    Diagnostic d{.code = "FEED0007", .severity = Severity::note, .text = "slow"};
    d.place.path_length_mm = 12.5;
    EXPECT_EQ(to_string(d), "at 12.500 mm of the path: note FEED0007: slow");
}

}  // namespace
