#pragma once

#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "trunnion/verify/programmed_path.hpp"

#include "made_motions.hpp"

/// Programs made by hand.
namespace trunnion::verify::test {

using program::Move;
using program::OrientationLaw;
using program::Program;
using program::Space;

inline Move by_words(Eigen::Vector3d position, double a, double c, std::int32_t line) {
    Move out;
    out.position_mm = position;
    out.rotary_rad = {a, c, 0};
    out.law = OrientationLaw::rotary;
    out.line = line;
    return out;
}

inline Move by_vector(Eigen::Vector3d position, Eigen::Vector3d axis, std::int32_t line) {
    Move out;
    out.position_mm = position;
    out.axis = axis.normalized();
    out.line = line;
    return out;
}

inline Program program_of(std::vector<Move> moves) {
    Program out;
    out.rotary_letters = {'A', 'C'};
    out.moves = std::move(moves);
    return out;
}

using Stands = std::vector<program::RotaryStand>;

inline std::vector<ProgrammedPose> poses_of(const Program& program, const machine::Setup& setup = peer_setup(),
                                            const machine::Machine& machine = peer_trunnion(),
                                            const Stands& stands = {}) {
    auto poses = programmed_poses(program, machine, setup, stands);
    EXPECT_TRUE(poses) << (poses ? "" : to_string(poses.error()));
    return poses.value_or(std::vector<ProgrammedPose>{});
}

inline std::string code_of(const Program& program, const machine::Setup& setup = peer_setup(),
                           const machine::Machine& machine = peer_trunnion(), const Stands& stands = {}) {
    const auto poses = programmed_poses(program, machine, setup, stands);
    return poses ? "none" : poses.error().code;
}

}  // namespace trunnion::verify::test
