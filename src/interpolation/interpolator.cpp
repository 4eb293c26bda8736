#include "trunnion/interpolation/interpolator.hpp"

#include <algorithm>
#include <cmath>

namespace trunnion::interpolation {

Interpolator::Interpolator(const path::AxisPath& path, const motion::FeedProfile& profile) noexcept
    : path_(&path), profile_(&profile) {}

Instant Interpolator::at(double time_s) noexcept {
    const auto& pieces = profile_->pieces;
    while (piece_ + 1 < pieces.size() && time_s >= pieces[piece_ + 1].begin_s) ++piece_;
    const motion::ProfilePiece& piece = pieces[piece_];
    const double delta = motion::distance_at(piece, std::clamp(time_s - piece.begin_s, 0.0, piece.duration_s));

    Instant now;
    now.path_state = motion::state_at(piece, delta);
    now.path_state.profile_piece = piece_;
    const path::PathPiece& geometry = path_->tool_path().pieces[piece.path_piece];
    now.place = {piece.path_piece, std::min(piece.path_offset_mm + delta, geometry.length_mm)};

    path::AxisSample sample;
    path_->evaluate(now.place, sample);
    for (int i = 0; i < path_->axis_count(); ++i) now.position[i] = sample.axes[i].value();
    now.tip_in_workpiece_mm = {sample.tip[0].value(), sample.tip[1].value(), sample.tip[2].value()};
    now.tip_speed_mm_s =
        now.path_state.speed_mm_s * std::hypot(sample.tip[0].d1(), sample.tip[1].d1(), sample.tip[2].d1());

    const auto& blocks = path_->tool_path().blocks;
    const double p = geometry.begin_mm + now.place.offset_mm;
    while (block_ + 1 < blocks.size() && p >= blocks[block_].end_mm) ++block_;
    now.block = block_;
    return now;
}

}  // namespace trunnion::interpolation
