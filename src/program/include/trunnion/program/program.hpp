#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "trunnion/base/diagnostic.hpp"

namespace trunnion::program {

/// What the coordinates of a move are: the tip in the workpiece (TCP on) or the linear machine axes (TCP off).
enum class Space : std::uint8_t { workpiece, machine };

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

/// One move, modal words resolved: where it ends and how it gets there from the end of the move before.
struct Move {
    Eigen::Vector3d position_mm = Eigen::Vector3d::Zero();  ///< its end, in its space
    Eigen::Vector3d axis =
        Eigen::Vector3d::UnitZ();  ///< law vector: unit tool axis in the workpiece at its end, tip → spindle
    std::array<double, max_rotary_letters>
        rotary_rad{};  ///< law rotary: literal words at its end, order of Program::rotary_letters
    Feed feed;
    MoveKind kind = MoveKind::feed;
    Space space = Space::workpiece;
    OrientationLaw law = OrientationLaw::vector;
    bool exact_stop = false;   ///< the program asks for standstill at its end
    std::uint16_t tool = 0;    ///< index in Program::tools
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

/// A part program, all that matters for motion. moves[0] is where motion starts: the first fully determined pose, not a
/// motion itself. Later moves go from the end of the one before.
struct Program {
    std::string name;                               ///< as the program says, or the file's stem
    std::string source;                             ///< the file
    std::string dialect;                            ///< "apt", "rs274"
    std::vector<char> rotary_letters;               ///< of law rotary, order of Move::rotary_rad
    std::vector<std::string> tools{std::string{}};  ///< [0] = the program names none
    std::vector<std::string> offsets{
        std::string{}};  ///< [0] = the setup's workpiece itself (G54 too unless the setup has it)
    std::vector<Move> moves;
    std::vector<Event> events;
    std::vector<Diagnostic> diagnostics;  ///< warnings, each once with its count
};

}  // namespace trunnion::program
