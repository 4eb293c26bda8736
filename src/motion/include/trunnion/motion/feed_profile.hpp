#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace trunnion::motion {

/// One piece of the speed over the path of a stretch.
/// rest_start: constant path jerk j from standstill, δ = j t³/6 with t from the piece's start.
/// rest_stop: its mirror, standstill at the piece's end.
/// cubic: x = ṗ² with x(0) = x0, x′(0) = d0 and x″ linear from e0 to e1 over the length (mm²/s², by mm).
struct ProfilePiece {
    enum class Kind : std::uint8_t { rest_start, cubic, rest_stop } kind = Kind::cubic;
    std::size_t path_piece = 0;  ///< of the stretch's ToolPath
    double path_offset_mm = 0;   ///< where this piece begins in that path piece
    double length_mm = 0;        ///< never longer than what is left of the path piece
    double x0 = 0, d0 = 0, e0 = 0, e1 = 0;
    double jerk_mm_s3 = 0;               ///< of the rest kinds
    double begin_s = 0, duration_s = 0;  ///< from the stretch's start
};

/// Speed along one stretch from rest to rest: abutting pieces.
struct FeedProfile {
    std::vector<ProfilePiece> pieces;
    double duration_s() const { return pieces.empty() ? 0 : pieces.back().begin_s + pieces.back().duration_s; }
};

/// State along the path at one time.
struct PathState {
    std::size_t profile_piece = 0;
    double delta_mm = 0;                                            ///< from the profile piece's start
    double speed_mm_s = 0, acceleration_mm_s2 = 0, jerk_mm_s3 = 0;  ///< ṗ, p̈, p⃛
};

/// ṗ, p̈, p⃛ at `delta_mm` in the piece. At the rest end of a rest piece speed and acceleration are 0 and jerk is ±j.
PathState state_at(const ProfilePiece& piece, double delta_mm) noexcept;

/// Time from the piece's start to `delta_mm`: exact for the rest kinds, Gauss quadrature of relative error below 1e-12
/// at the speed ratios that feed planning makes for cubic ones.
double time_to(const ProfilePiece& piece, double delta_mm) noexcept;

/// The inverse: where the piece is `time_s` after its start. Newton, at most 30 steps, falls back to bisection.
double distance_at(const ProfilePiece& piece, double time_s) noexcept;

}  // namespace trunnion::motion
