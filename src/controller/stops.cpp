#include "detail/stops.hpp"

namespace trunnion::controller {

using motion::ParameterId;
using program::EventKind;

StopTimes stop_time(const program::Event& event, const motion::Controller& controller) {
    StopTimes out;
    if (event.kind == EventKind::dwell)
        out.dwell_s = event.dwell_s;
    else if (!event.stops_motion)
        return out;
    else if (event.kind == EventKind::tool)
        out.tool_change_s = controller[ParameterId::tool_change_time].value;
    else
        out.other_s =
            controller[event.kind == EventKind::spindle ? ParameterId::spindle_time : ParameterId::other_stop_time]
                .value;
    return out;
}

StopTimes stop_times(const program::Program& program, const motion::Controller& controller) {
    StopTimes out;
    for (const program::Event& event : program.events) {
        const StopTimes one = stop_time(event, controller);
        out.dwell_s += one.dwell_s;
        out.tool_change_s += one.tool_change_s;
        out.other_s += one.other_s;
    }
    return out;
}

}  // namespace trunnion::controller
