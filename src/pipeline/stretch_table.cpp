#include "detail/stretch_table.hpp"

#include <algorithm>

namespace trunnion::pipeline {

namespace {

Eigen::Vector3d tip_of(const path::AxisPath& path, path::PathPlace place) {
    path::AxisSample sample;
    path.evaluate(place, sample);
    return {sample.tip[0].value(), sample.tip[1].value(), sample.tip[2].value()};
}

}  // namespace

void StretchTable::add_place(const path::AxisPath& path, path::PathPlace place, double s_begin_mm) {
    const Eigen::Vector3d tip = tip_of(path, place);
    s_mm.push_back(tip_mm.empty() ? s_begin_mm : s_mm.back() + (tip - tip_mm.back()).norm());
    p_mm.push_back(path.tool_path().pieces[place.piece].begin_mm + place.offset_mm);
    tip_mm.push_back(tip);
}

void StretchTable::add(const path::AxisPath& path, const motion::ProfilePiece& piece, double s_begin_mm) {
    if (!p_mm.empty()) {  // the end so far
        p_mm.pop_back();
        s_mm.pop_back();
        tip_mm.pop_back();
    }
    add_place(path, {piece.path_piece, piece.path_offset_mm}, s_begin_mm);
    add_place(path, {piece.path_piece, piece.path_offset_mm + piece.length_mm}, s_begin_mm);
}

StretchTable StretchTable::of(const path::AxisPath& path, const motion::FeedProfile& profile, double s_begin_mm) {
    StretchTable out;
    for (const auto& piece : profile.pieces) out.add_place(path, {piece.path_piece, piece.path_offset_mm}, s_begin_mm);
    const auto& last = profile.pieces.back();
    out.add_place(path, {last.path_piece, last.path_offset_mm + last.length_mm}, s_begin_mm);
    return out;
}

std::size_t StretchTable::piece_at(double at_mm) const {
    const auto after = std::upper_bound(p_mm.begin() + 1, p_mm.end() - 1, at_mm);
    return static_cast<std::size_t>(after - p_mm.begin()) - 1;
}

double StretchTable::time_at(const motion::FeedProfile& profile, double at_mm) const {
    const std::size_t i = piece_at(at_mm);
    const auto& piece = profile.pieces[i];
    return piece.begin_s + motion::time_to(piece, std::clamp(at_mm - p_mm[i], 0.0, piece.length_mm));
}

double StretchTable::way_at(double at_mm) const {
    const std::size_t i = piece_at(at_mm);
    const double span = p_mm[i + 1] - p_mm[i];
    const double w = span > 0 ? std::clamp((at_mm - p_mm[i]) / span, 0.0, 1.0) : 0.0;
    return s_mm[i] + w * (s_mm[i + 1] - s_mm[i]);
}

}  // namespace trunnion::pipeline
