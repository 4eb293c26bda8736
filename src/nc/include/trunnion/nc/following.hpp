#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

#include "trunnion/program/program.hpp"

namespace trunnion::nc {

// Axes that go along without shaping the motion (Program::following_letters): extruders, wire. A move takes them from
// where the move before left them to its own row of Program::following, in proportion to its way. Between moves they
// go alone by events: the path stands for `dwell_s`, and `word` says how far, like `E-0.8`. What their control counts
// (M82, M83, G92 E0) are events too, which move nothing: rows are running totals.

/// The word of an event in which the axes with these letters go that far, mm, while the path stands: `E-0.8`. Those
/// that stay are left out. The numbers read back to the same double.
std::string following_word(std::span<const char> letters, std::span<const double> way_mm);

/// Whether `word` is made of these letters with their numbers alone: `E-0.8`, `E1 D2`. Then the numbers are added to
/// `sum`, of the same order as `letters`. May allocate.
bool add_following_word(std::span<const char> letters, std::string_view word, std::span<double> sum);

/// The same of an event of a program: how far it takes the following axes. False: it takes them nowhere.
bool add_following_travel(const program::Program& program, const program::Event& event, std::span<double> sum_mm);

/// How far the events before moves `first` to `last` take following axis `axis` (index in following_letters), mm.
/// Cost: logarithmic in the events, and linear in those. May allocate.
double following_standing(const program::Program& program, std::size_t first, std::size_t last, std::size_t axis);

/// Where it is at the end of a move, mm.
inline double following_at_end(const program::Program& program, std::size_t move, std::size_t axis) {
    return program.following[move * program.following_letters.size() + axis];
}

/// Where it is when a move begins, mm: where the move before left it, and behind the events between them; before the
/// first move it was at 0. Cost: that of following_standing().
double following_at_begin(const program::Program& program, std::size_t move, std::size_t axis);

}  // namespace trunnion::nc
