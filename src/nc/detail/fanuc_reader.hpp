#pragma once

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "trunnion/base/quantity.hpp"

#include "detail/arcs.hpp"
#include "detail/dialects.hpp"
#include "detail/fanuc_block.hpp"
#include "detail/fanuc_interpreter.hpp"
#include "detail/fanuc_words.hpp"
#include "detail/findings.hpp"
#include "detail/rs274_control.hpp"
#include "detail/sinumerik_frames.hpp"

namespace trunnion::nc::fanuc {

using sinumerik::CoordinateFrame;

inline constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
/// Circles: what a post rounds away is smaller; the control itself compares the radii only where a parameter asks.
inline constexpr ArcTolerance fanuc_arcs{0.01, 1e-3, std::numeric_limits<double>::infinity(), 0.01};

using RotaryWords = std::array<double, program::max_rotary_letters>;

/// The letters of one block but G and M, with their values as written.
class Letters {
  public:
    void clear() { said_ = used_ = 0; }
    bool has(char letter) const { return (said_ & bit(letter)) != 0; }
    bool has_any(std::string_view letters) const {
        for (const char letter : letters)
            if (has(letter)) return true;
        return false;
    }
    void put(const Word& word) {
        said_ |= bit(word.letter);
        words_[index(word.letter)] = word;
    }
    double operator[](char letter) const { return words_[index(letter)].value; }
    double get(char letter, double otherwise) const { return has(letter) ? (*this)[letter] : otherwise; }
    const Word& word(char letter) const { return words_[index(letter)]; }
    /// Marks that letters have been made use of.
    void use(std::string_view letters) {
        for (const char letter : letters) used_ |= bit(letter);
    }
    void use_mask(std::uint32_t letters) { used_ |= letters; }
    std::uint32_t said() const { return said_; }
    /// A letter without use in its block.
    std::optional<char> left_over() const {
        const std::uint32_t rest = said_ & ~used_;
        if (rest == 0) return {};
        return static_cast<char>('A' + std::countr_zero(rest));
    }
    static constexpr std::size_t index(char letter) { return static_cast<std::size_t>(letter - 'A'); }
    static constexpr std::uint32_t bit(char letter) { return 1u << index(letter); }

  private:
    std::array<Word, 26> words_;
    std::uint32_t said_ = 0, used_ = 0;
};

/// The words that stay in force from block to block.
struct Modes {
    Meaning motion = Meaning::unknown;
    Meaning feed_kind = Meaning::per_minute;
    Meaning length = Meaning::no_length;
    int normal_axis = 2;  ///< across the plane of G17, G18, G19
    bool absolute = true, exact_stop = false, return_to_r = false;
    bool own_tcp = false;  ///< by a word of the machine file
    double unit_mm = 1, feed_unit_mm = 1;
    double feed = 0;  ///< as written, per minute or per turn; 0: none
    double spindle_rpm = unknown;
    std::uint16_t offset = 0;
    std::optional<int> length_number;  ///< H
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
    std::optional<double> speed_mm_s{};  ///< empty: the feed in force
    std::optional<program::Arc> arc{};   ///< in the work offset's frame
};

/// What a drilling cycle keeps from block to block. Levels are coordinates along the axis across the plane.
struct DrillingCycle {
    int number = 0;  ///< 0: none
    double initial = unknown, r = unknown, bottom = unknown;
    double peck_mm = 0, dwell_s = 0;
    double shift_first_mm = 0, shift_second_mm = 0;
    bool return_left_out = false;  ///< G98 to an initial level that is not known
};

/// A G06.2 that is being read: control points, in the programmed frame, and knots.
struct NurbsInProgress {
    std::size_t order = 4;
    Spot spot;
    Eigen::Vector3d start_mm = Eigen::Vector3d::Zero();
    RotaryWords start_rad{};
    program::Curve curve;
    program::Feed feed;
    bool turns = false;  ///< rotary words are said
    bool only_knots = false;
};

/// Carries out the blocks that the interpreter hands over. fanuc_reader.cpp: words, modes, tools; fanuc_motion.cpp:
/// where a block goes, how fast, and which poses are kept; fanuc_frames.cpp: shifts, rotations, tilted planes;
/// fanuc_cycles.cpp: drilling; fanuc_nurbs.cpp: curves.
class FanucReader final : public BlockReader, private ControlParameters {
  public:
    FanucReader(const ProgramText& text, std::string_view file_name, const ReadOptions& options, Control control);

