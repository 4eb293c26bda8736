#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "trunnion/base/quantity.hpp"

#include "detail/arcs.hpp"
#include "detail/dialects.hpp"
#include "detail/findings.hpp"
#include "detail/heidenhain_frames.hpp"
#include "detail/heidenhain_interpreter.hpp"
#include "detail/heidenhain_words.hpp"
#include "detail/rs274_control.hpp"

namespace trunnion::nc::heidenhain {

inline constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

/// Addresses of a path block that have a number.
enum class Address : std::uint8_t {
    x,
    y,
    z,
    rotary_1,
    rotary_2,
    rotary_3,
    nx,
    ny,
    nz,
    tx,
    ty,
    tz,
    radius,        ///< R with a sign
    polar_radius,  ///< PR
    polar_angle,   ///< PA
    count
};
inline constexpr std::size_t address_count = static_cast<std::size_t>(Address::count);

/// The addresses of one block.
class Addresses {
  public:
    void clear() { said_ = incremental_ = 0; }
    bool has(Address a) const { return (said_ & bit(a)) != 0; }
    bool has_any(Address first, Address last) const { return (said_ & (bit(last) * 2 - bit(first))) != 0; }
    bool has_all(Address first, Address last) const {
        const std::uint32_t bits = bit(last) * 2 - bit(first);
        return (said_ & bits) == bits;
    }
    bool is_incremental(Address a) const { return (incremental_ & bit(a)) != 0; }
    double operator[](Address a) const { return value_[index(a)]; }
    std::size_t place(Address a) const { return place_[index(a)]; }
    void put(Address a, double value, bool incremental, std::size_t place) {
        said_ |= bit(a);
        if (incremental) incremental_ |= bit(a);
        value_[index(a)] = value;
        place_[index(a)] = place;
    }
    /// The first address that is said beyond those from `first` to `last`.
    std::optional<Address> other_than(std::uint32_t allowed) const;
    static constexpr std::uint32_t bits(Address first, Address last) { return bit(last) * 2 - bit(first); }

  private:
    static constexpr std::size_t index(Address a) { return static_cast<std::size_t>(a); }
    static constexpr std::uint32_t bit(Address a) { return 1u << index(a); }

    std::array<double, address_count> value_{};
    std::array<std::size_t, address_count> place_{};
    std::uint32_t said_ = 0, incremental_ = 0;
};

/// The feed that a block says.
enum class FeedWord : std::uint8_t { none, value, rapid, of_tool_call, per_turn };

/// An M word of a block, and what stands behind it.
struct MWord {
    int number = 0;
    std::size_t place = 0;
    bool to_limit = false;  ///< M140 MB MAX
    double distance = 0;    ///< M140 MB
    FeedWord feed_word{};   ///< M140 F
    double feed = 0;
    std::uint32_t rotary_axes = 0;  ///< M94: bits of the axes; 0: all
};

/// The words that stay in force from block to block.
struct Modes {
    bool transform = false;       ///< M128, FUNCTION TCPM
    bool spatial_angles = false;  ///< AXIS SPAT
    bool vectors = false;         ///< PATHCTRL VECTOR
    bool axes_in_feed = false;    ///< F CONT
    bool rotary_in_mm = false;    ///< M116
    bool shortest = false;        ///< M126
    bool per_turn = false;        ///< M136: F is mm per turn
    bool feed_per_turn = false;   ///< the feed in force is
    double feed = 0;              ///< mm/min or mm per turn; 0: none
    double tool_call_feed = 0;
    double spindle_rpm = unknown;
    std::uint16_t offset = 0;
};

/// In what the linear words count; positions of machine axes depend on neither offset nor tool, which are 0 then.
struct CountedIn {
    program::Space space = program::Space::untransformed;
    std::uint16_t offset = 0, tool = 0;
    bool operator==(const CountedIn&) const = default;
};

/// How to get to a place.
struct Way {
    bool rapid = false;
    std::optional<double> speed_mm_s{};  ///< of a cycle; empty: the feed in force
    std::optional<program::Arc> arc{};   ///< in the offset's frame
};

/// RND, until the next line is known.
struct Corner {
    double radius_mm = 0;
    std::optional<double> speed_mm_s{};
    Spot spot{};
    int line = 0;
};

/// Which way a circle goes: DR+ is counter-clockwise.
enum class Turning : std::uint8_t { not_said, counter_clockwise, clockwise };

/// How PLANE goes on: what the axes do now.
enum class Positioning : std::uint8_t { stay, move, turn };

/// Carries out the blocks that the interpreter hands over. heidenhain_reader.cpp: words, modes, tools;
/// heidenhain_motion.cpp: where a block goes, how fast, which poses are kept; heidenhain_circles.cpp: circles, polar
/// coordinates, corners; heidenhain_frames.cpp: datum, cycles 7 … 26, PLANE; heidenhain_cycles.cpp: definitions and
/// calls of cycles; heidenhain_drilling.cpp: drilling.
class HeidenhainReader final : public BlockReader {
  public:
    HeidenhainReader(const ProgramText& text, std::string_view file_name, const ReadOptions& options, Control control);

