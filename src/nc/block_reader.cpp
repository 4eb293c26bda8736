#include "detail/block_reader.hpp"

#include <algorithm>
#include <utility>

#include "detail/program_cut.hpp"

namespace trunnion::nc {

using program::Move;
using program::Program;

BlockReader::BlockReader(std::string_view file_name, const ReadOptions& options, Dialect dialect)
    : findings_(file_name), options_(options) {
    program_.source = file_name;
    program_.name = std::filesystem::path(file_name).stem().string();
    program_.dialect = name_of(dialect);
}

bool BlockReader::is_moved_in(std::uint16_t offset) const {
    return (offset < offsets_moved_in_.size() && offsets_moved_in_[offset]) ||
           std::ranges::find(program_.moves, offset, &Move::offset) != program_.moves.end();
}

void BlockReader::give_out(std::size_t last, Program& part) {
    if (!first_move_) first_move_ = program_.moves.front();
    offsets_moved_in_.resize(program_.offsets.size());
    for (std::size_t i = 0; i <= last; ++i) offsets_moved_in_[program_.moves[i].offset] = true;
    cut_behind(last, program_, part);
    take_used_letters(part);
}

void BlockReader::give_out_rest(Program& part) {
    part = std::move(program_);
    take_used_letters(part);
    part.diagnostics = findings_.take_notices();
}

void BlockReader::reuse(Program& part, std::size_t moves) {
    part.moves.assign(program_.moves.begin(), program_.moves.end());
    part.moves.reserve(moves);
    program_.moves.swap(part.moves);
}

/// The rotary words of the axes that the program has used so far, in the place of those of all axes.
void BlockReader::take_used_letters(Program& part) {
    for (std::size_t axis = 0; axis < program::max_rotary_letters; ++axis)
        if (is_said(axis) && std::ranges::find(used_axes_, axis) == used_axes_.end()) used_axes_.push_back(axis);
    part.rotary_letters.clear();
    for (const std::size_t axis : used_axes_) part.rotary_letters.push_back(rotary_letter(axis));
    const auto used = [&](std::array<double, program::max_rotary_letters>& words) {
        const auto all = std::exchange(words, {});
        for (std::size_t i = 0; i < used_axes_.size(); ++i) words[i] = all[used_axes_[i]];
    };
    for (Move& move : part.moves)
        if (move.law == program::OrientationLaw::rotary) used(move.rotary_rad);
    for (program::Curve& curve : part.curves)
        for (auto& words : curve.rotary_rad) used(words);
}

}  // namespace trunnion::nc
