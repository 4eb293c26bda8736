#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "trunnion/path/rotary_stands.hpp"
#include "trunnion/pipeline/surface_motion.hpp"
#include "trunnion/surfacing/path_interval.hpp"

#include "detail/surface_motion_mover.hpp"

namespace trunnion::pipeline {

using geometry::SurfacePlace;
using interpolation::SurfaceCurve;
using interpolation::SurfaceTool;
using program::Program;

namespace {

constexpr int most_passes = 20000;
constexpr int places_of_a_pass = 200;

using Places = std::vector<SurfacePlace>;

/// The passes of Lin & Koren's rule, one after the other.
class PassLayer {
  public:
    PassLayer(const surfacing::Face& face, const surfacing::Cutter& cutter, const surfacing::SurfaceOptions& options)
        : face_(face), cutter_(cutter), options_(options) {}

    /// The parts of the next pass within the face, in the direction of u; none behind the border of largest v.
    Result<std::vector<Places>> next() {
        if (at_end_) return std::vector<Places>{};
        const auto &u = face_.surface.u(), &v = face_.surface.v();
        if (front_.empty()) {
            front_ = along_border(v.begin());
            return std::vector<Places>{front_};
        }
        if (auto moved = move_on(); !moved) return fail(moved.error());
        auto inside = parts_within(v.end(), 1e-3 * (u.end() - u.begin()));
        at_end_ = inside.empty();
        if (at_end_) inside.push_back(along_border(v.end()));
        return inside;
    }

  private:
    /// A place with its shape, and the unit direction across the pass, towards growing v.
    struct Station {
        geometry::SurfaceShape shape;
        Eigen::Vector3d across;
    };

    Places along_border(double v) const {
        const auto& u = face_.surface.u();
        Places out;
        for (int k = 0; k <= places_of_a_pass; ++k)
            out.push_back({u.begin() + (u.end() - u.begin()) * k / places_of_a_pass, v});
        return out;
    }

    Result<Station> station(std::size_t i) const {
        const SurfacePlace &before = front_[i == 0 ? 0 : i - 1], &behind = front_[std::min(i + 1, front_.size() - 1)];
        const auto shape = geometry::shape_at(face_.surface, front_[i], face_.side);
        if (!shape)
            return fail({.code = "INTP0003",
                         .text = "the surface has no normal at a place of the curve",
                         .value = fmt::format("u = {}, v = {}", front_[i].u, front_[i].v)});
        const Eigen::Vector3d along = (behind.u - before.u) * shape->by_u + (behind.v - before.v) * shape->by_v;
        Eigen::Vector3d across = shape->normal.cross(along).normalized();
        if (across.dot(shape->by_v) < 0) across = -across;
        return Station{*shape, across};
    }

    /// All places by the least interval of any. SURF0203 where the surface rises above the tool's rim.
    Result<void> move_on() {
        std::vector<Station> stations;
        double least = std::numeric_limits<double>::infinity();
        for (std::size_t i = 0; i < front_.size(); ++i) {
            auto at = station(i);
            if (!at) return fail(at.error());
            const Eigen::Vector2d across = at->shape.components(at->across);
            const auto parting = surfacing::parting(cutter_, at->shape, at->shape.normal);
            const double rise =
                0.5 * geometry::principal_curvatures(parting).smaller * cutter_.radius_mm() * cutter_.radius_mm();
            if (rise < -options_.gouge_tolerance_mm) return fail(too_hollow(at->shape));
            least = std::min(least, surfacing::path_interval_mm(cutter_, at->shape, at->shape.normal, across,
                                                                options_.scallop_mm, true));
            stations.push_back(*std::move(at));
        }
        Places moved;
        for (std::size_t i = 0; i < front_.size(); ++i) {
            const Eigen::Vector3d step = least * stations[i].across;
            const Eigen::Vector2d way = stations[i].shape.parameters_along(step);
            constexpr double margin = 0.5;
            moved.push_back(geometry::closest_place(face_.surface, stations[i].shape.point + step,
                                                    {front_[i].u + way.x(), front_[i].v + way.y()}, margin));
        }
        front_ = at_even_u(moved);
        return {};
    }

    static Diagnostic too_hollow(const geometry::SurfaceShape& at) {
        return {.code = "SURF0203",
                .text = fmt::format("the surface is hollower than the tool is round at ({:.3f} {:.3f} {:.3f})",
                                    at.point.x(), at.point.y(), at.point.z()),
                .hint = "Lin & Koren's rule is for surfaces that bulge towards the tool"};
    }

