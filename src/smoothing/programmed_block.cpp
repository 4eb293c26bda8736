#include "detail/programmed_block.hpp"

namespace trunnion::smoothing {

namespace {

/// Opposite vectors, whose plane is undefined, turn in some plane and arrive to 1e-9 rad.
geometry::GreatCircle turn_between(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
    if ((from + to).norm() > 1e-9) return {from, to};
    return {from, (to + 1e-9 * from.unitOrthogonal()).normalized()};
}

template <std::size_t count>
void put(const std::array<Taylor3, count>& series, int first, HermiteEnd& end) {
    for (int k = 0; k < static_cast<int>(count); ++k) {
        end.value[first + k] = series[k].value();
        end.first[first + k] = series[k].d1();
        end.second[first + k] = series[k].d2();
        end.third[first + k] = series[k].d3();
    }
}

/// Where a curve's parameter stands still its direction is that beside the place, and no more is known of it.
HermiteEnd along_curve(const path::CurveWay& curve, double w, double length_mm) {
    constexpr double standing = 1e-4, beside = 1e-3;
    HermiteEnd end;
    if (curve.speed_mm(w) > standing * length_mm) {
        put(curve.by_length(w), 0, end);
        return end;
    }
    put(curve.by_length(w < 0.5 ? w + beside : w - beside), 0, end);
    end.value = joined(curve.at(w));
    end.second.setZero();
    end.third.setZero();
    return end;
}

}  // namespace

bool curve_goes_on(const path::Run& run, std::size_t vertex) {
    if (run.blocks[vertex - 1].curve == path::no_curve || run.blocks[vertex].curve == path::no_curve) return false;
    constexpr double same_tangent = 1e-7, same_curvature_per_mm = 1e-6;
    const HermiteEnd before = ProgrammedBlock(run, vertex - 1).at(1), after = ProgrammedBlock(run, vertex).at(0);
    return size_mm(after.first - before.first) <= same_tangent &&
           size_mm(after.second - before.second) <= same_curvature_per_mm;
}

ProgrammedBlock::ProgrammedBlock(const path::Run& run, std::size_t block)
    : from_(joined(run.vertices[block])), to_(joined(run.vertices[block + 1])), length_(run.blocks[block].length_mm) {
    if (run.blocks[block].curve != path::no_curve) {
        curve_.emplace(run, block);
        if (curve_->curve().orientation) return;
    }
    if (has_vectors(run)) turn_ = turn_between(from_.tail<3>(), to_.tail<3>());
    if (const auto arc = run.blocks[block].arc; arc != program::no_arc)
        arc_ = path::helix_between(run.arcs[arc], run.vertices[block], run.vertices[block + 1]);
}

bool ProgrammedBlock::is_regular_curve() const {
    constexpr double least_speed = 0.05;  // of the mean
    constexpr int places = 8;
    for (int k = 0; curve_ && k <= places; ++k)
        if (curve_->speed_mm(static_cast<double>(k) / places) < least_speed * length_) return false;
    return curve_.has_value();
}

Coordinates ProgrammedBlock::place(double w) const {
    if (curve_) return joined(curve_->at(w));
    Coordinates at = from_ + w * (to_ - from_);
    if (turn_) at.tail<3>() = turn_->at(w);
    if (arc_) at.head<3>() = arc_->at(w);
    return at;
}

HermiteEnd ProgrammedBlock::at(double w) const {
    if (curve_) return along_curve(*curve_, w, length_);
    HermiteEnd end{from_ + w * (to_ - from_), (to_ - from_) / length_, Coordinates::Zero(), Coordinates::Zero()};
    const Taylor3 share{w, 1 / length_, 0, 0};
    if (turn_) put(turn_->at(share), 3, end);
    if (arc_) put(arc_->at(share), 0, end);
    return end;
}

}  // namespace trunnion::smoothing
