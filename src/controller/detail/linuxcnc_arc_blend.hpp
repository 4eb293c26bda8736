#pragma once

#include <optional>

#include "trunnion/controller/linuxcnc.hpp"

#include "detail/linuxcnc_segment.hpp"

namespace trunnion::controller::linuxcnc {

/// An arc that rounds the corner between two segments with linear motion only, and what is left of the two.
struct ArcBlend {
    Segment blend, before, after;
    bool swallows_before = false;  ///< what is left of the first is the blend's straight lead-in
};

/// Empty: no arc is possible.
std::optional<ArcBlend> arc_blend_between(const Segment& before, const Segment& after, const Limits& limits,
                                          const LinuxcncSettings& settings);

}  // namespace trunnion::controller::linuxcnc