    Step read_block() override;
    bool finish() override;
    int line() const override { return interpreter_.line(); }
    const ProgramText& text() const override { return interpreter_.text(); }
    std::size_t position() const override { return interpreter_.position(); }
    char rotary_letter(std::size_t axis) const override { return control_.rotary_letter(axis); }
    bool is_said(std::size_t axis) const override { return (rotary_ever_ & (1u << axis)) != 0; }

  private:
    // blocks and words
    bool block();
    bool block_of_kind(BlockKind kind, std::string_view name);
    bool begin();
    bool path_block(BlockKind kind);
    bool path_words();
    bool numbers_alone(std::uint32_t allowed);
    bool word(std::string_view name, std::size_t place);
    bool axis_word(char letter, bool incremental, std::size_t place);
    bool letter_without_axis(char letter, std::size_t place);
    bool put(Address address, bool incremental, std::size_t place);
    bool long_word(std::string_view name, std::size_t place);
    bool radius_word(std::size_t place);
    bool turning_word(std::size_t place);
    bool feed_words(FeedWord& kind, double& value, std::size_t place);
    bool feed_word(std::size_t place);
    bool feed_with_suffix(std::string_view name, std::size_t place);
    bool keep_feed();
    bool m_word(std::size_t place);
    bool words_of_function(MWord& word);
    bool start_functions();
    bool end_functions();
    bool start_function(const MWord& word);
    bool end_function(const MWord& word);
    bool refused_function(const MWord& word);
    bool own_word(int number);
    void reduce_rotary(const MWord& word);
    bool retract(const MWord& word);
    bool retract_to_limit(const Way& way);
    bool retracts_aslant() const;
    bool tool();
    bool tool_call();
    bool tool_name(std::string& name, bool& said);
    bool tool_words();
    bool change_tool(const std::string& name, std::size_t place);
    bool tool_definition();
    bool stop_block();
    bool function_block();
    bool tcpm();
    bool check_addresses(std::uint32_t allowed);
    bool want_end();
    void set_transform(bool on);
    bool speed_of_spindle();

    // motion
    bool line(bool with_vector);
    void count_in(const CountedIn& now);
    CountedIn counting() const;
    bool linear_words(Eigen::Vector3d& to);
    bool rotary_words();
    bool rotary_word(std::size_t axis);
    bool spatial_words();
    bool rotary_in_plane(const Way& way);
    bool turn_to_plane();
    bool vector_words();
    bool tool_vector(Address first, Eigen::Vector3d vector);
    bool whole_vector(Address first, bool& said);
    bool orientation(bool with_vector);
    bool go(const Eigen::Vector3d& to, const Way& way);
    bool leave_out(const Way& way);
    bool path_speed(double& speed_mm_s);
    bool feed_of(program::Move& move, const Way& way);
    bool feed_of_rotation(program::Move& move, double speed_mm_s);
    bool feed_of_axes(program::Move& move, const Way& way, double speed_mm_s);
    void keep(const program::Move& move);
    bool says_call() const;
    std::int32_t add_arc(const program::Arc& arc);
    Spot spot_of_motion() { return cursor().spot(first_word_); }
    bool never_started();
    void tell_assumptions();

    // circles and corners
    bool centre();
    bool circle(BlockKind kind);
    bool polar_place(Eigen::Vector3d& to, bool keeps_radius);
    bool circle_about_centre(const Eigen::Vector3d& from, const Eigen::Vector3d& to, Way& way);
    int plane_of_circle(const Eigen::Vector3d& from, const Eigen::Vector3d& to) const;
    bool helix(const Eigen::Vector3d& from, Eigen::Vector3d& to, Way& way);
    bool tangential_circle(const Eigen::Vector3d& from, const Eigen::Vector3d& to, Way& way);
    bool keep_circle(const Result<program::Arc>& arc, int normal_axis, Way& way);
    Eigen::Vector3d last_direction() const;
    bool rounding();
    bool round_corner(const program::Move& move);
    bool is_corner_of_lines(const program::Move& move) const;
    bool refuse_rounding(std::string_view why, std::string_view value = {});