    /// The front from border to border in u.
    Places at_even_u(const Places& moved) const {
        Places out;
        std::size_t k = 0;
        for (const SurfacePlace& even : along_border(0)) {
            while (k + 2 < moved.size() && moved[k + 1].u < even.u) ++k;
            const double share = (even.u - moved[k].u) / (moved[k + 1].u - moved[k].u);
            out.push_back({even.u, moved[k].v + share * (moved[k + 1].v - moved[k].v)});
        }
        return out;
    }

    /// Parts of the front with v below the border, cut there; stubs left out.
    std::vector<Places> parts_within(double border, double shortest_u) const {
        std::vector<Places> out;
        const auto cut = [&](const SurfacePlace& a, const SurfacePlace& b) {
            return SurfacePlace{a.u + (b.u - a.u) * (border - a.v) / (b.v - a.v), border};
        };
        for (std::size_t i = 0; i < front_.size(); ++i) {
            const bool inside = front_[i].v < border, was_inside = i > 0 && front_[i - 1].v < border;
            if (inside && !was_inside) out.emplace_back();
            if (i > 0 && inside != was_inside) out.back().push_back(cut(front_[i - 1], front_[i]));
            if (inside) out.back().push_back(front_[i]);
        }
        std::erase_if(out, [&](const Places& part) { return part.back().u - part.front().u < shortest_u; });
        return out;
    }

    const surfacing::Face& face_;
    const surfacing::Cutter& cutter_;
    const surfacing::SurfaceOptions& options_;
    Places front_;
    bool at_end_ = false;
};

Result<void> check_surface_options(const surfacing::SurfaceOptions& options, const surfacing::Cutter& cutter) {
    struct Bound {
        const char* name;
        double value, above, below;
    };
    constexpr double infinite = 1e9;
    for (const auto& [name, value, above, below] :
         {Bound{"scallop_mm", options.scallop_mm, 0, 0.5 * cutter.radius_mm()},
          Bound{"lift_mm", options.lift_mm, 0, infinite},
          Bound{"retract_mm", options.retract_mm, options.lift_mm, infinite},
          Bound{"feed_mm_s", options.feed_mm_s, 0, infinite},
          Bound{"approach_mm_s", options.approach_mm_s, 0, infinite}})
        if (!(value > above && value < below))
            return fail({.code = "SURF0202",
                         .text = fmt::format("{} is out of its range", name),
                         .value = fmt::format("{}", value),
                         .limit = fmt::format("above {:.6g}, below {:.6g}", above, below)});
    return {};
}

bool is_whole(const surfacing::Face& face) {
    const auto box = surfacing::parameter_box(face);
    const auto &u = face.surface.u(), &v = face.surface.v();
    return face.loops.size() == 1 && face.loops.front().size() == 4 && box.low.x() == u.begin() &&
           box.high.x() == u.end() && box.low.y() == v.begin() && box.high.y() == v.end();
}

machine::Pose raised(const machine::Pose& pose, double height_mm) {
    return {pose.tip_in_workpiece_mm + height_mm * pose.axis_in_workpiece, pose.axis_in_workpiece};
}

/// Moves from one pass to the next and along it.
class LinkWriter {
  public:
    explicit LinkWriter(const surfacing::SurfaceOptions& options) : options_(options) {}

    /// From where a pass ended, if there was one, down to where the next begins: the last move of the program.
    Program link(const std::optional<machine::Pose>& from, const machine::Pose& to) {
        if (from) start_at(*from);
        if (from && options_.zigzag) {
            feed(raised(*from, options_.lift_mm), options_.feed_mm_s);
            feed(raised(to, options_.lift_mm), options_.feed_mm_s);
        } else {
            if (from) rapid(raised(*from, options_.retract_mm));
            rapid(raised(to, options_.retract_mm));
            rapid(raised(to, options_.lift_mm));
        }
        feed(to, options_.approach_mm_s);
        return std::move(program_);
    }
    Program last(const machine::Pose& from) {
        start_at(from);
        rapid(raised(from, options_.retract_mm));
        return std::move(program_);
    }
    static void along(const SurfaceCurve& curve, double feed_mm_s, Program& program) {
        constexpr int chords = 60;
        for (int k = 1; k <= chords; ++k) {
            const auto at = curve.contact(curve.begin() + (curve.end() - curve.begin()) * k / chords);
            program.moves.push_back(move(curve.pose(at), program::MoveKind::feed, feed_mm_s));
        }
    }

