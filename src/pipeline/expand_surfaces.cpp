#include "trunnion/pipeline/expand_surfaces.hpp"

#include <algorithm>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "trunnion/base/quantity.hpp"
#include "trunnion/pipeline/surface.hpp"
#include "trunnion/surfacing/plan_surface.hpp"

namespace trunnion::pipeline {

namespace {

using program::Move;
using program::Program;
using program::SurfaceJob;

surfacing::Strategy strategy_of(program::SurfaceStrategy strategy) {
    switch (strategy) {
        case program::SurfaceStrategy::constant_scallop:
            return surfacing::Strategy::constant_scallop;
        case program::SurfaceStrategy::along_u:
            return surfacing::Strategy::along_u;
        case program::SurfaceStrategy::along_v:
            return surfacing::Strategy::along_v;
        case program::SurfaceStrategy::parallel_planes:
            return surfacing::Strategy::parallel_planes;
        case program::SurfaceStrategy::lin_koren:
            break;
    }
    return surfacing::Strategy::lin_koren;
}

constexpr double any_feed_mm_s = 1;    ///< for planning where the feed is not known
constexpr double gouge_in_chords = 2;  ///< depth that is no gouge, in chord tolerances

surfacing::SurfaceOptions options_of(const SurfaceJob& job) {
    surfacing::SurfaceOptions options;
    options.strategy = strategy_of(job.strategy);
    options.scallop_mm = job.scallop_mm;
    options.chord_tolerance_mm = job.chord_tolerance_mm;
    options.feed_angle_rad = job.feed_angle_rad;
    options.lead_rad = job.lead_rad;
    options.tilt_rad = job.tilt_rad;
    options.zigzag = job.zigzag;
    options.borders = job.borders;
    options.lift_mm = job.lift_mm;
    options.retract_mm = job.retract_mm;
    options.feed_mm_s = job.feed_mm_s > 0 ? job.feed_mm_s : any_feed_mm_s;
    options.approach_mm_s = job.approach_mm_s > 0 ? job.approach_mm_s : options.feed_mm_s;
    return options;
}

Result<surfacing::Face> face_of(const program::Surface& surface, bool normal_against) {
    auto made = geometry::BsplineSurface::make({surface.degree_u, surface.knots_u}, {surface.degree_v, surface.knots_v},
                                               surface.position_mm, surface.weights);
    if (!made) return fail(std::move(made.error()));
    return surfacing::whole_face(std::move(*made), normal_against ? geometry::Side::against : geometry::Side::along);
}

Result<surfacing::Cutter> cutter_of(const std::string& name, const machine::Setup& setup, double reach_mm) {
    const machine::Tool* tool = name.empty() ? &setup.tool : setup.tool_named(name);
    if (tool) return surfacing::Cutter::make(*tool, reach_mm);
    return fail({.code = "PIPE0120",
                 .text = "the setup has no such tool to machine a surface with",
                 .value = name,
                 .hint = "[tools." + name + "] in the setup file"});
}

/// Puts moves among those of a program, and what stands between the moves in its place.
class Splicing {
  public:
    explicit Splicing(Program program) : program_(std::move(program)), old_(std::exchange(program_.moves, {})) {
        old_rows_ = std::exchange(program_.following, {});
    }

    void insert(const std::vector<Move>& moves, const SurfaceJob& job) {
        take_up_to(job.before_move);
        shift_events(events_before(job.before_move));
        shift_controls(job.before_move);
        for (const Move& move : moves) append(move, job);
        inserted_ += moves.size();
    }

    Program finished() {
        take_up_to(old_.size());
        shift_events(program_.events.size());
        shift_controls(old_.size());
        std::erase_if(program_.events, names_a_job);
        program_.surfaces.clear();
        program_.surface_jobs.clear();
        return std::move(program_);
    }

  private:
    static bool names_a_job(const program::Event& event) {
        return event.kind == program::EventKind::other && event.word.starts_with("G324 ");
    }

