#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "detail/heidenhain_reader.hpp"

namespace trunnion::nc::heidenhain {

/// One call of a drilling cycle, where the tool is. The levels of the cycle are raised by `raised_mm`. Errors: NC0705.
class DrillingCycle {
  public:
    DrillingCycle(HeidenhainReader& reader, std::size_t place, double raised_mm)
        : reader_(reader), place_(place), unit_mm_(reader.unit_mm()), raised_mm_(raised_mm) {}

    bool run();
    /// The level from which the hole is begun.
    bool levels();
    double start_mm() const { return start_; }

  private:
    bool refuse(std::string text, std::string_view value = {}) {
        return reader_.refuse("NC0705", place_, std::move(text), value);
    }
    bool number(int parameter, double& value);
    bool length(int parameter, double& value_mm);
    double optional(int parameter, double otherwise) const;
    bool speed(int parameter, std::optional<double>& speed_mm_s);
    bool to(double level, bool rapid, std::optional<double> speed_mm_s = {});
    bool rapid(double level) { return to(level, true); }
    bool feed(double level) { return to(level, false, speed_); }
    bool dwell(double time_s);
    bool back(const std::optional<double>& speed_mm_s);
    bool peck_once();
    bool drill();
    bool ream();
    bool universal_drilling();
    bool universal_pecking();
    bool strokes(double first, double decrease, double least, std::vector<double>& depths);
    bool tap(bool rigid);
    bool centre_drill();

    HeidenhainReader& reader_;
    std::size_t place_;
    double unit_mm_, raised_mm_;
    double surface_ = 0, start_ = 0, bottom_ = 0, retract_ = 0, clearance_ = 0;
    std::optional<double> speed_;  ///< of plunging; empty: rapid
};

}  // namespace trunnion::nc::heidenhain
