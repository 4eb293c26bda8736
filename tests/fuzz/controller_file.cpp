#include "trunnion/files/controller_file.hpp"

#include <cmath>

#include "entries.hpp"

namespace trunnion::fuzz {

namespace {

void expect_sound(const motion::NamedParameter& named) {
    const motion::Parameter& parameter = *named.parameter;
    const motion::ParameterFacts& facts = *named.facts;
    expect(parameter.given, "what is used is given");
    expect(!std::isnan(parameter.value), "values are numbers");
    if (std::isinf(parameter.value)) {
        expect(facts.may_be_unlimited && parameter.value > 0 && parameter.spread == 0,
               "unlimited is a word of its own");
        return;
    }
    expect(parameter.value >= facts.least && parameter.value <= facts.most, "values lie where they may");
    expect(!facts.whole || parameter.value == std::floor(parameter.value), "counts are whole");
    expect(std::isfinite(parameter.spread) && parameter.spread >= 0, "spreads are finite and not negative");
    const auto [low, high] = motion::truth_of(parameter, facts);
    expect(facts.least <= low && low <= parameter.value && parameter.value <= high && high <= facts.most,
           "the truth lies about the value, where it may");
}

}  // namespace

void take_controller_file(std::string_view bytes) {
    auto controller = files::read_controller(bytes, "fuzz");
    if (!controller) return expect_sound(controller.error(), bytes);
    for (const auto& [letter, limits] : controller->axis_limits)
        expect(motion::limited_letters.contains(letter), "axes are those that may be limited");
    for (const motion::NamedParameter& named : motion::used_parameters(*controller)) expect_sound(named);
    for (std::size_t i = 0; i < motion::choice_count; ++i) {
        const auto id = static_cast<motion::ChoiceId>(i);
        const int way = motion::choice_of(*controller, id).way;
        expect(way >= 0 && std::size_t(way) < motion::facts_of(id).words.size(), "choices are one of their words");
    }
}

}  // namespace trunnion::fuzz