    void take_up_to(std::size_t end) {
        const auto from = old_.begin() + static_cast<std::ptrdiff_t>(taken_);
        program_.moves.insert(program_.moves.end(), from, old_.begin() + static_cast<std::ptrdiff_t>(end));
        const std::size_t letters = program_.following_letters.size();
        const auto row = [&](std::size_t i) { return old_rows_.begin() + static_cast<std::ptrdiff_t>(i * letters); };
        program_.following.insert(program_.following.end(), row(taken_), row(end));
        taken_ = end;
    }

    void append(Move move, const SurfaceJob& job) {
        move.tool = job.tool;
        move.offset = job.offset;
        move.line = job.line;
        if (move.kind == program::MoveKind::feed && job.feed_mm_s == 0) move.feed.value = 0;
        program_.moves.push_back(move);
        add_standing_row();
    }

    void add_standing_row() {
        const std::size_t letters = program_.following_letters.size();
        const std::size_t rows = program_.following.size();
        for (std::size_t i = 0; i < letters; ++i)
            program_.following.push_back(rows == 0 ? 0.0 : program_.following[rows - letters + i]);
    }

    /// Up to which event they stand before the job at this move.
    std::size_t events_before(std::size_t move) const {
        for (std::size_t i = shifted_events_; i < program_.events.size(); ++i) {
            const program::Event& event = program_.events[i];
            if (event.before_move > move) return i;
            if (event.before_move == move && names_a_job(event)) return i + 1;
        }
        return program_.events.size();
    }

    void shift_events(std::size_t end) {
        for (; shifted_events_ < end; ++shifted_events_) program_.events[shifted_events_].before_move += inserted_;
    }

    void shift_controls(std::size_t move) {
        auto& controls = program_.path_controls;
        for (; shifted_controls_ < controls.size() && controls[shifted_controls_].before_move <= move;
             ++shifted_controls_)
            controls[shifted_controls_].before_move += inserted_;
    }

    Program program_;
    std::vector<Move> old_;
    std::vector<double> old_rows_;
    std::size_t taken_ = 0, inserted_ = 0, shifted_events_ = 0, shifted_controls_ = 0;
};

/// What the simulation says of passes that were turned, where they are not as asked for.
std::optional<Diagnostic> verdict_of(const SurfaceCheck& check, const SurfaceProgramOptions& options) {
    constexpr double um = 1000;
    const surfacing::SurfaceVerdict& verdict = check.verdict;
    if (check.ridges_hold && check.surface_holds && !check.in_part) return std::nullopt;
    Diagnostic out{.code = "PIPE0123", .severity = Severity::warning};
    if (check.surface_holds && !check.in_part) {
        out.text = "leaning out of gouges, passes leave more than the ridges asked for";
        out.value = fmt::format("{:.4g} um", um * std::max(verdict.highest_mm, verdict.largest_ridge_mm));
        out.limit = fmt::format("{:.4g} um", um * options.passes.scallop_mm);
        out.hint = "a lower R, another lead or tilt, or a ball, whose ridges do not change";
        return out;
    }
    out.severity = Severity::error;
    out.text = "passes that were freed of gouges still go into the surfaces";
    out.value = fmt::format("{:.4g} mm", check.in_part ? check.in_part->depth_mm : verdict.deepest_mm);
    out.limit = fmt::format("{:.4g} mm", options.passes.gouge_tolerance_mm);
    return out;
}

Diagnostic lean_told(const FreedAccount& freed) {
    return {.code = "PIPE0124",
            .severity = Severity::note,
            .text = "passes lean away from what they would go into",
            .value = fmt::format("{:.3g} mm deep, turned by {:.3g} deg", freed.worst->depth_mm,
                                 freed.largest_turn_rad / degree),
            .count = static_cast<int>(freed.passes_turned)};
}

/// Passes whose tool leans out of the surfaces of the program. Leaning changes the ridges of tools that are no balls:
/// they are simulated.
Result<surfacing::SurfacePlan> freed_plan_of(const SurfaceJob& job, const Program& program, const surfacing::Face& face,
                                             const surfacing::Cutter& cutter) {
    SurfaceProgramOptions options{.passes = options_of(job), .freeing = lean_limits(cutter, job.lead_rad)};
    options.passes.gouge_tolerance_mm = gouge_in_chords * job.chord_tolerance_mm;
    std::vector<surfacing::Face> part{face};
    for (const std::int32_t other : job.others) {
        auto beside = face_of(program.surfaces[static_cast<std::size_t>(other)], false);
        if (!beside) return fail(std::move(beside.error()));
        part.push_back(std::move(*beside));
    }
    options.others.assign(part.begin() + 1, part.end());
    auto made = make_surface_program({&face, 1}, cutter, options);
    if (!made) return fail(std::move(made.error()));
    if (made->freed->passes_turned == 0) return std::move(made->plan);
    const auto check = check_surface_program({&face, 1}, part, cutter, *made, options.passes);
    if (!check) return fail(check.error());
    auto& told = made->plan.program.diagnostics;
    told.push_back(lean_told(*made->freed));
    if (auto verdict = verdict_of(*check, options)) {
        if (verdict->severity == Severity::error) return fail(std::move(*verdict));
        told.push_back(std::move(*verdict));
    }
    return std::move(made->plan);
}

Result<surfacing::SurfacePlan> plan_of(const SurfaceJob& job, const Program& program, const machine::Setup& setup) {
    const auto face = face_of(program.surfaces[static_cast<std::size_t>(job.surface)], job.normal_against);
    if (!face) return fail(face.error());
    const auto cutter = cutter_of(program.tools[job.tool], setup, job.free_of_gouges ? job.reach_mm : 0);
    if (!cutter) return fail(cutter.error());
    if (job.free_of_gouges) return freed_plan_of(job, program, *face, *cutter);
    return surfacing::plan_surface(*face, *cutter, options_of(job));
}

/// Each once, with its first place and how often.
void tell(Diagnostic one, std::vector<Diagnostic>& told) {
    const auto same = std::ranges::find(told, one.code, &Diagnostic::code);
    if (same == told.end())
        told.push_back(std::move(one));
    else
        same->count += one.count;
}

class ExpandedParts final : public program::ProgramParts {
  public:
    ExpandedParts(std::unique_ptr<program::ProgramParts> parts, const machine::Setup& setup)
        : parts_(std::move(parts)), setup_(setup) {}

