#include "detail/doubts.hpp"

#include <algorithm>
#include <cmath>

#include "detail/stops.hpp"

namespace trunnion::controller {

using motion::Controller;
using motion::ParameterId;

namespace {

bool is_of_stops(ParameterId id) {
    return id == ParameterId::tool_change_time || id == ParameterId::spindle_time || id == ParameterId::other_stop_time;
}

}  // namespace

Doubts::Doubts(const Controller& controller, const program::Program& program) {
    for (std::size_t i = 0; i < motion::parameter_count; ++i) {
        const auto id = static_cast<ParameterId>(i);
        const auto [low, high] = motion::truth_of(controller[id], motion::facts_of(id));
        if (motion::is_used(controller, id) && low < high) add_pair(controller, id, low, high, program);
    }
}

void Doubts::add_pair(const Controller& controller, ParameterId id, double low, double high,
                      const program::Program& program) {
    for (const double value : {low, high}) {
        Variant variant{.id = id, .controller = controller};
        variant.controller[id].value = value;
        variant.time_s = stop_times(program, variant.controller).sum_s();
        variants_.push_back(std::move(variant));
    }
}

void Doubts::add(const path::Run& run, const RunGeometry& geometry, const machine::Machine& machine) {
    double unchanged = -1;
    for (Variant& variant : variants_) {
        const bool same_motion = is_of_stops(variant.id);
        if (same_motion && unchanged < 0)
            unchanged = planner_.plan(run, geometry, machine, variant.controller, nullptr);
        variant.time_s += same_motion ? unchanged : planner_.plan(run, geometry, machine, variant.controller, nullptr);
    }
}

void Doubts::finish(motion::Prediction& prediction) const {
    for (std::size_t i = 0; i + 1 < variants_.size(); i += 2) {
        const Variant &low = variants_[i], &high = variants_[i + 1];
        prediction.doubts.push_back({std::string(motion::facts_of(low.id).key), low.controller[low.id].value,
                                     high.controller[high.id].value, low.time_s, high.time_s});
    }
    sum_up_doubts(prediction);
}

void sum_up_doubts(motion::Prediction& prediction) {
    const auto difference = [](const motion::Doubt& doubt) { return std::abs(doubt.time_high_s - doubt.time_low_s); };
    double squares = 0;
    for (const motion::Doubt& doubt : prediction.doubts) squares += 0.25 * difference(doubt) * difference(doubt);
    std::ranges::stable_sort(prediction.doubts, std::ranges::greater{}, difference);
    prediction.uncertainty_s = std::sqrt(squares);
}

}  // namespace trunnion::controller
