#include "trunnion/motion/controller.hpp"

#include <cmath>
#include <set>
#include <string>

#include <gtest/gtest.h>

#include "trunnion/motion/prediction.hpp"

namespace trunnion::motion {
namespace {

TEST(Controller, EveryParameterHasFactsOfItsOwnAndAKind) {
    std::set<std::string_view> keys;
    for (std::size_t i = 0; i < parameter_count; ++i) {
        const auto id = static_cast<ParameterId>(i);
        const ParameterFacts& facts = facts_of(id);
        EXPECT_TRUE(keys.insert(facts.key).second) << facts.key;
        EXPECT_FALSE(facts.meaning.empty()) << facts.key;
        EXPECT_LT(facts.least, facts.most) << facts.key;
        EXPECT_GT(facts.unit_value, 0) << facts.key;
        EXPECT_TRUE(belongs_to(ControllerKind::blocks, id) || belongs_to(ControllerKind::linuxcnc, id)) << facts.key;
        EXPECT_FALSE(belongs_to(ControllerKind::ideal, id)) << facts.key;
    }
    EXPECT_TRUE(belongs_to(ControllerKind::blocks, ParameterId::tool_change_time));
    EXPECT_TRUE(belongs_to(ControllerKind::linuxcnc, ParameterId::tool_change_time));
    EXPECT_FALSE(belongs_to(ControllerKind::linuxcnc, ParameterId::jerk_share));
    EXPECT_FALSE(belongs_to(ControllerKind::blocks, ParameterId::servo_period));
}

TEST(Controller, ChoicesReadBackWhatWasSet) {
    for (std::size_t i = 0; i < choice_count; ++i) {
        const auto id = static_cast<ChoiceId>(i);
        for (std::size_t way = 0; way < facts_of(id).words.size(); ++way) {
            Controller controller;
            set_choice(controller, id, {static_cast<int>(way), Source::documented});
            EXPECT_EQ(choice_of(controller, id).way, static_cast<int>(way)) << facts_of(id).key;
            EXPECT_EQ(choice_of(controller, id).source, Source::documented) << facts_of(id).key;
        }
    }
}

TEST(Controller, TheTruthLiesAboutTheValueWhereItMay) {
    const ParameterFacts& share = facts_of(ParameterId::missed_command_periods);
    EXPECT_EQ(truth_of({.value = 0, .spread = 0.13}, share).low, 0);
    EXPECT_EQ(truth_of({.value = 0, .spread = 0.13}, share).high, 0.13);
    const ParameterFacts& depth = facts_of(ParameterId::arc_blend_optimization_depth);
    EXPECT_EQ(truth_of({.value = 50, .spread = 2.5}, depth).low, 47);
    EXPECT_EQ(truth_of({.value = 50, .spread = 2.5}, depth).high, 53);
    EXPECT_EQ(truth_of({.value = 50}, depth).low, 50);
    EXPECT_TRUE(std::isinf(truth_of({.value = INFINITY}, facts_of(ParameterId::max_linear_velocity)).low));
}

TEST(Controller, UsedParametersAreThoseOfTheModelAndItsAxes) {
    Controller control{.kind = ControllerKind::linuxcnc};
    const auto names = [&] {
        std::set<std::string> out;
        for (const NamedParameter& named : used_parameters(control)) out.insert(named.name);
        return out;
    };
    EXPECT_TRUE(names().contains("arc_blend_gap_cycles"));
    EXPECT_FALSE(names().contains("look_ahead_blocks"));
    control.arc_blend_enable.way = Switch::off;
    EXPECT_FALSE(names().contains("arc_blend_gap_cycles"));
    control.axis_limits['A'][0].given = true;
    EXPECT_TRUE(names().contains("A max_velocity"));
    EXPECT_FALSE(names().contains("A max_acceleration"));
    control.kind = ControllerKind::ideal;
    EXPECT_TRUE(names().empty());
}

TEST(Limit, EveryKindHasANameOfItsOwn) {
    std::set<std::string> names;
    for (int kind = 0; kind <= static_cast<int>(LimitKind::planner); ++kind)
        EXPECT_TRUE(names.insert(to_string({.kind = static_cast<LimitKind>(kind)}, {})).second) << kind;
    EXPECT_TRUE(names.contains("command rate"));
    EXPECT_TRUE(names.contains("linear velocity"));
    EXPECT_TRUE(names.contains("planner"));
}

}  // namespace
}  // namespace trunnion::motion
