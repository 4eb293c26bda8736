#pragma once

#include <cmath>
#include <string>
#include <string_view>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "trunnion/base/quantity.hpp"

#include "reading.hpp"

namespace trunnion::nc {

/// On a machine with X, Y, Z, B and C.
inline Result<program::Program> read_bc(std::string_view text, ReadOptions options = {}) {
    static const machine::Machine machine = machine_with("BC");
    options.dialect = Dialect::sinumerik;
    return read_with(machine, text, options);
}

inline std::string number(double value) {
    return std::isnan(value) ? "-" : fmt::format("{:.6g}", std::abs(value) < 1e-9 ? 0 : value);
}

inline std::string triple(const Eigen::Vector3d& v) {
    return number(v.x()) + ' ' + number(v.y()) + ' ' + number(v.z());
}

/// As `R w 1 2 - B90 C-`: rapid or feed, workpiece, machine or untransformed, X Y Z, then the rotary words in degrees
/// or the vector, then an arc's angle in degrees, centre and normal; `-` for what stays where it stands.
inline std::string transcript(const program::Program& program, const program::Move& move) {
    std::string line = move.kind == program::MoveKind::rapid ? "R " : "F ";
    line += "wmu"[static_cast<std::size_t>(move.space)];
    line += ' ' + triple(move.position_mm);
    if (move.law == program::OrientationLaw::vector) line += " <" + triple(move.axis) + '>';
    for (std::size_t i = 0; i < program.rotary_letters.size() && move.law == program::OrientationLaw::rotary; ++i)
        line += fmt::format(" {}{}", program.rotary_letters[i], number(move.rotary_rad[i] / degree));
    if (move.arc == program::no_arc) return line;
    const program::Arc& arc = program.arcs.at(static_cast<std::size_t>(move.arc));
    return line +
           fmt::format(" arc {} ({}) ({})", number(arc.angle_rad / degree), triple(arc.centre_mm), triple(arc.normal));
}

/// All moves from the second on, a line each; or the error.
inline std::string moves_of(const Result<program::Program>& p, std::size_t first = 1) {
    if (!p) return said(p);
    std::string lines;
    for (std::size_t i = first; i < p->moves.size(); ++i) lines += transcript(*p, p->moves[i]) + '\n';
    return lines;
}

/// Of blocks that start at X0 Y0 Z0 with F600, TCP off; millimetres.
inline std::string moves_after_start(std::string_view blocks) {
    return moves_of(read_bc(std::string("G71 G90 G64 G0 X0 Y0 Z0\nG1 F600\n").append(blocks).append("\n")));
}

/// The same under TRAORI with B and C at 0.
inline std::string moves_under_traori(std::string_view blocks) {
    return moves_of(
        read_bc(std::string("G71 G90 G64 TRAORI\nG0 X0 Y0 Z0 B0 C0\nG1 F600\n").append(blocks).append("\n")));
}

}  // namespace trunnion::nc
