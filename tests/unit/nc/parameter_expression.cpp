#include "detail/parameter_expression.hpp"

#include <span>
#include <string>
#include <string_view>

#include <gtest/gtest.h>

namespace trunnion::nc {
namespace {

/// #5420 is 12, #5399 is not known.
class Control : public ControlParameters {
  public:
    Answer read(const ParameterReference& parameter, ParameterValue& value) const override {
        if (parameter.number == 5420) value = 12;
        return parameter.number == 5420   ? Answer::known
               : parameter.number == 5399 ? Answer::unknown
                                          : Answer::not_its_own;
    }
};

struct Outcome {
    ParameterValue value;
    std::string code;
    int column = 0;
    std::string rest;
};

/// #1 is 2, #2 is 1, #100 is −3.5, #<a> is 7, #<_b c> is 8.
Outcome worked_out(std::string_view text, const ParameterLanguage& language) {
    Findings findings("test");
    Parameters parameters(language);
    parameters.set({1}, 2);
    parameters.set({2}, 1);
    parameters.set({100}, -3.5);
    parameters.set({.name = "a"}, 7);
    parameters.set({.name = "_bc"}, 8);
    const Control control;
    ParameterExpressions expressions(language, parameters, control, findings);
    LineCursor cursor{text, text, 1};
    Outcome outcome;
    if (!expressions.value(cursor, outcome.value)) {
        const Diagnostic error = findings.take_error();
        return {{}, error.code, error.place.column, {}};
    }
    outcome.rest = cursor.rest;
    return outcome;
}

struct Worked {
    std::string_view text;
    double value;
};

void expect_worked(const ParameterLanguage& language, std::span<const Worked> all) {
    for (const Worked& wanted : all) {
        const Outcome outcome = worked_out(wanted.text, language);
        ASSERT_TRUE(outcome.value) << wanted.text << " " << outcome.code;
        EXPECT_NEAR(*outcome.value, wanted.value, 1e-12) << wanted.text;
        EXPECT_EQ(outcome.rest, "") << wanted.text;
    }
}

TEST(ParameterExpressions, OfBothLanguages) {
    const Worked all[] = {
        {"1.5", 1.5},
        {"-.5", -.5},
        {"1 2 . 5", 12.5},
        {"#1", 2},
        {"##2", 2},
        {"#[1 + #2]", 1},
        {"-#100", 3.5},
        {"- -#1", 2},
        {"[1+2*3]", 7},
        {"[[1+2]*3]", 9},
        {"[8/4/2]", 1},
        {"[1-2-3]", -4},
        {"[-7+2]", -5},
        {"sin[30]", .5},
        {"COS[60]", .5},
        {"TAN[45]", 1},
        {"ASIN[.5]", 30},
        {"ACOS[.5]", 60},
        {"ATAN[1]/[1]", 45},
        {"ATAN[1]/[-1]", 135},
        {"SQRT[16]", 4},
        {"ABS[-2]", 2},
        {"ROUND[2.5]", 3},
        {"ROUND[-2.5]", -3},
        {"FIX[2.9]", 2},
        {"FUP[2.1]", 3},
        {"LN[EXP[2]]", 2},
        {"[7 MOD 3]", 1},
        {"[#1 EQ 2]", 1},
        {"[#1EQ#2]", 0},
        {"[#1 NE 2]", 0},
        {"[2 GT 1]", 1},
        {"[2 GE 2]", 1},
        {"[2 LT 1]", 0},
        {"[2 LE 1]", 0},
        {"[[1 EQ 1] AND [2 EQ 2]]", 1},
        {"[[1 EQ 1] OR [2 EQ 3]]", 1},
        {"[[1 EQ 1] XOR [2 EQ 2]]", 0},
        {"#5420", 12},
    };
    expect_worked(linuxcnc_parameters, all);
    expect_worked(fanuc_parameters, all);
}

TEST(ParameterExpressions, OfLinuxcnc) {
    const Worked all[] = {
        {"[2**3**2]", 64},
        {"[-2**2]", 4},
        {"[2*2**3]", 16},
        {"[-7 MOD 3]", 2},
        {"[7 MOD -3]", 1},
        {"FIX[-2.5]", -3},
        {"FUP[-2.5]", -2},
        {"ATAN[-1]/[-1]", -135},
        {"#30", 0},
        {"#4000", 0},
        {"#<a>", 7},
        {"#<A >", 7},
        {"#<_B C>", 8},
        {"EXISTS[#<a>]", 1},
        {"EXISTS[#<x>]", 0},
        {"[1 EQ 1.00002]", 1},
        {"[1 EQ 1.001]", 0},
        {"[5 AND 2 OR 0]", 1},
        {"[1+2 EQ 3 AND 0]", 0},
    };
    expect_worked(linuxcnc_parameters, all);
}

TEST(ParameterExpressions, OfFanuc) {
    const Worked all[] = {
        {"[6 AND 3]", 2},  {"[6 OR 3]", 7},        {"[6 XOR 3]", 5},         {"[-7 MOD 3]", -1}, {"FIX[-2.5]", -2},
        {"FUP[-2.5]", -3}, {"ATAN[-1]/[-1]", 225}, {"ATAN[1,1]", 45},        {"ATAN[1]", 45},    {"SQR[4]", 2},
        {"RND[1.4]", 1},   {"POW[2,3]", 8},        {"[#9 EQ #0]", 1},        {"[#9 EQ 0]", 0},   {"[#1 NE #0]", 1},
        {"[#9+1]", 1},     {"[1 EQ 1.00002]", 0},  {"[1 + 2 AND 3 + 1]", 4},
    };
    expect_worked(fanuc_parameters, all);
    EXPECT_FALSE(worked_out("#9", fanuc_parameters).value) << "vacant";
    EXPECT_FALSE(worked_out("-[#0]", fanuc_parameters).value);
    EXPECT_EQ(worked_out("-[#0]", fanuc_parameters).code, "");
    ParameterLanguage steps = fanuc_parameters;
    steps.rounding_step = 0.001;
    EXPECT_NEAR(*worked_out("ROUND[1.23456]", steps).value, 1.235, 1e-12);
}

TEST(ParameterExpressions, Refusals) {
    struct Refused {
        std::string_view text, code;
        int column;
    };
    const std::string brackets(80, '['), signs(80, '-');
    const std::string deep = "1 " + brackets;
    const Refused both[] = {
        {"[1+2", "NC0320", 5},      {"[", "NC0320", 2},        {"[1 2 3 # 4]", "NC0320", 8}, {"[1 FOO 2]", "NC0321", 4},
        {"FOO[1]", "NC0321", 1},    {"BIN[#1]", "NC0321", 1},  {"#1.5", "NC0322", 1},        {"#-1", "NC0320", 2},
        {"#100000", "NC0322", 1},   {"#[1/0]", "NC0325", 4},   {"#5399", "NC0324", 1},       {"[1/0]", "NC0325", 3},
        {"[1 MOD 0]", "NC0325", 4}, {"SQRT[-1]", "NC0326", 1}, {"ASIN[1.5]", "NC0326", 1},   {"LN[0]", "NC0326", 1},
        {"EXP[1000]", "NC0327", 1}, {brackets, "NC0328", 66},  {signs, "NC0328", 65},        {"1..2", "NC0201", 1},
        {"COS 3", "NC0320", 5},
    };
    for (const ParameterLanguage& language : {linuxcnc_parameters, fanuc_parameters})
        for (const Refused& r : both) {
            const Outcome outcome = worked_out(r.text, language);
            EXPECT_EQ(outcome.code, r.code) << r.text;
            EXPECT_EQ(outcome.column, r.column) << r.text;
        }
    EXPECT_EQ(worked_out("#0", linuxcnc_parameters).code, "NC0322");
    EXPECT_EQ(worked_out("#<x>", linuxcnc_parameters).code, "NC0323");
    EXPECT_EQ(worked_out("#<>", linuxcnc_parameters).code, "NC0320");
    EXPECT_EQ(worked_out("#<a", linuxcnc_parameters).code, "NC0320");
    EXPECT_EQ(worked_out("ATAN[1]", linuxcnc_parameters).code, "NC0320");
    EXPECT_EQ(worked_out("[0**-1]", linuxcnc_parameters).code, "NC0325");
    EXPECT_EQ(worked_out("[[0-8]**.5]", linuxcnc_parameters).code, "NC0326");
    EXPECT_EQ(worked_out("#<a>", fanuc_parameters).code, "NC0322");
    EXPECT_EQ(worked_out("[1.5 AND 1]", fanuc_parameters).code, "NC0329");
    EXPECT_EQ(worked_out("[1 EQ 1 EQ 1]", fanuc_parameters).code, "NC0320");
    EXPECT_EQ(worked_out("EXISTS[#1]", fanuc_parameters).code, "NC0321");
    EXPECT_EQ(worked_out(deep.substr(2), fanuc_parameters).code, "NC0328");
}

TEST(ParameterExpressions, LocalParametersBelongToTheirSubprogram) {
    Parameters parameters(linuxcnc_parameters);
    parameters.set({1}, 5);
    parameters.set({31}, 6);
    parameters.set({.name = "a"}, 7);
    parameters.set({.name = "_a"}, 8);
    parameters.enter();
    EXPECT_FALSE(parameters.read({1}));
    EXPECT_FALSE(parameters.read({.name = "a"}));
    EXPECT_EQ(parameters.read({31}), 6);
    EXPECT_EQ(parameters.read({.name = "_a"}), 8);
    parameters.set({1}, 9);
    parameters.set({31}, 10);
    parameters.leave();
    EXPECT_EQ(parameters.read({1}), 5);
    EXPECT_EQ(parameters.read({31}), 10);
    EXPECT_EQ(parameters.read({.name = "a"}), 7);
    parameters.set({.name = "a"}, {});
    EXPECT_FALSE(parameters.read({.name = "a"}));
}

}  // namespace
}  // namespace trunnion::nc
