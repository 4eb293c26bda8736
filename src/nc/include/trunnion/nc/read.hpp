#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <string_view>

#include "trunnion/base/result.hpp"
#include "trunnion/machine/machine.hpp"
#include "trunnion/program/program.hpp"
#include "trunnion/program/program_parts.hpp"

namespace trunnion::nc {

/// The languages of part programs that are read.
enum class Dialect : std::uint8_t {
    apt,         ///< APT cutter location data, and bare lists of poses (x y z or x y z i j k a line)
    rs274,       ///< G-code as LinuxCNC takes it
    sinumerik,   ///< SINUMERIK 840D and its like
    heidenhain,  ///< HEIDENHAIN Klartext
    fanuc        ///< ISO code as FANUC and its like take it
};

/// `apt`, `rs274`, `sinumerik`, `heidenhain`, `fanuc`.
std::string_view name_of(Dialect dialect) noexcept;
std::optional<Dialect> dialect_named(std::string_view name) noexcept;

/// Which unit of length rules: the one that the program states, or this one whatever the program states.
enum class Units : std::uint8_t { none, mm, inch };

/// Where open_program_file() ends a part: at the first place of its kind behind so many moves, or so many events.
struct PartSizes {
    std::size_t to_rapid = 64'000;  ///< before a rapid
    std::size_t to_stop = 128'000;  ///< where motion stands still: an exact stop, a dwell, an event that stops it
    std::size_t most = 200'000;     ///< anywhere: a standstill is made there, and told (NC0019)
};

struct ReadOptions {
    std::optional<Dialect> dialect;  ///< empty: recognised by content
    Units units = Units::none;       ///< a feed that names its own unit (IPM, MMPM) keeps it
    const machine::Machine* machine =
        nullptr;                        ///< rotary words and words of one control need it; read only while reading
    bool feed_given_elsewhere = false;  ///< a missing feed is no error: such moves get the value 0
    /// Lines that jumps, loops and subprograms may carry out beyond the text once, about 1 µs each; more is a program
    /// without an end (NC0338, NC0542, NC0743; fanuc: see docs/dialects.md).
    std::int64_t most_repeated_lines = 5'000'000;
    int most_lines = std::numeric_limits<int>::max();  ///< up to before this line: NC0020
    PartSizes parts;
};

/// The dialect of a text, by the first line that tells. Looks at no file name. Allocates nothing unless it fails.
/// Errors: NC0002 nothing but blanks, NC0004 not recognised (the diagnostic names the line).
Result<Dialect> recognise(std::string_view text);

/// Reads a part program: every word is understood, or ignored with one counted warning where it cannot change motion,
/// or refused with its place. Any bytes are taken: the result is a Program or a Diagnostic.
///
/// What comes out: moves[0] is the first pose of which every coordinate and every rotary letter that the program ever
/// uses is known; from where the frame of its linear coordinates changes (space, offset, tool) one that is not said is
/// NaN: its axis stays where it stands. Moves that change nothing are left out; lengths in mm, rotary words in rad and
/// literal.
///
/// apt: law vector. A pose of three numbers keeps the vector, (0, 0, 1) at first. The feed is the speed of the tip; a
/// pure rotation has none and is bounded by the axes alone.
/// rs274: law rotary, always (no letters: the rotary axes stand still). G94: F is the speed of the tip in mm/min
/// (inch/min) where a linear coordinate changes, else deg/min of the Euclidean length of the rotary words. G93: 60/F s
/// for the block. Linear words are of the workpiece while TCP is on, as it is at first; after a word of words.tcp_off
/// they are untransformed; G53 is one block of machine axes, with offset 0. G2 and G3 are arcs in each of them.
/// sinumerik: law rotary by rotary words, law vector by A3 B3 C3 (or A2 B2 C2) and in planes of CYCLE800. Linear words
/// are of the workpiece under TRAORI and in planes of CYCLE800, else untransformed; of the machine axes in a block with
/// SUPA. F as in rs274; a pure rotation counts at FGREF's radius, 1 mm for 1 degree. Frames and drilling cycles are
/// carried out. docs/dialects.md lists every word.
/// heidenhain: law rotary by rotary words, law vector by TX TY TZ and in tilted planes. Linear words are of the
/// workpiece under M128 and FUNCTION TCPM and in tilted planes, else untransformed; of the machine axes with M91.
/// fanuc: law rotary, law vector under G43.5 and in planes of G68.2 with G53.1. Linear words are of the workpiece under
/// G43.4, G43.5 and G234, else untransformed; of the machine axes with G53. F as in rs274.
/// Curves that a program gives (BSPLINE, POLY, NURBS) stay curves: one move for each span of knots.
///
/// `file_name` is used for diagnostics and for the name of the program. Cost: one pass, about 1 µs a block; the memory
/// of the moves. Errors: src/nc/README.md lists all codes.
Result<program::Program> read_program(std::string_view text, std::string_view file_name, const ReadOptions& options);

/// The same for a file, which nobody may write to meanwhile; one that starts as a gzip archive is inflated first.
/// Errors: also NC0001 not readable, NC0008 an archive that holds more than 64 GB, NC0009 a damaged one.
Result<program::Program> read_program_file(const std::filesystem::path& file, const ReadOptions& options);

/// The same part by part: each call of next() reads on until a part is complete, as PartSizes says, so that a program
/// of any length fits into some 32 MB (a part of 200 000 moves, and 2 MB of text). Joined the parts are what
/// read_program_file() gives, but for standstills that had to be made. Nothing runs between the calls; what was opened
/// may be dropped at any time. `options.machine` must stay.
///
/// A part ends only at a pose that is known whole: every coordinate, and every rotary axis of the machine whose letter
/// stands anywhere in the text (looked for once, where an axis is not known at the first end). At its end a part has
/// the events that stand before the rapid that opens the next one; the path control in force is said again in the next.
/// Rotary letters that a program begins to use behind moves of law vector come with the part that says them.
///
/// The file is mapped, and what was read is given back. A gzip archive is inflated when it is opened, about 3 s a GB,
/// into a temporary file without a name (in TMPDIR, else /tmp), since every dialect can jump back. What may grow beyond
/// a part: the labels of a program that jumps, a curve with all of its control points, what no part can end in.
/// Errors of next(): those of the text, behind the good parts before them; NC0021 a file that the program calls is the
/// first to say a rotary axis, behind the end of a part.
Result<std::unique_ptr<program::ProgramParts>> open_program_file(const std::filesystem::path& file,
                                                                 const ReadOptions& options);

}  // namespace trunnion::nc