    Result<bool> next(Program& part) override {
        auto more = parts_->next(part);
        if (!more || !*more) return more;
        std::vector<Diagnostic> of_reading = std::exchange(part.diagnostics, {});
        if (!part.surface_jobs.empty()) {
            auto expanded = expand_surfaces(std::move(part), setup_);
            if (!expanded) return fail(std::move(expanded.error()));
            part = std::move(*expanded);
        }
        for (Diagnostic& one : part.diagnostics) tell(std::move(one), told_);
        part.diagnostics = std::move(of_reading);
        part.diagnostics.insert(part.diagnostics.end(), told_.begin(), told_.end());
        return true;
    }
    double share() const override { return parts_->share(); }

  private:
    std::unique_ptr<program::ProgramParts> parts_;
    const machine::Setup& setup_;
    std::vector<Diagnostic> told_;  ///< of the passes of all parts so far: those of the last part are read
};

}  // namespace

Result<Program> expand_surfaces(Program program, const machine::Setup& setup) {
    if (program.surface_jobs.empty()) return program;
    std::vector<std::vector<Move>> passes;
    for (const SurfaceJob& job : program.surface_jobs) {
        auto plan = plan_of(job, program, setup);
        const Place place{.file = program.source, .line = job.line};
        if (!plan) {
            plan.error().place = place;
            return fail(std::move(plan.error()));
        }
        for (Diagnostic& one : plan->program.diagnostics) {
            one.place = place;
            tell(std::move(one), program.diagnostics);
        }
        passes.push_back(std::move(plan->program.moves));
    }
    const std::vector<SurfaceJob> jobs = std::move(program.surface_jobs);
    Splicing splicing(std::move(program));
    for (std::size_t i = 0; i < jobs.size(); ++i) splicing.insert(passes[i], jobs[i]);
    return splicing.finished();
}

std::unique_ptr<program::ProgramParts> expand_surfaces(std::unique_ptr<program::ProgramParts> parts,
                                                       const machine::Setup& setup) {
    return std::make_unique<ExpandedParts>(std::move(parts), setup);
}

}  // namespace trunnion::pipeline
