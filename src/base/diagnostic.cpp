#include "trunnion/base/diagnostic.hpp"

#include <cmath>

#include <fmt/format.h>

namespace trunnion {

std::string_view to_string(Severity severity) {
    switch (severity) {
        case Severity::note:
            return "note";
        case Severity::warning:
            return "warning";
        case Severity::error:
            break;
    }
    return "error";
}

namespace {

std::string place_prefix(const Place& place) {
    std::string out = place.file;
    if (place.line > 0) out += fmt::format("{}{}", out.empty() ? "line " : ":", place.line);
    if (place.line > 0 && place.column > 0) out += fmt::format(":{}", place.column);
    if (std::isfinite(place.path_length_mm))
        out += fmt::format("{}at {:.3f} mm of the path", out.empty() ? "" : " ", place.path_length_mm);
    return out.empty() ? out : out + ": ";
}

std::string value_and_limit(const Diagnostic& d) {
    if (!d.value.empty() && !d.limit.empty()) return fmt::format(" ({}, limit {})", d.value, d.limit);
    if (!d.value.empty()) return fmt::format(" ({})", d.value);
    if (!d.limit.empty()) return fmt::format(" (limit {})", d.limit);
    return {};
}

}  // namespace

std::string to_string(const Diagnostic& d) {
    std::string out = place_prefix(d.place);
    out += fmt::format("{} {}: {}{}", to_string(d.severity), d.code, d.text, value_and_limit(d));
    if (d.count > 1) out += fmt::format(" [{} times]", d.count);
    if (!d.hint.empty()) out += "; " + d.hint;
    return out;
}

}  // namespace trunnion
