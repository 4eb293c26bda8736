#pragma once

#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "trunnion/base/quantity.hpp"

#include "detail/dialects.hpp"
#include "detail/findings.hpp"
#include "detail/rs274_block.hpp"
#include "detail/rs274_control.hpp"
#include "detail/rs274_flow.hpp"
#include "detail/rs274_words.hpp"
#include "detail/surface_words.hpp"

namespace trunnion::nc {

/// Of a coordinate that no block has said yet, or not in this frame: the axis stays where it stands.
inline constexpr double unknown_word = std::numeric_limits<double>::quiet_NaN();

using RotaryWords = std::array<double, program::max_rotary_letters>;

/// In what the linear words count. Of machine positions neither offset nor tool matter: they are 0.
struct Frame {
    program::Space space = program::Space::workpiece;
    std::uint16_t offset = 0, tool = 0;
    bool operator==(const Frame&) const = default;
};

/// What is added to absolute words (G92, G52, G10 L20) to get positions in a frame.
struct WordShift {
    Eigen::Vector3d mm = Eigen::Vector3d::Zero();
    RotaryWords rad{};
    std::array<double, 26> following_mm{};  ///< by letter; G92 alone, whatever the frame
};

/// Which feed F is.
enum class FeedMode : std::uint8_t { per_minute, inverse_time, per_turn };

/// The words that stay in force from block to block.
struct Modal {
    Meaning motion = Meaning::no_motion;
    Code motion_code;
    bool absolute = true, centre_absolute = false, exact_stop = false, tcp = true;
    std::optional<bool> following_absolute;  ///< by M82, M83; not said: as `absolute`
    FeedMode feed_mode = FeedMode::per_minute;
    std::optional<Meaning> retract;  ///< of cycles: to where they began, or to R; not said: to R
    int plane_normal = 2;            ///< of X, Y, Z
    double unit_mm = 1;
    double feed_per_s = 0;  ///< F/60 in mm or inch as it was given, with G95 F times the turns; 0 = none
    double feed_per_turn = 0;
    double feed_unit_mm = 1;
    std::optional<double> spindle_per_s;
    std::uint16_t offset = 0, tool = 0;
    std::optional<std::uint16_t> length_tool;  ///< of G43 H; else the tool in the spindle
    std::optional<double> prepared_tool;
    program::PathControl path_control{};
    std::string spindle_word;  ///< M3, M4; empty: it does not turn, or that is not known
};

/// Of a canned cycle, for blocks that repeat it. In mm along the normal, as written.
struct CycleWords {
    int tenths = 0;  ///< of its G word; 0: none
    double retract_mm = 0, depth_mm = 0, step_mm = 0, dwell_s = 0;
};

/// Where a canned cycle turns round, as coordinates along its axis.
struct CycleLevels {
    double start_mm = 0;                  ///< where the tool was before it
    double retract_mm = 0, depth_mm = 0;  ///< R and the bottom
    double across_mm = 0;                 ///< on the way to the first hole
    double clear_mm = 0;                  ///< to where it comes out
};

/// What M70 and M73 keep.
struct KeptState {
    std::size_t depth = 0;
    Modal modal;
    bool till_return = false;
};

/// Control points of a NURBS between G5.2 and G5.3.
struct OpenNurbs {
    std::vector<Eigen::Vector3d> points;
    std::vector<double> weights;
    int order = 3;
    int column = 0;
};

/// The G and M words of one block by group.
struct Request {
    std::array<Meaning, static_cast<std::size_t>(Group::count)> meaning{};
    std::array<Code, static_cast<std::size_t>(Group::count)> code;
    std::optional<bool> tcp;
    bool own_word = false;    ///< one that the machine file lets pass, with whatever parameters it has
    bool takes_axes = false;  ///< a word that has the axis words for itself

