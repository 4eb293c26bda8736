#pragma once

#include "trunnion/nc/read.hpp"
#include "trunnion/nc/write.hpp"
#include "trunnion/program/program.hpp"

#include "arguments.hpp"

/// Words of programs and dialects.
namespace trunnion::python {

inline constexpr Word<nc::Dialect> dialects[]{{"apt", nc::Dialect::apt},
                                              {"rs274", nc::Dialect::rs274},
                                              {"sinumerik", nc::Dialect::sinumerik},
                                              {"heidenhain", nc::Dialect::heidenhain},
                                              {"fanuc", nc::Dialect::fanuc}};
inline constexpr Word<nc::Units> length_units[]{{"mm", nc::Units::mm}, {"inch", nc::Units::inch}};
inline constexpr Word<nc::CurveForm> curve_forms[]{{"own", nc::CurveForm::own},
                                                   {"bspline", nc::CurveForm::bspline},
                                                   {"poly", nc::CurveForm::poly},
                                                   {"nurbs", nc::CurveForm::nurbs},
                                                   {"points", nc::CurveForm::points}};
inline constexpr Word<program::OrientationLaw> laws[]{{"vector", program::OrientationLaw::vector},
                                                      {"rotary", program::OrientationLaw::rotary}};
inline constexpr Word<program::EventKind> event_kinds[]{
    {"dwell", program::EventKind::dwell},     {"tool", program::EventKind::tool},
    {"spindle", program::EventKind::spindle}, {"coolant", program::EventKind::coolant},
    {"stop", program::EventKind::stop},       {"other", program::EventKind::other}};

}  // namespace trunnion::python
