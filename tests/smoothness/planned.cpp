#include "planned.hpp"

#include <utility>

#include "../unit/feed/synthetic_paths.hpp"

namespace trunnion::test {

namespace {

template <class T>
T value_of(Result<T> result) {
    if (!result) throw std::runtime_error(to_string(result.error()));
    return std::move(*result);
}

constexpr std::size_t one_window = std::numeric_limits<std::size_t>::max() / 4;

}  // namespace

const machine::Machine& trunnion_table() {
    static const machine::Machine machine = five_axis_machine(trunnion_limits());
    return machine;
}

const machine::Kinematics& table_kinematics() {
    static const machine::Kinematics kinematics = value_of(
        machine::Kinematics::make(trunnion_table(), {Eigen::Vector3d(0, 0, 50), Eigen::Matrix3d::Identity()}, 0));
    return kinematics;
}

std::vector<path::ToolPath> smoothed(const path::Run& run, const smoothing::SmoothingOptions& options) {
    std::vector<path::ToolPath> out;
    smoothing::smooth(run, options, out);
    return out;
}

path::ToolPath smoothed_to_one(const path::Run& run, const smoothing::SmoothingOptions& options) {
    std::vector<path::ToolPath> stretches = smoothed(run, options);
    if (stretches.size() != 1) throw std::runtime_error("the run stands still inside");
    return std::move(stretches.front());
}

Planned::Planned(path::ToolPath path) : path_(std::move(path)) {
    axis_path_ = std::make_unique<path::AxisPath>(value_of(path::AxisPath::make(path_, trunnion_table(), {})));
    plan_ = value_of(feed::plan_stretch(*axis_path_, {.calm = 0, .window = one_window}));
}

std::vector<Planned::State> Planned::walked(double step_s) const {
    std::vector<State> states;
    std::size_t at = 0;
    for (double time = 0; time <= duration_s(); time += step_s) {
        const auto& pieces = plan_.profile.pieces;
        while (at + 1 < pieces.size() && pieces[at + 1].begin_s <= time) ++at;
        const motion::ProfilePiece& piece = pieces[at];
        const double delta = motion::distance_at(piece, time - piece.begin_s);
        const auto q = path::evaluate(path_.pieces[piece.path_piece], piece.path_offset_mm + delta);
        State state{time, {q[0].value(), q[1].value(), q[2].value()}, {q[3].value(), q[4].value(), q[5].value()}, 0};
        if (path_.law == path::OrientationLaw::vector) {
            const double length = std::hypot(state.orientation[0], state.orientation[1], state.orientation[2]);
            for (double& n : state.orientation) n /= length;
        }
        state.tip_speed_mm_s = motion::state_at(piece, delta).speed_mm_s * std::hypot(q[0].d1(), q[1].d1(), q[2].d1());
        states.push_back(state);
    }
    return states;
}

}  // namespace trunnion::test