    Meaning of(Group group) const { return meaning[static_cast<std::size_t>(group)]; }
    const Code& code_of(Group group) const { return code[static_cast<std::size_t>(group)]; }
    bool asks(Group group, Meaning wanted) const { return of(group) == wanted; }
};

/// As people write it, `G59.1`.
inline std::string name_of(const Code& code) {
    return fmt::format("{}{:g}", code.letter, code.tenths / 10.0);
}

/// Carries out the blocks of a G-code program. rs274.cpp: words and modes; rs274_letters.cpp: which letters a block may
/// have; rs274_motion.cpp: where a block goes, how fast, and which poses are kept; rs274_arc.cpp: circles;
/// rs274_curve.cpp: G5 to G5.3; rs274_surface.cpp: G320 to G324; rs274_cycles.cpp: drilling; rs274_following.cpp: axes
/// that go along; rs274_shift.cpp: G10, G28, G52, G92; rs274_parameters.cpp: what the program may ask about its own
/// state.
class Rs274Reader final : public BlockReader, private ControlParameters {
  public:
    Rs274Reader(const ProgramText& text, std::string_view file_name, const ReadOptions& options, Control control)
        : BlockReader(file_name, options, Dialect::rs274),
          flow_(text, file_name, *this, findings_, options.most_repeated_lines),
          control_(std::move(control)),
          surface_words_(findings_) {
        program_.offsets.emplace_back("G54");  // in force when a program starts
        modal_.offset = 1;
        modal_.unit_mm = options.units == Units::inch ? inch_mm : 1;
        position_mm_.setConstant(unknown_word);
        rotary_rad_.fill(unknown_word);
    }

    Step read_block() override;
    bool finish() override;
    int line() const override { return block_.program_line; }
    const ProgramText& text() const override { return flow_.text(); }
    std::size_t position() const override { return flow_.position(); }
    bool waits() const override { return nurbs_.has_value(); }
    void leave_out_start() override { drop_undetermined(); }
    char rotary_letter(std::size_t axis) const override { return control_.rotary_letter(axis); }
    bool is_said(std::size_t axis) const override {
        return !std::isnan(rotary_rad_[axis]) || said_before_surface_[axis];
    }

  private:
    // words and modes
    bool block();
    bool sort_codes();
    bool own_code(const Code& code);
    bool sort_code(const Code& code);
    bool printing_word(const Code& code);
    void feed_mode();
    bool feed();
    bool set_feed(double word);
    bool spindle_and_tool();
    bool spindle_speed();
    bool prepare_tool();
    bool change_tool();
    bool put_in(double number);
    bool pins();
    bool state();
    void restore(const Modal& kept);
    void states_at_return();
    bool dwell();
    void units();
    bool modes();
    bool path_control();
    bool offset();
    bool tool_length();
    bool motion_word();
    bool subprogram();
    void stops();

    // letters
    bool check_letters();
    bool check_letter(char letter);
    bool check_following(char letter);
    void take_parameters_of_user_word();
    void user_word();
    std::string with_letters(const Code& code, std::uint32_t letters) const;
    bool uses(char letter) const;
    bool absent_axis(char letter);

    // motion
    Meaning motion_in_force() const;
    bool moves_on_arc() const;
    bool motion();
    bool move_along_path();
    bool move_to_target(bool on_arc);
    void enter(const Frame& frame);
    Frame frame_in_force() const;
    program::Move move_here() const;
    bool target();
    bool axis_word(char letter);
    bool arc_from(Eigen::Vector3d start_mm, program::Move& move);
    bool check_arc_words();
    Eigen::Vector3d centre_from(const Eigen::Vector3d& start_mm) const;
    bool turns_only(const program::Move& move) const;
    bool has_feed();
    bool feed_of(program::Move& move);
    bool add(program::Move& move);
    bool never_started();
    void drop_undetermined();

    // curves
    bool curve();
    bool check_curve();
    bool cubic_curve();
    bool quadratic_curve();
    bool nurbs_point();
    bool nurbs_end();
    bool follow(program::Curve curve);
    Eigen::Vector3d in_plane(char first, char second) const;

    // surfaces
    bool surface_datum();
    bool surface_word();
    bool machine_surface();
    bool can_machine_surface();
    bool shares_letters() const;
    bool stands_somewhere() const;
    bool is_whole(const program::Move& move) const;
    void stand_behind_surface();

