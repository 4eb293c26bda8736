#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "detail/coordinates.hpp"

namespace trunnion::smoothing {

/// The sum of many bumps Δ·share·w·g((p − p_j)/w), each of its own width, at the cost of a few of them.
///
/// Either half of a bump is one polynomial of degree 8. Blocks are taken in groups, groups in pairs, those in pairs and
/// so on; the largest of these cells that a half covers whole carry its polynomial about their own middle, so that no
/// digits are lost. Near its vertex and its ends a bump is summed by itself.
template <class Kernel>
class BumpField {
  public:
    /// `position` of the vertices, `jump` Δ: kept by the caller as long as the field.
    BumpField() = default;
    BumpField(std::span<const long double> position, std::span<const Coordinates> jump);

    /// Takes in what has changed. p_j + width and p_j − width must rise with j.
    void update(std::span<const double> share, std::span<const double> width);

    /// How many bumps the cells about a block stand for.
    std::size_t halves_over(std::size_t block) const;

    /// Adds the sum and its derivatives by p up to `orders` − 1 at `offset_mm` behind vertex `block`.
    template <std::size_t orders>
    void add(std::size_t block, double offset_mm, std::array<Coordinates, orders>& sum) const;

  private:
    struct Bump {
        double share = 0, width = 0;
        std::int32_t left = 0, right = 0;  // groups in which it begins and ends
        bool operator==(const Bump&) const = default;
    };
    struct Cell {
        std::size_t halves = 0;  // bumps' halves that came and went
        std::array<Coordinates, 9> coefficient;
    };

    std::size_t groups() const { return (position_.size() + group - 2) / group; }
    std::size_t group_of(std::size_t block) const { return std::min(block / group, groups() - 1); }
    std::size_t vertex_of(std::size_t group_index) const;
    void put(std::size_t vertex, const Bump& bump, double sign);
    void put_half(std::size_t vertex, const Bump& bump, double sign, std::size_t first, std::size_t behind, bool right);
    void put_in_cell(std::size_t cell, std::size_t first, std::size_t behind, std::size_t vertex, const Bump& bump,
                     double sign, bool right);
    template <std::size_t orders>
    void add_cells(std::size_t at_group, long double at, std::array<Coordinates, orders>& sum) const;

    static constexpr std::size_t group = 8;  // blocks

    std::span<const long double> position_;
    std::span<const Coordinates> jump_;
    std::vector<Bump> bumps_;
    std::vector<std::size_t> first_ending_, first_beginning_;  // vertex, by group and one behind
    std::size_t leaves_ = 1;                                   // cell `leaves_ + g` is group g, cell c/2 holds cell c
    std::vector<Cell> cells_;
};

}  // namespace trunnion::smoothing
