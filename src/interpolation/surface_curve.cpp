#include "trunnion/interpolation/surface_curve.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "detail/surface_series.hpp"

namespace trunnion::interpolation {

using geometry::SurfacePlace;
using machine::Pose;
using machine::VectorSeries;

namespace {

constexpr int looks_between_knots = 8;
constexpr double least_sine = 1e-9;                  // between S_u and S_v
constexpr double domain_slack = 1e-6;                // share of the domain
constexpr double least_rise = 0.017452406437283513;  // sine of 1°, of the axis above the tangent plane
constexpr double least_lean = 1e-3;                  // sine, of a tool that is no ball

Result<void> check_tool(const SurfaceTool& tool) {
    constexpr double quarter_turn = std::numbers::pi / 2;
    const auto refuse = [](const char* what, double value, const char* limit) {
        return fail({.code = "INTP0001",
                     .text = fmt::format("{} of a tool on a surface is out of its range", what),
                     .value = fmt::format("{}", value),
                     .limit = limit});
    };
    if (!(tool.radius_mm > 0 && std::isfinite(tool.radius_mm)))
        return refuse("the radius", tool.radius_mm, "above 0 mm");
    if (!(tool.corner_mm >= 0 && tool.corner_mm <= tool.radius_mm))
        return refuse("the corner radius", tool.corner_mm, "from 0 mm to the radius");
    for (const double angle : {tool.lead_rad, tool.tilt_rad})
        if (!(std::abs(angle) < quarter_turn)) return refuse("lead or tilt", angle, "within a quarter turn");
    return {};
}

double share_of(const geometry::SurfaceDirection& direction) noexcept {
    return direction.end() - direction.begin();
}

bool within(const geometry::SurfaceDirection& direction, double at) noexcept {
    const double slack = domain_slack * share_of(direction);
    return at >= direction.begin() - slack && at <= direction.end() + slack;
}

/// Inner knots at which a surface is less than C^k in one direction.
std::vector<double> rough_knots(const geometry::SurfaceDirection& direction, int smoothness) {
    std::vector<double> out;
    const auto& knots = direction.knots;
    for (std::size_t i = 0; i < knots.size();) {
        std::size_t behind = i;
        while (behind < knots.size() && knots[behind] == knots[i]) ++behind;
        const bool inside = knots[i] > direction.begin() && knots[i] < direction.end();
        if (inside && direction.degree - static_cast<int>(behind - i) < smoothness) out.push_back(knots[i]);
        i = behind;
    }
    return out;
}

}  // namespace

/// u(w) and v(w) with four derivatives, as Taylor coefficients.
struct SurfaceCurve::Parameters {
    std::array<double, 5> u, v;

