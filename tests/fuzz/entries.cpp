#include "entries.hpp"

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <cstdlib>

#include <fmt/format.h>

namespace trunnion::fuzz {

namespace {

constexpr Entry all[] = {
    {"apt", [](std::string_view bytes) { take_program("apt", bytes); }},
    {"rs274", [](std::string_view bytes) { take_program("rs274", bytes); }},
    {"sinumerik", [](std::string_view bytes) { take_program("sinumerik", bytes); }},
    {"heidenhain", [](std::string_view bytes) { take_program("heidenhain", bytes); }},
    {"fanuc", [](std::string_view bytes) { take_program("fanuc", bytes); }},
    {"machine_file", take_machine_file},
    {"linuxcnc_machine", take_linuxcnc_machine},
    {"setup_file", take_setup_file},
    {"controller_file", take_controller_file},
    {"surface_file", take_surface_file},
    {"setpoints", take_setpoints},
};

bool is_code(std::string_view code) {
    if (code.size() < 6) return false;
    const auto is = [](int (*kind)(int)) {
        return [kind](char letter) { return kind(static_cast<unsigned char>(letter)) != 0; };
    };
    return std::ranges::all_of(code.substr(0, code.size() - 4), is(std::isupper)) &&
           std::ranges::all_of(code.substr(code.size() - 4), is(std::isdigit));
}

}  // namespace

std::span<const Entry> entries() {
    return all;
}

const Entry* entry_named(std::string_view name) {
    const auto* const found = std::ranges::find(all, name, &Entry::name);
    return found == std::end(all) ? nullptr : found;
}

void expect(bool holds, std::string_view promise) {
    if (holds) return;
    fmt::print(stderr, "NOT AS PROMISED: {}\n", promise);
    std::abort();
}

void expect_sound(const Diagnostic& diagnostic, std::string_view bytes) {
    expect(is_code(diagnostic.code), "a diagnostic has a code");
    expect(!diagnostic.text.empty(), "a diagnostic says something");
    expect(diagnostic.count >= 1, "a diagnostic counts at least one");
    const auto lines = std::ranges::count(bytes, '\n') + std::ranges::count(bytes, '\r') + 1;
    expect(diagnostic.place.line >= 0 && diagnostic.place.line <= lines, "a diagnostic points into the text");
    expect(!to_string(diagnostic).empty(), "a diagnostic can be printed");
}

}  // namespace trunnion::fuzz
