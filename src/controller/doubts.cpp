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
        const motion::Parameter& parameter = controller[id];
        if (!motion::is_used(controller, id) || !(parameter.spread > 0) || !std::isfinite(parameter.value)) continue;
        const auto& facts = motion::facts_of(id);
        double low = std::clamp(parameter.value - parameter.spread, facts.least, facts.most);
        double high = std::clamp(parameter.value + parameter.spread, facts.least, facts.most);
        if (facts.whole) low = std::floor(low), high = std::ceil(high);
        add_pair(controller, id, low, high, program);
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
    double squares = 0;
    for (std::size_t i = 0; i + 1 < variants_.size(); i += 2) {
        const Variant &low = variants_[i], &high = variants_[i + 1];
        const double half = 0.5 * std::abs(high.time_s - low.time_s);
        squares += half * half;
        prediction.doubts.push_back({std::string(motion::facts_of(low.id).key), low.controller[low.id].value,
                                     high.controller[high.id].value, low.time_s, high.time_s});
    }
    std::ranges::stable_sort(prediction.doubts, std::ranges::greater{},
                             [](const motion::Doubt& doubt) { return std::abs(doubt.time_high_s - doubt.time_low_s); });
    prediction.uncertainty_s = std::sqrt(squares);
}

}  // namespace trunnion::controller
