#include "trunnion/pipeline/programmed.hpp"

#include <cmath>
#include <optional>
#include <utility>

#include "trunnion/path/rotary_stands.hpp"
#include "trunnion/smoothing/pole_tolerance.hpp"

namespace trunnion::pipeline {

namespace {

using Poses = std::vector<verify::ProgrammedPose>;

/// The first pose of a part is the last one of the part before, which may not have needed to say how the axes stand.
void join(Poses& poses, Poses&& part) {
    if (poses.empty()) {
        poses = std::move(part);
        return;
    }
    auto& last = poses.back();
    last.stands = true;
    for (std::size_t r = 0; r < last.rotary_rad.size(); ++r)
        if (std::isnan(last.rotary_rad[r])) last.rotary_rad[r] = part.front().rotary_rad[r];
    poses.insert(poses.end(), part.begin() + 1, part.end());
}

Diagnostic too_many(const program::Program& program) {
    return {.code = "VER0109",
            .text = "the program has too many poses to be checked",
            .place = {.file = program.source, .line = program.moves.back().line}};
}

}  // namespace

Result<Programmed> programmed_poses(program::ProgramParts& parts, const machine::Machine& machine,
                                    const machine::Setup& setup, const smoothing::SmoothingOptions& tolerances) {
    Programmed out;
    std::optional<machine::RotaryPosition> standing;
    for (program::Program part;;) {
        const auto more = parts.next(part);
        if (!more) return fail(more.error());
        if (!*more) return out;
        const auto stands =
            path::choose_rotary_stands(part, machine, setup, smoothing::pole_tolerance_rad(tolerances), standing);
        if (!stands) return fail(stands.error());
        auto poses = verify::programmed_poses(part, machine, setup, *stands, standing);
        if (!poses) return fail(poses.error());
        if (out.poses.size() + poses->size() > verify::most_programmed_poses) return fail(too_many(part));
        join(out.poses, std::move(*poses));
        standing = stands->back().rotary_rad;
        out.diagnostics = part.diagnostics;
    }
}

}  // namespace trunnion::pipeline
