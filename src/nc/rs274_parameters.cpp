#include <algorithm>
#include <iterator>

#include "detail/rs274_reader.hpp"

namespace trunnion::nc {

namespace {

constexpr std::string_view axis_order = "XYZABCUVW";
constexpr int first_position = 5420, offset_number = 5220;

/// What the control knows of itself and a program without it does not.
constexpr std::string_view other_states[] = {"_vmajor",
                                             "_vminor",
                                             "_line",
                                             "_motion_mode",
                                             "_plane",
                                             "_ccomp",
                                             "_coord_system",
                                             "_tool_offset",
                                             "_retract_r_plane",
                                             "_retract_old_z",
                                             "_spindle_rpm_mode",
                                             "_spindle_css_mode",
                                             "_ijk_absolute_mode",
                                             "_lathe_diameter_mode",
                                             "_lathe_radius_mode",
                                             "_spindle_on",
                                             "_spindle_cw",
                                             "_mist",
                                             "_flood",
                                             "_speed_override",
                                             "_feed_override",
                                             "_adaptive_feed",
                                             "_feed_hold",
                                             "_feed",
                                             "_rpm",
                                             "_current_tool",
                                             "_current_pocket",
                                             "_selected_tool",
                                             "_selected_pocket",
                                             "_task",
                                             "_call_level",
                                             "_remap_level"};

/// Probe results, home positions, offsets, tool data and messages.
bool is_the_controls(int number) {
    return (number >= 5061 && number <= 5070) || (number >= 5161 && number <= 5390) ||
           (number >= 5399 && number <= 5428) || number == 5599 || number == 5600 || number == 5601;
}

/// 1 … 9 for G54 … G59.3.
double number_of_offset(std::string_view name) {
    if (name.size() > 3) return 6 + (name.back() - '0');
    return name.back() - '3';
}

}  // namespace

/// Where the axis stands, as words count, in the unit in force.
ControlParameters::Answer Rs274Reader::position_parameter(std::size_t axis, ParameterValue& value) const {
    const char letter = axis_order[axis];
    const std::size_t index = Block::index(letter);
    if ((control_.axis_letters() & Block::bit(letter)) == 0) {
        value = 0;
        return Answer::known;
    }
    const std::size_t place = control_.axis(index);
    if (control_.kind(index) == Control::Letter::linear) {
        const auto along = static_cast<Eigen::Index>(place);
        value = (position_mm_[along] - word_shift_.mm[along]) / modal_.unit_mm;
        if (frame_ != frame_in_force()) return Answer::unknown;
    } else {
        value = (rotary_rad_[place] - word_shift_.rad[place]) / degree;
    }
    return std::isnan(*value) ? Answer::unknown : Answer::known;
}

ControlParameters::Answer Rs274Reader::read(const ParameterReference& parameter, ParameterValue& value) const {
    return parameter.name.empty() ? numbered_parameter(parameter.number, value)
                                  : named_parameter(parameter.name, value);
}

ControlParameters::Answer Rs274Reader::numbered_parameter(int number, ParameterValue& value) const {
    if (!is_the_controls(number)) return Answer::not_its_own;
    if (number >= first_position && number < first_position + static_cast<int>(axis_order.size()))
        return position_parameter(static_cast<std::size_t>(number - first_position), value);
    if (number != offset_number) return Answer::unknown;
    value = number_of_offset(program_.offsets[modal_.offset]);
    return Answer::known;
}

ControlParameters::Answer Rs274Reader::named_parameter(std::string_view name, ParameterValue& value) const {
    if (!name.starts_with('_')) return Answer::not_its_own;
    if (name.size() == 2) {
        const std::size_t axis = axis_order.find(upper(name[1]));
        return axis == axis_order.npos ? Answer::not_its_own : position_parameter(axis, value);
    }
    const std::pair<std::string_view, bool> states[] = {
        {"_metric", modal_.unit_mm == 1},
        {"_imperial", modal_.unit_mm != 1},
        {"_absolute", modal_.absolute},
        {"_incremental", !modal_.absolute},
        {"_inverse_time", modal_.feed_mode == FeedMode::inverse_time},
        {"_units_per_minute", modal_.feed_mode == FeedMode::per_minute},
        {"_units_per_rev", modal_.feed_mode == FeedMode::per_turn},
    };
    for (const auto& [state, holds] : states) {
        if (name != state) continue;
        value = holds ? 1 : 0;
        return Answer::known;
    }
    const bool other = std::ranges::find(other_states, name) != std::end(other_states);
    return other || name.starts_with("_ini[") || name.starts_with("_hal[") ? Answer::unknown : Answer::not_its_own;
}

}  // namespace trunnion::nc
