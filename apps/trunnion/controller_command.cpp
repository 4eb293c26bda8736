#include <cmath>
#include <cstdio>
#include <memory>
#include <string>

#include <fmt/format.h>

#include "trunnion/files/controller_file.hpp"

#include "commands.hpp"
#include "controllers.hpp"
#include "job.hpp"

namespace trunnion::app {

std::vector<std::filesystem::path> controller_folders() {
    std::vector<std::filesystem::path> out;
    for (const auto& machines : machine_folders()) out.push_back(machines.parent_path() / "controllers");
    return out;
}

namespace {

int list_controllers() {
    for (const auto& shipped : files::shipped_controllers(controller_folders()))
        fmt::print("{:<23} {}\n", shipped.name, shipped.title);
    return done;
}

std::string value_text(const motion::Parameter& parameter, const motion::ParameterFacts& facts) {
    if (std::isinf(parameter.value)) return "unlimited";
    std::string out = fmt::format("{:g}", parameter.value / facts.unit_value);
    if (parameter.spread > 0) out += fmt::format(" ± {:g}", parameter.spread / facts.unit_value);
    return facts.unit.empty() ? out : fmt::format("{} {}", out, facts.unit);
}

void print_line(std::string_view name, const std::string& value, motion::Source source, std::string_view meaning) {
    fmt::print("  {:<29}{:<20}{:<12}{}\n", name, value, to_string(source), meaning);
}

void print_controller(motion::Controller controller) {
    fmt::print("{}\n{}\nkind {}\n", controller.name, controller.file, to_string(controller.kind));
    if (!controller.description.empty()) fmt::print("{}\n", controller.description);
    for (std::size_t i = 0; i < motion::choice_count; ++i) {
        const auto id = static_cast<motion::ChoiceId>(i);
        if (!motion::is_used(controller, id)) continue;
        const auto& facts = motion::facts_of(id);
        const auto choice = motion::choice_of(controller, id);
        print_line(facts.key, std::string(facts.words[static_cast<std::size_t>(choice.way)]), choice.source,
                   facts.meaning);
    }
    for (const auto& [name, facts, parameter] : motion::used_parameters(controller))
        print_line(name, value_text(*parameter, *facts), parameter->source, facts->meaning);
}

int show_controller(const std::string& name) {
    const auto controller = files::find_controller(name, controller_folders());
    if (!controller) return report_failure(controller.error());
    print_controller(*controller);
    return done;
}

}  // namespace

void add_controller_command(CLI::App& app, int& status) {
    CLI::App* controller = app.add_subcommand("controller", "what controls there are, and what is known of one");
    controller->require_subcommand(1);
    controller->footer("Example:\n  trunnion controller show lavernhe-2006");
    auto name = std::make_shared<std::string>();
    controller->add_subcommand("list", "the shipped ones")->callback([&status] { status = list_controllers(); });
    CLI::App* show =
        controller->add_subcommand("show", "one control's parameters, what they mean, where they come from");
    show->add_option("controller", *name, "shipped name or file")->required();
    show->callback([name, &status] { status = show_controller(*name); });
}

}  // namespace trunnion::app
