#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <CLI/CLI.hpp>

#include "trunnion/base/result.hpp"
#include "trunnion/machine/machine.hpp"
#include "trunnion/surfacing/cutter.hpp"
#include "trunnion/surfacing/face.hpp"
#include "trunnion/surfacing/plan_surface.hpp"

namespace trunnion::app {

/// What the command line says about a surface and how a tool goes over it, as text.
struct SurfaceText {
    std::string file, faces, side = "file", tool, reach, strategy = "constant-scallop";
    std::string scallop = "10um", chord_tolerance, gouge_tolerance = "1um";
    std::string lead = "0deg", tilt = "0deg", feed_angle = "0deg";
    std::string feed = "3m/min", approach_feed, lift = "1mm", retract = "20mm", longest_step = "5mm";
    bool zigzag = true, borders = true;

    /// Surface file, faces, side and tool. Not --setup.
    void add_surface_to(CLI::App& command);
    /// How the passes lie; `feed_is`: which speed the feed is.
    void add_passes_to(CLI::App& command, const char* feed_is);
};

/// That, read.
struct SurfaceWork {
    surfacing::FaceList list;  ///< all faces of the file, on the side that is wanted, and what is told of them
    std::vector<surfacing::Face> faces;  ///< those to be machined
    std::string tool_name;               ///< of the setup's table; empty: the setup's [tool], or one of --tool's own
    machine::Tool tool;
    surfacing::Cutter cutter;
    surfacing::SurfaceOptions options;
};

/// An error in the value of an option.
Diagnostic in_option(const char* name, Diagnostic error);

/// `50mm 40 mm` → `50mm`, `40mm`: words that do not begin as a number are units of the number before.
std::vector<std::string> quantities_in(std::string_view text);

/// `3,5`, or `all` of them, as the value of an option. Errors: PIPE0110.
Result<std::vector<int>> face_numbers(const char* option, std::string_view text, const surfacing::FaceList& list);

/// The tool that `--tool` says: "ball 10mm", "flat 20mm", "torus 20mm 3mm" (diameter, corner radius), or the name of
/// one in the setup's table; its length is that of the setup's [tool]. Empty: the setup's [tool]. Errors: PIPE0112.
Result<machine::Tool> tool_of(const std::string& text, const machine::Setup& setup);

/// Reads faces, tool and options. Errors: PIPE0110 … PIPE0113, those of pipeline::read_surface_faces, Cutter::make and
/// parse_quantity.
Result<SurfaceWork> load_surface(const SurfaceText& text, const machine::Setup& setup);

}  // namespace trunnion::app
