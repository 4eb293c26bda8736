#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "trunnion/base/result.hpp"
#include "trunnion/machine/machine.hpp"
#include "trunnion/nc/read.hpp"
#include "trunnion/program/program.hpp"

namespace trunnion::nc {

/// Takes the text in pieces of some 64 KB, in order.
using TextSink = std::function<void(std::string_view)>;

/// As what curves are written.
enum class CurveForm : std::uint8_t {
    own,      ///< what the dialect has and the curve fits into, see write_program(); else straight moves
    bspline,  ///< sinumerik: BSPLINE
    poly,     ///< sinumerik: POLY
    nurbs,    ///< fanuc: G06.2
    points    ///< straight moves within precision_mm
};

struct WriteOptions {
    Dialect dialect = Dialect::rs274;
    /// Largest errors of what is written: numbers have the fewest decimals that keep them, up to 12.
    double precision_mm = 5e-5;
    double precision_deg = 5e-7;
    double vector_precision = 5e-8;  ///< of a component of a tool vector
    double feed_precision = 1e-6;    ///< share of the feed
    Units units = Units::mm;         ///< mm or inch; none is taken as mm
    bool block_numbers = false;      ///< N10, N20 …; Klartext always has them
    /// Feeds as the time of the block (G93) wherever its length is known: rs274, sinumerik, fanuc. Without it only
    /// blocks that say their time have G93.
    bool inverse_time = false;
    CurveForm curves = CurveForm::own;
    std::vector<std::string> head;  ///< lines of comment at the beginning; characters outside ASCII become `?`
};

struct WriteSummary {
    std::size_t moves = 0;                ///< of the program
    std::size_t lines = 0;                ///< of the text
    std::vector<Diagnostic> diagnostics;  ///< what the dialect says otherwise or has no word for, each with its count
};

/// Writes a program in a dialect, so that read_program() gives the same moves: positions, orientations, orientation
/// laws, feeds, stops, events, tools and work offsets at their places, within the precision. What moves less than that
/// is left out. Coordinates that a move leaves open (NaN) are not said. Axes that go along: rs274.
///
/// Law vector: tool vectors in apt, sinumerik (A3 B3 C3), heidenhain (LN … TX TY TZ) and fanuc (G43.5, I J K); rs274
/// has none and takes such moves only where the tool stands along Z. Law rotary: rotary words in all but apt. The
/// pipeline turns one into the other (pipeline::translate).
/// Arcs stay arcs where the dialect has them: in planes XY, ZX, YZ; in sinumerik and apt in any. Others, and curves
/// where the dialect has none, are divided into straight moves within precision_mm (NC0910, told). A feed that the
/// dialect cannot say is written as the time of its block where it has G93, else as a speed, and told. An event
/// without a word in the dialect becomes a comment, and is told.
///
/// Curves stay curves, where nothing but their moves lies along them and feeds are not times:
/// - sinumerik: BSPLINE of a whole curve of degree 1 … 3 with clamped ends and weights up to 3; else POLY, a block for
///   each polynomial, up to degree 5, where weights bend X Y Z alone;
/// - fanuc: G06.2, degree 1 … 3, law rotary; a new one where the feed changes, at events and exact stops.
/// What does not fit is divided; where `curves` asks for one form it is refused (NC0909).
///
/// `machine`: its words for TCP, and whether it has rotary axes; may be null, then LinuxCNC's are taken.
/// Errors: NC0901 … NC0909, NC0920, listed in src/nc/README.md; the sink may have been called before.
/// Cost: below 1 µs a plain block; allocates nothing for it.
Result<WriteSummary> write_program(const program::Program& program, const machine::Machine* machine,
                                   const WriteOptions& options, const TextSink& sink);

/// The same into one string, for programs known to be short.
Result<std::string> write_text(const program::Program& program, const machine::Machine* machine,
                               const WriteOptions& options);

}  // namespace trunnion::nc
