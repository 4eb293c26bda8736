#include "detail/programmed_block.hpp"

namespace trunnion::smoothing {

namespace {

/// Opposite vectors, whose plane is undefined, turn in some plane and arrive to 1e-9 rad.
geometry::GreatCircle turn_between(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
    if ((from + to).norm() > 1e-9) return {from, to};
    return {from, (to + 1e-9 * from.unitOrthogonal()).normalized()};
}

void put(const std::array<Taylor3, 3>& series, int first, HermiteEnd& end) {
    for (int k = 0; k < 3; ++k) {
        end.value[first + k] = series[k].value();
        end.first[first + k] = series[k].d1();
        end.second[first + k] = series[k].d2();
        end.third[first + k] = series[k].d3();
    }
}

}  // namespace

ProgrammedBlock::ProgrammedBlock(const path::Run& run, std::size_t block)
    : from_(joined(run.vertices[block])), to_(joined(run.vertices[block + 1])), length_(run.blocks[block].length_mm) {
    if (has_vectors(run)) turn_ = turn_between(from_.tail<3>(), to_.tail<3>());
    if (const auto arc = run.blocks[block].arc; arc != program::no_arc)
        arc_ = path::helix_between(run.arcs[arc], run.vertices[block], run.vertices[block + 1]);
}

Coordinates ProgrammedBlock::place(double w) const {
    Coordinates at = from_ + w * (to_ - from_);
    if (turn_) at.tail<3>() = turn_->at(w);
    if (arc_) at.head<3>() = arc_->at(w);
    return at;
}

HermiteEnd ProgrammedBlock::at(double w) const {
    HermiteEnd end{from_ + w * (to_ - from_), (to_ - from_) / length_, Coordinates::Zero(), Coordinates::Zero()};
    const Taylor3 share{w, 1 / length_, 0, 0};
    if (turn_) put(turn_->at(share), 3, end);
    if (arc_) put(arc_->at(share), 0, end);
    return end;
}

}  // namespace trunnion::smoothing
