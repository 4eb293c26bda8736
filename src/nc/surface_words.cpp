#include "detail/surface_words.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <vector>

#include <fmt/format.h>

#include "trunnion/base/quantity.hpp"
#include "trunnion/geometry/bspline_surface.hpp"

namespace trunnion::nc {

using program::Program;
using program::Surface;
using program::SurfaceJob;
using program::SurfaceStrategy;

namespace {

constexpr int highest_degree = 7, highest_number = 9999;
constexpr int most_along = 100'000;  ///< control points in one direction
constexpr double farthest_mm = 1e6;  ///< of a control point
constexpr double quarter_turn_deg = 90;

std::vector<double> uniform_knots(int degree, std::size_t points) {
    std::vector<double> knots(points + static_cast<std::size_t>(degree) + 1);
    const double inner = static_cast<double>(points) - degree;
    for (std::size_t i = 0; i < knots.size(); ++i) knots[i] = std::clamp(static_cast<double>(i) - degree, 0.0, inner);
    return knots;
}

/// As geometry has it, where its errors are found.
Result<geometry::BsplineSurface> geometry_of(const Surface& surface) {
    return geometry::BsplineSurface::make({surface.degree_u, surface.knots_u}, {surface.degree_v, surface.knots_v},
                                          surface.position_mm, surface.weights);
}

/// The control points of the polynomial whose coefficients stand in their place.
Result<void> make_net(Surface& surface) {
    auto net = geometry::polynomial_surface(surface.degree_u, surface.degree_v, surface.position_mm);
    if (!net) return fail(std::move(net.error()));
    surface.position_mm = net->control_points_mm();
    surface.knots_u = net->u().knots;
    surface.knots_v = net->v().knots;
    return {};
}

}  // namespace

// ---------------------------------------------------------------------------------------------------------- definition

bool SurfaceWords::open_net(const Block& block) {
    if (!only(block, "PIJKL")) return false;
    const auto degree_u = whole(block, 'I', 1, highest_degree, "NC0052", "a surface needs its degree along u");
    if (!degree_u) return false;
    const auto degree_v = whole(block, 'J', 1, highest_degree, "NC0052", "a surface needs its degree along v");
    if (!degree_v) return false;
    const auto rows =
        whole(block, 'K', *degree_u + 1, most_along, "NC0053", "a surface needs its control points along u");
    if (!rows) return false;
    const auto columns =
        whole(block, 'L', *degree_v + 1, most_along, "NC0053", "a surface needs its control points along v");
    if (!columns) return false;
    Open net{.rows = static_cast<std::size_t>(*rows), .columns = static_cast<std::size_t>(*columns)};
    net.surface.degree_u = *degree_u;
    net.surface.degree_v = *degree_v;
    return open(block, std::move(net));
}

bool SurfaceWords::open_polynomial(const Block& block) {
    if (!only(block, "PIJ")) return false;
    const auto degree_u = whole(block, 'I', 1, highest_degree, "NC0052", "a surface needs its degree along u");
    if (!degree_u) return false;
    const auto degree_v = whole(block, 'J', 1, highest_degree, "NC0052", "a surface needs its degree along v");
    if (!degree_v) return false;
    Open polynomial{.polynomial = true,
                    .rows = static_cast<std::size_t>(*degree_u) + 1,
                    .columns = static_cast<std::size_t>(*degree_v) + 1};
    polynomial.surface.degree_u = *degree_u;
    polynomial.surface.degree_v = *degree_v;
    return open(block, std::move(polynomial));
}

bool SurfaceWords::open(const Block& block, Open open) {
    const auto number = whole(block, 'P', 1, highest_number, "NC0051", "a surface needs its number");
    if (!number) return false;
    if (open.size() > most_points - points_)
        return refuse("NC0054", word(block), "more control points than are read, of all surfaces together",
                      fmt::format("{}", points_ + open.size()), fmt::format("at most {}", most_points));
    points_ += open.size();
    open.number = *number;
    open.spot = word(block);
    open.file = open.spot.file;
    open_ = std::move(open);
    return true;
}

bool SurfaceWords::datum(const Block& block, double unit_mm) {
    return block.has('I') || block.has('J') ? knots(block) : point(block, unit_mm);
}

bool SurfaceWords::point(const Block& block, double unit_mm) {
    if (!only(block, open_->polynomial ? "XYZ" : "XYZR")) return false;
    const char* what = open_->polynomial ? "coefficient" : "control point";
    std::vector<Eigen::Vector3d>& points = open_->surface.position_mm;
    if (points.size() == open_->size())
        return refuse("NC0053", block.at(1), fmt::format("one {} too many", what), fmt::format("{}", points.size() + 1),
                      "G322 behind the last one");
    Eigen::Vector3d at_mm;
    for (int i = 0; i < 3; ++i) {
        const char letter = "XYZ"[i];
        if (!block.has(letter))
            return refuse("NC0055", block.at(1), fmt::format("a {} needs X, Y and Z", what), {&letter, 1});
        at_mm[i] = block[letter] * unit_mm;
        if (!(std::abs(at_mm[i]) <= farthest_mm))
            return refuse("NC0055", block.spot(letter), fmt::format("a {} that is farther than a kilometre", what),
                          fmt::format("{}{}", letter, block[letter]));
    }
    points.push_back(at_mm);
    return weight(block);
}

bool SurfaceWords::weight(const Block& block) {
    const double weight = block.has('R') ? block['R'] : 1;
    constexpr double least = 1e-6, most = 1e6;
    if (!(weight >= least && weight <= most))
        return refuse("NC0056", block.spot('R'), "a weight lies between a millionth and a million",
                      fmt::format("R{}", weight));
    open_->surface.weights.push_back(weight);
    return true;
}

bool SurfaceWords::knots(const Block& block) {
    if (!only(block, "IJ")) return false;
    if (open_->polynomial)
        return refuse("NC0057", block.at(1), "a polynomial has no knots", {}, "G320 is a surface with knots");
    Surface& surface = open_->surface;
    const std::size_t along_u = open_->rows + static_cast<std::size_t>(surface.degree_u) + 1;
    const std::size_t along_v = open_->columns + static_cast<std::size_t>(surface.degree_v) + 1;
    return knot(block, 'I', along_u, surface.knots_u) && knot(block, 'J', along_v, surface.knots_v);
}

bool SurfaceWords::knot(const Block& block, char letter, std::size_t most, std::vector<double>& knots) {
    if (!block.has(letter)) return true;
    const double value = block[letter];
    constexpr double largest = 1e9;
    if (!(std::abs(value) <= largest))
        return refuse("NC0057", block.spot(letter), "a knot is too large", fmt::format("{}{}", letter, value));
    if (!knots.empty() && value < knots.back())
        return refuse("NC0057", block.spot(letter), "a knot below the one before", fmt::format("{}{}", letter, value),
                      "knots never fall");
    if (knots.size() == most)
        return refuse("NC0057", block.spot(letter), "one knot too many", fmt::format("{}{}", letter, value),
                      fmt::format("control points + degree + 1 = {}", most));
    knots.push_back(value);
    return true;
}

bool SurfaceWords::close(const Block& block) {
    if (!is_open()) return refuse("NC0059", word(block), "G322 ends a surface that G320 or G321 began", "G322");
    if (!only(block, "") || !complete(block)) return false;
    Surface& surface = open_->surface;
    if (std::ranges::all_of(surface.weights, [](double weight) { return weight == 1; })) surface.weights.clear();
    if (surface.knots_u.empty()) surface.knots_u = uniform_knots(surface.degree_u, open_->rows);
    if (surface.knots_v.empty()) surface.knots_v = uniform_knots(surface.degree_v, open_->columns);
    Result<void> made{};
    if (open_->polynomial)
        made = make_net(surface);
    else if (auto net = geometry_of(surface); !net)
        made = fail(std::move(net.error()));
    if (!made) return refuse("NC0057", word(block), "no surface: " + made.error().text, made.error().value);
    definitions_.insert_or_assign(open_->number, Definition{std::move(surface)});
    open_.reset();
    return true;
}

/// Whether all control points are there, and the knots of each direction all or none.
bool SurfaceWords::complete(const Block& block) {
    const Surface& surface = open_->surface;
    if (surface.position_mm.size() < open_->size())
        return refuse("NC0058", word(block),
                      fmt::format("{} are missing", open_->polynomial ? "coefficients" : "control points"),
                      fmt::format("{} of {} × {}", surface.position_mm.size(), open_->rows, open_->columns));
    const auto none_or_all = [&](const std::vector<double>& knots, std::size_t points, int degree, const char* where) {
        const std::size_t all = points + static_cast<std::size_t>(degree) + 1;
        return knots.empty() || knots.size() == all ||
               refuse("NC0057", word(block), fmt::format("knots along {} are missing", where),
                      fmt::format("{}", knots.size()), fmt::format("control points + degree + 1 = {}, or none", all));
    };
    return none_or_all(surface.knots_u, open_->rows, surface.degree_u, "u (I)") &&
           none_or_all(surface.knots_v, open_->columns, surface.degree_v, "v (J)");
}

bool SurfaceWords::finish() {
    if (!is_open()) return true;
    return refuse("NC0059", {open_->spot.line, open_->spot.column, open_->file}, "a surface that G322 does not end");
}

// ----------------------------------------------------------------------------------------------------------- machining

bool SurfaceWords::conditions(const Block& block, double unit_mm) {
    SurfaceJob& now = conditions_;
    if (!only(block, "DHJKLPQR") || !freeing(block, unit_mm) || !length(block, 'D', unit_mm, now.chord_tolerance_mm) ||
        !length(block, 'H', unit_mm, now.retract_mm) || !length(block, 'K', unit_mm, now.lift_mm) ||
        !choice(block, 'L', 1, 2, now.zigzag) || !choice(block, 'Q', 1, 0, now.borders))
        return false;
    if (!(now.lift_mm < now.retract_mm))
        return refuse("NC0063", word(block), "the lift between passes (K) is as high as the retract level (H)",
                      fmt::format("K {:g} mm, H {:g} mm", now.lift_mm, now.retract_mm));
    if (!block.has('R')) return true;
    now.approach_mm_s = block['R'] * unit_mm / 60;
    return (block['R'] >= 0 && std::isfinite(now.approach_mm_s)) ||
           refuse("NC0063", block.spot('R'), "the feed down to the surface is not negative",
                  fmt::format("R{}", block['R']), "R0: as F");
}

/// P: whether passes are freed of gouges; J: the tool's reach for that.
bool SurfaceWords::freeing(const Block& block, double unit_mm) {
    if (!choice(block, 'P', 1, 0, conditions_.free_of_gouges)) return false;
    if (!block.has('J')) return true;
    if (!conditions_.free_of_gouges)
        return refuse("NC0063", block.spot('J'), "the tool's reach has no use where gouges are not freed",
                      fmt::format("J{}", block['J']), "P1 frees passes of gouges");
    return length(block, 'J', unit_mm, conditions_.reach_mm);
}

bool SurfaceWords::job(const Block& block, double unit_mm, const Eigen::Vector3d& shift_mm, program::Program& program,
                       SurfaceJob& job) {
    if (!only(block, "FSTHPRQIJKL")) return false;
    const auto number = whole(block, 'P', 1, highest_number, "NC0051", "machining needs the number of its surface");
    if (!number) return false;
    const auto found = definitions_.find(*number);
    if (found == definitions_.end())
        return refuse("NC0060", block.spot('P'), "no such surface is defined before", fmt::format("P{}", *number),
                      "G320 or G321 defines it");
    if (jobs_ == most_jobs)
        return refuse("NC0054", word(block), "more machining blocks than are read", fmt::format("{}", jobs_ + 1),
                      fmt::format("at most {}", most_jobs));
    job = conditions_;
    job.scallop_mm = block.has('R') ? block['R'] * unit_mm : 0;
    if (!(job.scallop_mm > 0 && std::isfinite(job.scallop_mm)))
        return refuse("NC0061", block.has('R') ? block.spot('R') : word(block),
                      "machining needs the height that ridges may have, above 0",
                      block.has('R') ? fmt::format("R{}", block['R']) : "", "G324 P1 R0.01");
    bool along = true;
    if (!strategy(block, job) || !angle(block, 'J', quarter_turn_deg, job.lead_rad) ||
        !angle(block, 'K', quarter_turn_deg, job.tilt_rad) || !choice(block, 'L', 1, -1, along))
        return false;
    job.normal_against = !along;
    if (!place(block, found->second, shift_mm, program)) return false;
    job.surface = found->second.index;
    ++jobs_;
    return !job.free_of_gouges || place_others(block, *number, shift_mm, program, job);
}

/// The other surfaces that are defined so far: what the tool must not go into.
bool SurfaceWords::place_others(const Block& block, int machined, const Eigen::Vector3d& shift_mm, Program& program,
                                SurfaceJob& job) {
    others_ += definitions_.size() - 1;
    if (others_ > most_others)
        return refuse("NC0054", word(block), "more surfaces to keep out of than are read, of all blocks together",
                      fmt::format("{}", others_), fmt::format("at most {}", most_others));
    for (auto& [number, definition] : definitions_) {
        if (number == machined) continue;
        if (!place(block, definition, shift_mm, program)) return false;
        job.others.push_back(definition.index);
    }
    return true;
}

/// Q, and I where the strategy has a direction.
bool SurfaceWords::strategy(const Block& block, SurfaceJob& job) {
    constexpr SurfaceStrategy strategies[] = {SurfaceStrategy::constant_scallop, SurfaceStrategy::along_u,
                                              SurfaceStrategy::along_v, SurfaceStrategy::parallel_planes,
                                              SurfaceStrategy::lin_koren};
    if (block.has('Q')) {
        const auto number = whole(block, 'Q', 1, static_cast<int>(std::size(strategies)), "NC0062", "a strategy");
        if (!number) return false;
        job.strategy = strategies[*number - 1];
    }
    const bool directed =
        job.strategy == SurfaceStrategy::constant_scallop || job.strategy == SurfaceStrategy::parallel_planes;
    if (block.has('I') && !directed)
        return refuse("NC0062", block.spot('I'), "passes along the surface's own directions have no feed angle", "I",
                      "Q1 and Q4 have one");
    return angle(block, 'I', 4 * quarter_turn_deg, job.feed_angle_rad);
}

/// The surface as this block machines it: in the program once, unless it is machined elsewhere.
bool SurfaceWords::place(const Block& block, Definition& definition, const Eigen::Vector3d& shift_mm,
                         program::Program& program) {
    if (definition.index >= 0 && definition.shift_mm == shift_mm) return true;
    Surface surface = definition.surface;
    for (Eigen::Vector3d& point : surface.position_mm) point += shift_mm;
    if (!shift_mm.isZero(0)) {
        if (!std::ranges::all_of(surface.position_mm, [](const auto& p) { return p.norm() <= 4 * farthest_mm; }))
            return refuse("NC0055", word(block), "a control point that is farther than a kilometre");
        if (surface.position_mm.size() > most_points - points_)
            return refuse("NC0054", word(block), "more control points than are read, of all surfaces together",
                          fmt::format("at most {}", most_points), "fewer places where G92 or G52 shifts a surface to");
        points_ += surface.position_mm.size();
    }
    definition.index = static_cast<std::int32_t>(program.surfaces.size());
    definition.shift_mm = shift_mm;
    program.surfaces.push_back(std::move(surface));
    return true;
}

// ------------------------------------------------------------------------------------------------------------- letters

/// Whether the block has no other letters.
bool SurfaceWords::only(const Block& block, std::string_view letters) {
    for (std::uint32_t present = block.present; present != 0; present &= present - 1) {
        const char letter = static_cast<char>('A' + std::countr_zero(present));
        if (!letters.contains(letter))
            return refuse("NC0050", block.spot(letter), "the letter has no use in this block of a surface",
                          {&letter, 1});
    }
    return true;
}

std::optional<int> SurfaceWords::whole(const Block& block, char letter, int least, int most, std::string_view code,
                                       const std::string& what) {
    const double value = block.has(letter) ? block[letter] : 0;
    if (block.has(letter) && value == std::floor(value) && value >= least && value <= most)
        return static_cast<int>(value);
    refuse(code, block.has(letter) ? block.spot(letter) : word(block), what,
           block.has(letter) ? fmt::format("{}{}", letter, value) : "",
           fmt::format("{} is a whole number from {} to {}", letter, least, most));
    return {};
}

bool SurfaceWords::length(const Block& block, char letter, double unit_mm, double& length_mm) {
    if (!block.has(letter)) return true;
    length_mm = block[letter] * unit_mm;
    return (length_mm > 0 && std::isfinite(length_mm)) ||
           refuse("NC0063", block.spot(letter), "a length above 0 is needed here",
                  fmt::format("{}{}", letter, block[letter]));
}

bool SurfaceWords::choice(const Block& block, char letter, int first, int second, bool& is_first) {
    if (!block.has(letter)) return true;
    is_first = block[letter] == first;
    return is_first || block[letter] == second ||
           refuse("NC0063", block.spot(letter), fmt::format("{} is {} or {}", letter, first, second),
                  fmt::format("{}{}", letter, block[letter]));
}

bool SurfaceWords::angle(const Block& block, char letter, double most_deg, double& angle_rad) {
    if (!block.has(letter)) return true;
    angle_rad = block[letter] * degree;
    return std::abs(block[letter]) < most_deg ||
           refuse("NC0062", block.spot(letter), "the angle is out of its range",
                  fmt::format("{}{}", letter, block[letter]), fmt::format("below {}° either way", most_deg));
}

}  // namespace trunnion::nc