    // cycles
    bool cycle();
    bool cycle_can_run();
    bool cycle_words(CycleWords& words);
    bool cycle_levels(const CycleWords& words, CycleLevels& levels);
    bool cycle_times(const CycleWords& words, const CycleLevels& levels, double& times);
    bool bore_in_a_row(const CycleWords& words, const CycleLevels& levels, const Eigen::Vector3d& first_mm,
                       double times);
    bool bore(const CycleWords& words, const CycleLevels& levels);
    bool peck(const CycleWords& words, double retract_mm, double depth_mm);
    bool tap(const CycleWords& words, double depth_mm, double clear_mm);
    bool cycle_move(double along_mm, program::MoveKind kind);
    bool cycle_move_across(const Eigen::Vector3d& place_mm);
    void cycle_dwell(double seconds);

    // following axes
    void following_distance();
    bool follow_words();
    bool stand_while_following();
    bool time_of_following(double way_mm, double& time_s);
    void start_following(char letter);
    void add_following_row();
    bool shift_following_to_here();
    void tell_following_shift(const std::array<double, 26>& before_mm);

    // shifts and offsets
    bool shift();
    bool shift_to_here(WordShift& base, const WordShift& other, std::string_view what);
    bool local_shift();
    bool set_data();
    bool go_home();
    void use_shift();

    ControlParameters::Answer read(const ParameterReference& parameter, ParameterValue& value) const override;
    Answer position_parameter(std::size_t axis, ParameterValue& value) const;
    Answer numbered_parameter(int number, ParameterValue& value) const;
    Answer named_parameter(std::string_view name, ParameterValue& value) const;

    void event(program::EventKind kind, bool stops, std::string word, double dwell_s = 0) {
        program_.events.push_back({kind, stops, dwell_s, std::move(word), program_.moves.size(), block_.program_line});
    }
    void code_event(program::EventKind kind, bool stops, Group group) {
        event(kind, stops, name_of(request_.code_of(group)));
    }
    bool refuse(std::string_view code, Spot spot, std::string text, std::string_view value = {},
                std::string_view hint = {}) {
        return findings_.refuse(code, spot, std::move(text), value, hint);
    }
    Spot spot_of(Group group) const { return block_.at(request_.code_of(group).column); }
    /// The first axis word, else the word that asks for the motion, else a letter of the arc.
    Spot spot_of_motion() const {
        if (axes_ == 0 && request_.of(Group::motion) != Meaning::unknown) return spot_of(Group::motion);
        const std::uint32_t letters = axes_ != 0 ? axes_ : block_.present;
        return block_.at(letters == 0 ? 1 : block_.column[static_cast<std::size_t>(std::countr_zero(letters))]);
    }

    Rs274Flow flow_;
    Control control_;
    Block block_;
    Request request_;
    Modal modal_;
    UnitStatement stated_;
    std::uint32_t axes_ = 0;  ///< axis letters of the block
    std::uint32_t axes_ever_ = 0;
    std::uint32_t follows_ = 0;          ///< following letters of the block
    std::uint32_t user_parameters_ = 0;  ///< letters that belong to a user's word of the block
    Frame frame_;
    Eigen::Vector3d position_mm_;  ///< in frame_, without word_shift_; unknown until said
    RotaryWords rotary_rad_;       ///< by the machine's rotary axes; unknown until said
    WordShift word_shift_;         ///< in frame_
    WordShift g92_, kept_g92_;
    std::array<double, 26> following_mm_{};             ///< by letter: where following axes are, running totals
    std::array<double, 26> following_way_mm_{};         ///< by letter: how far the block takes those that it says
    std::map<std::uint16_t, WordShift> offset_shifts_;  ///< of G10 L20, by the index of the offset
    std::vector<KeptState> kept_states_;
    CycleWords cycle_;
    std::optional<double> cycle_level_mm_;  ///< where the axis across the plane stood before a series of cycles
    std::optional<OpenNurbs> nurbs_;
    SurfaceWords surface_words_;
    std::array<bool, program::max_rotary_letters> said_before_surface_{};  ///< by the machine's rotary axes
    std::optional<Eigen::Vector3d> end_tangent_mm_;  ///< of a G5 just before: from its end to its second control point
    std::optional<Spot> left_out_home_;
    bool finished_ = false;
};

}  // namespace trunnion::nc
