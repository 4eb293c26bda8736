#include "trunnion/interpolation/surface_interpolator.hpp"

#include <algorithm>

namespace trunnion::interpolation {

using machine::Pose;

SurfaceInterpolator::SurfaceInterpolator(const SurfaceCurve& curve, const SurfacePath& path,
                                         const SurfaceProfile& profile, const machine::RotaryPosition& begin_rad,
                                         StepOrder order) noexcept
    : curve_(&curve),
      path_(&path),
      profile_(&profile),
      order_(order),
      contact_(curve.contact(curve.begin())),
      rotary_rad_(begin_rad) {}

SurfaceInstant SurfaceInterpolator::at(double time_s) noexcept {
    const bool complete = profile_->finished();  // before size(): what is complete has all its pieces
    const std::size_t planned = profile_->size();
    SurfaceInstant now;
    if (planned == 0) {
        now.status = SurfaceStatus::starved;
        now.pose = pose_on_surface(0, 0);
        place_axes(now);
        return now;
    }
    while (profile_piece_ + 1 < planned && time_s >= (*profile_)[profile_piece_ + 1].begin_s) ++profile_piece_;
    const motion::ProfilePiece& piece = (*profile_)[profile_piece_];
    const bool behind = time_s > piece.begin_s + piece.duration_s;
    const double delta = motion::distance_at(piece, std::clamp(time_s - piece.begin_s, 0.0, piece.duration_s));
    if (behind) now.status = complete ? SurfaceStatus::finished : SurfaceStatus::starved;
    now.profile_piece = profile_piece_;
    now.path_piece = piece.path_piece;
    now.contact_feed_mm_s = behind ? 0 : motion::state_at(piece, delta).speed_mm_s;
    now.way_mm = path_->tool_path.pieces[piece.path_piece].begin_mm + piece.path_offset_mm + delta;
    now.pose = path_->pieces[piece.path_piece].bridge ? pose_on_bridge(piece.path_piece, piece.path_offset_mm + delta)
                                                      : pose_on_surface(piece.path_piece, now.way_mm);
    now.w = contact_.w;
    place_axes(now);
    return now;
}

Pose SurfaceInterpolator::pose_on_surface(std::size_t path_piece, double way_mm) noexcept {
    if (path_piece != contact_piece_) {
        contact_piece_ = path_piece;
        contact_ = curve_->contact(path_->pieces[path_piece].w_begin);
        way_mm_ = path_->tool_path.pieces[path_piece].begin_mm;
    }
    const SurfaceContact next = step(*curve_, contact_, way_mm - way_mm_, order_);
    way_mm_ += way_between_mm(contact_, next);
    contact_ = next;
    return curve_->pose(contact_);
}

Pose SurfaceInterpolator::pose_on_bridge(std::size_t path_piece, double offset_mm) const noexcept {
    const path::PathPiece& piece = path_->tool_path.pieces[path_piece];
    const auto at = path::evaluate(piece, std::min(offset_mm, piece.length_mm));
    return {{at[0].value(), at[1].value(), at[2].value()},
            Eigen::Vector3d(at[3].value(), at[4].value(), at[5].value()).normalized()};
}

void SurfaceInterpolator::place_axes(SurfaceInstant& now) noexcept {
    const machine::Kinematics& kinematics = *path_->tool_path.kinematics;
    const Eigen::Vector3d& axis = now.pose.axis_in_workpiece;
    const int rotary = kinematics.rotary_count(), linear = kinematics.axis_count() - rotary;
    if (rotary > 0) {
        const machine::RotarySeries turned = kinematics.rotary_series({axis.x(), axis.y(), axis.z()}, rotary_rad_);
        for (int i = 0; i < rotary; ++i) rotary_rad_[i] = turned[i].value();
    }
    const auto at = kinematics.linear_for(now.pose.tip_in_workpiece_mm, rotary_rad_);
    for (int i = 0; i < linear; ++i) now.position[i] = at[i];
    for (int i = 0; i < rotary; ++i) now.position[linear + i] = rotary_rad_[i];
}

}  // namespace trunnion::interpolation
