#include "surface_options.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <span>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "trunnion/base/quantity.hpp"
#include "trunnion/pipeline/surface_faces.hpp"

namespace trunnion::app {

namespace {

/// Order of surfacing::Strategy.
const std::vector<std::string> strategy_names{"constant-scallop", "along-u", "along-v", "parallel-planes", "lin-koren"};

constexpr std::array tool_kinds{"flat", "ball", "torus"};  ///< order of machine::ToolKind

/// Where no chord tolerance is given: of the scallop, and at most of the gouge tolerance, as chords cut into hollows.
constexpr double share_of_scallop = 0.05, share_of_gouge = 0.5;

std::vector<std::string> words_of(std::string_view text) {
    std::vector<std::string> out;
    while (!text.empty()) {
        const std::size_t end = std::min(text.find(' '), text.size());
        if (end > 0) out.emplace_back(text.substr(0, end));
        text.remove_prefix(std::min(end + 1, text.size()));
    }
    return out;
}

/// Words that do not begin with a digit are units of the number before: `10 mm`.
std::vector<std::string> with_their_units(std::span<const std::string> words) {
    std::vector<std::string> out;
    for (const std::string& word : words) {
        const bool number = std::string_view("0123456789.+-").find(word.front()) != std::string_view::npos;
        if (number || out.empty())
            out.push_back(word);
        else
            out.back() += word;
    }
    return out;
}

Diagnostic no_tool(const std::string& text, const machine::Setup& setup) {
    std::string named;
    for (const auto& [name, tool] : setup.tools) named += fmt::format(", {}", name);
    return {.code = "PIPE0112",
            .text = text.empty() ? "no tool is given that machines a surface" : "--tool says no tool",
            .value = text,
            .hint = fmt::format("--tool \"ball 10mm\", \"flat 20mm\", \"torus 20mm 3mm\"{}",
                                named.empty() ? ", or --setup with a [tool]" : " or one of the setup" + named)};
}

Result<machine::Tool> described_tool(const std::string& text, std::span<const std::string> words, std::size_t kind,
                                     const machine::Setup& setup) {
    const auto sizes = with_their_units(words.subspan(1));
    machine::Tool out{.kind = static_cast<machine::ToolKind>(kind), .length_mm = setup.tool.length_mm};
    if (sizes.size() != (out.kind == machine::ToolKind::torus ? 2 : 1)) return fail(no_tool(text, setup));
    for (std::size_t i = 0; i < sizes.size(); ++i) {
        auto size = parse_quantity(sizes[i], dimension::length);
        if (!size) return fail(in_option("--tool", std::move(size.error())));
        (i == 0 ? out.diameter_mm : out.corner_radius_mm) = *size;
    }
    if (out.kind == machine::ToolKind::ball) out.corner_radius_mm = out.diameter_mm / 2;
    return out;
}

Result<surfacing::SurfaceOptions> options_of(const SurfaceText& text) {
    surfacing::SurfaceOptions out;
    const auto strategy = std::ranges::find(strategy_names, text.strategy) - strategy_names.begin();
    out.strategy = static_cast<surfacing::Strategy>(strategy);
    out.zigzag = text.zigzag;
    out.borders = text.borders;
    struct Quantity {
        double* target;
        const char* name;
        const std::string* written;
        Dimension wanted;
    };
    const Quantity quantities[] = {
        {&out.scallop_mm, "--scallop", &text.scallop, dimension::length},
        {&out.chord_tolerance_mm, "--chord-tolerance", &text.chord_tolerance, dimension::length},
        {&out.gouge_tolerance_mm, "--gouge-tolerance", &text.gouge_tolerance, dimension::length},
        {&out.lead_rad, "--lead", &text.lead, dimension::angle},
        {&out.tilt_rad, "--tilt", &text.tilt, dimension::angle},
        {&out.feed_angle_rad, "--feed-angle", &text.feed_angle, dimension::angle},
        {&out.feed_mm_s, "--feed", &text.feed, dimension::velocity},
        {&out.approach_mm_s, "--approach-feed", &text.approach_feed, dimension::velocity},
        {&out.lift_mm, "--lift", &text.lift, dimension::length},
        {&out.retract_mm, "--retract", &text.retract, dimension::length},
        {&out.longest_step_mm, "--longest-step", &text.longest_step, dimension::length}};
    for (const auto& [target, name, written, wanted] : quantities) {
        if (written->empty()) continue;
        auto value = parse_quantity(*written, wanted);
        if (!value) return fail(in_option(name, std::move(value.error())));
        *target = *value;
    }
    if (text.chord_tolerance.empty())
        out.chord_tolerance_mm = std::min(share_of_scallop * out.scallop_mm, share_of_gouge * out.gouge_tolerance_mm);
    if (text.approach_feed.empty()) out.approach_mm_s = out.feed_mm_s;
    return out;
}

}  // namespace

Diagnostic in_option(const char* name, Diagnostic error) {
    error.text = fmt::format("{}: {}", name, error.text);
    return error;
}

std::vector<std::string> quantities_in(std::string_view text) {
    return with_their_units(words_of(text));
}

Result<std::vector<int>> face_numbers(const char* option, std::string_view text, const surfacing::FaceList& list) {
    std::vector<int> out;
    if (text == "all") {
        for (const auto& face : list.faces) out.push_back(face.number);
        return out;
    }
    for (std::string_view rest = text; !rest.empty();) {
        const std::string_view word = rest.substr(0, rest.find(','));
        int number = 0;
        const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
        if (error != std::errc() || end != word.data() + word.size())
            return fail({.code = "PIPE0110",
                         .text = fmt::format("{} is no list of numbers", option),
                         .value = std::string(text),
                         .hint = "write it like 3,5 or all"});
        out.push_back(number);
        rest.remove_prefix(std::min(word.size() + 1, rest.size()));
    }
    return out;
}

void SurfaceText::add_surface_to(CLI::App& command) {
    command.add_option("surface", file, "surface: STEP (.step .stp), IGES (.iges .igs) or a surface file (.toml)")
        ->required();
    command.add_option("--face", faces, "numbers of the faces to machine, 3,5, or all; not needed where there is one");
    command.add_option("--side", side, "where the tool is: as the file says, or on the other side of the faces")
        ->check(CLI::IsMember({"file", "other"}))
        ->capture_default_str();
    command.add_option("--tool", tool,
                       "\"ball 10mm\", \"flat 20mm\", \"torus 20mm 3mm\" (diameter, corner radius), or the name of one "
                       "of the setup; default: the setup's [tool]");
    command.add_option("--reach", reach, "how far up from its tip the tool is as thick; default: its diameter");
}

void SurfaceText::add_passes_to(CLI::App& command, const char* feed_is) {
    command.add_option("--strategy", strategy, "how the passes lie")
        ->check(CLI::IsMember(strategy_names))
        ->capture_default_str();
    command.add_option("--scallop", scallop, "highest ridge between passes")->capture_default_str();
    command.add_option(
        "--chord-tolerance", chord_tolerance,
        "how far moves may lead the tool off the surface; default: a twentieth of the scallop, at most half "
        "of the gouge tolerance");
    command.add_option("--gouge-tolerance", gouge_tolerance, "how deep the tool may cut into the part")
        ->capture_default_str();
    command.add_option("--lead", lead, "tool axis leaning from the normal towards the feed")->capture_default_str();
    command.add_option("--tilt", tilt, "tool axis leaning across the feed")->capture_default_str();
    command
        .add_option("--feed-angle", feed_angle,
                    "constant-scallop, parallel-planes: direction of the passes in the middle, from u towards v")
        ->capture_default_str();
    command.add_flag("--one-way{false},--zigzag{true}", zigzag, "passes all in one direction, or to and fro (default)");
    command.add_flag("--no-borders{false},--borders{true}", borders, "a pass along every border as well (default)");
    command.add_option("--feed", feed, feed_is)->capture_default_str();
    command.add_option("--approach-feed", approach_feed, "from the lift height down to the surface; default: the feed");
    command.add_option("--lift", lift, "up the tool axis between neighbouring passes to and fro")
        ->capture_default_str();
    command.add_option("--retract", retract, "up the tool axis for rapids")->capture_default_str();
    command.add_option("--longest-step", longest_step, "of a straight move")->capture_default_str();
}

Result<machine::Tool> tool_of(const std::string& text, const machine::Setup& setup) {
    const auto words = words_of(text);
    if (words.empty()) {
        if (setup.tool.diameter_mm > 0) return setup.tool;
        return fail(no_tool(text, setup));
    }
    const auto kind = std::ranges::find(tool_kinds, words.front());
    if (kind != tool_kinds.end())
        return described_tool(text, words, static_cast<std::size_t>(kind - tool_kinds.begin()), setup);
    const auto named = setup.tools.find(text);
    if (named == setup.tools.end()) return fail(no_tool(text, setup));
    return named->second;
}

Result<SurfaceWork> load_surface(const SurfaceText& text, const machine::Setup& setup) {
    const auto options = options_of(text);
    if (!options) return fail(options.error());
    const auto tool = tool_of(text.tool, setup);
    if (!tool) return fail(tool.error());
    double reach_mm = 0;
    if (!text.reach.empty()) {
        auto reach = parse_quantity(text.reach, dimension::length);
        if (!reach) return fail(in_option("--reach", std::move(reach.error())));
        reach_mm = *reach;
    }
    const auto cutter = surfacing::Cutter::make(*tool, reach_mm);
    if (!cutter) return fail(cutter.error());
    auto list = pipeline::read_surface_faces(text.file);
    if (!list) return fail(list.error());
    const auto numbers = face_numbers("--face", text.faces, *list);
    if (!numbers) return fail(numbers.error());
    if (text.side == "other")
        for (surfacing::Face& face : list->faces) face.side = geometry::opposite(face.side);
    auto faces = pipeline::choose_faces(*list, *numbers);
    if (!faces) return fail(faces.error());
    const bool named = setup.tools.contains(text.tool);
    return SurfaceWork{std::move(*list), std::move(*faces), named ? text.tool : "", *tool, *cutter, *options};
}

}  // namespace trunnion::app
