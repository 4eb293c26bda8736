#pragma once

#include <string>
#include <utility>

#include "trunnion/base/diagnostic.hpp"

namespace trunnion::verify {

/// A diagnostic at a line of the program or of a table.
inline Diagnostic fault_at(int line, std::string code, std::string text, std::string file = {}) {
    Diagnostic out;
    out.code = std::move(code);
    out.text = std::move(text);
    out.place.file = std::move(file);
    out.place.line = line;
    return out;
}

}  // namespace trunnion::verify
