#pragma once

#include <exception>
#include <string>
#include <utility>

#include "trunnion/base/result.hpp"

namespace trunnion::python {

/// On its way to Python, where it is a trunnion.Error.
struct Refusal : std::exception {
    explicit Refusal(Diagnostic what_is_wrong) : diagnostic(std::move(what_is_wrong)) {}
    Diagnostic diagnostic;
};

[[noreturn]] inline void refuse(Diagnostic diagnostic) {
    throw Refusal(std::move(diagnostic));
}

template <class Value>
Value value_of(Result<Value> result) {
    if (!result) refuse(std::move(result.error()));
    return std::move(*result);
}
inline void value_of(Result<void> result) {
    if (!result) refuse(std::move(result.error()));
}

}  // namespace trunnion::python
