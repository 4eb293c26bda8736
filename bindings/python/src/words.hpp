#pragma once

#include "trunnion/geometry/surface_shape.hpp"

#include "arguments.hpp"

/// Words that stand for the choices of the library.
namespace trunnion::python {

inline constexpr Word<geometry::Side> sides[]{{"along", geometry::Side::along}, {"against", geometry::Side::against}};

}  // namespace trunnion::python