    static Taylor3 series(const std::array<double, 5>& c) noexcept { return {c[0], c[1], c[2], c[3]}; }
    static Taylor3 slope(const std::array<double, 5>& c) noexcept { return {c[1], 2 * c[2], 3 * c[3], 4 * c[4]}; }
};

std::size_t SurfaceCurve::piece_at(double w) const noexcept {
    const auto behind = std::upper_bound(pieces_.begin() + 1, pieces_.end(), w,
                                         [](double at, const auto& piece) { return at < piece.u_begin; });
    return static_cast<std::size_t>(behind - pieces_.begin()) - 1;
}

SurfaceCurve::Parameters SurfaceCurve::parameters(double w) const noexcept {
    const geometry::PolynomialPiece& piece = pieces_[piece_at(w)];
    const double per_w = 1 / (piece.u_end - piece.u_begin), x = (w - piece.u_begin) * per_w;
    Parameters out{};
    for (int i = piece.degree; i >= 0; --i) {
        for (int k = 4; k > 0; --k) {
            out.u[k] = out.u[k] * x + out.u[k - 1];
            out.v[k] = out.v[k] * x + out.v[k - 1];
        }
        out.u[0] = out.u[0] * x + piece.coefficients_mm[i].x();
        out.v[0] = out.v[0] * x + piece.coefficients_mm[i].y();
    }
    double power = 1;
    for (int k = 1; k < 5; ++k) {
        power *= per_w;
        out.u[k] *= power;
        out.v[k] *= power;
    }
    return out;
}

SurfacePlace SurfaceCurve::place(double w) const noexcept {
    const Parameters at = parameters(w);
    return {at.u[0], at.v[0]};
}

SurfaceContact SurfaceCurve::contact(double w) const noexcept {
    const Parameters at = parameters(w);
    const geometry::SurfacePoint s = surface_->evaluate(at.u[0], at.v[0]);
    const double u1 = at.u[1], v1 = at.v[1];
    SurfaceContact out;
    out.w = w;
    out.place = {at.u[0], at.v[0]};
    out.point_mm = s.at;
    out.by_w = u1 * s.by_u + v1 * s.by_v;
    out.by_ww =
        u1 * u1 * s.by_uu + 2 * u1 * v1 * s.by_uv + v1 * v1 * s.by_vv + 2 * at.u[2] * s.by_u + 2 * at.v[2] * s.by_v;
    const Eigen::Vector3d across = s.by_u.cross(s.by_v);
    out.normal = (side_ == geometry::Side::along ? 1 : -1) / across.norm() * across;
    out.rate_mm = out.by_w.norm();
    out.rate_slope_mm = out.by_w.dot(out.by_ww) / out.rate_mm;
    return out;
}

/// The tool with an axis of an orientation surface.
Pose SurfaceCurve::pose_of(const SurfaceContact& contact, const Eigen::Vector3d& axis) const noexcept {
    const Eigen::Vector3d& n = contact.normal;
    const double r = tool_.corner_mm, flat = tool_.radius_mm - r;
    Pose out{contact.point_mm + r * (n - axis), axis};
    if (flat > 0) out.tip_in_workpiece_mm += flat * (n - n.dot(axis) * axis).normalized();
    return out;
}

Pose SurfaceCurve::pose(const SurfaceContact& contact) const noexcept {
    if (tool_.orientation) {
        const Eigen::Vector3d second = tool_.orientation->at(contact.place.u, contact.place.v);
        return pose_of(contact, (second - contact.point_mm - tool_.corner_mm * contact.normal).normalized());
    }
    if (sine_ == 0) return {contact.point_mm, contact.normal};
    const Eigen::Vector3d& n = contact.normal;
    const Eigen::Vector3d t = contact.by_w / contact.rate_mm;
    const Eigen::Vector3d axis = cosine_ * (n + tan_lead_ * t + tan_tilt_ * n.cross(t));
    const Eigen::Vector3d across = (n - cosine_ * axis) / sine_;
    const double r = tool_.corner_mm;
    return {contact.point_mm + r * (n - axis) + (tool_.radius_mm - r) * across, axis};
}

SurfaceSeries SurfaceCurve::on_orientation(const Parameters& at, const VectorSeries& contact,
                                           const VectorSeries& normal) const noexcept {
    const double r = tool_.corner_mm, flat = tool_.radius_mm - r;
    const VectorSeries centre = detail::sum(contact, detail::scaled(normal, r));
    const VectorSeries second =
        detail::on_surface(*tool_.orientation, Parameters::series(at.u), Parameters::series(at.v)).at;
    SurfaceSeries out{.contact = contact, .tip = centre, .axis = {}};
    out.axis = detail::unit(detail::sum(second, detail::scaled(centre, -1)));
    if (flat > 0) {
        const Taylor3 cosine = detail::dot(normal, out.axis);
        const VectorSeries across = detail::unit(detail::sum(normal, detail::scaled(out.axis, -cosine)));
        out.tip = detail::sum(out.tip, detail::scaled(across, flat));
    }
    out.tip = detail::sum(out.tip, detail::scaled(out.axis, -r));
    return out;
}

SurfaceSeries SurfaceCurve::by_parameter(double w) const noexcept {
    const Parameters at = parameters(w);
    const detail::SeriesOnSurface s = detail::on_surface(*surface_, Parameters::series(at.u), Parameters::series(at.v));
    const VectorSeries across = detail::cross(s.by_u, s.by_v);
    const VectorSeries n = detail::scaled(detail::unit(across), side_ == geometry::Side::along ? 1 : -1);
    if (tool_.orientation) return on_orientation(at, s.at, n);
    SurfaceSeries out{.contact = s.at, .tip = s.at, .axis = n};
    if (sine_ == 0) return out;
    const VectorSeries slope =
        detail::sum(detail::scaled(s.by_u, Parameters::slope(at.u)), detail::scaled(s.by_v, Parameters::slope(at.v)));
    const VectorSeries t = detail::unit(slope);
    const VectorSeries lean = detail::sum(detail::scaled(t, tan_lead_), detail::scaled(detail::cross(n, t), tan_tilt_));
    out.axis = detail::scaled(detail::sum(n, lean), cosine_);
    const double r = tool_.corner_mm, flat = (tool_.radius_mm - r) / sine_;
    for (int i = 0; i < 3; ++i) out.tip[i] = s.at[i] + (r + flat) * n[i] - (r + flat * cosine_) * out.axis[i];
    return out;
}

SurfaceSeries SurfaceCurve::by_way(double w) const noexcept {
    const SurfaceSeries f = by_parameter(w);
    VectorSeries slope;  // its first three coefficients are exact, and enough
    for (int i = 0; i < 3; ++i) slope[i] = {f.contact[i].c[1], 2 * f.contact[i].c[2], 3 * f.contact[i].c[3], 0};
    const detail::Reparameter to_way(sqrt(detail::dot(slope, slope)));
    return {to_way(f.contact), to_way(f.tip), to_way(f.axis)};
}

double SurfaceCurve::way_mm(double from, double to) const noexcept {
    constexpr std::array<std::array<double, 2>, 4> gauss8{{{0.18343464249564980494, 0.36268378337836198297},
                                                           {0.52553240991632898582, 0.31370664587788728734},
                                                           {0.79666647741362673959, 0.22238103445337447054},
                                                           {0.96028985649753623168, 0.10122853629037625915}}};
    const double middle = 0.5 * (from + to), half = 0.5 * (to - from);
    double sum = 0;
    for (const auto& [abscissa, weight] : gauss8)
        sum += weight * (contact(middle - half * abscissa).rate_mm + contact(middle + half * abscissa).rate_mm);
    return half * sum;
}

std::vector<double> SurfaceCurve::knots() const {
    std::vector<double> out;
    for (const auto& piece : pieces_) out.push_back(piece.u_begin);
    out.push_back(end());
    return out;
}

std::vector<double> SurfaceCurve::rough_places() const {
    std::vector<double> out;
    const auto find = [&](const geometry::SurfaceDirection& direction, int smoothness, const auto& coordinate) {
        const double along_it = 1e-9 * share_of(direction);
        for (const double knot : rough_knots(direction, smoothness))
            for (const auto& piece : pieces_)
                for (int k = 0; k < looks_between_knots; ++k) {
                    const double step = (piece.u_end - piece.u_begin) / looks_between_knots;
                    double low = piece.u_begin + k * step, high = low + step;
                    const double at_low = coordinate(low) - knot, at_high = coordinate(high) - knot;
                    if ((at_low < 0) == (at_high < 0) || std::max(std::abs(at_low), std::abs(at_high)) < along_it)
                        continue;
                    for (int halving = 0; halving < 60; ++halving) {
                        const double middle = 0.5 * (low + high);
                        ((coordinate(middle) - knot < 0) == (at_low < 0) ? low : high) = middle;
                    }
                    out.push_back(0.5 * (low + high));
                }
    };
    const auto find_all = [&](const geometry::BsplineSurface& surface, int smoothness) {
        find(surface.u(), smoothness, [this](double w) { return place(w).u; });
        find(surface.v(), smoothness, [this](double w) { return place(w).v; });
    };
    find_all(*surface_, 4);
    if (tool_.orientation) find_all(*tool_.orientation, 3);
    std::ranges::sort(out);
    const auto again = std::ranges::unique(out);
    out.erase(again.begin(), again.end());
    return out;
}

Result<void> SurfaceCurve::check_orientation(double w) const {
    const SurfaceContact at = contact(w);
    const geometry::BsplineSurface& second = *tool_.orientation;
    if (!within(second.u(), at.place.u) || !within(second.v(), at.place.v))
        return fail({.code = "INTP0002",
                     .text = "a curve leaves the domain of its orientation surface",
                     .value = fmt::format("u = {}, v = {}", at.place.u, at.place.v)});
    const Eigen::Vector3d axis = pose(at).axis_in_workpiece;
    const double rise = axis.dot(at.normal), lean = axis.cross(at.normal).norm();
    const bool upright = tool_.corner_mm < tool_.radius_mm && !(lean >= least_lean);
    if (rise >= least_rise && !upright) return {};
    return fail({.code = "INTP0009",
                 .text = fmt::format("the axis of an orientation surface is {} at ({:.3f} {:.3f} {:.3f})",
                                     upright ? "along the normal" : "not above the surface", at.point_mm.x(),
                                     at.point_mm.y(), at.point_mm.z()),
                 .value = fmt::format("{:.3g} rad from the normal", std::atan2(lean, rise)),
                 .limit = upright ? fmt::format("at least {} rad of a tool that is no ball", least_lean)
                                  : std::string("at least 1 deg above the tangent plane"),
                 .hint = upright ? "give a lead that keeps its sign" : "less lead or tilt"});
}

Result<void> SurfaceCurve::check(double w) const {
    const SurfacePlace at = place(w);
    if (!within(surface_->u(), at.u) || !within(surface_->v(), at.v))
        return fail({.code = "INTP0002",
                     .text = "a curve leaves the domain of its surface",
                     .value = fmt::format("u = {}, v = {}", at.u, at.v),
                     .limit = fmt::format("u from {} to {}, v from {} to {}", surface_->u().begin(),
                                          surface_->u().end(), surface_->v().begin(), surface_->v().end())});
    const geometry::SurfacePoint s = surface_->evaluate(at.u, at.v);
    const double area = s.by_u.norm() * s.by_v.norm();
    const bool ahead = contact(w).rate_mm * (end() - begin()) > 1e-9;
    if (s.by_u.cross(s.by_v).norm() > least_sine * area && ahead) return {};
    return fail(
        {.code = "INTP0003",
         .text = ahead ? "the surface has no normal at a place of the curve" : "a curve on a surface stands still",
         .value = fmt::format("u = {}, v = {}", at.u, at.v),
         .hint = "end the pass before it"});
}

Result<SurfaceCurve> SurfaceCurve::make(const geometry::BsplineSurface& surface, geometry::Side side,
                                        const geometry::BsplineCurve& places, const SurfaceTool& tool) {
    if (auto sound = check_tool(tool); !sound) return fail(sound.error());
    if (!places.weights().empty())
        return fail({.code = "INTP0004", .text = "a curve on a surface is given with weights"});
    SurfaceCurve out;
    out.surface_ = &surface;
    out.side_ = side;
    out.pieces_ = places.pieces();
    out.tool_ = tool;
    out.tan_lead_ = std::tan(tool.lead_rad);
    out.tan_tilt_ = std::tan(tool.tilt_rad);
    const double lean = std::hypot(out.tan_lead_, out.tan_tilt_);
    out.cosine_ = 1 / std::hypot(1, lean);
    out.sine_ = lean * out.cosine_;
    for (const auto& piece : out.pieces_)
        for (int k = 0; k <= looks_between_knots; ++k) {
            const double w = piece.u_begin + (piece.u_end - piece.u_begin) * k / looks_between_knots;
            if (auto sound = out.check(w); !sound) return fail(sound.error());
            if (!tool.orientation) continue;
            if (auto sound = out.check_orientation(w); !sound) return fail(sound.error());
        }
    return out;
}

}  // namespace trunnion::interpolation
