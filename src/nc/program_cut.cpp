#include "detail/program_cut.hpp"

#include <algorithm>
#include <utility>
#include <vector>

namespace trunnion::nc {

using program::Program;

namespace {

/// `part` takes the first ones with their storage, `whole` keeps the others.
template <class Element>
void cut(std::vector<Element>& whole, std::size_t at, std::vector<Element>& part) {
    std::vector<Element> behind(std::make_move_iterator(whole.begin() + static_cast<std::ptrdiff_t>(at)),
                                std::make_move_iterator(whole.end()));
    whole.resize(at);
    part = std::exchange(whole, std::move(behind));
}

/// The first of the indices that moves or parts of curves have, else `none`.
template <class Elements, class Index>
std::size_t first_index(const Elements& elements, Index index, std::size_t none) {
    for (const auto& element : elements)
        if (element.*index >= 0) return static_cast<std::size_t>(element.*index);
    return none;
}

template <class Elements, class Index>
void count_from(std::size_t first, Elements& elements, Index index) {
    for (auto& element : elements)
        if (element.*index >= 0) element.*index -= static_cast<std::int32_t>(first);
}

void cut_arcs(Program& program, Program& part) {
    const std::size_t first = first_index(program.moves, &program::Move::arc, program.arcs.size());
    cut(program.arcs, first, part.arcs);
    count_from(first, program.moves, &program::Move::arc);
}

void cut_curves(Program& program, Program& part) {
    const std::size_t first = first_index(program.moves, &program::Move::curve_part, program.curve_parts.size());
    cut(program.curve_parts, first, part.curve_parts);
    count_from(first, program.moves, &program::Move::curve_part);
    const std::size_t curve = first_index(program.curve_parts, &program::CurvePart::curve, program.curves.size());
    const bool in_both = !part.curve_parts.empty() && !program.curve_parts.empty() &&
                         static_cast<std::size_t>(part.curve_parts.back().curve) == curve;
    cut(program.curves, curve, part.curves);
    if (in_both) part.curves.push_back(program.curves.front());
    count_from(curve, program.curve_parts, &program::CurvePart::curve);
}

void cut_following(std::size_t last, Program& program, Program& part) {
    const std::size_t letters = program.following_letters.size();
    const std::vector<double> row(program.following.begin() + static_cast<std::ptrdiff_t>(last * letters),
                                  program.following.begin() + static_cast<std::ptrdiff_t>((last + 1) * letters));
    cut(program.following, (last + 1) * letters, part.following);
    program.following.insert(program.following.begin(), row.begin(), row.end());
}

/// How many of these come before the moves behind `last`.
template <class Elements>
std::size_t count_up_to(std::size_t last, const Elements& elements) {
    return static_cast<std::size_t>(
        std::ranges::find_if(elements, [&](const auto& element) { return element.before_move > last; }) -
        elements.begin());
}

void cut_events(std::size_t last, Program& program, Program& part) {
    cut(program.events, count_up_to(last + 1, program.events), part.events);
    for (program::Event& event : program.events) event.before_move -= last;
}

/// Surfaces stay where they are, as names do: indices of them count for the whole program.
void cut_surface_jobs(std::size_t last, Program& program, Program& part) {
    cut(program.surface_jobs, count_up_to(last, program.surface_jobs), part.surface_jobs);
    for (program::SurfaceJob& job : program.surface_jobs) job.before_move -= last;
    if (part.surface_jobs.empty())
        part.surfaces.clear();
    else
        part.surfaces = program.surfaces;
}

void cut_path_controls(std::size_t last, Program& program, Program& part) {
    cut(program.path_controls, count_up_to(last, program.path_controls), part.path_controls);
    for (program::PathControl& control : program.path_controls) control.before_move -= last;
    if (part.path_controls.empty()) return;
    program.path_controls.insert(program.path_controls.begin(), part.path_controls.back());
    program.path_controls.front().before_move = 0;
}

}  // namespace

void cut_behind(std::size_t last, Program& program, Program& part) {
    part.name = program.name;
    part.source = program.source;
    part.dialect = program.dialect;
    part.tools = program.tools;
    part.offsets = program.offsets;
    part.following_letters = program.following_letters;
    part.diagnostics.clear();
    cut(program.moves, last + 1, part.moves);
    cut_arcs(program, part);
    cut_curves(program, part);
    cut_following(last, program, part);
    cut_events(last, program, part);
    cut_path_controls(last, program, part);
    cut_surface_jobs(last, program, part);
    program::Move start = part.moves.back();
    start.arc = program::no_arc;
    start.curve_part = program::no_curve_part;
    program.moves.insert(program.moves.begin(), start);
}

}  // namespace trunnion::nc
