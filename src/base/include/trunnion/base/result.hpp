#pragma once

#include <expected>

#include "trunnion/base/diagnostic.hpp"

namespace trunnion {

/// Either a value or the diagnostic that says why there is none.
template <class T>
using Result = std::expected<T, Diagnostic>;

/// Shorthand for the failing side of a Result.
inline std::unexpected<Diagnostic> fail(Diagnostic diagnostic) {
    return std::unexpected(std::move(diagnostic));
}

}  // namespace trunnion
