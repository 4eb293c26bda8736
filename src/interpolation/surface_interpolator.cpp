#include "trunnion/interpolation/surface_interpolator.hpp"

#include <algorithm>

namespace trunnion::interpolation {

SurfaceInterpolator::SurfaceInterpolator(const SurfaceCurve& curve, const SurfacePath& path, const path::AxisPath& axes,
                                         const SurfaceProfile& profile, StepOrder order) noexcept
    : curve_(&curve),
      path_(&path),
      axes_(&axes),
      profile_(&profile),
      order_(order),
      contact_(curve.contact(curve.begin())) {
    const machine::AxisPosition begin = axes.begin_position();
    const int linear = path.tool_path.kinematics->axis_count() - path.tool_path.kinematics->rotary_count();
    for (int i = 0; linear + i < path.tool_path.kinematics->axis_count(); ++i) rotary_rad_[i] = begin[linear + i];
}

SurfaceInstant SurfaceInterpolator::at(double time_s) noexcept {
    const bool complete = profile_->finished();  // before size(): what is complete has all its pieces
    const std::size_t planned = profile_->size();
    SurfaceInstant now;
    if (planned == 0) {
        now.status = SurfaceStatus::starved;
        place_on_surface(now);
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
    const double offset_mm = piece.path_offset_mm + delta;
    now.way_mm = path_->tool_path.pieces[piece.path_piece].begin_mm + offset_mm;
    if (path_->pieces[piece.path_piece].bridge)
        place_on_bridge(now, offset_mm);
    else
        place_on_surface(now);
    return now;
}

void SurfaceInterpolator::place_on_surface(SurfaceInstant& now) noexcept {
    if (now.path_piece != contact_piece_) {
        contact_piece_ = now.path_piece;
        contact_ = curve_->contact(path_->pieces[contact_piece_].w_begin);
        way_mm_ = path_->tool_path.pieces[contact_piece_].begin_mm;
    }
    const SurfaceContact next = step(*curve_, contact_, now.way_mm - way_mm_, order_);
    way_mm_ += way_between_mm(contact_, next);
    contact_ = next;
    now.w = contact_.w;
    now.pose = curve_->pose(contact_);
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

void SurfaceInterpolator::place_on_bridge(SurfaceInstant& now, double offset_mm) noexcept {
    const double length_mm = path_->tool_path.pieces[now.path_piece].length_mm;
    path::AxisSample sample;
    axes_->evaluate({now.path_piece, std::min(offset_mm, length_mm)}, sample);
    now.w = contact_.w;
    now.pose = {{sample.tip[0].value(), sample.tip[1].value(), sample.tip[2].value()},
                {sample.tool_axis[0].value(), sample.tool_axis[1].value(), sample.tool_axis[2].value()}};
    const int count = axes_->axis_count(), linear = count - path_->tool_path.kinematics->rotary_count();
    for (int i = 0; i < count; ++i) now.position[i] = sample.axes[i].value();
    for (int i = linear; i < count; ++i) rotary_rad_[i - linear] = now.position[i];
}

}  // namespace trunnion::interpolation
