#include "trunnion/base/number.hpp"

#include <string_view>

#include <gtest/gtest.h>

namespace {

using namespace trunnion;

/// Number and what is left behind it.
void expect_taken(std::string_view text, Exponent exponent, double value, std::string_view rest) {
    const auto whole = text;
    const auto read = take_number(text, exponent);
    ASSERT_TRUE(read) << whole;
    EXPECT_EQ(*read, value) << whole;
    EXPECT_EQ(text, rest) << whole;
}

TEST(TakeNumber, ReadsTheWaysOfNcPrograms) {
    expect_taken("53.839Y1", Exponent::refused, 53.839, "Y1");
    expect_taken(".4884", Exponent::refused, 0.4884, "");
    expect_taken("1.", Exponent::refused, 1, "");
    expect_taken("+18.066 ", Exponent::refused, 18.066, " ");
    expect_taken("-0", Exponent::refused, 0, "");
    expect_taken("0.1", Exponent::refused, 0.1, "");
    expect_taken("1.2.3", Exponent::refused, 1.2, ".3");
}

TEST(TakeNumber, AnEIsAnAddressUnlessAllowed) {
    expect_taken("10E5", Exponent::refused, 10, "E5");
    expect_taken("10E5", Exponent::allowed, 1e6, "");
    expect_taken("2e-3x", Exponent::allowed, 2e-3, "x");
    expect_taken("2e", Exponent::allowed, 2, "e");
    expect_taken("2e+", Exponent::allowed, 2, "e+");
}

TEST(TakeNumber, RefusesWhatIsNone) {
    for (std::string_view text : {"", "+", "-.", "X", "inf", "nan", "-nan", "+-1", "1e999"}) {
        const auto whole = text;
        EXPECT_FALSE(take_number(text, Exponent::allowed)) << whole;
        EXPECT_EQ(text, whole);
    }
    expect_taken("0x10", Exponent::refused, 0, "x10");
}

}  // namespace
