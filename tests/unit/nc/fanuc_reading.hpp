#pragma once

#include <string>
#include <string_view>

#include "trunnion/base/quantity.hpp"

#include "reading.hpp"

namespace trunnion::nc {

/// A machine with a table C on a tilting B, chain C B X Y Z.
inline machine::Machine fanuc_machine() {
    machine::Machine machine = machine_with("BC");
    machine.words = {};
    machine.chain = {4, 3, 0, 1, 2};
    for (std::size_t i = 0; i < 3; ++i) machine.axes[i].direction = Eigen::Vector3d::Unit(static_cast<int>(i));
    machine.axes[3].direction = Eigen::Vector3d::UnitY();
    machine.axes[4].direction = Eigen::Vector3d::UnitZ();
    return machine;
}

inline Result<program::Program> read_fanuc_text(std::string_view text, ReadOptions options = {}) {
    static const machine::Machine machine = fanuc_machine();
    options.dialect = Dialect::fanuc;
    return read_with(machine, text, options);
}

/// Behind a start that is known whole, at X0 Y0 Z50 B0 C0, with tool 8 and its length.
inline Result<program::Program> read_fanuc_after_start(std::string_view text) {
    return read_fanuc_text("%\nO1\nG21 G90 G94 G17\nT8 M6\nG0 X0 Y0 B0 C0\nG43 H8 Z50.\nF600\n" + std::string(text) +
                           "\nM30\n%\n");
}

inline Eigen::Vector3d end_of(const program::Program& program) {
    return program.moves.back().position_mm;
}

}  // namespace trunnion::nc