  private:
    static program::Move move(const machine::Pose& to, program::MoveKind kind, double feed_mm_s) {
        program::Move out{.position_mm = to.tip_in_workpiece_mm, .axis = to.axis_in_workpiece, .kind = kind};
        if (kind == program::MoveKind::feed) out.feed = {program::FeedRule::tip_speed, feed_mm_s};
        return out;
    }
    void feed(const machine::Pose& to, double mm_s) {
        program_.moves.push_back(move(to, program::MoveKind::feed, mm_s));
    }
    void rapid(const machine::Pose& to) { program_.moves.push_back(move(to, program::MoveKind::rapid, 0)); }
    /// moves[0] is where motion starts, not a motion.
    void start_at(const machine::Pose& pose) { rapid(pose); }

    const surfacing::SurfaceOptions& options_;
    Program program_{.name = "surface", .dialect = "apt"};
};

/// Lays and moves pass after pass.
class AheadMover {
  public:
    AheadMover(const surfacing::Face& face, const surfacing::SurfaceOptions& surface, const machine::Machine& machine,
               const machine::Setup& setup, double tolerance_mm, SurfaceMover& mover)
        : face_(face),
          surface_(surface),
          machine_(machine),
          setup_(setup),
          tolerance_mm_(tolerance_mm),
          mover_(mover) {}

    Result<void> pass(Places places, const surfacing::Cutter& cutter) {
        const bool backwards = surface_.zigzag && count_ % 2 == 1;
        if (backwards) std::ranges::reverse(places);
        const SurfaceTool tool{cutter.radius_mm(), cutter.corner_mm(), surface_.lead_rad,
                               backwards ? -surface_.tilt_rad : surface_.tilt_rad};
        const auto curve = curve_of(face_, places, tool, tolerance_mm_);
        if (!curve) return fail(curve.error());
        Program program = LinkWriter(surface_).link(end_, curve->pose(curve->contact(curve->begin())));
        const std::size_t links = program.moves.size();
        LinkWriter::along(*curve, surface_.feed_mm_s, program);
        const auto stands = path::choose_rotary_stands(program, machine_, setup_, 0, standing());
        if (!stands) return fail(stands.error());
        program.moves.resize(links);
        const auto linked =
            mover_.link(program, {stands->begin(), stands->begin() + static_cast<std::ptrdiff_t>(links)});
        if (!linked) return linked;
        const auto line = static_cast<std::int32_t>(++count_);
        if (auto moved = mover_.pass(*curve, surface_.feed_mm_s, line, {}); !moved) return moved;
        end_ = curve->pose(curve->contact(curve->end()));
        return {};
    }

    Result<void> finish() {
        const Program program = LinkWriter(surface_).last(*end_);
        auto stands = path::choose_rotary_stands(program, machine_, setup_, 0, standing());
        return stands ? mover_.link(program, std::move(*stands)) : fail(stands.error());
    }

  private:
    std::optional<machine::RotaryPosition> standing() const {
        return end_ ? std::optional(mover_.standing()) : std::nullopt;
    }

    const surfacing::Face& face_;
    const surfacing::SurfaceOptions& surface_;
    const machine::Machine& machine_;
    const machine::Setup& setup_;
    double tolerance_mm_;
    SurfaceMover& mover_;
    std::optional<machine::Pose> end_;
    int count_ = 0;
};

}  // namespace

Result<SurfaceMotionSummary> move_surface_ahead(const surfacing::Face& face, const surfacing::Cutter& cutter,
                                                const surfacing::SurfaceOptions& surface,
                                                const machine::Machine& machine, const machine::Setup& setup,
                                                const SurfaceMotionOptions& options, PlanObserver& observer) {
    if (auto sound = check_motion_options(options); !sound) return fail(sound.error());
    if (auto sound = check_surface_options(surface, cutter); !sound) return fail(sound.error());
    if (!is_whole(face))
        return fail({.code = "PIPE0133",
                     .text = "passes are laid while others are moved on whole faces alone",
                     .hint = "plan the face first"});
    const auto kinematics = machine::Kinematics::make(machine, setup.workpiece, setup.tool.length_mm);
    if (!kinematics) return fail(kinematics.error());
    SurfaceMover mover(machine, setup, *kinematics, options, observer);
    PassLayer layer(face, cutter, surface);
    AheadMover ahead(face, surface, machine, setup, options.place_tolerance_mm, mover);
    for (int count = 0; count < most_passes; ++count) {
        const auto parts = layer.next();
        if (!parts) return fail(parts.error());
        if (parts->empty()) {
            if (auto done = ahead.finish(); !done) return fail(done.error());
            return mover.finish();
        }
        for (const Places& places : *parts)
            if (auto moved = ahead.pass(places, cutter); !moved) return fail(moved.error());
        if (!observer.progress(0)) return fail({.code = "PIPE0002", .text = "cancelled"});
    }
    return fail({.code = "PIPE0133", .text = fmt::format("more than {} passes", most_passes)});
}

}  // namespace trunnion::pipeline
