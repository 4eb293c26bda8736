#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace trunnion::pipeline {

/// What summaries of plans and of predictions say in the same words. `Told` is either of them, `Drop` a drop of the
/// feed of either.

/// A report for a person: a name in front of every line.
class ReportLines {
  public:
    void add(std::string_view name, const std::string& value) { text_ += fmt::format("{:<22}{}\n", name, value); }
    template <class Told>
    void add_job(const Told& told) {
        add("program", fmt::format("{} ({}, {} blocks)", told.program, told.dialect, told.blocks));
        add("machine", told.machine + (told.setup.empty() ? "" : fmt::format(", setup {}", told.setup)));
    }
    const std::string& text() const { return text_; }

  private:
    std::string text_;
};

/// The drops that cost most, at most three.
template <class Drop>
std::vector<Drop> worst_of(std::vector<Drop> drops) {
    constexpr std::size_t most = 3;
    std::ranges::stable_sort(drops, std::ranges::greater{}, &Drop::lost_s);
    drops.resize(std::min(drops.size(), most));
    return drops;
}

template <class Drop>
std::string drop_text(const Drop& drop, std::string_view cause) {
    return fmt::format("line {}, {:.1f} … {:.1f} mm: down to {:.0f} of {:.0f} mm/min, {:.3f} s lost, {}", drop.line,
                       drop.s_from_mm, drop.s_to_mm, drop.feed_min_mm_s * 60, drop.programmed_feed_mm_s * 60,
                       drop.lost_s, cause);
}

template <class Drop>
nlohmann::ordered_json drop_json(const Drop& drop, std::string_view cause) {
    return {{"line", drop.line},
            {"s_from_mm", drop.s_from_mm},
            {"s_to_mm", drop.s_to_mm},
            {"feed_min_mm_min", drop.feed_min_mm_s * 60},
            {"programmed_feed_mm_min", drop.programmed_feed_mm_s * 60},
            {"lost_s", drop.lost_s},
            {"cause", cause}};
}

template <class Told>
void set_job(nlohmann::ordered_json& out, const Told& told) {
    out["program"] = told.program;
    out["dialect"] = told.dialect;
    out["machine"] = told.machine;
    out["setup"] = told.setup;
}

template <class Told>
void set_times(nlohmann::ordered_json& out, const Told& told) {
    out["cut_time_s"] = told.cut_time_s;
    out["rapid_time_s"] = told.rapid_time_s;
    out["dwell_time_s"] = told.dwell_time_s;
}

/// null where there is none.
inline nlohmann::ordered_json finite_or_null(double value) {
    return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json(nullptr);
}

}  // namespace trunnion::pipeline
