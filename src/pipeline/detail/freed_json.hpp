#pragma once

#include <array>
#include <cstddef>

#include <nlohmann/json.hpp>

#include "trunnion/base/quantity.hpp"
#include "trunnion/pipeline/surface.hpp"

namespace trunnion::pipeline {

inline const char* kind_text(const surfacing::Gouge& gouge) {
    constexpr std::array kinds{"local", "rear", "global", "holder"};  // order of surfacing::GougeKind
    return kinds[static_cast<std::size_t>(gouge.kind)];
}

inline nlohmann::ordered_json point_json(const Eigen::Vector3d& at) {
    return {at.x(), at.y(), at.z()};
}

inline nlohmann::ordered_json freed_json(const FreedAccount& freed) {
    nlohmann::ordered_json worst;
    if (freed.worst)
        worst = {{"depth_mm", freed.worst->depth_mm},
                 {"kind", kind_text(*freed.worst)},
                 {"face", freed.worst_face},
                 {"at_mm", point_json(freed.worst->at_mm)}};
    const auto& [local, rear, global, holder] = freed.gouges;
    return {{"gouges", {{"local", local}, {"rear", rear}, {"global", global}, {"holder", holder}}},
            {"worst", worst},
            {"tolerance_mm", freed.tolerance_mm},
            {"passes_turned", freed.passes_turned},
            {"largest_turn_deg", freed.largest_turn_rad / degree},
            {"largest_step_deg", freed.largest_step_rad / degree},
            {"rounds", freed.rounds},
            {"links_raised", freed.links_raised},
            {"highest_link_mm", freed.highest_link_mm}};
}

}  // namespace trunnion::pipeline
