#pragma once

#include <memory>
#include <optional>
#include <variant>
#include <vector>

#include "trunnion/base/result.hpp"
#include "trunnion/feed/interval.hpp"
#include "trunnion/path/run.hpp"
#include "trunnion/program/program.hpp"

#include "detail/stretch.hpp"

namespace trunnion::pipeline {

/// The moves up to the next standstill that the program asks for begin here.
struct RunBegin {
    std::shared_ptr<const program::Program> program;  ///< the part that the run is of
    std::vector<path::RunEvent> events;
    std::size_t blocks = 0;
};

struct StretchBegin {
    std::shared_ptr<const Stretch> stretch;
    std::size_t first_block = 0;  ///< of the run
    double share_at_end = 0;      ///< Element::share behind its last interval
};

/// The next intervals of the stretch; the last batch ends it.
struct IntervalBatch {
    std::vector<feed::Interval> intervals;
    bool last = false;
};

struct RunEnd {};

/// What the geometry of a program is handed on in, in the program's order.
struct Element {
    std::variant<RunBegin, StretchBegin, IntervalBatch, RunEnd> content;
    double share = 0;  ///< of the program's moves that are through with this element, ascending
};

/// The next element, none behind the last one, or the error that ends all.
using NextElement = Result<std::optional<Element>>;

}  // namespace trunnion::pipeline