    // frames
    bool datum();
    bool shift_words();
    bool set_shift(const Eigen::Vector3d& shift_mm, std::size_t place);
    bool mirror();
    bool rotation();
    bool scale();
    bool axis_scale();
    bool working_plane();
    bool trans();
    bool plane();
    bool plane_frame(std::string_view kind, CoordinateFrame& frame);
    bool plane_numbers(const std::array<std::string_view, 6>& names, std::size_t count, std::array<double, 6>& values);
    bool plane_by_vectors(CoordinateFrame& frame);
    bool plane_relative(CoordinateFrame& frame);
    bool positioning(Positioning& how, Way& way);
    bool tilt(const CoordinateFrame& frame, std::size_t place);
    void align_tool();
    bool reset_plane();
    bool turn_back(Positioning how, const Way& way);
    void frames_changed();
    void forget_position();

    // cycles
    bool cycle();
    bool cycle_part(int number, int part, std::size_t place);
    bool old_pecking(int part);
    bool old_dwell();
    bool number_behind_words(double& value);
    bool parameters_of_cycle();
    bool define_cycle(int number, std::size_t place);
    bool cycle_call();
    bool call_cycle(std::size_t place);

    friend class DrillingCycle;

    bool refuse(std::string_view code, const Spot& spot, std::string text, std::string_view value = {},
                std::string_view hint = {}) {
        return findings_.refuse(code, spot, std::move(text), value, hint);
    }
    bool refuse(std::string_view code, std::size_t place, std::string text, std::string_view value = {},
                std::string_view hint = {}) {
        return findings_.refuse(code, cursor().spot(place), std::move(text), value, hint);
    }
    bool event(program::EventKind kind, bool stops, std::string word, double dwell_s = 0) {
        program_.events.push_back({kind, stops, dwell_s, std::move(word), program_.moves.size(), interpreter_.line()});
        return true;
    }
    Cursor& cursor() { return interpreter_.cursor(); }
    Values& values() { return interpreter_.values(); }
    bool inch() const { return options_.units == Units::none ? interpreter_.inch() : options_.units == Units::inch; }
    double unit_mm() const { return inch() ? inch_mm : 1; }
    /// F of a program in inches counts in tenths of an inch.
    double feed_unit_mm() const { return inch() ? inch_mm / 10 : 1; }

    Interpreter interpreter_;
    Control control_;
    Modes modes_;
    UnitStatement stated_;
    std::uint16_t tool_ = 0;  ///< in Program::tools

    // of the block
    Addresses said_;
    Turning turning_ = Turning::not_said;
    FeedWord feed_word_ = FeedWord::none;
    double feed_value_ = 0;
    std::vector<MWord> m_words_;
    bool machine_datum_ = false;
    std::uint32_t to_plane_ = 0;  ///< rotary axes whose word is the plane's own position
    std::size_t first_word_ = 0;

    // where things stand
    CountedIn counted_in_;
    Frames frames_;
    CoordinateFrame frame_;                        ///< that counted_in_ counts in
    Eigen::Vector3d position_mm_, programmed_mm_;  ///< in the offset's frame and in frame_; unknown: stays
    Eigen::Vector3d centre_mm_;                    ///< CC, in frame_; unknown: not said
    bool centre_says_z_ = false;
    std::array<double, program::max_rotary_letters> rotary_rad_{};   ///< by the machine's rotary axes; unknown: stand
    std::array<double, program::max_rotary_letters> reduced_rad_{};  ///< what M94 took off the count of each
    std::array<double, 3> spatial_deg_{};                            ///< A B C under AXIS SPAT
    std::uint32_t rotary_ever_ = 0;
    program::OrientationLaw law_ = program::OrientationLaw::rotary;
    Eigen::Vector3d axis_ = Eigen::Vector3d::UnitZ();  ///< of law vector, in the offset's frame
    bool whole_pose_needed_ = false;  ///< X, Y and Z must be known before anything moves: the plane was tilted
    bool rapid_left_out_ = false;     ///< the programmed place was not gone to: something of it was not known
    std::optional<Corner> corner_;
    int cycle_ = 0;                    ///< the machining cycle that is defined; 0: none
    std::array<double, 6> pecking_{};  ///< of cycle 1, by the part of its definition
    bool modal_call_ = false;
    bool axis_words_ever_ = false, finished_ = false;
    Spot last_motion_;
};

}  // namespace trunnion::nc::heidenhain
