#include <algorithm>
#include <cmath>

#include "trunnion/nc/read.hpp"

#include "entries.hpp"

namespace trunnion::fuzz {

namespace {

/// C on A with one control's words; readers look at letters and words alone.
machine::Machine reading_machine() {
    machine::Machine machine;
    for (const char letter : std::string_view("XYZAC")) {
        machine::Axis& axis = machine.axes[static_cast<std::size_t>(machine.axis_count++)];
        axis.letter = letter;
        axis.rotary = machine.axis_count > 3;
    }
    machine.rotary_count = 2;
    machine.words = {.tcp_on = {"M428"}, .tcp_off = {"M429"}, .ignore = {"M64"}, .following = {"E"}};
    return machine;
}

void expect_sound(const program::Move& move, const program::Program& program) {
    expect(!move.position_mm.array().isInf().any(), "positions are finite or left as they are");
    expect(std::abs(move.axis.norm() - 1) < 1e-9, "tool axes are unit vectors");
    for (const double word : move.rotary_rad) expect(!std::isinf(word), "rotary words are finite or absent");
    expect(std::isfinite(move.feed.value) && move.feed.value >= 0, "feeds are finite and not negative");
    expect(move.tool < program.tools.size() && move.offset < program.offsets.size(), "tools and offsets are known");
    expect(move.arc == program::no_arc || (move.arc >= 0 && std::size_t(move.arc) < program.arcs.size()),
           "arcs are known");
    expect(move.curve_part == program::no_curve_part ||
               (move.curve_part >= 0 && std::size_t(move.curve_part) < program.curve_parts.size()),
           "parts of curves are known");
}

void expect_sound(const program::Curve& curve) {
    const std::size_t points = curve.position_mm.size();
    expect(curve.degree >= 1 && curve.degree <= 7, "degrees of curves are low");
    expect(curve.knots.size() == points + std::size_t(curve.degree) + 1, "knots and control points fit");
    expect(std::ranges::is_sorted(curve.knots), "knots do not fall");
    for (const std::size_t size : {curve.weights.size(), curve.axis.size(), curve.rotary_rad.size()})
        expect(size == 0 || size == points, "every control point is whole");
    for (const double knot : curve.knots) expect(std::isfinite(knot), "knots are finite");
    for (const double weight : curve.weights) expect(weight > 0 && std::isfinite(weight), "weights are positive");
    for (const auto& point : curve.position_mm) expect(point.allFinite(), "control points are finite");
    for (const auto& axis : curve.axis) expect(axis.allFinite(), "control vectors are finite");
}

void expect_sound(const program::Surface& surface) {
    const auto direction = [](int degree, const std::vector<double>& knots) {
        expect(degree >= 1 && degree <= 7, "degrees of surfaces are low");
        expect(std::ranges::is_sorted(knots), "knots of surfaces do not fall");
        return knots.size() - std::size_t(degree) - 1;
    };
    const std::size_t points =
        direction(surface.degree_u, surface.knots_u) * direction(surface.degree_v, surface.knots_v);
    expect(surface.position_mm.size() == points, "knots and control points of a surface fit");
    expect(surface.weights.empty() || surface.weights.size() == points, "weights of a surface are whole");
    for (const double weight : surface.weights) expect(weight > 0 && std::isfinite(weight), "weights are positive");
    for (const auto& point : surface.position_mm) expect(point.allFinite(), "control points are finite");
}

void expect_sound(const program::SurfaceJob& job, const program::Program& program) {
    expect(job.surface >= 0 && std::size_t(job.surface) < program.surfaces.size(), "surfaces are known");
    expect(job.before_move >= 1 && job.before_move <= program.moves.size(), "surfaces fall among the moves");
    expect(job.tool < program.tools.size() && job.offset < program.offsets.size(), "tools of surfaces are known");
    for (const double length : {job.scallop_mm, job.chord_tolerance_mm, job.lift_mm, job.retract_mm})
        expect(length > 0 && std::isfinite(length), "lengths of surfaces are positive");
    for (const double speed : {job.feed_mm_s, job.approach_mm_s})
        expect(speed >= 0 && std::isfinite(speed), "feeds of surfaces are finite");
    expect(job.reach_mm >= 0 && std::isfinite(job.reach_mm), "the reach of tools is finite");
    for (const std::int32_t other : job.others)
        expect(other >= 0 && std::size_t(other) < program.surfaces.size() && other != job.surface,
               "surfaces to keep out of are known, and others");
}

void expect_sound(const program::Program& program) {
    expect(program.moves.size() >= (program.surface_jobs.empty() ? 2 : 1), "a program that is read moves something");
    expect(program.moves.front().position_mm.allFinite(), "the first place is known whole");
    for (const program::Move& move : program.moves) expect_sound(move, program);
    for (const program::Arc& arc : program.arcs) {
        expect(arc.centre_mm.allFinite() && std::isfinite(arc.angle_rad), "arcs are finite");
        expect(std::abs(arc.normal.norm() - 1) < 1e-9, "normals of arcs are unit vectors");
    }
    for (const program::Curve& curve : program.curves) expect_sound(curve);
    for (const program::CurvePart& part : program.curve_parts) {
        expect(part.curve >= 0 && std::size_t(part.curve) < program.curves.size(), "curves are known");
        expect(part.from_u < part.to_u, "parts of curves have a length");
    }
    expect(program.following.size() == program.moves.size() * program.following_letters.size(),
           "every move has a row of following axes");
    for (const double at_mm : program.following) expect(std::isfinite(at_mm), "following axes are finite");
    for (const program::Surface& surface : program.surfaces) expect_sound(surface);
    for (const program::SurfaceJob& job : program.surface_jobs) expect_sound(job, program);
    expect(std::ranges::is_sorted(program.surface_jobs, {}, &program::SurfaceJob::before_move),
           "surfaces are in order");
    expect(std::ranges::is_sorted(program.events, {}, &program::Event::before_move), "events are in order");
    for (const program::Event& event : program.events) {
        expect(event.before_move <= program.moves.size(), "events fall among the moves");
        expect(std::isfinite(event.dwell_s) && event.dwell_s >= 0, "dwells are finite and not negative");
    }
}

}  // namespace

void take_program(std::string_view dialect, std::string_view bytes) {
    static const machine::Machine machine = reading_machine();
    nc::ReadOptions options;
    options.dialect = nc::dialect_named(dialect);
    if (!options.dialect) return;  // a dialect that is still to come
    options.machine = &machine;
    options.most_repeated_lines = 10'000;                  // endless loops are many, and each takes its time
    options.feed_given_elsewhere = bytes.size() % 2 == 0;  // both kinds of reading, and any file is a seed
    if (const auto recognised = nc::recognise(bytes); !recognised) expect_sound(recognised.error(), bytes);
    const auto program = nc::read_program(bytes, "fuzz", options);
    if (!program) return expect_sound(program.error(), bytes);
    expect_sound(*program);
    for (const Diagnostic& told : program->diagnostics) expect_sound(told, bytes);
}

}  // namespace trunnion::fuzz
