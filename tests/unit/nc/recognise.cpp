#include <gtest/gtest.h>

#include "reading.hpp"

namespace trunnion::nc {
namespace {

struct Case {
    std::string_view text;
    Dialect dialect;
};

TEST(Recognise, ByContent) {
    const Case cases[] = {
        {"$$ made by hand\nGOTO/1,2,3\n", Dialect::apt},
        {"partno multax test\n", Dialect::apt},
        {"GOTO  /   1, 2, 3\n", Dialect::apt},
        {"\n\n  TOOL PATH/A,TOOL,B\n", Dialect::apt},
        {"1.5,2,3\n", Dialect::apt},
        {"-1 2e-05 3 0 0 1\n", Dialect::apt},
        {"%\nG0 X1\n", Dialect::rs274},
        {"(comment)\n", Dialect::rs274},
        {"g0x1\n", Dialect::rs274},
        {"/ N10 G0\n", Dialect::rs274},
        {"  X  -1.5\n", Dialect::rs274},
    };
    for (const Case& c : cases) {
        const auto dialect = recognise(c.text);
        ASSERT_TRUE(dialect) << c.text;
        EXPECT_EQ(*dialect, c.dialect) << c.text;
    }
}

TEST(Recognise, RefusesWhatIsNeither) {
    for (const std::string_view text : {"Information listing\n", "* comment\nG0\n", "1,2\n", "1 2 3 4\n"}) {
        const auto dialect = recognise(text);
        ASSERT_FALSE(dialect) << text;
        EXPECT_EQ(dialect.error().code, "NC0004");
        EXPECT_EQ(dialect.error().place.line, 1);
    }
    for (const std::string_view text : {"", " \n\t\r\n"}) EXPECT_EQ(recognise(text).error().code, "NC0002");
}

TEST(Recognise, Names) {
    EXPECT_EQ(dialect_named("apt"), Dialect::apt);
    EXPECT_EQ(dialect_named("rs274"), Dialect::rs274);
    EXPECT_EQ(dialect_named("heidenhain"), Dialect::heidenhain);
    EXPECT_EQ(dialect_named("fanuc"), Dialect::fanuc);
    EXPECT_FALSE(dialect_named("okuma"));
    EXPECT_EQ(name_of(Dialect::rs274), "rs274");
}

TEST(Recognise, OptionOverrules) {
    ReadOptions options;
    options.dialect = Dialect::rs274;
    const auto program = read_ac(
        "\xEF\xBB\xBF"
        "M64\nG21 G0 X0 Y0 Z0\nG1 X1 F60\n",
        options);
    ASSERT_TRUE(program) << said(program);
    EXPECT_EQ(program->dialect, "rs274");
    options.dialect = Dialect::apt;
    EXPECT_EQ(read_ac("G0 X0\n", options).error().code, "NC0204");
}

}  // namespace
}  // namespace trunnion::nc