    Step read_block() override;
    bool finish() override;
    int line() const override { return block_.line; }
    const ProgramText& text() const override { return interpreter_.text(); }
    std::size_t position() const override { return interpreter_.position(); }
    bool waits() const override { return nurbs_.has_value(); }
    char rotary_letter(std::size_t axis) const override { return control_.rotary_letter(axis); }
    bool is_said(std::size_t axis) const override { return (rotary_ever_ & (1u << axis)) != 0; }

  private:
    // words
    bool block();
    bool sort_words();
    bool sort_letter(const Word& word);
    bool sort_code(const Word& word);
    bool own_word(const Word& word, int tenths);
    bool not_supported(const WordRule& rule, const Word& word);
    bool enter_group(const WordRule& rule, const Word& word);
    bool absent_axis(const Word& word);
    bool modes();
    void units();
    bool feed();
    bool speed_and_tool();
    bool change_tool();
    bool offset();
    bool length();
    bool carry_out();
    bool dwell();
    bool data_setting();
    bool offset_data(int number);
    bool check_use();
    bool stops();
    bool whole(const Word& word, int most, int& number);
    void events();
    void tell_number_without_point(const Word& word);

    // motion
    bool motion();
    bool count_in(bool machine_position);
    bool upright() const;
    bool axis_words(Eigen::Vector3d& to);
    bool circle(const Eigen::Vector3d& to, Way& way);
    bool turns_of(const Eigen::Vector3d& step, double angle_rad, double& further);
    bool centre_words();
    bool tool_vector();
    bool go(const Eigen::Vector3d& to, const Way& way);
    bool leave_out(const Way& way);
    bool said_since_reference(const Way& way);
    bool reference();
    bool machine_position_in_g91();
    bool send_home(std::uint32_t letters);
    void leave_unknown(std::uint32_t letters);
    bool path_speed(double& speed_mm_s);
    bool feed_of(program::Move& move, const Way& way);
    program::Move move_to(const Eigen::Vector3d& position_mm, program::MoveKind kind) const;
    void add(const program::Move& move);
    Spot spot_of_motion() const;
    bool never_started();
    void tell_assumptions();

    // frames
    bool linear_words(Eigen::Vector3d& values, double otherwise);
    bool no_rotary_words();
    std::uint32_t rotary_mask() const;
    bool local_shift();
    bool preset();
    bool mirror(bool on);
    bool rotation();
    bool no_rotation();
    bool tilted_plane();
    bool swivel();
    bool dynamic_offset(bool on);
    bool turn_dynamic_frame();
    void frames_changed();
    CoordinateFrame frame_in_force() const;
    bool turned() const { return !rotation_.is_identity() || plane_said_; }

    // cycles
    bool begin_cycle(int number);
    bool cycle_words();
    bool cycle_lengths();
    bool drill();
    bool hole(const Eigen::Vector3d& at);
    bool carry_out_cycle();
    bool to_level(double level, bool rapid, std::optional<double> speed_mm_s = {});
    bool drill_down(double level) { return to_level(level, false); }
    bool back_out();
    bool aside(double sense);
    bool pecks();
    bool tap();
    bool back_bore();
    bool cycle_dwell();
    bool cycle_spindle(std::string word) { return event(program::EventKind::spindle, true, std::move(word)); }

