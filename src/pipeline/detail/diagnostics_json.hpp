#pragma once

#include <vector>

#include <nlohmann/json.hpp>

#include "trunnion/base/diagnostic.hpp"

namespace trunnion::pipeline {

/// diagnostics[] of a summary, of a plan or a prediction.
inline nlohmann::ordered_json diagnostics_json(const std::vector<Diagnostic>& diagnostics) {
    nlohmann::ordered_json out = nlohmann::ordered_json::array();
    for (const Diagnostic& d : diagnostics)
        out.push_back({{"code", d.code},
                       {"severity", to_string(d.severity)},
                       {"line", d.place.line},
                       {"text", d.text},
                       {"value", d.value},
                       {"limit", d.limit},
                       {"count", d.count},
                       {"hint", d.hint}});
    return out;
}

}  // namespace trunnion::pipeline
