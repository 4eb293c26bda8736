#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "trunnion/base/diagnostic.hpp"

namespace trunnion::program {

/// What the coordinates of a move are.
enum class Space : std::uint8_t {
    workpiece,     ///< the tip in the work offset's frame (TCP on)
    machine,       ///< positions of the linear machine axes, without offset or tool length (G53, SUPA)
    untransformed  ///< linear machine axes as a control counts them with TCP off: from the work offset and with the
                   ///< tool's length, so that with all rotary axes at 0 they are the tip in the work offset's frame
};

/// How the tool turns along a move. vector: in one plane, in proportion to the tip's way. rotary: the rotary words are
/// linear in the move's parameter.
enum class OrientationLaw : std::uint8_t { vector, rotary };

enum class MoveKind : std::uint8_t { rapid, feed };

/// What the programmed feed of a move bounds. The reader resolved the dialect's modes to one of these.
enum class FeedRule : std::uint8_t {
    none,         ///< nothing: a rapid
    tip_speed,    ///< speed of the tip in the workpiece (in machine space: of the linear axes), mm/s
    rotary_rate,  ///< Euclidean rate of the rotary words, rad/s: a pure rotation in deg/min
    block_time    ///< time of the whole block, s (G93)
};

struct Feed {
    FeedRule rule = FeedRule::none;
    double value = 0;  ///< mm/s, rad/s or s: see the rule
    bool operator==(const Feed&) const = default;
};

/// At most so many rotary letters in one program.
inline constexpr int max_rotary_letters = 3;

/// A circle or helix: the position turns about the line through `centre_mm` along `normal` by `angle_rad` (right-hand
/// sense where positive; more than 2π for several turns), goes along the line in proportion to the angle, and its
/// distance from the line changes in proportion too, where start and end differ. In the frame of the move's position.
struct Arc {
    Eigen::Vector3d centre_mm = Eigen::Vector3d::Zero();  ///< any point of the line
    Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();    ///< unit
    double angle_rad = 0;
};

inline constexpr std::int32_t no_arc = -1;

/// A curve that the program itself gives as piecewise polynomials (BSPLINE, POLY, NURBS): C(u) = Σ N_{i,p}(u) w_i P_i /
/// Σ N_{i,p}(u) w_i for u from knots[p] to knots[n], n control points, degree p. Basis as in geometry::BsplineCurve.
struct Curve {
    int degree = 3;                            ///< p, 1 … 7
    std::vector<double> knots;                 ///< n + p + 1, never falling
    std::vector<Eigen::Vector3d> position_mm;  ///< control points, in the space of its moves
    std::vector<double> weights;               ///< by control point, positive; empty: all 1
    /// Law vector: the tool axis is the direction of Σ N_i w_i axis_i ≠ 0, which need not be unit; of a dual spline
    /// (top − bottom). Empty: it turns from a move's start to its end in proportion to u.
    std::vector<Eigen::Vector3d> axis;
    /// Law rotary: the words are Σ N_i w_i rotary_i / Σ N_i w_i. Empty: linear in u from a move's start to its end.
    std::vector<std::array<double, max_rotary_letters>> rotary_rad;
};

/// The part of a curve that one move follows, from_u < to_u; the end of the move before lies at C(from_u).
struct CurvePart {
    std::int32_t curve = 0;  ///< index in Program::curves
    double from_u = 0, to_u = 1;
};

inline constexpr std::int32_t no_curve_part = -1;

/// One move, modal words resolved: where it ends and how it gets there from the end of the move before.
struct Move {
    /// Its end, in its space. NaN: this coordinate, as it counts in the move's space, offset and tool, ends where it
    /// began; for readers that do not know it, as after a change of space, offset or tool. Never in moves[0].
    Eigen::Vector3d position_mm = Eigen::Vector3d::Zero();
    Eigen::Vector3d axis =
        Eigen::Vector3d::UnitZ();  ///< law vector: unit tool axis in the workpiece at its end, tip → spindle
    std::array<double, max_rotary_letters> rotary_rad{};  ///< law rotary: literal words at its end, order of
                                                          ///< Program::rotary_letters; NaN: the axis stays where it
                                                          ///< stands (no word since a move of law vector)
    std::int32_t arc = no_arc;                            ///< index in Program::arcs; no_arc: no arc
    std::int32_t curve_part = no_curve_part;  ///< index in Program::curve_parts; neither arc nor curve: straight
    Feed feed;
    MoveKind kind = MoveKind::feed;
    Space space = Space::workpiece;
    OrientationLaw law = OrientationLaw::vector;
    bool exact_stop = false;   ///< the program asks for standstill at its end
    std::uint16_t tool = 0;    ///< index in Program::tools: whose length counts
    std::uint16_t offset = 0;  ///< index in Program::offsets
    std::int32_t line = 0;     ///< in the source, from 1
};

enum class EventKind : std::uint8_t { dwell, tool, spindle, coolant, stop, other };

/// Something other than motion, at its place among the moves.
struct Event {
    EventKind kind = EventKind::other;
    bool stops_motion = false;  ///< the axes stand still when it happens
    double dwell_s = 0;
    std::string word;             ///< as written, `M3`, `S600`, `T8`, `G4 P2`
    std::size_t before_move = 0;  ///< it falls where moves[before_move] begins; moves.size() = at the end
    std::int32_t line = 0;
};

/// How a control is to pass from block to block.
enum class PathControlKind : std::uint8_t {
    stop,   ///< a standstill at every end (G61.1)
    exact,  ///< exactly along the path, through tangent joints without a stop (G61)
    blend   ///< as fast as the tolerance allows (G64)
};

/// A word of path control as it was said, from moves[before_move] on. Before the first one the control does as it does
/// by itself. It is for models of controls: what is planned here has its own tolerances, and Move::exact_stop.
struct PathControl {
    PathControlKind kind = PathControlKind::blend;
    double tolerance_mm = 0;        ///< G64 P; 0: none
    double merge_tolerance_mm = 0;  ///< within which short blocks may become one (G64 Q); 0: they stay
    std::size_t before_move = 0;
};

/// A surface that the program itself gives (Lin & Koren): S(u, v) = Σ Σ N_i N_j w_ij P_ij / Σ Σ N_i N_j w_ij, as in
/// geometry::BsplineSurface.
struct Surface {
    int degree_u = 3, degree_v = 3;            ///< 1 … 7
    std::vector<double> knots_u, knots_v;      ///< control points of that direction + degree + 1, never falling
    std::vector<Eigen::Vector3d> position_mm;  ///< P_ij at i · (points of v) + j, in the frame of its job's offset
    std::vector<double> weights;               ///< by control point, positive; empty: all 1
};

/// How passes lie on a surface; the same names as surfacing::Strategy.
enum class SurfaceStrategy : std::uint8_t { constant_scallop, along_u, along_v, parallel_planes, lin_koren };

/// A surface that the program wants machined, where moves[before_move] begins; moves.size() = at the end. The passes
/// are laid by pipeline::expand_surfaces(), which puts moves in their place.
struct SurfaceJob {
    std::int32_t surface = 0;     ///< index in Program::surfaces
    bool normal_against = false;  ///< the material is on the side of S_u × S_v
    SurfaceStrategy strategy = SurfaceStrategy::constant_scallop;
    double scallop_mm = 0.01, chord_tolerance_mm = 0.0005;
    double feed_angle_rad = 0, lead_rad = 0, tilt_rad = 0;
    bool zigzag = true, borders = true;
    double lift_mm = 1, retract_mm = 20;
    double feed_mm_s = 0, approach_mm_s = 0;  ///< approach 0: as the feed
    bool free_of_gouges = false;              ///< the tool leans out of this surface and of `others`
    double reach_mm = 0;  ///< with free_of_gouges: how far up from its tip the tool is as thick; 0: its diameter
    std::vector<std::int32_t> others;  ///< indices in Program::surfaces: sheets that the tool must not go into
    std::size_t before_move = 0;
    std::uint16_t tool = 0;    ///< index in Program::tools
    std::uint16_t offset = 0;  ///< index in Program::offsets
    std::int32_t line = 0;
};

/// Where the rotary axes stand at the end of a move: chosen by path building where the program leaves it open.
struct RotaryStand {
    std::array<double, 2> rotary_rad{};  ///< order of the machine's rotary axes, control's count
    /// A move of law vector that turns as under law rotary, from the stand before to this one: a rapid on which the
    /// axes go to another branch or winding, or a move at the pole along which the free axis turns.
    bool rebranched = false;
};

/// A part program, all that matters for motion. moves[0] is where motion starts: the first fully determined pose, not a
/// motion itself. Later moves go from the end of the one before.
struct Program {
    std::string name;                               ///< as the program says, or the file's stem
    std::string source;                             ///< the file
    std::string dialect;                            ///< "apt", "rs274", "sinumerik", "heidenhain", "fanuc"
    std::vector<char> rotary_letters;               ///< of law rotary, order of Move::rotary_rad
    std::vector<std::string> tools{std::string{}};  ///< [0] = the program names none
    std::vector<std::string> offsets{
        std::string{}};  ///< [0] = the setup's workpiece itself (G54 too unless the setup has it)
    std::vector<Move> moves;
    std::vector<Arc> arcs;
    std::vector<Curve> curves;
    std::vector<CurvePart> curve_parts;
    std::vector<Surface> surfaces;
    std::vector<SurfaceJob> surface_jobs;  ///< in order
    /// Axes that go along without shaping the motion (extruder E, laser power): in proportion to the way of their move.
    std::vector<char> following_letters;
    /// Where they are at the end of every move, row by row: moves.size() × following_letters.size(). Lengths in mm, the
    /// rest as written; running totals, whatever the program set to 0 on its way.
    std::vector<double> following;
    std::vector<Event> events;
    std::vector<PathControl> path_controls;  ///< words of path control, in order; rs274 only
    std::vector<Diagnostic> diagnostics;     ///< warnings, each once with its count
};

}  // namespace trunnion::program