    // curves
    bool nurbs_block();
    bool begin_nurbs();
    bool control_point();
    bool end_nurbs();
    bool check_nurbs();
    bool keep_curve();

    Answer read(const ParameterReference& parameter, ParameterValue& value) const override;

    /// True, so that the word is done with it.
    bool event(program::EventKind kind, bool stops, std::string word, double dwell_s = 0) {
        program_.events.push_back({kind, stops, dwell_s, std::move(word), program_.moves.size(), block_.line});
        return true;
    }
    bool refuse(std::string_view code, const Spot& spot, std::string text, std::string_view value = {},
                std::string_view hint = {}) {
        return findings_.refuse(code, spot, std::move(text), value, hint);
    }
    bool refuse(std::string_view code, const Word& word, std::string text, std::string_view hint = {}) {
        return findings_.refuse(code, block_.spot(word), std::move(text), fmt::format("{}{}", word.letter, word.value),
                                hint);
    }
    Spot spot(char letter) const { return block_.spot(said_.word(letter)); }
    Meaning asked(Group group) const { return groups_[static_cast<std::size_t>(group)]; }
    const Word& code_of(Group group) const { return codes_[static_cast<std::size_t>(group)]; }
    double length_of(char letter) const { return said_[letter] * modes_.unit_mm; }
    bool is_axis(char letter) const { return (control_.axis_letters() & Letters::bit(letter)) != 0; }
    bool tcp() const {
        return modes_.own_tcp || modes_.length == Meaning::tcp_rotary || modes_.length == Meaning::tcp_vector;
    }

    Control control_;
    Interpreter interpreter_;
    Block block_;
    Modes modes_;
    UnitStatement stated_;

    // of the block
    Letters said_;
    std::array<Meaning, static_cast<std::size_t>(Group::count)> groups_{};
    std::array<Word, static_cast<std::size_t>(Group::count)> codes_{};
    bool exact_stop_once_ = false, loose_letters_ = false;

    // the tool
    std::string tool_;
    std::optional<std::string> prepared_tool_;
    std::uint16_t in_spindle_ = 0, length_tool_ = 0;  ///< in Program::tools

    // where things stand
    CountedIn counted_in_;
    CoordinateFrame rotation_, mirror_, plane_, dynamic_;
    Eigen::Vector3d preset_mm_ = Eigen::Vector3d::Zero(), local_mm_ = Eigen::Vector3d::Zero();
    std::map<std::uint16_t, Eigen::Vector3d> offset_shift_mm_, offset_data_;  ///< by offset, of G10
    CoordinateFrame frame_;                                                   ///< that counted_in_ counts in
    Eigen::Vector3d position_mm_, programmed_mm_;  ///< in the offset's frame and in frame_; unknown: stays
    Eigen::Vector3d mirror_at_ = Eigen::Vector3d::Zero();
    std::array<bool, 3> mirrored_{};
    RotaryWords rotary_rad_;         ///< by the machine's rotary axes; unknown: as they stand
    std::uint32_t rotary_ever_ = 0;  ///< bit of each rotary axis with a word
    std::uint32_t at_reference_ =
        0;  ///< letters of axes that were sent where only the control knows and not said since
    program::OrientationLaw law_ = program::OrientationLaw::rotary;
    Eigen::Vector3d axis_ = Eigen::Vector3d::UnitZ();  ///< of law vector, in the offset's frame
    bool plane_said_ = false;                          ///< G68.2
    bool swivelled_ = false;                           ///< and G53.1
    bool whole_pose_needed_ = false;  ///< X, Y and Z must be known before anything moves: the tool was swivelled
    bool rapid_left_out_ = false;     ///< the programmed place was not gone to: something of it was not known
    bool dynamic_on_ = false;
    DrillingCycle cycle_;
    std::optional<NurbsInProgress> nurbs_;
    bool axis_words_ever_ = false, finished_ = false, data_mode_ = false;
    Spot last_motion_;
};

}  // namespace trunnion::nc::fanuc
