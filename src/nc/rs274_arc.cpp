#include <cmath>

#include "detail/arcs.hpp"
#include "detail/rs274_reader.hpp"

namespace trunnion::nc {

using Eigen::Vector3d;

namespace {

constexpr char centre_letters[] = {'I', 'J', 'K'};

}  // namespace

/// The circle of the block from `start_mm` to position_mm_ in the plane in force. A coordinate along its normal may be
/// unknown: it stays where it stands, and the line that the arc turns about is the same.
bool Rs274Reader::arc_from(Vector3d start_mm, program::Move& move) {
    if (!check_arc_words()) return false;
    const int along = modal_.plane_normal;
    Vector3d end_mm = position_mm_;
    if (std::isnan(start_mm[along]) || std::isnan(end_mm[along])) start_mm[along] = end_mm[along] = 0;
    if (start_mm.hasNaN() || end_mm.hasNaN())
        return refuse("NC0317", spot_of_motion(), "an arc from a position that is not known in this frame", {},
                      "say the coordinates of its plane in a straight move before it");
    const double turns = block_.has('P') ? block_['P'] : 1;
    if (turns != std::floor(turns) || turns < 1)
        return refuse("NC0318", block_.spot('P'), "the turns of an arc are a whole number, at least 1",
                      fmt::format("P{}", turns), "P2 is one whole turn more than P1");
    const bool clockwise = modal_.motion == Meaning::clockwise_arc;
    const Vector3d normal = Vector3d::Unit(along);
    const ArcTolerance& tolerance = modal_.unit_mm == 1 ? linuxcnc_arcs : linuxcnc_inch_arcs;
    auto arc =
        block_.has('R')
            ? arc_by_radius(start_mm, end_mm, block_['R'] * modal_.unit_mm, normal, clockwise, turns - 1, tolerance)
            : arc_by_centre(start_mm, end_mm, centre_from(start_mm), normal, clockwise, turns - 1, tolerance);
    if (!arc) return findings_.refuse(spot_of_motion(), std::move(arc.error()));
    move.arc = static_cast<std::int32_t>(program_.arcs.size());
    program_.arcs.push_back(*arc);
    return true;
}

/// Either R, or the centre by the letters of the plane: all of them where they are absolute.
bool Rs274Reader::check_arc_words() {
    int given = 0;
    for (int i = 0; i < 3; ++i) {
        if (!block_.has(centre_letters[i])) continue;
        ++given;
        if (block_.has('R'))
            return refuse("NC0316", block_.spot('R'), "an arc has a radius or a centre, not both", "R",
                          "take R or I J K away");
        if (i == modal_.plane_normal)
            return refuse("NC0316", block_.spot(centre_letters[i]), "this letter is no centre in the plane in force",
                          {&centre_letters[i], 1}, "I J in G17, I K in G18, J K in G19");
    }
    if (block_.has('R')) return true;
    if (given == 0)
        return refuse("NC0316", spot_of_motion(), "an arc without its centre or radius", {},
                      "I J K from the start, or R");
    if (modal_.centre_absolute && given < 2)
        return refuse("NC0316", spot_of_motion(), "with G90.1 an arc needs both letters of its centre");
    return true;
}

Vector3d Rs274Reader::centre_from(const Vector3d& start_mm) const {
    Vector3d centre_mm = start_mm;
    for (int i = 0; i < 3; ++i) {
        if (!block_.has(centre_letters[i])) continue;
        const double way_mm = block_[centre_letters[i]] * modal_.unit_mm;
        centre_mm[i] = modal_.centre_absolute ? way_mm : centre_mm[i] + way_mm;
    }
    return centre_mm;
}

}  // namespace trunnion::nc
